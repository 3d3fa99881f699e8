//! The figure of a frame field: short lines that follow the frames, features bold, dots where the number of quads is unusual.

use super::picture::{Image, Lines, Path, Picture, Rgb, render};
use crate::field::{Corner, Field};
use crate::mesh::{NONE, Triangles};
use glam::DVec3;
use rustc_hash::FxHashMap;
use std::f64::consts::FRAC_PI_2;

/// Crosses along the diagonal, about.
const PICTURE_CROSSES: f64 = 55.0;
/// Length of the arms of a cross over the distance to the next cross.
const ARM: f64 = 0.62;
/// Triangles that an arm crosses at most.
const ARM_STEPS: usize = 400;
/// Colour of the arms.
const ARMS: Rgb = [38, 92, 150];
/// Colour of vertices with fewer quads than usual.
pub(super) const FEWER: Rgb = [200, 40, 40];
/// Colour of vertices with more quads than usual.
pub(super) const MORE: Rgb = [30, 120, 220];

/// Draws a frame field.
pub fn field_figure(field: &Field) -> Image {
    let Some(arms) = arms(field, PICTURE_CROSSES) else { return render(&Picture::new(&[], field.mesh.faces())) };
    let mut picture = Picture::new(field.mesh.points(), field.mesh.faces());
    picture.lines.push(Lines::new(Path::Segments(&arms), ARMS, 1.0));
    picture.lines.push(Lines { width: 1.8, ..Lines::bold(Path::Edges(&field.features)) });
    let dots = |more: bool| {
        let chosen = |c: &&Corner| if more { c.quads > usual(c) } else { c.quads < usual(c) };
        let at = |c: &Corner| [field.mesh.points()[c.vertex as usize]; 2];
        field.corners.iter().filter(chosen).map(at).collect::<Vec<_>>()
    };
    let (fewer, more) = (dots(false), dots(true));
    picture.lines.push(Lines::new(Path::Segments(&fewer), FEWER, 9.0));
    picture.lines.push(Lines::new(Path::Segments(&more), MORE, 9.0));
    render(&picture)
}

/// Crosses that follow the frames, with their number along the diagonal, about; `None` if a face is not a triangle.
pub(super) fn arms(field: &Field, crosses: f64) -> Option<Vec<[DVec3; 2]>> {
    let t = Triangles::of(&field.mesh)?;
    let walker = Walker::new(field, t);
    let spacing = field.mesh.diagonal() / crosses;
    let mut arms = Vec::new();
    for seed in seeds(t, spacing) {
        (0..4).for_each(|branch| walker.walk(seed, branch, ARM * spacing, &mut arms));
    }
    Some(arms)
}

/// The quads that a fan has where the field does not turn.
pub(super) fn usual(corner: &Corner) -> i32 {
    if corner.closed { 4 } else { ((corner.angle / FRAC_PI_2).round() as i32).max(1) }
}

/// A triangle and a point in it.
type Seed = (u32, DVec3);

/// Points on the surface that are about a spacing apart: candidates on a lattice in every triangle, taken where none is near.
fn seeds(t: Triangles<'_>, spacing: f64) -> Vec<Seed> {
    let mut taken: FxHashMap<[i64; 3], Vec<DVec3>> = FxHashMap::default();
    let cell = |p: DVec3| (p / spacing).floor().to_array().map(|x| x as i64);
    let mut seeds = Vec::new();
    for i in 0..t.len() as u32 {
        let [a, b, c] = t.triangle(i).map(|v| t.points()[v as usize]);
        let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
        // At most as many as the picture could show.
        let n = (2.0 * longest / spacing).ceil().clamp(1.0, 4.0 * PICTURE_CROSSES) as u32;
        for (j, k) in (0..n).flat_map(|j| (0..n - j).map(move |k| (j, k))) {
            let [s, r] = [j, k].map(|x| (f64::from(x) + 1.0 / 3.0) / f64::from(n));
            let p = a + (b - a) * s + (c - a) * r;
            let [x, y, z] = cell(p);
            let around = |d: i64| [x + d % 3 - 1, y + d / 3 % 3 - 1, z + d / 9 - 1];
            let is_near = |q: &DVec3| q.distance_squared(p) < spacing * spacing;
            if (0..27).all(|d| taken.get(&around(d)).is_none_or(|near| !near.iter().any(is_near))) {
                taken.entry([x, y, z]).or_default().push(p);
                seeds.push((i, p));
            }
        }
    }
    seeds
}

/// Follows a branch from triangle to triangle.
struct Walker<'a> {
    field: &'a Field,
    triangles: Triangles<'a>,
    /// p from the first to the second triangle.
    turn: FxHashMap<(u32, u32), i32>,
}

impl<'a> Walker<'a> {
    fn new(field: &'a Field, triangles: Triangles<'a>) -> Self {
        let both = |m: &crate::field::Matching| {
            let [i, j] = m.triangles;
            [((i, j), m.p), ((j, i), -m.p)]
        };
        Walker { field, triangles, turn: field.matchings.iter().flat_map(both).collect() }
    }

    fn direction(&self, triangle: u32, branch: i32) -> DVec3 {
        let of = if branch % 2 == 0 { &self.field.u } else { &self.field.v };
        if branch < 2 { of[triangle as usize] } else { -of[triangle as usize] }
    }

    /// Adds the segments of an arm; it ends at features.
    fn walk(&self, (mut triangle, mut p): Seed, mut branch: i32, mut length: f64, into: &mut Vec<[DVec3; 2]>) {
        let t = self.triangles;
        let mut entry = NONE;
        for _ in 0..ARM_STEPS {
            let d = self.direction(triangle, branch);
            let Some((far, exit)) = exit(t, triangle, entry, p, d) else { return };
            let step = far.min(length);
            let q = p + d * step;
            into.push([p, q]);
            length -= step;
            let across = t.opposite(exit);
            if length <= 0.0 || across == NONE {
                return;
            }
            let Some(turn) = self.turn.get(&(triangle, across / 3)) else { return };
            branch = (branch + turn).rem_euclid(4);
            (triangle, entry, p) = (across / 3, across, q);
        }
    }
}

/// Where a ray leaves a triangle: how far, and the half-edge there.
fn exit(t: Triangles<'_>, triangle: u32, entry: u32, p: DVec3, d: DVec3) -> Option<(f64, u32)> {
    let [a, b, c] = t.triangle(triangle).map(|v| t.points()[v as usize]);
    let normal = (b - a).cross(c - a);
    let distance = |corner: u32| {
        let (from, to) = (t.point(corner), t.point(t.next(corner)));
        let outward = (to - from).cross(normal);
        let speed = d.dot(outward);
        (speed > 0.0).then(|| (((from - p).dot(outward) / speed).max(0.0), corner))
    };
    let sides = (3 * triangle..3 * triangle + 3).filter(|&corner| corner != entry);
    sides.filter_map(distance).min_by(|x, y| x.0.total_cmp(&y.0))
}
