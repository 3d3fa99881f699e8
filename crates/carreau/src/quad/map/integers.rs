//! Numbers of cells along the edges of the decimated metric: every face positive, every face closed.
//!
//! Sequential rounding ("nearest plane", Babai 1986): the shortest edges first, each to the nearest whole vector of the right
//! parity for which the mean of those still free leaves every face some area. Then flips of faces that are not positive, strips of
//! cells through these, and other orders, with longer edges around the faces that stay so.

use super::flat::Flat;
use super::framed::next;
use super::lattice::{Lattice, Unknowns};
use super::strips::Strips;
use super::tuning::{
    CELL_STRETCH, FACE_ROOM, MOST_BAD_SHARE, MOST_CANDIDATES, ORDER_SHAKE, REPAIR_ROUNDS, ROUNDING_ORDERS,
};
use crate::context::Context;
use crate::error::Result;
use crate::numeric::dense::{cholesky, inverse, solve};
use glam::DVec2;

/// What feature curves, by number, want.
#[derive(Default)]
pub struct Curves {
    /// The fewest edges that keep each of them.
    pub fewest: Vec<usize>,
    /// How many times longer their edges are to be.
    pub factor: Vec<f64>,
}

/// Gives every edge its cells; returns whether all faces are positive. Where one is not, its vertices are stretched: their edges
/// are to be longer the next time, here and for who calls again. `curves`: what feature curves want.
pub fn choose(flat: &mut Flat, stretch: &mut [f64], curves: &Curves, context: &Context) -> Result<bool> {
    let mut best: Option<(usize, Flat)> = None;
    let mut random = Random(1);
    for order in 0..ROUNDING_ORDERS {
        context.check()?;
        let mut tried = flat.clone();
        let unknowns = Unknowns::new(&tried, &goals(&tried, stretch, curves));
        let Some(q) = rounded(&unknowns, (order > 0).then_some(&mut random), context)? else { continue };
        assign(&mut tried, &unknowns, &q);
        let mut bad = repair(&mut tried);
        let is_hopeless = bad as f64 > MOST_BAD_SHARE * tried.faces().count() as f64;
        if bad > 0 && !is_hopeless {
            let goal = goals(&tried, stretch, curves);
            Strips::new(&mut tried, goal, &curves.fewest).give_cells(context)?;
            bad = bad_faces(&tried).len();
        }
        let mut tight: Vec<u32> =
            bad_faces(&tried).into_iter().flat_map(|f| [0, 1, 2].map(|k| tried.side(3 * f + k).vertex)).collect();
        tight.sort_unstable();
        tight.dedup();
        tight.into_iter().for_each(|v| stretch[v as usize] *= CELL_STRETCH);
        tracing::debug!(target: "carreau::quad", order, bad, "numbers");
        if best.as_ref().is_none_or(|b| bad < b.0) {
            best = Some((bad, tried));
        }
        if bad == 0 || is_hopeless {
            break;
        }
    }
    let Some((bad, found)) = best else { return Ok(false) };
    *flat = found;
    Ok(bad == 0)
}

/// Numbers in an order that is the same in every run (SplitMix64; Steele, Lea, Flood 2014).
struct Random(u64);

impl Random {
    /// From 0 to 1.
    fn share(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }
}

fn assign(flat: &mut Flat, unknowns: &Unknowns, q: &[f64]) {
    for (face, &f) in unknowns.ids.iter().enumerate() {
        for k in 0..3 {
            flat.sides[3 * f as usize + k].cells = unknowns.cells(face, k, q);
        }
    }
}

/// All unknowns, one edge after the other; `None` where they cannot all be whole.
fn rounded(unknowns: &Unknowns, random: Option<&mut Random>, context: &Context) -> Result<Option<Vec<f64>>> {
    let length = |e: usize| unknowns.real[2 * e].hypot(unknowns.real[2 * e + 1]);
    let mut keys: Vec<f64> = (0..unknowns.edges.len()).map(length).collect();
    if let Some(random) = random {
        keys.iter_mut().for_each(|key| *key *= 1.0 + ORDER_SHAKE * (2.0 * random.share() - 1.0));
    }
    let mut order: Vec<u32> = (0..unknowns.real.len() as u32).collect();
    order.sort_by(|&a, &b| keys[a as usize / 2].total_cmp(&keys[b as usize / 2]).then(a.cmp(&b)));
    let Some(lattice) = Lattice::new(unknowns, &order, context)? else { return Ok(None) };
    context.check()?;
    let weight: Vec<f64> = (0..unknowns.real.len()).map(|c| 1.0 / length(c / 2).max(1.0)).collect();
    let Some(mut rounding) = Rounding::new(unknowns, &lattice, &weight) else { return Ok(None) };
    context.check()?;
    let mut k = 0;
    while k < lattice.free.len() {
        context.check_every(k)?;
        let is_pair = k + 1 < lattice.free.len() && lattice.free[k] / 2 == lattice.free[k + 1] / 2;
        rounding.fix(k, if is_pair { 2 } else { 1 });
        k += if is_pair { 2 } else { 1 };
    }
    let q = rounding.q;
    Ok(q.iter().all(|q| (q - q.round()).abs() < 1e-5).then_some(q))
}

/// Unknowns in the mean, given those that are whole.
struct Rounding<'a> {
    unknowns: &'a Unknowns,
    lattice: &'a Lattice,
    /// Factor of the covariance of the free unknowns: column k is what a change of the k-th does to those behind it.
    factor: Vec<f64>,
    /// The same for all unknowns, column by column.
    effect: Vec<Vec<f64>>,
    z: Vec<f64>,
    q: Vec<f64>,
    whole: Vec<i64>,
}

impl<'a> Rounding<'a> {
    fn new(unknowns: &'a Unknowns, lattice: &'a Lattice, weight: &[f64]) -> Option<Self> {
        let d = lattice.free.len();
        let (mut precision, mut right) = (vec![0.0; d * d], vec![0.0; d]);
        for (c, terms) in lattice.of_free.iter().enumerate() {
            for &(i, a) in terms {
                right[i as usize] += weight[c] * a * unknowns.real[c];
                terms.iter().for_each(|&(j, b)| precision[i as usize * d + j as usize] += weight[c] * a * b);
            }
        }
        let root = cholesky(&precision, d)?;
        let z = solve(&root, d, &right);
        let factor = cholesky(&inverse(&root, d), d)?;
        let of = |values: &dyn Fn(usize) -> f64, c: usize| -> f64 {
            lattice.of_free[c].iter().map(|&(i, a)| a * values(i as usize)).sum()
        };
        let n = unknowns.real.len();
        let effect = (0..d).map(|k| (0..n).map(|c| of(&|i| factor[i * d + k], c)).collect()).collect();
        let q = (0..n).map(|c| of(&|i| z[i], c)).collect();
        Some(Rounding { unknowns, lattice, factor, effect, z, q, whole: Vec::new() })
    }

    /// Makes the next one or two free unknowns whole.
    fn fix(&mut self, k: usize, count: usize) {
        let mut candidates = self.candidates(k, count);
        candidates.sort_by(|a, b| a.cost.total_cmp(&b.cost).then(a.whole.cmp(&b.whole)));
        let mut best: Option<(f64, &Candidate, Vec<f64>)> = None;
        for candidate in candidates.iter().take(MOST_CANDIDATES) {
            let mut q = self.q.clone();
            for (effect, y) in self.effect[k..k + count].iter().zip(candidate.steps) {
                q.iter_mut().zip(effect).for_each(|(q, e)| *q += e * y);
            }
            let faces = 0..self.unknowns.faces.len();
            let lack: f64 = faces.map(|f| (FACE_ROOM - self.unknowns.area(f, &q)).max(0.0)).sum();
            // Hundredths: nearer ones count as the same, and come first.
            let lack = (100.0 * lack).round();
            if best.as_ref().is_none_or(|b| lack < b.0) {
                best = Some((lack, candidate, q));
            }
            if lack == 0.0 {
                break;
            }
        }
        let Some((_, candidate, q)) = best else { return };
        let d = self.z.len();
        for j in 0..count {
            for i in k..d {
                self.z[i] += self.factor[i * d + k + j] * candidate.steps[j];
            }
        }
        self.whole.extend(&candidate.whole[..count]);
        self.q = q;
    }

    fn candidates(&mut self, k: usize, count: usize) -> Vec<Candidate> {
        let d = self.z.len();
        let mut found = Vec::new();
        for first in self.near(k, self.z[k]) {
            let y = (first as f64 - self.z[k]) / self.factor[k * d + k];
            if count == 1 {
                found.push(Candidate { whole: [first, 0], steps: [y, 0.0], cost: y * y });
                continue;
            }
            self.whole.push(first);
            let mean = self.z[k + 1] + self.factor[(k + 1) * d + k] * y;
            for second in self.near(k + 1, mean) {
                let w = (second as f64 - mean) / self.factor[(k + 1) * d + k + 1];
                found.push(Candidate { whole: [first, second], steps: [y, w], cost: y * y + w * w });
            }
            self.whole.pop();
        }
        found
    }

    /// The whole numbers near a value that a free unknown may be.
    fn near(&self, k: usize, value: f64) -> Vec<i64> {
        let (middle, odd) = (value.round() as i64, self.lattice.is_odd(k, &self.whole));
        let reach = if odd.is_some() { 4 } else { 2 };
        (middle - reach..=middle + reach).filter(|n| odd.is_none_or(|odd| (n % 2 != 0) == odd)).collect()
    }
}

struct Candidate {
    whole: [i64; 2],
    steps: [f64; 2],
    cost: f64,
}

/// Flips edges of faces that are not positive where that helps, in both metrics; returns how many such faces are left.
fn repair(flat: &mut Flat) -> usize {
    for _ in 0..REPAIR_ROUNDS {
        let mut has_moved = false;
        for f in bad_faces(flat) {
            if flat.cells(f) > 0 {
                continue;
            }
            let gain = |&h: &u32| {
                let [a, b] = flat.flipped(h)?;
                let cells = |s: &[super::flat::Side; 3]| s[0].cells.cross(s[1].cells);
                let area = |s: &[super::flat::Side; 3]| s[0].vector.perp_dot(s[1].vector);
                let before = flat.cells(f).min(flat.cells(flat.side(h).opposite / 3));
                let after = cells(&a).min(cells(&b));
                (after > before && area(&a) > 1e-9 && area(&b) > 1e-9).then_some((after, h))
            };
            let best =
                [3 * f, 3 * f + 1, 3 * f + 2].iter().filter_map(gain).max_by_key(|g| (g.0, std::cmp::Reverse(g.1)));
            if let Some((_, h)) = best {
                has_moved |= flat.flip(h, 1e-12);
            }
        }
        if !has_moved {
            break;
        }
    }
    bad_faces(flat).len()
}

fn bad_faces(flat: &Flat) -> Vec<u32> {
    flat.faces().filter(|&f| flat.cells(f) <= 0).collect()
}

/// What the edge of every half-edge should be near.
pub fn goals(flat: &Flat, stretch: &[f64], curves: &Curves) -> Vec<DVec2> {
    let goal = |h: u32| {
        let side = flat.side(h);
        let ends = [side.vertex, flat.side(next(h)).vertex].map(|v| stretch[v as usize]);
        let factor = curves.factor.get(side.curve as usize).copied().unwrap_or(1.0);
        side.vector * factor * (ends[0] * ends[1]).sqrt()
    };
    (0..flat.sides.len() as u32).map(goal).collect()
}
