//! The room's options, their checks, and an estimate of the number of cells that they lead to.

use super::choices::{Order, Padding, Stage};
use super::cubic::{self, Cube};
use super::insert;
use super::layers::{self, Layers, MOST_LAYERS};
use crate::bounds::{positive, within};
use crate::error::{Error, Result};
use crate::mesh::{CurveNet, UnitScale};
use serde::{Deserialize, Serialize};
use std::ops::Bound;

/// Options of [`from_net`](super::from_net).
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct HexOptions {
    /// Where a layer is put.
    pub padding: Padding,
    /// Number of times that every cell is halved across its axis, the layer included. `None`: 0 for skeletons, as many as the
    /// shape needs for surfaces.
    pub refine_across: Option<u32>,
    /// Number of times that every cell is halved along its axis.
    pub refine_along: u32,
    /// Insert cells where a branch is more than twice as thick as where it is thinnest. Has no effect on surfaces.
    pub adapt_radius: bool,
    /// How much the skeleton is cleaned up before it is meshed.
    pub stage: Stage,
    /// Target number of hexes (an upper bound). Sets the step length along the branches.
    pub hexes: Option<usize>,
    /// Step length along the branches, in the unit of the file; excludes `hexes`.
    pub edge_length: Option<f64>,
    /// One radius for all nodes, in the unit of the file.
    pub radius: Option<f64>,
    /// Boundary layers on the wall, in addition to the layer that `padding` makes.
    pub layers: Option<Layers>,
    /// Length of the straight piece added at every end, in radii of the end.
    pub extend: Option<f64>,
    /// Order of the cells. Second order adds nodes in the middle of edges and faces; those on the boundary lie on the surface.
    pub order: Order,
    /// Return the mesh even if some cells could not be certified (otherwise an error).
    pub allow_invalid: bool,
    /// Largest two-sided distance between cells and surface, in the unit of the file. `None`:
    /// [`MAX_DISTANCE`](super::MAX_DISTANCE) of the diagonal.
    pub max_distance: Option<f64>,
    /// Return the mesh even if it is farther than that from the surface, or if cells overlap (otherwise an error).
    pub allow_far: bool,
}

/// Most levels of halving: each multiplies the number of cells by up to four.
pub const MOST_HALVINGS: u32 = 6;
/// Longest straight piece at an end, in radii: a hundred diameters, after which flow in a pipe is fully developed.
pub const LONGEST_EXTENSION: f64 = 200.0;
/// Most hexes: at up to 170 bytes each the mesh alone takes 8.5 GB.
pub const MOST_HEXES: f64 = 5e7;

impl HexOptions {
    /// Refuses values out of range, and those that contradict each other.
    ///
    /// # Errors
    /// [`Error::Options`].
    pub fn validate(&self) -> Result<()> {
        within("refine-across", self.refine_across(), 0..=MOST_HALVINGS, "")?;
        within("refine-along", self.refine_along, 0..=MOST_HALVINGS, "")?;
        if self.hexes.is_some() && self.edge_length.is_some() {
            return Err(Error::Options("give a number of hexes or an edge length, not both".into()));
        }
        if self.stage == Stage::Base && (self.hexes.is_some() || self.edge_length.is_some()) {
            return Err(Error::Options("stage base takes the graph as it is: it has no size to be set".into()));
        }
        if self.stage == Stage::Base && self.adapt_radius {
            return Err(Error::Options("stage base takes the graph as it is: no cells are inserted".into()));
        }
        if self.hexes == Some(0) {
            return Err(Error::Options("the number of hexes must be at least 1".into()));
        }
        let lengths = [("edge length", self.edge_length), ("radius", self.radius), ("max-distance", self.max_distance)];
        for (name, length) in lengths {
            if length.is_some_and(|l| !(l > 0.0 && l.is_finite())) {
                return Err(Error::Options(format!("the {name} must be positive")));
            }
        }
        if let Some(layers) = self.layers {
            within("layers", layers.count, 1..=MOST_LAYERS, "")?;
            positive("first-layer", layers.first)?;
            within("growth", layers.growth, 1.0..=layers::STEEPEST, "")?;
        }
        if let Some(radii) = self.extend {
            within("extend", radii, (Bound::Excluded(0.0), Bound::Included(LONGEST_EXTENSION)), "radii")?;
        }
        Ok(())
    }

    /// The options for a model in another scale.
    pub(super) fn in_scale(&self, scale: UnitScale) -> HexOptions {
        let lengths = [self.edge_length, self.radius, self.max_distance];
        let [edge_length, radius, max_distance] = lengths.map(|l| l.map(|l| scale.length(l)));
        let layers = self.layers.map(|l| l.in_scale(scale));
        HexOptions { edge_length, radius, max_distance, layers, ..self.clone() }
    }

    pub(super) fn refine_across(&self) -> u32 {
        self.refine_across.unwrap_or(0)
    }

    /// Hexes of a net with this many segments and ends.
    pub(super) fn hexes_of(&self, segments: usize, ends: usize) -> f64 {
        let (k, n) = (f64::from(1 << self.refine_across()), f64::from(1 << self.refine_along));
        let (per_segment, per_end) = match self.padding {
            Padding::None => (4.0, 0.0),
            Padding::Sides => (12.0, 0.0),
            Padding::All => (12.0, 4.0),
        };
        per_segment * k * k * n * segments as f64 + per_end * k * k * k * ends as f64
    }

    /// Hexes of a net at most: as if all branchings that may be cubic were.
    pub(super) fn most_hexes(&self, net: &CurveNet) -> f64 {
        let around = net.incidence();
        let mut sum = self.hexes_of(net.edges.len(), around.tips().count());
        if self.stage == Stage::Full {
            let k = f64::from(1 << self.refine_across());
            let layer = if self.padding == Padding::None { 0 } else { 4 };
            let of = |v: u32| {
                let cube = Cube::of(&cubic::directions(net, &around, v))?;
                Some(8 + layer * cube.open_faces().count())
            };
            sum += k * k * k * (0..net.points.len() as u32).filter_map(of).sum::<usize>() as f64;
            if self.adapt_radius {
                let [along, ends] = insert::count(net, &insert::levels(net), self.padding);
                sum += k * k * (along * f64::from(1 << self.refine_along) + ends * k);
            }
        }
        sum
    }
}

/// Refuses steps so short that the hexes would be too many, before any is made.
pub(super) fn check_steps(net: &CurveNet, options: &HexOptions) -> Result<()> {
    let Some(step) = options.edge_length else { return Ok(()) };
    let length: f64 = (0..net.edges.len()).map(|e| net.length(e)).sum();
    let expected = (length / step) * options.hexes_of(1, 0);
    if expected > MOST_HEXES {
        return Err(Error::Options(format!("about {expected:.1e} hexes would be made; ask for longer edges")));
    }
    Ok(())
}

pub(super) fn check_size(net: &CurveNet, options: &HexOptions) -> Result<()> {
    let expected = options.most_hexes(net);
    if expected > MOST_HEXES {
        return Err(Error::Options(format!(
            "about {expected:.1e} hexes would be made; ask for fewer hexes or longer edges"
        )));
    }
    Ok(())
}
