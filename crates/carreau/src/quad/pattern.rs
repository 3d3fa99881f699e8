//! Quads in a disc whose opposite sides do not agree: a grid, blocks around one irregular vertex, or two such parts.
//!
//! A disc with c corners takes c blocks that meet in one vertex (spokes); the quads along the spokes follow from those along
//! the sides. Where they do not come out whole and positive, a path of new edges divides the disc into two that do: four
//! sides that differ become three and five, with one vertex of three quads and one of five. All that is asked for is an even
//! number of edges around.
//!
//! ```text
//!    three sides      four that differ
//!        ╱╲             ┌──────┬──┐
//!       ╱  ╲            │ five │  │
//!      ╱─╮╭─╲           │    ╭─┴──┤
//!     ╱  ││  ╲          │    │three
//!    ╱───┴┴───╲         └────┴────┘
//! ```

use crate::error::Result;
use crate::mesh::NONE;
use crate::numeric::sparse::Matrix;
use glam::DVec2;

/// Sides of parts that take spokes.
const MOST_SPOKES: usize = 6;
/// Places along a side that are tried for a cut; where two cuts are needed, for each.
const PLACES: usize = 24;
const FEW: usize = 3;
/// What an irregular vertex costs, what a number of quads off the wanted one does, and one near the outline.
const IRREGULAR: f64 = 8.0;
const OFF: f64 = 4.0;
const NEAR: f64 = 1.0;

/// A side: its number of edges, and whether it is a cut, on which an irregular vertex may be.
#[derive(Debug, Clone, Copy)]
struct Length {
    edges: usize,
    is_cut: bool,
}

/// How a disc is filled.
#[derive(Debug, Clone)]
enum Plan {
    Grid,
    /// The edges along every spoke.
    Spokes(Vec<usize>),
    /// A path between two sides: side and place of its ends, its edges; what the two parts take.
    Cut {
        ends: [(usize, usize); 2],
        edges: usize,
        parts: Box<[Plan; 2]>,
    },
    /// A ring of quads along an outline with one corner or none, and a grid of this length inside.
    Ring {
        has_corner: bool,
        length: usize,
    },
}

/// Quads over vertices of which the first are the outline, counter-clockwise from the first corner.
#[derive(Debug, Clone, Default)]
pub struct Pattern {
    pub vertices: usize,
    pub outline: usize,
    pub quads: Vec<[u32; 4]>,
}

/// The best pattern for a disc with so many edges along its sides, and about so many quads. A disc without a corner has
/// one side, which closes. `None` where the sides are odd together or too short.
pub fn pattern(sides: &[usize], corners: usize, quads: f64) -> Option<Pattern> {
    let outline: usize = sides.iter().sum();
    if !outline.is_multiple_of(2) || sides.contains(&0) || sides.len() != corners.max(1) {
        return None;
    }
    let lengths: Vec<Length> = sides.iter().map(|&edges| Length { edges, is_cut: false }).collect();
    let plan = match corners {
        0 | 1 if outline < 8 + 2 * corners => None,
        0 | 1 => Some(Plan::Ring { has_corner: corners == 1, length: (outline - 2 * corners) / 4 }),
        _ => best(&lengths, quads, &[PLACES]).or_else(|| best(&lengths, quads, &[FEW; 2])).map(|found| found.plan),
    }?;
    let mut pattern = Pattern { vertices: outline, outline, quads: Vec::new() };
    let mut first = 0;
    let lists = sides.iter().map(|&edges| {
        let list = (first..=first + edges).map(|v| (v % outline) as u32).collect();
        first += edges;
        list
    });
    let lists: Vec<Vec<u32>> = lists.collect();
    pattern.build(lists, &plan);
    Some(pattern)
}

struct Found {
    cost: f64,
    quads: f64,
    plan: Plan,
}

/// The cheapest way. `cuts`: for every cut that may be made the number of places to try along a side.
fn best(sides: &[Length], quads: f64, cuts: &[usize]) -> Option<Found> {
    if let Some(found) = whole(sides) {
        return Some(found);
    }
    let (&places, later) = cuts.split_first()?;
    let at = |edges: usize| (1..edges).step_by(edges.div_ceil(places).max(1));
    let off = |found: &Found| found.cost + OFF * (found.quads / quads.max(1.0)).ln().abs();
    let mut least: Option<(f64, Found)> = None;
    for (i, j) in (0..sides.len()).flat_map(|i| (i + 1..sides.len()).map(move |j| (i, j))) {
        for (p, q) in at(sides[i].edges).flat_map(|p| at(sides[j].edges).map(move |q| (p, q))) {
            // Both parts are even.
            let odd = (sides[i].edges - p + q + sides[i + 1..j].iter().map(|s| s.edges).sum::<usize>()) % 2;
            let longest = sides[i].edges + sides[j].edges;
            for edges in (2 - odd..=longest).step_by(2 * longest.div_ceil(2 * places)) {
                let Some(found) = (Cut { ends: [(i, p), (j, q)], edges }).fill(sides, quads, later) else { continue };
                let cost = off(&found);
                if least.as_ref().is_none_or(|l| cost < l.0) {
                    least = Some((cost, found));
                }
            }
        }
    }
    least.map(|l| l.1)
}

struct Cut {
    ends: [(usize, usize); 2],
    edges: usize,
}

impl Cut {
    fn fill(&self, sides: &[Length], quads: f64, later: &[usize]) -> Option<Found> {
        let parts = self.parts(sides);
        if parts.iter().any(|part| part.len() > MOST_SPOKES) {
            return None;
        }
        let [first, second] = [best(&parts[0], 0.5 * quads, later)?, best(&parts[1], 0.5 * quads, later)?];
        Some(Found {
            cost: first.cost + second.cost,
            quads: first.quads + second.quads,
            plan: Plan::Cut { ends: self.ends, edges: self.edges, parts: Box::new([first.plan, second.plan]) },
        })
    }

    fn parts(&self, sides: &[Length]) -> [Vec<Length>; 2] {
        let [(i, p), (j, q)] = self.ends;
        let part = |side: usize, edges: usize| Length { edges, ..sides[side] };
        let cut = Length { edges: self.edges, is_cut: true };
        let mut first = vec![part(i, sides[i].edges - p)];
        first.extend(&sides[i + 1..j]);
        first.extend([part(j, q), cut]);
        let mut second = vec![part(j, sides[j].edges - q)];
        second.extend(sides[j + 1..].iter().chain(&sides[..i]));
        second.extend([part(i, p), cut]);
        [first, second]
    }
}

/// A grid or spokes.
fn whole(sides: &[Length]) -> Option<Found> {
    if let [a, b, c, d] = sides {
        let fits = a.edges == c.edges && b.edges == d.edges;
        return fits.then(|| Found { cost: 0.0, quads: (a.edges * b.edges) as f64, plan: Plan::Grid });
    }
    let spokes = spokes(sides)?;
    let near: f64 = spokes.iter().map(|&x| 1.0 / (1.0 + x as f64)).sum();
    let quads = (0..spokes.len()).map(|i| (spokes[i] * spokes[(i + 1) % spokes.len()]) as f64).sum();
    Some(Found { cost: IRREGULAR + NEAR * near, quads, plan: Plan::Spokes(spokes) })
}

/// The edges along every spoke: side i has as many as the spokes before and after it together. One of them may have none,
/// from a side that is a cut: the irregular vertex is on it, then.
fn spokes(sides: &[Length]) -> Option<Vec<usize>> {
    let c = sides.len();
    if !(3..=MOST_SPOKES).contains(&c) || c == 4 {
        return None;
    }
    let mut all = vec![None; c];
    for start in 0..c {
        if all[start].is_some() {
            continue;
        }
        // By steps of two around, with nothing at the start: what comes back is twice the start.
        let (mut at, mut sum) = (start, 0i64);
        loop {
            sum = sides[(at + 1) % c].edges as i64 - sum;
            at = (at + 2) % c;
            if at == start {
                break;
            }
        }
        if sum % 2 != 0 {
            return None;
        }
        let mut x = sum / 2;
        loop {
            all[at] = Some(x);
            x = sides[(at + 1) % c].edges as i64 - x;
            at = (at + 2) % c;
            if at == start {
                break;
            }
        }
    }
    let all: Vec<i64> = all.into_iter().collect::<Option<_>>()?;
    let fits = all.iter().zip(sides).all(|(&x, side)| x > 0 || (x == 0 && side.is_cut));
    let none = all.iter().filter(|&&x| x == 0).count();
    (fits && none <= 1).then(|| all.into_iter().map(|x| x as usize).collect())
}

impl Pattern {
    fn vertex(&mut self) -> u32 {
        self.vertices += 1;
        self.vertices as u32 - 1
    }

    /// Quads inside of sides, each a list of vertices from corner to corner.
    fn build(&mut self, sides: Vec<Vec<u32>>, plan: &Plan) {
        match plan {
            Plan::Grid => {
                if let Ok(sides) = <[Vec<u32>; 4]>::try_from(sides) {
                    self.grid(&sides);
                }
            }
            Plan::Spokes(spokes) => self.spokes(&sides, spokes),
            Plan::Cut { ends, edges, parts } => {
                let [(i, p), (j, q)] = *ends;
                let mut path = vec![sides[i][p]];
                path.extend((1..*edges).map(|_| self.vertex()));
                path.push(sides[j][q]);
                let back: Vec<u32> = path.iter().rev().copied().collect();
                let mut first = vec![sides[i][p..].to_vec()];
                first.extend(sides[i + 1..j].iter().cloned());
                first.extend([sides[j][..=q].to_vec(), back]);
                let mut second = vec![sides[j][q..].to_vec()];
                second.extend(sides[j + 1..].iter().chain(&sides[..i]).cloned());
                second.extend([sides[i][..=p].to_vec(), path]);
                self.build(first, &parts[0]);
                self.build(second, &parts[1]);
            }
            Plan::Ring { has_corner, length } => self.ring(&sides[0], usize::from(*has_corner), *length),
        }
    }

    /// Rows of quads between four sides.
    fn grid(&mut self, sides: &[Vec<u32>; 4]) {
        let (m, n) = (sides[0].len() - 1, sides[1].len() - 1);
        let mut rows: Vec<Vec<u32>> = vec![sides[0].clone()];
        for j in 1..n {
            let mut row = vec![sides[3][n - j]];
            row.extend((1..m).map(|_| self.vertex()));
            row.push(sides[1][j]);
            rows.push(row);
        }
        rows.push(sides[2].iter().rev().copied().collect());
        for pair in rows.windows(2) {
            for i in 0..m {
                self.quads.push([pair[0][i], pair[0][i + 1], pair[1][i + 1], pair[1][i]]);
            }
        }
    }

    /// A block in every corner.
    fn spokes(&mut self, sides: &[Vec<u32>], lengths: &[usize]) {
        let c = sides.len();
        let before = |i: usize| (i + c - 1) % c;
        let split = |i: usize| lengths[before(i)];
        let on_side = lengths.iter().position(|&x| x == 0);
        let centre = match on_side {
            Some(i) => sides[i][split(i)],
            None => self.vertex(),
        };
        let mut spokes = Vec::new();
        for i in 0..c {
            let spoke = match on_side {
                Some(z) if i == z => vec![centre],
                Some(z) if (i + 1) % c == z => sides[z][..=split(z)].to_vec(),
                Some(z) if i == (z + 1) % c => sides[z][split(z)..].iter().rev().copied().collect(),
                _ => {
                    let mut spoke = vec![sides[i][split(i)]];
                    spoke.extend((1..lengths[i]).map(|_| self.vertex()));
                    spoke.push(centre);
                    spoke
                }
            };
            spokes.push(spoke);
        }
        for i in 0..c {
            let j = (i + 1) % c;
            if lengths[i] == 0 || lengths[j] == 0 {
                continue;
            }
            let [along, up] = [sides[i][split(i)..].to_vec(), sides[j][..=split(j)].to_vec()];
            self.grid(&[along, up, spokes[j].clone(), spokes[i].iter().rev().copied().collect()]);
        }
    }

    /// Quads along an outline that closes, with one corner where it begins or none, and a grid inside.
    fn ring(&mut self, side: &[u32], corner: usize, length: usize) {
        let n = side.len() - 1;
        let at = |k: usize| side[k % n];
        // What is inside of a corner has two edges less.
        let count = n - 2 * corner;
        let inner: Vec<u32> = (0..count).map(|_| self.vertex()).collect();
        if corner == 1 {
            self.quads.push([at(n - 1), at(0), at(1), inner[0]]);
        }
        for k in 0..count {
            self.quads.push([at(k + corner), at(k + corner + 1), inner[(k + 1) % count], inner[k]]);
        }
        let rest = count / 2 - length;
        let places = [0, length, length + rest, 2 * length + rest, count];
        let lists = [0, 1, 2, 3].map(|s| (places[s]..=places[s + 1]).map(|k| inner[k % count]).collect());
        self.grid(&lists);
    }

    /// Places of all vertices: those of the outline as they are given, the others in the mean of their neighbours (Tutte).
    pub fn spread(&self, outline: &[DVec2]) -> Result<Vec<DVec2>> {
        let inner = self.vertices - self.outline;
        let mut at = outline.to_vec();
        at.resize(self.vertices, DVec2::ZERO);
        if inner == 0 {
            return Ok(at);
        }
        let number = |v: u32| if (v as usize) < self.outline { NONE } else { v - self.outline as u32 };
        let mut matrix = Matrix::new(inner);
        let mut rhs = [vec![0.0; inner], vec![0.0; inner]];
        for q in &self.quads {
            for k in 0..4 {
                // Edges inside have a quad on both sides: each adds half.
                for (v, w) in [(q[k], q[(k + 1) % 4]), (q[(k + 1) % 4], q[k])] {
                    let (i, j) = (number(v), number(w));
                    if i == NONE {
                        continue;
                    }
                    matrix.add(i, i, 0.5);
                    if j == NONE {
                        rhs[0][i as usize] += 0.5 * outline[w as usize].x;
                        rhs[1][i as usize] += 0.5 * outline[w as usize].y;
                    } else if j < i {
                        matrix.add(i, j, -0.5);
                    }
                }
            }
        }
        let factor = matrix.factor(&mut None)?;
        let (x, y) = (factor.solve(&rhs[0])?, factor.solve(&rhs[1])?);
        at[self.outline..].iter_mut().enumerate().for_each(|(i, p)| *p = DVec2::new(x[i], y[i]));
        Ok(at)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rustc_hash::FxHashMap;

    /// Number of irregular vertices inside, after all that a pattern promises.
    fn check(sides: &[usize], corners: usize, pattern: &Pattern) -> usize {
        let outline: usize = sides.iter().sum();
        assert_eq!(pattern.outline, outline);
        let mut edges: FxHashMap<[u32; 2], usize> = FxHashMap::default();
        let mut valence = vec![0; pattern.vertices];
        for q in &pattern.quads {
            for k in 0..4 {
                let [a, b] = [q[k], q[(k + 1) % 4]];
                assert_ne!(a, b);
                assert!(edges.insert([a, b], 1).is_none(), "{sides:?}: an edge has two quads on one side");
                valence[a as usize] += 1;
            }
        }
        assert!(valence.iter().all(|&v| v > 0));
        // The outline is the border, and there is no other.
        let border: Vec<&[u32; 2]> = edges.keys().filter(|[a, b]| !edges.contains_key(&[*b, *a])).collect();
        assert_eq!(border.len(), outline);
        assert!(border.iter().all(|[a, b]| (a + 1) % outline as u32 == *b));
        // A disc: V − E + F = 1.
        let edge_count = (edges.len() + outline) / 2;
        assert_eq!(pattern.vertices + pattern.quads.len(), edge_count + 1);
        // One quad in every corner, two everywhere else on the outline.
        let mut at = 0;
        let mut expected = vec![2; outline];
        for &n in &sides[..corners.min(sides.len())] {
            expected[at] = 1;
            at += n;
        }
        assert_eq!(&valence[..outline], &expected, "{sides:?}");
        valence[outline..].iter().filter(|&&v| v != 4).count()
    }

    fn irregular(sides: &[usize]) -> Option<usize> {
        let quads = 0.8 * (sides.iter().sum::<usize>() as f64 / sides.len() as f64).powi(2);
        pattern(sides, sides.len(), quads).map(|pattern| check(sides, sides.len(), &pattern))
    }

    #[test]
    fn sides_that_agree_take_grids_and_spokes() {
        assert_eq!(irregular(&[5, 3, 5, 3]), Some(0));
        assert_eq!(irregular(&[4, 6, 8]), Some(1));
        assert_eq!(irregular(&[6, 6, 6, 6, 6]), Some(1));
        assert_eq!(irregular(&[1, 1, 1, 1]), Some(0));
    }

    #[test]
    fn four_sides_that_differ_take_two_irregular_vertices() {
        for sides in [[8, 8, 6, 8], [10, 9, 9, 8], [12, 7, 8, 7], [9, 14, 10, 13], [8, 6, 8, 8], [30, 20, 28, 20]] {
            assert_eq!(irregular(&sides), Some(2), "{sides:?}");
        }
    }

    #[test]
    fn whatever_comes_out_is_a_disc_of_quads() {
        let mut found = [0, 0];
        for c in 2..=6 {
            for seed in 0..60usize {
                let sides: Vec<usize> = (0..c).map(|k| 1 + (seed * 7 + k * 5 + seed * k * k * 3) % 13).collect();
                let even = sides.iter().sum::<usize>() % 2 == 0;
                match irregular(&sides) {
                    Some(count) => {
                        assert!(even && count <= 6, "{sides:?} {count}");
                        found[0] += 1;
                    }
                    None => found[1] += usize::from(even),
                }
            }
        }
        // What is missing is short or far from anything with right angles.
        assert!(found[0] > found[1], "{found:?}");
    }

    #[test]
    fn without_a_corner_there_are_four_irregular_vertices() {
        for (n, corners) in [(12, 0), (30, 0), (16, 1)] {
            let pattern = pattern(&[n], corners, 30.0).unwrap();
            assert_eq!(check(&[n], corners, &pattern), 4 - corners, "{n}");
        }
        assert!(pattern(&[13], 0, 30.0).is_none() && pattern(&[4], 0, 1.0).is_none());
    }

    #[test]
    fn vertices_inside_keep_quads_convex_over_a_square() {
        let pattern = pattern(&[10, 8, 8, 8], 4, 72.0).unwrap();
        let on = |side: usize, x: f64| {
            [DVec2::new(x, 0.0), DVec2::new(1.0, x), DVec2::new(1.0 - x, 1.0), DVec2::new(0.0, 1.0 - x)][side]
        };
        let outline: Vec<DVec2> = [10, 8, 8, 8]
            .into_iter()
            .enumerate()
            .flat_map(|(k, n)| (0..n).map(move |x| on(k, x as f64 / n as f64)))
            .collect();
        let at = pattern.spread(&outline).unwrap();
        for q in &pattern.quads {
            let p = q.map(|v| at[v as usize]);
            assert!((0..4).all(|k| (p[(k + 1) % 4] - p[k]).perp_dot(p[(k + 3) % 4] - p[k]) > 0.0));
        }
    }
}
