//! Boundary layers: thin cells on the wall whose thickness grows inwards by a constant factor, as flow solvers need
//! them.
//!
//! Padding (section 4 of the paper) graded: the whole mesh shrinks by the thickness of all layers, and these fill the gap.
//!
//! ```text
//!   p ──┬──┬── wall          p ──┬──┬──   first
//!       │  │                   ──┼──┼──   first × growth
//!       │  │        →          ──┼──┼──   first × growth²
//!       │  │                 q ──┼──┼──
//!     ──┴──┴──                 ──┴──┴──
//! ```
//!
//! 1. Every wall vertex p gets a place q inside, along the wall's normal (at the rim of an end: in the plane of that), so
//!    far that the layers have the thickness asked for; less where the room to the opposite wall is narrow.
//! 2. The vertices inside follow: a harmonic displacement shrinks a round section in proportion.
//! 3. Where cells would become weak, or lose their certificate, the inside is smoothed; what stays weak is given thinner layers
//!    around it, and 2 is done again.
//! 4. The inside is smoothed with its boundary held.
//!
//! `wall` does 1, thins, and makes the cells; `inside` does 2.

mod inside;
mod options;
mod wall;

use super::optimise::{Effort, FINE, INNER, Optimiser};
use super::{HexResult, MOST_HEXES};
use crate::context::Context;
use crate::error::{Error, Result};
use crate::mesh::{HexMesh, UnitScale};
use glam::DVec3;
use inside::Inside;
use wall::Wall;

pub use options::{GROWTH, LayerFigures, Layers, MOST_LAYERS, STEEPEST};
pub(super) use wall::{planes, within};

/// Cells inside keep this share of their scaled Jacobian when they shrink.
const KEPT_WHEN_SHRINKING: f64 = 0.4;
/// Rounds in which the inside is smoothed and layers are thinned around cells that stay weak; after these all layers are halved.
/// Each takes as long as smoothing the mesh does.
const THINNING_ROUNDS: usize = 16;
/// Rounds after which layers are thinned one ring farther: what stays weak has its reason farther away.
const ROUNDS_PER_RING: usize = 4;
/// Where that is not enough all of the wall's are halved, so often at most.
const HALVINGS: usize = 6;
/// Rings of cells around a weak one whose wall vertices are thinned at first.
const THINNED_RINGS: usize = 2;
/// The user is told where they are on less than this share of the wall.
const MOST_OF_THE_WALL: f64 = 0.95;

impl LayerFigures {
    /// What is to be said where the layers are thinner than asked.
    pub(super) fn warning(&self) -> Option<String> {
        let ([x, y, z], share, least) = (self.least_at, 100.0 * (1.0 - self.as_asked), self.least);
        (self.as_asked < MOST_OF_THE_WALL).then(|| {
            format!(
                "the layers are not as thick as asked on {share:.1}% of the wall, because there is no room; least {least:.2} \
                 of the thickness near {x:.6} {y:.6} {z:.6}"
            )
        })
    }

    pub(super) fn in_scale(self, scale: UnitScale) -> LayerFigures {
        LayerFigures {
            asked: self.asked.in_scale(scale),
            thickness: scale.length(self.thickness),
            least_at: scale.point(DVec3::from(self.least_at)).to_array(),
            ..self
        }
    }
}

/// Puts layers on the wall of a mesh that has its boundary and tags.
pub fn add(result: &mut HexResult, layers: Layers, context: &Context) -> Result<()> {
    let _stage = context.stage("layers");
    let of_wall = result.mesh.tags.iter().filter(|tag| **tag == 1).count() as f64;
    if result.mesh.hexes.len() as f64 + f64::from(layers.count) * of_wall > MOST_HEXES {
        return Err(Error::Options(format!("{} layers would take too many hexes", layers.count)));
    }
    let (wall, points) = shrunk(&result.mesh, &layers, context)?;
    let figures = wall.figures(&result.mesh, &points, layers);
    result.figures.layers = Some(figures);
    wall.fill(&mut result.mesh, points, &layers)?;
    let outermost = |k: usize| (result.bases.len() + (k + 1) * layers.count as usize - 1) as u32;
    let outermost: Vec<u32> = (0..wall.vertices.len()).map(outermost).collect();
    wall.vertices.iter().zip(&outermost).for_each(|(&v, &out)| result.bases[v as usize] = out);
    result.bases.extend(outermost.iter().flat_map(|&out| std::iter::repeat_n(out, layers.count as usize)));
    result.origins = (0..result.mesh.quads.len() as u32).collect();
    Ok(())
}

/// The wall with the thickness that its layers can have, and the places of the vertices of the mesh behind them.
fn shrunk(mesh: &HexMesh, layers: &Layers, context: &Context) -> Result<(Wall, Vec<DVec3>)> {
    let mut wall = Wall::of(mesh, layers.thickness());
    let inside = Inside::of(mesh, &wall);
    let optimiser = Optimiser::new(&mesh.points, &mesh.hexes);
    let floors: Vec<f64> = optimiser.qualities(&mesh.points).into_iter().map(|q| KEPT_WHEN_SHRINKING * q).collect();
    let mut moves = vec![DVec3::ZERO; mesh.points.len()];
    let mut points = mesh.points.clone();
    for round in 0..THINNING_ROUNDS + HALVINGS {
        context.check()?;
        inside.follow(&wall, &mut moves, context)?;
        points = mesh.points.iter().zip(&moves).map(|(p, m)| *p + *m).collect();
        let mut weak = optimiser.weak(&points, &floors);
        if !weak.is_empty() && round < THINNING_ROUNDS {
            let smoothed = smoothed(mesh, &mesh.points, &wall, points.clone(), &FINE, context)?;
            let left = optimiser.weak(&smoothed, &floors);
            if left.len() < weak.len() {
                (points, weak) = (smoothed, left);
            }
        }
        weak.extend(wall.weak_columns(mesh, &points, layers).map(|f| wall.cells[f]));
        tracing::debug!(round, weak = weak.len(), "layers");
        if weak.is_empty() {
            break;
        }
        weak.sort_unstable();
        weak.dedup();
        if round < THINNING_ROUNDS {
            wall.thin(&inside.wall_near(mesh, &wall, &weak, THINNED_RINGS + round / ROUNDS_PER_RING));
            wall.even_out(mesh);
        } else {
            wall.thickness.iter_mut().for_each(|t| *t *= 0.5);
            moves.iter_mut().for_each(|m| *m *= 0.5);
        }
    }
    let points = smoothed(mesh, &points, &wall, points.clone(), &INNER, context)?;
    Ok((wall, points))
}

/// The places of the vertices when the inside has been smoothed, with the lengths that cells have at others, `like`.
fn smoothed(
    mesh: &HexMesh,
    like: &[DVec3],
    wall: &Wall,
    mut points: Vec<DVec3>,
    effort: &Effort,
    context: &Context,
) -> Result<Vec<DVec3>> {
    let mut inner = Optimiser::new(like, &mesh.hexes);
    inner.fix(wall.on_boundary.clone());
    inner.run(&mut points, effort, context)?;
    Ok(points)
}
