//! The curves of chains beside bicubic faces. One curve follows several chains past the nodes at which only the pieces on one side end.
//!
//! ```text
//!    A   ┃   B          A and B end at the node •, C does not: the chains A ┆ C and B ┆ C are one run, so that
//!    ━━━━•━━━━          the side of C is smooth there
//!        C
//! ```
//!
//! All pieces beside a run are curved ones: beside a plane a curve has to stay in that plane.

use super::chain::Chains;
use super::fit::ChainCurve;
use super::piece::Piece;
use super::scene::Scene;
use crate::error::Result;
use crate::mesh::NONE;
use glam::DVec3;
use rustc_hash::FxHashMap;
use std::ops::Range;
use std::sync::Arc;

/// The curves of chains beside bicubic faces, by the vertices of the chain.
#[derive(Default)]
pub struct Curves {
    of: FxHashMap<Vec<u32>, OnRun>,
}

/// The curve of a run.
struct Run {
    vertices: Vec<u32>,
    points: Vec<DVec3>,
    curve: ChainCurve,
}

/// A chain as a part of its run.
struct OnRun {
    run: Arc<Run>,
    /// Its first and last vertex on the run.
    range: [usize; 2],
    /// Whether it is run backwards.
    backwards: bool,
    curve: ChainCurve,
}

/// Some consecutive chains of a side, and the curve along them.
pub type Stretch = (Range<usize>, ChainCurve);

impl Curves {
    /// The curve of a chain; straight from end to end where there is no other.
    pub fn of(&self, path: &[u32]) -> ChainCurve {
        self.of.get(path).map_or_else(ChainCurve::straight, |on| on.curve.clone())
    }

    /// The curves along a side: consecutive chains, each with whether it is passed backwards. Chains of one run have one curve.
    pub fn along(&self, side: &[(&[u32], bool)]) -> Result<Vec<Stretch>> {
        let mut out = Vec::new();
        let mut from = 0;
        while from < side.len() {
            let (path, backwards) = side[from];
            let oriented = |curve: ChainCurve, against: bool| if against { curve.reversed() } else { curve };
            let Some(first) = self.of.get(path) else {
                out.push((from..from + 1, ChainCurve::straight()));
                from += 1;
                continue;
            };
            let against = first.backwards != backwards;
            let mut range = first.range;
            let mut to = from + 1;
            while let Some(next) = side.get(to).and_then(|(path, _)| self.of.get(*path)) {
                match (Arc::ptr_eq(&next.run, &first.run), against) {
                    (true, false) if next.range[0] == range[1] => range[1] = next.range[1],
                    (true, true) if next.range[1] == range[0] => range[0] = next.range[0],
                    _ => break,
                }
                to += 1;
            }
            let curve = match to - from {
                1 => oriented(first.curve.clone(), backwards),
                _ => oriented(first.run.part(range)?, against),
            };
            out.push((from..to, curve));
            from = to;
        }
        Ok(out)
    }

    /// Fits the curves beside candidates that are not known yet, and says which.
    pub fn fit(
        &mut self,
        scene: &Scene,
        pieces: &[Piece],
        chains: &Chains,
        candidates: usize,
        tolerance: f64,
    ) -> Result<Vec<u32>> {
        let mut runs = runs(pieces, chains, candidates);
        let mut in_run = vec![false; chains.paths.len()];
        runs.iter().flatten().for_each(|&(chain, _)| in_run[chain as usize] = true);
        let alone = (0..chains.paths.len() as u32).filter(|&c| !in_run[c as usize]);
        runs.extend(alone.filter(|&c| beside(chains, c, candidates).next().is_some()).map(|c| vec![(c, false)]));
        let mut new = Vec::new();
        for chains_of_run in runs {
            let (mut vertices, mut ranges): (Vec<u32>, Vec<[usize; 2]>) = Default::default();
            for &(chain, backwards) in &chains_of_run {
                let path = &chains.paths[chain as usize];
                let skip = usize::from(!vertices.is_empty());
                let first = vertices.len() - skip;
                match backwards {
                    true => vertices.extend(path.iter().rev().skip(skip)),
                    false => vertices.extend(path.iter().skip(skip)),
                }
                ranges.push([first, vertices.len() - 1]);
            }
            let known = |c: u32| self.of.get(&chains.paths[c as usize]).is_some_and(|on| on.run.vertices == vertices);
            if chains_of_run.iter().all(|&(chain, _)| known(chain)) {
                continue;
            }
            let points: Vec<DVec3> = vertices.iter().map(|&v| scene.point(v)).collect();
            let nodes: Vec<usize> = ranges.iter().skip(1).map(|r| r[0]).collect();
            let curve = ChainCurve::fit(&points, &nodes, tolerance)?;
            let run = Arc::new(Run { vertices, points, curve });
            for (&(chain, backwards), range) in chains_of_run.iter().zip(ranges) {
                let curve = run.part(range)?;
                let curve = if backwards { curve.reversed() } else { curve };
                let on = OnRun { run: run.clone(), range, backwards, curve };
                self.of.insert(chains.paths[chain as usize].clone(), on);
                new.push(chain);
            }
        }
        Ok(new)
    }
}

impl Run {
    fn part(&self, range: [usize; 2]) -> Result<ChainCurve> {
        self.curve.part(range, range.map(|k| self.points[k]))
    }
}

/// The candidates on both sides of a chain.
pub fn beside(chains: &Chains, chain: u32, candidates: usize) -> impl Iterator<Item = usize> + use<> {
    let (a, b) = chains.sides[chain as usize];
    [Some(a), b].into_iter().flatten().map(|k| k as usize).filter(move |&k| k < candidates)
}

/// The chains of a run in order, and whether each is run backwards.
type ChainsOfRun = Vec<(u32, bool)>;

/// All runs of two chains and more along the first pieces, which are the curved ones.
fn runs(pieces: &[Piece], chains: &Chains, curved: usize) -> Vec<ChainsOfRun> {
    let linked = links(pieces, chains, curved);
    let mut seen = vec![false; chains.paths.len()];
    let mut out = Vec::new();
    // Every run from an end that is linked to nothing; the sides of a piece have ends, so no run is closed.
    for start in 0..linked.len() as u32 {
        if linked[start as usize] != NONE || seen[start as usize / 2] {
            continue;
        }
        let mut run = Vec::new();
        let mut from = start;
        loop {
            seen[from as usize / 2] = true;
            run.push((from / 2, from % 2 == 1));
            from = linked[(from ^ 1) as usize];
            if from == NONE || seen[from as usize / 2] {
                break;
            }
        }
        if run.len() > 1 {
            out.push(run);
        }
    }
    out
}

/// Per end of a chain (2 c its first vertex, 2 c + 1 its last one): the end on which its run goes on.
fn links(pieces: &[Piece], chains: &Chains, curved: usize) -> Vec<u32> {
    let mut linked = vec![NONE; 2 * chains.paths.len()];
    let among_curved = |chain: u32| {
        let (a, b) = chains.sides[chain as usize];
        a.max(b.unwrap_or(a)) < curved as u32
    };
    for (piece, loops) in pieces.iter().zip(&chains.loops).take(curved) {
        for (outline, uses) in piece.loops.iter().zip(loops) {
            for (k, of) in uses.iter().enumerate() {
                let next = &uses[(k + 1) % uses.len()];
                let [end, begin] = [2 * of.chain + u32::from(!of.reversed), 2 * next.chain + u32::from(next.reversed)];
                let passed = !outline.corner[next.start as usize % outline.corner.len()] && of.chain != next.chain;
                let free = linked[end as usize] == NONE && linked[begin as usize] == NONE;
                if passed && free && among_curved(of.chain) && among_curved(next.chain) {
                    (linked[end as usize], linked[begin as usize]) = (begin, end);
                }
            }
        }
    }
    linked
}
