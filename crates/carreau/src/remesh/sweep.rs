//! All vertices move, in classes no two vertices of which are neighbours: the moves of a class are found in parallel.
//!
//! ```text
//!     0───1───0───1
//!      ╲ ╱ ╲ ╱ ╲ ╱         what a move is worth depends on the neighbours of its vertex,
//!       2───0───2          and these stay while the class moves
//!      ╱ ╲ ╱ ╲ ╱ ╲
//!     1───2───1───2
//! ```
//!
//! The moves are the same for any number of threads. Dihedral angles reach one triangle farther than the neighbours: they are
//! looked at once more when the moves are made, one after the other.

use super::curves::Rank;
use super::relocate::Move;
use super::work::Work;
use crate::context::Context;
use crate::error::Result;
use crate::mesh::NONE;
use rayon::prelude::*;

/// Vertices that are looked at together: in the order of space they are near each other, and what is known of them stays at
/// hand while their classes take turns.
const CHUNK: usize = 2048;
/// Vertices that a thread takes at least.
const VERTICES_PER_TASK: usize = 64;
/// The class of what does not move; others are numbered below.
const STAYS: u32 = u64::BITS;

impl Work<'_> {
    /// Moves every vertex once to where `find` wants it. Returns how many moved.
    pub fn sweep<F>(&mut self, context: &Context, find: F) -> Result<usize>
    where
        F: Fn(&Self, u32) -> Option<Move> + Sync,
    {
        let class = self.classes();
        let movable: Vec<u32> = (0..self.mesh.vertex_slots()).filter(|&v| class[v as usize] < STAYS).collect();
        let (mut members, mut moves) = (Vec::new(), Vec::new());
        let mut done = 0;
        for chunk in movable.chunks(CHUNK) {
            context.check()?;
            let most = chunk.iter().map(|&v| class[v as usize]).max().unwrap_or(0);
            for k in 0..=most {
                members.clear();
                members.extend(chunk.iter().copied().filter(|&v| class[v as usize] == k));
                let work = &*self;
                let found = members.par_iter().with_min_len(VERTICES_PER_TASK).map(|&v| find(work, v));
                found.collect_into_vec(&mut moves);
                for (&v, to) in members.iter().zip(&moves) {
                    if let Some(to) = to
                        && self.strain_allows(v, to.point, NONE)
                    {
                        self.make(v, to);
                        done += 1;
                    }
                }
            }
        }
        Ok(done)
    }

    /// The class of every vertex, the first that none of its neighbours has. Corners stay, and what is surrounded by all
    /// classes, as no more than a few vertices of very many neighbours are.
    fn classes(&self) -> Vec<u32> {
        let mesh = &self.mesh;
        let mut class = vec![STAYS; mesh.vertex_slots() as usize];
        for v in (0..mesh.vertex_slots()).filter(|&v| mesh.is_vertex(v) && self.rank[v as usize] != Rank::Corner) {
            let mut taken = 0u64;
            mesh.for_neighbours(v, |w| taken |= 1u64.checked_shl(class[w as usize]).unwrap_or(0));
            class[v as usize] = taken.trailing_ones();
        }
        class
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::remesh::RemeshOptions;
    use crate::remesh::source::Source;
    use crate::sample;

    #[test]
    fn neighbours_are_in_different_classes() {
        let context = Context::new();
        let options = RemeshOptions::default();
        for name in ["rounded-box", "torus", "open-cylinder"] {
            let mesh = sample::make(name, None, &context).unwrap().triangulated().unwrap();
            let mut source = Source::new(&mesh, &options, &context).unwrap();
            source.set_sizes(&options, &context).unwrap();
            let work = source.at_work(&options);
            let class = work.classes();
            for v in 0..work.mesh.vertex_slots() {
                assert_eq!(class[v as usize] == STAYS, work.rank[v as usize] == Rank::Corner);
                work.mesh.for_neighbours(v, |w| {
                    assert!(class[v as usize] == STAYS || class[v as usize] != class[w as usize]);
                });
            }
        }
    }
}
