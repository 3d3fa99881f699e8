//! Blocks: the grids of quads between the walls.

use super::net::{Net, next, previous};
use super::tracks::Walls;
use crate::context::Context;
use crate::error::{Error, Result};
use crate::mesh::NONE;
use rustc_hash::FxHashMap;

/// A grid of quads.
///
/// ```text
///          3 ┌───┬───┬───┐ 2
///   v        ├───┼───┼───┤        corners and sides counter-clockwise
///   ▲        ├───┼───┼───┤
///   │      0 └───┴───┴───┘ 1
///   └──► u
/// ```
#[derive(Debug, Clone)]
pub struct Block {
    /// Number of quads along u and v.
    pub size: [usize; 2],
    /// The lower side of every quad, as a half-edge along u; u runs fastest.
    pub lower: Vec<u32>,
}

impl Block {
    /// The lower side of a quad.
    pub fn at(&self, i: usize, j: usize) -> u32 {
        self.lower[j * self.size[0] + i]
    }

    /// The half-edges of a side, counter-clockwise.
    pub fn side(&self, side: usize) -> Vec<u32> {
        let [m, n] = self.size;
        match side {
            0 => (0..m).map(|i| self.at(i, 0)).collect(),
            1 => (0..n).map(|j| next(self.at(m - 1, j))).collect(),
            2 => (0..m).rev().map(|i| next(next(self.at(i, n - 1)))).collect(),
            _ => (0..n).rev().map(|j| previous(self.at(0, j))).collect(),
        }
    }

    /// The half-edge that leaves a corner, counter-clockwise along the border.
    pub fn corner(&self, corner: usize) -> u32 {
        self.side(corner)[0]
    }
}

/// The blocks between the walls. Walls are added where there would be no grid, and where a block touches itself.
pub fn blocks(net: &Net, walls: &mut Walls, context: &Context) -> Result<Vec<Block>> {
    let mut of_quad = vec![NONE; net.quads.len()];
    let mut out: Vec<Block> = Vec::new();
    let mut q = 0;
    while q < net.quads.len() {
        context.check_every(q)?;
        if of_quad[q] != NONE {
            q += 1;
            continue;
        }
        match grid(net, walls, q as u32) {
            Ok(block) => {
                if let Some(cut) = middle_line(net, &block) {
                    cut.into_iter().for_each(|h| walls.add(net, h));
                    continue;
                }
                block.lower.iter().for_each(|&h| of_quad[h as usize / 4] = out.len() as u32);
                out.push(block);
            }
            Err(start) if walls.is_wall[start as usize] => {
                return Err(Error::Numeric("the quads cannot be divided into grids".into()));
            }
            Err(start) => walls.start_at(net, start, context)?,
        }
    }
    Ok(out)
}

/// The grid around a quad, or a half-edge from which a wall has to start where it goes round.
fn grid(net: &Net, walls: &Walls, q: u32) -> std::result::Result<Block, u32> {
    let mut place: FxHashMap<u32, ([i32; 2], u32)> = FxHashMap::default();
    let mut order = vec![4 * q];
    place.insert(q, ([0, 0], 4 * q));
    let (mut low, mut high) = ([0, 0], [0, 0]);
    let mut at = 0;
    while at < order.len() {
        let lower = order[at];
        at += 1;
        let ([i, j], _) = place[&(lower / 4)];
        let mut side = lower;
        for step in [[0, -1], [1, 0], [0, 1], [-1, 0]] {
            let o = net.opposite[side as usize];
            if !walls.is_wall[side as usize] && o != NONE {
                // The side of the neighbour that lies like `lower`: opposite of `side`, turned.
                let turned = turn(o, step);
                let to = [i + step[0], j + step[1]];
                match place.get(&(o / 4)) {
                    Some(&known) if known != (to, turned) => return Err(side),
                    Some(_) => {}
                    None => {
                        place.insert(o / 4, (to, turned));
                        order.push(turned);
                        (0..2).for_each(|k| (low[k], high[k]) = (low[k].min(to[k]), high[k].max(to[k])));
                    }
                }
            }
            side = next(side);
        }
    }
    let size = [0, 1].map(|k| (high[k] - low[k] + 1) as usize);
    if size[0] * size[1] != order.len() {
        return Err(inner_corner(net, walls, &order));
    }
    let mut lowers = vec![NONE; order.len()];
    for &lower in &order {
        let ([i, j], _) = place[&(lower / 4)];
        lowers[(j - low[1]) as usize * size[0] + (i - low[0]) as usize] = lower;
    }
    if lowers.contains(&NONE) { Err(inner_corner(net, walls, &order)) } else { Ok(Block { size, lower: lowers }) }
}

/// The lower side of a quad that is entered through its side `o`.
fn turn(o: u32, step: [i32; 2]) -> u32 {
    match step {
        [0, -1] => next(next(o)),
        [1, 0] => next(o),
        [0, 1] => o,
        _ => previous(o),
    }
}

/// Where a set of quads that is no rectangle can be cut: from a vertex on its border, inwards.
fn inner_corner(net: &Net, walls: &Walls, lowers: &[u32]) -> u32 {
    let sides = lowers.iter().flat_map(|&l| [0, 1, 2, 3].map(|k| l & !3 | k));
    let open = |h: u32| !walls.is_wall[h as usize] && net.opposite[h as usize] != NONE;
    // A half-edge that goes inwards from the border.
    let found = sides.clone().find(|&h| open(h) && walls.is_wall[previous(h) as usize]);
    found.or_else(|| sides.clone().find(|&h| open(h))).unwrap_or(lowers[0])
}

/// The half-edges across the middle of a block that touches itself, at a vertex or along edges: no loop of a face goes through a vertex
/// twice, because programs that look for such a border on the surface take one corner for the other.
fn middle_line(net: &Net, block: &Block) -> Option<Vec<u32>> {
    let mut own: Vec<u32> = (0..4).flat_map(|s| block.side(s)).map(|h| net.start(h)).collect();
    own.sort_unstable();
    if own.windows(2).all(|w| w[0] != w[1]) {
        return None;
    }
    let [m, n] = block.size;
    if m >= n && m > 1 {
        Some((0..n).map(|j| previous(block.at(m / 2, j))).collect())
    } else {
        (n > 1).then(|| (0..m).map(|i| block.at(i, n / 2)).collect())
    }
}

/// A wall between two nodes, as a part of the side of a block.
#[derive(Debug, Clone)]
pub struct ArcUse {
    /// The arc.
    pub arc: u32,
    /// Whether the border runs against it.
    pub reversed: bool,
    /// The side of the block, and where on it the use begins and ends, in edges from the side's start.
    pub side: usize,
    /// See `side`.
    pub from: usize,
    /// See `side`.
    pub to: usize,
}

/// How blocks are joined.
pub struct Layout {
    /// Vertices at both ends of every arc, in the sense of its first user.
    pub arcs: Vec<[u32; 2]>,
    /// Uses around every block, counter-clockwise.
    pub uses: Vec<Vec<ArcUse>>,
}

/// The arcs of the walls between nodes: vertices where walls meet, and corners of blocks.
pub fn layout(net: &Net, walls: &Walls, blocks: &[Block]) -> Result<Layout> {
    let mut is_node = vec![false; net.role.len()];
    let mut degree = vec![0u32; net.role.len()];
    let mut seen = vec![false; net.ends.len()];
    for (h, &edge) in net.edge.iter().enumerate() {
        if walls.is_wall[h] && !std::mem::replace(&mut seen[edge as usize], true) {
            net.ends[edge as usize].iter().for_each(|&v| degree[v as usize] += 1);
        }
    }
    degree.iter().zip(&mut is_node).for_each(|(&d, node)| *node = d > 2);
    blocks.iter().flat_map(|b| [0, 1, 2, 3].map(|c| b.corner(c))).for_each(|h| is_node[net.start(h) as usize] = true);
    let mut out = Layout { arcs: Vec::new(), uses: Vec::with_capacity(blocks.len()) };
    let mut arc_of = vec![NONE; net.ends.len()];
    for block in blocks {
        let mut uses = Vec::new();
        for side in 0..4 {
            let path = block.side(side);
            let mut from = 0;
            for to in 1..=path.len() {
                if to < path.len() && !is_node[net.start(path[to]) as usize] {
                    continue;
                }
                let edges: Vec<u32> = path[from..to].iter().map(|&h| net.edge[h as usize]).collect();
                let known = arc_of[edges[0] as usize];
                if edges.iter().any(|&e| arc_of[e as usize] != known) {
                    return Err(Error::Bug("two blocks do not agree about the wall between them".into()));
                }
                let ends = [net.start(path[from]), net.end(path[to - 1])];
                let arc = if known == NONE { out.arcs.len() as u32 } else { known };
                if known == NONE {
                    edges.iter().for_each(|&e| arc_of[e as usize] = arc);
                    out.arcs.push(ends);
                }
                uses.push(ArcUse { arc, reversed: known != NONE, side, from, to });
                from = to;
            }
        }
        out.uses.push(uses);
    }
    Ok(out)
}
