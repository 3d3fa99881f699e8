//! The constants of the room: what each is a measure of, its unit, and why it has that value.

/// Share of the diagonal: an edge's curve with a name (line, circle, ellipse …) is exact when it is as near as this to both
/// surfaces. A tenth of the tolerance (1e-6) that other programs work with without trouble.
pub const NAMED: f64 = 1e-7;
/// Share of the diagonal: largest distance of a spline edge from its two surfaces; refined until it is met.
pub const TRACED: f64 = 2e-8;
/// Share of the diagonal: gaps above this make a model that other programs cannot work with, so that a face is demoted.
pub const GAP: f64 = 1e-5;
/// Share of the tolerance of noisy data: the same where that is more, because surfaces are no surer than this where the noise has a
/// tenth of its largest value on average.
pub const UNSETTLED: f64 = 0.25;
/// Share of the diagonal: the vertices of a tessellation lie this near to its surfaces where the file has their full digits
/// (a float has 6e-8 of its own size).
pub const FILE: f64 = 2e-6;
/// Share of the diagonal: points nearer than this are one point.
pub const SAME_POINT: f64 = 1e-9;
/// Cosine: two surfaces whose normals differ by less than 10° all along an edge touch there; from there on the intersection
/// is ill-conditioned at the accuracy of the normals of a mesh.
pub const TANGENT: f64 = 0.9848;
/// Radians: directions nearer than this are parallel in exact data (the axis of a fit through vertices of float precision).
pub const PARALLEL: f64 = 1e-5;
/// Of the largest eigenvalue of Σ n nᵀ: below it the surfaces leave a direction free. Normals that differ by 1°.
pub const FREE: f64 = 1e-4;
/// Number of Newton steps; convergence is quadratic but for contacts.
pub const STEPS: usize = 20;
/// Most points of a spline edge.
pub const MOST_POINTS: usize = 4000;
/// Rounds in which the points of a spline edge are doubled where it is too far from the surfaces.
pub const DOUBLINGS: usize = 9;
/// Samples of every edge where loops are unrolled, least number: a full turn needs several so that no step exceeds half a
/// period.
pub const LOOP_SAMPLES: usize = 16;
/// Share of a period: a seam keeps this distance from other loops, so that tessellations do not run into them.
pub const SEAM_CLEARANCE: f64 = 2e-3;
/// Radians: a face of a sphere that is seen from its middle under less than this has both poles outside.
pub const CAP: f64 = 1.35;
/// Rounds of the ladder; every round demotes one face at least, from a finite number of rungs, but rounds cost time. The last
/// ones demote everything that is still in the way at once.
pub const ROUNDS: usize = 24;
/// Share of the diagonal: facets that cut off more than this speak against their surface. Programs tessellate within half a radian a
/// facet, which is 1.1 % for a circle as wide as the part; four corners of two flat sides always lie on some circle.
pub const COARSEST: f64 = 0.02;
/// Radians: triangles of one plane facet differ by no more than this.
pub const COPLANAR: f64 = 1e-6;
/// Share of the diagonal: the same as a distance.
pub const COPLANAR_DISTANCE: f64 = 1e-9;
/// Edges may be this much of the diagonal away from the mesh's polyline even where that is straight: wrong branches are
/// farther away by the size of the part.
pub const BRANCH: f64 = 2e-3;
/// Of the tolerance of a mesh: the same, where that is more. The vertices of a noisy crease are off it by the noise through the sine of
/// half its angle.
pub const NOISE: f64 = 4.0;
/// Share of the diagonal: how far, besides what facets cut off, mesh and model may be apart. It also is four times the chord of
/// the polygons in which the validator looks for loops that cross, so that thin faces need it small.
pub const NEAR: f64 = 1e-3;
/// Gaps are sampled, here and in the validator, at different places: what is stated exceeds what was measured by this factor.
pub const STATED: f64 = 1.5;
/// Of the largest: the triangles of an extrusion contain its direction, within this angle in radians (float precision of
/// triangles as small as a thousandth of the part).
pub const ALONG: f64 = 1e-4;
/// Share of the diagonal: vertices that are this near to each other, seen along an extrusion, are one place of its profile.
pub const COLUMN: f64 = 1e-6;
/// Points that are this many tolerances from a vertex are that vertex: shorter edges break what is done with the model later.
pub const NEAR_VERTEX: f64 = 12.0;
/// Share of the diagonal: the tolerance of a segmentation of exact data; that of [`crate::segment`] where it sees no noise.
pub const EXACT: f64 = 3e-5;
/// Shares of the area on exact surfaces: with less the data is not exact, with more there is no doubt about it.
pub const SOME: f64 = 0.05;
/// See [`SOME`].
pub const NEARLY_ALL: f64 = 0.999;
/// Steps of a fit that starts from the result of another: it is near already.
pub const REFINE_STEPS: usize = 30;
