//! The motorcycle graph: from every singular point and every corner with room for more than one quad, tracks follow the
//! branches of the frames until they meet a feature or another track across their way.
//!
//! All tracks move at once, the shortest first, from vertex to vertex of a [`Sheet`]: a track that crosses a triangle
//! divides the edge where it leaves. What is near a vertex goes through it. A track that would run into another one, or
//! into a feature, at too flat an angle for a quad on both sides is taken back, and those that had ended in it go on. Two
//! that come towards each other along the same way are one.

use super::sheet::{Sheet, Wall};
use crate::context::Context;
use crate::error::Result;
use crate::mesh::NONE;
use rustc_hash::{FxHashMap, FxHashSet};
use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::f64::consts::{FRAC_PI_2, PI};

/// A share of the edge: crossings nearer to an end go through the vertex, because slivers would be left beside it.
const VERTEX_SNAP: f64 = 0.12;
/// Lengths of quads: ends of tracks on a wall that are nearer to each other are one, because no quad fits between.
const NODE_DISTANCE: f64 = 0.5;
/// A count of diagonals: longer tracks are taken back, because they wind around the surface.
const LONGEST_TRACK: f64 = 4.0;

/// How a track leaves a vertex.
#[derive(Debug, Clone, Copy)]
enum Port {
    /// Into the triangle of this half-edge, which leaves the vertex, on this branch.
    Into(u32, i32),
    /// Along this half-edge, which leaves the vertex, in this branch of its triangle.
    Along(u32, i32),
}

/// The triangles around a vertex from one wall to the next.
#[derive(Debug, Clone, Copy)]
pub struct Sector {
    /// Quads that the frames give it.
    pub quads: i32,
    /// The half-edge that comes in along the second wall.
    pub back: u32,
    /// In radians.
    pub angle: f64,
}

/// Where tracks start.
#[derive(Debug, Clone, Copy)]
pub struct Start {
    pub vertex: u32,
    /// Quads that the frames give the vertex, or its sector.
    pub quads: i32,
    /// On features: the first vertex along the one before the sector, clockwise.
    pub after: Option<u32>,
}

/// What was drawn.
pub struct Traced {
    pub starts: Vec<Start>,
    /// Vertices of the tracks that were not taken back, before edges between them were divided; see [`Sheet::walls_along`].
    pub tracks: Vec<Vec<u32>>,
}

/// A track on its way.
#[derive(Debug, Clone)]
struct Track {
    vertices: Vec<u32>,
    length: f64,
}

fn wrap(angle: f64) -> f64 {
    angle - 2.0 * PI * ((angle - PI) / (2.0 * PI)).ceil()
}

impl Sheet {
    /// The way out of a vertex that is m quarter turns, counter-clockwise, from a branch near the half-edge `start`.
    fn port(&self, start: u32, branch: i32, m: i32) -> Option<Port> {
        let first = start;
        let (mut h, mut s, mut theta) = (start, branch, 0.0);
        let mut lifted = self.angle(h / 3, self.along(h), self.direction(h / 3, s));
        let mut found = None;
        let mut was_ahead = false;
        loop {
            let t = h / 3;
            let back = Self::previous(h);
            let corner = self.angle(t, self.along(h), -self.along(back)).max(0.0);
            let quarter = |j: i32| self.angle(t, self.direction(t, s + j), self.direction(t, s + j + 1));
            let at = lifted + (0..m).map(quarter).sum::<f64>();
            if at >= theta - 1e-9 && at < theta + corner {
                found = Some(Port::Into(h, s + m));
            } else if was_ahead && at < theta {
                found = Some(Port::Along(h, s + m));
            }
            was_ahead = at >= theta + corner;
            theta += corner;
            let across = self.opposite[back as usize];
            if across == NONE || across == first || self.is_feature(back) {
                return found;
            }
            let turned = s + self.turn[back as usize];
            let before = self.angle(t, -self.along(back), self.direction(t, s));
            let after = self.angle(across / 3, self.along(across), self.direction(across / 3, turned));
            lifted += wrap(after - before);
            (h, s) = (across, turned);
        }
    }

    /// What is between a wall that leaves a vertex and the next one, counter-clockwise.
    pub fn sector(&self, start: u32) -> Option<Sector> {
        let (mut h, mut s, mut angle) = (start, self.branch[start as usize], 0.0);
        loop {
            let back = Self::previous(h);
            angle += self.angle(h / 3, self.along(h), -self.along(back)).max(0.0);
            if self.is_wall(back) {
                let turn = (self.branch[back as usize] + 2 - s).rem_euclid(4);
                let nearest = |k: &i32| (f64::from(*k) - angle / FRAC_PI_2).abs();
                let quads = (0..4).map(|j| turn + 4 * j).min_by(|a, b| nearest(a).total_cmp(&nearest(b)))?;
                return Some(Sector { quads, back, angle });
            }
            let across = self.opposite[back as usize];
            if across == NONE || across == start {
                return None;
            }
            s += self.turn[back as usize];
            h = across;
        }
    }

    /// The quads of the sectors from a wall that leaves a vertex on, counter-clockwise, each with the wall behind it: `NONE`
    /// at a border, where they end.
    pub fn sectors(&self, start: u32) -> impl Iterator<Item = (i32, u32)> + '_ {
        let mut wall = start;
        std::iter::from_fn(move || {
            let sector = (wall != NONE).then(|| self.sector(wall))??;
            wall = self.opposite[sector.back as usize];
            Some((sector.quads, wall))
        })
    }

    /// The wall before a wall that leaves a vertex, clockwise.
    fn wall_before(&self, start: u32) -> Option<u32> {
        let mut h = start;
        loop {
            let across = self.opposite[h as usize];
            if across == NONE {
                return None;
            }
            h = Self::next(across);
            if h == start || self.is_wall(h) {
                return Some(h);
            }
        }
    }

    /// Whether there is room for a quad on both sides of the wall that leaves a vertex.
    fn has_room(&self, h: u32) -> bool {
        let own = self.sector(h).is_some_and(|s| s.quads >= 1);
        let before = self.wall_before(h).is_some_and(|b| self.sector(b).is_some_and(|s| s.quads >= 1));
        own && before
    }

    /// Whether a track may go on from or end in a vertex that it has come to.
    fn can_arrive(&self, from: u32, at: u32) -> bool {
        let (walls, feature) = self.walls_at(at, from);
        !(walls > 1 || feature) || self.between(at, from).is_some_and(|back| self.has_room(back))
    }

    fn clear_wall(&mut self, h: u32) {
        self.wall[h as usize] = Wall::None;
        let o = self.opposite[h as usize];
        if o != NONE {
            self.wall[o as usize] = Wall::None;
        }
    }

    /// Takes back what is left of tracks that end in no other wall.
    fn prune(&mut self) {
        let mut queue: Vec<u32> = (0..self.points.len() as u32).collect();
        while let Some(v) = queue.pop() {
            let walls: Vec<u32> = self.around(v).into_iter().filter(|&h| self.is_wall(h)).collect();
            if let [h] = walls[..]
                && !self.is_feature(h)
            {
                self.clear_wall(h);
                queue.push(self.head(h));
            }
        }
    }

    /// The first vertex on the way from one to another, along an edge that may have been divided since.
    fn first_part(&self, a: u32, b: u32) -> Option<u32> {
        match self.between(a, b) {
            Some(_) => Some(b),
            None => self.first_part(a, *self.divided.get(&[a.min(b), a.max(b)])?),
        }
    }

    /// The vertices after the first from one to another, along an edge that may have been divided since.
    fn parts(&self, a: u32, b: u32, into: &mut Vec<u32>) {
        if self.between(a, b).is_some() {
            into.push(b);
        } else if let Some(&m) = self.divided.get(&[a.min(b), a.max(b)]) {
            self.parts(a, m, into);
            self.parts(m, b, into);
        }
    }

    /// The vertices along a track as it is now: where its edges were divided, and without what was taken back at its ends.
    pub fn walls_along(&self, track: &[u32]) -> Vec<u32> {
        let mut all = track.get(..1).unwrap_or_default().to_vec();
        track.windows(2).for_each(|w| self.parts(w[0], w[1], &mut all));
        let is_wall = |w: &[u32]| self.between(w[0], w[1]).is_some_and(|h| self.is_wall(h));
        let Some(first) = all.windows(2).position(is_wall) else { return Vec::new() };
        let count = all[first..].windows(2).take_while(|w| is_wall(w)).count();
        all[first..=first + count].to_vec()
    }

    /// The tracks that leave a start, or have come to it.
    pub fn tracks_at(&self, start: &Start) -> usize {
        let around = self.around(start.vertex);
        let is_track = |h: &u32| self.is_wall(*h) && !self.is_feature(*h);
        let Some(after) = start.after else { return around.into_iter().filter(is_track).count() };
        let first = self.first_part(start.vertex, after);
        let Some(k) = around.iter().position(|&h| Some(self.head(h)) == first) else { return 0 };
        let sector = around[k + 1..].iter().chain(&around[..k]).copied().take_while(|&h| !self.is_feature(h));
        sector.filter(is_track).count()
    }

    /// Clears the walls from one vertex to another, in as many parts as they have been divided into; lists their vertices.
    fn clear_path(&mut self, a: u32, b: u32, cleared: &mut Vec<u32>) {
        if let Some(h) = self.between(a, b) {
            self.clear_wall(h);
            cleared.extend([a, b]);
        } else if let Some(&m) = self.divided.get(&[a.min(b), a.max(b)]) {
            self.clear_path(a, m, cleared);
            self.clear_path(m, b, cleared);
        }
    }
}

/// Draws the motorcycle graph; `quads`: of the inner vertices that do not have four.
pub fn trace(sheet: &mut Sheet, quads: &[(u32, i32)], diagonal: f64, context: &Context) -> Result<Traced> {
    let _stage = context.stage("motorcycle graph");
    let mut race = Race::new(sheet, diagonal);
    let mut starts = race.start_at_features();
    for &(vertex, quads) in quads {
        starts.push(Start { vertex, quads, after: None });
        race.start_at_singularity(vertex, quads);
    }
    race.run(context)?;
    let tracks = race.arrived();
    sheet.prune();
    Ok(Traced { starts, tracks })
}

/// Cuts from a wall into a patch, a quarter turn from the half-edge that leaves a vertex; the vertices of the track, if it
/// arrived.
pub fn cut(sheet: &mut Sheet, start: u32, diagonal: f64, context: &Context) -> Result<Option<Vec<u32>>> {
    let mut race = Race::new(sheet, diagonal);
    let branch = race.sheet.branch[start as usize];
    let port = race.sheet.port(start, branch, 1);
    race.start(start, port);
    race.run(context)?;
    Ok(race.arrived().pop())
}

struct Race<'a> {
    sheet: &'a mut Sheet,
    tracks: Vec<Track>,
    queue: BinaryHeap<Reverse<(u64, u32)>>,
    longest: f64,
    /// Tracks by the vertex that they start from.
    starts: FxHashMap<u32, Vec<u32>>,
}

impl<'a> Race<'a> {
    fn new(sheet: &'a mut Sheet, diagonal: f64) -> Self {
        let (tracks, queue, starts) = (Vec::new(), BinaryHeap::new(), FxHashMap::default());
        Race { sheet, tracks, queue, longest: LONGEST_TRACK * diagonal, starts }
    }

    /// The vertices of the tracks that were not taken back.
    fn arrived(self) -> Vec<Vec<u32>> {
        self.tracks.into_iter().map(|t| t.vertices).filter(|v| !v.is_empty()).collect()
    }

    fn start_at_features(&mut self) -> Vec<Start> {
        let mut all = Vec::new();
        for v in 0..self.sheet.out.len() as u32 {
            let features =
                |sheet: &Sheet| -> Vec<u32> { sheet.around(v).into_iter().filter(|&h| sheet.is_feature(h)).collect() };
            let starts = features(self.sheet);
            let counts: Vec<i32> = starts.iter().map(|&h| self.sheet.sector(h).map_or(0, |s| s.quads)).collect();
            let after: Vec<u32> = starts.iter().map(|&h| self.sheet.head(h)).collect();
            for (j, k) in counts.into_iter().enumerate().filter(|&(_, k)| k >= 3) {
                all.push(Start { vertex: v, quads: k, after: Some(after[j]) });
                for m in 1..k {
                    let Some(&h) = features(self.sheet).get(j) else { continue };
                    let port = self.sheet.port(h, self.sheet.branch[h as usize], m);
                    self.start(h, port);
                }
            }
        }
        all
    }

    fn start_at_singularity(&mut self, v: u32, k: i32) {
        let h = self.sheet.out[v as usize];
        // The first branch counter-clockwise from some edge; then all from that one.
        let ahead = |s: &i32| {
            self.sheet.angle(h / 3, self.sheet.along(h), self.sheet.direction(h / 3, *s)).rem_euclid(2.0 * PI)
        };
        let Some(first) = (0..4).min_by(|a, b| ahead(a).total_cmp(&ahead(b))) else { return };
        let port = self.sheet.port(h, first, 0);
        let before = self.tracks.len();
        self.start(h, port);
        let Some(second) = self.tracks.get(before).map(|t| t.vertices[1]) else { return };
        for m in 1..k {
            let Some(h) = self.sheet.between(v, second) else { return };
            let port = self.sheet.port(h, self.sheet.branch[h as usize], m);
            self.start(h, port);
        }
    }

    /// One step from a vertex; the vertex that it leads to. `None` where it would follow a wall.
    fn step(&mut self, port: Port) -> Option<u32> {
        let (h, s) = match port {
            Port::Along(h, s) => {
                let is_free = !self.sheet.is_wall(h);
                return is_free.then(|| {
                    self.sheet.set_wall(h, Wall::Track, s);
                    self.sheet.head(h)
                });
            }
            Port::Into(h, s) => (h, s),
        };
        let (t, back) = (h / 3, Sheet::previous(h));
        let (d, n) = (self.sheet.direction(t, s), self.sheet.normal(t));
        let side = |x: glam::DVec3| n.dot(d.cross(x));
        let (right, left) = (side(self.sheet.along(h)), side(-self.sheet.along(back)));
        let share = if left > right { (-right / (left - right)).clamp(0.0, 1.0) } else { 0.5 };
        // Through the vertex, unless there is no room for a quad on both sides of the track.
        let near =
            if share < VERTEX_SNAP { Some((h, s)) } else { (share > 1.0 - VERTEX_SNAP).then_some((back, s + 2)) };
        if let Some((edge, branch)) = near {
            match self.along(h, edge, branch) {
                Some(to) => return Some(to),
                // Another track goes the same way, too near for quads between them.
                None if self.is_track_beside(edge, branch) => return None,
                None => {}
            }
        }
        if let Some(to) = self.node_beside(h, s, share) {
            return Some(to);
        }
        let far = Sheet::next(h);
        let [a, b] = [self.sheet.tail(far), self.sheet.head(far)].map(|v| self.sheet.points[v as usize]);
        let from = self.sheet.tail(h);
        let m = self.sheet.divide(far, a.lerp(b, share.clamp(0.05, 0.95)));
        let edge = self.sheet.between(from, m)?;
        self.sheet.set_wall(edge, Wall::Track, s);
        Some(m)
    }

    /// A step along an edge beside the triangle of a half-edge, if the track may arrive at its end.
    fn along(&mut self, h: u32, edge: u32, branch: i32) -> Option<u32> {
        if self.sheet.is_wall(edge) {
            return None;
        }
        self.sheet.set_wall(edge, Wall::Track, branch);
        let (from, to) =
            (self.sheet.tail(h), if edge == h { self.sheet.head(h) } else { self.sheet.tail(Sheet::previous(h)) });
        if self.sheet.can_arrive(from, to) || self.rival(from, to).is_some() {
            return Some(to);
        }
        self.sheet.clear_wall(edge);
        None
    }

    /// Whether a step along an edge would meet a track, at its end, at no angle.
    fn is_track_beside(&mut self, edge: u32, branch: i32) -> bool {
        if self.sheet.is_wall(edge) {
            return self.sheet.wall[edge as usize] == Wall::Track;
        }
        self.sheet.set_wall(edge, Wall::Track, branch);
        let beside = [edge, self.sheet.opposite[edge as usize]].into_iter().filter(|&e| e != NONE).any(|e| {
            let track = |h: u32| self.sheet.wall[h as usize] == Wall::Track;
            let own = self.sheet.sector(e).is_some_and(|s| s.quads <= 0 && track(s.back));
            let before = self
                .sheet
                .wall_before(e)
                .is_some_and(|b| track(b) && self.sheet.sector(b).is_some_and(|s| s.quads <= 0));
            own || before
        });
        self.sheet.clear_wall(edge);
        beside
    }

    /// Where the way leads into a wall close to one of its nodes, or past the start of a track that comes towards this one:
    /// there. Ends that nearly meet would leave arcs that are too short for a quad, and sides that cannot add up.
    fn node_beside(&mut self, h: u32, s: i32, share: f64) -> Option<u32> {
        let (far, back) = (Sheet::next(h), Sheet::previous(h));
        let is_wall = self.sheet.is_wall(far);
        let length = self.sheet.along(far).length();
        let ends = [(share * length, h, s), ((1.0 - share) * length, back, s + 2)];
        let near = if ends[0].0 <= ends[1].0 { [ends[0], ends[1]] } else { [ends[1], ends[0]] };
        for (distance, edge, branch) in near {
            let to = if edge == h { self.sheet.head(h) } else { self.sheet.tail(back) };
            if distance > NODE_DISTANCE * self.sheet.length || self.sheet.walls_at(to, NONE).0 < 3 {
                continue;
            }
            if !is_wall && !self.starts.contains_key(&to) {
                continue;
            }
            if let Some(to) = self.along(h, edge, branch) {
                if is_wall || self.rival(self.sheet.tail(h), to).is_some() {
                    return Some(to);
                }
                self.sheet.clear_wall(edge);
            }
        }
        None
    }

    /// The track that starts where another one has come to, in the direction that this one has come from: both are one.
    fn rival(&self, from: u32, at: u32) -> Option<u32> {
        let starts = self.starts.get(&at)?;
        let back = self.sheet.between(at, from)?;
        let own = self.sheet.sector(back).filter(|s| s.quads <= 0).map(|s| self.sheet.tail(s.back));
        let before = self.sheet.wall_before(back);
        let before = before.filter(|&b| self.sheet.sector(b).is_some_and(|s| s.quads <= 0)).map(|b| self.sheet.head(b));
        let is_beside = |id: &&u32| {
            let [first, second, ..] = self.tracks[**id as usize].vertices[..] else { return false };
            let next = self.sheet.first_part(first, second);
            next.is_some() && (next == own || next == before)
        };
        starts.iter().find(is_beside).copied()
    }

    /// The first step of a track that leaves the vertex of a half-edge.
    fn start(&mut self, h: u32, port: Option<Port>) {
        let v = self.sheet.tail(h);
        let Some(to) = port.and_then(|port| self.step(port)) else {
            return;
        };
        let length = self.sheet.points[v as usize].distance(self.sheet.points[to as usize]);
        let id = self.tracks.len() as u32;
        self.tracks.push(Track { vertices: vec![v, to], length });
        self.starts.entry(v).or_default().push(id);
        self.push(id);
    }

    fn push(&mut self, track: u32) {
        // Lengths are not negative: their bits are ordered as they are.
        self.queue.push(Reverse((self.tracks[track as usize].length.to_bits(), track)));
    }

    fn run(&mut self, context: &Context) -> Result<()> {
        let mut steps = 0;
        while let Some(Reverse((_, id))) = self.queue.pop() {
            steps += 1;
            context.check_every(steps)?;
            self.advance(id);
        }
        Ok(())
    }

    /// One step of a track: it ends where there is a wall, in peace or not.
    fn advance(&mut self, id: u32) {
        let track = &self.tracks[id as usize];
        let [.., before, at] = track.vertices[..] else { return };
        let Some(back) = self.sheet.between(at, before) else { return self.drop(id) };
        let (walls, feature) = self.sheet.walls_at(at, before);
        if walls > 1 || feature {
            while !self.sheet.has_room(back) {
                match self.rival(before, at) {
                    Some(rival) if rival != id => self.drop(rival),
                    _ => return self.drop(id),
                }
            }
            return;
        }
        // Two tracks, head on, have become one.
        if walls == 1 && self.sheet.sector(back).is_some_and(|s| s.quads == 2) {
            return;
        }
        if track.length > self.longest {
            return self.drop(id);
        }
        let port = self.sheet.port(back, self.sheet.branch[back as usize], 2);
        let Some(to) = port.and_then(|port| self.step(port)) else { return self.drop(id) };
        let track = &mut self.tracks[id as usize];
        track.length += self.sheet.points[at as usize].distance(self.sheet.points[to as usize]);
        track.vertices.push(to);
        self.push(id);
    }

    /// Takes a track back; those that ended in it go on.
    fn drop(&mut self, id: u32) {
        let vertices = std::mem::take(&mut self.tracks[id as usize].vertices);
        let Some(&start) = vertices.first() else { return };
        if let Some(starts) = self.starts.get_mut(&start) {
            starts.retain(|&other| other != id);
        }
        let mut cleared = Vec::new();
        vertices.windows(2).for_each(|w| self.sheet.clear_path(w[0], w[1], &mut cleared));
        let freed: FxHashSet<u32> = cleared.into_iter().collect();
        for other in 0..self.tracks.len() as u32 {
            if self.tracks[other as usize].vertices.last().is_some_and(|v| freed.contains(v)) {
                self.push(other);
            }
        }
    }
}
