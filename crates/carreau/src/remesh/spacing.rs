//! Ridges with no more edges than their sag asks for, evenly spaced.
//!
//! A collapse on a ridge has to leave a chord within the tolerance. Edges that sag by half of it can therefore not be
//! collapsed, though with their neighbours moved on there would be room for fewer:
//!
//! ```text
//!     •───•───•───•───•───•    sag 0.6: none of the five may go
//!     •────•────•────•────•    sag 0.95: four do as well
//! ```
//!
//! So the number of edges comes first, the least for which an even spacing in the metric is within the tolerance; what is
//! too many is collapsed without a look at the sag, the rest moves to its places, and a chord that is beyond the tolerance
//! even so is split again.

use super::curves::{Chain, Kind, Rank};
use super::decimate::Demand;
use super::relocate::Accept;
use super::size::metric_length;
use super::work::Work;
use crate::context::Context;
use crate::error::Result;
use crate::mesh::{Keep, NONE};

/// What goes for the sake of the spacing leaves shapes no worse than this and edges no longer.
const DEMAND: Demand = Demand { good_length: 0.0, longest: 2.2, least_shape: 0.2, ears: false };
/// Sweeps in which the vertices of a ridge move to their places.
const RIDGE_SWEEPS: usize = 4;
/// Where else an edge that sags is split.
const ELSEWHERE: [f64; 9] = [0.5, 0.4, 0.6, 0.3, 0.7, 0.2, 0.8, 0.1, 0.9];
/// Edges that a closed chain keeps.
const LEAST_CLOSED: usize = 3;

/// The vertices of a chain in order, from end to end; in a closed one the first is repeated.
struct Row<'a> {
    chain: &'a Chain,
    vertices: Vec<u32>,
    /// Their parameters, ascending.
    at: Vec<f64>,
}

impl Row<'_> {
    /// The parameters that cut the row into pieces of the same length, by the ways to its vertices.
    fn places(&self, ways: &[f64], pieces: usize) -> Vec<f64> {
        let whole = ways[ways.len() - 1];
        let place = |j: usize| {
            let way = whole * j as f64 / pieces as f64;
            let k = ways.partition_point(|&w| w <= way).clamp(1, ways.len() - 1);
            let share = (way - ways[k - 1]) / (ways[k] - ways[k - 1]).max(f64::MIN_POSITIVE);
            self.at[k - 1] + share.clamp(0.0, 1.0) * (self.at[k] - self.at[k - 1])
        };
        (0..=pieces).map(place).collect()
    }
}

impl<'a> Work<'a> {
    /// Spaces the vertices of all ridges evenly, with as few edges as sizes and sag ask for.
    pub fn space_ridges(&mut self, context: &Context) -> Result<()> {
        for row in self.rows() {
            context.check()?;
            self.space(row);
        }
        Ok(())
    }

    /// Splits what sags by more than the tolerance on any ridge.
    pub fn keep_ridges(&mut self, context: &Context) -> Result<()> {
        for row in self.rows() {
            context.check()?;
            self.split_what_sags(&row);
        }
        Ok(())
    }

    /// The rows of all ridges that have vertices within.
    fn rows(&self) -> Vec<Row<'a>> {
        let mut on_chain: Vec<Vec<u32>> = vec![Vec::new(); self.curves.chains.len()];
        for v in (0..self.mesh.vertex_slots()).filter(|&v| self.mesh.is_vertex(v)) {
            if self.rank[v as usize] == Rank::Curve
                && let Some(h) = self.mesh.around(v).find(|&h| self.mesh.curve(h) != NONE)
            {
                on_chain[self.mesh.curve(h) as usize].push(v);
            }
        }
        let is_ridge = |chain: &Chain| matches!(chain.kind, Kind::Ridge | Kind::Crease);
        let filled = self.curves.chains.iter().zip(on_chain);
        let filled = filled.filter(|(chain, inner)| is_ridge(chain) && inner.len() > usize::from(chain.closed));
        filled.map(|(chain, inner)| self.row(chain, inner)).collect()
    }

    fn space(&mut self, mut row: Row<'a>) {
        let chain = row.chain;
        let edges = row.vertices.len() - 1;
        let least = if chain.closed { LEAST_CLOSED } else { 1 };
        let ways = self.ways(&row);
        let wanted = (ways[edges].round() as usize).max(least);
        if let Some(fewest) = (wanted..edges).find(|&n| self.holds(chain, &row.places(&ways, n))) {
            self.thin(&mut row, fewest);
            let places = row.places(&self.ways(&row), row.vertices.len() - 1);
            for _ in 0..RIDGE_SWEEPS {
                self.shift_row(&row, &places);
            }
        }
        self.split_what_sags(&row);
    }

    fn row(&self, chain: &'a Chain, mut inner: Vec<u32>) -> Row<'a> {
        let of = |v: &u32| self.parameter[*v as usize];
        inner.sort_by(|a, b| of(a).total_cmp(&of(b)).then(a.cmp(b)));
        let mut at: Vec<f64> = inner.iter().map(of).collect();
        if chain.closed {
            at.push(at[0] + chain.length());
            inner.push(inner[0]);
        } else {
            at.insert(0, 0.0);
            at.push(chain.length());
            inner.insert(0, chain.vertices[0]);
            inner.push(chain.vertices[chain.vertices.len() - 1]);
        }
        Row { chain, vertices: inner, at }
    }

    /// Length in the metric from the first vertex to every other.
    fn ways(&self, row: &Row) -> Vec<f64> {
        let size = |k: usize| self.size[row.vertices[k] as usize];
        let mut ways = vec![0.0];
        for k in 1..row.at.len() {
            ways.push(ways[k - 1] + metric_length(row.at[k] - row.at[k - 1], size(k - 1), size(k)));
        }
        ways
    }

    fn holds(&self, chain: &Chain, places: &[f64]) -> bool {
        places.windows(2).all(|w| self.curve_allows(chain, [w[0], w[1]], 0.0))
    }

    /// Collapses the vertices between the shortest edges until there are `fewest`, or as few as the triangles allow.
    fn thin(&mut self, row: &mut Row<'a>, fewest: usize) {
        let limits = self.limits;
        (self.limits.ridge_sag, self.limits.curve_sag_share) = (f64::INFINITY, 0.5);
        let mut stays: Vec<u32> = Vec::new();
        while row.vertices.len() - 1 > fewest {
            let ways = self.ways(row);
            let free = (1..row.vertices.len() - 1).filter(|&k| !stays.contains(&row.vertices[k]));
            let both = |k: usize| ways[k + 1] - ways[k - 1];
            let Some(k) = free.min_by(|&a, &b| both(a).total_cmp(&both(b))) else { break };
            if self.give_up(row.vertices[k], [row.vertices[k - 1], row.vertices[k + 1]]) {
                row.vertices.remove(k);
                row.at.remove(k);
            } else {
                stays.push(row.vertices[k]);
            }
        }
        self.limits = limits;
    }

    /// Collapses a vertex into the better of two neighbours.
    fn give_up(&mut self, v: u32, neighbours: [u32; 2]) -> bool {
        let ways = neighbours.map(|w| {
            let h = self.mesh.half_edge(v, w).or(self.mesh.half_edge(w, v))?;
            let keep = if self.mesh.gone_and_kept(h, Keep::Head).0 == v { Keep::Head } else { Keep::Tail };
            let allowed = self.may_go(h, keep) && self.mesh.check_collapse(h).is_ok();
            let shape = if allowed { self.try_collapse(h, keep, &DEMAND)? } else { return None };
            Some((shape, h, keep))
        });
        let better = ways.into_iter().flatten().max_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((_, h, keep)) = better {
            self.collapse(h, keep);
        }
        better.is_some()
    }

    /// Moves the vertices of a row towards their places, and their neighbours after them.
    fn shift_row(&mut self, row: &Row, places: &[f64]) {
        for (&v, &place) in row.vertices.iter().zip(places) {
            if self.rank[v as usize] != Rank::Curve {
                continue;
            }
            let [from, to] = row.chain.span(self.parameter[v as usize], row.chain.wrapped(place));
            let along = self.step_along(v, to - from);
            self.go(v, along);
            let mut around = Vec::new();
            self.mesh.for_neighbours(v, |w| around.push(w));
            around.retain(|&w| self.rank[w as usize] == Rank::Free);
            for w in around {
                let follows = self.relocation(w, Accept::Harmless);
                self.go(w, follows);
            }
        }
    }

    fn split_what_sags(&mut self, row: &Row) {
        let chain = row.chain;
        for pair in row.vertices.windows(2) {
            let Some(h) = self.mesh.half_edge(pair[0], pair[1]).or(self.mesh.half_edge(pair[1], pair[0])) else {
                continue;
            };
            if self.mesh.curve(h) != NONE && !self.curve_allows(chain, self.span(chain, pair[0], pair[1]), 0.0) {
                // Where the middle would make needles or a crease, another place may not; where two ridges nearly touch,
                // a needle between them is better than a ridge that leaves its place.
                let elsewhere =
                    |work: &mut Self, urgent| ELSEWHERE.into_iter().find_map(|t| work.split_curve(h, t, urgent));
                let _ = self.split(h).or_else(|| elsewhere(self, false)).or_else(|| elsewhere(self, true));
            }
        }
    }
}
