//! The edges that may be features as a network: strands between corners, tips and branches.

use crate::geometry::normals::angle_between;
use crate::mesh::DisjointSets;
use glam::DVec3;

/// A strand goes on in a direction that turns by less than this, in degrees: less than the corner of a square, more than noise
/// of a tenth of an edge makes of a straight line.
const ONWARD_DEG: f64 = 45.0;
/// Turns above this are jags, in degrees: six of them make half a circle, so that fewer edges are no rim of anything round.
const JAG_DEG: f64 = 30.0;
/// A strand is jagged where more than this share of its vertices are jags: those of parts have corners, but few; strands that
/// follow the edges of a rounded fold jump from row to row.
const JAGGED_SHARE: f64 = 0.2;
/// A loop of fewer edges than this around a spike is noise where it is jagged.
const FEWEST_OF_LOOP: u32 = 6;

/// The candidates of a mesh, by vertex, with those that are kept.
pub struct Network<'a> {
    points: &'a [DVec3],
    /// The ends of every candidate.
    ends: Vec<[u32; 2]>,
    /// Where the candidates of every vertex begin in `around`.
    first: Vec<u32>,
    around: Vec<u32>,
    /// Features whatever their angle: they stay.
    fixed: Vec<bool>,
    kept: Vec<bool>,
    /// Kept edges at every vertex.
    degree: Vec<u32>,
}

/// A strand from a free tip to the next tip, branch or fixed feature.
struct Branch {
    tip: u32,
    end: u32,
    length: f64,
    edges: Vec<u32>,
}

impl<'a> Network<'a> {
    /// The network of these edges; the kept ones are the fixed and the strong ones.
    pub fn new(points: &'a [DVec3], ends: Vec<[u32; 2]>, fixed: Vec<bool>, kept: Vec<bool>) -> Self {
        let mut first = vec![0u32; points.len() + 1];
        ends.iter().flatten().for_each(|&v| first[v as usize + 1] += 1);
        for v in 1..first.len() {
            first[v] += first[v - 1];
        }
        let mut fill = first.clone();
        let mut around = vec![0; 2 * ends.len()];
        for (e, v) in ends.iter().zip(0u32..).flat_map(|(ends, e)| ends.map(|v| (e, v as usize))) {
            around[fill[v] as usize] = e;
            fill[v] += 1;
        }
        let degree = vec![0; points.len()];
        let mut network = Network { points, ends, first, around, fixed, kept, degree };
        network.count();
        network
    }

    /// Whether an edge is kept.
    pub fn is_kept(&self, e: u32) -> bool {
        self.kept[e as usize]
    }

    /// Whether an edge is a feature whatever its angle.
    pub fn is_fixed(&self, e: u32) -> bool {
        self.fixed[e as usize]
    }

    /// The edges.
    pub fn edges(&self) -> std::ops::Range<u32> {
        0..self.ends.len() as u32
    }

    /// Length of an edge.
    pub fn length(&self, e: u32) -> f64 {
        let [a, b] = self.ends[e as usize].map(|v| self.points[v as usize]);
        a.distance(b)
    }

    /// Number of the free ends of kept edges that are not fixed, and the total length of what is kept: a few loose edges beside
    /// many that are known are no noise.
    pub fn tips(&self) -> (usize, f64) {
        let open = |&e: &u32| self.is_kept(e) && !self.is_fixed(e);
        let length = self.edges().filter(|&e| self.is_kept(e)).map(|e| self.length(e)).sum();
        let is_tip = |&v: &u32| self.degree[v as usize] == 1;
        (self.edges().filter(open).flat_map(|e| self.ends[e as usize]).filter(is_tip).count(), length)
    }

    /// Number of pieces of what is kept.
    pub fn pieces(&self) -> usize {
        let mut leaders: Vec<u32> =
            self.components().into_iter().zip(self.edges()).filter(|(_, e)| self.is_kept(*e)).map(|(l, _)| l).collect();
        leaders.sort_unstable();
        leaders.dedup();
        leaders.len()
    }

    /// Which edges are in pieces, with all candidates, that are as long as a length, or have a loop.
    pub fn may_stay(&self, length: f64) -> Vec<bool> {
        let mut sets = DisjointSets::new(self.degree.len());
        self.ends.iter().for_each(|&[a, b]| sets.union(a, b));
        let leaders = sets.leaders();
        let of = |e: u32| leaders[self.ends[e as usize][0] as usize] as usize;
        let (mut total, mut surplus) = (vec![0.0; leaders.len()], vec![1i64; leaders.len()]);
        let is_used = |v: usize| self.first[v] < self.first[v + 1];
        (0..leaders.len()).filter(|&v| is_used(v)).for_each(|v| surplus[leaders[v] as usize] -= 1);
        for e in self.edges() {
            total[of(e)] += self.length(e);
            surplus[of(e)] += 1;
        }
        self.edges().map(|e| total[of(e)] >= length || surplus[of(e)] > 0).collect()
    }

    /// Keeps what is told of the edges that are not fixed.
    pub fn keep_only(&mut self, keeps: &[bool]) {
        for (kept, (&fixed, &keep)) in self.kept.iter_mut().zip(self.fixed.iter().zip(keeps)) {
            *kept = fixed || keep;
        }
        self.count();
    }

    fn count(&mut self) {
        self.degree.fill(0);
        for (ends, _) in self.ends.iter().zip(&self.kept).filter(|(_, kept)| **kept) {
            ends.iter().for_each(|&v| self.degree[v as usize] += 1);
        }
    }

    fn of(&self, v: u32) -> &[u32] {
        &self.around[self.first[v as usize] as usize..self.first[v as usize + 1] as usize]
    }

    fn other(&self, e: u32, v: u32) -> u32 {
        let [a, b] = self.ends[e as usize];
        if a == v { b } else { a }
    }

    fn set(&mut self, e: u32, kept: bool) {
        if self.kept[e as usize] != kept {
            self.kept[e as usize] = kept;
            for v in self.ends[e as usize] {
                let degree = &mut self.degree[v as usize];
                *degree = if kept { *degree + 1 } else { degree.saturating_sub(1) };
            }
        }
    }

    /// Hysteresis: strands go on from their free tips along weaker edges that `goes_on`, where these lead to what is kept.
    ///
    /// ```text
    ///     ═══════•───────•───────•═══════        ═ kept      ─ weaker
    /// ```
    pub fn bridge<E>(&mut self, mut goes_on: impl FnMut(u32) -> Result<bool, E>) -> Result<(), E> {
        let tips: Vec<u32> = (0..self.degree.len() as u32).filter(|&v| self.degree[v as usize] == 1).collect();
        for tip in tips {
            if self.degree[tip as usize] != 1 {
                continue;
            }
            let Some(&last) = self.of(tip).iter().find(|&&e| self.is_kept(e)) else { continue };
            let (mut before, mut at) = (self.other(last, tip), tip);
            let mut path = Vec::new();
            let arrives = loop {
                let Some(e) = self.straightest(before, at, &path) else { break false };
                if !goes_on(e)? {
                    break false;
                }
                path.push(e);
                (before, at) = (at, self.other(e, at));
                if self.degree[at as usize] > 0 {
                    break true;
                }
            };
            if arrives {
                path.into_iter().for_each(|e| self.set(e, true));
            }
        }
        Ok(())
    }

    /// The edge that leads on from a vertex in about the direction from the one before, not kept and not on the path.
    fn straightest(&self, before: u32, at: u32, path: &[u32]) -> Option<u32> {
        let turn = |e: u32| self.turn(before, at, self.other(e, at));
        let onward = self.of(at).iter().copied().filter(|e| !self.is_kept(*e) && !path.contains(e));
        let best = onward.min_by(|&a, &b| turn(a).total_cmp(&turn(b)))?;
        (turn(best) < ONWARD_DEG.to_radians()).then_some(best)
    }

    fn turn(&self, a: u32, b: u32, c: u32) -> f64 {
        let [a, b, c] = [a, b, c].map(|v| self.points[v as usize]);
        angle_between(b - a, c - b)
    }

    /// Drops strands with free tips that are shorter than `length` for every tip, the shortest first, until there are none: what
    /// is left of a branch may be one strand then.
    pub fn prune(&mut self, length: f64) {
        loop {
            let mut short: Vec<Branch> = self.branches();
            short.retain(|b| b.length < length * if self.degree[b.end as usize] == 1 { 2.0 } else { 1.0 });
            short.sort_by(|a, b| a.length.total_cmp(&b.length).then(a.tip.cmp(&b.tip)));
            let mut touched = vec![false; self.degree.len()];
            for branch in &short {
                if std::mem::replace(&mut touched[branch.end as usize], true) | touched[branch.tip as usize] {
                    continue;
                }
                branch.edges.iter().for_each(|&e| self.set(e, false));
            }
            if short.is_empty() {
                return;
            }
        }
    }

    /// All strands that begin at free tips.
    fn branches(&self) -> Vec<Branch> {
        let tips = (0..self.degree.len() as u32).filter(|&v| self.degree[v as usize] == 1);
        tips.filter_map(|tip| {
            let mut e = *self.of(tip).iter().find(|&&e| self.is_kept(e) && !self.is_fixed(e))?;
            let mut branch = Branch { tip, end: tip, length: 0.0, edges: Vec::new() };
            loop {
                branch.edges.push(e);
                branch.length += self.length(e);
                branch.end = self.other(e, branch.end);
                let next = self.of(branch.end).iter().copied().find(|&n| n != e && self.is_kept(n));
                match next {
                    Some(n) if self.degree[branch.end as usize] == 2 && !self.is_fixed(n) => e = n,
                    _ => return Some(branch),
                }
            }
        })
        .collect()
    }

    /// Drops the pieces with free tips that are jagged, and loops around a spike.
    pub fn drop_jagged(&mut self) {
        let leader = self.components();
        #[derive(Default, Clone)]
        struct Piece {
            edges: u32,
            tips: u32,
            jags: u32,
            inner: u32,
            stays: bool,
        }
        let mut pieces = vec![Piece::default(); self.degree.len()];
        let mut seen = vec![false; self.degree.len()];
        for e in self.edges().filter(|&e| self.is_kept(e)) {
            let piece = &mut pieces[leader[e as usize] as usize];
            piece.edges += 1;
            piece.stays |= self.is_fixed(e);
            for v in self.ends[e as usize] {
                if std::mem::replace(&mut seen[v as usize], true) {
                    continue;
                }
                match self.degree[v as usize] {
                    1 => piece.tips += 1,
                    2 => {
                        piece.inner += 1;
                        piece.jags += u32::from(self.is_jag(v));
                    }
                    _ => {}
                }
            }
        }
        for e in self.edges() {
            let piece = &pieces[leader[e as usize] as usize];
            let is_jagged = f64::from(piece.jags) >= JAGGED_SHARE * f64::from(piece.inner);
            let is_open = piece.tips > 0 || piece.edges < FEWEST_OF_LOOP;
            if self.is_kept(e) && !self.is_fixed(e) && !(piece.stays && piece.tips == 0) && is_open && is_jagged {
                self.set(e, false);
            }
        }
    }

    fn is_jag(&self, v: u32) -> bool {
        let mut kept = self.of(v).iter().filter(|&&e| self.is_kept(e)).map(|&e| self.other(e, v));
        match [kept.next(), kept.next()] {
            [Some(a), Some(b)] => self.turn(a, v, b) > JAG_DEG.to_radians(),
            _ => false,
        }
    }

    /// A vertex that stands for the piece of every edge.
    fn components(&self) -> Vec<u32> {
        let mut sets = DisjointSets::new(self.degree.len());
        let kept = self.ends.iter().zip(&self.kept).filter(|(_, kept)| **kept);
        kept.for_each(|(&[a, b], _)| sets.union(a, b));
        let leaders = sets.leaders();
        self.ends.iter().map(|&[a, _]| leaders[a as usize]).collect()
    }

    /// Pieces of edges that are not kept but were, as `was` tells: the length of the longest, and the middle of its longest edge.
    pub fn longest_dropped(&self, was: &[bool]) -> Option<(f64, DVec3)> {
        let is_dropped = |e: u32| was[e as usize] && !self.is_kept(e);
        let mut sets = DisjointSets::new(self.degree.len());
        self.edges()
            .filter(|&e| is_dropped(e))
            .for_each(|e| sets.union(self.ends[e as usize][0], self.ends[e as usize][1]));
        let leaders = sets.leaders();
        let mut length = vec![0.0; leaders.len()];
        let of = |e: u32| leaders[self.ends[e as usize][0] as usize] as usize;
        self.edges().filter(|&e| is_dropped(e)).for_each(|e| length[of(e)] += self.length(e));
        let longest = self.edges().filter(|&e| is_dropped(e)).max_by(|&a, &b| {
            let key = |e: u32| (length[of(e)], self.length(e));
            let (a, b) = (key(a), key(b));
            a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1))
        })?;
        let [a, b] = self.ends[longest as usize].map(|v| self.points[v as usize]);
        Some((length[of(longest)], 0.5 * (a + b)))
    }
}
