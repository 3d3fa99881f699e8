//! The constants of the room: what each is a measure of, its unit, and why it has that value.

/// A share of the diagonal: an edge's curve with a name (line, circle, ellipse …) is exact when it is as near as this
/// to both surfaces, because a tenth of the tolerance (1e-6) of other programs makes them no trouble.
pub const NAMED_DISTANCE: f64 = 1e-7;
/// A share of the diagonal: largest distance of a spline edge from its two surfaces, refined until it is met, because
/// it has to be well below [`NAMED_DISTANCE`].
pub const TRACED_DISTANCE: f64 = 2e-8;
/// A share of the diagonal: gaps above this demote a face, because other programs cannot work with such a model.
pub const MOST_GAP: f64 = 1e-5;
/// A share of the tolerance of noisy data: the same where that is more, because surfaces are no surer than this where
/// the noise has a tenth of its largest value on average.
pub const NOISY_GAP: f64 = 0.25;
/// A share of the diagonal: the vertices of a tessellation lie this near to its surfaces where the file has their full
/// digits, because a float has 6e-8 of its own size.
pub const FILE_PRECISION: f64 = 2e-6;
/// A share of the diagonal: points nearer than this are one point, because they differ by the rounding of a few steps
/// only.
pub const SAME_POINT: f64 = 1e-9;
/// Cosine of 10°: two surfaces whose normals differ by less all along an edge touch there, because from there on the
/// intersection is ill-conditioned at the accuracy of the normals of a mesh.
pub const TANGENT_COSINE: f64 = 0.9848;
/// Radians: directions nearer than this are parallel in exact data, because the axis of a fit through vertices of float
/// precision is no surer.
pub const PARALLEL_ANGLE: f64 = 1e-5;
/// A share of the largest eigenvalue of Σ n nᵀ: below it the surfaces leave a direction free, because their normals
/// differ by 1° only.
pub const FREE_EIGENVALUE: f64 = 1e-4;
/// A count: Newton steps, because convergence is quadratic but for contacts.
pub const NEWTON_STEPS: usize = 20;
/// A count: most points of a spline edge, because files and times grow with them.
pub const SPLINE_POINTS: usize = 4000;
/// A count: rounds in which the points of a spline edge are doubled where it is too far from the surfaces, because a
/// smooth edge comes nearer by sixteen in each.
pub const DOUBLINGS: usize = 9;
/// A count: fewest samples of every edge where loops are unrolled, because no step of a full turn may exceed half a
/// period.
pub const LOOP_SAMPLES: usize = 16;
/// A share of a period: a seam keeps this distance from other loops, because tessellations would run into them.
pub const SEAM_CLEARANCE: f64 = 2e-3;
/// Radians: a face of a sphere that is seen from its middle under less than this has both poles outside, because it
/// ends before the equator.
pub const CAP_ANGLE: f64 = 1.35;
/// A count: rounds of the ladder, because rounds cost time. Every one demotes one face at least, from a finite number
/// of rungs; the last ones demote everything that is still in the way at once.
pub const LADDER_ROUNDS: usize = 24;
/// A share of the diagonal: facets that cut off more than this speak against their surface, because programs tessellate
/// within half a radian a facet, which is 1.1 % for a circle as wide as the part; four corners of two flat sides always
/// lie on some circle.
pub const COARSEST_SAGITTA: f64 = 0.02;
/// Radians: triangles of one plane facet differ by no more than this, because they differ by rounding only.
pub const COPLANAR_ANGLE: f64 = 1e-6;
/// A share of the diagonal: the same as a distance, because normals of small triangles say less than distances.
pub const COPLANAR_DISTANCE: f64 = 1e-9;
/// A share of the diagonal: edges may be this far from the mesh's polyline even where that is straight, because wrong
/// branches are farther away by the size of the part.
pub const BRANCH_DISTANCE: f64 = 2e-3;
/// Multiple of the tolerance of a mesh: the same, where that is more, because the vertices of a noisy crease are off it
/// by the noise through the sine of half its angle.
pub const NOISY_BRANCH: f64 = 4.0;
/// A share of the diagonal: how far, besides what facets cut off, mesh and model may be apart. It is small because it
/// also is four times the chord of the polygons in which the validator looks for loops that cross, and faces may be
/// thin.
pub const MODEL_DISTANCE: f64 = 1e-3;
/// Multiple of the tolerance of noisy data: the same, because triangles that noise has put into the wrong piece are twice
/// as far from it as the others may be.
pub const NOISY_DISTANCE: f64 = 2.0;
/// A factor: a gap that is stated exceeds what was measured by this, because it is sampled here and in the validator at
/// different places.
pub const STATED_FACTOR: f64 = 1.5;
/// Radians: the triangles of an extrusion contain its direction within this angle, because those as small as a
/// thousandth of the part have no more in float precision.
pub const ALONG_ANGLE: f64 = 1e-4;
/// A share of the diagonal: vertices that are this near to each other, seen along an extrusion, are one place of its
/// profile, because floats put them off by less.
pub const COLUMN_DISTANCE: f64 = 1e-6;
/// Multiple of a tolerance: points that are this near to a vertex are that vertex, because shorter edges break what is
/// done with the model later.
pub const NEAR_VERTEX: f64 = 12.0;
/// A share of the diagonal: the tolerance of a segmentation of exact data, because [`crate::segment`] takes it where it
/// sees no noise.
pub const EXACT_TOLERANCE: f64 = 3e-5;
/// A share of the area on exact surfaces: with less the data is not exact, because that little may be chance.
pub const SOME_AREA: f64 = 0.05;
/// A share of the area on exact surfaces: with more there is no doubt that the data is exact, because the rest is
/// crumbs.
pub const NEARLY_ALL_AREA: f64 = 0.999;
/// A count: steps of a fit that starts from the result of another, few because it is near already.
pub const REFINE_STEPS: usize = 30;
