//! Boundary vertices that slide on the surface while the mesh gets better.

use crate::hex::boundary::{Shape, Skin};
use crate::hex::optimise::{Spring, Ties};
use crate::hex::ridges;
use crate::hex::target::{Part, Target};
use glam::DVec3;
use rayon::prelude::*;
use rustc_hash::FxHashMap;

/// Strength of the springs to the surface along its normal, and across, while poor cells are improved.
pub const SLIDING: [f64; 2] = [1000.0, 1e-3];

/// The boundary slides along the surface.
pub struct Sliding<'a> {
    pub(super) skin: &'a Skin,
    pub(super) target: &'a Target<'a>,
    pub(super) shape: Shape,
    /// Vertices that are on the surface, or are to be put there.
    pub(super) placed: Vec<bool>,
    /// The surface's normal at wall vertices that are on it.
    pub(super) under: Vec<Option<DVec3>>,
    /// Vertices that belong where the surface is closest.
    pub(super) at_closest: Vec<bool>,
    /// Vertices that belong to one place, and the normal there.
    pub(super) pinned: FxHashMap<u32, (DVec3, DVec3)>,
    /// Where each vertex was, and the directions in which it is held there; empty where all are free.
    pub(super) held: Vec<(DVec3, [DVec3; 2])>,
}

impl<'a> Sliding<'a> {
    /// Of the `placed` vertices, all but the `stuck` ones are on the surface.
    pub(super) fn new(
        points: &[DVec3],
        skin: &'a Skin,
        target: &'a Target<'a>,
        placed: Vec<bool>,
        stuck: &[u32],
    ) -> Self {
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
    pub(super) fn on_ridges(self, points: &[DVec3]) -> Self {
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

    pub(super) fn place(&self, v: usize, at: DVec3) -> (DVec3, DVec3) {
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

/// What pulls a boundary vertex to its place.
pub fn springs_to(
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
