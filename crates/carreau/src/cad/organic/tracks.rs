//! Walls between blocks: the motorcycle graph of the quads.
//!
//! From every irregular fan a track runs along each of its edges, straight ahead, until it meets another (Eppstein, Goodrich,
//! Kim, Tamstorf: *Motorcycle graphs: canonical quad mesh partitioning*, SGP 2008). Tracks that lead straight from one
//! irregular vertex to another come first: each saves a block, because it has no T-junction.
//!
//! ```text
//!     ●────────────●       first: two ends, no T-junction
//!     │            │
//!     │      ──────┤       then: one end
//! ```

use super::net::{Net, next};
use crate::context::Context;
use crate::error::Result;
use crate::mesh::NONE;
use glam::DVec3;

/// A count: so many places may tracks start in for those between irregular vertices to be sought, because with more,
/// the quads are no grids anyway and time would grow with the square.
const MOST_STARTS: usize = 4000;

/// The walls.
pub struct Walls {
    /// Of every half-edge whether it is part of a wall.
    pub is_wall: Vec<bool>,
    /// Of every fan whether a wall goes through it or ends there.
    visited: Vec<bool>,
}

impl Walls {
    /// The walls of a net.
    pub fn new(net: &Net, points: &[DVec3], context: &Context) -> Result<Self> {
        let is_wall = net.opposite.iter().map(|&o| o == NONE).collect();
        let visited = net.fans.iter().map(|f| !f.closed || !net.is_regular(f)).collect();
        let mut walls = Walls { is_wall, visited };
        let starts: Vec<u32> = net.fans.iter().filter(|f| !net.is_regular(f)).flat_map(inner).collect();
        let few = if starts.len() <= MOST_STARTS { &starts[..] } else { &[] };
        for path in links(net, points, few, context)? {
            for h in path {
                walls.add(net, h);
            }
        }
        walls.race(net, &starts, context)?;
        Ok(walls)
    }

    /// Lets a track run from a vertex, ahead and to both sides, where no wall has been.
    pub fn start_at(&mut self, net: &Net, h: u32, context: &Context) -> Result<()> {
        let fan = &net.fans[net.fan_of[h as usize] as usize];
        self.visited[net.fan_of[h as usize] as usize] = true;
        let starts: Vec<u32> = inner(fan).collect();
        self.race(net, &starts, context)
    }

    fn set(&mut self, net: &Net, h: u32) {
        self.is_wall[h as usize] = true;
        if net.opposite[h as usize] != NONE {
            self.is_wall[net.opposite[h as usize] as usize] = true;
        }
    }

    /// All tracks at once, an edge at a time.
    fn race(&mut self, net: &Net, starts: &[u32], context: &Context) -> Result<()> {
        let mut running = starts.to_vec();
        let mut round = 0;
        while !running.is_empty() {
            context.check_every(round)?;
            round += 1;
            let mut on = Vec::with_capacity(running.len());
            for h in running {
                if self.is_wall[h as usize] {
                    continue;
                }
                self.set(net, h);
                let fan = arrival(net, h) as usize;
                if !std::mem::replace(&mut self.visited[fan], true) {
                    on.push(net.ahead(h));
                }
            }
            running = on;
        }
        Ok(())
    }
}

/// The edges of a fan that are no borders, as half-edges away from its vertex.
fn inner(fan: &super::net::Fan) -> impl Iterator<Item = u32> + '_ {
    fan.spokes.iter().skip(usize::from(!fan.closed)).copied()
}

/// The fan that a half-edge leads into.
fn arrival(net: &Net, h: u32) -> u32 {
    net.fan_of[next(h) as usize]
}

/// Tracks that lead straight from one irregular vertex to another and do not cross, as many as are found: always the one that the
/// fewest others cross, the shortest of several.
fn links(net: &Net, points: &[DVec3], starts: &[u32], context: &Context) -> Result<Vec<Vec<u32>>> {
    let mut all: Vec<(f64, Vec<u32>)> = Vec::new();
    for (k, &h) in starts.iter().enumerate() {
        context.check_every(k)?;
        let known =
            |path: &Vec<u32>| all.iter().any(|l| path.last() == l.1.first().map(|&h| &net.opposite[h as usize]));
        if let Some(path) = link(net, h).filter(|p| !known(p)) {
            let length = |&h: &u32| points[net.start(h) as usize].distance(points[net.end(h) as usize]);
            all.push((path.iter().map(length).sum(), path));
        }
    }
    let mut through: Vec<(u32, usize)> = Vec::new();
    for (k, (_, path)) in all.iter().enumerate() {
        through.extend(path[1..].iter().map(|&h| (net.start(h), k)));
    }
    through.sort_unstable();
    let mut crossing: Vec<Vec<usize>> = vec![Vec::new(); all.len()];
    for group in through.chunk_by(|a, b| a.0 == b.0) {
        for (&(_, a), &(_, b)) in
            group.iter().flat_map(|a| group.iter().map(move |b| (a, b))).filter(|(a, b)| a.1 != b.1)
        {
            crossing[a].push(b);
        }
    }
    crossing.iter_mut().for_each(|others| {
        others.sort_unstable();
        others.dedup();
    });
    let mut open = vec![true; all.len()];
    let mut taken = Vec::new();
    loop {
        context.check()?;
        let rank = |&k: &usize| (crossing[k].iter().filter(|&&o| open[o]).count(), all[k].1.len(), all[k].0, k);
        let ranks = (0..all.len()).filter(|&k| open[k]).map(|k| rank(&k));
        let better = |a: &(usize, usize, f64, usize), b: &(usize, usize, f64, usize)| {
            (a.0, a.1).cmp(&(b.0, b.1)).then(a.2.total_cmp(&b.2)).then(a.3.cmp(&b.3))
        };
        let Some((_, _, _, best)) = ranks.min_by(better) else { break };
        open[best] = false;
        crossing[best].iter().for_each(|&o| open[o] = false);
        taken.push(all[best].1.clone());
    }
    Ok(taken)
}

/// The track straight to another irregular vertex, unless it crosses itself or comes to a border.
fn link(net: &Net, from: u32) -> Option<Vec<u32>> {
    let mut path = vec![from];
    let mut seen: Vec<u32> = Vec::new();
    loop {
        let h = *path.last()?;
        let fan = &net.fans[arrival(net, h) as usize];
        if !net.is_regular(fan) {
            seen.sort_unstable();
            let simple = fan.vertex != net.start(from) && seen.windows(2).all(|w| w[0] != w[1]);
            return simple.then_some(path);
        }
        // No track is longer than all edges, unless it goes round and round.
        if !fan.closed || path.len() > net.ends.len() {
            return None;
        }
        seen.push(fan.vertex);
        path.push(net.ahead(h));
    }
}

impl Walls {
    /// Makes an edge a wall.
    pub fn add(&mut self, net: &Net, h: u32) {
        self.set(net, h);
        self.visited[net.fan_of[h as usize] as usize] = true;
        self.visited[arrival(net, h) as usize] = true;
    }
}

impl Walls {
    /// The same walls after every quad was divided in four.
    pub fn divided(&self, net: &Net) -> Self {
        let mut out = Walls {
            is_wall: net.opposite.iter().map(|&o| o == NONE).collect(),
            visited: net.fans.iter().map(|f| !f.closed || !net.is_regular(f)).collect(),
        };
        // Both halves of side h, in the parts of both of its corners.
        for (h, _) in (0u32..).zip(&self.is_wall).filter(|w| *w.1) {
            out.add(net, 4 * h);
            out.add(net, 4 * next(h) + 3);
        }
        out
    }
}
