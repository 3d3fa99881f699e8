//! Tangent planes along the edges that end in an irregular vertex.
//!
//! The first cells of the faces around such a vertex are not the limit surface, and meet at an angle. The control points that move
//! the surface within half a quad of the vertex only are changed by as little as it takes for the faces to have the same
//! tangent plane all along the edges between them: least squares of det(C', A, B) by Gauss–Newton steps, where C is the edge and
//! A and B are the derivatives across it on both sides.
//!
//! ```text
//!               A ▲  i, j ≤ 3
//!     ●──────────►┼──────►  C'
//!               B ▼
//! ```

use super::blocks::Block;
use super::control::Sheet;
use super::net::{Fan, Net};
use crate::context::Context;
use crate::error::Result;
use crate::geometry::bspline::Knots;
use crate::numeric::dense;
use glam::DVec3;

/// A count: samples of a knot span along an edge, because faces are to meet smoothly between knots as well.
const POLISH_SAMPLES: usize = 5;
/// A count: most Gauss–Newton steps, because each solves a dense system.
const POLISH_STEPS: usize = 24;
/// A share of what keeps control points where they are, by which the first step is damped (Levenberg, Marquardt),
/// because control points far from the minimum would go too far.
const FIRST_DAMPING: f64 = 1.0;
/// A factor: what damping is multiplied by after a step that helped, and divided by after one that did not, as
/// Marquardt has it.
const DAMPING_FACTOR: f64 = 0.1;
/// A share of the distance from the neighbours: moves below it are the last, because what they change cannot be
/// measured.
const LAST_MOVE: f64 = 1e-6;
/// What a control point that moves by its distance from its neighbours counts, for one sample at an angle of one
/// radian: little, because angles are what is to be mended.
const MOVE_WEIGHT: f64 = 1e-5;
/// The same for control points on borders: much, because these stay.
const BORDER_WEIGHT: f64 = 1e6;

/// The corner of a block that is in a sector of a fan.
#[derive(Debug, Clone, Copy)]
struct Sector {
    block: usize,
    corner: usize,
}

/// Bends the faces at all irregular vertices.
pub fn polish(net: &Net, blocks: &[Block], sheets: &mut [Sheet], grades: usize, context: &Context) -> Result<()> {
    let mut of_corner = vec![None; net.edge.len()];
    for (b, block) in blocks.iter().enumerate() {
        (0..4).for_each(|c| of_corner[block.corner(c) as usize] = Some(Sector { block: b, corner: c }));
    }
    for fan in net.fans.iter().filter(|f| !net.is_regular(f)) {
        context.check()?;
        let sectors: Option<Vec<Sector>> = fan.spokes.iter().map(|&h| of_corner[h as usize]).collect();
        if let Some(sectors) = sectors {
            // The basis functions of so many control points along an edge end within half a quad.
            Apex::new(fan, sectors, sheets, grades - 1).solve(sheets);
        }
    }
    Ok(())
}

/// The control points around an irregular vertex. Unknowns: the vertex (0), those on the edges, those beside the edges.
struct Apex<'a> {
    fan: &'a Fan,
    /// Number of control points along an edge that are moved.
    moved: usize,
    sectors: Vec<Sector>,
    /// Present and first positions of the unknowns.
    now: Vec<DVec3>,
    first: Vec<DVec3>,
    /// The size of each: what a move is measured by.
    size: Vec<f64>,
    /// Unknowns that stay: those on borders.
    fixed: Vec<bool>,
    /// Of every sector along both of its sides, from the vertex on.
    knots: Vec<[Knots; 2]>,
}

impl Sector {
    fn knots(&self, sheets: &[Sheet], axis: usize) -> Knots {
        let along = &sheets[self.block].knots[(self.corner + axis) % 2];
        if matches!(self.corner + axis, 0 | 1 | 4) { along.clone() } else { along.reversed() }
    }
}

/// A weighted sum of control points.
type Terms = Vec<(Term, f64)>;
/// An unknown, or a point that stays.
type Term = std::result::Result<usize, DVec3>;

impl<'a> Apex<'a> {
    fn new(fan: &'a Fan, sectors: Vec<Sector>, sheets: &[Sheet], moved: usize) -> Self {
        let n = sectors.len();
        let spokes = n + usize::from(!fan.closed);
        let count = 1 + moved * spokes + moved * moved * n;
        let knots = sectors.iter().map(|s| [0, 1].map(|axis| s.knots(sheets, axis))).collect();
        let mut apex = Apex {
            fan,
            moved,
            now: vec![DVec3::ZERO; count],
            first: Vec::new(),
            size: vec![0.0; count],
            fixed: vec![false; count],
            sectors,
            knots,
        };
        for s in 0..n {
            for (i, j) in (0..=moved).flat_map(|i| (0..=moved).map(move |j| (i, j))) {
                let k = apex.unknown(s, i, j);
                apex.now[k] = apex.control(sheets, s, i, j);
            }
        }
        for s in 0..n {
            for (i, j) in (0..=moved).flat_map(|i| (0..=moved).map(move |j| (i, j))) {
                let next = apex.control(sheets, s, i + 1, j).distance(apex.control(sheets, s, i, j));
                let k = apex.unknown(s, i, j);
                apex.size[k] = next;
            }
        }
        if !fan.closed {
            for i in 0..=moved {
                let (first, last) = (apex.unknown(0, i, 0), apex.unknown(n - 1, 0, i));
                (apex.fixed[first], apex.fixed[last]) = (true, true);
            }
        }
        apex.first = apex.now.clone();
        apex
    }

    fn unknown(&self, s: usize, i: usize, j: usize) -> usize {
        let n = self.sectors.len();
        let spokes = n + usize::from(!self.fan.closed);
        match (i, j) {
            (0, 0) => 0,
            (i, 0) => 1 + self.moved * s + i - 1,
            (0, j) => 1 + self.moved * ((s + 1) % spokes) + j - 1,
            (i, j) => 1 + self.moved * spokes + self.moved * (self.moved * s + j - 1) + i - 1,
        }
    }

    fn control(&self, sheets: &[Sheet], s: usize, i: usize, j: usize) -> DVec3 {
        let Sector { block, corner } = self.sectors[s];
        sheets[block].points[sheets[block].index(corner, i, j)]
    }

    /// The control point as an unknown or a point.
    fn term(&self, sheets: &[Sheet], s: usize, i: usize, j: usize) -> Term {
        if i <= self.moved && j <= self.moved { Ok(self.unknown(s, i, j)) } else { Err(self.control(sheets, s, i, j)) }
    }

    /// C', A and B of a place of the edge between sector `s − 1` and `s`.
    fn terms(&self, sheets: &[Sheet], s: usize, t: f64) -> [Terms; 3] {
        let before = (s + self.sectors.len() - 1) % self.sectors.len();
        let [mut along, mut left, mut right] = [Terms::new(), Terms::new(), Terms::new()];
        let (first, [values, slopes, _]) = self.knots[s][0].derivatives(t);
        for (i, (value, slope)) in (first..).zip(values.into_iter().zip(slopes)) {
            let on = self.term(sheets, s, i, 0);
            along.push((on, slope));
            left.extend([(self.term(sheets, s, i, 1), value), (on, -value)]);
        }
        let (first, values) = self.knots[before][1].basis(t);
        for (i, value) in (first..).zip(values) {
            let on = self.term(sheets, before, 0, i);
            right.extend([(self.term(sheets, before, 1, i), value), (on, -value)]);
        }
        [along, left, right]
    }

    fn solve(mut self, sheets: &mut [Sheet]) {
        let places = self.places();
        let inner = usize::from(!self.fan.closed)..self.sectors.len();
        let all: Vec<[Terms; 3]> =
            inner.flat_map(|s| places.iter().map(move |&t| (s, t))).map(|(s, t)| self.terms(sheets, s, t)).collect();
        let mut damping = FIRST_DAMPING;
        for _ in 0..POLISH_STEPS {
            let (before, cost) = (self.now.clone(), self.cost(&all));
            match self.step(&all, damping) {
                Some(largest) if self.cost(&all) < cost => {
                    damping *= DAMPING_FACTOR;
                    if largest < LAST_MOVE {
                        break;
                    }
                }
                _ => {
                    self.now = before;
                    damping /= DAMPING_FACTOR;
                }
            }
        }
        for s in 0..self.sectors.len() {
            let Sector { block, corner } = self.sectors[s];
            for (i, j) in (0..=self.moved).flat_map(|i| (0..=self.moved).map(move |j| (i, j))) {
                let (k, unknown) = (sheets[block].index(corner, i, j), self.unknown(s, i, j));
                // What is on a border stays to the bit, because the face beyond has the same points.
                if !self.fixed[unknown] {
                    sheets[block].points[k] = self.now[unknown];
                }
            }
        }
    }

    /// Parameters of the samples along an edge, as far as control points move it.
    fn places(&self) -> Vec<f64> {
        let breaks = self.knots[0][0].breaks();
        let within = breaks.windows(2).take(self.moved + 1);
        let in_span = |w: &[f64]| {
            let [a, b] = [w[0], w[1]];
            (0..POLISH_SAMPLES).map(move |k| a + (b - a) * k as f64 / POLISH_SAMPLES as f64).collect::<Vec<_>>()
        };
        within.flat_map(in_span).collect()
    }

    /// What is minimised.
    fn cost(&self, all: &[[Terms; 3]]) -> f64 {
        let moved = (0..self.now.len()).map(|k| self.stay(k) * self.now[k].distance_squared(self.first[k]));
        let bent = all.iter().map(|terms| {
            let [c, a, b] = terms.each_ref().map(|t| self.value(t).normalize_or_zero());
            c.dot(a.cross(b)).powi(2)
        });
        moved.sum::<f64>() + bent.sum::<f64>()
    }

    /// The weight of the square of a control point's move.
    fn stay(&self, k: usize) -> f64 {
        let weight = if self.fixed[k] { BORDER_WEIGHT } else { MOVE_WEIGHT };
        weight / (self.size[k] * self.size[k]).max(f64::MIN_POSITIVE)
    }

    /// A damped Gauss–Newton step, if there is one. Returns the largest move.
    fn step(&mut self, all: &[[Terms; 3]], damping: f64) -> Option<f64> {
        let n = 3 * self.now.len();
        let (mut matrix, mut rhs) = (vec![0.0; n * n], vec![0.0; n]);
        for k in 0..self.now.len() {
            let weight = self.stay(k);
            for d in 0..3 {
                matrix[(3 * k + d) * (n + 1)] += (1.0 + damping) * weight;
                rhs[3 * k + d] += weight * (self.first[k] - self.now[k])[d];
            }
        }
        for terms in all {
            let [c, a, b] = terms.each_ref().map(|t| self.value(t));
            let scale = c.length() * a.length() * b.length();
            if !(scale > 0.0) {
                continue;
            }
            let slopes = [a.cross(b), b.cross(c), c.cross(a)].map(|x| x / scale);
            let r = c.dot(a.cross(b)) / scale;
            let mut row: Vec<(usize, f64)> = Vec::new();
            for (terms, slope) in terms.iter().zip(slopes) {
                for (of, w) in terms {
                    if let Ok(k) = *of {
                        (0..3).for_each(|d| row.push((3 * k + d, w * slope[d])));
                    }
                }
            }
            for &(i, x) in &row {
                rhs[i] -= r * x;
                row.iter().for_each(|&(j, y)| matrix[i * n + j] += x * y);
            }
        }
        let x = dense::solve(&dense::cholesky(&matrix, n)?, n, &rhs);
        let move_of = |k: usize| DVec3::new(x[3 * k], x[3 * k + 1], x[3 * k + 2]);
        let largest = (0..self.now.len()).map(|k| move_of(k).length() / self.size[k]).fold(0.0, f64::max);
        (0..self.now.len()).for_each(|k| self.now[k] += move_of(k));
        largest.is_finite().then_some(largest)
    }

    fn value(&self, terms: &Terms) -> DVec3 {
        terms.iter().map(|(of, w)| *w * of.map_or_else(|p| p, |k| self.now[k])).sum()
    }
}
