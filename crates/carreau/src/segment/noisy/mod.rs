//! Parts with noise: the vertices lie near the surfaces of a part, not on them.
//!
//! Hypotheses and energy after Isack and Boykov, "Energy-Based Geometric Multi-Model Fitting", IJCV 97 (2012): surfaces are
//! proposed from patches all over the mesh, the triangles divided among them by α-expansion, the surfaces fitted again to
//! what they got, and so on; surfaces that pay less than their parameters are merged with their neighbours.
//!
//! Noise is of four kinds. White noise is the same everywhere and independent from vertex to vertex: its deviation is measured, and
//! decides. Where exact surfaces hold some triangles for certain, these stay theirs. All else is within a tolerance: in proportion to
//! the edges, where it is rough (chords of a remeshed part, edges that smoothing rounded); that of exact surfaces, and a little more,
//! where it is smooth. Where they hold none (waves, scans) the tolerance is what surfaces through a few places are wrong by; two
//! pieces of a face may then be a wave apart. Whether there is a part at all is for the division to tell: organic shapes fall to
//! chains of surfaces that hold much of each other.
//!
//! | file | holds |
//! |---|---|
//! | `deviation` | which kind of noise there is, and how much |
//! | `held` | which exact surfaces are no chance |
//! | `level` | how large the noise is, and what it does to normals and creases |
//! | `patch` | patches of triangles |
//! | `model` | a surface as an explanation: prices, growth, fit |
//! | `propose` | hypotheses |
//! | `expand` | which surface every triangle belongs to |
//! | `merge` | fewer, simpler surfaces |
//! | `ambiguous` | surfaces that are pieces of freeform ones |
//! | `soft` | surfaces that end where the tolerance does |
//! | `settle` | rounded edges, which are no faces |
//! | `border` | borders where the surfaces meet |
//! | `simplest` | the simplest kind for what a surface got |

mod ambiguous;
mod border;
mod deviation;
mod expand;
mod held;
mod level;
mod merge;
mod model;
mod patch;
mod propose;
mod settle;
mod simplest;
mod soft;

use super::growth;
use super::regions::{Groups, connected, count};
use super::surface::Surface;
use super::surfaces::{PART_SHARE, Surfaces};
use crate::context::Context;
use crate::error::Result;
use crate::geometry::primitive::{Kind, Primitive};
use crate::mesh::NONE;
use deviation::Open;
use expand::Energy;
use held::Hold;
use level::Noise;
use model::{Fitter, Model};

/// A share of the area that lies on surfaces where the mesh is a part: more than half, because a mesh of which most is
/// free is none.
const DIVIDED_SHARE: f64 = 0.6;
/// A share of the area: where exact surfaces hold more there is no white noise, because that is the same everywhere.
const EXACT_SHARE: f64 = 0.5;
/// A share of all that is not planar: where exact curved surfaces hold more, the triangles are those of a kernel. Measured
/// 0.36 and more on tessellations, 0.03 and less on what was smoothed, remeshed or decimated.
const CURVED_SHARE: f64 = 0.2;
/// Variances of the noise that surfaces are wrong by where they are pieces of freeform ones. Measured 0.15 and more there, 0.02 and
/// less on parts that were decimated.
const FILLED_WRONGNESS: f64 = 0.06;
/// A share of the area: where more is on surfaces with a soft border, the tolerance made them possible, because single surfaces
/// of a part may end softly, most do not.
const SOFT_SHARE: f64 = 0.02;
/// A count of standard deviations of the noise: largest distance of a vertex from its surface, because normal noise is larger once in two
/// million times.
const NOISE_DEVIATIONS: f64 = 5.0;
/// A count: most triangles of the mesh, because larger ones would take minutes.
const MOST_TRIANGLES: usize = 400_000;
/// A count: rounds of division and fit, few because hardly a triangle changes after some.
const DIVISION_ROUNDS: usize = 4;
/// A count: rounds in which every label is offered, few because hardly a triangle changes after some.
const EXPANSIONS: usize = 3;
/// A count: pieces of fewer triangles are no faces, because noise makes such pieces.
const FACE_TRIANGLES: usize = 4;
/// A count: the same of pieces without a surface, more because nothing speaks for them.
const FREE_TRIANGLES: usize = 10;

/// The faces of a noisy part.
pub struct Noisy {
    /// Region of every triangle.
    pub label: Vec<u32>,
    /// Their surfaces, where these cannot be fitted to all vertices because those of rounded edges are far off; regions beyond
    /// have none.
    pub primitives: Vec<Primitive>,
    /// Standard deviation of the vertices from their surfaces.
    pub sigma: f64,
    /// Share of the area on recognised surfaces.
    pub share: f64,
}

impl Noisy {
    /// Largest distance of a vertex from its surface.
    pub fn tolerance(&self) -> f64 {
        NOISE_DEVIATIONS * self.sigma
    }
}

/// What was found exactly before, and what the user asks for.
pub struct Before<'a> {
    pub exact: &'a Surfaces,
    /// Share of the area that lies on its surfaces.
    pub share: f64,
    /// Largest distance of a vertex from its surface.
    pub tolerance: Option<f64>,
}

/// The faces of a part with noise; `None` for other meshes.
pub fn find(surface: &Surface<'_>, order: &[u32], before: &Before<'_>, context: &Context) -> Result<Option<Noisy>> {
    if surface.len() > MOST_TRIANGLES {
        return Ok(None);
    }
    let white = if before.share < EXACT_SHARE { deviation::white(surface, order, before, context)? } else { None };
    if let Some(noise) = white {
        return divide(surface, &noise, order, Start::nothing(surface), Way::White, context);
    }
    let start = Start::of(surface, before.exact);
    if before.tolerance.is_none() && start.is_tessellation(surface) {
        return Ok(None);
    }
    let Some(open) = Open::of(surface, order, before, &start) else { return Ok(None) };
    if start.exact < PART_SHARE * surface.total_area
        && let Some(noise) = open.waves(surface, order, before.tolerance, context)?
        && let Some(found) = divide(surface, &noise, order, Start::nothing(surface), Way::Loose, context)?
    {
        return Ok(Some(found));
    }
    if open.held < PART_SHARE {
        return Ok(None);
    }
    let (noise, way) = open.beside_exact(surface, before);
    divide(surface, &noise, order, start, way, context)
}

/// Where the division starts from.
struct Start {
    /// Models that are held.
    models: Vec<Model>,
    label: Vec<u32>,
    /// Triangles of the models that are held.
    fixed: Vec<bool>,
    /// Area of those that are exact, and of the curved ones among them.
    exact: f64,
    curved: f64,
    /// Vertices inside of models that are held.
    inner: usize,
}

impl Start {
    /// Without surfaces.
    fn nothing(surface: &Surface<'_>) -> Self {
        let (label, fixed) = (vec![NONE; surface.len()], vec![false; surface.len()]);
        Start { models: Vec::new(), label, fixed, exact: 0.0, curved: 0.0, inner: 0 }
    }

    /// Whether the triangles are those of a kernel: exact curved surfaces are next to what is open. Whatever moves vertices
    /// moves those of curved surfaces first, and leaves planes; what is open in such a mesh is freeform.
    fn is_tessellation(&self, surface: &Surface<'_>) -> bool {
        let fixed = self.fixed.iter().zip(&surface.areas).filter(|(fixed, _)| **fixed);
        let open = surface.total_area - fixed.map(|(_, area)| area).sum::<f64>();
        self.curved > CURVED_SHARE * (self.curved + open)
    }

    /// The exact surfaces that are no chance.
    fn of(surface: &Surface<'_>, exact: &Surfaces) -> Self {
        let inner = held::inner(surface, exact);
        let hold = held::held(surface, exact, &inner);
        let groups = Groups::new(&exact.label, exact.primitives.len());
        let mut start = Start::nothing(surface);
        let held: Vec<u32> =
            (0..groups.len() as u32).filter(|&l| hold[l as usize] != Hold::None && !groups.of(l).is_empty()).collect();
        let members: Vec<&[u32]> = held.iter().map(|&l| groups.of(l)).collect();
        let area = |l: u32| groups.of(l).iter().map(|&k| surface.areas[k as usize]).sum::<f64>();
        for &l in held.iter().filter(|&&l| hold[l as usize] == Hold::Exact) {
            start.exact += area(l);
            let is_plane = exact.primitives[l as usize].kind() == Kind::Plane;
            start.curved += if is_plane { 0.0 } else { area(l) };
        }
        start.inner = held.iter().map(|&l| inner[l as usize]).sum();
        start.models = held
            .iter()
            .zip(&members)
            .map(|(&l, members)| Model::of(exact.primitives[l as usize], surface, members))
            .collect();
        let home = held::same(surface, &start.models, &members, held::TWIN_FACTOR * exact.tolerance);
        for (members, &home) in members.iter().zip(&home) {
            for &k in *members {
                (start.label[k as usize], start.fixed[k as usize]) = (home, true);
            }
        }
        start
    }
}

/// What the vertices deviate from their surfaces by.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Way {
    /// White noise.
    White,
    /// Chords, rounded edges, waves: within a tolerance.
    Loose,
    /// Next to nothing, but more than exact surfaces.
    Close,
}

/// Divides the triangles that are not held among surfaces.
fn divide(
    surface: &Surface<'_>,
    noise: &Noise,
    order: &[u32],
    start: Start,
    way: Way,
    context: &Context,
) -> Result<Option<Noisy>> {
    let bare = start.inner == 0;
    let Start { mut models, mut label, fixed, .. } = start;
    let held = models.len() as u32;
    let proposals = propose::propose(surface, noise, order, &fixed, context)?;
    propose::choose(surface, noise, &proposals, &mut models, &mut label);
    let energy = Energy::new(surface, noise, models, &fixed);
    let fitter = Fitter::new(surface, noise, &fixed);
    let mut division = Division { energy, fitter, label, held, bare, order, context };
    division.minimise()?;
    match way {
        Way::White => division.white(),
        Way::Loose | Way::Close => division.tolerant(way),
    }
}

/// Triangles that are divided among surfaces.
struct Division<'a> {
    energy: Energy<'a>,
    fitter: Fitter<'a>,
    label: Vec<u32>,
    /// So many of the models stay as they are.
    held: u32,
    /// These have no vertices inside, as the faces of kernels have: what lies between may be freeform.
    bare: bool,
    order: &'a [u32],
    context: &'a Context,
}

impl Division<'_> {
    /// Division, fit and merging in turn.
    fn minimise(&mut self) -> Result<()> {
        for _ in 0..DIVISION_ROUNDS {
            let changed = self.energy.minimise(&mut self.label, EXPANSIONS, self.context)?;
            self.refit();
            if !self.merge()? && !changed {
                break;
            }
        }
        self.energy.minimise(&mut self.label, EXPANSIONS, self.context)?;
        Ok(())
    }

    /// The faces, where noise is all that the vertices deviate by.
    fn white(mut self) -> Result<Option<Noisy>> {
        free_wrong(&self.energy, &mut self.label);
        let share = self.share();
        if share < DIVIDED_SHARE {
            return Ok(None);
        }
        self.free_pieces();
        without_crumbs(&self.energy, &mut self.label, self.order, self.context)?;
        let sigma = self.energy.noise.sigma;
        Ok(Some(Noisy { label: self.label, primitives: Vec::new(), sigma, share }))
    }

    /// The faces, where edges may be rounded.
    fn tolerant(mut self, way: Way) -> Result<Option<Noisy>> {
        self.refit();
        self.simplify();
        // Pieces of a plane are one where they were bent, each otherwise, to the rounded edges around.
        self.merge()?;
        let surface = self.energy.surface;
        ambiguous::free(&self.energy, &mut self.label, self.held);
        if way == Way::Close && soft::area(&self.energy, &self.label, self.held) > SOFT_SHARE * surface.total_area {
            return Ok(None);
        }
        self.free_pieces();
        settle::settle(&self.energy, &mut self.label, self.energy.fixed, self.order, self.context)?;
        let share = self.share();
        if share < DIVIDED_SHARE || self.bare && self.held > 0 && self.is_filled() {
            return Ok(None);
        }
        self.refit();
        border::divide(&self.energy, &mut self.label, self.order);
        let next = count(&self.label) as u32;
        self.label.iter_mut().filter(|l| **l == NONE).for_each(|l| *l = next);
        self.refit();
        self.simplify();
        let primitives = self.energy.models.iter().map(|m| m.primitive).collect();
        Ok(Some(Noisy { label: self.label, primitives, sigma: self.energy.noise.sigma, share }))
    }

    /// Share of the area that is on surfaces.
    fn share(&self) -> f64 {
        let surface = self.energy.surface;
        let on = |&(l, _): &(&u32, &f64)| (*l as usize) < self.energy.models.len();
        let area: f64 = self.label.iter().zip(&surface.areas).filter(on).map(|(_, area)| area).sum();
        area / surface.total_area.max(f64::MIN_POSITIVE)
    }

    /// Whether most of what is not held is wrong by much of the noise: pieces of freeform surfaces grow until they are, chords are
    /// much nearer.
    fn is_filled(&self) -> bool {
        let Energy { surface, noise, models, .. } = &self.energy;
        let groups = Groups::new(&self.label, models.len().max(count(&self.label)));
        let (mut filled, mut all) = (0.0, 0.0);
        for l in self.held..models.len() as u32 {
            let area: f64 = groups.of(l).iter().map(|&k| surface.areas[k as usize]).sum();
            let (wrongness, _) = models[l as usize].wrongness(surface, noise, groups.of(l));
            all += area;
            filled += if wrongness > FILLED_WRONGNESS { area } else { 0.0 };
        }
        filled > 0.5 * all
    }

    /// Labels for the pieces without a surface; they end at creases.
    fn free_pieces(&mut self) {
        let Energy { surface, noise, models, .. } = &self.energy;
        surface.flood(self.order, &mut self.label, models.len() as u32, |c| !noise.crease[c as usize], |_, _| ());
    }

    fn merge(&mut self) -> Result<bool> {
        merge::merge(&mut self.energy, &mut self.fitter, &mut self.label, self.held, self.context)
    }

    fn simplify(&mut self) {
        simplest::simplify(&mut self.energy, &mut self.fitter, &self.label, self.held);
    }

    /// Fits every surface that is not held to the triangles it has.
    fn refit(&mut self) {
        let Division { energy, fitter, .. } = self;
        // Labels beyond the models are free.
        let own: Vec<u32> =
            self.label.iter().map(|&l| if (l as usize) < energy.models.len() { l } else { NONE }).collect();
        let groups = Groups::new(&own, energy.models.len());
        for l in self.held..groups.len() as u32 {
            let old = energy.models[l as usize];
            let on: Vec<u32> =
                groups.of(l).iter().copied().filter(|&k| old.holds(energy.surface, energy.noise, k)).collect();
            let kind = old.primitive.kind();
            if let Some(fit) = fitter.fit(kind, &on, Some(old.primitive)) {
                energy.models[l as usize] = Model::of(fit.primitive, energy.surface, &on);
            }
        }
    }
}

/// Takes the surfaces away that are pieces of freeform ones, found because noise hides what they are wrong by.
fn free_wrong(energy: &Energy<'_>, label: &mut [u32]) {
    let groups = Groups::new(label, energy.models.len());
    for l in 0..groups.len() as u32 {
        if model::is_wrong(energy.models[l as usize].wrongness(energy.surface, energy.noise, groups.of(l))) {
            groups.of(l).iter().for_each(|&k| label[k as usize] = NONE);
        }
    }
}

/// Gives crumbs to their neighbours; larger pieces without a surface are faces of their own.
fn without_crumbs(energy: &Energy<'_>, label: &mut [u32], order: &[u32], context: &Context) -> Result<()> {
    let (surface, models) = (energy.surface, energy.models.len() as u32);
    let next = count(label) as u32;
    let part = connected(surface, label, order);
    let mut size = vec![0usize; count(&part)];
    part.iter().for_each(|&p| size[p as usize] += 1);
    for k in 0..label.len() {
        let least = if label[k] >= models { FREE_TRIANGLES } else { FACE_TRIANGLES };
        if size[part[k] as usize] < least {
            label[k] = NONE;
        }
    }
    growth::fill(surface, &energy.noise.crease, label, context)?;
    growth::fill(surface, &vec![false; 3 * label.len()], label, context)?;
    // A mesh of crumbs alone.
    label.iter_mut().filter(|l| **l == NONE).for_each(|l| *l = next);
    Ok(())
}
