//! Ridges, borders and other curves that stay: chains of source edges between corners, parametrised by arc length.
//!
//! A corner is a vertex where other than two curve edges meet, or where a curve turns sharply. Ridges are read vertex by
//! vertex: they come from CAD models, whose every corner counts. Borders of scans are ragged, and at that scale every
//! vertex would be a corner; they are read at the scale of the size map: the turn is that between the chords to the points
//! one size before and behind.

mod chain;

use crate::geometry::normals::{angle_between, unit};
use crate::mesh::{EditMesh, NONE, triangle_area_vector};
use chain::circumradius;
use glam::DVec3;

pub use chain::{Chain, Kind, Rank};

/// A turn above this makes a corner of a ridge. Below the 45° that are commonly asked for, so that no rounding decides.
pub const RIDGE_TURN_DEG: f64 = 40.0;
/// The same for borders, at the scale of the size map.
const BORDER_TURN_DEG: f64 = 60.0;

/// They are read over no more than this share of a closed border: half a side of a square.
const LOOP_SHARE: f64 = 0.125;

/// Readings of the radius of a border, each at the size that the one before asks for.
const READINGS: usize = 8;
/// How far the points of a reading are, in sizes.
const REACH: f64 = 1.5;

/// All curves of a source mesh.
#[derive(Debug, Clone, Default)]
pub struct Curves {
    pub chains: Vec<Chain>,
    pub rank: Vec<Rank>,
    /// Parameter of every vertex of rank [`Rank::Curve`] on its chain.
    pub parameter: Vec<f64>,
    /// Corners off curves.
    pub tips: Vec<u32>,
}

/// The curve edges of a mesh before they are traced: kind per half-edge.
pub type Marks = Vec<Option<Kind>>;

impl Curves {
    /// Traces the marked edges; writes the chain of every curve edge into the mesh. `size` is the scale at which borders
    /// are read, per vertex.
    pub fn trace(mesh: &mut EditMesh, marks: &Marks, size: &[f64]) -> Curves {
        let mut tracer = Tracer::new(mesh, marks);
        tracer.find_corners(mesh, size);
        let mut curves = Curves {
            chains: Vec::new(),
            rank: tracer.rank.clone(),
            parameter: vec![0.0; mesh.vertex_slots() as usize],
            tips: Vec::new(),
        };
        // From corners first; what is left then is closed.
        for pass in 0..2 {
            for v in 0..mesh.vertex_slots() {
                if pass == 0 && curves.rank[v as usize] != Rank::Corner {
                    continue;
                }
                for k in tracer.first[v as usize]..tracer.first[v as usize + 1] {
                    if let Some(chain) = tracer.follow(mesh, v, k as usize) {
                        curves.add(mesh, chain);
                    }
                }
            }
        }
        curves
    }

    /// Tells for every ridge whether all its edges have an angle above a limit with the given cosine, or none.
    pub fn find_sharp(&mut self, mesh: &EditMesh, cosine: f64) {
        let normal = |h: u32| {
            let [a, b, c] = mesh.positions(h / 3);
            unit(triangle_area_vector(a, b, c))
        };
        for chain in self.chains.iter_mut().filter(|c| c.kind == Kind::Ridge) {
            let is_sharp = |s: &[u32; 2]| s[0] != NONE && s[1] != NONE && normal(s[0]).dot(normal(s[1])) < cosine;
            chain.sharp = chain.sides.iter().all(is_sharp);
            chain.smooth = !chain.sides.iter().any(is_sharp);
        }
    }

    /// Radius of curvature of the curves at every vertex, infinite where there is none: that of the circle through the
    /// vertex and its two neighbours. Borders are ragged: there the circle goes through the points one and a half sizes away,
    /// `alpha` times the radius, as long as that makes it larger.
    pub fn radii(&self, alpha: f64) -> Vec<f64> {
        let mut radius = vec![f64::INFINITY; self.rank.len()];
        for chain in self.chains.iter().filter(|c| c.kind != Kind::Seam) {
            let last = chain.points.len() - 1;
            let inner = if chain.closed { 0..last } else { 1..last };
            // No closed curve turns by less than once.
            let widest = if chain.closed { chain.length() / std::f64::consts::TAU } else { f64::INFINITY };
            for k in inner {
                let (before, after) = (if k == 0 { last - 1 } else { k - 1 }, k + 1);
                let mut r = circumradius(chain.points[before], chain.points[k], chain.points[after]);
                if chain.kind == Kind::Border {
                    for _ in 0..READINGS {
                        match chain.radius_at(k, REACH * alpha * r) {
                            Some(wider) if wider > r => r = wider,
                            _ => break,
                        }
                    }
                }
                let at = &mut radius[chain.vertices[k] as usize];
                *at = at.min(r).min(widest);
            }
        }
        radius
    }

    fn add(&mut self, mesh: &mut EditMesh, chain: Chain) {
        let id = self.chains.len() as u32;
        for (k, &v) in chain.vertices.iter().enumerate() {
            if self.rank[v as usize] == Rank::Curve && !(chain.closed && k + 1 == chain.vertices.len()) {
                self.parameter[v as usize] = chain.arc[k];
            }
        }
        for sides in &chain.sides {
            sides.iter().filter(|&&h| h != NONE).for_each(|&h| mesh.set_curve(h, id));
        }
        self.chains.push(chain);
    }
}

/// An end of a curve edge as seen from one of its vertices.
#[derive(Clone, Copy)]
struct End {
    to: u32,
    /// The half-edges there and back.
    sides: [u32; 2],
    kind: Kind,
}

/// Curve edges by vertex.
struct Tracer {
    first: Vec<u32>,
    ends: Vec<End>,
    used: Vec<bool>,
    rank: Vec<Rank>,
}

impl Tracer {
    fn new(mesh: &EditMesh, marks: &Marks) -> Self {
        let n = mesh.vertex_slots() as usize;
        let marked = || mesh.edges().filter_map(|h| marks[h as usize].map(|kind| (h, kind)));
        let mut first = vec![0u32; n + 1];
        for (h, _) in marked() {
            first[mesh.vertex(h) as usize + 1] += 1;
            first[mesh.head(h) as usize + 1] += 1;
        }
        for k in 1..first.len() {
            first[k] += first[k - 1];
        }
        let mut fill = first.clone();
        let nothing = End { to: NONE, sides: [NONE; 2], kind: Kind::Ridge };
        let mut ends = vec![nothing; first[n] as usize];
        for (h, kind) in marked() {
            let o = mesh.opposite(h);
            for (v, to, sides) in [(mesh.vertex(h), mesh.head(h), [h, o]), (mesh.head(h), mesh.vertex(h), [o, h])] {
                ends[fill[v as usize] as usize] = End { to, sides, kind };
                fill[v as usize] += 1;
            }
        }
        let used = vec![false; ends.len()];
        Tracer { first, ends, used, rank: vec![Rank::Free; n] }
    }

    fn of(&self, v: u32) -> &[End] {
        &self.ends[self.first[v as usize] as usize..self.first[v as usize + 1] as usize]
    }

    fn find_corners(&mut self, mesh: &EditMesh, size: &[f64]) {
        for v in 0..mesh.vertex_slots() {
            self.rank[v as usize] = match self.of(v) {
                _ if mesh.is_copy(v) => Rank::Corner,
                [] => Rank::Free,
                [a, b] if a.kind == b.kind && matches!(a.kind, Kind::Ridge | Kind::Crease) => {
                    let p = |v: u32| mesh.points[v as usize];
                    let turn = angle_between(p(v) - p(a.to), p(b.to) - p(v));
                    if turn > RIDGE_TURN_DEG.to_radians() { Rank::Corner } else { Rank::Curve }
                }
                [a, b] if a.kind == b.kind && a.kind == Kind::Border => Rank::Curve,
                _ => Rank::Corner,
            };
        }
        self.find_border_corners(mesh, size);
    }

    /// Corners of borders: where the turn at the scale of the size map is above the limit, and largest nearby.
    fn find_border_corners(&mut self, mesh: &EditMesh, size: &[f64]) {
        let is_smooth_border =
            |v: u32| self.rank[v as usize] == Rank::Curve && self.of(v).first().is_some_and(|e| e.kind == Kind::Border);
        let smooth: Vec<u32> = (0..mesh.vertex_slots()).filter(|&v| is_smooth_border(v)).collect();
        let reach = self.reaches(mesh, &smooth, size);
        let mut turn = vec![0.0; self.rank.len()];
        for &v in &smooth {
            let reach = reach[v as usize];
            let [a, b] = [0, 1].map(|side| self.point_at(mesh, v, side, reach));
            let p = mesh.points[v as usize];
            turn[v as usize] = angle_between(p - a, b - p);
        }
        let limit = BORDER_TURN_DEG.to_radians();
        let mut corners = Vec::new();
        for v in smooth.into_iter().filter(|&v| turn[v as usize] > limit) {
            let reach = reach[v as usize];
            let own = (turn[v as usize], v);
            let mut largest = true;
            for side in 0..2 {
                self.walk(mesh, v, side, reach, |w, way| largest &= way > reach || (turn[w as usize], w) <= own);
            }
            if largest {
                corners.push(v);
            }
        }
        corners.into_iter().for_each(|v| self.rank[v as usize] = Rank::Corner);
    }

    /// How far to look from every vertex: a size, but no farther than to the next side of what is closed.
    fn reaches(&self, mesh: &EditMesh, smooth: &[u32], size: &[f64]) -> Vec<f64> {
        let mut reach = size.to_vec();
        let mut seen = vec![false; size.len()];
        for &v in smooth {
            if seen[v as usize] {
                continue;
            }
            // All of it: to the one side, and where that comes to an end, to the other.
            let (mut around, mut length) = (Vec::new(), 0.0);
            self.walk(mesh, v, 0, f64::INFINITY, |w, way| {
                around.push(w);
                length = way;
            });
            let is_closed = around.last() == Some(&v);
            if !is_closed {
                self.walk(mesh, v, 1, f64::INFINITY, |w, _| around.push(w));
            }
            for &w in &around {
                seen[w as usize] = true;
                if is_closed {
                    reach[w as usize] = reach[w as usize].min(LOOP_SHARE * length);
                }
            }
        }
        reach
    }

    /// Visits the vertices of a curve from `v` on one side, as far as the reach, corners included, with the way.
    fn walk(&self, mesh: &EditMesh, v: u32, side: usize, reach: f64, mut visit: impl FnMut(u32, f64)) {
        let Some(mut end) = self.of(v).get(side).copied() else { return };
        let (mut at, mut way) = (v, 0.0);
        loop {
            way += mesh.points[at as usize].distance(mesh.points[end.to as usize]);
            let before = at;
            at = end.to;
            visit(at, way);
            if way >= reach || at == v || self.rank[at as usize] == Rank::Corner {
                return;
            }
            match self.of(at).iter().find(|e| e.to != before) {
                Some(e) => end = *e,
                None => return,
            }
        }
    }

    /// The point at some way along the curve, or its end.
    fn point_at(&self, mesh: &EditMesh, v: u32, side: usize, reach: f64) -> DVec3 {
        let (mut last, mut before) = ((v, 0.0), (v, 0.0));
        self.walk(mesh, v, side, reach, |w, way| (before, last) = (last, (w, way)));
        let [p, q] = [before.0, last.0].map(|w| mesh.points[w as usize]);
        let width: f64 = last.1 - before.1;
        let t = if width > 0.0 { ((reach - before.1) / width).clamp(0.0, 1.0) } else { 1.0 };
        p.lerp(q, t)
    }

    /// Follows a curve from its end `k` at `v` to the next corner, or back to `v`.
    fn follow(&mut self, mesh: &EditMesh, v: u32, k: usize) -> Option<Chain> {
        if self.used[k] {
            return None;
        }
        let mut chain = Chain {
            kind: self.ends[k].kind,
            closed: false,
            sharp: false,
            smooth: self.ends[k].kind == Kind::Crease,
            points: vec![mesh.points[v as usize]],
            vertices: vec![v],
            arc: vec![0.0],
            sides: Vec::new(),
        };
        let (mut at, mut k) = (v, k);
        loop {
            let end = self.ends[k];
            self.used[k] = true;
            let back = (self.first[end.to as usize]..self.first[end.to as usize + 1])
                .map(|b| b as usize)
                .find(|&b| self.ends[b].sides == [end.sides[1], end.sides[0]])?;
            self.used[back] = true;
            let (p, q) = (mesh.points[at as usize], mesh.points[end.to as usize]);
            chain.arc.push(chain.length() + p.distance(q));
            chain.points.push(q);
            chain.vertices.push(end.to);
            chain.sides.push(end.sides);
            at = end.to;
            if self.rank[at as usize] == Rank::Corner {
                return Some(chain);
            }
            if at == v {
                chain.closed = true;
                return Some(chain);
            }
            let mut onward = (self.first[at as usize]..self.first[at as usize + 1]).map(|b| b as usize);
            k = onward.find(|&b| b != back)?;
        }
    }
}
