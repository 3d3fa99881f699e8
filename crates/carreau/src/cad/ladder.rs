//! The ladder: what cannot be a face as it is described goes down a rung, a piece at a time, until there is a valid model.

use super::memory::Memory;
use super::model::{Obstacle, attempt};
use super::regions::{Map, Piece, Rung};
use super::shells::enclose;
use super::spline;
use super::tuning::LADDER_ROUNDS;
use crate::brep::Brep;
use crate::context::Context;
use crate::error::{Error, Result};
use crate::geometry::intersections::Intersections;
use crate::geometry::primitive::Kind;
use crate::mesh::{NONE, SurfaceMesh};
use serde::Serialize;
use std::cmp::Ordering;

/// A region that fell.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Fallback {
    /// The region of the segmentation.
    pub region: u32,
    /// Its kind of surface before: `plane`, …, `freeform`.
    pub from: String,
    /// The rung after.
    pub to: Rung,
    /// Why.
    pub reason: String,
}

/// Goes down the ladder until there is a model.
pub fn descend(map: &mut Map<'_>, mesh: &SurfaceMesh, context: &Context) -> Result<(Brep, Vec<Fallback>)> {
    let mut fallback = Vec::new();
    let mut memory = Memory::default();
    // What has no border is cut before anything is tried.
    let is_whole = |map: &Map<'_>, p: u32| {
        let piece = &map.pieces[p as usize];
        piece.rung == Rung::Spline && !spline::has_border(map.t, piece, &map.label)
    };
    let whole: Vec<u32> = (0..map.pieces.len() as u32).filter(|&p| is_whole(map, p) && !map.cut(p)).collect();
    let coarse = map.coarse();
    let reason = "it lies on no surface of a simple kind and has no border";
    fall(map, &whole, Rung::Planes, reason, &mut fallback);
    fall(map, &coarse, Rung::Planes, "its facets cut off too much of its surface", &mut fallback);
    map.compact();
    let mut round = 0;
    loop {
        context.check()?;
        let obstacles = match judged(map, mesh, &mut memory, context)? {
            Ok(brep) => return Ok((brep, fallback)),
            Err(obstacles) => obstacles,
        };
        for obstacle in &obstacles {
            let first = obstacle.pieces.first().map_or(NONE, |&p| map.pieces[p as usize].region);
            tracing::debug!(round, region = first, pieces = ?obstacle.pieces, reason = obstacle.reason, "obstacle");
        }
        match round.cmp(&LADDER_ROUNDS) {
            Ordering::Less => demote(map, &obstacles, round, memory.is_spent(), &mut fallback),
            Ordering::Equal => {
                // Nothing but triangles is left to be said.
                let above = |&p: &u32| map.pieces[p as usize].rung < Rung::Triangles;
                let rest: Vec<u32> = (0..map.pieces.len() as u32).filter(above).collect();
                fall(map, &rest, Rung::Triangles, "no better description was valid", &mut fallback);
                map.compact();
            }
            Ordering::Greater => {
                let reason = obstacles.first().map_or("", |o| o.reason.as_str());
                return Err(refusal(mesh, reason, context)?);
            }
        }
        round += 1;
    }
}

/// Why not even the triangles make a valid model: they cross each other, or else what the validator says.
fn refusal(mesh: &SurfaceMesh, reason: &str, context: &Context) -> Result<Error> {
    let crossing = Intersections::of(mesh, context)?;
    let Some([a, b]) = crossing.places.first() else {
        return Ok(Error::Numeric(format!("not even the triangles make a valid model: {reason}")));
    };
    let [least, plural] = [if crossing.more { "at least " } else { "" }, if crossing.pairs == 1 { "" } else { "s" }];
    Ok(Error::Input {
        what: format!("the surface crosses itself ({least}{} pair{plural} of faces), so that no solid has it for its border", crossing.pairs),
        place: format!("faces {a} and {b}"),
        remedy: "where a wall is thinner than its facets cut off, tessellate the part more finely; else move the crossing sheets apart".into(),
    })
}

/// One attempt and what the validator says: a model, or what is in the way of one.
fn judged(
    map: &mut Map<'_>,
    mesh: &SurfaceMesh,
    memory: &mut Memory,
    context: &Context,
) -> Result<std::result::Result<Brep, Vec<Obstacle>>> {
    let tried = attempt(map, memory, context)?;
    if !tried.obstacles.is_empty() {
        return Ok(Err(tried.obstacles));
    }
    let mut brep = tried.brep;
    enclose(map.t, &map.label, map.pieces.len(), &mut brep)?;
    let obstacles = super::check::obstacles(map, mesh, &brep, context)?;
    Ok(if obstacles.is_empty() { Ok(brep) } else { Err(obstacles) })
}

/// Demotes the cause of every obstacle: the least certain of its pieces.
fn demote(map: &mut Map<'_>, obstacles: &[Obstacle], round: usize, spent: bool, fallback: &mut Vec<Fallback>) {
    let mut chosen: Vec<(u32, &str)> = Vec::new();
    let exact = if map.is_noisy() { f64::INFINITY } else { map.precision };
    for obstacle in obstacles {
        // One fall of a piece may clear more than one obstacle.
        if round + 4 < LADDER_ROUNDS && obstacle.pieces.iter().any(|p| chosen.iter().any(|c| c.0 == *p)) {
            continue;
        }
        let movable = |p: &&u32| map.pieces[**p as usize].rung < Rung::Triangles;
        let weakest = obstacle.pieces.iter().filter(movable).max_by(|&&a, &&b| {
            let (x, y) = (&map.pieces[a as usize], &map.pieces[b as usize]);
            doubt(x, exact).total_cmp(&doubt(y, exact)).then(y.triangles.len().cmp(&x.triangles.len())).then(b.cmp(&a))
        });
        if let Some(&weakest) = weakest {
            chosen.push((weakest, &obstacle.reason));
        } else {
            // Triangles alone are in each other's way: their neighbours hold them there.
            let around = neighbours(map, &obstacle.pieces);
            let next = around.into_iter().find(|&p| map.pieces[p as usize].rung < Rung::Triangles);
            chosen.extend(next.map(|p| (p, obstacle.reason.as_str())));
        }
    }
    chosen.sort_by_key(|c| c.0);
    chosen.dedup_by_key(|c| c.0);
    if chosen.is_empty() {
        chosen.extend((0..map.pieces.len() as u32).map(|p| (p, "its neighbours are not valid")));
        chosen.retain(|c| map.pieces[c.0 as usize].rung < Rung::Triangles);
    }
    for (p, reason) in chosen {
        let rung = map.pieces[p as usize].rung;
        let next = match rung {
            Rung::Analytic | Rung::Swept => Rung::Spline,
            Rung::Spline if !spent && map.cut(p) => continue,
            Rung::Spline => Rung::Planes,
            Rung::Planes | Rung::Triangles => Rung::Triangles,
        };
        fall(map, &[p], next, reason, fallback);
    }
    map.compact();
}

/// The less certain, the larger: whether vertices are on the surface where those of others are exactly, then their distance and the
/// kind.
fn doubt(piece: &Piece, exact: f64) -> f64 {
    let kind = match piece.primitive.map(|p| p.kind()) {
        Some(Kind::Plane) => 0.0,
        Some(Kind::Cylinder) => 1.0,
        Some(Kind::Sphere) => 2.0,
        Some(Kind::Cone) => 3.0,
        Some(Kind::Torus) => 4.0,
        None => 5.0,
    };
    // A decade of distance weighs as much as a kind.
    let residual = (piece.max.max(1e-300)).log10();
    match piece.rung {
        Rung::Planes | Rung::Triangles => -1e3,
        // It follows its vertices whatever they are.
        Rung::Spline => 6.0,
        Rung::Analytic | Rung::Swept if piece.max > exact => 7.0,
        Rung::Analytic | Rung::Swept => kind + residual.max(-30.0),
    }
}

fn neighbours(map: &Map<'_>, pieces: &[u32]) -> Vec<u32> {
    let triangles = pieces.iter().flat_map(|&p| map.pieces[p as usize].triangles.iter().copied());
    let mut found = map.labels_beside(triangles);
    found.retain(|l| !pieces.contains(l));
    found
}

fn fall(map: &mut Map<'_>, which: &[u32], to: Rung, reason: &str, fallback: &mut Vec<Fallback>) {
    for &p in which {
        let piece = &map.pieces[p as usize];
        let from = piece.primitive.map_or("freeform", |p| p.kind().name());
        let known = fallback.iter_mut().find(|f| f.region == piece.region);
        match known {
            Some(known) => known.to = known.to.max(to),
            None => fallback.push(Fallback { region: piece.region, from: from.into(), to, reason: reason.into() }),
        }
    }
    if to == Rung::Spline {
        map.loosen(which);
    } else {
        map.divide(which, to);
    }
}
