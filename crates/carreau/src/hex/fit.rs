//! The boundary of the mesh goes to the surface (spec 1.6).
//!
//! Every boundary vertex is cast along the mean normal of its boundary faces, forward and backward, on the side of the
//! surface that faces the same way; where nothing is met within reach, its closest such point counts. Springs pull it there,
//! stiff along the surface's normal and free along the surface, stiffer from round to round, and the cells never leave the
//! valid set. At last the vertices are put onto the surface, as far as all cells stay certified.
//!
//! Vertices of caps in lids stay in the lid's plane, those of its rim on the border of the surface.

use super::optimise::{self, Optimiser, Spring, Ties, relieve};
use crate::context::Context;
use crate::error::Result;
use crate::geometry::normals::face_normals;
use crate::geometry::search_tree::{Closest, TriangleTree};
use crate::geometry::winding::WindingTree;
use crate::mesh::{CurveNet, SurfaceMesh, boundary_faces, split_quad};
use crate::skeleton::{self, Closed, Lid};
use glam::DVec3;
use rayon::prelude::*;

/// A hit counts when its normal is at most about 75° off.
const AGREES: f64 = 0.25;
/// What is met along the normal is taken for this much nearer than the closest point.
const AHEAD: f64 = 0.5;
/// The surface bulges where it is farther from the boundary than this share of the boundary's faces, or than this share of its
/// diagonal; it is looked at in so many places, about.
const BULGE: f64 = 0.3;
const FAR: f64 = 0.01;
const SAMPLES: usize = 20_000;
/// Wall vertices lie off the surface by no more than this share of its diagonal, for the sake of the faces between them.
const SWELL: f64 = 8e-5;
/// Strength of the springs to the surface along its normal, and across, while poor cells are improved.
const SLIDING: [f64; 2] = [1000.0, 1e-3];
/// Rounds of taking back vertices whose cells do not.
const ROUNDS: usize = 1000;
/// Passes over the vertices that were taken back, in which each is tried alone.
const PASSES: usize = 20;

/// The surface, its lids and borders.
pub struct Target<'a> {
    closed: &'a Closed,
    normals: Vec<DVec3>,
    all: TriangleTree,
    inside: WindingTree,
    /// Borders of the lids, as triangles without width.
    rims: Vec<TriangleTree>,
    by_facing: bool,
}

/// What a boundary vertex belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// Inside.
    Inner,
    /// The surface.
    Wall,
    /// A lid, from 0.
    Lid(u32),
    /// The border of a lid.
    Rim(u32),
}

impl<'a> Target<'a> {
    /// The target of a surface with lids.
    pub fn new(closed: &'a Closed) -> Self {
        let triangles = closed.mesh.faces().fan().0;
        let rim = |lid: &Lid| {
            let sides = lid.triangles.clone().map(|t| triangles[t as usize]).map(|[a, b, _]| [a, b]);
            TriangleTree::of_segments(closed.mesh.points(), sides)
        };
        let all = TriangleTree::new(closed.mesh.points(), &triangles);
        Target {
            normals: face_normals(&closed.mesh),
            inside: WindingTree::new(&all),
            all,
            rims: closed.lids.iter().map(rim).collect(),
            by_facing: false,
            closed,
        }
    }

    /// What faces another way than a vertex is taken for farther from it, so that a vertex in a body between two branches
    /// goes ahead to where these part, not to the flank of the body. Some surfaces are met better with, some without.
    ///
    /// ```text
    ///     ╲   ╱          s faces as v does; f is nearer, but faces aside
    ///      ╲s╱
    ///       ↑
    ///   f   v   f
    /// ```
    pub fn by_facing(self) -> Self {
        Target { by_facing: true, ..self }
    }

    /// The closed surface.
    pub fn surface(&self) -> &SurfaceMesh {
        &self.closed.mesh
    }

    /// The lids.
    pub fn lids(&self) -> &[Lid] {
        &self.closed.lids
    }

    /// The triangles of the surface without its lids.
    pub fn wall(&self) -> std::ops::Range<usize> {
        0..self.closed.wall
    }

    /// The corners of a triangle.
    pub fn corners(&self, triangle: u32) -> [DVec3; 3] {
        let (points, corners) = (self.surface().points(), self.surface().faces().corners());
        [0, 1, 2].map(|k| points[corners[3 * triangle as usize + k] as usize])
    }

    /// Distance to the closed surface.
    pub fn distance(&self, p: DVec3) -> f64 {
        self.all.distance(p)
    }

    /// Whether a point is inside.
    pub fn contains(&self, p: DVec3) -> bool {
        self.inside.contains(p)
    }

    /// Moves the nodes of a net to the middle of the surface.
    pub fn centre(&self, net: &mut CurveNet) {
        skeleton::centre(net, &self.all, &self.inside);
    }

    /// How far along a ray from inside the surface is left.
    pub fn leaves(&self, from: DVec3, direction: DVec3) -> Option<f64> {
        let mut first: Option<f64> = None;
        self.all.along_ray(from, direction, f64::INFINITY, |hit| {
            if !hit.front && first.is_none_or(|t| hit.t < t) {
                first = Some(hit.t);
            }
        });
        first
    }

    fn is_wall(&self, triangle: u32) -> bool {
        (triangle as usize) < self.closed.wall
    }

    /// Where a wall vertex with a normal belongs, and the surface's normal there: ahead or behind along the normal, or,
    /// where that glances off, where the surface is closest.
    fn on_wall(&self, p: DVec3, n: DVec3, reach: f64) -> (DVec3, DVec3) {
        let farther = |distance: f64, triangle: u32| {
            let cos = self.normals[triangle as usize].dot(n);
            (self.is_wall(triangle) && cos > AGREES).then(|| if self.by_facing { distance / cos } else { distance })
        };
        let mut best: Option<(f64, DVec3, u32)> = None;
        for sense in [1.0, -1.0] {
            self.all.along_ray(p, n * sense, reach, |hit| {
                let Some(far) = farther(AHEAD * hit.t, hit.triangle) else { return };
                if best.is_none_or(|b| far < b.0) {
                    best = Some((far, p + n * (sense * hit.t), hit.triangle));
                }
            });
        }
        let reach = best.map_or(reach, |b| b.0.min(reach));
        if let Some((far, c)) = self.all.cheapest(p, reach, |c| farther(c.distance(), c.triangle))
            && best.is_none_or(|b| (far, c.triangle) < (b.0, b.2))
        {
            best = Some((far, c.point, c.triangle));
        }
        match best {
            Some((_, point, triangle)) => (point, self.normals[triangle as usize]),
            None => self.closest_wall(p).unwrap_or((p, n)),
        }
    }

    /// Where a vertex belongs that was on the wall and has been moved along it: at the closest place that faces as the vertex
    /// does, or as the wall did where the vertex was. The two differ much where a few faces span a fork.
    fn along_wall(&self, p: DVec3, facings: [DVec3; 2], reach: f64) -> Option<(DVec3, DVec3)> {
        let agrees = |t: u32| facings.iter().any(|n| self.normals[t as usize].dot(*n) > AGREES);
        let cost = |c: &Closest| (self.is_wall(c.triangle) && agrees(c.triangle)).then(|| c.distance());
        let (_, c) = self.all.cheapest(p, reach, cost)?;
        Some((c.point, self.normals[c.triangle as usize]))
    }

    fn closest_wall(&self, p: DVec3) -> Option<(DVec3, DVec3)> {
        let c = self.all.closest(p)?;
        Some((c.point, self.normals[c.triangle as usize]))
    }

    /// Where a boundary vertex belongs, and the direction in which it must be there; others are free.
    fn place(&self, part: Part, p: DVec3, n: DVec3, reach: f64) -> (DVec3, DVec3) {
        match part {
            Part::Inner => (p, DVec3::ZERO),
            Part::Wall => self.on_wall(p, n, reach),
            Part::Lid(k) => {
                let lid = &self.lids()[k as usize];
                (p - lid.normal * (p - lid.centre).dot(lid.normal), lid.normal)
            }
            Part::Rim(k) => {
                // About across the border, in the lid's plane.
                let (lid, to) = (&self.lids()[k as usize], self.rims[k as usize].closest(p).map_or(p, |c| c.point));
                let outward = to - lid.centre;
                (to, (outward - lid.normal * lid.normal.dot(outward)).normalize_or_zero())
            }
        }
    }
}

/// The boundary of a mesh, and what its vertices belong to.
pub struct Skin {
    quads: Vec<[u32; 4]>,
    parts: Vec<Part>,
}

/// The boundary where its vertices are: unit normals, and the longest side of the faces at each.
struct Shape {
    normals: Vec<DVec3>,
    sizes: Vec<f64>,
}

impl Skin {
    /// `caps` numbers the end of every vertex from 1, `lid_of` the lid of every end, from 1, zero for a round tip.
    pub fn new(hexes: &[[u32; 8]], caps: &[u32], lid_of: &[u32]) -> Skin {
        let quads: Vec<[u32; 4]> = boundary_faces(hexes).into_iter().map(|f| f.0).collect();
        let lid = |v: u32| match caps[v as usize] {
            0 => 0,
            end => lid_of[end as usize - 1],
        };
        let mut parts = vec![Part::Inner; caps.len()];
        for q in &quads {
            let k = lid(q[0]);
            let own = if k > 0 && q.iter().all(|&v| lid(v) == k) { Part::Lid(k - 1) } else { Part::Wall };
            for &v in q {
                let part = &mut parts[v as usize];
                *part = match (*part, own) {
                    (Part::Inner, own) => own,
                    (Part::Wall, Part::Lid(k)) | (Part::Lid(k), Part::Wall) => Part::Rim(k),
                    (known, _) => known,
                };
            }
        }
        Skin { quads, parts }
    }

    /// Whether a vertex is on the boundary.
    pub fn has(&self, v: usize) -> bool {
        self.parts[v] != Part::Inner
    }

    /// Unit normals of the wall vertices, by the wall's own faces.
    fn normals(&self, points: &[DVec3]) -> Vec<DVec3> {
        let mut sums = vec![DVec3::ZERO; points.len()];
        for q in &self.quads {
            let p = q.map(|v| points[v as usize]);
            let area = (p[2] - p[0]).cross(p[3] - p[1]);
            let normal = area.normalize_or_zero() * area.length().sqrt();
            q.iter().for_each(|&v| sums[v as usize] += normal);
        }
        sums.iter().map(|s| s.normalize_or_zero()).collect()
    }

    fn shape(&self, points: &[DVec3]) -> Shape {
        Shape { normals: self.normals(points), sizes: self.sizes(points) }
    }

    /// Where every boundary vertex belongs, in their order.
    fn places(&self, points: &[DVec3], shape: &Shape, target: &Target) -> Vec<(u32, DVec3, DVec3)> {
        (0..points.len() as u32)
            .into_par_iter()
            .filter(|&v| self.parts[v as usize] != Part::Inner)
            .map(|v| {
                let k = v as usize;
                let (to, normal) = target.place(self.parts[k], points[k], shape.normals[k], 4.0 * shape.sizes[k]);
                (v, to, normal)
            })
            .collect()
    }

    /// Moves the places of wall vertices off the surface by half of the sag of the faces around them, within a limit: faces
    /// with all corners on a round wall lie inside of it, and the volume would be too small.
    fn swell(&self, points: &[DVec3], target: &Target, places: &mut [(u32, DVec3, DVec3)]) {
        let mut placed = points.to_vec();
        places.iter().for_each(|p| placed[p.0 as usize] = p.1);
        let sag = |q: &[u32; 4]| {
            let p = q.map(|v| placed[v as usize]);
            let (middle, normal) =
                (p.iter().sum::<DVec3>() / 4.0, (p[2] - p[0]).cross(p[3] - p[1]).normalize_or_zero());
            target.closest_wall(middle).map_or(0.0, |(on, _)| (on - middle).dot(normal))
        };
        let sags: Vec<f64> = self.quads.par_iter().map(sag).collect();
        let mut sums = vec![(0.0, 0.0); points.len()];
        for (q, sag) in self.quads.iter().zip(sags) {
            for &v in q {
                let (sum, count) = sums[v as usize];
                sums[v as usize] = (sum + sag, count + 1.0);
            }
        }
        let normals = self.normals(&placed);
        let most = SWELL * target.surface().diagonal();
        for (v, to, _) in places.iter_mut().filter(|p| self.parts[p.0 as usize] == Part::Wall) {
            let (sum, count) = sums[*v as usize];
            *to += normals[*v as usize] * (0.5 * sum / f64::max(count, 1.0)).clamp(-most, most);
        }
    }

    /// Draws boundary vertices to where the surface bulges away from the boundary, though all of its vertices be on it: the
    /// one nearest to each bulge goes to its farthest place.
    ///
    /// ```text
    ///     ╭──s──╮         ╭──v──╮
    ///     │  ↑  │    →    │ ╱ ╲ │
    ///   ──v──v──v──     ──v╯   ╰v──
    /// ```
    fn reach_out(&self, points: &[DVec3], shape: &Shape, target: &Target, places: &mut [(u32, DVec3, DVec3)]) {
        let triangles: Vec<[u32; 3]> = self.quads.iter().flat_map(|&q| split_quad(points, q)).collect();
        let far = FAR * target.surface().diagonal();
        let tree = TriangleTree::new(points, &triangles);
        let bulge = |t: u32| {
            let n = target.normals[t as usize];
            let [a, b, c] = target.corners(t);
            let sample = (a + b + c) / 3.0;
            let found = tree.closest(sample)?;
            let near = |v: &u32| points[*v as usize].distance_squared(sample);
            let walls =
                triangles[found.triangle as usize].into_iter().filter(|&v| self.parts[v as usize] == Part::Wall);
            let v = walls.min_by(|a, b| near(a).total_cmp(&near(b)))?;
            let k = v as usize;
            let bulges = found.distance() > far.min(BULGE * shape.sizes[k]) && shape.normals[k].dot(n) > AGREES;
            bulges.then_some((v, found.distance(), sample, n))
        };
        let wall = target.wall().len();
        let samples = (0..wall as u32).into_par_iter().step_by(wall.div_ceil(SAMPLES).max(1));
        let bulges: Vec<_> = samples.filter_map(bulge).collect();
        let mut farthest = vec![0f64; places.len()];
        for (v, distance, to, normal) in bulges {
            if let Ok(k) = places.binary_search_by_key(&v, |p| p.0)
                && distance > farthest[k]
            {
                farthest[k] = distance;
                places[k] = (v, to, normal);
            }
        }
    }

    /// The longest side of the boundary faces at each vertex.
    fn sizes(&self, points: &[DVec3]) -> Vec<f64> {
        let mut sizes = vec![0f64; points.len()];
        for q in &self.quads {
            let longest =
                (0..4).map(|k| points[q[k] as usize].distance(points[q[(k + 1) % 4] as usize])).fold(0.0, f64::max);
            q.iter().for_each(|&v| sizes[v as usize] = sizes[v as usize].max(longest));
        }
        sizes
    }
}

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
struct Sliding<'a> {
    skin: &'a Skin,
    target: &'a Target<'a>,
    shape: Shape,
    /// Vertices that are on the surface, or are to be put there.
    placed: Vec<bool>,
    /// The surface's normal at wall vertices that are on it.
    under: Vec<Option<DVec3>>,
    /// Vertices that belong where the surface is closest.
    at_closest: Vec<bool>,
}

impl<'a> Sliding<'a> {
    /// Of the `placed` vertices, all but the `stuck` ones are on the surface.
    fn new(points: &[DVec3], skin: &'a Skin, target: &'a Target<'a>, placed: Vec<bool>, stuck: &[u32]) -> Self {
        let mut is_on: Vec<bool> = (0..points.len()).map(|v| placed[v] && skin.parts[v] == Part::Wall).collect();
        stuck.iter().for_each(|&v| is_on[v as usize] = false);
        let normal = |(p, is_on): (&DVec3, &bool)| is_on.then(|| target.closest_wall(*p).map(|c| c.1)).flatten();
        let under = points.par_iter().zip(&is_on).map(normal).collect();
        Sliding { skin, target, shape: skin.shape(points), placed, under, at_closest: vec![false; points.len()] }
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
        let (to, normal) = self.place(v, at);
        springs_to(self.target, self.skin.parts[v], vertex, to, normal, SLIDING[0], SLIDING[1]).collect()
    }

    /// What could not be put onto the surface stays as near as it is.
    fn is_fixed(&self, vertex: u32) -> bool {
        self.skin.has(vertex as usize) && !self.placed[vertex as usize]
    }

    fn settled(&self, vertex: u32, at: DVec3) -> Option<DVec3> {
        let v = vertex as usize;
        self.placed[v].then(|| {
            let to = self.place(v, at).0;
            if self.skin.parts[v] == Part::Wall { self.target.closest_wall(to).map_or(to, |c| c.0) } else { to }
        })
    }
}

/// Lets boundary vertices slide where cells are poor. `free` are those that are inside or could not be put onto the surface.
pub fn slide(
    points: &mut [DVec3],
    hexes: &[[u32; 8]],
    skin: &Skin,
    target: &Target,
    free: &[bool],
    context: &Context,
) -> Result<()> {
    let placed: Vec<bool> = (0..points.len()).map(|v| skin.has(v) && !free[v]).collect();
    relieve(points, hexes, &Sliding::new(points, skin, target, placed, &[]), context)
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
    let (at_closest, singly) = (where_to != Seat::Own, where_to == Seat::Singly);
    let vertices = 0..points.len();
    let stuck: Vec<u32> = (0..points.len() as u32).filter(|&v| free[v as usize] && skin.has(v as usize)).collect();
    let mut sliding = Sliding::new(points, skin, target, vertices.clone().map(|v| skin.has(v)).collect(), &stuck);
    for &v in &stuck {
        sliding.at_closest[v as usize] = at_closest && skin.parts[v as usize] == Part::Wall;
        sliding.placed[v as usize] = !singly;
    }
    for group in stuck.chunks(if singly { 1 } else { stuck.len().max(1) }) {
        group.iter().for_each(|&v| sliding.placed[v as usize] = true);
        let seated = optimise::seat(points, hexes, &sliding, group, context)?;
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
    skin.swell(points, target, &mut places);
    let mut goes = vec![true; points.len()];
    for _ in 0..ROUNDS {
        for &(v, to, _) in &places {
            points[v as usize] = if goes[v as usize] { to } else { start[v as usize] };
        }
        let weak = optimiser.weak(points, &floors);
        if weak.is_empty() {
            break;
        }
        weak.iter().flat_map(|&h| optimiser.corners_of(h)).for_each(|&v| goes[v as usize] = false);
    }
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

    /// Faces that span a fork face another way than the surface under their corners: a vertex stays where it is, and slides from
    /// there, though by the faces alone it belongs on the other side.
    #[test]
    fn a_vertex_slides_from_where_it_is() {
        let (closed, _) = skeleton::prepared(&sphere(4), &Context::new()).unwrap();
        let target = Target::new(&closed);
        let (here, across) = (target.closest_wall(DVec3::Z).unwrap(), -DVec3::Z);
        assert!(target.on_wall(here.0, across, 4.0).0.z < -0.9);
        let along = |p: DVec3| target.along_wall(p, [across, here.1], 4.0).unwrap().0;
        assert!(along(here.0).distance(here.0) < 1e-12);
        let beside = along(here.0 + DVec3::X * 0.1);
        assert!(beside.x > 0.05 && beside.z > 0.9, "{beside}");
        assert!(target.along_wall(DVec3::Z * 9.0, [across, here.1], 4.0).is_none());
    }

    /// A vertex in a long body looks ahead, a little upward: the flank above it is nearer, but faces aside.
    #[test]
    fn by_facing_a_vertex_goes_ahead_not_aside() {
        let ball = sphere(4);
        let points = ball.points().iter().map(|p| DVec3::new(4.0 * p.x, p.y, p.z)).collect();
        let long = SurfaceMesh::from_triangles(points, &ball.faces().fan().0).unwrap();
        let (closed, _) = skeleton::prepared(&long, &Context::new()).unwrap();
        let (p, n) = (DVec3::new(1.5, 0.4, 0.0), DVec3::new(0.95, 0.31, 0.0).normalize());
        let near = Target::new(&closed).on_wall(p, n, 5.0).0;
        let ahead = Target::new(&closed).by_facing().on_wall(p, n, 5.0).0;
        assert!(near.x < 1.8 && ahead.x > 2.3, "{near} {ahead}");
        assert!([near, ahead].iter().all(|q| ((q.x / 4.0).powi(2) + q.y * q.y + q.z * q.z - 1.0).abs() < 0.02));
    }
}
