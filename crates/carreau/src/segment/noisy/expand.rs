//! Which surface every triangle belongs to: α-expansion (Boykov, Veksler and Zabih, "Fast Approximate Energy Minimization
//! via Graph Cuts", PAMI 23, 2001) of
//!
//! ```text
//!     E = Σ price(t, l_t) + λ Σ length(e) / edge · contrast(e)   over the edges e between two labels
//! ```
//!
//! One move offers a label α to all triangles around it that could bear it; the minimum cut says which take it. With x = 1
//! where α is taken, two neighbours of different labels cost w unless both take it: w (1 − x y) = w/2 (1 − x) + w/2 (1 − y) +
//! w/2 |x − y|.

use super::level::Noise;
use super::model::{DEAREST_PRICE, FREE_PRICE, Model};
use crate::context::Context;
use crate::error::Result;
use crate::mesh::NONE;
use crate::numeric::flow::{CutGraph, Edge};
use crate::segment::surface::Surface;

/// λ, in prices of triangles, for an edge of mean length: somewhat more than a triangle costs on its own surface,
/// because a single one is not to leave it.
const BOUNDARY_PRICE: f64 = 1.5;
/// A count of steps for a price of 1, because capacities are integers.
const EXPANSION_STEPS: f64 = 1e6;
/// A count of standard deviations: bends of so many halve the price of a boundary, because noise bends next to no edge
/// by more.
const HALF_PRICE_BEND: f64 = 3.0;

/// The prices of a mesh.
pub struct Energy<'a> {
    pub surface: &'a Surface<'a>,
    pub noise: &'a Noise,
    pub models: Vec<Model>,
    /// Triangles that keep their label.
    pub fixed: &'a [bool],
    /// Price of a boundary on every half-edge.
    boundary: Vec<f64>,
}

impl<'a> Energy<'a> {
    pub fn new(surface: &'a Surface<'a>, noise: &'a Noise, models: Vec<Model>, fixed: &'a [bool]) -> Self {
        let boundary = |c: u32| {
            let bend = f64::from(surface.bend[c as usize]) / (HALF_PRICE_BEND * noise.bend(surface, c).max(1e-9));
            noise.triangles_a_sample.sqrt() * BOUNDARY_PRICE * (surface.edge_length(c) / noise.edge).min(3.0)
                / (1.0 + bend * bend)
        };
        let boundary = (0..3 * surface.len() as u32).map(boundary).collect();
        Energy { surface, noise, models, fixed, boundary }
    }

    /// The price of a triangle with a label; [`NONE`] is no surface.
    pub fn price(&self, k: u32, label: u32) -> f64 {
        self.models.get(label as usize).map_or(FREE_PRICE, |m| m.price(self.surface, self.noise, k))
    }

    /// Price of a boundary at a half-edge.
    pub fn boundary(&self, c: u32) -> f64 {
        self.boundary[c as usize]
    }

    /// Offers every label in turn until none is taken any more, at most `rounds` times; returns whether anything changed.
    pub fn minimise(&self, label: &mut [u32], rounds: usize, context: &Context) -> Result<bool> {
        let mut price: Vec<f64> = (0..label.len() as u32).map(|k| self.price(k, label[k as usize])).collect();
        let mut node = vec![NONE; label.len()];
        let mut any = false;
        for _ in 0..rounds {
            let mut changed = false;
            for alpha in (0..self.models.len() as u32).chain([NONE]) {
                context.check()?;
                changed |= self.expand(alpha, label, &mut price, &mut node);
            }
            any |= changed;
            if !changed {
                break;
            }
        }
        Ok(any)
    }

    /// One move.
    fn expand(&self, alpha: u32, label: &mut [u32], price: &mut [f64], node: &mut [u32]) -> bool {
        let (members, offered) = self.candidates(alpha, label, price, node);
        let mut graph = CutGraph::default();
        let steps = |x: f64| (x * EXPANSION_STEPS) as i64;
        let t = self.surface.triangles;
        for (&k, &offer) in members.iter().zip(&offered) {
            let own = label[k as usize];
            let (mut stay, mut take) = (price[k as usize], offer);
            for c in 3 * k..3 * k + 3 {
                let o = t.opposite(c);
                if o == NONE {
                    continue;
                }
                let (n, w) = (o / 3, self.boundary[c as usize]);
                let (m, other) = (node[n as usize], label[n as usize]);
                let me = node[k as usize];
                if m == NONE {
                    stay += if other != own { w } else { 0.0 };
                    take += if other != alpha { w } else { 0.0 };
                } else if other == own {
                    if me < m {
                        graph.edges.push(Edge { ends: [me, m], capacity: steps(w) });
                    }
                } else {
                    stay += w / 2.0;
                    if me < m {
                        graph.edges.push(Edge { ends: [me, m], capacity: steps(w / 2.0) });
                    }
                }
            }
            let common = stay.min(take);
            // On the source's side a triangle keeps its label: what is not clearly better stays as it is.
            graph.source.push(steps(take - common));
            graph.sink.push(steps(stay - common));
        }
        let mut changed = false;
        if !members.is_empty() {
            let keeps = graph.min_cut();
            for ((&k, &offer), keeps) in members.iter().zip(&offered).zip(keeps) {
                if !keeps {
                    label[k as usize] = alpha;
                    price[k as usize] = offer;
                    changed = true;
                }
            }
        }
        members.iter().for_each(|&k| node[k as usize] = NONE);
        changed
    }

    /// The triangles that could take a label: connected with those that have it over triangles that it does not cost the
    /// highest price; and what it costs them. `node` gets their numbers.
    fn candidates(&self, alpha: u32, label: &[u32], price: &[f64], node: &mut [u32]) -> (Vec<u32>, Vec<f64>) {
        let t = self.surface.triangles;
        let (mut members, mut offered) = (Vec::new(), Vec::new());
        if alpha == NONE {
            for k in (0..label.len() as u32).filter(|&k| {
                label[k as usize] != NONE && price[k as usize] > 0.5 * FREE_PRICE && !self.fixed[k as usize]
            }) {
                node[k as usize] = members.len() as u32;
                members.push(k);
                offered.push(FREE_PRICE);
            }
            return (members, offered);
        }
        let enter = |k: u32, members: &mut Vec<u32>, offered: &mut Vec<f64>, node: &mut [u32]| {
            for o in (3 * k..3 * k + 3).map(|c| t.opposite(c)).filter(|&o| o != NONE) {
                let n = o / 3;
                if label[n as usize] == alpha || node[n as usize] != NONE || self.fixed[n as usize] {
                    continue;
                }
                let offer = self.price(n, alpha);
                if offer < DEAREST_PRICE {
                    node[n as usize] = members.len() as u32;
                    members.push(n);
                    offered.push(offer);
                }
            }
        };
        for k in (0..label.len() as u32).filter(|&k| label[k as usize] == alpha) {
            enter(k, &mut members, &mut offered, node);
        }
        let mut next = 0;
        while next < members.len() {
            enter(members[next], &mut members, &mut offered, node);
            next += 1;
        }
        (members, offered)
    }
}
