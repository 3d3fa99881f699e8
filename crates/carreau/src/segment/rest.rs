//! What is left beside the surfaces of a part: strips and pieces that belong to it are freed, and the rest gets labels of its own.

use super::facets::Facets;
use super::regions::{Groups, count, fit_region};
use super::strips::{fragments, rows};
use super::surface::{Surface, quantile};
use super::surfaces::{COARSEST_BEND, NORMAL_NOISE, Surfaces};
use crate::geometry::normals::angle_between;
use crate::geometry::primitive::Kind;
use crate::mesh::NONE;
use rustc_hash::FxHashMap;

/// A share of the edges inside a freeform surface that bend by less than its sharp angle, because the rest may be edges
/// of the part.
const USUAL_SHARE: f64 = 0.9;
/// A factor: the sharp angle of a freeform surface over that bend, because some of its edges bend by a little more.
const BEND_FACTOR: f64 = 1.3;
/// A count: half-edges of a free surface below which that says nothing, because a quantile of fewer is chance.
const FEW_EDGES: usize = 40;
/// Radians, 6°: strips of a curved surface bend by no more, because planes that bend more are the sides of a prism.
const STRIP_BEND: f64 = 0.105;
/// A count: rounds of freeing fragments of strips, because what is freed makes fragments of planes beside it.
const FRAGMENT_ROUNDS: usize = 4;
/// A count: free pieces of no more directions are planes that meet, because the coarsest freeform surface has more.
const WEDGE_SIDES: usize = 3;
/// A count: free pieces of no more triangles are none of their own, because they say nothing about a surface.
const FREE_CRUMB: u32 = 4;
/// A share of its border: a weak surface with more towards free ones is a piece of them, because the blends of a part lie between
/// its other faces.
const FREE_BORDER: f64 = 0.5;

impl Surfaces {
    /// Frees strips beside a free surface that bends as much in itself as it does towards them: they are a part of it. A
    /// single triangle is on a plane of its own anyway, which says nothing.
    pub fn release(&mut self, surface: &Surface<'_>, facets: &Facets, mut strips: Vec<u32>, sharp_angle: f64) {
        let t = surface.triangles;
        let limit = self.free_sharp_angle(surface, sharp_angle);
        loop {
            let belongs = |f: &u32| {
                let limit = if facets.triangles(*f).len() == 1 { limit.max(COARSEST_BEND) } else { limit };
                facets.triangles(*f).iter().flat_map(|&k| 3 * k..3 * k + 3).any(|c| {
                    let o = t.opposite(c);
                    o != NONE && self.label[o as usize / 3] == NONE && f64::from(surface.bend[c as usize]) <= limit
                })
            };
            let (freed, kept): (Vec<u32>, Vec<u32>) = strips.into_iter().partition(belongs);
            if freed.is_empty() {
                return;
            }
            freed.iter().flat_map(|&f| facets.triangles(f)).for_each(|&k| self.label[k as usize] = NONE);
            strips = kept;
        }
    }

    /// Frees the flat strips of curved surfaces that were subdivided.
    pub fn free_strips(&mut self, surface: &Surface<'_>, sharp_angle: f64) {
        let is_plane: Vec<bool> = self.primitives.iter().map(|p| p.kind() == Kind::Plane).collect();
        let bends = NORMAL_NOISE..STRIP_BEND.min(sharp_angle);
        let free = |label: &mut [u32], gone: Vec<bool>| {
            let old = label.iter_mut().filter(|l| **l != NONE && gone[**l as usize]);
            old.map(|l| *l = NONE).count() > 0
        };
        let found = rows(surface, &self.label, &is_plane, &bends);
        free(&mut self.label, found);
        // Fragments that are free make others free.
        for _ in 0..FRAGMENT_ROUNDS {
            let found = fragments(surface, &self.label, &is_plane, &bends);
            if !free(&mut self.label, found) {
                return;
            }
        }
    }

    /// Frees weak surfaces with most of their border towards free ones, one after the other: those between the faces of a
    /// part are blends, the others are pieces of what is around them.
    pub fn free_weak(&mut self, surface: &Surface<'_>) {
        let t = surface.triangles;
        let groups = Groups::new(&self.label, self.primitives.len());
        let mut weak = std::mem::take(&mut self.weak);
        loop {
            let is_piece = |l: &u32| {
                let (mut free, mut all) = (0.0, 0.0);
                for c in groups.of(*l).iter().flat_map(|&k| 3 * k..3 * k + 3) {
                    let beyond = if t.opposite(c) == NONE { *l } else { self.label[t.opposite(c) as usize / 3] };
                    let length = if beyond == *l { 0.0 } else { surface.edge_length(c) };
                    all += length;
                    free += if beyond == NONE { length } else { 0.0 };
                }
                free > FREE_BORDER * all
            };
            let (pieces, kept): (Vec<u32>, Vec<u32>) = weak.iter().partition(|l| is_piece(l));
            if pieces.is_empty() {
                return;
            }
            pieces.iter().flat_map(|&l| groups.of(l)).for_each(|&k| self.label[k as usize] = NONE);
            weak = kept;
        }
    }

    /// Bends above this are sharp on the free surface, in radians: the sharp angle adapts to how much it bends between its
    /// triangles.
    fn free_sharp_angle(&self, surface: &Surface<'_>, sharp_angle: f64) -> f64 {
        let t = surface.triangles;
        let free = |k: u32| self.label[k as usize] == NONE;
        let inner = |c: &u32| t.opposite(*c) != NONE && free(*c / 3) && free(t.opposite(*c) / 3);
        let mut bends: Vec<f32> =
            (0..3 * surface.len() as u32).filter(inner).map(|c| surface.bend[c as usize]).collect();
        let typical = 3.0 * quantile(&mut bends, 0.5, f32::total_cmp).map_or(0.0, f64::from);
        let most = BEND_FACTOR * quantile(&mut bends, USUAL_SHARE, f32::total_cmp).map_or(0.0, f64::from);
        // A few edges have no distribution.
        let limit = if bends.len() < FEW_EDGES { typical } else { typical.max(most) };
        limit.max(sharp_angle).min(COARSEST_BEND.max(sharp_angle))
    }

    /// Labels for what is left: connected free triangles between sharp edges, where the sharp angle adapts to how much the
    /// free surface bends between its triangles. Single crumbs go to the free region beside them.
    pub fn complete(&self, surface: &Surface<'_>, order: &[u32], sharp_angle: f64) -> Vec<u32> {
        let limit = self.free_sharp_angle(surface, sharp_angle);
        let mut label = self.label.clone();
        let open = |c: u32| f64::from(surface.bend[c as usize]) <= limit;
        surface.flood(order, &mut label, self.primitives.len() as u32, open, |_, _| ());
        dissolve_crumbs(surface, &mut label, self.primitives.len() as u32);
        divide_wedges(surface, &mut label, self.primitives.len() as u32, self.tolerance);
        label
    }
}

/// Gives free pieces of a few triangles to the larger free piece that they have the longest boundary with, where the mesh
/// bends no more than a coarse surface does. Labels from `first_free` on are free.
fn dissolve_crumbs(surface: &Surface<'_>, label: &mut [u32], first_free: u32) {
    const ROUNDS: usize = 8;
    let t = surface.triangles;
    for _ in 0..ROUNDS {
        let count = count(label);
        let mut size = vec![0u32; count];
        label.iter().for_each(|&l| size[l as usize] += 1);
        let crumb = |l: u32| l >= first_free && size[l as usize] <= FREE_CRUMB;
        let larger = |a: u32, b: u32| b >= first_free && (size[b as usize], b) > (size[a as usize], a);
        let mut common: FxHashMap<(u32, u32), f64> = FxHashMap::default();
        for c in 0..3 * surface.len() as u32 {
            let o = t.opposite(c);
            if o == NONE || f64::from(surface.bend[c as usize]) > COARSEST_BEND {
                continue;
            }
            let (a, b) = (label[c as usize / 3], label[o as usize / 3]);
            if a != b && crumb(a) && larger(a, b) {
                *common.entry((a, b)).or_default() += surface.edge_length(c);
            }
        }
        if common.is_empty() {
            return;
        }
        let mut pairs: Vec<((u32, u32), f64)> = common.into_iter().collect();
        pairs.sort_by(|x, y| x.0.0.cmp(&y.0.0).then(y.1.total_cmp(&x.1)).then(x.0.1.cmp(&y.0.1)));
        let mut into: Vec<u32> = (0..count as u32).collect();
        for group in pairs.chunk_by(|x, y| x.0.0 == y.0.0) {
            let ((crumb, home), _) = group[0];
            into[crumb as usize] = home;
        }
        label.iter_mut().for_each(|l| *l = into[*l as usize]);
    }
}

/// Divides free pieces of a few flat facets: planes that meet, unless three are strips of a curved surface.
fn divide_wedges(surface: &Surface<'_>, label: &mut [u32], first_free: u32, tolerance: f64) {
    let groups = Groups::new(label, count(label));
    let count = groups.len() as u32;
    let flat = |a: u32, b: u32| angle_between(surface.normals[a as usize], surface.normals[b as usize]) <= NORMAL_NOISE;
    let mut next = count;
    for l in first_free..count {
        let mut sides: Vec<Vec<u32>> = Vec::new();
        for &k in groups.of(l) {
            match sides.iter_mut().find(|side| flat(side[0], k)) {
                Some(side) => side.push(k),
                None => sides.push(vec![k]),
            }
            if sides.len() > WEDGE_SIDES {
                break;
            }
        }
        // A single triangle is a crumb.
        if sides.len() > WEDGE_SIDES || sides.iter().any(|side| side.len() < 2) {
            continue;
        }
        // Two strips are on a cylinder in any case, three on a torus.
        let kinds = [Kind::Cylinder, Kind::Cone];
        if sides.len() > 2 && fit_region(surface, groups.of(l), tolerance, &kinds).is_some() {
            continue;
        }
        for side in sides.iter().skip(1) {
            side.iter().for_each(|&k| label[k as usize] = next);
            next += 1;
        }
    }
}
