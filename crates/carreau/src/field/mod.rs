//! Frame fields for CAD parts: a frame per triangle, along every feature, from which quads follow.
//!
//! Protais, Corman, Ray, Sokolov: *Champs de repères pour les modèles CAO*, JFIG 2020. The smoothest field along the features
//! has poles in acute corners, where it leaves room for no quad at all; a target rotation ω, zero but near them, makes
//! room, and the frames then lean to turn less.
//!
//! | stage | file | paper |
//! |---|---|---|
//! | splits before | `condition` | – |
//! | the dual graph, fans | `dual` | §1 |
//! | target rotation ω | `target` | §1, figure 7 |
//! | guides, directions of curvature | `align` | – |
//! | the smoothest field | `smooth` | equation 3 |
//! | matchings, quads of every fan, surgery | `matching` | equation 1 |
//! | relaxation | `relax` | equations 4, 5 |
//! | the layout file | `layout` | – |
//! | options | `options` | – |
//!
//! Beyond the paper: corners below 90° are pinned to one quad, not only those that would get none; inner tips to three; and
//! what is still wrong after the solves is put right by moving quads from one vertex to another, so that every sector has one.

mod align;
mod condition;
mod dual;
mod layout;
mod matching;
mod options;
mod relax;
mod smooth;
mod target;
#[cfg(test)]
mod tests;

use crate::context::Context;
use crate::error::{Error, Result};
use crate::geometry::features::{FeaturedSurface, FoundFeatures, USUAL_ELEMENTS};
use crate::mesh::{CornerId, Side, SurfaceMesh, UnitScale, VertexId};
pub(crate) use align::below_guides;
use condition::Conditioned;
use dual::Dual;
use glam::DVec3;
use relax::Relaxed;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};
use target::Spread;

pub(crate) use options::MOST_CURVATURE_WEIGHT;
pub use options::{FieldOptions, Pin, Propagation};

/// A fan of triangles around a vertex, between two features or all around.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Corner {
    /// The vertex.
    pub vertex: u32,
    /// All around: an inner vertex on no feature.
    pub closed: bool,
    /// Sum of the angles, in radians.
    pub angle: f64,
    /// Quads that the field gives it.
    pub quads: i32,
}

impl Corner {
    /// Whether the field leaves it no room: a sector without a quad, or a tip with two and fewer.
    pub fn is_pole(&self) -> bool {
        self.quads < if self.closed { 3 } else { 1 }
    }

    /// Whether it is a singular point of the field off the features.
    pub fn is_singular(&self) -> bool {
        self.closed && self.quads != 4
    }
}

/// An edge that frames continue across.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Matching {
    /// The two triangles.
    pub triangles: [u32; 2],
    /// Branch s of the first continues as branch s + p of the second, modulo 4.
    pub p: i32,
}

/// A frame field.
#[derive(Debug, Clone)]
pub struct Field {
    /// The mesh that carries it: the input with a few splits.
    pub mesh: SurfaceMesh,
    /// Triangle of the (repaired) input for every triangle.
    pub source: Vec<u32>,
    /// Unit directions of the first two branches of every triangle; the others are their opposites.
    pub u: Vec<DVec3>,
    /// The second branch.
    pub v: Vec<DVec3>,
    /// Feature edges, by their ends.
    pub features: Vec<[u32; 2]>,
    /// All inner edges that are no features.
    pub matchings: Vec<Matching>,
    /// All fans.
    pub corners: Vec<Corner>,
    /// Solves until no fan had too few quads, or none was left to pin.
    pub rounds: usize,
    /// Quads moved by surgery.
    pub moved: usize,
    /// Σ w (r⁰² + r¹²) of the orthogonal field and after relaxation.
    pub energy: [f64; 2],
    /// What was repaired in the input, one sentence each.
    pub repaired: Vec<String>,
    /// Tagged and listed edges that the mesh does not have.
    pub missing: Vec<[VertexId; 2]>,
    /// The features of the input, and sharp edges that are none at the size of the usual quads.
    pub found: FoundFeatures,
}

impl Field {
    /// Sectors without a quad, and inner vertices with two and fewer.
    pub fn poles(&self) -> [usize; 2] {
        [false, true].map(|closed| self.corners.iter().filter(|c| c.closed == closed && c.is_pole()).count())
    }

    /// Singular points off the features.
    pub fn singularities(&self) -> usize {
        self.corners.iter().filter(|c| c.is_singular()).count()
    }

    /// Largest angle between the branches away from 90°, in degrees.
    pub fn lean_deg(&self) -> f64 {
        let lean = |(u, v): (&DVec3, &DVec3)| (u.cross(*v).length().atan2(u.dot(*v)) - FRAC_PI_2).abs();
        self.u.iter().zip(&self.v).map(lean).fold(0.0, f64::max).to_degrees()
    }
}

/// ℓ as a share of the root of the area, because this is where the weight of the paper's authors leads.
const LOCAL_LENGTH: f64 = 0.03;
/// Radians: interior vertices with a smaller sum of angles get three quads, because the corners of four would have 56°
/// at most.
const TIP_ANGLE: f64 = 1.25 * PI;
/// A count: rounds of pins, limited because each solves the whole field again.
const PIN_ROUNDS: usize = 3;

/// Computes a frame field. The mesh is triangulated, and repaired where it needs it.
///
/// ```
/// use carreau::{Context, field, sample};
/// let context = Context::new();
/// let mesh = sample::make("bracket", None, &context)?;
/// let field = field::field(&mesh, &field::FieldOptions::default(), &context)?;
/// assert_eq!(field.poles(), [0, 0]);
/// assert!(field.energy[1] <= field.energy[0]);
/// # Ok::<(), carreau::Error>(())
/// ```
///
/// # Errors
/// [`Error::Options`] for angles out of range, [`Error::Input`] for a mesh without faces or with one side only,
/// [`Error::Numeric`] where a system could not be solved, [`Error::Cancelled`], [`Error::Deadline`].
pub fn field(mesh: &SurfaceMesh, options: &FieldOptions, context: &Context) -> Result<Field> {
    options.validate()?;
    let scale = UnitScale::of_mesh(mesh);
    if let Some(mesh) = scale.mesh(mesh, &[]) {
        let guides = options.guides.iter().map(|e| e.map(|p| scale.point(p))).collect();
        let found = field(&mesh, &FieldOptions { guides, ..options.clone() }, context)?;
        let mesh = scale.back().moved(found.mesh, &[]);
        return Ok(Field { mesh, found: found.found.moved(scale.back()), ..found });
    }
    let wanted = options.features.for_squares(mesh, USUAL_ELEMENTS);
    let FeaturedSurface { mesh, features, repaired, missing, found } = FeaturedSurface::new(mesh, &wanted, context)?;
    check_input(&mesh)?;
    let conditioned = {
        let _stage = context.stage("condition");
        condition::condition(&mesh, &features)?
    };
    let mut dual = Dual::new(&conditioned)?;
    if options.curvature > 0.0 {
        align::to_curvature(&mut dual, options.curvature);
    }
    align::to_guides(&mut dual, &options.guides);
    let mut topology = topology(&dual, options, context)?;
    let moved = match options.pin {
        Pin::None => 0,
        _ => matching::operate(&dual, &mut topology.p, &mut topology.quads),
    };
    topology.alpha = relax::evened(&dual, topology.alpha, &topology.p, context)?;
    let (relaxed, energy) = relaxed(&dual, &topology, options, context)?;
    let frames = Frames::new(&dual, &topology, &relaxed);
    drop(dual);
    Ok(Field {
        features: conditioned.feature_edges(),
        mesh: conditioned.mesh,
        source: conditioned.source,
        u: frames.u,
        v: frames.v,
        matchings: frames.matchings,
        corners: frames.corners,
        rounds: topology.rounds,
        moved,
        energy,
        repaired,
        missing,
        found,
    })
}

fn check_input(mesh: &SurfaceMesh) -> Result<()> {
    if mesh.face_count() == 0 {
        return Err(Error::input("the mesh has no faces", "", "a frame field needs triangles"));
    }
    let inconsistent = (0..mesh.corner_count()).map(CornerId::new).find(|&c| mesh.side(c) == Side::Inconsistent);
    match inconsistent {
        None => Ok(()),
        Some(c) => Err(Error::input(
            "the surface has only one side (as a Möbius strip)",
            format!("edge {} {}", mesh.vertex(c).0, mesh.vertex(mesh.next(c)).0),
            "cut it open",
        )),
    }
}

/// The orthogonal field: which branch continues which, and what follows from it.
struct Topology {
    alpha: Vec<f64>,
    p: Vec<i32>,
    /// Quads of every fan.
    quads: Vec<i32>,
    rounds: usize,
}

/// The smoothest field for the target rotation of the pins; fans that it leaves too few quads are pinned and it is solved again.
fn topology(dual: &Dual<'_>, options: &FieldOptions, context: &Context) -> Result<Topology> {
    let spread = match options.propagation {
        Propagation::None => Spread::None,
        Propagation::Local => Spread::Length(LOCAL_LENGTH * dual.areas.iter().sum::<f64>().sqrt()),
        Propagation::Global => Spread::All,
    };
    let mut pins = first_pins(dual, options.pin);
    let mut plan = None;
    let mut rounds = 0;
    loop {
        let omega = {
            let _stage = context.stage("target rotation");
            target::target(dual, &pins, spread)?
        };
        context.check()?;
        let _stage = context.stage("smoothest field");
        let alpha = smooth::smoothest(dual, &omega, &mut plan, context)?;
        let p = matching::matchings(dual, &alpha, &omega);
        let quads = matching::quads(dual, &alpha, &p);
        rounds += 1;
        if options.pin == Pin::None || rounds > PIN_ROUNDS || !pin_more(dual, &quads, &mut pins) {
            return Ok(Topology { alpha, p, quads, rounds });
        }
    }
}

/// Acute sectors, and inner tips.
fn first_pins(dual: &Dual<'_>, pin: Pin) -> Vec<(u32, i32)> {
    let acute = match pin {
        Pin::None => return Vec::new(),
        Pin::Below45 => FRAC_PI_4,
        Pin::Below90 => FRAC_PI_2 * (1.0 - 1e-9),
    };
    let is_pinned = |fan: &dual::Fan| if fan.closed { fan.angle < TIP_ANGLE } else { fan.angle < acute };
    (0u32..).zip(&dual.fans).filter(|(_, fan)| is_pinned(fan)).map(|(f, fan)| (f, matching::fewest(fan))).collect()
}

/// Pins the fans with too few quads that are not pinned yet; returns whether there are any.
fn pin_more(dual: &Dual<'_>, quads: &[i32], pins: &mut Vec<(u32, i32)>) -> bool {
    let few = |&f: &u32| quads[f as usize] < matching::fewest(&dual.fans[f as usize]);
    let is_new = |f: &u32| pins.binary_search_by_key(f, |pin| pin.0).is_err();
    let new: Vec<u32> = (0..dual.fans.len() as u32).filter(few).filter(is_new).collect();
    pins.extend(new.iter().map(|&f| (f, matching::fewest(&dual.fans[f as usize]))));
    pins.sort_unstable();
    !new.is_empty()
}

/// The frames after relaxation, and the energy before and after.
fn relaxed(dual: &Dual<'_>, of: &Topology, options: &FieldOptions, context: &Context) -> Result<(Relaxed, [f64; 2])> {
    let straight = vec![0.0; of.alpha.len()];
    let before = relax::energy(dual, &of.alpha, &straight, &of.p);
    let relaxed = if options.orthogonal {
        Relaxed { alpha: of.alpha.clone(), rho: straight }
    } else {
        let _stage = context.stage("relaxation");
        relax::relax(dual, &of.alpha, &of.p, options.lean_deg.to_radians(), context)?
    };
    let after = relax::energy(dual, &relaxed.alpha, &relaxed.rho, &of.p);
    Ok((relaxed, [before, after]))
}

/// What a field says of triangles, edges and fans.
struct Frames {
    u: Vec<DVec3>,
    v: Vec<DVec3>,
    matchings: Vec<Matching>,
    corners: Vec<Corner>,
}

impl Frames {
    fn new(dual: &Dual<'_>, topology: &Topology, relaxed: &Relaxed) -> Self {
        let direction = |i: usize, angle: f64| dual.x[i] * angle.cos() + dual.y[i] * angle.sin();
        let corner = |(fan, &quads): (&dual::Fan, &i32)| Corner {
            vertex: fan.vertex,
            closed: fan.closed,
            angle: fan.angle,
            quads,
        };
        let n = dual.triangles.len();
        Frames {
            u: (0..n).map(|i| direction(i, relaxed.alpha[i])).collect(),
            v: (0..n).map(|i| direction(i, relaxed.alpha[i] + FRAC_PI_2 + relaxed.rho[i])).collect(),
            matchings: (0..dual.edges.len()).map(|e| Matching { triangles: dual.ends(e), p: topology.p[e] }).collect(),
            corners: dual.fans.iter().zip(&topology.quads).map(corner).collect(),
        }
    }
}

impl Conditioned {
    /// Every feature edge once, by its ends in ascending order.
    fn feature_edges(&self) -> Vec<[u32; 2]> {
        let corners = (0..self.mesh.corner_count()).filter(|&c| self.feature[c]).map(CornerId::new);
        let ends = |c: CornerId| [self.mesh.vertex(c).0, self.mesh.vertex(self.mesh.next(c)).0];
        let mut all: Vec<[u32; 2]> = corners.map(ends).map(|[a, b]| [a.min(b), a.max(b)]).collect();
        all.sort_unstable();
        all.dedup();
        all
    }
}
