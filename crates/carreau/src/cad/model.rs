//! One attempt: from a map of pieces to a model, or to the pieces that are in the way.

use super::borders::border;
use super::corners::place;
use super::curves::{Room, Track, between, straight};
use super::draft::{Draft, DraftFace};
use super::faces::{center_cone, face, turn_sphere};
use super::memory::Memory;
use super::regions::{Map, Piece, Rung};
use super::relations;
use super::spelled::{lay_borders, spell_out};
use super::spline::settle;
use super::topology::{Chain, Graph};
use super::trace::meet;
use super::tuning::{BRANCH_DISTANCE, COPLANAR_DISTANCE, NOISY_BRANCH, SAME_POINT};
use crate::brep::{Brep, Face, Surface};
use crate::context::Context;
use crate::error::Result;
use crate::mesh::NONE;
use glam::DVec3;
use rayon::prelude::*;

/// Pieces of which one is in the way of a valid model, and why.
#[derive(Debug, Clone)]
pub struct Obstacle {
    /// The pieces.
    pub pieces: Vec<u32>,
    /// What is wrong.
    pub reason: String,
}

/// A model with the piece of every face, or obstacles.
pub struct Attempt {
    /// The model; faces in the order of the pieces, shells not made yet.
    pub brep: Brep,
    /// What is in the way; then the model is empty.
    pub obstacles: Vec<Obstacle>,
}

/// Tries to make a model of the map.
pub fn attempt(map: &mut Map<'_>, memory: &mut Memory, context: &Context) -> Result<Attempt> {
    let graph = graph(map)?;
    let refused = |obstacles| Ok(Attempt { brep: Brep::default(), obstacles });
    let tracks = {
        let _stage = context.stage("edges");
        let corners = Corners::of(map, &graph);
        let known = &*memory;
        let one = |c: &Chain| {
            context.check()?;
            let ends = [c.vertices[0], c.vertices[c.vertices.len() - 1]];
            let ends = ends.map(|v| corners.place(v, map.t.points()[v as usize]));
            let key = Memory::key(map, c, ends);
            let track = known.track(&key).cloned().unwrap_or_else(|| track(map, c, ends));
            Ok((key, track))
        };
        let tracks: Vec<_> = context.install(|| graph.chains.par_iter().map(one).collect::<Result<_>>())?;
        tracks.iter().for_each(|(key, track)| memory.keep_track(*key, track));
        tracks.into_iter().map(|(_, track)| track)
    };
    let mut obstacles = Vec::new();
    let mut found = Vec::with_capacity(tracks.len());
    for (track, chain) in tracks.zip(&graph.chains) {
        let pieces = || chain.sides.into_iter().filter(|&s| s != NONE).collect();
        match track {
            Some(track) if track.gap <= map.gap() => found.push(track),
            Some(track) => {
                let share = track.gap / map.diagonal;
                obstacles
                    .push(Obstacle { pieces: pieces(), reason: format!("its edge is {share:.0e} of the size off") });
            }
            None => obstacles
                .push(Obstacle { pieces: pieces(), reason: "it does not meet its neighbour in a curve".into() }),
        }
    }
    if !obstacles.is_empty() {
        return refused(obstacles);
    }
    let mut draft = Draft::default();
    obstacles.extend(place(map, &graph, &mut found, &mut draft));
    if obstacles.is_empty() {
        obstacles.extend(settle(map, &graph, &mut found, memory, context)?);
    }
    if !obstacles.is_empty() {
        return refused(obstacles);
    }
    draft.edges_of(found, &graph);
    let _stage = context.stage("faces");
    let mut faces: Vec<(Face, DraftFace)> = Vec::with_capacity(map.pieces.len());
    for p in 0..map.pieces.len() {
        context.check_every(p)?;
        let loops: Vec<Vec<(u32, bool)>> =
            graph.loops[p].iter().map(|l| l.iter().map(|u| (u.chain, u.reversed)).collect()).collect();
        if matches!(map.pieces[p].surface, Surface::Sphere { .. }) {
            let middle = middle(map, p);
            turn_sphere(&mut map.pieces[p], &draft, &loops, middle);
        }
        let piece = &mut map.pieces[p];
        center_cone(piece, &draft, &loops);
        match face(piece, &mut draft, loops, map.diagonal) {
            Ok(drafted) => {
                let mut face = Face::new(p as u32, Vec::new());
                face.same_sense = piece.same_sense;
                face.region = Some(piece.region);
                faces.push((face, drafted));
            }
            Err(reason) => obstacles.push(Obstacle { pieces: vec![p as u32], reason: reason.into() }),
        }
    }
    if !obstacles.is_empty() {
        return refused(obstacles);
    }
    Ok(Attempt { brep: finished(map, draft, faces), obstacles })
}

/// The model of a draft, on the surfaces of the pieces; extrusions of splines are spelled out.
fn finished(map: &Map<'_>, draft: Draft, mut faces: Vec<(Face, DraftFace)>) -> Brep {
    let mut surfaces: Vec<Surface> = map.pieces.iter().map(|p| p.surface.clone()).collect();
    let mut spelled = Vec::new();
    for (k, ((face, drafted), surface)) in faces.iter_mut().zip(&mut surfaces).enumerate() {
        if let Some(spline) = spell_out(surface, face.same_sense, &draft, &drafted.loops) {
            face.same_sense = true;
            spelled.push((k, spline));
        }
        face.name = format!("{}_{}", surface.kind().name(), face.surface);
        face.trimmed = matches!(surface, Surface::Spline(_));
    }
    let mut brep = draft.finish(surfaces, faces);
    spelled.iter().for_each(|(face, spline)| lay_borders(&mut brep, *face, spline, map.diagonal));
    brep
}

/// The graph of the map, where the vertices at which boundaries of facets bend are corners as well.
fn graph(map: &Map<'_>) -> Result<Graph> {
    let (t, pieces) = (map.t, &map.pieces);
    let forced = |graph: &Graph| -> Vec<u32> {
        let facets = |c: &&Chain| c.sides.iter().all(|&s| s == NONE || pieces[s as usize].rung >= Rung::Planes);
        let mut out = Vec::new();
        for c in graph.chains.iter().filter(facets) {
            let n = c.vertices.len();
            let p = |k: usize| t.points()[c.vertices[k] as usize];
            let bends = |a: DVec3, b: DVec3, c: DVec3| {
                let along = (c - a).normalize_or_zero();
                let off = (b - a) - along * (b - a).dot(along);
                off.length() > COPLANAR_DISTANCE * map.diagonal || (b - a).dot(c - b) <= 0.0
            };
            out.extend((1..n - 1).filter(|&k| bends(p(k - 1), p(k), p(k + 1))).map(|k| c.vertices[k]));
            if c.closed && n > 2 && bends(p(n - 2), p(0), p(1)) {
                out.push(c.vertices[0]);
            }
        }
        out
    };
    let graph = Graph::of(t, &map.label, pieces.len(), &[])?;
    let more = forced(&graph);
    if more.is_empty() { Ok(graph) } else { Graph::of(t, &map.label, pieces.len(), &more) }
}

/// Where corners are that are not vertices of the mesh: beside spline surfaces, on all other surfaces around them.
struct Corners {
    /// Vertices of the mesh, ascending, and their places.
    moved: Vec<(u32, DVec3)>,
}

impl Corners {
    fn of(map: &Map<'_>, graph: &Graph) -> Self {
        let is_spline = |s: u32| s != NONE && map.pieces[s as usize].rung == Rung::Spline;
        let mut around: Vec<(u32, u32)> = Vec::new();
        for chain in graph.chains.iter().filter(|c| !c.closed) {
            for v in [chain.vertices[0], chain.vertices[chain.vertices.len() - 1]] {
                around.extend(chain.sides.iter().filter(|&&s| s != NONE).map(|&s| (v, s)));
            }
        }
        around.sort_unstable();
        around.dedup();
        let place = |at: &[(u32, u32)]| {
            let start = map.t.points()[at[0].0 as usize];
            let others = at.iter().filter(|a| !is_spline(a.1)).map(|a| &map.pieces[a.1 as usize].surface);
            let p = meet(&others.collect::<Vec<&Surface>>(), start);
            let room = (BRANCH_DISTANCE * map.diagonal).max(2.0 * NOISY_BRANCH * map.tolerance);
            (at[0].0, if p.distance(start) <= room { p } else { start })
        };
        let moves = |at: &&[(u32, u32)]| at.iter().any(|a| is_spline(a.1));
        Corners { moved: around.chunk_by(|a, b| a.0 == b.0).filter(moves).map(place).collect() }
    }

    fn place(&self, v: u32, otherwise: DVec3) -> DVec3 {
        self.moved.binary_search_by_key(&v, |m| m.0).map_or(otherwise, |k| self.moved[k].1)
    }
}

fn track(map: &Map<'_>, chain: &Chain, ends: [DVec3; 2]) -> Option<Track> {
    let mut polyline: Vec<DVec3> = chain.vertices.iter().map(|&v| map.t.points()[v as usize]).collect();
    let closed = chain.vertices[0] == chain.vertices[chain.vertices.len() - 1];
    let side = |s: u32| (s != NONE).then(|| &map.pieces[s as usize]);
    let [a, b] = chain.sides.map(side);
    let a = a?;
    let b = b.unwrap_or(a);
    let facets = a.rung >= Rung::Planes && b.rung >= Rung::Planes;
    let flat = |p: &Piece| matches!(p.surface, Surface::Plane { .. });
    if (facets || (chain.sides[1] == NONE && flat(a)))
        && let Some(track) = straight(&polyline, SAME_POINT * 10.0 * map.diagonal)
    {
        return Some(track);
    }
    if a.rung == Rung::Spline || b.rung == Rung::Spline {
        let last = polyline.len() - 1;
        if !chain.closed {
            (polyline[0], polyline[last]) = (ends[0], ends[1]);
        }
        let other = [a, b].into_iter().find(|p| p.rung != Rung::Spline);
        return border(other.map(|p| &p.surface), &polyline, closed, map.diagonal);
    }
    if map.is_noisy() && !closed {
        polyline = between_ends(&polyline, ends);
    }
    // A vertex of the edge is as near to the curve as it is to both surfaces, more where these meet at a small angle.
    let room = 4.0 * (a.max + b.max) + super::tuning::FILE_PRECISION * map.diagonal;
    let crossing = room.min((BRANCH_DISTANCE * map.diagonal).max(NOISY_BRANCH * map.tolerance));
    between(a, b, &polyline, closed, map.diagonal, Room { crossing, touching: relations::room(a, b, map.diagonal) })
}

/// A noisy polyline between other ends: without what lies beyond them.
fn between_ends(polyline: &[DVec3], [a, b]: [DVec3; 2]) -> Vec<DVec3> {
    let ahead = |p: DVec3, from: DVec3, to: DVec3| (p - from).dot(to - from) > 0.0;
    let inside = |w: &[DVec3]| {
        let [before, p, next] = [w[0], w[1], w[2]];
        ahead(p, a, next).then_some(()).and(ahead(p, b, before).then_some(p))
    };
    let inner = polyline.windows(3).filter_map(inside).filter(|p| *p != a && *p != b);
    std::iter::once(a).chain(inner).chain([b]).collect()
}

/// The mean of a piece's vertices, weighted by area.
fn middle(map: &Map<'_>, p: usize) -> DVec3 {
    let (mut sum, mut total) = (DVec3::ZERO, 0.0);
    for &k in &map.pieces[p].triangles {
        let area = super::regions::area_vector(map.t, k).length();
        sum += area * map.t.triangle(k).map(|v| map.t.points()[v as usize]).iter().sum::<DVec3>() / 3.0;
        total += area;
    }
    sum / f64::max(total, f64::MIN_POSITIVE)
}
