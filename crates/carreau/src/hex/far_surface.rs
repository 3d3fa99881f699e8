//! Sends boundary vertices to where the surface is far although all of them lie on it: down into a groove that faces
//! span, or out to the tip of a part that has no branch. The cells around follow, and the boundary slides along the
//! surface.
//!
//! ```text
//!    v─────────────·            ·           ·
//!   ╱│╲           ╱│╲          ╱│╲         ╱│╲
//!      ╲  groove ╱        →      ╲ ╲     ╱╱
//!       ╲       ╱                 ╲ ╲   ╱╱
//!        ╰──p──╯                   ╰──v──╯
//! ```
//!
//! And the other way round: a corner of a face whose middle is far from the surface goes to the place that is nearest to the middle.

use super::boundary::Skin;
use super::boundary_fit::Sliding;
use super::optimise::{self, relieve};
use super::target::{Part, Seen, Target};
use crate::context::Context;
use crate::error::Result;
use glam::DVec3;
use rayon::prelude::*;
use rustc_hash::{FxHashMap, FxHashSet};

/// Most rounds of reaching.
const REACHING_ROUNDS: usize = 40;
/// Rounds in a row in which nothing is gained, after which no more are tried.
const FRUITLESS_ROUNDS: usize = 4;
/// The farthest place must come nearer by this share for a round to have gained something, if no vertex went all of the way.
const NEARER: f64 = 0.05;
/// Vertices that are moved in each round: they are far from each other.
const AT_ONCE: usize = 64;
/// Scaled Jacobian below which no cell may fall.
const LEAST_JACOBIAN: f64 = 0.2;
/// Places in a round are this many times as far from each other as the farther one from the boundary.
const APART: f64 = 1.5;
/// A vertex goes all of the way, or these shares of it along the surface.
const WAYS: [f64; 3] = [1.0, 0.5, 0.25];

/// Moves vertices to where the surface is farther from the boundary than a limit. `free` are those that are inside or could not be
/// put onto the surface.
pub fn reach(
    points: &mut [DVec3],
    hexes: &[[u32; 8]],
    skin: &Skin,
    target: &Target,
    free: &[bool],
    limit: f64,
    context: &Context,
) -> Result<()> {
    let mut pinned: FxHashMap<u32, (DVec3, DVec3)> = FxHashMap::default();
    let mut part_of_the_way: Vec<u32> = Vec::new();
    let mut in_vain: FxHashSet<u32> = FxHashSet::default();
    let (mut best, mut fruitless) = ((f64::INFINITY, 0), 0);
    for round in 0..REACHING_ROUNDS {
        context.check()?;
        let is_free = |v: u32| {
            let k = v as usize;
            skin.parts[k] == Part::Wall && !free[k] && !pinned.contains_key(&v) && !in_vain.contains(&v)
        };
        let mut open = far_places(points, skin, target, limit, is_free);
        let Some(farthest) = open.first() else { break };
        tracing::debug!(round, places = open.len(), pinned = pinned.len(), far = farthest.far, "far places");
        fruitless = if farthest.far < (1.0 - NEARER) * best.0 || pinned.len() > best.1 { 0 } else { fruitless + 1 };
        if fruitless > FRUITLESS_ROUNDS {
            break;
        }
        best = (best.0.min(farthest.far), pinned.len());
        let count = open.len();
        let mut fixed = Fixed { pinned: &mut pinned, part_of_the_way: &mut part_of_the_way };
        open = fixed.go(open, points, hexes, &Surroundings { skin, target, free }, context)?;
        // What has gone makes room for others.
        if open.len() < count {
            in_vain.clear();
        }
        in_vain.extend(open.iter().map(|place| place.vertex));
    }
    // What makes poor cells better would draw them back.
    for v in part_of_the_way {
        let there = points[v as usize];
        if let Some((_, normal)) = target.closest_wall(there) {
            pinned.entry(v).or_insert((there, normal));
        }
    }
    let sliding = Sliding::pinning(points, skin, target, free, pinned);
    relieve(points, hexes, &sliding, context)
}

/// Where the boundary may go.
struct Surroundings<'a> {
    skin: &'a Skin,
    target: &'a Target<'a>,
    free: &'a [bool],
}

/// The vertices that have gone.
struct Fixed<'a> {
    /// All of the way: place and normal.
    pinned: &'a mut FxHashMap<u32, (DVec3, DVec3)>,
    part_of_the_way: &'a mut Vec<u32>,
}

impl Fixed<'_> {
    /// Moves vertices to their places, or as far as their cells allow; the places that are left.
    fn go(
        &mut self,
        mut open: Vec<Far>,
        points: &mut [DVec3],
        hexes: &[[u32; 8]],
        around: &Surroundings<'_>,
        context: &Context,
    ) -> Result<Vec<Far>> {
        for share in WAYS {
            let to = |place: &Far| match share < 1.0 {
                true => around.target.closest_wall(points[place.vertex as usize].lerp(place.to, share)),
                false => Some((place.to, place.normal)),
            };
            let mut pins = self.pinned.clone();
            pins.extend(open.iter().filter_map(|place| Some((place.vertex, to(place)?))));
            let sliding = Sliding::pinning(points, around.skin, around.target, around.free, pins);
            let vertices: Vec<u32> = open.iter().map(|place| place.vertex).collect();
            let seated = optimise::seat(points, hexes, &sliding, &vertices, LEAST_JACOBIAN, context)?;
            let (there, left): (Vec<Far>, Vec<Far>) =
                open.into_iter().partition(|place| seated.contains(&place.vertex));
            // What went all of the way stays there; the others may go on.
            if share == 1.0 {
                self.pinned.extend(there.iter().map(|place| (place.vertex, (place.to, place.normal))));
            } else {
                self.part_of_the_way.extend(there.iter().map(|place| place.vertex));
            }
            open = left;
        }
        Ok(open)
    }
}

/// A place of the surface that is far from the boundary, and the vertex of the boundary that is to go there.
struct Far {
    vertex: u32,
    to: DVec3,
    normal: DVec3,
    far: f64,
}

/// The farthest places, not near each other.
fn far_places(
    points: &[DVec3],
    skin: &Skin,
    target: &Target,
    limit: f64,
    is_free: impl Fn(u32) -> bool + Sync,
) -> Vec<Far> {
    let far = |seen: Seen| {
        if seen.distance <= limit {
            return None;
        }
        let distance = |v: u32| points[v as usize].distance_squared(seen.place);
        let near = |a: &u32, b: &u32| distance(*a).total_cmp(&distance(*b)).then(a.cmp(b));
        let vertex = skin.quads[seen.quad].into_iter().filter(|&v| is_free(v)).min_by(near)?;
        Some(Far { vertex, to: seen.place, normal: seen.normal, far: seen.distance })
    };
    let mut all = target.looking_at(points, &skin.quads, usize::MAX, far);
    all.extend(spanning(points, skin, target, limit, &is_free));
    all.sort_by(|a, b| b.far.total_cmp(&a.far));
    let mut kept: Vec<Far> = Vec::new();
    for place in all {
        let is_near = |k: &Far| k.vertex == place.vertex || k.to.distance(place.to) < APART * k.far;
        if kept.len() < AT_ONCE && !kept.iter().any(is_near) {
            kept.push(place);
        }
    }
    kept
}

/// The faces of the wall whose middles are far from the surface, and where the nearest of their corners is to go.
fn spanning(
    points: &[DVec3],
    skin: &Skin,
    target: &Target,
    limit: f64,
    is_free: impl Fn(u32) -> bool + Sync,
) -> Vec<Far> {
    let of_face = |q: &[u32; 4]| {
        let middle = q.iter().map(|&v| points[v as usize]).sum::<DVec3>() / 4.0;
        let (to, normal) = target.closest_wall(middle)?;
        let distance = |v: u32| points[v as usize].distance_squared(to);
        let near = |a: &u32, b: &u32| distance(*a).total_cmp(&distance(*b)).then(a.cmp(b));
        let vertex = q.iter().copied().filter(|&v| is_free(v)).min_by(near)?;
        let far = to.distance(middle);
        (far > limit).then_some(Far { vertex, to, normal, far })
    };
    let is_wall = |q: &&[u32; 4]| !q.iter().any(|&v| matches!(skin.parts[v as usize], Part::Lid(_)));
    skin.quads.par_iter().filter(is_wall).filter_map(of_face).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::hexes::uncertified;
    use crate::mesh::SurfaceMesh;
    use crate::mesh::test_models::{bricks, sphere};
    use crate::skeleton;

    /// A ball with a thorn where no vertex of its cells is: one goes out to it, on the surface still, and no cell folds.
    #[test]
    fn a_vertex_goes_to_the_tip_that_is_far() {
        let ball = sphere(4);
        let tip = DVec3::new(0.3, 0.2, 1.0).normalize();
        let out = |p: &DVec3| p * (1.0 + 0.5 * (1.0 - p.distance(tip) / 0.3).max(0.0));
        let triangles = ball.faces().fan().0;
        let thorny = SurfaceMesh::from_triangles(ball.points().iter().map(out).collect(), &triangles).unwrap();
        let (closed, _) = skeleton::prepared(&thorny, &Context::new()).unwrap();
        let target = Target::new(&closed);
        let (mut points, hexes) = bricks([4; 3]);
        for p in &mut points {
            let q = 0.5 * *p - DVec3::ONE;
            let on_ball = q.abs().max_element() * q.normalize_or_zero();
            *p = if q.abs().max_element() < 1.0 { on_ball } else { target.closest_wall(on_ball).unwrap().0 };
        }
        let skin = Skin::new(&hexes, &vec![0; points.len()], &[]);
        let free: Vec<bool> = (0..points.len()).map(|v| !skin.has(v)).collect();
        let farthest = |points: &[DVec3]| far_places(points, &skin, &target, 0.0, |_| true)[0].far;
        let before = farthest(&points);
        assert!(before > 0.15, "{before}");
        reach(&mut points, &hexes, &skin, &target, &free, 0.1, &Context::new()).unwrap();
        assert!(farthest(&points) < 0.6 * before, "{before} {}", farthest(&points));
        assert!(uncertified(&points, &hexes).is_empty());
        assert!((0..points.len()).filter(|&v| skin.has(v)).all(|v| target.distance(points[v]) < 1e-9));
    }

    /// One cell in a ball: each of its faces spans what is hollow from there, and a corner goes to the nearest place.
    #[test]
    fn a_face_far_from_the_surface_is_seen() {
        let (mut points, hexes) = bricks([1; 3]);
        points.iter_mut().for_each(|p| *p = (2.0 * *p - DVec3::ONE).normalize());
        let (closed, _) = skeleton::prepared(&sphere(4), &Context::new()).unwrap();
        let (skin, target) = (Skin::new(&hexes, &[0; 8], &[]), Target::new(&closed));
        let found = |limit: f64, v: u32| spanning(&points, &skin, &target, limit, |w| w != v);
        assert_eq!(found(0.5, 8).len(), 0);
        let all = found(0.3, 8);
        assert_eq!(all.len(), 6);
        assert!(all.iter().all(|f| (f.far - 0.42).abs() < 0.02 && f.to.abs().max_element() > 0.98));
        assert!(found(0.3, 7).iter().all(|f| f.vertex != 7));
    }
}
