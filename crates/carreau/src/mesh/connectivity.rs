//! How faces hang together: through which edges, in which sense, around which vertices.
//!
//! Works on bare polygons, so that [`super::repair`] can ask between its steps. Faces marked in `ignore` (those that use
//! a vertex twice, which have no place in a surface) are left out of everything and form components of their own.

use super::disjoint_sets::{DisjointSets, SignedSets};
use super::half_edges::{EdgeGroup, HalfEdges};
use super::polygons::Polygons;

/// Components of faces that share edges, the irregular edges, and which faces to turn.
pub(crate) struct Connectivity {
    /// Number of undirected edges.
    pub edges: usize,
    /// Half-edges without a partner, by the corner they leave from, in order of their edges.
    pub boundary: Vec<u32>,
    /// Edges with more than two faces.
    pub nonmanifold: Vec<[u32; 2]>,
    /// Edges that their two faces run along in the same direction.
    pub inconsistent: Vec<[u32; 2]>,
    /// Component of every face; faces are linked through every edge they share, non-manifold ones included.
    pub component: Vec<u32>,
    /// Number of components.
    pub components: usize,
    /// Whether all edges of a component have exactly two faces.
    pub closed: Vec<bool>,
    /// Whether the faces of a component can be turned so that neighbours agree. Non-manifold edges ask nothing.
    pub orientable: Vec<bool>,
    /// The faces to turn: the smaller part of each set of faces linked by regular edges; of two equal parts, the one
    /// without the set's first face.
    pub turned: Vec<bool>,
}

impl Connectivity {
    /// Examines faces whose half-edges are already grouped.
    pub fn of(faces: &Polygons, half_edges: &HalfEdges, ignore: &[bool]) -> Self {
        let face_of = faces.face_of_corners();
        let start = faces.corners();
        let (mut edges, mut boundary, mut nonmanifold, mut inconsistent) = (0, Vec::new(), Vec::new(), Vec::new());
        let mut linked = DisjointSets::new(faces.len());
        let mut senses = SignedSets::new(faces.len());
        let mut contradictions = Vec::new();
        let mut open_faces = Vec::new();
        let mut sides: Vec<u32> = Vec::new();
        for edge in half_edges.groups() {
            sides.clear();
            sides.extend(edge.corners().filter(|&c| !ignore[face_of[c as usize] as usize]));
            edges += usize::from(!sides.is_empty());
            for pair in sides.windows(2) {
                linked.union(face_of[pair[0] as usize], face_of[pair[1] as usize]);
            }
            match sides[..] {
                [] => {}
                [c] => {
                    boundary.push(c);
                    open_faces.push(face_of[c as usize]);
                }
                [c, d] => {
                    let same_direction = start[c as usize] == start[d as usize];
                    if same_direction {
                        inconsistent.push(edge.ends);
                    }
                    let face = face_of[c as usize];
                    if !senses.relate(face, face_of[d as usize], same_direction) {
                        contradictions.push(face);
                    }
                }
                [c, ..] => {
                    nonmanifold.push(edge.ends);
                    open_faces.push(face_of[c as usize]);
                }
            }
        }
        let (component, components) = linked.labels();
        let unless = |faces: &[u32]| {
            let mut good = vec![true; components];
            faces.iter().for_each(|&f| good[component[f as usize] as usize] = false);
            good
        };
        let (closed, orientable) = (unless(&open_faces), unless(&contradictions));
        let turned = senses.smaller_parts();
        Connectivity { edges, boundary, nonmanifold, inconsistent, component, components, closed, orientable, turned }
    }
}

/// The umbrella of every corner: the corners of one vertex whose faces are linked by edges at that vertex.
///
/// ```text
///   ╲ │ ╱        ╲     ╱
///    ╲│╱          ╲   ╱      left: one umbrella
/// ────•────    ────╲ ╱────   right: two, a bow-tie
///    ╱│╲            •
///   ╱ │ ╲       ───╱ ╲───
/// ```
///
/// An umbrella is named by its smallest corner. Edges that do not link cut the surface, with those of more than two sides along
/// what is not manifold. Corners of ignored faces are left alone.
pub(crate) fn umbrellas(
    faces: &Polygons,
    half_edges: &HalfEdges,
    ignore: &[bool],
    links: impl Fn(&EdgeGroup, usize) -> bool,
) -> Vec<u32> {
    let (face_of, next) = (faces.face_of_corners(), faces.next_corners());
    let start = faces.corners();
    let mut sets = DisjointSets::new(start.len());
    let mut sides: Vec<u32> = Vec::new();
    for edge in half_edges.groups() {
        sides.clear();
        sides.extend(edge.corners().filter(|&c| !ignore[face_of[c as usize] as usize]));
        if !links(&edge, sides.len()) {
            continue;
        }
        // The corners of a side at the edge's smaller and larger vertex.
        let ends = |c: u32| {
            let n = next[c as usize];
            if start[c as usize] == edge.ends[0] { [c, n] } else { [n, c] }
        };
        for pair in sides.windows(2) {
            let (a, b) = (ends(pair[0]), ends(pair[1]));
            sets.union(a[0], b[0]);
            sets.union(a[1], b[1]);
        }
    }
    sets.leaders()
}

/// A vertex of its own for every umbrella: the vertex of every corner, and for each new vertex the one it is a copy of. The
/// first umbrella of a vertex keeps it, the others follow in the order of vertices, then faces: an order that does not depend on
/// where a face begins or which way it turns. Corners of ignored faces keep theirs.
pub(crate) fn vertices_of_umbrellas(
    faces: &Polygons,
    umbrella: &[u32],
    ignore: &[bool],
    vertices: usize,
) -> (Vec<u32>, Vec<u32>) {
    let (face_of, old) = (faces.face_of_corners(), faces.corners());
    let named = |c: &u32| umbrella[*c as usize] == *c && !ignore[face_of[*c as usize] as usize];
    let mut firsts: Vec<u32> = (0..old.len() as u32).filter(named).collect();
    firsts.sort_by_key(|&c| (old[c as usize], c));
    let (mut new, mut copied) = (old.to_vec(), Vec::new());
    for of_vertex in firsts.chunk_by(|&a, &b| old[a as usize] == old[b as usize]) {
        for &c in &of_vertex[1..] {
            new[c as usize] = (vertices + copied.len()) as u32;
            copied.push(old[c as usize]);
        }
    }
    for c in 0..old.len() {
        new[c] = new[umbrella[c] as usize];
    }
    (new, copied)
}

/// The edges that one was cut into, each with its smaller end first, where corners have `new` vertices; `None`: no face has it.
/// `next`: the next corner of every one.
pub(crate) fn copies_of_edge(
    [a, b]: [u32; 2],
    half_edges: &HalfEdges,
    new: &[u32],
    next: &[u32],
) -> Option<Vec<[u32; 2]>> {
    let ends = |c: u32| [new[c as usize], new[next[c as usize] as usize]];
    let in_order = |[p, q]: [u32; 2]| [p.min(q), p.max(q)];
    let mut copies: Vec<[u32; 2]> = half_edges.find(a, b)?.corners().map(ends).map(in_order).collect();
    copies.sort_unstable();
    copies.dedup();
    Some(copies)
}

/// Which faces use a vertex more than once.
pub(crate) fn faces_with_repeats(faces: &Polygons, vertices: usize) -> Vec<bool> {
    let mut seen_in = vec![u32::MAX; vertices];
    let repeats = |(face, f): (&[u32], u32)| {
        let mut found = false;
        for &v in face {
            found |= seen_in[v as usize] == f;
            seen_in[v as usize] = f;
        }
        found
    };
    faces.iter().zip(0u32..).map(repeats).collect()
}
