//! The motorcycle graph: from every singular point and every corner with room for more than one quad, tracks follow the
//! branches of the frames until they meet a feature or another track across their way.
//!
//! All tracks move at once, the shortest first, from vertex to vertex of a [`Sheet`]: a track that crosses a triangle
//! divides the edge where it leaves. What is near a vertex goes through it. A track that would run into another one, or
//! into a feature, at too flat an angle for a quad on both sides is taken back: the patch there is not regular, then.

use super::sheet::{Sheet, Wall};
use crate::context::Context;
use crate::error::Result;
use crate::mesh::NONE;
use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::f64::consts::{FRAC_PI_2, PI};

/// Crossings nearer to an end of an edge, as a share of it, go through the vertex.
const SNAP: f64 = 0.12;
/// Ends of tracks on a wall that are nearer to each other, in lengths of quads, are one.
const NODE: f64 = 0.5;
/// Tracks are taken back where they are longer than so many diagonals.
const LONGEST: f64 = 4.0;

/// How a track leaves a vertex.
#[derive(Debug, Clone, Copy)]
enum Port {
    /// Into the triangle of this half-edge, which leaves the vertex, on this branch.
    Into(u32, i32),
    /// Along this half-edge, which leaves the vertex, in this branch of its triangle.
    Along(u32, i32),
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

    /// Quads between a wall that leaves a vertex and the next one, counter-clockwise, and the half-edge that comes in there.
    pub fn sector(&self, start: u32) -> Option<(i32, u32)> {
        let (mut h, mut s, mut theta) = (start, self.branch[start as usize], 0.0);
        loop {
            let back = Self::previous(h);
            theta += self.angle(h / 3, self.along(h), -self.along(back)).max(0.0);
            if self.is_wall(back) {
                let turn = (self.branch[back as usize] + 2 - s).rem_euclid(4);
                let nearest = |k: &i32| (f64::from(*k) - theta / FRAC_PI_2).abs();
                let k = (0..4).map(|j| turn + 4 * j).min_by(|a, b| nearest(a).total_cmp(&nearest(b)))?;
                return Some((k, back));
            }
            let across = self.opposite[back as usize];
            if across == NONE || across == start {
                return None;
            }
            s += self.turn[back as usize];
            h = across;
        }
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
        let own = self.sector(h).is_some_and(|(k, _)| k >= 1);
        let before = self.wall_before(h).is_some_and(|b| self.sector(b).is_some_and(|(k, _)| k >= 1));
        own && before
    }

    /// One step from a vertex; the vertex that it leads to. `None` where it would follow a wall.
    fn step(&mut self, port: Port) -> Option<u32> {
        let along = |sheet: &mut Self, h: u32, branch: i32| {
            if sheet.is_wall(h) {
                return None;
            }
            sheet.set_wall(h, Wall::Track, branch);
            Some(sheet.head(h))
        };
        let (h, s) = match port {
            Port::Along(h, s) => return along(self, h, s),
            Port::Into(h, s) => (h, s),
        };
        let (t, back) = (h / 3, Self::previous(h));
        let (d, n) = (self.direction(t, s), self.normal(t));
        let side = |x: glam::DVec3| n.dot(d.cross(x));
        let (right, left) = (side(self.along(h)), side(-self.along(back)));
        let share = if left > right { (-right / (left - right)).clamp(0.0, 1.0) } else { 0.5 };
        // Through the vertex, unless there is no room for a quad on both sides of the track.
        let near = if share < SNAP { Some((h, s)) } else { (share > 1.0 - SNAP).then_some((back, s + 2)) };
        if let Some((edge, branch)) = near.filter(|n| !self.is_wall(n.0)) {
            self.set_wall(edge, Wall::Track, branch);
            let (from, to) = (self.tail(h), if edge == h { self.head(h) } else { self.tail(back) });
            if self.can_arrive(from, to) {
                return Some(to);
            }
            self.clear_wall(edge);
        }
        let far = Self::next(h);
        if let Some(to) = self.node_beside(h, s, share) {
            return Some(to);
        }
        let at =
            self.points[self.tail(far) as usize].lerp(self.points[self.head(far) as usize], share.clamp(0.05, 0.95));
        let from = self.tail(h);
        let m = self.divide(far, at);
        let edge = self.between(from, m)?;
        self.set_wall(edge, Wall::Track, s);
        Some(m)
    }

    /// Where the way leads into a wall close to one of its nodes: to the node. Ends that nearly meet would leave arcs that are
    /// too short for a quad, and sides that cannot add up.
    fn node_beside(&mut self, h: u32, s: i32, share: f64) -> Option<u32> {
        let (far, back) = (Self::next(h), Self::previous(h));
        if !self.is_wall(far) {
            return None;
        }
        let length = self.along(far).length();
        let ends = [(share * length, h, s), ((1.0 - share) * length, back, s + 2)];
        let near = if ends[0].0 <= ends[1].0 { [ends[0], ends[1]] } else { [ends[1], ends[0]] };
        for (distance, edge, branch) in near {
            let to = if edge == h { self.head(h) } else { self.tail(back) };
            if distance > NODE * self.length || self.is_wall(edge) || self.walls_at(to, NONE).0 < 3 {
                continue;
            }
            self.set_wall(edge, Wall::Track, branch);
            if self.can_arrive(self.tail(h), to) {
                return Some(to);
            }
            self.clear_wall(edge);
        }
        None
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
                && self.wall[h as usize] == Wall::Track
            {
                self.clear_wall(h);
                queue.push(self.head(h));
            }
        }
    }

    /// Takes a track back.
    fn erase(&mut self, track: &Track) {
        for w in track.vertices.windows(2) {
            if let Some(h) = self.between(w[0], w[1]) {
                self.clear_wall(h);
            }
        }
    }
}

/// Draws the motorcycle graph; `quads`: of the inner vertices that do not have four. Returns how many tracks were taken back.
pub fn trace(sheet: &mut Sheet, quads: &[(u32, i32)], diagonal: f64, context: &Context) -> Result<usize> {
    let _stage = context.stage("motorcycle graph");
    let mut race =
        Race { sheet, tracks: Vec::new(), queue: BinaryHeap::new(), longest: LONGEST * diagonal, dropped: 0 };
    race.start_at_features();
    quads.iter().for_each(|&(v, k)| race.start_at_singularity(v, k));
    race.run(context)?;
    let dropped = race.dropped;
    sheet.prune();
    Ok(dropped)
}

/// Cuts from a wall into a patch, a quarter turn from the half-edge that leaves a vertex; returns whether it arrived.
pub fn cut(sheet: &mut Sheet, start: u32, diagonal: f64, context: &Context) -> Result<bool> {
    let mut race =
        Race { sheet, tracks: Vec::new(), queue: BinaryHeap::new(), longest: LONGEST * diagonal, dropped: 0 };
    let branch = race.sheet.branch[start as usize];
    let port = race.sheet.port(start, branch, 1);
    race.start(start, port);
    race.run(context)?;
    Ok(race.dropped == 0)
}

struct Race<'a> {
    sheet: &'a mut Sheet,
    tracks: Vec<Track>,
    queue: BinaryHeap<Reverse<(u64, u32)>>,
    longest: f64,
    dropped: usize,
}

impl Race<'_> {
    fn start_at_features(&mut self) {
        for v in 0..self.sheet.out.len() as u32 {
            let features =
                |sheet: &Sheet| -> Vec<u32> { sheet.around(v).into_iter().filter(|&h| sheet.is_feature(h)).collect() };
            let starts = features(self.sheet);
            let counts: Vec<i32> = starts.iter().map(|&h| self.sheet.sector(h).map_or(0, |s| s.0)).collect();
            for (j, k) in counts.into_iter().enumerate().filter(|&(_, k)| k >= 3) {
                for m in 1..k {
                    let Some(&h) = features(self.sheet).get(j) else { continue };
                    let port = self.sheet.port(h, self.sheet.branch[h as usize], m);
                    self.start(h, port);
                }
            }
        }
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

    /// The first step of a track that leaves the vertex of a half-edge.
    fn start(&mut self, h: u32, port: Option<Port>) {
        let v = self.sheet.tail(h);
        let Some(to) = port.and_then(|port| self.sheet.step(port)) else {
            self.dropped += 1;
            return;
        };
        let length = self.sheet.points[v as usize].distance(self.sheet.points[to as usize]);
        self.tracks.push(Track { vertices: vec![v, to], length });
        self.push(self.tracks.len() as u32 - 1);
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
            if !self.sheet.has_room(back) {
                self.drop(id);
            }
            return;
        }
        if track.length > self.longest {
            return self.drop(id);
        }
        let port = self.sheet.port(back, self.sheet.branch[back as usize], 2);
        let Some(to) = port.and_then(|port| self.sheet.step(port)) else { return self.drop(id) };
        let track = &mut self.tracks[id as usize];
        track.length += self.sheet.points[at as usize].distance(self.sheet.points[to as usize]);
        track.vertices.push(to);
        self.push(id);
    }

    fn drop(&mut self, id: u32) {
        let track = self.tracks[id as usize].clone();
        self.sheet.erase(&track);
        self.dropped += 1;
    }
}
