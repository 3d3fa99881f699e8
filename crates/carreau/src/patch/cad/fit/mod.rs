//! Bicubic surfaces near the patches instead of exact ones through every vertex: smaller files, smoother shapes.
//!
//! | file | stage |
//! |---|---|
//! | `curve` | every chain is fitted once; both its faces use the same curve |
//! | `side` | the curves of a side are joined, with knots of full multiplicity at nodes in between |
//! | `surface` | between given sides the inner control points are fitted and the knots refined |
//! | `stencil` | the equations of that, solved |
//!
//! Sides are never changed by a surface, so neighbours meet without gap or tolerance (C0), at T-nodes, too. A surface must
//! keep the tolerance, and must not bend inside; otherwise the block is left to the next rung.

mod curve;
pub mod side;
mod stencil;
mod surface;

use super::chain::Chains;
use super::piece::Block;
use super::runs::Curves;
use super::scene::Scene;
use crate::error::Result;
use crate::geometry::bspline::{BSplineSurface, Knots};
pub use curve::{ChainCurve, Shape};
use side::Frame;
use surface::Problem;

/// Largest angle by which a surface may bend at an inner knot, by its cosine (one degree).
const KNOT_BEND: f64 = 0.999_85;
/// Places at which a line is looked at for bends.
const PLACES: u32 = 8;

/// A bicubic face to be.
#[derive(Clone)]
pub struct Smooth {
    pub surface: BSplineSurface,
    /// Parameters of the vertices on the sides v = 0, u = 1, v = 1, u = 0.
    pub border: [Vec<f64>; 4],
    /// Largest distance of a vertex inside or on the border.
    pub deviation: f64,
}

/// A bicubic surface between the curves of a block's chains, if there is one within the tolerance that bends nowhere.
pub fn smooth(
    scene: &Scene,
    block: Block,
    number: usize,
    chains: &Chains,
    curves: &Curves,
    tolerance: f64,
) -> Result<Option<Smooth>> {
    let uses = &chains.loops[number][0];
    let kinked = |c: &ChainCurve| matches!(&c.shape, Shape::Polyline(stops) if stops.len() > 2);
    let of_use: Vec<ChainCurve> = uses.iter().map(|of| curves.of(&chains.paths[of.chain as usize])).collect();
    if of_use.iter().any(kinked) {
        return Ok(None);
    }
    let scale = side::scale(scene, &block);
    let frame = Frame::new(scene, &block, &scale, uses, chains, curves)?;
    // Refinement between sides that need many control points themselves may double them.
    let limit = 2 * (block.size[0] as usize + 1) * (block.size[1] as usize + 1);
    let Some(fit) = Problem::new(scene, &block, &frame, tolerance, limit.max(16)).solve()? else { return Ok(None) };
    let deviation = of_use.iter().map(|c| c.deviation).fold(fit.deviation, f64::max);
    if bends(&fit.surface) {
        return Ok(None);
    }
    Ok(Some(Smooth { surface: fit.surface, border: frame.sides.map(|side| side.parameters), deviation }))
}

/// Whether the normal jumps across a knot at which the surface is only continuous.
fn bends(surface: &BSplineSurface) -> bool {
    let [u, v] = surface.knots();
    let jumps = |knots: &Knots, other: &Knots, normal: &dyn Fn(f64, f64) -> glam::DVec3| {
        let [a, b] = other.domain();
        let [low, high] = knots.domain();
        let step = 1e-7 * (high - low);
        knots.distinct().filter(|&(t, times)| t > low && t < high && times >= knots.degree()).any(|(t, _)| {
            (0..=PLACES).map(|k| a + (b - a) * f64::from(k) / f64::from(PLACES)).any(|s| {
                let (before, behind) = (normal(t - step, s), normal(t + step, s));
                before.dot(behind) < KNOT_BEND * before.length() * behind.length()
            })
        })
    };
    let normal = |u: f64, v: f64| {
        let jet = surface.jet(u, v);
        jet.first[0].cross(jet.first[1])
    };
    jumps(u, v, &|t, s| normal(t, s)) || jumps(v, u, &|t, s| normal(s, t))
}
