//! The faces to be: patches, cut until none touches itself, and leftover triangles.

use super::scene::Scene;
use crate::mesh::FaceId;
use crate::patch::Patch;
use glam::DVec3;

/// One face to be.
pub struct Piece {
    /// Where it comes from.
    pub source: Source,
    /// The corners of the cells of a polygon, or of the triangles of a flat region (the last one twice); else empty.
    pub cells: Vec<[u32; 4]>,
    /// Its border: the outer loop counter-clockwise, then holes clockwise.
    pub loops: Vec<Outline>,
}

/// What a piece is made of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Source {
    /// A rectangle of cells of a patch.
    Block(Block),
    /// A leftover triangle.
    Triangle(FaceId),
    /// A part of a flat region.
    Flat(Flat),
    /// A rectilinear polygon of cells.
    Polygon,
}

/// A part of a flat region.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Flat {
    /// Unit normal of its plane.
    pub normal: DVec3,
    /// One of its triangles.
    pub first: u32,
}

/// A rectangle of cells of a patch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Block {
    /// Index of the patch.
    pub patch: u32,
    /// First row and first column.
    pub from: [u32; 2],
    /// Number of rows and of columns.
    pub size: [u32; 2],
}

/// One closed border of a piece.
#[derive(Default)]
pub struct Outline {
    /// Mesh vertices in order; the first is not repeated.
    pub vertices: Vec<u32>,
    /// Whether the border turns there in the parameter plane; an edge never passes a corner.
    pub corner: Vec<bool>,
    /// Column and row of every vertex, counted from the piece's own first ones; empty for triangles.
    pub at: Vec<[u32; 2]>,
}

impl Block {
    /// The mesh vertex at a node of the block.
    pub fn vertex(&self, patches: &[Patch], row: u32, col: u32) -> u32 {
        patches[self.patch as usize].vertex(self.from[0] + row, self.from[1] + col).0
    }

    /// The corners of all cells, counter-clockwise, row by row.
    pub fn cells(self, patches: &[Patch]) -> impl Iterator<Item = [u32; 4]> {
        let at = move |r, c| self.vertex(patches, r, c);
        let corners = move |r, c| [at(r, c), at(r, c + 1), at(r + 1, c + 1), at(r + 1, c)];
        (0..self.size[0]).flat_map(move |r| (0..self.size[1]).map(move |c| corners(r, c)))
    }

    /// The border, counter-clockwise from the first node, as (row, column) of the block.
    fn border(&self) -> impl Iterator<Item = [u32; 2]> + use<> {
        let [m, n] = self.size;
        let bottom = (0..n).map(|c| [0, c]);
        let right = (0..m).map(move |r| [r, n]);
        let top = (1..=n).rev().map(move |c| [m, c]);
        let left = (1..=m).rev().map(|r| [r, 0]);
        bottom.chain(right).chain(top).chain(left)
    }

    fn outline(&self, patches: &[Patch]) -> Outline {
        let [m, n] = self.size;
        let mut out = Outline::default();
        for [r, c] in self.border() {
            out.vertices.push(self.vertex(patches, r, c));
            out.corner.push((r == 0 || r == m) && (c == 0 || c == n));
            out.at.push([c, r]);
        }
        out
    }

    /// The two halves before and behind a line of nodes; `axis` 0 cuts between rows, 1 between columns.
    pub fn cut(&self, axis: usize, at: u32) -> [Block; 2] {
        let (mut low, mut high) = (*self, *self);
        low.size[axis] = at;
        high.from[axis] += at;
        high.size[axis] -= at;
        [low, high]
    }
}

/// All patches, cut where they touch themselves, and all leftover triangles.
pub fn pieces(scene: &Scene) -> Vec<Piece> {
    let blocks = blocks(scene).into_iter().map(|b| Piece::block(scene.patches, b));
    blocks.chain(scene.leftover.iter().map(|&t| Piece::triangle(scene, t))).collect()
}

/// All patches, cut where they touch themselves.
pub fn blocks(scene: &Scene) -> Vec<Block> {
    let patches = scene.patches;
    let mut cutter = Cutter { patches, seen: vec![0; scene.points.len()], round: 0 };
    let mut blocks = Vec::with_capacity(patches.len());
    for (k, patch) in patches.iter().enumerate() {
        cutter.cut(Block { patch: k as u32, from: [0, 0], size: [patch.rows, patch.cols] }, &mut blocks);
    }
    blocks
}

impl Outline {
    /// The border of a plane face, without corners.
    pub fn of_plane(vertices: Vec<u32>) -> Self {
        Outline { corner: vec![false; vertices.len()], vertices, at: Vec::new() }
    }
}

impl Piece {
    /// A triangle of the mesh that it stands for; of polygons it is not known.
    pub fn first(&self, patches: &[Patch]) -> Option<FaceId> {
        match self.source {
            Source::Block(b) => Some(patches[b.patch as usize].cell_triangles(b.from[0], b.from[1])[0]),
            Source::Triangle(t) => Some(t),
            Source::Flat(flat) => Some(FaceId(flat.first)),
            Source::Polygon => None,
        }
    }

    /// A block of a patch.
    pub fn block(patches: &[Patch], block: Block) -> Self {
        Piece { source: Source::Block(block), cells: Vec::new(), loops: vec![block.outline(patches)] }
    }

    /// A leftover triangle.
    pub fn triangle(scene: &Scene, t: FaceId) -> Self {
        let border = Outline { vertices: scene.mesh.face(t).to_vec(), corner: vec![true; 3], at: Vec::new() };
        Piece { source: Source::Triangle(t), cells: Vec::new(), loops: vec![border] }
    }
}

/// Cuts blocks until the border of each passes every vertex once.
///
/// ```text
///   a ── b ── c ── a            a ── b      b ── c ── a
///   │    │    │    │     →      │    │      │    │    │      a closed strip
///   d ── e ── f ── d            d ── e      e ── f ── d
/// ```
struct Cutter<'a> {
    patches: &'a [Patch],
    /// The round in which a vertex was last passed.
    seen: Vec<u32>,
    round: u32,
}

impl Cutter<'_> {
    fn cut(&mut self, block: Block, out: &mut Vec<Block>) {
        let mut open = vec![block];
        while let Some(block) = open.pop() {
            if self.repetitions(&block) == 0 {
                out.push(block);
            } else if let Some([low, high]) = self.best_cut(&block) {
                open.extend([high, low]);
            } else {
                // A single cell: its corners differ, so this is not reached.
                out.push(block);
            }
        }
    }

    /// How often the border passes a vertex again.
    fn repetitions(&mut self, block: &Block) -> u32 {
        self.round = self.round.wrapping_add(1);
        let mut again = 0;
        for [r, c] in block.border() {
            let seen = &mut self.seen[block.vertex(self.patches, r, c) as usize];
            again += u32::from(*seen == self.round);
            *seen = self.round;
        }
        again
    }

    /// The cut with the fewest repetitions left; among equals the one nearest to the middle of the longer side.
    fn best_cut(&mut self, block: &Block) -> Option<[Block; 2]> {
        let mut cuts: Vec<(u64, usize, u32)> = Vec::new();
        for axis in 0..2 {
            let (n, across) = (block.size[axis], block.size[1 - axis]);
            // Cells of the larger half: the smaller, the better balanced.
            cuts.extend((1..n).map(|at| (u64::from(at.max(n - at)) * u64::from(across), axis, at)));
        }
        cuts.sort_unstable();
        let mut best: Option<(u32, [Block; 2])> = None;
        for (_, axis, at) in cuts {
            let halves = block.cut(axis, at);
            let left = self.repetitions(&halves[0]) + self.repetitions(&halves[1]);
            if best.is_none_or(|(fewest, _)| left < fewest) {
                best = Some((left, halves));
            }
            if left == 0 {
                break;
            }
        }
        best.map(|(_, halves)| halves)
    }
}
