//! One step of Catmull–Clark subdivision (*Recursively generated B-spline surfaces on arbitrary topological meshes*, CAD 10, 1978),
//! with borders and creases that are cubic splines of their own.

use super::net::{Net, Role, previous};
use crate::mesh::NONE;
use glam::DVec3;

/// What can be mixed: points, and points as sums over control points.
pub trait Value: Clone {
    /// A weighted sum.
    fn mix(terms: &[(f64, &Self)]) -> Self;
}

impl Value for DVec3 {
    fn mix(terms: &[(f64, &Self)]) -> Self {
        terms.iter().map(|&(w, &p)| w * p).sum()
    }
}

/// Numbers of control points with their weights, ascending.
#[derive(Debug, Clone)]
pub struct Row(pub Vec<(u32, f64)>);

impl Value for Row {
    fn mix(terms: &[(f64, &Self)]) -> Self {
        let mut all: Vec<(u32, f64)> =
            terms.iter().flat_map(|(w, row)| row.0.iter().map(move |&(k, x)| (k, w * x))).collect();
        all.sort_by_key(|t| t.0);
        let sum = |same: &[(u32, f64)]| (same[0].0, same.iter().map(|t| t.1).sum::<f64>());
        Row(all.chunk_by(|a, b| a.0 == b.0).map(sum).collect())
    }
}

/// Control points after one step: one for every vertex, edge and quad.
pub struct Refined<V> {
    /// Of the vertices.
    pub vertex: Vec<V>,
    /// Of the edges.
    pub edge: Vec<V>,
    /// Of the quads.
    pub face: Vec<V>,
}

/// One step.
pub fn refine<V: Value>(net: &Net, values: &[V]) -> Refined<V> {
    let of = |v: u32| &values[v as usize];
    let mean = |q: &[u32; 4]| V::mix(&q.map(|v| (0.25, of(v))));
    let face: Vec<V> = net.quads.iter().map(mean).collect();
    let mut half = vec![NONE; net.ends.len()];
    (0u32..).zip(&net.edge).for_each(|(h, &e)| half[e as usize] = h);
    let middle = |(h, ends): (&u32, &[u32; 2])| {
        let [a, b] = ends.map(of);
        match net.opposite[*h as usize] {
            NONE => V::mix(&[(0.5, a), (0.5, b)]),
            o => V::mix(&[(0.25, a), (0.25, b), (0.25, &face[*h as usize / 4]), (0.25, &face[o as usize / 4])]),
        }
    };
    let edge = half.iter().zip(&net.ends).map(middle).collect();
    let mut vertex: Vec<V> = values.to_vec();
    for fan in &net.fans {
        let v = fan.vertex as usize;
        match net.role[v] {
            Role::Corner => {}
            Role::Border => {
                let [a, b] = rim(net, &fan.spokes);
                vertex[v] = V::mix(&[(0.75, of(fan.vertex)), (0.125, of(a)), (0.125, of(b))]);
            }
            Role::Smooth | Role::Dart => {
                let n = fan.spokes.len() as f64;
                // (Q + 2 R + (n − 3) S) / n, where R is the mean of the middles of the edges.
                let mut terms = vec![((n - 2.0) / n, of(fan.vertex))];
                for &h in &fan.spokes {
                    terms.push((1.0 / (n * n), of(net.end(h))));
                    terms.push((1.0 / (n * n), &face[h as usize / 4]));
                }
                vertex[v] = V::mix(&terms);
            }
        }
    }
    Refined { vertex, edge, face }
}

/// The vertices before and behind that of an open fan on its border.
pub fn rim(net: &Net, spokes: &[u32]) -> [u32; 2] {
    [net.end(spokes[0]), net.start(previous(spokes[spokes.len() - 1]))]
}

/// The quads after one step, in the order of [`Refined`]: vertices, edges, quads. Quad 4 q + k has corner k of quad q as its first.
pub fn refined_quads(net: &Net) -> Vec<[u32; 4]> {
    let (vertices, edges) = (net.role.len() as u32, net.ends.len() as u32);
    let of = |h: u32| {
        let q = h / 4;
        let edge = |h: u32| vertices + net.edge[h as usize];
        [net.start(h), edge(h), vertices + edges + q, edge(previous(h))]
    };
    (0..net.edge.len() as u32).map(of).collect()
}
