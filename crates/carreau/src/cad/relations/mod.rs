//! Relations between surfaces that hold exactly on the part, and only within the noise in the fits: surfaces that touch, corners of four
//! and more, in noisy data also directions that are parallel or perpendicular.
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

mod conditions;
mod contact;
mod search;
#[cfg(test)]
mod tests;

use super::adjust::{Body, Condition, adjust};
use super::regions::{Map, Piece};
use super::topology::Graph;
use super::tuning::{FILE_PRECISION, NAMED_DISTANCE};
use crate::brep::Surface;
use crate::context::Context;
use crate::error::Result;
use crate::mesh::NONE;
use conditions::{concurring, parallel, perpendicular, touching};
use glam::DVec3;
use search::Found;

pub use contact::room;

/// A factor: how much farther from its vertices a surface may be that is adjusted, because more than that is no noise.
const WORSE_FACTOR: f64 = 1.6;
/// A count: rounds in which relations that do not hold are dropped, because each solves for all surfaces.
const RELATION_ROUNDS: usize = 40;

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
}

impl Relation {
    fn bodies(&self) -> &[u32] {
        match self {
            Relation::Touch { bodies, .. } | Relation::Parallel(bodies) | Relation::Perpendicular(bodies) => bodies,
            Relation::Concur { bodies, .. } => bodies,
        }
    }

    /// Numbers that are zero where it holds.
    fn conditions(&self, all: &[Body]) -> Vec<Condition> {
        match self {
            Relation::Touch { bodies, places } => places.iter().map(|&at| touching(all, *bodies, at)).collect(),
            Relation::Concur { bodies, place } => vec![concurring(all, *bodies, *place)],
            Relation::Parallel(bodies) => parallel(all, *bodies),
            Relation::Perpendicular(bodies) => perpendicular(all, *bodies),
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

/// Adjusts the surfaces of a map so that those relations hold exactly which hold on the part.
pub fn relate(map: &mut Map<'_>, context: &Context) -> Result<()> {
    let _stage = context.stage("relations");
    let graph = Graph::of(map.t, &map.label, map.pieces.len(), &[])?;
    let found = Found::of(map);
    let bodies = &found.bodies;
    let mut held = found.claims(map, &graph);
    // What is exact stays as it is.
    if held.iter().all(|c| c.relation.off(bodies) <= NAMED_DISTANCE) {
        return Ok(());
    }
    for _ in 0..RELATION_ROUNDS {
        let mut adjusted = bodies.clone();
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
            apply(map, &found, &adjusted);
            return Ok(());
        }
        dropped.sort_unstable();
        dropped.dedup();
        dropped.iter().rev().for_each(|&k| drop(held.remove(k)));
        if held.is_empty() {
            break;
        }
    }
    Ok(())
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
