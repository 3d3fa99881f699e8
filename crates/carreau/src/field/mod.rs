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
//! | the smoothest field | `smooth` | equation 3 |
//! | matchings, quads of every fan, surgery | `matching` | equation 1 |
//! | relaxation | `relax` | equations 4, 5 |
//! | linear systems | `sparse` | – |
//!
//! Beyond the paper: corners below 90° are pinned to one quad, not only those that would get none; inner tips to three; and
//! what is still wrong after the solves is put right by moving quads from one vertex to another, so that every sector has one.

mod condition;
mod dual;
mod matching;
mod relax;
mod smooth;
mod sparse;
mod target;

use crate::context::Context;
use crate::error::{Error, Result};
use crate::geometry::features::{FeatureOptions, feature_edges};
use crate::mesh::SurfaceMesh;
use dual::Dual;
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};
use target::Spread;

/// Which corners are pinned to one quad.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Pin {
    /// None, and no repair: the classic field.
    #[serde(rename = "none")]
    None,
    /// Those below 45°.
    #[serde(rename = "45")]
    Below45,
    /// Those below 90°.
    #[default]
    #[serde(rename = "90")]
    Below90,
}

/// How far the rotation that pins ask for spreads.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Propagation {
    /// Not at all.
    None,
    /// Over a few hundredths of the root of the area.
    #[default]
    Local,
    /// Everywhere.
    Global,
}

/// Options of [`field`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct FieldOptions {
    /// What the frames are aligned with.
    pub features: FeatureOptions,
    /// The frames stay orthogonal.
    pub orthogonal: bool,
    /// Which corners are pinned.
    pub pin: Pin,
    /// How far they reach.
    pub propagation: Propagation,
    /// Largest angle between the branches away from 90°, in degrees.
    pub lean_deg: f64,
}

impl Default for FieldOptions {
    fn default() -> Self {
        let (features, pin, propagation) = (FeatureOptions::default(), Pin::default(), Propagation::default());
        FieldOptions { features, orthogonal: false, pin, propagation, lean_deg: 60.0 }
    }
}

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
    /// Triangle of the input for every triangle.
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
    /// Rounds of pins until no fan had too few quads, and quads moved by surgery.
    pub rounds: usize,
    /// Quads moved by surgery.
    pub moved: usize,
    /// Σ w (r⁰² + r¹²) of the orthogonal field and after relaxation.
    pub energy: [f64; 2],
}

/// ℓ as a share of the root of the area: where the weight of the paper's authors leads.
const SPREAD: f64 = 0.03;
/// Interior vertices with a smaller sum of angles get three quads.
const TIP: f64 = 1.25 * PI;
/// Rounds of pins.
const ROUNDS: usize = 3;

/// Computes a frame field.
///
/// # Errors
/// [`Error::Input`] for polygons, [`Error::Numeric`] where a system could not be solved, [`Error::Cancelled`],
/// [`Error::Deadline`].
pub fn field(mesh: &SurfaceMesh, options: &FieldOptions, context: &Context) -> Result<Field> {
    if !mesh.is_triangular() || mesh.face_count() == 0 {
        return Err(Error::input("a frame field needs triangles", "", "triangulate the mesh first"));
    }
    let features = feature_edges(mesh, &options.features)?;
    let conditioned = {
        let _stage = context.stage("condition");
        condition::condition(mesh, &features)?
    };
    let dual = Dual::new(&conditioned)?;
    let spread = match options.propagation {
        Propagation::None => Spread::None,
        Propagation::Local => Spread::Length(SPREAD * dual.areas.iter().sum::<f64>().sqrt()),
        Propagation::Global => Spread::All,
    };
    let mut pins = first_pins(&dual, options.pin);
    let mut rounds = 0;
    let (alpha, mut p, mut quads) = loop {
        let omega = {
            let _stage = context.stage("target rotation");
            target::target(&dual, &pins, spread)?
        };
        let _stage = context.stage("smoothest field");
        let alpha = smooth::smoothest(&dual, &omega, context)?;
        let p = matching::matchings(&dual, &alpha, &omega);
        let quads = matching::quads(&dual, &alpha, &p);
        rounds += 1;
        let before = pins.len();
        if options.pin != Pin::None && rounds <= ROUNDS {
            let few = |f: &u32| quads[*f as usize] < matching::fewest(&dual.fans[*f as usize]);
            let pinned: Vec<u32> = pins.iter().map(|pin| pin.0).collect();
            let new = (0..dual.fans.len() as u32).filter(few).filter(|f| pinned.binary_search(f).is_err());
            pins.extend(new.map(|f| (f, matching::fewest(&dual.fans[f as usize]))));
            pins.sort_unstable();
        }
        if pins.len() == before {
            break (alpha, p, quads);
        }
    };
    let moved = if options.pin == Pin::None { 0 } else { matching::operate(&dual, &mut p, &mut quads) };
    let still = vec![0.0; alpha.len()];
    let before = relax::energy(&dual, &alpha, &still, &p);
    let relaxed = if options.orthogonal {
        relax::Relaxed { alpha, rho: still }
    } else {
        let _stage = context.stage("relaxation");
        relax::relax(&dual, &alpha, &p, options.lean_deg.to_radians(), context)?
    };
    let after = relax::energy(&dual, &relaxed.alpha, &relaxed.rho, &p);
    let direction = |i: usize, angle: f64| dual.x[i] * angle.cos() + dual.y[i] * angle.sin();
    let n = dual.triangles.len();
    let t = dual.triangles;
    let ends = |c: u32| [t.vertex(c), t.vertex(t.next(c))];
    let mut listed: Vec<[u32; 2]> = (0..3 * n as u32)
        .filter(|&c| conditioned.feature[c as usize])
        .map(|c| ends(c).map(|v| v))
        .map(|[a, b]| [a.min(b), a.max(b)])
        .collect();
    listed.sort_unstable();
    listed.dedup();
    let corner = |(fan, &quads): (&dual::Fan, &i32)| Corner { vertex: fan.vertex, closed: fan.closed, angle: fan.angle, quads };
    let result = (
        (0..n).map(|i| direction(i, relaxed.alpha[i])).collect(),
        (0..n).map(|i| direction(i, relaxed.alpha[i] + FRAC_PI_2 + relaxed.rho[i])).collect(),
        (0..dual.edges.len()).map(|e| Matching { triangles: dual.ends(e), p: p[e] }).collect(),
        dual.fans.iter().zip(&quads).map(corner).collect(),
    );
    let (u, v, matchings, corners) = result;
    drop(dual);
    Ok(Field {
        mesh: conditioned.mesh,
        source: conditioned.source,
        u,
        v,
        features: listed,
        matchings,
        corners,
        rounds,
        moved,
        energy: [before, after],
    })
}

/// Acute sectors, and inner tips.
fn first_pins(dual: &Dual<'_>, pin: Pin) -> Vec<(u32, i32)> {
    let acute = match pin {
        Pin::None => return Vec::new(),
        Pin::Below45 => FRAC_PI_4,
        Pin::Below90 => FRAC_PI_2 * (1.0 - 1e-9),
    };
    let is_pinned = |fan: &dual::Fan| if fan.closed { fan.angle < TIP } else { fan.angle < acute };
    (0u32..).zip(&dual.fans).filter(|(_, fan)| is_pinned(fan)).map(|(f, fan)| (f, matching::fewest(fan))).collect()
}
