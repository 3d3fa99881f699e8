//! Pulls the boundary of the mesh to the surface.
//!
//! Every boundary vertex is cast along the mean normal of its boundary faces, forward and backward, on the side of the
//! surface that faces the same way; where nothing is met within reach, its closest such point counts. Springs pull it there,
//! stiff along the surface's normal and free along the surface, stiffer from round to round, and the cells never leave the
//! valid set. At last the vertices are put onto the surface, as far as all cells stay certified.
//!
//! Vertices of caps in lids stay in the lid's plane, those of its rim on the border of the surface.

mod sliding;
#[cfg(test)]
mod tests;

use super::boundary::{SWELL, Skin};
use super::optimise::{self, Optimiser, polish};
use super::target::{Part, Target};
use crate::context::Context;
use crate::error::Result;
use crate::geometry::hexes::volume;
use crate::mesh::Topology;
use glam::DVec3;
use rayon::prelude::*;
use rustc_hash::FxHashMap;
use sliding::springs_to;

pub use sliding::Sliding;

/// Least scaled Jacobian of cells when vertices are put onto the surface together with their surroundings, unless
/// they were poorer before.
const SEATED: f64 = 0.1;
/// The same for the vertices that are left at last.
const BARELY_SEATED: f64 = 0.01;
/// Scaled Jacobian up to which the boundary's swelling must not make cells poorer.
const POOR_BEFORE_SWELLING: f64 = 0.5;
/// Share of that scaled Jacobian, or of their own, that cells keep when the boundary swells.
const KEPT_WHEN_SWELLING: f64 = 0.98;
/// Share of the surface's volume up to which the boundary swells.
const FULL: f64 = 0.99;
/// Steps in which the boundary swells to that volume.
const SWELLINGS: usize = 4;
/// Rounds of taking back vertices whose cells do not.
const UNDOING_ROUNDS: usize = 1000;
/// Passes over the vertices that were taken back, in which each is tried alone.
const PASSES: usize = 20;

/// How the strength of the springs rises.
pub struct Rise {
    /// Strength of the first and of the last round.
    pub strength: [f64; 2],
    /// Rounds.
    pub rounds: usize,
    /// Power of the energy, and iterations of each round.
    pub power: i32,
    /// Iterations of each round.
    pub iterations: usize,
}

/// Pulls the boundary to the surface, round by round.
pub fn pull(
    optimiser: &mut Optimiser,
    points: &mut Vec<DVec3>,
    skin: &Skin,
    target: &Target,
    rise: &Rise,
    context: &Context,
) -> Result<()> {
    for round in 0..rise.rounds {
        let t = round as f64 / (rise.rounds.max(2) - 1) as f64;
        let strength = rise.strength[0] * (rise.strength[1] / rise.strength[0]).powf(t);
        let mut springs = Vec::new();
        let shape = skin.shape(points);
        let mut places = skin.places(points, &shape, target);
        skin.reach_out(points, &shape, target, &mut places);
        for (vertex, to, normal) in places {
            let across = 1e-3 * strength.min(1.0);
            springs.extend(springs_to(target, skin.parts[vertex as usize], vertex, to, normal, strength, across));
        }
        optimiser.tie(springs);
        optimiser.descend(points, 0.0, rise.power, rise.iterations, context)?;
        optimiser.retarget(points);
    }
    Ok(())
}

/// Lets boundary vertices slide where cells are poor, those on ridges along these. `free` are those that are inside or could not be put onto the surface.
pub fn slide(
    points: &mut [DVec3],
    hexes: &[[u32; 8]],
    skin: &Skin,
    target: &Target,
    free: &[bool],
    context: &Context,
) -> Result<()> {
    let sliding = Sliding::pinning(points, skin, target, free, FxHashMap::default()).on_ridges(points);
    polish(points, hexes, &sliding, context)
}

/// Where boundary vertices are put.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Seat {
    /// Where they belong.
    Own,
    /// Where the surface is closest, though it face another way there.
    Closest,
    /// The same, one by one.
    Singly,
    /// The same, though cells become poor by that.
    Poorly,
}

/// Puts boundary vertices onto the surface that are still `free`, with the cells around them, those beside each other together
/// if not one by one.
pub fn seat(
    points: &mut [DVec3],
    hexes: &[[u32; 8]],
    skin: &Skin,
    target: &Target,
    free: &mut [bool],
    where_to: Seat,
    context: &Context,
) -> Result<()> {
    let (at_closest, singly, least) = match where_to {
        Seat::Own => (false, false, SEATED),
        Seat::Closest => (true, false, SEATED),
        Seat::Singly => (true, true, SEATED),
        Seat::Poorly => (true, true, BARELY_SEATED),
    };
    let vertices = 0..points.len();
    let stuck: Vec<u32> = (0..points.len() as u32).filter(|&v| free[v as usize] && skin.has(v as usize)).collect();
    let mut sliding = Sliding::new(points, skin, target, vertices.clone().map(|v| skin.has(v)).collect(), &stuck);
    for &v in &stuck {
        sliding.at_closest[v as usize] = at_closest && skin.parts[v as usize] == Part::Wall;
        sliding.placed[v as usize] = !singly;
    }
    for group in stuck.chunks(if singly { 1 } else { stuck.len().max(1) }) {
        group.iter().for_each(|&v| sliding.placed[v as usize] = true);
        let seated = optimise::seat(points, hexes, &sliding, group, least, context)?;
        for v in vertices.clone().filter(|&v| skin.has(v) && seated.contains(&(v as u32))) {
            free[v] = false;
        }
        group.iter().for_each(|&v| sliding.placed[v as usize] &= !singly || !free[v as usize]);
    }
    Ok(())
}

/// Puts the boundary onto the surface as far as all cells stay certified and keep a share of their quality, `kept`; says of
/// every vertex whether it is inside, or could not be put there.
pub fn snap(optimiser: &Optimiser, points: &mut [DVec3], skin: &Skin, target: &Target, kept: f64) -> Vec<bool> {
    let start = points.to_vec();
    let floors: Vec<f64> = optimiser.qualities(points).into_iter().map(|q| kept * q).collect();
    let mut places = skin.places(points, &skin.shape(points), target);
    // The projection of a projection: rays meet flat pieces, and the closest point is on them for sure.
    places.iter_mut().filter(|p| skin.parts[p.0 as usize] == Part::Wall).for_each(|p| {
        if let Some((to, _)) = target.closest_wall(p.1) {
            p.1 = to;
        }
    });
    skin.swell(points, target, 0.0, &mut places);
    let mut goes = put_together(optimiser, points, &start, &places, &floors);
    let middles = Middles::new(skin, target);
    put_singly(optimiser, points, &places, &floors, &mut goes, |v, points| middles.place(v, points));
    // Where it is near enough a vertex may stay.
    let near = SWELL * target.surface().diagonal();
    let is_there = |&(v, _, _): &(u32, DVec3, DVec3)| {
        let k = v as usize;
        goes[k]
            || skin.parts[k] == Part::Wall
                && target.closest_wall(points[k]).is_some_and(|c| c.0.distance(points[k]) <= near)
    };
    let there: Vec<bool> = places.par_iter().map(is_there).collect();
    let mut free = vec![true; points.len()];
    places.iter().zip(there).for_each(|(p, there)| free[p.0 as usize] = !there);
    free
}

/// Puts all vertices in their places at once, and takes back, round by round, those of weak cells; says which went.
fn put_together(
    optimiser: &Optimiser,
    points: &mut [DVec3],
    start: &[DVec3],
    places: &[(u32, DVec3, DVec3)],
    floors: &[f64],
) -> Vec<bool> {
    let mut goes = vec![true; points.len()];
    for _ in 0..UNDOING_ROUNDS {
        for &(v, to, _) in places {
            points[v as usize] = if goes[v as usize] { to } else { start[v as usize] };
        }
        let weak = optimiser.weak(points, floors);
        if weak.is_empty() {
            break;
        }
        weak.iter().flat_map(|&h| optimiser.corners_of(h)).for_each(|&v| goes[v as usize] = false);
    }
    goes
}

/// What slid along the surface has lost its distance from that: wall vertices that are not `free` get it again
/// ([`Skin::swell`]), and more where the volume is still small, as far as no other cell becomes poor, and no poor one much poorer.
pub fn swell(points: &mut [DVec3], hexes: &[[u32; 8]], skin: &Skin, target: &Target, free: &[bool]) {
    let optimiser = Optimiser::new(points, hexes);
    let start = points.to_vec();
    let floors: Vec<f64> =
        optimiser.qualities(points).into_iter().map(|q| KEPT_WHEN_SWELLING * q.min(POOR_BEFORE_SWELLING)).collect();
    let on_wall = |v: &usize| skin.parts[*v] == Part::Wall && !free[*v];
    let place = |v: usize| target.closest_wall(start[v]).map(|(to, normal)| (v as u32, to, normal));
    let on_surface: Vec<_> = (0..points.len()).into_par_iter().filter(on_wall).filter_map(place).collect();
    let wanted = FULL * Topology::of(target.surface()).volume.unwrap_or(0.0);
    let area = skin.area(points);
    let (mut places, mut outward) = (Vec::new(), 0.0);
    for _ in 0..SWELLINGS {
        places.clone_from(&on_surface);
        skin.swell(&start, target, outward, &mut places);
        places.iter().for_each(|&(v, to, _)| points[v as usize] = to);
        let lacking = wanted - hexes.iter().map(|h| volume(&h.map(|v| points[v as usize]))).sum::<f64>();
        if !(lacking > 0.0 && area > 0.0) {
            break;
        }
        outward += lacking / area;
    }
    put_together(&optimiser, points, &start, &places, &floors);
}

/// Where boundary vertices belong by their neighbours: places that are found one by one may be in each other's way.
///
/// ```text
///       ·                       ·
///   ·───v───·   v's own   ·──v──·      the middle of its neighbours, put onto the surface
///       ·        place          ·
/// ```
struct Middles<'a> {
    skin: &'a Skin,
    target: &'a Target<'a>,
    /// The boundary vertices around each.
    around: Vec<Vec<u32>>,
}

impl<'a> Middles<'a> {
    fn new(skin: &'a Skin, target: &'a Target<'a>) -> Self {
        let mut around = vec![Vec::new(); skin.parts.len()];
        for q in &skin.quads {
            // Every side belongs to two faces, once in each sense.
            (0..4).for_each(|k| around[q[k] as usize].push(q[(k + 1) % 4]));
        }
        Middles { skin, target, around }
    }

    /// `None` for what is not a vertex of the wall.
    fn place(&self, v: u32, points: &[DVec3]) -> Option<DVec3> {
        let around = &self.around[v as usize];
        if self.skin.parts[v as usize] != Part::Wall || around.is_empty() {
            return None;
        }
        let middle = around.iter().map(|&w| points[w as usize]).sum::<DVec3>() / around.len() as f64;
        self.target.closest_wall(middle).map(|c| c.0)
    }
}

/// One weak cell has taken back all of its corners, and a cell between those and others that went may have become weak by that,
/// and so on: most of them can go alone, one after the other, to their own places or to `others`.
fn put_singly(
    optimiser: &Optimiser,
    points: &mut [DVec3],
    places: &[(u32, DVec3, DVec3)],
    floors: &[f64],
    goes: &mut [bool],
    other: impl Fn(u32, &[DVec3]) -> Option<DVec3>,
) {
    for _ in 0..PASSES {
        let mut any = false;
        for &(v, to, _) in places {
            if goes[v as usize] {
                continue;
            }
            let from = points[v as usize];
            for to in [Some(to), other(v, points)].into_iter().flatten() {
                points[v as usize] = to;
                goes[v as usize] = optimiser.cells_at(v).all(|h| !optimiser.is_weak(h, points, floors[h as usize]));
                if goes[v as usize] {
                    any = true;
                    break;
                }
                points[v as usize] = from;
            }
        }
        if !any {
            break;
        }
    }
}
