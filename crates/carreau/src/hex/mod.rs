//! Hexahedral meshes of tubular shapes from their skeleton.
//!
//! Viville, Kraemer, Bechmann, "Génération de maillage hexaédrique à partir d'un squelette", Journées du groupe de travail
//! en modélisation géométrique 2020. A skeleton (nodes with radii, segments) becomes a mesh of hexes that follow its
//! branches: a partition of the sphere into quads at every node says how the four hexes about each segment are joined.
//!
//! | stage | file |
//! |---|---|
//! | nodes where a branch turns back within a ball go | `turns` |
//! | narrow forks get a trunk | `zip` |
//! | stubs go, branches get nodes in proportion to the radius | `resample` |
//! | radii that leave no room are reduced | `limit` |
//! | whether the result stands for the skeleton that was given | `cover` |
//! | of the branches in a web, as an ear is one, the longest stays | `web` |
//! | where many branches of a surface meet | `meet` |
//! | connection surfaces of the branchings | `connection` |
//! | branchings at right angles | `cubic` |
//! | frames along the branches | `frames` |
//! | hexes and sewing | `sew` |
//! | padding, halving across and along | `refine` |
//! | cells as flat as the sections of a surface | `oval` |
//! | segments halved where a surface is far | `adapt` |
//! | flat ends of closed tubes | `ends` |
//! | the surface, the boundary of the mesh, and how the one comes to the other | `target`, `skin`, `fit` |
//! | vertices that go to where the surface is far | `reach` |
//! | cells inserted where branches grow thick | `insert` |
//! | untangling, smoothing, certificate | `optimise` |
//! | boundary, tags, certificate | `deliver` |
//! | boundary layers | `layers` |
//! | straight pieces at the ends | `extend` |
//! | cells of second order | `second_order` |
//! | how far the result is from the surface, what lies where it should not | `judge` |
//! | figures of the result | `figures` |
//!
//! Departures from the paper, each explained in its file: the best of many partitions instead of one heuristic's, a
//! rule for the first ring at a branching, residual twist spread by arc length on rings too, an energy that untangles
//! instead of linear smoothing, and a certificate for every cell.

mod adapt;
mod connection;
mod cover;
mod cubic;
mod deliver;
mod ends;
mod extend;
mod figures;
mod fit;
mod frames;
mod insert;
mod judge;
mod layers;
mod limit;
mod meet;
mod optimise;
mod oval;
mod reach;
mod refine;
mod resample;
mod second_order;
mod sew;
mod skin;
#[cfg(test)]
mod star_tests;
mod surface;
mod target;
#[cfg(test)]
mod tests;
mod tips;
mod turns;
mod validate;
mod web;
mod zip;

pub use figures::{Figures, HexQuality};
pub use judge::{MAX_DISTANCE, Uncovered};
pub use layers::{GROWTH, LayerFigures, Layers, MOST_LAYERS};
pub use second_order::{MiddleOf, StraightEdges};
pub use surface::from_surface;
pub use validate::Validity;

use crate::bounds::{positive, within};
use crate::context::Context;
use crate::error::{Error, Result};
use crate::geometry::hexes::{scaled_jacobian, uncertified};
use crate::mesh::{CurveNet, HexMesh, RawMesh, RepairedNet, UnitScale};
use cubic::Cube;
use glam::DVec3;
use optimise::{COARSE, Effort, FINE, Optimiser, PASSING, Spring, relieve};
use refine::{CORE, TubeMesh};
use resample::Step;
use rustc_hash::FxHashSet;
use serde::{Deserialize, Serialize};
use sew::BaseMesh;
use std::ops::Bound;

/// Where a layer of hexes is put.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Padding {
    /// Nowhere.
    None,
    /// On the wall: every hex is cut in three across its axis.
    Sides,
    /// On the whole boundary, ends included: no hex has two boundary faces.
    #[default]
    All,
}

/// How far the skeleton is worked on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Stage {
    /// The graph as given: one segment, one ring of hexes.
    Base,
    /// Stubs go, and nodes are set anew.
    #[default]
    Full,
}

/// The order of the cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(try_from = "OrderNumber", into = "u8")]
pub enum Order {
    /// Straight edges: 8 corners.
    #[default]
    First,
    /// Edges with a node in the middle, which bends them: 27 nodes, or 20.
    Second,
}

/// The order as a number, or as a command line has it.
#[derive(Deserialize)]
#[serde(untagged)]
enum OrderNumber {
    Number(u8),
    Word(String),
}

impl TryFrom<OrderNumber> for Order {
    type Error = Error;

    fn try_from(order: OrderNumber) -> Result<Order> {
        let word = match order {
            OrderNumber::Number(number) => number.to_string(),
            OrderNumber::Word(word) => word,
        };
        match word.as_str() {
            "1" => Ok(Order::First),
            "2" => Ok(Order::Second),
            _ => Err(Error::Options(format!("the order of the cells is {word}, it must be 1 or 2"))),
        }
    }
}

impl From<Order> for u8 {
    fn from(order: Order) -> u8 {
        match order {
            Order::First => 1,
            Order::Second => 2,
        }
    }
}

/// Options of [`from_net`].
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct HexOptions {
    /// Where a layer is put.
    pub padding: Padding,
    /// How often every cell is halved across its axis, the layer included; none: not at all, or what a surface needs.
    pub refine_across: Option<u32>,
    /// How often every cell is halved along its axis.
    pub refine_along: u32,
    /// Cells are inserted where a branch is more than twice as thick as where it is thinnest. Not for surfaces.
    pub adapt_radius: bool,
    /// How far the skeleton is worked on.
    pub stage: Stage,
    /// About this many hexes: sets the length of the steps along the branches.
    pub hexes: Option<usize>,
    /// Length of the steps along the branches, in the unit of the file; exclusive with `hexes`.
    pub edge_length: Option<f64>,
    /// One radius for all nodes, in the unit of the file.
    pub radius: Option<f64>,
    /// Boundary layers on the wall, besides the layer that `padding` makes.
    pub layers: Option<Layers>,
    /// Every end is lengthened by a straight piece of so many of its radii.
    pub extend: Option<f64>,
    /// Cells have nodes in the middle of their edges and faces, those of the boundary on the surface.
    pub order: Order,
    /// Cells without a certificate are delivered.
    pub allow_invalid: bool,
    /// The largest distance between cells and surface, either way, in the unit of the file; none: [`MAX_DISTANCE`] of the diagonal.
    pub max_distance: Option<f64>,
    /// Cells farther than that from the surface, or where others are, are delivered.
    pub allow_far: bool,
}

/// Levels of halving that are accepted.
pub const MOST_HALVINGS: u32 = 6;
/// Ends are lengthened by no more than this, in their radii: a hundred diameters, after which flow in a pipe has settled.
pub const LONGEST_EXTENSION: f64 = 200.0;
/// More hexes are refused.
pub const MOST_HEXES: f64 = 5e7;
/// Steps along the branches, in radii, where no size is asked for.
const STEP: f64 = 1.5;
/// More segments than this are not made without being asked for: the steps grow instead.
const MANY_SEGMENTS: usize = 1500;
/// Steps are at most this long, in radii; longer than the first ones only where these are too many.
const LONGEST: [f64; 2] = [1e3, 1e12];
/// Thinner and thinner layers, tried where one of the usual thickness folds.
const CORES: [f64; 4] = [0.75, 0.88, 0.95, 0.98];
/// Branchings closer than this share of the smaller radius become one.
const MERGE: f64 = 0.3;
/// Angles in degrees: directions closer than the first get a trunk, up to where they are as far apart as the second.
const FORKS: [f64; 2] = [zip::CLOSE_DEGREES, zip::APART_DEGREES];
/// What is tried where the least scaled Jacobian is below [`LEAST`] and cells are not more than [`FEW_HEXES`]: trunks from
/// more branches have forks with wider angles, but depart farther from what was drawn.
const OTHER_FORKS: [[f64; 2]; 2] = [[42.0, 55.0], [36.0, 48.0]];
const LEAST: f64 = 0.3;
const FEW_HEXES: usize = 50_000;
/// Vertices at nodes this near to one that lies outside are held, in its radii.
const NEAR: f64 = 2.0;
/// Strength of the springs: of ends to their planes, of the wall to its radius and across it, of nodes to their places.
const PLANE: f64 = 10.0;
const WALL: f64 = 0.3;
const NODE: f64 = 0.3;
const WEAK: f64 = 0.02;

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
            return Err(Error::Options("the number of hexes must be positive".into()));
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
    fn in_scale(&self, scale: UnitScale) -> HexOptions {
        let lengths = [self.edge_length, self.radius, self.max_distance];
        let [edge_length, radius, max_distance] = lengths.map(|l| l.map(|l| scale.length(l)));
        let layers = self.layers.map(|l| l.in_scale(scale));
        HexOptions { edge_length, radius, max_distance, layers, ..self.clone() }
    }

    fn refine_across(&self) -> u32 {
        self.refine_across.unwrap_or(0)
    }

    /// Hexes of a net with this many segments and ends.
    fn hexes_of(&self, segments: usize, ends: usize) -> f64 {
        let (k, n) = (f64::from(1 << self.refine_across()), f64::from(1 << self.refine_along));
        let (per_segment, per_end) = match self.padding {
            Padding::None => (4.0, 0.0),
            Padding::Sides => (12.0, 0.0),
            Padding::All => (12.0, 4.0),
        };
        per_segment * k * k * n * segments as f64 + per_end * k * k * k * ends as f64
    }

    /// Hexes of a net at most: as if all branchings that may be cubic were.
    fn most_hexes(&self, net: &CurveNet) -> f64 {
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

/// A hex mesh of a skeleton.
#[derive(Debug, Clone)]
pub struct HexResult {
    /// The mesh: boundary quads tagged 1 on the wall, 2, 3 … on the ends.
    pub mesh: HexMesh,
    /// The skeleton that was meshed, after clean-up.
    pub skeleton: CurveNet,
    /// What the mesh achieves.
    pub figures: Figures,
    /// What the user should know.
    pub warnings: Vec<String>,
    /// For every boundary face the one that it continues: itself, but for those that lengthen an end.
    pub origins: Vec<u32>,
    /// The tags of ends that are flat pieces of the surface itself, and no open ends.
    pub flat_caps: Vec<i32>,
    /// The nodes of second order, where they were asked for.
    pub second_order: Option<MiddleOf>,
    /// For every vertex the one of the wall that it lies under in a layer, or of an end that it was drawn from; else itself.
    bases: Vec<u32>,
}

impl HexResult {
    /// What is written into a file: the mesh, with its nodes of second order where it has some.
    pub fn raw(&self) -> RawMesh {
        let raw = RawMesh::from(self.mesh.clone());
        match &self.second_order {
            Some(middle) => raw.with_second_order(middle.nodes.clone(), &middle.places),
            None => raw,
        }
    }

    /// The result in another scale.
    fn in_scale(mut self, scale: UnitScale) -> HexResult {
        self.mesh.points.iter_mut().for_each(|p| *p = scale.point(*p));
        self.figures.quality.volume = scale.back().volume(self.figures.quality.volume);
        judge::in_scale(&mut self, scale);
        self.second_order = self.second_order.take().map(|s| s.in_scale(scale));
        HexResult { skeleton: scale.moved_net(self.skeleton), ..self }
    }
}

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
/// [`Error::Input`] for a net without any segment of positive length, [`Error::Options`] for options that make no sense,
/// [`Error::Numeric`] when a cell cannot be certified and `allow_invalid` is not set.
pub fn from_net(net: &CurveNet, options: &HexOptions, context: &Context) -> Result<HexResult> {
    options.validate()?;
    let mut result = meshed(net, options, context)?;
    result.warnings.extend(judge::overlap_line(&result));
    judge::tell(&mut result);
    Ok(result)
}

/// The mesh, not yet judged.
fn meshed(net: &CurveNet, options: &HexOptions, context: &Context) -> Result<HexResult> {
    let scale = UnitScale::of_net(net);
    if let Some(net) = scale.net(net) {
        return Ok(meshed(&net, &options.in_scale(scale), context)?.in_scale(scale.back()));
    }
    let mut best = Meshed::new(net, FORKS, options, context)?;
    let incidence = net.incidence();
    let has_forks = (0..net.points.len() as u32).any(|v| incidence.valence(v) > 2);
    for forks in OTHER_FORKS {
        let may_gain = has_forks && best.least < LEAST && best.tube.hexes.len() <= FEW_HEXES;
        if !may_gain || options.stage == Stage::Base {
            break;
        }
        let other = match Meshed::new(net, forks, options, context) {
            Err(Error::Numeric(_)) => continue,
            other => other?,
        };
        if (other.lacking, -other.least) < (best.lacking, -best.least) {
            best = other;
        }
    }
    let Meshed { lacking: [_, outside], tube, base, net, mut warnings, .. } = best;
    warn_of_poor(&base, &mut warnings);
    if outside > 0 {
        warnings.push(format!("{outside} nodes of the skeleton lie outside of the cells"));
    }
    let mut result = deliver::with_boundary(tube, net, warnings, options, context)?;
    deliver::certify(&mut result, options)?;
    deliver::finish(&mut result, options, None, context)?;
    Ok(result)
}

/// The mesh of a skeleton that was made ready in one of several ways.
struct Meshed {
    /// Cells without a certificate, and nodes outside of the cells.
    lacking: [usize; 2],
    /// The least scaled Jacobian.
    least: f64,
    tube: TubeMesh,
    base: BaseMesh,
    /// The skeleton made ready.
    net: CurveNet,
    warnings: Vec<String>,
}

impl Meshed {
    fn new(net: &CurveNet, forks: [f64; 2], options: &HexOptions, context: &Context) -> Result<Meshed> {
        let (given, net, warnings) = prepare(net, forks, options, context)?;
        let mut best: Option<([usize; 2], TubeMesh, BaseMesh)> = None;
        let mut held = Vec::new();
        for _ in 0..2 {
            let base = valid_base(&net, options.stage == Stage::Full, &held, context)?;
            let tube = refined(&net, &base, &held, options, context)?;
            let outside = cover::outside_cells(&given, &tube);
            let lacking = [uncertified(&tube.points, &tube.hexes).len(), outside.len()];
            if best.as_ref().is_none_or(|b| lacking < b.0) {
                best = Some((lacking, tube, base));
            }
            if outside.is_empty() {
                break;
            }
            held = outside.iter().map(|&v| (given.points[v as usize], NEAR * given.radii[v as usize])).collect();
        }
        let Some((lacking, tube, base)) = best else { return Err(Error::Numeric("no mesh was made".into())) };
        let least = least_scaled_jacobian(&tube.points, &tube.hexes);
        Ok(Meshed { lacking, least, tube, base, net, warnings })
    }
}

/// Places, with a radius, around which the vertices at the nodes of the skeleton stay, as extremities do; others are drawn
/// to their nodes by springs: cells have better shapes.
type Held = [(DVec3, f64)];

/// The base mesh padded, halved, and optimised.
fn refined(net: &CurveNet, base: &BaseMesh, held: &Held, options: &HexOptions, context: &Context) -> Result<TubeMesh> {
    // What is not refined is not optimised again.
    let halved = options.refine_across() + options.refine_along > 0;
    let levels = if options.adapt_radius { insert::levels(net) } else { Vec::new() };
    let grows = levels.iter().any(|&l| l > 0);
    let mut tube = padded(net, base, options, &[], if halved || grows { &PASSING } else { &COARSE }, held, context)?;
    if grows {
        insert::insert(&mut tube, refine::places(net, base, options.padding), &levels);
        optimise(&mut tube, if halved { &PASSING } else { &COARSE }, held, context)?;
    }
    (0..options.refine_across()).for_each(|_| tube.refine_across());
    (0..options.refine_along).for_each(|_| tube.refine_along(|_| true));
    if halved {
        let _stage = context.stage("optimise");
        optimise(&mut tube, &FINE, held, context)?;
    }
    let _stage = context.stage("poor cells");
    let mut optimiser = Optimiser::new(&tube.points, &tube.hexes);
    hold(&mut optimiser, &tube, held);
    relieve(&mut tube.points, &tube.hexes, &optimiser, context)?;
    Ok(tube)
}

/// The coarsest mesh, its folds undone: where cells are few that costs little, and what refines a valid mesh is nearly valid.
/// `cubic` allows cubic junctions.
fn valid_base(net: &CurveNet, cubic: bool, held: &Held, context: &Context) -> Result<BaseMesh> {
    let _stage = context.stage("base mesh");
    let mut base = sew::base_mesh(net, cubic);
    let mut coarse = refine::pad(net, &base, Padding::None, CORE);
    optimise(&mut coarse, &COARSE, held, context)?;
    base.points = coarse.points;
    Ok(base)
}

/// Untangles and smooths a mesh that has no surface.
fn optimise(tube: &mut TubeMesh, effort: &Effort, held: &Held, context: &Context) -> Result<()> {
    let mut optimiser = Optimiser::new(&tube.points, &tube.hexes);
    hold(&mut optimiser, tube, held);
    optimiser.run(&mut tube.points, effort, context)
}

fn least_scaled_jacobian(points: &[DVec3], hexes: &[[u32; 8]]) -> f64 {
    hexes.iter().map(|h| scaled_jacobian(&h.map(|v| points[v as usize]))).fold(f64::INFINITY, f64::min)
}

fn warn_of_poor(base: &BaseMesh, warnings: &mut Vec<String>) {
    if let Some(first) = base.poor.first() {
        let count = base.poor.len();
        warnings.push(format!("{count} branchings have no partition that includes all directions, first {first}"));
    }
}

/// The coarsest mesh of a net as it is, without any optimisation: what the speed of the construction is measured by.
pub fn base_mesh(net: &CurveNet) -> HexMesh {
    let base = sew::base_mesh(net, false);
    HexMesh { points: base.points, hexes: base.hexes, ..HexMesh::default() }
}

/// Repair, and the skeleton made ready for cells. Clean-up is taken back where it drops what the user has drawn: stubs
/// whose nodes would lie outside of the tubes stay, then branchings are not merged either.
///
/// Returns the repaired net, the one to be meshed, and what the user should know.
fn prepare(
    net: &CurveNet,
    forks: [f64; 2],
    options: &HexOptions,
    context: &Context,
) -> Result<(CurveNet, CurveNet, Vec<String>)> {
    let _stage = context.stage("skeleton");
    let RepairedNet { mut net, mut warnings } = net.repaired(options.radius)?;
    if options.stage == Stage::Full {
        let dropped = turns::drop_turns(&mut net);
        if dropped > 0 {
            warnings.push(format!("{dropped} nodes where a branch turns back within its radius were dropped"));
        }
    }
    check_steps(&net, options)?;
    let mut stay = FxHashSet::default();
    let mut best: Option<(usize, CurveNet, Vec<String>)> = None;
    for merge in [MERGE, MERGE, 0.0] {
        context.check()?;
        let (ready, notes) = shaped(&net, forks, options, &stay, merge);
        let outside = cover::outside(&net, &ready);
        if best.as_ref().is_none_or(|b| outside.len() < b.0) {
            best = Some((outside.len(), ready, notes));
        }
        if outside.is_empty() || options.stage == Stage::Base {
            break;
        }
        stay.extend(outside.iter().map(|&v| net.ids[v as usize]));
    }
    let ready = best.filter(|(_, ready, _)| !ready.edges.is_empty());
    let Some((_, ready, notes)) = ready else {
        return Err(Error::input("the skeleton has no segment", "", "give one"));
    };
    warnings.extend(notes);
    check_size(&ready, options)?;
    Ok((net, ready, warnings))
}

/// Zipping, and for the full stage clean-up and resampling; notes say what was done.
fn shaped(
    net: &CurveNet,
    forks: [f64; 2],
    options: &HexOptions,
    stay: &FxHashSet<i64>,
    merge: f64,
) -> (CurveNet, Vec<String>) {
    let mut net = net.clone();
    let mut notes = Vec::new();
    if options.stage == Stage::Full {
        let pruned = resample::prune(&mut net, stay);
        if pruned > 0 {
            notes.push(format!("{pruned} branches end inside the ball of their branching and were dropped"));
        }
        let merged = net.merge_branchings(|[a, b]| merge * a.min(b));
        if merged > 0 {
            notes.push(format!("{merged} branchings lie inside others and were merged with them"));
        }
    }
    let [narrow, apart] = if options.stage == Stage::Full { forks } else { [zip::NARROW_DEGREES, zip::APART_DEGREES] };
    let zipped = zip::zip(&mut net, narrow, apart);
    if zipped > 0 {
        notes.push(format!("{zipped} pairs of directions are closer than {narrow}° and got a common trunk"));
    }
    if options.stage == Stage::Full {
        net = resized(&net, options);
    }
    let reduced = limit::limit_radii(&mut net);
    if reduced > 0 {
        notes.push(format!("{reduced} radii leave no room for cells beside a short segment and were reduced"));
    }
    (net, notes)
}

/// Refuses steps so short that the hexes would be too many, before any is made.
fn check_steps(net: &CurveNet, options: &HexOptions) -> Result<()> {
    let Some(step) = options.edge_length else { return Ok(()) };
    let length: f64 = (0..net.edges.len()).map(|e| net.length(e)).sum();
    let expected = (length / step) * options.hexes_of(1, 0);
    if expected > MOST_HEXES {
        return Err(Error::Options(format!("about {expected:.1e} hexes would be made; ask for longer ones")));
    }
    Ok(())
}

fn check_size(net: &CurveNet, options: &HexOptions) -> Result<()> {
    let expected = options.most_hexes(net);
    if expected > MOST_HEXES {
        return Err(Error::Options(format!("about {expected:.1e} hexes would be made; ask for fewer or longer ones")));
    }
    Ok(())
}

/// The net resampled to the size asked for.
fn resized(net: &CurveNet, options: &HexOptions) -> CurveNet {
    if let Some(length) = options.edge_length {
        return resample::resample(net, Step::Length(length));
    }
    let fine = resample::resample(net, Step::Radii(STEP));
    let fits = |n: &CurveNet| match options.hexes {
        Some(wanted) => options.most_hexes(n) <= wanted as f64,
        None => n.edges.len() <= MANY_SEGMENTS.max(net.edges.len()),
    };
    if options.hexes.is_none() && fits(&fine) {
        return fine;
    }
    finest(net, Step::Radii, fits)
}

/// The finest resampled net that fits, by bisection of the logarithm of the steps.
fn finest(net: &CurveNet, step: impl Fn(f64) -> Step, fits: impl Fn(&CurveNet) -> bool) -> CurveNet {
    // The longest one is for threads, thin beyond all measure.
    let [long, longest] = LONGEST.map(|k| (k.ln(), step(k)));
    let usual = resample::resample(net, long.1);
    let (mut high, mut best) = match fits(&usual) {
        true => (long.0, usual),
        false => (longest.0, resample::resample(net, longest.1)),
    };
    let mut low = 0.02f64.ln();
    for _ in 0..24 {
        let middle = 0.5 * (low + high);
        let tried = resample::resample(net, step(middle.exp()));
        if fits(&tried) {
            high = middle;
            best = tried;
        } else {
            low = middle;
        }
    }
    best
}

/// The base mesh with its layer: as thick as it should be where that folds nothing, else as thin as it must be, and then
/// let grow. No layer on the ends that are `flat`.
fn padded(
    net: &CurveNet,
    base: &BaseMesh,
    options: &HexOptions,
    flat: &[bool],
    effort: &Effort,
    held: &Held,
    context: &Context,
) -> Result<TubeMesh> {
    let _stage = context.stage("padding");
    let mut tube = refine::pad_but(net, base, options.padding, CORE, flat);
    if options.padding == Padding::None {
        return Ok(tube);
    }
    let mut optimiser = Optimiser::new(&tube.points, &tube.hexes);
    hold(&mut optimiser, &tube, held);
    let mut points = tube.points.clone();
    for core in CORES {
        if optimiser.is_valid(&points) {
            break;
        }
        points = refine::pad_but(net, base, options.padding, core, flat).points;
    }
    optimiser.run(&mut points, effort, context)?;
    tube.points = points;
    Ok(tube)
}

/// What holds a mesh that has no surface: springs pull the wall to its radius, ends to their planes, and the vertices at
/// the nodes of the skeleton to these.
fn hold(optimiser: &mut Optimiser, tube: &TubeMesh, held: &Held) {
    let is_held = |p: DVec3| held.iter().any(|&(at, reach)| p.distance(at) <= reach);
    let mut springs = Vec::with_capacity(tube.points.len());
    for v in 0..tube.points.len() {
        let (vertex, c) = (v as u32, tube.centres[v]);
        let mut away = tube.points[v] - c;
        if let Some(end) = tube.ends.get((tube.caps[v] as usize).wrapping_sub(1)) {
            let normal = end.outward;
            springs.push(Spring { vertex, to: end.centre, normal, along: PLANE, across: 0.0 });
            away -= normal * normal.dot(away);
        }
        if tube.radii[v] > 0.0 {
            let normal = away.normalize_or_zero();
            springs.push(Spring { vertex, to: c + normal * tube.radii[v], normal, along: WALL, across: WEAK });
        }
    }
    let mut fixed = vec![false; tube.points.len()];
    for &vertex in &tube.nodes {
        let to = tube.centres[vertex as usize];
        springs.push(Spring { vertex, to, normal: DVec3::ZERO, along: 0.0, across: NODE });
        fixed[vertex as usize] = tube.caps[vertex as usize] > 0 || is_held(to);
    }
    optimiser.tie(springs);
    optimiser.fix(fixed);
}
