//! What is around every vertex, and how good it is.

use super::ceiling::{ceilings, jacobians, over, shape};
use super::work::{Place, Work};
use crate::geometry::quality::scaled_jacobian;
use crate::mesh::HalfEdges;
use glam::DVec3;

/// A scaled Jacobian: quads with a smaller one have no normal of their own to go by, because they are turned over or
/// all but.
pub const BAD_JACOBIAN: f64 = 0.02;
/// A cosine: a quad may turn by less in one move, because one that turns farther is on its way to be turned over.
const MOVE_TURN: f64 = 0.5;
/// A count: so many quads beside one will do for its normal, because very many may meet in one vertex.
const ENOUGH_BESIDE: usize = 64;
/// A factor of the shape in an exponent: how much more a worse one counts, because what cannot become better is not to
/// hide what can.
const SHAPE_STEEPNESS: f64 = 10.0;

/// The quads and neighbours of every vertex.
pub struct Around {
    pub quads: Vec<Vec<u32>>,
    /// Along edges; for vertices on curves, along their curve.
    pub neighbours: Vec<Vec<u32>>,
    /// How long edges are to be at every vertex, relative to each other; empty where they are to be even.
    pub size: Vec<f64>,
    /// What the scaled Jacobian can be at the corners of every quad.
    ceilings: Vec<[f64; 4]>,
}

impl Around {
    pub fn new(work: &Work) -> Self {
        let n = work.points.len();
        let mut around = Around {
            quads: vec![Vec::new(); n],
            neighbours: vec![Vec::new(); n],
            size: Vec::new(),
            ceilings: ceilings(work),
        };
        for (q, face) in (0u32..).zip(work.faces.iter()) {
            face.iter().for_each(|&v| around.quads[v as usize].push(q));
        }
        for edge in HalfEdges::new(&work.faces, n).groups() {
            let [a, b] = edge.ends;
            let is_inner = |v: u32| matches!(work.place[v as usize], Place::Region(_));
            for (v, w) in [(a, b), (b, a)] {
                if is_inner(v) {
                    around.neighbours[v as usize].push(w);
                }
            }
        }
        for ([a, b], _) in &work.features {
            for (v, w) in [(*a, *b), (*b, *a)] {
                around.neighbours[v as usize].push(w);
            }
        }
        around
    }

    /// Where a vertex is best among its neighbours: in the middle, or nearer to those where edges are to be shorter.
    pub fn mean(&self, work: &Work, v: u32) -> DVec3 {
        let neighbours = &self.neighbours[v as usize];
        let weight = |w: u32| match self.size.is_empty() {
            true => 1.0,
            false => 1.0 / (self.size[v as usize] + self.size[w as usize]),
        };
        let (mut sum, mut weights) = (DVec3::ZERO, 0.0);
        for &w in neighbours {
            sum += weight(w) * work.points[w as usize];
            weights += weight(w);
        }
        sum / weights
    }

    /// Says anew what can be at corners, where vertices have gone to tips.
    pub fn set_ceilings(&mut self, work: &Work) {
        self.ceilings = ceilings(work);
    }

    /// How near a vertex would be to its neighbours.
    pub fn shortest_edge(&self, work: &Work, v: u32, at: DVec3) -> f64 {
        let neighbours = self.neighbours[v as usize].iter();
        neighbours.map(|&w| work.points[w as usize].distance(at)).fold(f64::INFINITY, f64::min)
    }

    /// Mean length of the edges at a vertex.
    pub fn mean_edge(&self, work: &Work, v: u32) -> f64 {
        let (from, neighbours) = (work.points[v as usize], &self.neighbours[v as usize]);
        let sum: f64 = neighbours.iter().map(|&w| work.points[w as usize].distance(from)).sum();
        sum / neighbours.len().max(1) as f64
    }

    /// Unit normal at a vertex; zero where its quads look everywhere.
    pub fn up(&self, work: &Work, v: u32) -> DVec3 {
        let of = |&q: &u32| normal(corners(work, q, v, work.points[v as usize]));
        self.quads[v as usize].iter().map(of).sum::<DVec3>().normalize_or_zero()
    }
}

/// The corners of a quad, with one vertex elsewhere.
pub fn corners(work: &Work, q: u32, v: u32, at: DVec3) -> [DVec3; 4] {
    let face = work.faces.face(q as usize);
    [0, 1, 2, 3].map(|k| if face[k] == v { at } else { work.points[face[k] as usize] })
}

/// Unit normal of a quad, across its diagonals.
pub fn normal(q: [DVec3; 4]) -> DVec3 {
    (q[2] - q[0]).cross(q[3] - q[1]).normalize_or_zero()
}

/// The quads around a vertex, and how they look before it moves: what its moves are judged by.
pub struct Ring<'a> {
    work: &'a Work,
    around: &'a Around,
    vertex: u32,
    quads: Vec<Before>,
    /// The worst of the shapes where the vertex is.
    pub now: f64,
}

/// A quad before its vertex moves.
struct Before {
    quad: u32,
    /// Where it looks; one that is turned over, where those around it do.
    up: DVec3,
    is_good: bool,
}

impl<'a> Ring<'a> {
    pub fn new(work: &'a Work, around: &'a Around, vertex: u32) -> Self {
        let at = work.points[vertex as usize];
        let mut now = f64::INFINITY;
        let before = |&quad: &u32| {
            let (own, ceilings) = (corners(work, quad, vertex, at), &around.ceilings[quad as usize]);
            let mut up = normal(own);
            let mut found = jacobians(own, up);
            let is_good = found.into_iter().all(|j| j > BAD_JACOBIAN);
            if !is_good {
                up = up_beside(work, around, quad).normalize_or(up);
                found = jacobians(own, up);
            }
            now = over(found, ceilings).into_iter().fold(now, f64::min);
            Before { quad, up, is_good }
        };
        let quads = around.quads[vertex as usize].iter().map(before).collect();
        Ring { work, around, vertex, quads, now }
    }

    /// The shapes where the vertex would be elsewhere: the scaled Jacobian at every corner over what it can be there; −1
    /// where a quad turned over.
    fn shapes(&self, at: DVec3) -> impl Iterator<Item = [f64; 4]> {
        self.quads.iter().map(move |before| {
            let after = corners(self.work, before.quad, self.vertex, at);
            let ceilings = &self.around.ceilings[before.quad as usize];
            if !before.is_good {
                return shape(after, before.up, ceilings);
            }
            let up = normal(after);
            if up.dot(before.up) < MOVE_TURN { [-1.0; 4] } else { shape(after, up, ceilings) }
        })
    }

    /// Where the quads look together.
    pub fn up(&self) -> DVec3 {
        self.quads.iter().map(|before| before.up).sum()
    }

    /// Whether none of the shapes is worse than that.
    pub fn holds(&self, at: DVec3, least: f64) -> bool {
        self.shapes(at).flatten().all(|shape| shape >= least)
    }

    /// A sum that the worst of the shapes make most of: what cannot become better does not hide what can.
    pub fn distress(&self, at: DVec3) -> f64 {
        self.shapes(at).flatten().map(|shape| (-SHAPE_STEEPNESS * shape).exp()).sum()
    }
}

/// The worst shape around a vertex where it is.
pub fn worst(work: &Work, around: &Around, vertex: u32) -> f64 {
    Ring::new(work, around, vertex).now
}

/// The normals of the quads beside one, those that have one.
fn up_beside(work: &Work, around: &Around, q: u32) -> DVec3 {
    beside(work, around, q)
        .take(ENOUGH_BESIDE)
        .map(|other| work.faces.face(other as usize))
        .map(|f| [0, 1, 2, 3].map(|k| work.points[f[k] as usize]))
        .filter(|&p| scaled_jacobian(p) > BAD_JACOBIAN)
        .map(normal)
        .sum()
}

/// The quads that share a vertex with a quad, some of them more than once.
pub fn beside<'a>(work: &'a Work, around: &'a Around, q: u32) -> impl Iterator<Item = u32> + 'a {
    work.faces.face(q as usize).iter().flat_map(|&v| around.quads[v as usize].iter().copied())
}

/// When vertices last moved: what found no better place will find none as long as nothing around has moved.
pub struct Moves(Vec<usize>);

impl Moves {
    pub fn new(work: &Work) -> Self {
        Moves(vec![0; work.points.len()])
    }

    pub fn note(&mut self, round: usize, v: u32, has_moved: bool) {
        if has_moved {
            self.0[v as usize] = round + 1;
        }
    }

    /// Whether any vertex of the quads around one has moved in so many rounds; all count as moved before the first.
    pub fn any_since(&self, round: usize, rounds: usize, work: &Work, around: &Around, v: u32) -> bool {
        let mut near = around.quads[v as usize].iter().flat_map(|&q| work.faces.face(q as usize));
        round < rounds || near.any(|&w| self.0[w as usize] + rounds > round)
    }
}
