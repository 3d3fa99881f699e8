//! Relations between surfaces that hold exactly on the part, and only within the noise in the fits: surfaces that touch, corners of four
//! and more, in noisy data also directions that are parallel or perpendicular, axes on one line, equal radii and round numbers.
//!
//! ```text
//!     ────────●─ ─ ─ ─  plane            f = 0 on both surfaces at the point where their normals agree;
//!              ╲                         the border of the regions is within an edge of that curve, not on it
//!               ╲  fillet
//! ```
//!
//! What holds is found by its contacts and kept where the surfaces, adjusted together, are no farther from their vertices than before
//! but for the noise (Benkő, Kós, Várady, Andor, Martin: *Constrained fitting in reverse engineering*, CAGD 19, 2002).
//!
//! | file | holds |
//! |---|---|
//! | `search` | the surfaces, each once, and the relations that the noise allows |
//! | `contact` | where two surfaces touch |
//! | `conditions` | what is zero where a relation holds |
//! | `values` | radii and distances that are round numbers |

mod conditions;
mod contact;
mod search;
#[cfg(test)]
mod tests;
mod values;

use super::adjust::{Body, Condition, adjust};
use super::regions::{Map, Piece};
use super::topology::Graph;
use super::tuning::{FILE_PRECISION, NAMED_DISTANCE};
use crate::brep::Surface;
use crate::context::Context;
use crate::error::Result;
use crate::mesh::NONE;
use conditions::{Radius, apart, coaxial, concurring, parallel, perpendicular, radius, same_radius, touching};
use glam::DVec3;
use search::Found;
use serde::Serialize;
use values::round_values;

pub use contact::room;

/// A factor: how much farther from its vertices a surface may be that is adjusted, because more than that is no noise.
const WORSE_FACTOR: f64 = 1.6;
/// A count: rounds in which relations that do not hold are dropped, because each solves for all surfaces.
const RELATION_ROUNDS: usize = 40;

/// A relation that the surfaces of a model were adjusted to.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Adjusted {
    /// What holds now: `tangent`, `concurrent`, `parallel`, `perpendicular`, `coaxial`, `equal_radius`, `radius`, `distance`.
    pub relation: &'static str,
    /// The faces that it is between.
    pub faces: Vec<u32>,
    /// What it was: an angle in degrees, else a length in the unit of the file.
    pub before: f64,
    /// What it is.
    pub after: f64,
}

/// What holds between surfaces; lengths as shares of the diagonal.
#[derive(Debug, Clone)]
enum Relation {
    /// Two of them touch, near places of their border.
    Touch { bodies: [u32; 2], places: Vec<DVec3> },
    /// A fourth one passes through the point where three meet, near a place.
    Concur { bodies: [u32; 4], place: DVec3 },
    /// Normals or axes are parallel.
    Parallel([u32; 2]),
    /// Normals or axes are perpendicular.
    Perpendicular([u32; 2]),
    /// Axes are on one line.
    Coaxial([u32; 2]),
    /// Two cylinders or spheres have the same radius.
    SameRadius([u32; 2]),
    /// A radius has a round value.
    Radius { body: [u32; 1], which: Radius, value: f64 },
    /// Two parallel planes have a round distance.
    Apart { bodies: [u32; 2], value: f64 },
}

impl Relation {
    fn bodies(&self) -> &[u32] {
        match self {
            Relation::Touch { bodies, .. }
            | Relation::Parallel(bodies)
            | Relation::Perpendicular(bodies)
            | Relation::Coaxial(bodies)
            | Relation::SameRadius(bodies)
            | Relation::Apart { bodies, .. } => bodies,
            Relation::Concur { bodies, .. } => bodies,
            Relation::Radius { body, .. } => body,
        }
    }

    /// Numbers that are zero where it holds.
    fn conditions(&self, all: &[Body]) -> Vec<Condition> {
        match self {
            Relation::Touch { bodies, places } => places.iter().map(|&at| touching(all, *bodies, at)).collect(),
            Relation::Concur { bodies, place } => vec![concurring(all, *bodies, *place)],
            Relation::Parallel(bodies) => parallel(all, *bodies),
            Relation::Perpendicular(bodies) => perpendicular(all, *bodies),
            Relation::Coaxial(bodies) => coaxial(all, *bodies),
            Relation::SameRadius(bodies) => same_radius(all, *bodies),
            Relation::Radius { body: [body], which, value } => vec![radius(all, (*body, *which), *value)],
            Relation::Apart { bodies, value } => apart(all, *bodies, *value),
        }
    }

    /// Its name in the record, and what it was before and is now, lengths in a unit.
    fn told(&self, all: &[Body], unit: f64) -> (&'static str, [f64; 2]) {
        let off = unit * self.off(all);
        let degrees = self.off(all).min(1.0).asin().to_degrees();
        match self {
            Relation::Touch { .. } => ("tangent", [off, 0.0]),
            Relation::Concur { .. } => ("concurrent", [off, 0.0]),
            Relation::Parallel(_) => ("parallel", [degrees, 0.0]),
            Relation::Perpendicular(_) => ("perpendicular", [90.0 - degrees, 90.0]),
            Relation::Coaxial(_) => ("coaxial", [off, 0.0]),
            Relation::SameRadius(_) => ("equal_radius", [off, 0.0]),
            Relation::Radius { body: [body], which, value } => {
                let was = which.of(&all[*body as usize].primitive).unwrap_or(*value);
                ("radius", [unit * was, unit * value])
            }
            Relation::Apart { value, .. } => {
                let was = self.conditions(all).first().map_or(0.0, |c| c.value) + value;
                ("distance", [unit * was.abs(), unit * value.abs()])
            }
        }
    }

    /// The largest of them.
    fn off(&self, all: &[Body]) -> f64 {
        self.conditions(all).iter().map(|c| c.value.abs()).fold(0.0, f64::max)
    }
}

/// A relation that may hold.
#[derive(Debug, Clone)]
struct Claim {
    relation: Relation,
    /// How far off it may be before the adjustment, in its own unit.
    bound: f64,
}

/// Adjusts the surfaces of a map so that those relations hold exactly which hold on the part. `snap`: also directions, axes, equal
/// radii and round numbers that noise hides. Returns what holds now, with a triangle instead of every face.
pub fn relate(map: &mut Map<'_>, snap: bool, context: &Context) -> Result<Vec<Adjusted>> {
    let _stage = context.stage("relations");
    let graph = Graph::of(map.t, &map.label, map.pieces.len(), &[])?;
    let found = Found::of(map);
    let snap = snap && map.is_noisy();
    let claims = found.claims(map, &graph, snap);
    // What is exact stays as it is.
    if !snap && claims.iter().all(|c| c.relation.off(&found.bodies) <= NAMED_DISTANCE) {
        return Ok(Vec::new());
    }
    let (mut adjusted, mut held) = adjusted(&found.bodies, claims, context)?;
    if snap {
        let rounded = round_values(&adjusted, &held, found.unit.diagonal);
        if !rounded.is_empty() {
            let claims = held.into_iter().chain(rounded).collect();
            (adjusted, held) = self::adjusted(&found.bodies, claims, context)?;
        }
    }
    if held.is_empty() {
        return Ok(Vec::new());
    }
    let triangle = |body: &u32| {
        let piece = found.number.iter().position(|n| n == body);
        piece.and_then(|p| map.pieces[p].triangles.first().copied()).unwrap_or(0)
    };
    let told = |claim: &Claim| {
        let (relation, [before, after]) = claim.relation.told(&found.bodies, found.unit.diagonal);
        Adjusted { relation, faces: claim.relation.bodies().iter().map(triangle).collect(), before, after }
    };
    let all = held.iter().map(told).collect();
    apply(map, &found, &adjusted);
    Ok(all)
}

/// Surfaces adjusted to claims, and those of these that they can be adjusted to.
fn adjusted(bodies: &[Body], mut held: Vec<Claim>, context: &Context) -> Result<(Vec<Body>, Vec<Claim>)> {
    for _ in 0..RELATION_ROUNDS {
        if held.is_empty() {
            break;
        }
        let mut adjusted = bodies.to_vec();
        let all = |b: &[Body]| held.iter().flat_map(|c| c.relation.conditions(b)).collect::<Vec<_>>();
        let multipliers = adjust(&mut adjusted, all, context)?;
        let mut dropped: Vec<usize> = match multipliers {
            // They cannot all hold: the one that is farthest off is the least likely.
            None => {
                let share = |k: usize| held[k].relation.off(bodies) / held[k].bound;
                (0..held.len()).max_by(|&i, &j| share(i).total_cmp(&share(j))).into_iter().collect()
            }
            // The one that pulls most at a surface which is worse for it.
            Some(multipliers) => {
                let pull = strains(&held, bodies, &multipliers);
                let strongest = |b: &u32| {
                    let of = |k: &usize| held[*k].relation.bodies().contains(b);
                    (0..held.len()).filter(of).max_by(|&i, &j| pull[i].total_cmp(&pull[j]))
                };
                worse(bodies, &adjusted).iter().filter_map(strongest).collect()
            }
        };
        tracing::debug!(held = held.len(), dropped = dropped.len(), "adjusted");
        if dropped.is_empty() {
            return Ok((adjusted, held));
        }
        dropped.sort_unstable();
        dropped.dedup();
        dropped.iter().rev().for_each(|&k| drop(held.remove(k)));
    }
    Ok((bodies.to_vec(), Vec::new()))
}

/// The largest multiplier of the conditions of every relation.
fn strains(held: &[Claim], bodies: &[Body], multipliers: &[f64]) -> Vec<f64> {
    let mut rest = multipliers;
    let mut of = |c: &Claim| {
        let (own, other) = rest.split_at(c.relation.conditions(bodies).len());
        rest = other;
        own.iter().map(|m| m.abs()).fold(0.0, f64::max)
    };
    held.iter().map(&mut of).collect()
}

/// Surfaces that are farther from their vertices than the noise explains.
fn worse(before: &[Body], after: &[Body]) -> Vec<u32> {
    let is_worse = |(k, (b, a)): (u32, (&Body, &Body))| {
        let ([rms, max], [new_rms, new_max]) = (b.residuals(), a.residuals());
        let bad = new_rms > WORSE_FACTOR * rms + FILE_PRECISION || new_max > WORSE_FACTOR * max + FILE_PRECISION;
        bad.then_some(k)
    };
    (0u32..).zip(before.iter().zip(after)).filter_map(is_worse).collect()
}

fn apply(map: &mut Map<'_>, found: &Found, bodies: &[Body]) {
    let unit = found.unit;
    for (p, &number) in found.number.iter().enumerate().filter(|(_, n)| **n != NONE) {
        let primitive = bodies[number as usize].primitive.moved(|p| unit.leave(p), |l| l * unit.diagonal);
        let id = map.new_id();
        let piece = &map.pieces[p];
        let (triangles, region) = (piece.triangles.clone(), piece.region);
        let surface = Surface::of_primitive(&primitive);
        map.pieces[p] = Piece { id, ..Piece::on(map.t, triangles, surface, Some(primitive), region) };
    }
}
