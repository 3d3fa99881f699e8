//! Regions that a curve sweeps along a straight line or around an axis: extrusions and surfaces of revolution.
//!
//! All triangles of an extruded region contain its direction. The normals of a surface of revolution meet its axis: they belong to
//! a linear complex (Pottmann and Randrup, *Rotational and helical surface approximation for reverse engineering*, Computing 60,
//! 1998). Borders and neighbours know the axis better: a border around it is a circle.
//!
//! ```text
//!           axis                 the profile is in the half plane of the frame's x and z;
//!      z ↑   │   ╲  n            a normal n at p meets the axis c through x:
//!            │────●                  n · (x × c) + (p × n) · c = 0
//!            │   ╱ p
//! ```
//!
//! Parts of the profile that are straight, or arcs of circles, sweep surfaces with a name: a flat side that runs into a fillet is a
//! plane and a cylinder.

use super::axes::{axes, direction, directions};
use super::clean::normals;
use super::profile::Profile;
use super::regions::{Map, Piece, Rung, vertex_ids, vertices};
use super::runs::{Run, Shape, joint, runs};
use super::topology::Graph;
use super::trace::{continued, interpolate};
use super::tuning::{COLUMN_DISTANCE, REFINE_STEPS, SOME_AREA};
use super::unions::{UNION_CRUMB, unions};
use crate::brep::{Curve, Frame, Surface};
use crate::error::Result;
use crate::geometry::primitive::{self, Kind, Primitive};
use crate::mesh::{NONE, Triangles};
use glam::{DVec2, DVec3};

/// A count: fewest places of an extruded profile, because fewer are a plane or a wedge.
const LEAST_EXTRUDED: usize = 4;
/// A count: fewest places of a revolved profile, because two are a cone.
const LEAST_REVOLVED: usize = 3;
/// A factor: places nearer to each other than this many times the precision of the vertices are one, because a curve
/// through both would turn with the rounding.
const PLACE_DISTANCE: f64 = 20.0;
/// A share of the diagonal: places of a profile that every vertex has its own place on are so far apart at first,
/// because few of them say what a smooth profile is.
const FIRST_DISTANCE: f64 = 0.04;
/// A count: fewer triangles than this lie on a swept surface by chance, but for the precision of exact data.
const FEW_SWEPT: usize = 24;
/// A share of the diagonal: vertices of exact data that are nearer to each other, seen along a sweep of few triangles, are one place of
/// its profile, because those on edges are where the part's own tolerance has them.
const SAME_COLUMN: f64 = 1e-8;
/// A count: how often that is halved until they are in a row, because a profile that bends more needs nearer ones.
const DISTANCE_HALVINGS: i32 = 5;
/// A count: vertices beyond the number of its parameters that speak for a surface, because it fits as many as it has
/// parameters exactly.
pub const SPARE_VERTICES: usize = 3;

/// Gives swept surfaces to the pieces without a surface that lie on some, alone or together with neighbours whose surfaces do not fit
/// well, and surfaces with a name to those parts of them that have one.
pub fn sweep(map: &mut Map<'_>) -> Result<()> {
    let is_wanted = |p: &Piece| p.rung == Rung::Spline || p.primitive.is_some_and(|q| q.kind() != Kind::Plane);
    if !map.pieces.iter().any(is_wanted) {
        return Ok(());
    }
    map.part_at_edges();
    let graph = Graph::of(map.t, &map.label, map.pieces.len(), &[])?;
    let exact = map.is_exact();
    for union in unions(map, &graph) {
        let whole = swept(map, &union, &graph);
        if !whole.is_empty() {
            replace(map, &union, whole);
            continue;
        }
        let mut rest = union.clone();
        for &p in union.iter().filter(|_| union.len() > 1) {
            let piece = &map.pieces[p as usize];
            // A triangle or two lie on a plane always.
            let is_crumb = exact && piece.triangles.len() <= UNION_CRUMB;
            let alone = if piece.rung == Rung::Spline && !is_crumb { swept(map, &[p], &graph) } else { Vec::new() };
            if !alone.is_empty() {
                replace(map, &[p], alone);
                rest.retain(|&q| q != p);
            }
        }
        // Crumbs belong to the free piece around them, and so does what is a torus nearly, where others are one exactly.
        let flat = |p: &u32| map.pieces[*p as usize].primitive.is_none_or(|q| q.kind() == Kind::Plane);
        if rest.len() > 1 && (exact || rest.iter().all(flat)) {
            let mut triangles: Vec<u32> =
                rest.iter().flat_map(|&p| map.pieces[p as usize].triangles.iter().copied()).collect();
            triangles.sort_unstable();
            map.replace(&rest, vec![(triangles, None)]);
        }
    }
    map.compact();
    Ok(())
}

fn replace(map: &mut Map<'_>, pieces: &[u32], parts: Vec<Part>) {
    let parts = parts.into_iter().map(|(own, surface, primitive)| (own, Some((surface, primitive))));
    map.replace(pieces, parts.collect());
}

/// What is swept, and how.
#[derive(Clone, Copy)]
enum Sweep {
    Along(DVec3),
    Around(Frame),
}

/// A part of a swept piece: triangles and the surface.
type Part = (Vec<u32>, Surface, Option<Primitive>);

/// The parts of a set of pieces that one profile sweeps; none where none does.
fn swept(map: &Map<'_>, pieces: &[u32], graph: &Graph) -> Vec<Part> {
    let mut triangles: Vec<u32> =
        pieces.iter().flat_map(|&p| map.pieces[p as usize].triangles.iter().copied()).collect();
    triangles.sort_unstable();
    let column = COLUMN_DISTANCE * map.diagonal;
    let near =
        if triangles.len() < FEW_SWEPT { map.precision.clamp(SAME_COLUMN * map.diagonal, column) } else { column };
    // Noise hides what a surface is from those who found it, but not that all vertices lie within the noise of one.
    let noise = (map.is_noisy() && map.exact_share() <= SOME_AREA).then_some(0.5 * map.tolerance);
    if let Some(primitive) = [Some(near), noise].into_iter().flatten().find_map(|n| simple(map.t, &triangles, n)) {
        return vec![(triangles, Surface::of_primitive(&primitive), Some(primitive))];
    }
    let vertices_of = |own: &[u32]| vertex_ids(map.t, own).len();
    // Where nothing else speaks for a sweep, there are two vertices and more at every place of the profile.
    let many = vertices_of(&triangles) / 2;
    let along = direction(map.t, &triangles).map(|d| (Sweep::Along(d), usize::MAX));
    let beside = directions(map, pieces, graph).into_iter().map(|d| (Sweep::Along(d), many));
    let around = axes(map, pieces, &triangles, graph).into_iter();
    let around = around.map(|(o, z)| (Sweep::Around(Frame::along(o, z)), many));
    let fits = |parts: &Vec<Part>| {
        let far = |(own, surface, primitive): &Part| {
            let off = |q: &DVec3| primitive.map_or_else(|| surface.distance(*q), |p| p.distance(*q).abs());
            // A free profile goes through whatever has few vertices, or is the same on both sides of a part.
            let chance =
                primitive.is_none() && map.is_coarse(&Piece::on(map.t, own.clone(), surface.clone(), None, NONE));
            !chance && vertices(map.t, own).iter().all(|q| off(q) <= 2.0 * near)
        };
        parts.iter().all(far)
    };
    let found = along.into_iter().chain(beside).chain(around).find_map(|(sweep, most)| {
        let columns = |most: usize| {
            let profile = sweep.profile(map.t, &triangles, near, PLACE_DISTANCE * near, most)?;
            sweep.parts(map.t, &triangles, profile, near).filter(fits)
        };
        // Every vertex at a place of its own: as few of them as say what the profile is, more where it bends more.
        let few = |k: i32| {
            let apart = map.diagonal * FIRST_DISTANCE * 0.5f64.powi(k);
            let mut profile = sweep.profile(map.t, &triangles, near, apart, many)?;
            let flat = sweep.flat(map.t.point(3 * triangles[0]), near);
            profile.reach_out(map.t, &flat);
            let all: Vec<DVec3> = vertices(map.t, &triangles).into_iter().map(&flat).collect();
            let is_near = profile.refine(&all, near, PLACE_DISTANCE * near);
            is_near.then(|| sweep.whole(&triangles, &profile)).flatten().filter(fits)
        };
        columns(many).or_else(|| (0..DISTANCE_HALVINGS).find_map(few)).or_else(|| columns(most))
    });
    found.unwrap_or_default()
}

impl Sweep {
    /// Moves points into the plane of the profile, which for an extrusion is that through a point.
    fn flat(self, origin: DVec3, near: f64) -> impl Fn(DVec3) -> DVec3 {
        move |q: DVec3| match self {
            Sweep::Along(direction) => q - direction * (q - origin).dot(direction),
            Sweep::Around(frame) => {
                let at = frame.profile(q);
                // On the axis, to the bit.
                let x = if at.x < near { 0.0 } else { at.x };
                frame.origin + frame.x * x + frame.z * at.y
            }
        }
    }

    fn profile(self, t: Triangles<'_>, triangles: &[u32], near: f64, apart: f64, most: usize) -> Option<Profile> {
        let flat = self.flat(t.point(3 * triangles[0]), near);
        match self {
            Sweep::Along(d) => {
                Profile::of(t, triangles, flat, d.any_orthonormal_vector(), apart, [LEAST_EXTRUDED, most])
            }
            Sweep::Around(f) => Profile::of(t, triangles, flat, f.z + 0.5 * f.x, apart, [LEAST_REVOLVED, most]),
        }
    }

    /// All triangles on one surface.
    fn whole(self, triangles: &[u32], profile: &Profile) -> Option<Vec<Part>> {
        let mut points = profile.points.clone();
        points.extend(profile.closed.then(|| points[0]));
        Some(vec![(triangles.to_vec(), self.free(&points, profile.jointed)?, None)])
    }

    /// The plane of the profile, whose z axis is across it, and whose y axis is that of a revolution.
    fn plane(self, at: DVec3) -> Frame {
        match self {
            Sweep::Along(direction) => Frame::along(at, direction),
            Sweep::Around(frame) => Frame::new(frame.origin, -frame.y(), frame.x),
        }
    }

    /// A surface for every run of a profile, with its triangles; one for all where some triangles are in two.
    fn parts(self, t: Triangles<'_>, triangles: &[u32], mut profile: Profile, near: f64) -> Option<Vec<Part>> {
        let plane = self.plane(profile.points[0]);
        let flat = |p: &DVec3| {
            let l = plane.local(*p);
            DVec2::new(l.x, l.y)
        };
        let first = profile.closed.then(|| joint(&profile.points.iter().map(flat).collect::<Vec<DVec2>>(), near));
        if first == Some(None) {
            let round = circle_through(profile.points.iter().map(flat)).filter(|c| c.2 <= near);
            let Some((center, radius, _)) = round else { return self.whole(triangles, &profile) };
            let run = Run { ends: [0, 0], shape: Shape::Arc { center, radius } };
            let primitive = self.primitive(&run, &profile.points, &plane, near)?;
            return Some(vec![(triangles.to_vec(), Surface::of_primitive(&primitive), Some(primitive))]);
        }
        profile.begin_at(first.flatten().unwrap_or(0));
        let mut points = profile.points.clone();
        points.extend(profile.closed.then(|| points[0]));
        let runs = runs(&points.iter().map(flat).collect::<Vec<DVec2>>(), near);
        let (lids, sides): (Vec<u32>, Vec<u32>) = triangles.iter().partition(|&&k| self.is_lid(t, k, &profile));
        let triangles = &sides;
        let Some(of) = assigned(t, triangles, &profile, &runs) else {
            let lids = self.lids(t, &lids, &profile);
            return self.whole(triangles, &profile).map(|sides| sides.into_iter().chain(lids).collect());
        };
        let part = |(k, run): (usize, &Run)| {
            let own: Vec<u32> = triangles.iter().zip(&of).filter(|o| *o.1 == k).map(|o| *o.0).collect();
            let primitive = self.primitive(run, &points, &plane, near);
            let surface = match &primitive {
                Some(p) => Surface::of_primitive(p),
                None => self.free(&points[run.ends[0]..=run.ends[1]], false)?,
            };
            Some((own, surface, primitive))
        };
        let mut parts: Vec<Part> = runs.iter().enumerate().map(part).collect::<Option<_>>()?;
        parts.extend(self.lids(t, &lids, &profile));
        Some(parts.into_iter().filter(|p| !p.0.is_empty()).collect())
    }

    /// Whether all corners of a triangle are at one place of the profile of a revolution: it is a part of the disc inside of it.
    fn is_lid(self, t: Triangles<'_>, k: u32, profile: &Profile) -> bool {
        let at = t.triangle(k).map(|v| profile.place(v));
        matches!(self, Sweep::Around(_)) && at[0] == at[1] && at[1] == at[2]
    }

    fn lids(self, t: Triangles<'_>, triangles: &[u32], profile: &Profile) -> Vec<Part> {
        let Sweep::Around(frame) = self else { return Vec::new() };
        let place = |k: u32| profile.place(t.triangle(k)[0]);
        let mut order: Vec<(usize, u32)> = triangles.iter().map(|&k| (place(k), k)).collect();
        order.sort_unstable();
        let lid = |of: &[(usize, u32)]| {
            let origin = frame.origin + frame.z * frame.profile(profile.points[of[0].0]).y;
            let plane = Primitive::Plane { origin, normal: frame.z };
            (of.iter().map(|o| o.1).collect(), Surface::of_primitive(&plane), Some(plane))
        };
        order.chunk_by(|a, b| a.0 == b.0).map(lid).collect()
    }

    /// The surface that a spline through points sweeps: beyond the ends as well, because borders bulge between their vertices.
    fn free(self, points: &[DVec3], jointed: bool) -> Option<Surface> {
        let is_off_axis = |p: DVec3| match self {
            Sweep::Along(_) => true,
            Sweep::Around(frame) => frame.local(p).x > 0.0,
        };
        let spline = if points[0] == points[points.len() - 1] {
            interpolate(points, !jointed)?.0
        } else {
            continued(points, is_off_axis)?
        };
        let profile = Curve::Spline(spline);
        Some(match self {
            Sweep::Along(direction) => Surface::Extrusion { profile, direction },
            Sweep::Around(frame) => Surface::Revolution { profile, frame },
        })
    }

    /// The surface that a line or an arc sweeps.
    fn primitive(self, run: &Run, points: &[DVec3], plane: &Frame, near: f64) -> Option<Primitive> {
        let [a, b] = run.ends.map(|k| points[k]);
        match (self, run.shape) {
            (_, Shape::Free) => None,
            (Sweep::Along(axis), Shape::Line) => {
                Some(Primitive::Plane { origin: a, normal: axis.cross(b - a).normalize_or_zero() })
            }
            (Sweep::Along(axis), Shape::Arc { center, radius }) => {
                Some(Primitive::Cylinder { origin: plane.global(center.extend(0.0)), axis, radius })
            }
            (Sweep::Around(frame), Shape::Line) => {
                let [p, q] = [a, b].map(|x| frame.profile(x));
                if (p.y - q.y).abs() <= near {
                    return Some(Primitive::Plane { origin: frame.origin + frame.z * p.y, normal: frame.z });
                }
                if (p.x - q.x).abs() <= near {
                    let (origin, axis) = (frame.origin, frame.z);
                    return Some(Primitive::Cylinder { origin, axis, radius: 0.5 * (p.x + q.x) });
                }
                let slope = (q.x - p.x) / (q.y - p.y);
                let apex = frame.origin + frame.z * (p.y - p.x / slope);
                Some(Primitive::Cone { apex, axis: frame.z * slope.signum(), half_angle: slope.abs().atan() })
            }
            (Sweep::Around(frame), Shape::Arc { center, radius }) => {
                let middle = frame.origin + frame.z * center.y;
                if center.x.abs() <= near {
                    return Some(Primitive::Sphere { center: middle, radius });
                }
                // The inner leaf of a tube that crosses the axis has no name.
                let torus =
                    Primitive::Torus { center: middle, axis: frame.z, major_radius: center.x, minor_radius: radius };
                (center.x > 0.0).then_some(torus)
            }
        }
    }
}

/// The run of every triangle; `None` where one is in two.
fn assigned(t: Triangles<'_>, triangles: &[u32], profile: &Profile, runs: &[Run]) -> Option<Vec<usize>> {
    let n = profile.points.len();
    let of = |&k: &u32| {
        let mut at = t.triangle(k).map(|v| profile.place(v));
        at.sort_unstable();
        // The first place is also that after the last one.
        if profile.closed && at[0] == 0 && at[2] > n / 2 {
            at.iter_mut().filter(|a| **a == 0).for_each(|a| *a = n);
            at.sort_unstable();
        }
        runs.iter().position(|run| run.ends[0] <= at[0] && at[2] <= run.ends[1])
    };
    triangles.iter().map(of).collect()
}

/// Centre, radius, and the largest distance of a point.
fn circle_through(points: impl Iterator<Item = DVec2> + Clone) -> Option<(DVec2, f64, f64)> {
    let (center, radius) = primitive::circle(points.clone())?;
    Some((center, radius, points.map(|p| (p.distance(center) - radius).abs()).fold(0.0, f64::max)))
}

/// The surface with a name that all vertices lie on.
fn simple(t: Triangles<'_>, triangles: &[u32], near: f64) -> Option<Primitive> {
    let (points, normals) = (vertices(t, triangles), normals(t, triangles));
    let mut scratch = primitive::Scratch::default();
    [Kind::Plane, Kind::Cylinder, Kind::Sphere, Kind::Cone, Kind::Torus].into_iter().find_map(|kind| {
        let enough = kind == Kind::Plane || points.len() >= kind.parameters() + SPARE_VERTICES;
        if !enough {
            return None;
        }
        let found = primitive::fit_within(kind, &points, &normals, 2.0 * near, &mut scratch)?;
        let better = primitive::refine(found.primitive, &points, None, REFINE_STEPS).filter(|f| f.max <= found.max);
        Some(better.unwrap_or(found).primitive)
    })
}
