//! Pulls the boundary of the mesh to the surface.
//!
//! Every boundary vertex is cast along the mean normal of its boundary faces, forward and backward, on the side of the
//! surface that faces the same way; where nothing is met within reach, its closest such point counts. Springs pull it there,
//! stiff along the surface's normal and free along the surface, stiffer from round to round, and the cells never leave the
//! valid set. At last the vertices are put onto the surface, as far as all cells stay certified.
//!
//! Vertices of caps in lids stay in the lid's plane, those of its rim on the border of the surface.

use super::boundary::{SWELL, Shape, Skin};
use super::optimise::{self, Optimiser, Spring, Ties, polish};
use super::ridges;
use super::target::{Part, Target};
use crate::context::Context;
use crate::error::Result;
use crate::geometry::hexes::volume;
use crate::mesh::Topology;
use glam::DVec3;
use rayon::prelude::*;
use rustc_hash::FxHashMap;

/// Strength of the springs to the surface along its normal, and across, while poor cells are improved.
const SLIDING: [f64; 2] = [1000.0, 1e-3];
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

/// What pulls a boundary vertex to its place.
fn springs_to(
    target: &Target,
    part: Part,
    vertex: u32,
    to: DVec3,
    normal: DVec3,
    along: f64,
    across: f64,
) -> impl Iterator<Item = Spring> + use<> {
    // Along the border of a lid it slides.
    let in_plane = match part {
        Part::Rim(k) => Some(Spring { vertex, to, normal: target.lids()[k as usize].normal, along, across: 0.0 }),
        _ => None,
    };
    [Some(Spring { vertex, to, normal, along, across }), in_plane].into_iter().flatten()
}

/// The boundary slides along the surface.
pub struct Sliding<'a> {
    skin: &'a Skin,
    target: &'a Target<'a>,
    shape: Shape,
    /// Vertices that are on the surface, or are to be put there.
    placed: Vec<bool>,
    /// The surface's normal at wall vertices that are on it.
    under: Vec<Option<DVec3>>,
    /// Vertices that belong where the surface is closest.
    at_closest: Vec<bool>,
    /// Vertices that belong to one place, and the normal there.
    pinned: FxHashMap<u32, (DVec3, DVec3)>,
    /// Where each vertex was, and the directions in which it is held there; empty where all are free.
    held: Vec<(DVec3, [DVec3; 2])>,
}

impl<'a> Sliding<'a> {
    /// Of the `placed` vertices, all but the `stuck` ones are on the surface.
    fn new(points: &[DVec3], skin: &'a Skin, target: &'a Target<'a>, placed: Vec<bool>, stuck: &[u32]) -> Self {
        let mut is_on: Vec<bool> = (0..points.len()).map(|v| placed[v] && skin.parts[v] == Part::Wall).collect();
        stuck.iter().for_each(|&v| is_on[v as usize] = false);
        let normal = |(p, is_on): (&DVec3, &bool)| is_on.then(|| target.closest_wall(*p).map(|c| c.1)).flatten();
        let under = points.par_iter().zip(&is_on).map(normal).collect();
        Sliding {
            skin,
            target,
            shape: skin.shape(points),
            placed,
            under,
            at_closest: vec![false; points.len()],
            pinned: FxHashMap::default(),
            held: Vec::new(),
        }
    }

    /// Vertices on ridges slide along these only.
    fn on_ridges(self, points: &[DVec3]) -> Self {
        let held = points.iter().copied().zip(ridges::bends(points, self.skin)).collect();
        Sliding { held, ..self }
    }

    /// Vertices that are not `free` are on the surface, and some belong to one place, which has a normal.
    pub fn pinning(
        points: &[DVec3],
        skin: &'a Skin,
        target: &'a Target<'a>,
        free: &[bool],
        pinned: FxHashMap<u32, (DVec3, DVec3)>,
    ) -> Self {
        let placed = (0..points.len()).map(|v| skin.has(v) && !free[v]).collect();
        let moved: Vec<u32> = pinned.keys().copied().collect();
        Sliding { pinned, ..Sliding::new(points, skin, target, placed, &moved) }
    }

    fn place(&self, v: usize, at: DVec3) -> (DVec3, DVec3) {
        if self.at_closest[v]
            && let Some(closest) = self.target.closest_wall(at)
        {
            return closest;
        }
        let (normal, reach) = (self.shape.normals[v], 4.0 * self.shape.sizes[v]);
        let along = self.under[v].and_then(|under| self.target.along_wall(at, [normal, under], reach));
        along.unwrap_or_else(|| self.target.place(self.skin.parts[v], at, normal, reach))
    }
}

impl Ties for Sliding<'_> {
    fn springs(&self, vertex: u32, at: DVec3) -> Vec<Spring> {
        let v = vertex as usize;
        if !self.placed[v] {
            return Vec::new();
        }
        if let Some(&(to, normal)) = self.pinned.get(&vertex) {
            return vec![Spring { vertex, to, normal, along: SLIDING[0], across: SLIDING[0] }];
        }
        let (to, normal) = self.place(v, at);
        let mut springs: Vec<Spring> =
            springs_to(self.target, self.skin.parts[v], vertex, to, normal, SLIDING[0], SLIDING[1]).collect();
        if let Some(&(to, bends)) = self.held.get(v) {
            let holds = |normal| Spring { vertex, to, normal, along: SLIDING[0], across: 0.0 };
            springs.extend(bends.into_iter().filter(|d| *d != DVec3::ZERO).map(holds));
        }
        springs
    }

    /// What could not be put onto the surface stays as near as it is.
    fn is_fixed(&self, vertex: u32) -> bool {
        self.skin.has(vertex as usize) && !self.placed[vertex as usize]
    }

    fn tied_place(&self, vertex: u32, at: DVec3) -> Option<DVec3> {
        let v = vertex as usize;
        if let Some((to, _)) = self.pinned.get(&vertex) {
            return Some(*to);
        }
        self.placed[v].then(|| {
            let to = self.place(v, at).0;
            if self.skin.parts[v] == Part::Wall { self.target.closest_wall(to).map_or(to, |c| c.0) } else { to }
        })
    }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::test_models::{bricks, sphere};
    use crate::skeleton;

    /// Of two vertices side by side on the top of a block, one would turn its cells over: the other goes alone.
    #[test]
    fn a_vertex_goes_where_its_neighbour_cannot() {
        let at = |i: u32, j: u32, k: u32| (k * 2 + j) * 4 + i;
        let (points, hexes) = bricks([3, 1, 1]);
        let (goes_alone, cannot) = (at(1, 0, 1), at(2, 0, 1));
        let up = |v: u32, by: f64| (v, points[v as usize] + DVec3::Z * by, DVec3::Z);
        let places = [up(goes_alone, 0.1), up(cannot, -1.5)];
        let (mut moved, mut goes) = (points.clone(), vec![false; points.len()]);
        put_singly(&Optimiser::new(&points, &hexes), &mut moved, &places, &[0.4; 3], &mut goes, |_, _| None);
        assert!(goes[goes_alone as usize] && !goes[cannot as usize]);
        assert_eq!(moved[goes_alone as usize], places[0].1);
        assert!((0..16).filter(|&v| v != goes_alone).all(|v| moved[v as usize] == points[v as usize]));
    }

    /// A block of 2 × 2 × 2 cells in a ball: the middle of its top belongs above the middle of the four vertices around it.
    #[test]
    fn a_vertex_may_go_where_its_neighbours_say() {
        let at = |i: u32, j: u32, k: u32| (k * 3 + j) * 3 + i;
        let (mut points, hexes) = bricks([2; 3]);
        points.iter_mut().for_each(|p| *p = 0.3 * (*p - DVec3::ONE));
        let top = at(1, 1, 2);
        points[top as usize] = DVec3::new(0.2, 0.1, 0.4);
        let (closed, _) = skeleton::prepared(&sphere(4), &Context::new()).unwrap();
        let (skin, target) = (Skin::new(&hexes, &[0; 27], &[]), Target::new(&closed));
        let middles = Middles::new(&skin, &target);
        let to = middles.place(top, &points).unwrap();
        assert!(to.distance(DVec3::Z) < 0.05, "{to}");
        assert_eq!(middles.place(at(1, 1, 1), &points), None);
        // Its own place would fold the cells; that of the others is taken.
        let (mut moved, mut goes) = (points.clone(), vec![true; 27]);
        goes[top as usize] = false;
        let places = [(top, DVec3::new(0.0, 0.0, -0.5), DVec3::Z)];
        put_singly(&Optimiser::new(&points, &hexes), &mut moved, &places, &[0.1; 8], &mut goes, |_, _| {
            Some(DVec3::new(0.0, 0.0, 0.5))
        });
        assert!(goes[top as usize]);
        assert_eq!(moved[top as usize], DVec3::new(0.0, 0.0, 0.5));
    }

    /// A block in a ball, all of its boundary on that: its volume grows, by as much as vertices may leave the surface; what is
    /// free stays.
    #[test]
    fn a_boundary_on_a_ball_takes_its_volume() {
        let (mut points, hexes) = bricks([8; 3]);
        for p in &mut points {
            let q = 0.25 * *p - DVec3::ONE;
            *p = q.abs().max_element() * q.normalize_or_zero();
        }
        let (closed, _) = skeleton::prepared(&sphere(4), &Context::new()).unwrap();
        let (skin, target) = (Skin::new(&hexes, &vec![0; points.len()], &[]), Target::new(&closed));
        let on_wall: Vec<usize> = (0..points.len()).filter(|&v| skin.has(v)).collect();
        on_wall.iter().for_each(|&v| points[v] = target.closest_wall(points[v]).unwrap().0);
        let free: Vec<bool> = (0..points.len()).map(|v| !skin.has(v)).collect();
        let start = points.clone();
        swell(&mut points, &hexes, &skin, &target, &free);
        let outward = |v: &usize| points[*v].length() - start[*v].length();
        let reach = SWELL * target.surface().diagonal();
        assert!(on_wall.iter().all(|v| (0.0..=1.01 * reach).contains(&outward(v))));
        assert!(on_wall.iter().filter(|v| outward(v) > 0.9 * reach).count() > on_wall.len() / 2);
        assert!((0..points.len()).filter(|&v| free[v]).all(|v| points[v] == start[v]));
        let mut stays = start.clone();
        swell(&mut stays, &hexes, &skin, &target, &vec![true; free.len()]);
        assert_eq!(stays, start);
    }

    /// Ahead of a vertex in a ball the surface is nearer than where it is closest; but where a vertex cannot go there it goes to
    /// the closest place.
    #[test]
    fn a_vertex_may_go_to_the_closest_place() {
        let (mut points, hexes) = bricks([2; 3]);
        points.iter_mut().for_each(|p| *p = 0.3 * (*p - DVec3::ONE));
        let (closed, _) = skeleton::prepared(&sphere(4), &Context::new()).unwrap();
        let (skin, target) = (Skin::new(&hexes, &[0; 27], &[]), Target::new(&closed));
        let top = (2 * 3 + 1) * 3 + 1;
        let placed = (0..27).map(|v| skin.has(v)).collect();
        let mut sliding = Sliding::new(&points, &skin, &target, placed, &[top]);
        let (top, at) = (top as usize, DVec3::new(0.6, 0.0, 0.2));
        let ahead = sliding.place(top, at).0;
        sliding.at_closest[top] = true;
        let closest = sliding.place(top, at).0;
        assert!(ahead.distance(DVec3::new(0.6, 0.0, 0.8)) < 0.05, "{ahead}");
        assert!(closest.distance(at.normalize()) < 0.05, "{closest}");
    }
}
