//! The four sides of a block, each composed of the curves of its chains.

use super::curve::{ChainCurve, Shape};
use crate::error::Result;
use crate::geometry::bspline::{BSplineCurve, Knots};
use crate::patch::cad::chain::{ChainUse, Chains};
use crate::patch::cad::piece::Block;
use crate::patch::cad::runs::Curves;
use crate::patch::cad::scene::Scene;
use glam::DVec3;

/// A side of a block over 0..=1, in the sense of growing parameters.
#[derive(Debug, Clone)]
pub struct Side {
    /// Its curve, of degree 1 or 3.
    pub curve: BSplineCurve,
    /// The parameter of every vertex on it.
    pub parameters: Vec<f64>,
}

/// What the fit of one block starts from.
pub struct Frame {
    /// v = 0, u = 1, v = 1, u = 0.
    pub sides: [Side; 4],
    /// Parameter u of every column and v of every row, at which its chains begin and end.
    pub scale: [Vec<f64>; 2],
}

/// Knots closer than this, as a share of the side, are too close.
const CLOSE: f64 = 1e-7;

impl Frame {
    /// Puts the sides together; `scale` as from [`scale`].
    pub fn new(
        scene: &Scene,
        block: &Block,
        scale: &[Vec<f64>; 2],
        uses: &[ChainUse],
        chains: &Chains,
        curves: &Curves,
    ) -> Result<Self> {
        let [m, n] = block.size;
        let ends = [0, n, n + m, 2 * n + m, 2 * (n + m)];
        // A loop may begin inside the last side only where a corner is no node, which never happens.
        let side = |k: usize| {
            let backwards = k >= 2;
            let mut part: Vec<&ChainUse> = uses.iter().filter(|u| (ends[k]..ends[k + 1]).contains(&u.start)).collect();
            if backwards {
                part.reverse();
            }
            let length = ends[k + 1] - ends[k];
            let path = |of: &ChainUse| chains.paths[of.chain as usize].as_slice();
            // First and last vertex of a chain, counted along the side.
            let range = |of: &ChainUse| {
                let (from, steps) = (of.start - ends[k], path(of).len() as u32 - 1);
                let first = if backwards { length - from - steps } else { from };
                [first as usize, (first + steps) as usize]
            };
            let passed: Vec<(&[u32], bool)> = part.iter().map(|of| (path(of), of.reversed != backwards)).collect();
            let positions = &scale[k % 2];
            let pieces: Vec<(Vec<f64>, ChainCurve)> = curves
                .along(&passed)?
                .into_iter()
                .map(|(of, curve)| {
                    let (first, last) = (range(part[of.start])[0], range(part[of.end - 1])[1]);
                    (positions[first..=last].to_vec(), curve)
                })
                .collect();
            let vertex = |c: u32| {
                let (r, c) = [(0, c), (c, n), (m, c), (c, 0)][k];
                scene.point(block.vertex(scene.patches, r, c))
            };
            compose(&pieces, &(0..=length).map(vertex).collect::<Vec<_>>())
        };
        Ok(Frame { sides: [side(0)?, side(1)?, side(2)?, side(3)?], scale: scale.clone() })
    }

    /// The knots that both opposite sides need, in u and in v; `None` where some are too close to each other.
    pub fn knots(&self, cubic: [bool; 2]) -> Result<Option<[Knots; 2]>> {
        let union = |k: usize| -> Result<Knots> {
            let [a, b] = [&self.sides[k].curve, &self.sides[k + 2].curve];
            if cubic[k] || a.knots().degree().max(b.knots().degree()) > 1 {
                return Ok(a.elevated()?.knots().union(b.elevated()?.knots()));
            }
            Ok(a.knots().union(b.knots()))
        };
        let both = [union(0)?, union(1)?];
        let close = |k: &Knots| k.breaks().windows(2).any(|w| w[1] - w[0] < CLOSE);
        Ok(if both.iter().any(close) { None } else { Some(both) })
    }

    /// The side's curve on these knots.
    pub fn curve_on(&self, side: usize, knots: &Knots) -> Result<BSplineCurve> {
        let curve = &self.sides[side].curve;
        if knots.degree() == 1 { curve.refined_to(knots) } else { curve.elevated()?.refined_to(knots) }
    }
}

/// Average positions of columns and rows over all lines of a block, in 0..=1: the mean of their shares of the length.
pub fn scale(scene: &Scene, block: &Block) -> [Vec<f64>; 2] {
    let [m, n] = block.size;
    let at = |r, c| scene.point(block.vertex(scene.patches, r, c));
    let columns = mean_shares(n, (0..=m).map(|r| (0..=n).map(|c| at(r, c)).collect()));
    let rows = mean_shares(m, (0..=n).map(|c| (0..=m).map(|r| at(r, c)).collect()));
    [columns, rows]
}

fn mean_shares(steps: u32, lines: impl Iterator<Item = Vec<DVec3>>) -> Vec<f64> {
    let mut sum = vec![0.0; steps as usize];
    for line in lines {
        let lengths: Vec<f64> = line.windows(2).map(|w| w[0].distance(w[1])).collect();
        let total: f64 = lengths.iter().sum();
        if total > 0.0 {
            sum.iter_mut().zip(lengths).for_each(|(s, l)| *s += l / total);
        }
    }
    let total: f64 = sum.iter().sum();
    let mut at = 0.0;
    let mut out = vec![0.0];
    for s in sum {
        at += s / total;
        out.push(at);
    }
    out[steps as usize] = 1.0;
    let usable = out.windows(2).all(|w| w[1] - w[0] > 10.0 * CLOSE);
    if usable { out } else { (0..=steps).map(|k| f64::from(k) / f64::from(steps)).collect() }
}

/// Joins chain curves over the given positions of their vertices. The stops of polylines lie at the positions of their
/// vertices, so that those of opposite sides agree; a spline is mapped as a whole.
fn compose(pieces: &[(Vec<f64>, ChainCurve)], points: &[DVec3]) -> Result<Side> {
    let all_straight = pieces.iter().all(|(_, c)| matches!(c.shape, Shape::Polyline(_)));
    let mut curves = Vec::with_capacity(pieces.len());
    let mut parameters = vec![0.0];
    let mut from = 0;
    for (at, chain) in pieces {
        let last = at.len() - 1;
        let (a, b) = (at[0], at[last]);
        match &chain.shape {
            Shape::Spline(c) => {
                parameters.extend(chain.parameters.iter().skip(1).map(|t| a + t * (b - a)));
                curves.push(c.clone().rescaled([a, b]));
            }
            Shape::Polyline(stops) => {
                for w in stops.windows(2) {
                    let (i, j) = (w[0] as usize, w[1] as usize);
                    let (s, e) = (chain.parameters[i], chain.parameters[j]);
                    let share = |t: f64| at[i] + (t - s) / (e - s) * (at[j] - at[i]);
                    parameters.extend((i + 1..=j).map(|k| if k == j { at[j] } else { share(chain.parameters[k]) }));
                }
                let breaks: Vec<f64> = stops.iter().map(|&k| at[k as usize]).collect();
                let corners = stops.iter().map(|&k| points[from + k as usize]).collect();
                let line = BSplineCurve::new(Knots::from_breaks(1, &breaks, 1)?, corners)?;
                curves.push(if all_straight { line } else { line.elevated()? });
            }
        }
        from += last;
    }
    Ok(Side { curve: BSplineCurve::joined(&curves)?, parameters })
}
