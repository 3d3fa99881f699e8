//! Creases at the size of elements: what is a feature of a scan, where every angle is noise to some degree.
//!
//! ```text
//!                 b                   The mean normals of both sides of an edge, over a width w and over twice
//!      ╲          │          ╱        that. A crease turns as much over w as over 2 w; a surface that bends
//!       ╲   2w   w│w   2w   ╱         turns in proportion to the width, and noise turns nowhere.
//!        ╲        │        ╱
//!         ╲       a       ╱           turn at width 0 ≈ 2 turn(w) − turn(2 w)
//! ```
//!
//! 1. **Noise** is measured: free tips of the sharp edges over their length. On parts ridges end at each other, and every
//!    sharp edge is a feature. Only where many hang loose the rest is done.
//! 2. Sharp edges are creases where the surface turns by more than the angle over the width of an element, and at the edge.
//! 3. **Hysteresis**: weaker edges bridge the gaps between strands.
//! 4. Strands with free tips that are shorter than two elements for every tip are dropped, and jagged ones, whatever their
//!    length. Loops stay, and strands that end at corners or at each other.

use super::DroppedStrand;
use super::marked::{Features, length_of_squares, sides};
use super::network::Network;
use super::noise::Noise;
use crate::context::Context;
use crate::error::Result;
use crate::geometry::normals::{angle_between, unit};
use crate::mesh::{CornerId, FaceId, NONE, SurfaceMesh, area_vector};
use glam::DVec3;
use rayon::prelude::*;
use std::collections::VecDeque;

/// Number of squares that cover the surface where elements have the usual size.
pub const USUAL_ELEMENTS: f64 = 3000.0;
/// Edges above this share of the angle continue a strand.
const WEAK_SHARE: f64 = 0.5;
/// The surface turns by more than this share of the angle along them.
const WEAK_TURN_SHARE: f64 = 0.7;
/// Least width in edges of the mesh: over fewer of them, noise would be measured.
const LEAST_EDGES: f64 = 2.0;
/// Elements that a strand is long for every free tip that it has.
const ELEMENTS_PER_TIP: f64 = 2.0;
/// Faces on one side of an edge that are looked at, the nearest first.
const MOST_FACES: usize = 2000;

/// What is looked at: the faces of a mesh.
struct Look<'a> {
    mesh: &'a SurfaceMesh,
    normals: &'a [DVec3],
    faces: Vec<Face>,
    /// The face across every half-edge, none across those that are sharp.
    across: Vec<u32>,
    size: f64,
}

/// A face: its centre, and its normal as long as its area.
struct Face {
    centre: DVec3,
    area_normal: DVec3,
}

/// Selects the creases among the edges above an angle. `fixed` half-edges are features in any case; `size` is the length of
/// the elements' edges.
pub fn select(
    mesh: &SurfaceMesh,
    normals: &[DVec3],
    [fixed, sharp]: [Vec<bool>; 2],
    angle_deg: f64,
    size: f64,
    context: &Context,
) -> Result<Features> {
    let angle = angle_deg.to_radians();
    let turn_at = |c: CornerId| {
        mesh.opposite(c).map_or(0.0, |o| {
            let [a, b] = sides(mesh, normals, c, o);
            angle_between(a, b)
        })
    };
    let is_first = |c: &CornerId| mesh.opposite(*c).is_none_or(|o| *c < o);
    let firsts: Vec<CornerId> = (0..mesh.corner_count()).map(CornerId::new).filter(is_first).collect();
    let turns: Vec<f64> = firsts.par_iter().with_min_len(1024).map(|&c| turn_at(c)).collect();
    let is_candidate = |c: CornerId, turn: f64| fixed[c.index()] || sharp[c.index()] || turn > WEAK_SHARE * angle;
    let corners: Vec<CornerId> =
        firsts.iter().zip(&turns).filter(|&(&c, &t)| is_candidate(c, t)).map(|(&c, _)| c).collect();
    let of = |flags: &[bool]| corners.iter().map(|c| flags[c.index()]).collect::<Vec<bool>>();
    let ends = corners.iter().map(|&c| [mesh.vertex(c).0, mesh.vertex(mesh.next(c)).0]).collect();
    let was: Vec<bool> = of(&fixed).into_iter().zip(of(&sharp)).map(|(fixed, sharp)| fixed || sharp).collect();
    let mut network = Network::new(mesh.points(), ends, of(&fixed), was.clone());
    let smooth = || firsts.iter().zip(&turns).filter(|(c, _)| !fixed[c.index()] && !sharp[c.index()]).map(|(_, t)| *t);
    let noise = noise(&network, smooth(), length_of_squares(mesh, USUAL_ELEMENTS));
    if noise.is_high() {
        let barrier: Vec<bool> = fixed.iter().zip(&sharp).map(|(fixed, sharp)| *fixed || *sharp).collect();
        let look = Look::new(mesh, normals, &barrier, size);
        choose(&look, &mut network, &corners, angle, context)?;
    }
    let longest_dropped = network.longest_dropped(&was).map(|(length, place)| DroppedStrand { length, place });
    let mut out = Features { corners: fixed, longest_dropped, noise, ..Features::default() };
    for (e, &c) in network.edges().zip(&corners) {
        if network.is_kept(e) {
            [Some(c), mesh.opposite(c)].into_iter().flatten().for_each(|c| out.corners[c.index()] = true);
        } else if was[e as usize] {
            out.dropped.push(c);
        }
    }
    Ok(out)
}

/// Tips and pieces of what is sharp, and the spread of the angles elsewhere.
fn noise(network: &Network, smooth: impl Iterator<Item = f64>, usual: f64) -> Noise {
    let (tips, length) = network.tips();
    let share = |count: usize| if length > 0.0 { count as f64 * usual / length } else { 0.0 };
    let (sum, count) = smooth.fold((0.0, 0usize), |(sum, count), turn| (sum + turn * turn, count + 1));
    let spread_deg = (sum / count.max(1) as f64).sqrt().to_degrees();
    Noise { tips: share(tips), pieces: share(network.pieces()), spread_deg }
}

/// Stages 2 to 4.
fn choose(look: &Look, network: &mut Network, corners: &[CornerId], angle: f64, context: &Context) -> Result<()> {
    let faces = look.mesh.face_count();
    // What is too short with all that might continue it needs no look.
    let may_stay = network.may_stay(ELEMENTS_PER_TIP * look.size);
    let of = |visited: &mut Visited, e: u32| {
        context.check_every(16 * e as usize)?;
        let is_open = network.is_kept(e) && may_stay[e as usize];
        Ok(network.is_fixed(e) || is_open && look.is_crease(corners[e as usize], angle, visited))
    };
    let new = || Visited::new(faces);
    let keeps: Vec<bool> = network.edges().into_par_iter().with_min_len(64).map_init(new, of).collect::<Result<_>>()?;
    network.keep_only(&keeps);
    let (mut visited, mut step) = (new(), 0);
    network.bridge(|e| {
        step += 1;
        context.check_every(64 * step)?;
        Ok(look.is_crease(corners[e as usize], WEAK_TURN_SHARE * angle, &mut visited))
    })?;
    network.prune(ELEMENTS_PER_TIP * look.size);
    network.drop_jagged();
    Ok(())
}

/// The faces that were looked at from an edge, without a list to clear.
struct Visited {
    stamp: Vec<u32>,
    round: u32,
    queue: VecDeque<u32>,
}

impl Visited {
    fn new(faces: usize) -> Self {
        Visited { stamp: vec![0; faces], round: 0, queue: VecDeque::new() }
    }

    fn begin(&mut self, face: u32) {
        self.round += 1;
        self.queue.clear();
        self.add(face);
    }

    fn has(&self, face: u32) -> bool {
        self.stamp[face as usize] == self.round
    }

    fn add(&mut self, face: u32) {
        self.stamp[face as usize] = self.round;
        self.queue.push_back(face);
    }
}

impl<'a> Look<'a> {
    fn new(mesh: &'a SurfaceMesh, normals: &'a [DVec3], barrier: &[bool], size: f64) -> Self {
        let face = |(face, normal): (&[u32], &DVec3)| Face {
            centre: face.iter().map(|&v| mesh.points()[v as usize]).sum::<DVec3>() / face.len().max(1) as f64,
            area_normal: area_vector(mesh.points(), face).length() * *normal,
        };
        let faces = mesh.faces().iter().zip(normals).map(face).collect();
        let next = |c: CornerId| mesh.opposite(c).filter(|_| !barrier[c.index()]).map_or(NONE, |o| mesh.face_of(o).0);
        let across = (0..mesh.corner_count()).map(CornerId::new).map(next).collect();
        Look { mesh, normals, faces, across, size }
    }

    /// Whether the surface turns by more than an angle over the width of an element, and does so at this edge.
    fn is_crease(&self, c: CornerId, angle: f64, visited: &mut Visited) -> bool {
        let Some(o) = self.mesh.opposite(c) else { return true };
        let width = self.size.max(LEAST_EDGES * self.edge_length(c, o));
        let mut turn = |width: f64| {
            let [own, other] = [c, o].map(|c| self.side(c, width, visited));
            angle_between(own, other)
        };
        let near = turn(width);
        // What is farther is looked at only where it matters: it costs most.
        near > angle && 2.0 * near - turn(2.0 * width) > angle
    }

    /// Mean length of the edges of both faces.
    fn edge_length(&self, c: CornerId, o: CornerId) -> f64 {
        let mesh = self.mesh;
        let all = [c, o].into_iter().flat_map(|c| mesh.corners(mesh.face_of(c)));
        let length = |c: CornerId| mesh.point(mesh.vertex(c)).distance(mesh.point(mesh.vertex(mesh.next(c))));
        let (sum, count) = all.fold((0.0, 0.0), |(sum, count), c| (sum + length(c), count + 1.0));
        sum / f64::max(count, 1.0)
    }

    /// Mean normal of one side of an edge over a width: of the faces that are reached without crossing a sharp edge or the
    /// plane that stands on this one.
    fn side(&self, c: CornerId, width: f64, visited: &mut Visited) -> DVec3 {
        let mesh = self.mesh;
        let [a, b] = [c, mesh.next(c)].map(|c| mesh.point(mesh.vertex(c)));
        let (middle, first) = (0.5 * (a + b), mesh.face_of(c));
        let other = mesh.opposite(c).map_or(first, |o| mesh.face_of(o));
        let upright = self.normals[first.index()] + self.normals[other.index()];
        let inward = upright.cross(b - a);
        let inward = if inward.dot(self.faces[first.index()].centre - middle) < 0.0 { -inward } else { inward };
        visited.begin(first.0);
        let (mut sum, mut count) = (DVec3::ZERO, 0);
        while let Some(f) = visited.queue.pop_front() {
            sum += self.faces[f as usize].area_normal;
            count += 1;
            if count >= MOST_FACES {
                break;
            }
            for corner in mesh.corners(FaceId(f)) {
                let next = self.across[corner.index()];
                if next == NONE || visited.has(next) {
                    continue;
                }
                let way = self.faces[next as usize].centre - middle;
                if way.length_squared() <= width * width && way.dot(inward) > 0.0 {
                    visited.add(next);
                }
            }
        }
        unit(sum)
    }
}
