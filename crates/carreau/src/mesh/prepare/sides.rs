//! The two sides of every face, and which of them meet across edges.

use crate::mesh::disjoint_sets::SignedSets;
use crate::mesh::half_edges::HalfEdges;
use crate::mesh::position::by_position;
use crate::mesh::repair::Soup;
use crate::mesh::triangles::NONE;
use glam::DVec3;

/// The edges of a welded surface, with what is known of the sides of each.
pub struct Sides<'a> {
    pub soup: &'a Soup,
    /// The sheet of every corner at its vertex, as far as it is known: only whether two are equal counts.
    own: &'a [u32],
    half_edges: HalfEdges,
    pub face_of: Vec<u32>,
    pub next: Vec<u32>,
    pub repeats: Vec<bool>,
}

/// An edge of more than two faces, its lower end first, and its sides, by the corners that they leave.
pub struct Crowded {
    pub ends: [u32; 2],
    pub sides: Vec<u32>,
}

/// Whether a place comes before another one.
pub fn is_lower(a: DVec3, b: DVec3) -> bool {
    by_position(a, b).is_lt()
}

impl<'a> Sides<'a> {
    pub fn new(soup: &'a Soup, own: &'a [u32]) -> Self {
        Sides {
            soup,
            own,
            half_edges: soup.half_edges(),
            face_of: soup.faces.face_of_corners(),
            next: soup.faces.next_corners(),
            repeats: soup.faces_with_repeats(),
        }
    }

    /// The sides of every edge, without those of faces that use a vertex twice.
    pub(super) fn each_edge(&self, mut visit: impl FnMut([u32; 2], &[u32])) {
        let mut sides = Vec::new();
        for edge in self.half_edges.groups() {
            sides.clear();
            sides.extend(edge.corners().filter(|&c| !self.repeats[self.face_of[c as usize] as usize]));
            visit(edge.ends, &sides);
        }
    }

    pub(super) fn face(&self, c: u32) -> u32 {
        self.face_of[c as usize]
    }

    /// Whether a side leaves the vertex with the smaller number.
    pub(super) fn is_forward(&self, c: u32) -> bool {
        let start = self.soup.faces.corners();
        start[c as usize] < start[self.next[c as usize] as usize]
    }

    /// The corners of a side at the vertex with the smaller number, and at the other one.
    pub(super) fn corners(&self, c: u32) -> [u32; 2] {
        let n = self.next[c as usize];
        if self.is_forward(c) { [c, n] } else { [n, c] }
    }

    /// What tells a side from others of its edge that lie in other sheets.
    pub(super) fn key(&self, c: u32) -> [u32; 2] {
        self.corners(c).map(|c| self.own[c as usize])
    }

    /// The faces to turn so that neighbours agree, in every part the fewer; none where all do. Neighbours share an edge of two
    /// faces, or of two faces of one sheet. What agrees already is linked first: a surface with one side only keeps its seam.
    pub fn turned(&self) -> Option<Vec<bool>> {
        let mut senses = SignedSets::new(self.soup.faces.len());
        let mut turns: Vec<[u32; 2]> = Vec::new();
        self.each_edge(|_, sides| {
            let mut link = |c: u32, d: u32| {
                if self.is_forward(c) == self.is_forward(d) {
                    turns.push([self.face(c), self.face(d)]);
                } else {
                    senses.relate(self.face(c), self.face(d), false);
                }
            };
            match *sides {
                [c, d] => link(c, d),
                [_, _, _, ..] => pairs_of_one(sides, |c| self.key(c)).into_iter().for_each(|[c, d]| link(c, d)),
                _ => {}
            }
        });
        if turns.is_empty() {
            return None;
        }
        for [f, g] in turns {
            senses.relate(f, g, true);
        }
        let turned = senses.smaller_parts();
        turned.contains(&true).then_some(turned)
    }

    /// Faces that use a vertex twice go with the first sheet of each of theirs.
    pub(super) fn add_repeats(&self, sheet: &mut [u32]) {
        let mut least = vec![NONE; self.soup.points.len()];
        let is_repeat = |c: usize| self.repeats[self.face_of[c] as usize];
        let corners = self.soup.faces.corners();
        for (c, &v) in corners.iter().enumerate().filter(|(c, _)| !is_repeat(*c)) {
            least[v as usize] = least[v as usize].min(sheet[c]);
        }
        (0..corners.len()).filter(|&c| is_repeat(c)).for_each(|c| sheet[c] = least[corners[c] as usize]);
    }

    /// The edges of more than two faces, in an order that no numbers of vertices change.
    pub(super) fn crowded(&self) -> Vec<Crowded> {
        let mut all: Vec<(Vec<u32>, [[u64; 3]; 2], Crowded)> = Vec::new();
        self.each_edge(|ends, sides| {
            if sides.len() > 2 {
                let place = |v: u32| self.soup.points[v as usize];
                let [a, b] = ends;
                let ends = if is_lower(place(b), place(a)) { [b, a] } else { [a, b] };
                let mut faces: Vec<u32> = sides.iter().map(|&c| self.face(c)).collect();
                faces.sort_unstable();
                let mut sides = sides.to_vec();
                sides.sort_by_key(|&c| self.face(c));
                let places = ends.map(|v| place(v).to_array().map(f64::to_bits));
                all.push((faces, places, Crowded { ends, sides }));
            }
        });
        all.sort_by(|a, b| (&a.0, a.1, a.2.ends).cmp(&(&b.0, b.1, b.2.ends)));
        all.into_iter().map(|(_, _, edge)| edge).collect()
    }
}

/// Pairs of sides that alone have a key.
pub fn pairs_of_one<K: Ord + Copy>(sides: &[u32], key: impl Fn(u32) -> K) -> Vec<[u32; 2]> {
    let mut keyed: Vec<(K, u32)> = sides.iter().map(|&c| (key(c), c)).collect();
    keyed.sort_unstable();
    let groups = keyed.chunk_by(|a, b| a.0 == b.0).filter(|group| group.len() == 2);
    groups.map(|group| [group[0].1, group[1].1]).collect()
}
