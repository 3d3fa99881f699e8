//! Quads whose vertices are on a surface that bends lie on one side of it. Where they would be too far off, their vertices
//! leave it to the other side, by as little as brings both within what is allowed:
//!
//! ```text
//!      ╭──╮  surface        v────v
//!    ╭╯    ╰╮       →      ╱╭╯  ╰╮╲
//!   v────────v           v╯      ╰v
//! ```

use super::around::{Around, Ring};
use super::gaps::{Gaps, largest};
use super::nearer::nudge;
use super::smooth::{GOOD_SHAPE, WAY_SHARES};
use super::source::Source;
use super::work::{Place, Work};
use crate::context::Context;
use crate::error::Result;
use glam::DVec3;

/// A share of the diagonal: how far quads may be from the surface, less than what counts against them because some stay
/// a little farther off.
const ALLOWED_GAP: f64 = 0.0017;
/// A multiple of what a quad is off by: a vertex moves no farther where others of the quad cannot move, because it
/// would spoil the quads on its other side.
const MOST_LIFT: f64 = 2.0;
/// A count: rounds at most, because vertices that move change what their neighbours have to move by.
const LIFT_ROUNDS: usize = 8;
/// A share of what was too much: a round that leaves more is the last, because the next ones would do less still.
const EXCESS_LEFT: f64 = 0.97;
/// A share of what is allowed: no round is needed where all quads together are too far off by less, because it would
/// not be seen.
const LITTLE_EXCESS: f64 = 0.01;

/// Moves the vertices inside regions off the surface where their quads are too far from it. Returns how far they are then.
pub fn lift(work: &mut Work, source: &Source, context: &Context) -> Result<f64> {
    let _stage = context.stage("lift");
    let around = &Around::new(work);
    let far = ALLOWED_GAP * source.diagonal;
    let mut gaps = Gaps::new(work, source, far);
    let beyond = |gaps: &[DVec3]| gaps.iter().map(|gap| (gap.length() - far).max(0.0)).sum::<f64>();
    let mut has_moved = vec![true; work.points.len()];
    let mut now = gaps.of(work, &has_moved);
    for _ in 0..LIFT_ROUNDS {
        let before = beyond(&now);
        if before <= LITTLE_EXCESS * far {
            break;
        }
        context.check()?;
        let points = work.points.clone();
        for v in 0..work.points.len() {
            has_moved[v] = false;
            if let Place::Region(region) = work.place[v]
                && let Some(step) = step(work, around, &now, v, far)
            {
                let from = work.points[v];
                let ring = Ring::new(work, around, v as u32);
                let least = ring.now.min(GOOD_SHAPE);
                let may_be = |&to: &DVec3| {
                    source.on_region(region, to).is_some_and(|found| found.0.distance(to) <= far)
                        && ring.holds(to, least)
                };
                if let Some(to) = WAY_SHARES.map(|share| from + share * step).into_iter().find(may_be) {
                    work.points[v] = to;
                    has_moved[v] = true;
                }
            }
        }
        let moved = gaps.of(work, &has_moved);
        let after = beyond(&moved);
        if after >= before {
            work.points = points;
            // What the gaps know is of the places taken back.
            now = gaps.of(work, &has_moved);
            break;
        }
        now = moved;
        if after > EXCESS_LEFT * before {
            break;
        }
    }
    let now = nudge(work, around, &mut gaps, now, context)?;
    Ok(largest(&now))
}

/// The vertices of quads that are too far from the surface.
pub fn far_vertices(work: &Work, source: &Source) -> Vec<bool> {
    let mut is_far = vec![false; work.points.len()];
    for q in quads_beyond(work, source, ALLOWED_GAP * source.diagonal) {
        work.faces.face(q).iter().for_each(|&v| is_far[v as usize] = true);
    }
    is_far
}

/// The quads that are farther from the surface than so much, or that it is.
pub fn quads_beyond(work: &Work, source: &Source, far: f64) -> Vec<usize> {
    let gaps = Gaps::new(work, source, far).of(work, &vec![true; work.points.len()]);
    (0..gaps.len()).filter(|&q| gaps[q].length() > far).collect()
}

/// What a vertex has to move by: the most that one of its quads asks for.
fn step(work: &Work, around: &Around, gaps: &[DVec3], v: usize, far: f64) -> Option<DVec3> {
    let gap = around.quads[v]
        .iter()
        .map(|&q| (gaps[q as usize], q))
        .reduce(|a, b| if b.0.length_squared() > a.0.length_squared() { b } else { a });
    let (gap, q) = gap.filter(|gap| gap.0.length() > far)?;
    let is_free = |v: &&u32| matches!(work.place[**v as usize], Place::Region(_));
    let free = work.faces.face(q as usize).iter().filter(is_free).count();
    Some(gap * (1.0 - far / gap.length()) * (4.0 / free as f64).min(MOST_LIFT))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::features::FeatureOptions;
    use crate::geometry::quality::scaled_jacobian;
    use crate::mesh::{Polygons, SurfaceMesh, test_models::cube};
    use rustc_hash::FxHashMap;

    /// The unit sphere as a cube blown up: `n` by `n` quads to a side.
    fn sphere(n: usize) -> SurfaceMesh {
        let cube = cube(DVec3::splat(-1.0), 2.0);
        let (mut points, mut faces, mut known) = (Vec::new(), Polygons::new(), FxHashMap::default());
        for face in cube.faces().iter() {
            let [a, b, c, d] = [0, 1, 2, 3].map(|k| cube.points()[face[k] as usize]);
            let mut at = |i: usize, j: usize| {
                let share = |k: usize| (std::f64::consts::FRAC_PI_2 * (k as f64 / n as f64 - 0.5)).tan() / 2.0 + 0.5;
                let p = a.lerp(b, share(i)).lerp(d.lerp(c, share(i)), share(j)).normalize();
                *known.entry(p.to_array().map(|x| (x * 1e6).round() as i64)).or_insert_with(|| {
                    points.push(p);
                    points.len() as u32 - 1
                })
            };
            for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
                faces.push(&[at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
            }
        }
        SurfaceMesh::new(points, faces).unwrap()
    }

    fn on_sphere(n: usize) -> Work {
        let mesh = sphere(n);
        let (place, region) = (vec![Place::Region(0); mesh.vertex_count()], vec![0; mesh.face_count()]);
        Work { points: mesh.points().to_vec(), place, faces: mesh.faces().clone(), region, features: Vec::new() }
    }

    /// The least and the largest distance of the middles of shorter diagonals from the centre.
    fn middles(work: &Work) -> (f64, f64) {
        let middle = |f: &[u32]| {
            let [a, b, c, d] = [0, 1, 2, 3].map(|k| work.points[f[k] as usize]);
            if a.distance(c) < b.distance(d) { a.midpoint(c).length() } else { b.midpoint(d).length() }
        };
        let all = work.faces.iter().map(middle);
        all.fold((f64::INFINITY, 0.0), |(a, b), m| (a.min(m), b.max(m)))
    }

    #[test]
    fn vertices_leave_a_sphere_until_its_quads_are_near_enough() {
        let context = Context::new();
        let options = FeatureOptions { angle_deg: None, ..FeatureOptions::default() };
        let source = Source::new(&sphere(40), &options, &context).unwrap();
        let far = ALLOWED_GAP * source.diagonal;
        let mut work = on_sphere(8);
        assert!(1.0 - middles(&work).0 > 1.5 * far);
        let before = work.clone();
        let left = lift(&mut work, &source, &context).unwrap();
        assert!(left <= (1.0 + LITTLE_EXCESS) * far, "{left} of {far}");
        let (low, high) = middles(&work);
        assert!(1.0 - low <= 1.1 * far && high - 1.0 <= 1.1 * far, "{low} {high} {far}");
        // Outwards, no farther than that, and square as before.
        let least = |work: &Work| {
            let of = |f: &[u32]| scaled_jacobian([0, 1, 2, 3].map(|k| work.points[f[k] as usize]));
            work.faces.iter().map(of).fold(1.0, f64::min)
        };
        assert!(work.points.iter().all(|p| (0.999..=1.0 + 1.01 * far).contains(&p.length())));
        assert!(least(&work) > 0.95 * least(&before));
    }

    #[test]
    fn what_is_near_enough_stays_to_the_bit() {
        let context = Context::new();
        let options = FeatureOptions { angle_deg: None, ..FeatureOptions::default() };
        let source = Source::new(&sphere(40), &options, &context).unwrap();
        let mut work = on_sphere(20);
        let before = work.points.clone();
        assert!(lift(&mut work, &source, &context).unwrap() < ALLOWED_GAP * source.diagonal);
        assert_eq!(work.points, before);
    }
}
