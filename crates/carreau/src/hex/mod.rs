//! Hexahedral meshes of tubular shapes, from their skeleton.
//!
//! Viville, Kraemer, Bechmann, "Génération de maillage hexaédrique à partir d'un squelette", Journées du groupe de travail
//! en modélisation géométrique 2020. A skeleton (nodes with radii, segments) becomes a mesh of hexes along its branches. Four
//! hexes stand about every segment; a partition of the sphere into quads at every node says how they are joined there.
//!
//! | stage, in the order of the calls | section | file |
//! |---|---|---|
//! | options; the result | | `options`, `choices`, `result` |
//! | **skeletons**: the driver | | `tubes` |
//! | nodes where a branch turns back within a ball are dropped | | `u_turns` |
//! | stubs are dropped; narrow forks get a trunk | | `resample`, `fork_trunks` |
//! | branches are resampled in proportion to the radius, for the size asked for | | `resample`, `size` |
//! | radii that leave no room are reduced | | `ring_room` |
//! | check that the result still represents the input: every input node lies inside | | `coverage` |
//! | **surfaces**: the driver, and its fallbacks | | `surface`, `surface::fallbacks` |
//! | flat ends of closed tubes | | `ends` |
//! | the skeleton is prepared: extremities, webs, hubs, meeting points of many branches | | `surface::prepared`, `tips`, `webs`, `hubs`, `junction_centres` |
//! | **cells**, the same for both from here on | | `cells` |
//! | connection surfaces of the branchings; cubic junctions at right angles | 3.2 | `connection`, `cubic` |
//! | frames along the branches | 3.1 | `frames` |
//! | the base mesh: hexes joined at the nodes | 3.1 | `assemble` |
//! | padding, halving across and along | 4 | `refine` |
//! | cells inserted where branches grow thick | | `insert` |
//! | untangling, smoothing, certificate | | `optimise` |
//! | **fit** to the surface: sections flattened; segments halved where the surface is far | | `flat_sections`, `adapt` |
//! | the surface, the boundary of the mesh, and how the one is pulled to the other | | `target`, `boundary`, `boundary_fit` |
//! | vertices sent to where the surface is far; ridges of the boundary stay | | `far_surface`, `ridges` |
//! | **delivery**: boundary, tags, certificate | | `deliver` |
//! | boundary layers, straight pieces at the ends, cells of second order | | `layers`, `extend`, `disc`, `second_order`, `middle_nodes` |
//! | distance and overlap are judged; figures | | `judge`, `overlap`, `figures` |
//!
//! Departures from the paper, each explained in its file: the best of many partitions instead of one heuristic's; a rule for
//! the first ring at a branching; residual twist spread by arc length, on rings too; an energy that untangles instead of
//! linear smoothing; and a certificate for every cell.

mod adapt;
mod assemble;
mod boundary;
mod boundary_fit;
mod cells;
mod choices;
mod connection;
mod coverage;
mod cubic;
mod deliver;
mod disc;
mod ends;
mod extend;
mod far_surface;
mod figures;
mod flat_sections;
mod fork_trunks;
mod frames;
mod hubs;
mod insert;
mod judge;
mod junction_centres;
mod layers;
mod middle_nodes;
mod optimise;
mod options;
mod overlap;
mod refine;
mod resample;
mod result;
mod ridges;
mod ring_room;
mod second_order;
mod size;
#[cfg(test)]
mod star_tests;
mod surface;
mod target;
#[cfg(test)]
mod tests;
mod tips;
mod tubes;
mod u_turns;
mod validate;
mod webs;

pub use choices::{Order, Padding, Stage};
pub use figures::{Figures, HexQuality};
pub use judge::MAX_DISTANCE;
pub use layers::{GROWTH, LayerFigures, Layers, MOST_LAYERS};
pub use middle_nodes::{MiddleOf, StraightEdges};
pub use options::{HexOptions, LONGEST_EXTENSION, MOST_HALVINGS, MOST_HEXES};
pub use overlap::Uncovered;
pub use result::HexResult;
pub use surface::from_surface;
pub use validate::Validity;

use crate::context::Context;
use crate::error::Result;
use crate::mesh::{CurveNet, HexMesh};

/// Meshes a skeleton.
///
/// ```
/// use carreau::mesh::CurveNet;
/// use carreau::{Context, DVec3, hex};
/// let fork = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [3.5, 1.0, 0.0], [3.5, -1.0, 0.0]].map(DVec3::from);
/// let net = CurveNet::new(fork.to_vec(), vec![0.3, 0.3, 0.2, 0.2], vec![[0, 1], [1, 2], [1, 3]]);
/// let filled = hex::from_net(&net, &hex::HexOptions::default(), &Context::new())?;
/// assert!(filled.figures.quality.certified);
/// # Ok::<(), carreau::Error>(())
/// ```
///
/// # Errors
/// [`Error::Input`](crate::Error::Input) for a net without any segment of positive length, [`Error::Options`](crate::Error::Options) for options that make no sense,
/// [`Error::Numeric`](crate::Error::Numeric) when a cell cannot be certified and `allow_invalid` is not set.
pub fn from_net(net: &CurveNet, options: &HexOptions, context: &Context) -> Result<HexResult> {
    options.validate()?;
    let mut result = tubes::meshed(net, options, context)?;
    result.warnings.extend(judge::overlap_line(&result));
    judge::tell(&mut result);
    Ok(result)
}

/// The coarsest mesh of a net as it is, without any optimisation: what the speed of the construction is measured by.
pub fn base_mesh(net: &CurveNet) -> HexMesh {
    let base = assemble::base_mesh(net, false);
    HexMesh { points: base.points, hexes: base.hexes, ..HexMesh::default() }
}
