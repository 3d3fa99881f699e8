//! The closed assignments of edge vectors: which components are free, how the others follow from them, and which parities
//! make all of them whole.
//!
//! Around every face the edges add up to nothing. Elimination leaves as many free components as there are degrees of freedom;
//! the others are sums of these with halves (around a cone, I − R is singular modulo 2), which gives relations over GF(2).

use super::cell::Cell;
use super::flat::Flat;
use super::framed::turned;
use super::tuning::MOST_UNKNOWNS;
use crate::context::Context;
use crate::error::Result;
use crate::mesh::NONE;
use glam::DVec2;

/// A component of an edge of a face: plus or minus an unknown.
#[derive(Debug, Clone, Copy)]
pub struct Form {
    /// The unknown.
    pub column: u32,
    pub sign: f64,
}

impl Form {
    pub fn of(&self, q: &[f64]) -> f64 {
        self.sign * q[self.column as usize]
    }
}

/// The unknowns: two for each edge.
pub struct Unknowns {
    /// A half-edge of every edge.
    pub edges: Vec<u32>,
    /// What every component should be near.
    pub real: Vec<f64>,
    /// Components of the three edges of every face.
    pub faces: Vec<[[Form; 2]; 3]>,
    pub ids: Vec<u32>,
    /// Unknowns that are zero.
    zero: Vec<u32>,
}

impl Unknowns {
    /// `goal`: what the edge of every half-edge should be near.
    pub fn new(flat: &Flat, goal: &[DVec2]) -> Self {
        let ids: Vec<u32> = flat.faces().collect();
        let mut of = vec![None; flat.sides.len()];
        let mut unknowns =
            Unknowns { edges: Vec::new(), real: Vec::new(), faces: Vec::new(), ids: Vec::new(), zero: Vec::new() };
        for &f in &ids {
            let forms = [0, 1, 2].map(|k| {
                let h = 3 * f + k;
                let side = flat.side(h);
                let (edge, turn, sign) = *of[h as usize].get_or_insert_with(|| {
                    unknowns.edges.push(h);
                    unknowns.real.extend(goal[h as usize].to_array());
                    (unknowns.edges.len() as u32 - 1, 0, 1.0)
                });
                if side.opposite != NONE && of[side.opposite as usize].is_none() {
                    of[side.opposite as usize] = Some((edge, turn + side.turn, -sign));
                }
                if side.curve != NONE && unknowns.edges[edge as usize] == h {
                    unknowns.zero.push(2 * edge + u32::from(side.vector.x.abs() >= side.vector.y.abs()));
                }
                let axes = [DVec2::X, DVec2::Y].map(|axis| turned(axis, turn) * sign);
                [0, 1].map(|c| {
                    let d = usize::from(axes[0][c] == 0.0);
                    Form { column: 2 * edge + d as u32, sign: axes[d][c] }
                })
            });
            unknowns.faces.push(forms);
        }
        unknowns.ids = ids;
        unknowns
    }

    /// Twice the area of a face.
    pub fn area(&self, face: usize, q: &[f64]) -> f64 {
        let [a, b, _] = &self.faces[face];
        a[0].of(q) * b[1].of(q) - a[1].of(q) * b[0].of(q)
    }

    /// The integer vector of an edge of a face.
    pub fn cells(&self, face: usize, k: usize, q: &[f64]) -> Cell {
        let [x, y] = self.faces[face][k].map(|form| form.of(q).round() as i64);
        Cell::new(x, y)
    }
}

/// The assignments: q = Σ free z.
pub struct Lattice {
    /// Free unknowns, in the order in which they are to be rounded.
    pub free: Vec<u32>,
    /// For every unknown what it is of the free ones.
    pub of_free: Vec<Vec<(u32, f64)>>,
    /// Those before a free one whose sum has its parity; `None` where it may have any.
    pub parity: Vec<Option<Vec<u32>>>,
}

/// An entry of the elimination, without a unit: smaller ones are zero, because all others are halves at least and
/// rounding is far below.
const ZERO_ENTRY: f64 = 1e-7;

impl Lattice {
    /// `order`: the unknowns, those to be free first. `None` where it would be too much.
    pub fn new(unknowns: &Unknowns, order: &[u32], context: &Context) -> Result<Option<Self>> {
        let n = unknowns.real.len();
        if n > MOST_UNKNOWNS {
            return Ok(None);
        }
        let mut at = vec![0; n];
        order.iter().enumerate().for_each(|(k, &c)| at[c as usize] = k);
        let mut rows = rows(unknowns, &at, n);
        let mut pivot_row = vec![usize::MAX; n];
        let mut first = 0;
        for column in (0..n).rev() {
            context.check()?;
            let Some(best) = (first..rows.len())
                .max_by(|&a, &b| rows[a][column].abs().total_cmp(&rows[b][column].abs()).then(b.cmp(&a)))
            else {
                break;
            };
            if rows[best][column].abs() < ZERO_ENTRY {
                continue;
            }
            rows.swap(first, best);
            let scale = 1.0 / rows[first][column];
            rows[first].iter_mut().for_each(|a| *a *= scale);
            let pivot = rows[first].clone();
            for (_, row) in rows.iter_mut().enumerate().filter(|(r, row)| *r != first && row[column] != 0.0) {
                let factor = row[column];
                row.iter_mut().zip(&pivot).for_each(|(a, p)| *a -= factor * p);
                row[column] = 0.0;
            }
            pivot_row[column] = first;
            first += 1;
        }
        let free_columns: Vec<usize> = (0..n).filter(|&c| pivot_row[c] == usize::MAX).collect();
        let mut of_free = vec![Vec::new(); n];
        for (k, &c) in free_columns.iter().enumerate() {
            of_free[order[c] as usize].push((k as u32, 1.0));
        }
        for c in (0..n).filter(|&c| pivot_row[c] != usize::MAX) {
            let row = &rows[pivot_row[c]];
            let terms = free_columns.iter().enumerate().filter(|(_, f)| row[**f].abs() > ZERO_ENTRY);
            of_free[order[c] as usize] = terms.map(|(k, &f)| (k as u32, -row[f])).collect();
        }
        let parity = parities(&of_free, free_columns.len());
        let free = free_columns.iter().map(|&c| order[c]).collect();
        Ok(Some(Lattice { free, of_free, parity }))
    }

    /// The parity that a free unknown must have, given those before it.
    pub fn is_odd(&self, k: usize, before: &[i64]) -> Option<bool> {
        let others = self.parity[k].as_ref()?;
        Some(others.iter().fold(false, |odd, &j| odd ^ (before[j as usize] % 2 != 0)))
    }
}

/// The equations: what edges of faces add up to is zero, and so are some unknowns.
fn rows(unknowns: &Unknowns, at: &[usize], n: usize) -> Vec<Vec<f64>> {
    let mut rows = Vec::new();
    for face in &unknowns.faces {
        for c in 0..2 {
            let mut row = vec![0.0; n];
            for form in face.iter().map(|edge| edge[c]) {
                row[at[form.column as usize]] += form.sign;
            }
            rows.push(row);
        }
    }
    for &column in &unknowns.zero {
        let mut row = vec![0.0; n];
        row[at[column as usize]] = 1.0;
        rows.push(row);
    }
    rows
}

/// The relations that make all unknowns whole, each solved for the last free one in it.
fn parities(of_free: &[Vec<(u32, f64)>], free: usize) -> Vec<Option<Vec<u32>>> {
    let words = free / 64 + 1;
    let mut found: Vec<Option<Vec<u64>>> = vec![None; free];
    for terms in of_free {
        let is_half = |a: f64| (2.0 * a).round() as i64 % 2 != 0;
        let mut bits = vec![0u64; words];
        terms.iter().filter(|t| is_half(t.1)).for_each(|t| bits[t.0 as usize / 64] ^= 1 << (t.0 % 64));
        while let Some(w) = (0..words).rev().find(|&w| bits[w] != 0) {
            let last = 64 * w + 63 - bits[w].leading_zeros() as usize;
            match &found[last] {
                Some(other) => bits.iter_mut().zip(other).for_each(|(a, b)| *a ^= b),
                None => {
                    found[last] = Some(bits);
                    break;
                }
            }
        }
    }
    let before =
        |k: usize, bits: Vec<u64>| (0..k as u32).filter(|j| bits[*j as usize / 64] >> (j % 64) & 1 == 1).collect();
    found.into_iter().enumerate().map(|(k, bits)| bits.map(|bits| before(k, bits))).collect()
}
