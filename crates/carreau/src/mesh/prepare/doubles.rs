//! Of several faces on the same vertices one stays; two where they are the wall between two bodies.
//!
//! ```text
//! ┌─────╥─────┐      A and B share a face: with one wall, three faces would meet in its border and neither
//! │  A  ║  B  │      body would be closed. A body that is in the file twice has an even number of faces
//! └─────╨─────┘      at every edge with one of each as well.
//! ```

use super::super::disjoint_sets::DisjointSets;
use super::super::duplicates::first_on_same_vertices;
use super::super::repair::Soup;
use super::bodies;
use crate::mesh::SurfaceMesh;

/// For every face the one that stands for it: itself, if it stays.
pub(super) fn kept(soup: &Soup, original: &SurfaceMesh) -> Vec<u32> {
    let repeats = soup.faces_with_repeats();
    let first = first_on_same_vertices(&soup.faces, &repeats);
    if first.iter().enumerate().all(|(f, &l)| f == l as usize) {
        return first;
    }
    Groups::new(soup, original, first).kept(&repeats)
}

/// The faces, those on the same vertices together.
struct Groups<'a> {
    soup: &'a Soup,
    original: &'a SurfaceMesh,
    first: Vec<u32>,
    /// Number of faces of every group, by its first.
    size: Vec<u32>,
}

impl<'a> Groups<'a> {
    fn new(soup: &'a Soup, original: &'a SurfaceMesh, first: Vec<u32>) -> Self {
        let mut size = vec![0; first.len()];
        first.iter().for_each(|&l| size[l as usize] += 1);
        Groups { soup, original, first, size }
    }

    /// For every face the one that stands for it: itself, if it stays.
    fn kept(&self, repeats: &[bool]) -> Vec<u32> {
        let mut kept = self.first.clone();
        let seconds = self.seconds();
        for (l, _) in self.walls(repeats).iter().enumerate().filter(|(_, wall)| **wall) {
            if let Some(second) = seconds[l] {
                kept[second as usize] = second;
            }
        }
        kept
    }

    /// Which groups are walls, by their first faces. Groups of one size that hang together are one or not as a whole.
    fn walls(&self, repeats: &[bool]) -> Vec<bool> {
        let (face_of, half_edges) = (self.soup.faces.face_of_corners(), self.soup.half_edges());
        let mut together = DisjointSets::new(self.first.len());
        let mut crowded: Vec<Vec<u32>> = Vec::new();
        for edge in half_edges.groups().filter(|edge| edge.len() > 2) {
            let mut leaders: Vec<u32> = edge
                .corners()
                .map(|c| face_of[c as usize])
                .filter(|&f| !repeats[f as usize])
                .map(|f| self.first[f as usize])
                .collect();
            leaders.sort_unstable();
            leaders.dedup();
            for (k, &a) in leaders.iter().enumerate().filter(|&(_, &a)| self.size[a as usize] > 1) {
                if let Some(&b) = leaders[..k].iter().rev().find(|&&b| self.size[b as usize] == self.size[a as usize]) {
                    together.union(a, b);
                }
            }
            crowded.push(leaders);
        }
        let patch = together.leaders();
        // A wall makes even what is odd with one of each, and nothing else.
        let (mut mends, mut harms) = (vec![false; self.first.len()], vec![false; self.first.len()]);
        for leaders in &crowded {
            let odd = leaders.len() % 2 == 1;
            let doubled = leaders.iter().filter(|&&l| self.size[l as usize] > 1);
            for of_patch in by_patch(doubled, &patch) {
                let changes = of_patch.len() % 2 == 1;
                let place = if odd && leaders.len() > 2 { &mut mends } else { &mut harms };
                if changes {
                    place[patch[of_patch[0] as usize] as usize] = true;
                }
            }
        }
        (0..self.first.len())
            .map(|f| self.size[f] > 1 && mends[patch[f] as usize] && !harms[patch[f] as usize])
            .collect()
    }

    /// For every group the face of a wall that stays beside its first: one of another name, else one of the other sense, else
    /// any.
    fn seconds(&self) -> Vec<Option<u32>> {
        let names = bodies::labels(self.original);
        let name = |f: u32| names.map(|names| names[self.soup.face_source[f as usize] as usize]);
        let rank = |f: u32, leader: u32| {
            let turns = is_reversed(self.soup.faces.face(leader as usize), self.soup.faces.face(f as usize));
            (name(f) == name(leader), !turns, f)
        };
        let mut seconds: Vec<Option<u32>> = vec![None; self.first.len()];
        for (f, &leader) in (0u32..).zip(&self.first).filter(|&(f, &leader)| f != leader) {
            let second = &mut seconds[leader as usize];
            if second.is_none_or(|known| rank(f, leader) < rank(known, leader)) {
                *second = Some(f);
            }
        }
        seconds
    }
}

/// Faces of one patch together.
fn by_patch<'a>(faces: impl Iterator<Item = &'a u32>, patch: &[u32]) -> Vec<Vec<u32>> {
    let mut sorted: Vec<u32> = faces.copied().collect();
    sorted.sort_by_key(|&f| (patch[f as usize], f));
    sorted.chunk_by(|&a, &b| patch[a as usize] == patch[b as usize]).map(<[u32]>::to_vec).collect()
}

/// Whether a face on the same vertices runs the other way.
pub(super) fn is_reversed(a: &[u32], b: &[u32]) -> bool {
    let n = a.len();
    let Some(k) = b.iter().position(|&v| v == a[0]) else { return false };
    a[1] == b[(k + n - 1) % n] && a[1] != b[(k + 1) % n]
}
