//! The closed assignments of edge vectors: which components are free, how the others follow from them, and which parities
//! make all of them whole.
//!
//! Around every face the edges add up to nothing. Elimination leaves as many free components as there are degrees of freedom;
//! the others are sums of these with halves (around a cone, I − R is singular modulo 2), which gives relations over GF(2).

use super::cell::Cell;
use super::flat::Flat;
use super::framed::{next, turned};
use super::tuning::MOST_UNKNOWNS;
use crate::context::Context;
use crate::error::Result;
use crate::mesh::NONE;
use glam::DVec2;

/// A component of an edge of a face: plus or minus an unknown, or a number.
#[derive(Debug, Clone, Copy)]
pub struct Form {
    /// The unknown, or [`NONE`].
    pub column: u32,
    /// Its sign, or the number.
    pub value: f64,
}

impl Form {
    pub fn of(&self, q: &[f64]) -> f64 {
        if self.column == NONE { self.value } else { self.value * q[self.column as usize] }
    }
}

/// The unknowns of some faces: two for each edge that is not given.
pub struct Unknowns {
    /// A half-edge of every edge.
    pub edges: Vec<u32>,
    /// The feature curve of every edge, or [`NONE`].
    pub curve: Vec<u32>,
    /// What every component should be near.
    pub real: Vec<f64>,
    /// Components of the three edges of every face.
    pub faces: Vec<[[Form; 2]; 3]>,
    pub ids: Vec<u32>,
    /// Unknowns that are zero.
    zero: Vec<u32>,
}

impl Unknowns {
    /// Of all faces, or of some, whose edges to others are given. Edges are to be longer than they are by the mean of how much
    /// their ends are stretched; those on feature curves by the factor of their curve, too.
    pub fn new(flat: &Flat, ids: Vec<u32>, stretch: &[f64], of_curve: &[f64]) -> Self {
        let mut is_in = vec![false; flat.is_alive.len()];
        ids.iter().for_each(|&f| is_in[f as usize] = true);
        let is_all = ids.len() == flat.faces().count();
        let mut of = vec![None; flat.sides.len()];
        let mut unknowns = Unknowns {
            edges: Vec::new(),
            curve: Vec::new(),
            real: Vec::new(),
            faces: Vec::new(),
            ids: Vec::new(),
            zero: Vec::new(),
        };
        for &f in &ids {
            let forms = [0, 1, 2].map(|k| {
                let h = 3 * f + k;
                let side = flat.side(h);
                let is_given = !is_all && (side.opposite == NONE || !is_in[side.opposite as usize / 3]);
                if is_given {
                    return [side.cells.x, side.cells.y].map(|value| Form { column: NONE, value: value as f64 });
                }
                let (edge, turn, sign) = *of[h as usize].get_or_insert_with(|| {
                    unknowns.edges.push(h);
                    unknowns.curve.push(side.curve);
                    let ends = [side.vertex, flat.side(next(h)).vertex].map(|v| stretch[v as usize]);
                    let factor = of_curve.get(side.curve as usize).copied().unwrap_or(1.0);
                    unknowns.real.extend((side.vector * factor * (ends[0] * ends[1]).sqrt()).to_array());
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
                    Form { column: 2 * edge + d as u32, value: axes[d][c] }
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

/// Other unknowns whose sum has the parity of one, and whether it is odd beside them.
type Relation = (Vec<u32>, bool);

/// The assignments: q = constant + Σ free z.
pub struct Lattice {
    /// Free unknowns, in the order in which they are to be rounded.
    pub free: Vec<u32>,
    pub constant: Vec<f64>,
    /// For every unknown what it is of the free ones.
    pub of_free: Vec<Vec<(u32, f64)>>,
    /// The parity of a free one from those before it: these, and a constant.
    pub parity: Vec<Option<Relation>>,
}

const EPSILON: f64 = 1e-7;

impl Lattice {
    /// `order`: the unknowns, those to be free first. `None` where nothing closes, or it would be too much.
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
            if rows[best][column].abs() < EPSILON {
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
        // What is left says that nothing is nothing, or it closes nowhere.
        if rows[first..].iter().any(|row| row[n].abs() > EPSILON) {
            return Ok(None);
        }
        let free_columns: Vec<usize> = (0..n).filter(|&c| pivot_row[c] == usize::MAX).collect();
        let (mut constant, mut of_free) = (vec![0.0; n], vec![Vec::new(); n]);
        for (k, &c) in free_columns.iter().enumerate() {
            of_free[order[c] as usize].push((k as u32, 1.0));
        }
        for c in (0..n).filter(|&c| pivot_row[c] != usize::MAX) {
            let row = &rows[pivot_row[c]];
            constant[order[c] as usize] = row[n];
            let terms = free_columns.iter().enumerate().filter(|(_, f)| row[**f].abs() > EPSILON);
            of_free[order[c] as usize] = terms.map(|(k, &f)| (k as u32, -row[f])).collect();
        }
        let parity = parities(&constant, &of_free, free_columns.len());
        let free = free_columns.iter().map(|&c| order[c]).collect();
        Ok(parity.map(|parity| Lattice { free, constant, of_free, parity }))
    }

    /// The parity that a free unknown must have, given those before it.
    pub fn is_odd(&self, k: usize, before: &[i64]) -> Option<bool> {
        let (others, odd) = self.parity[k].as_ref()?;
        Some(others.iter().fold(*odd, |odd, &j| odd ^ (before[j as usize] % 2 != 0)))
    }
}

/// The equations: what edges of faces add up to, and what is zero; the right side comes last.
fn rows(unknowns: &Unknowns, at: &[usize], n: usize) -> Vec<Vec<f64>> {
    let mut rows = Vec::new();
    for face in &unknowns.faces {
        for c in 0..2 {
            let mut row = vec![0.0; n + 1];
            for form in face.iter().map(|edge| edge[c]) {
                match form.column {
                    NONE => row[n] -= form.value,
                    column => row[at[column as usize]] += form.value,
                }
            }
            rows.push(row);
        }
    }
    for &column in &unknowns.zero {
        let mut row = vec![0.0; n + 1];
        row[at[column as usize]] = 1.0;
        rows.push(row);
    }
    rows
}

/// The relations that make all unknowns whole, each solved for the last free one in it; `None` where they contradict each other.
fn parities(constant: &[f64], of_free: &[Vec<(u32, f64)>], free: usize) -> Option<Vec<Option<Relation>>> {
    let words = free / 64 + 1;
    // One more bit for the constant, which is never a pivot.
    let mut found: Vec<Option<Vec<u64>>> = vec![None; free];
    let mut constants = vec![false; free];
    for (terms, constant) in of_free.iter().zip(constant) {
        let is_half = |a: f64| (2.0 * a).round() as i64 % 2 != 0;
        let (mut bits, mut odd) = (vec![0u64; words], is_half(*constant));
        terms.iter().filter(|t| is_half(t.1)).for_each(|t| bits[t.0 as usize / 64] ^= 1 << (t.0 % 64));
        loop {
            let Some(w) = (0..words).rev().find(|&w| bits[w] != 0) else {
                if odd {
                    return None;
                }
                break;
            };
            let last = 64 * w + 63 - bits[w].leading_zeros() as usize;
            match &found[last] {
                Some(other) => {
                    bits.iter_mut().zip(other).for_each(|(a, b)| *a ^= b);
                    odd ^= constants[last];
                }
                None => {
                    (found[last], constants[last]) = (Some(bits), odd);
                    break;
                }
            }
        }
    }
    let listed = |k: usize, bits: Vec<u64>| {
        let others = (0..k as u32).filter(|j| bits[*j as usize / 64] >> (j % 64) & 1 == 1).collect();
        (others, constants[k])
    };
    Some(found.into_iter().enumerate().map(|(k, bits)| bits.map(|bits| listed(k, bits))).collect())
}
