//! Corners, edges and loops from the region map alone: no geometry.
//!
//! ```text
//!          region 0                 corner: a vertex with other than two boundary edges
//!    ──●──────────●──               edge:   a maximal chain between corners, or a closed chain
//!      │ region 1 │                 loop:   the edges around a region, its triangles on their left
//! ```
//!
//! Around a vertex a loop stays within the fan of triangles that are joined by edges inside of the region: a region that has
//! two fans at a vertex passes through it twice.

use crate::error::{Error, Result};
use crate::mesh::{NONE, Triangles};

/// The boundary between two regions, from one corner to the next.
#[derive(Debug, Clone, PartialEq)]
pub struct Chain {
    /// The region on the left, and the one on the right ([`NONE`]: nothing, an open border).
    pub sides: [u32; 2],
    /// Half-edges of the left region in the order of travel.
    pub half_edges: Vec<u32>,
    /// Vertices in the order of travel; a closed chain repeats its first one.
    pub vertices: Vec<u32>,
    /// Whether it is a closed curve without a corner.
    pub closed: bool,
}

/// A chain as a part of a loop.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ChainUse {
    /// The chain.
    pub chain: u32,
    /// Whether the loop runs against it.
    pub reversed: bool,
}

/// The boundaries of all regions.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Graph {
    /// Vertices of the mesh where chains end, ascending.
    pub corners: Vec<u32>,
    /// All boundaries.
    pub chains: Vec<Chain>,
    /// Loops of every region.
    pub loops: Vec<Vec<Vec<ChainUse>>>,
}

impl Graph {
    /// Chains and loops of a labelled mesh with `count` regions; some vertices of boundaries are corners in any case.
    pub fn of(t: Triangles<'_>, label: &[u32], count: usize, forced: &[u32]) -> Result<Self> {
        let walk = Walk { t, label };
        let mut corner = walk.corners();
        forced.iter().for_each(|&v| corner[v as usize] = true);
        let corners = (0..corner.len() as u32).filter(|&v| corner[v as usize]).collect();
        let mut graph = Graph { corners, chains: Vec::new(), loops: vec![Vec::new(); count] };
        // The chain that each half-edge is in, as seen from its own region.
        let mut of = vec![NONE; 3 * t.len()];
        let mut against = vec![false; 3 * t.len()];
        for pass in [true, false] {
            for c in 0..3 * t.len() as u32 {
                let starts = !pass || corner[t.vertex(c) as usize];
                if of[c as usize] == NONE && starts && walk.is_boundary(c) {
                    let chain = walk.chain(c, &corner)?;
                    let id = graph.chains.len() as u32;
                    for &h in &chain.half_edges {
                        of[h as usize] = id;
                        let o = t.opposite(h);
                        if o != NONE {
                            (of[o as usize], against[o as usize]) = (id, true);
                        }
                    }
                    graph.chains.push(chain);
                }
            }
        }
        let mut seen = vec![false; 3 * t.len()];
        for c in 0..3 * t.len() as u32 {
            if of[c as usize] == NONE || seen[c as usize] {
                continue;
            }
            let mut uses: Vec<ChainUse> = Vec::new();
            let mut h = c;
            // A loop begins where a chain does.
            let mut steps = 0;
            while !corner[t.vertex(h) as usize] && !graph.chains[of[h as usize] as usize].closed {
                h = walk.next(h);
                steps += 1;
                if steps > 3 * t.len() {
                    return Err(Error::Bug("a loop of the region map has no end".into()));
                }
            }
            let start = h;
            loop {
                let chain = of[h as usize];
                let fresh = corner[t.vertex(h) as usize] || uses.is_empty();
                if fresh {
                    uses.push(ChainUse { chain, reversed: against[h as usize] });
                }
                if std::mem::replace(&mut seen[h as usize], true) {
                    return Err(Error::Bug("two loops of the region map share a half-edge".into()));
                }
                h = walk.next(h);
                if h == start {
                    break;
                }
            }
            graph.loops[label[c as usize / 3] as usize].push(uses);
        }
        Ok(graph)
    }

    /// First and last vertex of a use.
    #[cfg(test)]
    pub fn ends(&self, of: ChainUse) -> [u32; 2] {
        let v = &self.chains[of.chain as usize].vertices;
        let [a, b] = [v[0], v[v.len() - 1]];
        if of.reversed { [b, a] } else { [a, b] }
    }
}

struct Walk<'a> {
    t: Triangles<'a>,
    label: &'a [u32],
}

impl Walk<'_> {
    fn is_boundary(&self, c: u32) -> bool {
        let o = self.t.opposite(c);
        o == NONE || self.label[o as usize / 3] != self.label[c as usize / 3]
    }

    /// Vertices with a number of boundary edges other than 0 and 2.
    fn corners(&self) -> Vec<bool> {
        let t = self.t;
        let mut edges = vec![0u32; t.points().len()];
        for c in (0..3 * t.len() as u32).filter(|&c| self.is_boundary(c)) {
            let o = t.opposite(c);
            if o == NONE || c < o {
                edges[t.vertex(c) as usize] += 1;
                edges[t.vertex(t.next(c)) as usize] += 1;
            }
        }
        edges.into_iter().map(|n| n != 0 && n != 2).collect()
    }

    /// The next half-edge of the loop around the region on the left.
    ///
    /// ```text
    ///      ╲   ╱ ← next
    ///   ────●──╱──
    ///     ↗  the fan inside of the region is turned through
    /// ```
    fn next(&self, c: u32) -> u32 {
        let mut d = self.t.next(c);
        let mut turns = 0;
        while !self.is_boundary(d) && turns <= self.label.len() {
            d = self.t.next(self.t.opposite(d));
            turns += 1;
        }
        d
    }

    fn chain(&self, start: u32, corner: &[bool]) -> Result<Chain> {
        let t = self.t;
        let o = t.opposite(start);
        let sides = [self.label[start as usize / 3], if o == NONE { NONE } else { self.label[o as usize / 3] }];
        let mut chain = Chain { sides, half_edges: Vec::new(), vertices: vec![t.vertex(start)], closed: false };
        let mut c = start;
        loop {
            chain.half_edges.push(c);
            let end = t.vertex(t.next(c));
            chain.vertices.push(end);
            if corner[end as usize] {
                return Ok(chain);
            }
            c = self.next(c);
            if c == start {
                chain.closed = true;
                return Ok(chain);
            }
            if chain.half_edges.len() > 3 * t.len() {
                return Err(Error::Bug("a chain of the region map has no end".into()));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::SurfaceMesh;
    use glam::DVec3;

    #[test]
    fn a_cube_has_8_corners_12_edges_and_a_loop_a_face() {
        let points = (0..8).map(|k| DVec3::new(f64::from(k & 1), f64::from(k >> 1 & 1), f64::from(k >> 2))).collect();
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles: Vec<[u32; 3]> = quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).collect();
        let mesh = SurfaceMesh::from_triangles(points, &triangles).unwrap();
        let label: Vec<u32> = (0..12).map(|t| t / 2).collect();
        let graph = Graph::of(Triangles::of(&mesh).unwrap(), &label, 6, &[]).unwrap();
        assert_eq!((graph.corners.len(), graph.chains.len()), (8, 12));
        assert!(graph.loops.iter().all(|l| l.len() == 1 && l[0].len() == 4));
        for uses in graph.loops.iter().flatten() {
            for (k, &u) in uses.iter().enumerate() {
                assert_eq!(graph.ends(u)[1], graph.ends(uses[(k + 1) % 4])[0]);
            }
        }
        // Two neighbours as one region: the edge between them goes, and its ends are corners no more.
        let merged: Vec<u32> = label.iter().map(|&l| if l == 5 { 3 } else { l }).collect();
        let graph = Graph::of(Triangles::of(&mesh).unwrap(), &merged, 5, &[]).unwrap();
        assert_eq!((graph.corners.len(), graph.chains.len()), (6, 9));
        assert_eq!(graph.loops.iter().map(Vec::len).sum::<usize>(), 5);
    }
}
