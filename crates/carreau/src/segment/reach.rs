//! Neighbourhoods of facets: what a hypothesis is fitted to.

use super::facets::Facets;
use super::surface::Surface;
use crate::mesh::NONE;
use glam::DVec3;

/// A share of its longest side from which a side of a facet is long, because strips may taper.
const LONG_SIDE: f64 = 0.4;
/// Cosine of 30°: sides that turn by no more from one strip to the next are along each other, because those of a cone turn as it
/// does, and the others are across.
const ALONG_COS: f64 = 0.866;
/// A factor: a facet of this many times the triangles of the seed is a plane beside it, because facets of one surface are about
/// alike.
const LARGE_FACTOR: usize = 4;

/// Which neighbours a neighbourhood takes in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reach {
    All,
    /// Beyond the longer sides: of a strip the next strips, not what it ends at.
    Sideways,
    /// Beyond the sides along the longest one. The strips of a short cylinder are wider than long, and what it ends at may bend by no
    /// more than they do.
    Row,
    /// Beyond the sides across the longest one.
    Column,
}

/// The free facets of a search.
pub struct Around<'a> {
    pub surface: &'a Surface<'a>,
    pub facets: &'a Facets,
    /// Surface of every facet that has one.
    pub owner: &'a [u32],
    /// Edges that bend by more are not crossed, in radians.
    pub bend: f64,
}

/// A growing neighbourhood.
pub struct Patch {
    pub facets: Vec<u32>,
    /// Direction of the sides that each of them was reached by; that of the seed is given.
    along: Vec<DVec3>,
    reach: Reach,
    /// Most triangles of a facet.
    most: usize,
}

impl Patch {
    pub fn new(around: &Around<'_>, seed: u32, reach: Reach) -> Self {
        let along = vec![around.direction(seed, reach == Reach::Column)];
        let most = LARGE_FACTOR * around.facets.triangles(seed).len().max(1);
        Patch { facets: vec![seed], along, reach, most }
    }
}

impl Around<'_> {
    /// Adds one more ring; whether there was any.
    pub fn grow(&self, patch: &mut Patch) -> bool {
        let from = patch.facets.len();
        let mut ring = Vec::new();
        for k in 0..from {
            self.beyond(patch.facets[k], patch.reach, patch.along[k], &mut ring);
            for &(g, side) in &ring {
                if self.facets.triangles(g).len() <= patch.most && !patch.facets.contains(&g) {
                    patch.facets.push(g);
                    patch.along.push(side);
                }
            }
        }
        patch.facets.len() > from
    }

    /// All free facets beside a facet.
    pub fn all(&self, f: u32, out: &mut Vec<u32>) {
        out.clear();
        self.sides(f, |_, g| {
            if !out.contains(&g) {
                out.push(g);
            }
        });
    }

    /// The facets that are reached from a facet, and by which sides.
    fn beyond(&self, f: u32, reach: Reach, along: DVec3, out: &mut Vec<(u32, DVec3)>) {
        out.clear();
        let least = if reach == Reach::Sideways { LONG_SIDE * self.longest(f).length() } else { 0.0 };
        self.sides(f, |side, g| {
            let reached = match reach {
                Reach::All => true,
                Reach::Sideways => side.length() >= least,
                Reach::Row | Reach::Column => side.normalize_or_zero().dot(along).abs() > ALONG_COS,
            };
            if reached {
                out.push((g, side.normalize_or_zero()));
            }
        });
    }

    /// Visits the sides of a facet that bend by no more than a surface may and the free facets beyond.
    fn sides(&self, f: u32, mut visit: impl FnMut(DVec3, u32)) {
        let t = self.surface.triangles;
        for c in self.facets.triangles(f).iter().flat_map(|&k| 3 * k..3 * k + 3) {
            let o = t.opposite(c);
            if o == NONE || f64::from(self.surface.bend[c as usize]) > self.bend {
                continue;
            }
            let g = self.facets.of[o as usize / 3];
            if g != f && g != NONE && self.owner[g as usize] == NONE {
                visit(t.point(t.next(c)) - t.point(c), g);
            }
        }
    }

    /// The outer sides of a facet.
    fn outline(&self, f: u32) -> impl Iterator<Item = DVec3> {
        let t = self.surface.triangles;
        let outer = move |c: &u32| t.opposite(*c) == NONE || self.facets.of[t.opposite(*c) as usize / 3] != f;
        let corners = self.facets.triangles(f).iter().flat_map(|&k| 3 * k..3 * k + 3);
        corners.filter(outer).map(move |c| t.point(t.next(c)) - t.point(c))
    }

    fn longest(&self, f: u32) -> DVec3 {
        self.outline(f).max_by(|a, b| a.length().total_cmp(&b.length())).unwrap_or_default()
    }

    /// The direction of the longest side of a facet, or that of the side most across it.
    fn direction(&self, f: u32, across: bool) -> DVec3 {
        let longest = self.longest(f).normalize_or_zero();
        let angle = |side: &DVec3| side.dot(longest).abs();
        let others = self.outline(f).map(DVec3::normalize_or_zero);
        if across { others.min_by(|a, b| angle(a).total_cmp(&angle(b))).unwrap_or_default() } else { longest }
    }
}
