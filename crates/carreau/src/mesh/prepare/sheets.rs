//! Which sides of an edge belong to one sheet, and the vertices of sheets that only touch.
//!
//! Two bodies in contact share vertices once these are welded: four faces meet in an edge. Each side finds the other one of its
//! own body, in this order:
//!
//! 1. the two sides that share the edge in the file, by their own vertices;
//! 2. the two sides of one name (`solid`, `object`, `body`, `group`);
//! 3. the two sides of one part of the surface, linked elsewhere, whose senses agree;
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
//! What 3 to 5 say counts only where the sheet comes out closed: plates that cross stay as they are. Pairs are looked for in an
//! order of edges that depends on faces and places alone, so that it is the same in a second preparation.

use super::super::disjoint_sets::{DisjointSets, SignedSets};
use super::super::triangles::NONE;
use super::radial::pairs_around;
use super::sides::{Crowded, Sides, pairs_of_one};

/// Rounds in which only those pairs are taken apart that need it; then all are.
const PARTINGS: usize = 8;

impl<'a> Sides<'a> {
    /// Looks for the sides that belong together; `names`: the body of every face of the file.
    pub fn joined(&self, names: Option<&[i32]>) -> Sheets {
        let mut finder = Finder {
            at: self,
            names,
            mate: vec![NONE; self.soup.faces.corners().len()],
            linked: SignedSets::new(self.soup.faces.len()),
            guesses: Vec::new(),
        };
        self.each_edge(|_, sides| {
            if let [c, d] = *sides {
                finder.join([c, d], false);
            }
        });
        let crowded = self.crowded();
        finder.pair(&crowded);
        let guesses = std::mem::take(&mut finder.guesses);
        let mut sheets = Sheets { mate: finder.mate, crowded };
        if !guesses.is_empty() {
            sheets.dissolve(&guesses, self);
        }
        sheets.join_the_last_two();
        sheets
    }
}

/// The sides that belong together.
pub(super) struct Sheets {
    /// The other side of every half-edge; [`NONE`] on borders and where none was found.
    mate: Vec<u32>,
    pub crowded: Vec<Crowded>,
}

impl Sheets {
    /// Takes guessed pairs apart where the sheet is open.
    fn dissolve(&mut self, guesses: &[[u32; 2]], at: &Sides) {
        let mut sets = DisjointSets::new(at.soup.faces.len());
        for (c, &d) in (0u32..).zip(&self.mate).filter(|&(_, &d)| d != NONE) {
            sets.union(at.face(c), at.face(d));
        }
        let sheet = sets.leaders();
        let mut open = vec![false; sheet.len()];
        for (c, _) in (0u32..).zip(&self.mate).filter(|&(_, &d)| d == NONE) {
            open[sheet[at.face(c) as usize] as usize] = true;
        }
        for &[c, d] in guesses.iter().filter(|[c, _]| open[sheet[at.face(*c) as usize] as usize]) {
            (self.mate[c as usize], self.mate[d as usize]) = (NONE, NONE);
        }
    }

    /// Two sides that are left over belong together: what is regular without the others.
    fn join_the_last_two(&mut self) {
        for edge in &self.crowded {
            let mut loose = edge.sides.iter().copied().filter(|&c| self.mate[c as usize] == NONE);
            if let (Some(c), Some(d), None) = (loose.next(), loose.next(), loose.next()) {
                (self.mate[c as usize], self.mate[d as usize]) = (d, c);
            }
        }
    }

    /// The sheet of every corner, by the first face that it has at the vertex. Sides without a mate stay together, or are cut.
    pub fn of_corners(&mut self, at: &Sides, cut: bool) -> Vec<u32> {
        let mut first = self.umbrellas(at, cut);
        let mut rounds = 0;
        while cut && self.part_doubled(at, &first, rounds == PARTINGS) {
            first = self.umbrellas(at, cut);
            rounds += 1;
        }
        let mut sheet: Vec<u32> = first.into_iter().map(|c| at.face(c)).collect();
        if at.repeats.contains(&true) {
            at.add_repeats(&mut sheet);
        }
        sheet
    }

    /// The umbrella of every corner, by its smallest corner.
    fn umbrellas(&self, at: &Sides, cut: bool) -> Vec<u32> {
        let mut sets = DisjointSets::new(self.mate.len());
        let mut link = |c: u32, d: u32| {
            let (a, b) = (at.corners(c), at.corners(d));
            sets.union(a[0], b[0]);
            sets.union(a[1], b[1]);
        };
        for (c, &d) in (0u32..).zip(&self.mate).filter(|&(c, &d)| d != NONE && c < d) {
            link(c, d);
        }
        if !cut {
            for edge in &self.crowded {
                let loose: Vec<u32> = edge.sides.iter().copied().filter(|&c| self.mate[c as usize] == NONE).collect();
                loose.windows(2).for_each(|w| link(w[0], w[1]));
            }
        }
        sets.leaders()
    }

    /// Takes pairs apart that have the same vertices as others of their edge, or all. Whether there were any.
    fn part_doubled(&mut self, at: &Sides, umbrella: &[u32], all: bool) -> bool {
        let mut found = false;
        for edge in &self.crowded {
            let mut keyed: Vec<([u32; 2], u32)> =
                edge.sides.iter().map(|&c| (at.corners(c).map(|c| umbrella[c as usize]), c)).collect();
            keyed.sort_unstable();
            for &(_, c) in keyed.chunk_by(|a, b| a.0 == b.0).filter(|group| all || group.len() > 2).flatten() {
                let d = std::mem::replace(&mut self.mate[c as usize], NONE);
                if d != NONE {
                    self.mate[d as usize] = NONE;
                    found = true;
                }
            }
        }
        found
    }

    /// The edges whose sides are all in sheets of two, by vertices of the surface.
    pub fn paired(&self, at: &Sides) -> Vec<[u32; 2]> {
        let is_paired = |edge: &&Crowded| 2 * pairs_of_one(&edge.sides, |c| at.key(c)).len() == edge.sides.len();
        self.crowded.iter().filter(is_paired).map(|edge| edge.ends).collect()
    }
}

/// Looks for pairs.
struct Finder<'a> {
    at: &'a Sides<'a>,
    names: Option<&'a [i32]>,
    mate: Vec<u32>,
    /// Faces that are linked, with their senses.
    linked: SignedSets,
    /// Pairs of rules 3 to 5.
    guesses: Vec<[u32; 2]>,
}

impl Finder<'_> {
    fn join(&mut self, [c, d]: [u32; 2], is_guess: bool) {
        (self.mate[c as usize], self.mate[d as usize]) = (d, c);
        let turn = self.at.is_forward(c) == self.at.is_forward(d);
        self.linked.relate(self.at.face(c), self.at.face(d), turn);
        if is_guess {
            self.guesses.push([c, d]);
        }
    }

    /// Pairs the sides of all crowded edges, the surest first.
    fn pair(&mut self, crowded: &[Crowded]) {
        for edge in crowded {
            let pairs = pairs_of_one(&edge.sides, |c| self.at.key(c));
            pairs.into_iter().for_each(|pair| self.join(pair, false));
        }
        if self.names.is_some() {
            for edge in crowded {
                let pairs = pairs_of_one(&self.rest(edge), |c| self.name(c));
                pairs.into_iter().for_each(|pair| self.join(pair, false));
            }
        }
        crowded.iter().for_each(|edge| self.pair_by_parts(edge));
        for edge in crowded {
            self.pair_by_parts(edge);
            let mut rest = self.rest(edge);
            rest.sort_by_key(|&c| (self.name(c), self.at.face(c)));
            let groups = rest.chunk_by(|&a, &b| self.name(a) == self.name(b));
            let pairs: Vec<[u32; 2]> = groups.flat_map(|group| pairs_around(self.at, edge.ends, group)).collect();
            pairs.into_iter().for_each(|pair| self.join(pair, true));
        }
    }

    /// The sides of an edge that have no mate.
    fn rest(&self, edge: &Crowded) -> Vec<u32> {
        edge.sides.iter().copied().filter(|&c| self.mate[c as usize] == NONE).collect()
    }

    /// The two sides of one part, where they agree in sense.
    fn pair_by_parts(&mut self, edge: &Crowded) {
        let mut parts: Vec<(u32, u32, bool)> = Vec::new();
        for c in self.rest(edge) {
            let (part, differs) = self.linked.find(self.at.face(c));
            parts.push((part, c, differs));
        }
        parts.sort_unstable();
        for pair in parts.chunk_by(|a, b| a.0 == b.0) {
            if let &[(_, c, first), (_, d, second)] = pair
                && (first != second) == (self.at.is_forward(c) == self.at.is_forward(d))
            {
                self.join([c, d], true);
            }
        }
    }

    fn name(&self, c: u32) -> Option<i32> {
        let source = self.at.soup.face_source[self.at.face(c) as usize];
        self.names.map(|names| names[source as usize])
    }
}
