//! Edges of more than two faces: which of their sides belong to one sheet, and the vertices of sheets that only touch.
//!
//! Two bodies in contact share vertices once these are welded: four faces meet in an edge. Each side finds the other one of its
//! own body, in this order:
//!
//! 1. the two sides that share the edge in the file, by their own vertices;
//! 2. the two sides of one name (`solid`, `object`, `body`, `group`);
//! 3. the two sides of one part of the surface, linked elsewhere by edges of two faces;
//! 4. by the sense of the faces: the material between two of them belongs to one body;
//! 5. by angle, where the senses do not tell.
//!
//! ```text
//!     │ B            │ B
//!     │              │
//! ────•────   →   ───╯           two bodies A and B: each gets a vertex of its own
//!   A │             A ╭───
//!     │               │
//! ```
//!
//! What 3 to 5 say counts only where the sheet comes out closed: plates that cross stay as they are.

use super::super::disjoint_sets::DisjointSets;
use super::super::half_edges::HalfEdges;
use super::super::repair::{Soup, copies_of_tagged};
use super::super::surface::SurfaceMesh;
use super::super::triangles::NONE;
use super::radial::pairs_around;
use crate::context::Context;
use crate::error::Result;

/// The sides of all edges.
pub(in crate::mesh) struct Sheets {
    half_edges: HalfEdges,
    /// The other side of every half-edge, named by the corner that it leaves; [`NONE`] on borders and where none was found.
    mate: Vec<u32>,
    /// The sides without a mate of every edge with more than two.
    loose: Vec<Vec<u32>>,
    /// The ends of the edges all of whose sides were paired, and of those that stay.
    pub paired: Vec<[u32; 2]>,
    pub left: Vec<[u32; 2]>,
}

/// An edge of more than two faces.
struct Crowded {
    ends: [u32; 2],
    sides: Vec<u32>,
}

impl Sheets {
    /// Looks for the sides that belong together; `original` is what the soup was made of.
    pub fn of(soup: &Soup, original: &SurfaceMesh, context: &Context) -> Result<Self> {
        let half_edges = soup.half_edges();
        let repeats = soup.faces_with_repeats();
        let face_of = soup.faces.face_of_corners();
        let mut mate = vec![NONE; soup.faces.corners().len()];
        let mut crowded = Vec::new();
        let mut linked = DisjointSets::new(soup.faces.len());
        let mut sides: Vec<u32> = Vec::new();
        for edge in half_edges.groups() {
            sides.clear();
            sides.extend(edge.corners().filter(|&c| !repeats[face_of[c as usize] as usize]));
            match sides[..] {
                [] | [_] => {}
                [c, d] => {
                    (mate[c as usize], mate[d as usize]) = (d, c);
                    linked.union(face_of[c as usize], face_of[d as usize]);
                }
                _ => crowded.push(Crowded { ends: edge.ends, sides: sides.clone() }),
            }
        }
        let mut sheets = Sheets { half_edges, mate, loose: Vec::new(), paired: Vec::new(), left: Vec::new() };
        if !crowded.is_empty() {
            context.check()?;
            let guesses = Finder::new(soup, original, &face_of, linked.leaders()).pair(&crowded, &mut sheets.mate);
            sheets.dissolve(&guesses, &crowded, &face_of, soup.faces.len());
            sheets.sort_out(&crowded);
        }
        Ok(sheets)
    }

    /// Takes guessed pairs apart where the sheet is open.
    fn dissolve(&mut self, guesses: &[[u32; 2]], crowded: &[Crowded], face_of: &[u32], faces: usize) {
        let mut sets = DisjointSets::new(faces);
        for (c, &d) in self.mate.iter().enumerate().filter(|(_, d)| **d != NONE) {
            sets.union(face_of[c], face_of[d as usize]);
        }
        let sheet = sets.leaders();
        let mut open = vec![false; faces];
        for (c, _) in self.mate.iter().enumerate().filter(|(_, d)| **d == NONE) {
            open[sheet[face_of[c] as usize] as usize] = true;
        }
        debug_assert!(guesses.is_empty() || !crowded.is_empty());
        for &[c, d] in guesses.iter().filter(|[c, _]| open[sheet[face_of[*c as usize] as usize] as usize]) {
            (self.mate[c as usize], self.mate[d as usize]) = (NONE, NONE);
        }
    }

    /// Which edges have all their sides paired. Two sides that are left over belong together: what is regular without the others.
    fn sort_out(&mut self, crowded: &[Crowded]) {
        for edge in crowded {
            let loose: Vec<u32> = edge.sides.iter().copied().filter(|&c| self.mate[c as usize] == NONE).collect();
            match loose[..] {
                [] => self.paired.push(edge.ends),
                [c, d] => {
                    (self.mate[c as usize], self.mate[d as usize]) = (d, c);
                    self.paired.push(edge.ends);
                }
                _ => {
                    self.left.push(edge.ends);
                    self.loose.push(loose);
                }
            }
        }
    }

    /// Gives every umbrella of a vertex a vertex of its own: that of the file, where it had one. Sides without a mate stay
    /// together. Returns how many vertices are copies, and one that was copied.
    pub fn separate(&self, soup: &mut Soup, original: &SurfaceMesh) -> (usize, Option<u32>) {
        let umbrella = self.umbrellas(soup);
        let own: Vec<u32> = soup.corner_source.iter().map(|&c| original.faces().corners()[c as usize]).collect();
        let repeats = soup.faces_with_repeats();
        let face_of = soup.faces.face_of_corners();
        // The file's vertex of every umbrella: the first of those that its corners had.
        let mut source = vec![NONE; umbrella.len()];
        for (c, &u) in umbrella.iter().enumerate().filter(|(c, _)| !repeats[face_of[*c] as usize]) {
            source[u as usize] = source[u as usize].min(own[c]);
        }
        let named = |&c: &u32| umbrella[c as usize] == c && source[c as usize] != NONE;
        let mut firsts: Vec<u32> = (0..umbrella.len() as u32).filter(named).collect();
        let old: Vec<u32> = soup.faces.corners().to_vec();
        firsts.sort_by_key(|&c| (old[c as usize], source[c as usize], c));
        if firsts.windows(2).all(|w| old[w[0] as usize] != old[w[1] as usize]) {
            return (0, None);
        }
        let mut of_umbrella = old.clone();
        for of_vertex in firsts.chunk_by(|&a, &b| old[a as usize] == old[b as usize]).filter(|list| list.len() > 1) {
            for (k, &c) in of_vertex.iter().enumerate() {
                let v = old[c as usize];
                if k > 0 {
                    of_umbrella[c as usize] = soup.points.len() as u32;
                    soup.points.push(original.points()[source[c as usize] as usize]);
                    soup.vertex_source.push(source[c as usize]);
                } else {
                    soup.points[v as usize] = original.points()[source[c as usize] as usize];
                    soup.vertex_source[v as usize] = source[c as usize];
                }
            }
        }
        let new: Vec<u32> = (0..old.len()).map(|c| of_umbrella[umbrella[c] as usize]).collect();
        let next = soup.faces.next_corners();
        soup.tagged = copies_of_tagged(&soup.tagged, &self.half_edges, &new, &next);
        soup.faces.corners_mut().copy_from_slice(&new);
        for (c, &v) in own.iter().enumerate().rev() {
            soup.vertex_image[v as usize] = new[c];
        }
        let copies = soup.in_order_of_source();
        (copies.len(), copies.first().copied())
    }

    /// The umbrella of every corner, by its smallest corner.
    fn umbrellas(&self, soup: &Soup) -> Vec<u32> {
        let (start, next) = (soup.faces.corners(), soup.faces.next_corners());
        let mut sets = DisjointSets::new(start.len());
        // The corners of a half-edge at the smaller and the larger vertex.
        let ends = |c: u32| {
            let n = next[c as usize];
            if start[c as usize] < start[n as usize] { [c, n] } else { [n, c] }
        };
        let mut link = |c: u32, d: u32| {
            let (a, b) = (ends(c), ends(d));
            sets.union(a[0], b[0]);
            sets.union(a[1], b[1]);
        };
        for (c, &d) in (0u32..).zip(&self.mate).filter(|&(c, &d)| d != NONE && c < d) {
            link(c, d);
        }
        self.loose.iter().flat_map(|sides| sides.windows(2)).for_each(|w| link(w[0], w[1]));
        sets.leaders()
    }
}

/// What is known about the sides of an edge.
struct Finder<'a> {
    soup: &'a Soup,
    face_of: &'a [u32],
    next: Vec<u32>,
    /// The file's vertex of every corner.
    own: Vec<u32>,
    /// Body name of every face of the file.
    names: Option<&'a [i32]>,
    /// The part of the surface that every face is in.
    part: Vec<u32>,
}

impl<'a> Finder<'a> {
    fn new(soup: &'a Soup, original: &'a SurfaceMesh, face_of: &'a [u32], part: Vec<u32>) -> Self {
        let own = soup.corner_source.iter().map(|&c| original.faces().corners()[c as usize]).collect();
        let names = super::bodies::labels(original);
        Finder { soup, face_of, next: soup.faces.next_corners(), own, names, part }
    }

    /// Pairs the sides of all crowded edges, and returns the pairs that are guesses.
    fn pair(&self, crowded: &[Crowded], mate: &mut [u32]) -> Vec<[u32; 2]> {
        let mut guesses = Vec::new();
        for edge in crowded {
            let mut rest = edge.sides.clone();
            let mut join = |pairs: Vec<[u32; 2]>, rest: &mut Vec<u32>, guessed: bool| {
                for [c, d] in pairs {
                    (mate[c as usize], mate[d as usize]) = (d, c);
                    rest.retain(|&side| side != c && side != d);
                    if guessed {
                        guesses.push([c, d]);
                    }
                }
            };
            join(pairs_of_one(&rest, |c| self.own_edge(c)), &mut rest, false);
            if self.names.is_some() {
                join(pairs_of_one(&rest, |c| self.name(c)), &mut rest, false);
            }
            let alike = pairs_of_one(&rest, |c| self.part[self.face_of[c as usize] as usize]);
            let alike = alike.into_iter().filter(|&[c, d]| self.is_forward(c) != self.is_forward(d)).collect();
            join(alike, &mut rest, true);
            let mut by_name = rest.clone();
            by_name.sort_by_key(|&c| (self.name(c), c));
            for group in by_name.chunk_by(|&a, &b| self.name(a) == self.name(b)) {
                join(pairs_around(self.soup, edge.ends, group, &self.next, self.face_of), &mut rest, true);
            }
        }
        guesses
    }

    fn own_edge(&self, c: u32) -> [u32; 2] {
        let ends = [self.own[c as usize], self.own[self.next[c as usize] as usize]];
        [ends[0].min(ends[1]), ends[0].max(ends[1])]
    }

    fn name(&self, c: u32) -> Option<i32> {
        let source = self.soup.face_source[self.face_of[c as usize] as usize];
        self.names.map(|names| names[source as usize])
    }

    fn is_forward(&self, c: u32) -> bool {
        let start = self.soup.faces.corners();
        start[c as usize] < start[self.next[c as usize] as usize]
    }
}

/// Pairs of sides that alone have a key.
fn pairs_of_one<K: Ord + Copy>(sides: &[u32], key: impl Fn(u32) -> K) -> Vec<[u32; 2]> {
    let mut keyed: Vec<(K, u32)> = sides.iter().map(|&c| (key(c), c)).collect();
    keyed.sort_unstable();
    let groups = keyed.chunk_by(|a, b| a.0 == b.0).filter(|group| group.len() == 2);
    groups.map(|group| [group[0].1, group[1].1]).collect()
}
