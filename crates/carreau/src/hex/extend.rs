//! Lengthens ends by straight pieces, as flow solvers need them, so that the flow can develop before it enters.
//!
//! ```text
//!   ──┬──┬─╮         ──┬──┬─┬──┬──┬──┐
//!     │  │ │    →      │  │ │  │  │  │     every face of an end is drawn along its normal, and the last layer is flat
//!   ──┴──┴─╯         ──┴──┴─┴──┴──┴──┘
//! ```

use super::disc::{OPPOSITE, disc};
use super::{HexResult, MOST_HEXES};
use crate::error::{Error, Result};
use crate::mesh::boundary_faces;
use rustc_hash::FxHashMap;

/// Cells of an extension are at least and at most this long, in radii of its end: as long as those before it in between.
const LENGTHS: [f64; 2] = [0.1, 1.0];

/// Lengthens every end by some radii.
pub fn extend(result: &mut HexResult, radii: f64) -> Result<()> {
    let ends = result.mesh.tags.iter().copied().max().unwrap_or(1);
    if ends < 2 {
        result.warnings.push("the shape has no end that could be lengthened".into());
        return Ok(());
    }
    let mut growth = Growth::of(result);
    for tag in 2..=ends {
        growth.end(tag, radii)?;
    }
    growth.finish();
    Ok(())
}

struct Growth<'a> {
    result: &'a mut HexResult,
    /// The tags of boundary faces, and the faces that they continue; faces by their vertices, ascending.
    known: FxHashMap<[u32; 4], (i32, [u32; 4])>,
    /// The wall's face at every side of a face of an end, by the vertices of the side, ascending.
    wall_at: FxHashMap<[u32; 2], [u32; 4]>,
}

impl<'a> Growth<'a> {
    fn of(result: &'a mut HexResult) -> Self {
        let mesh = &result.mesh;
        let (mut known, mut wall_at) = (FxHashMap::default(), FxHashMap::default());
        for (q, &tag) in mesh.quads.iter().zip(&mesh.tags) {
            known.insert(sorted(*q), (tag, sorted(*q)));
            for k in (0..4).filter(|_| tag == 1) {
                wall_at.insert(pair(q[k], q[(k + 1) % 4]), sorted(*q));
            }
        }
        Growth { result, known, wall_at }
    }

    fn end(&mut self, tag: i32, radii: f64) -> Result<()> {
        let mesh = &self.result.mesh;
        let of_end: Vec<usize> = (0..mesh.quads.len()).filter(|&f| mesh.tags[f] == tag).collect();
        let Some((centre, normal, radius)) = disc(mesh, &of_end) else { return Ok(()) };
        let length = radii * radius;
        let step = self.step(&of_end).clamp(LENGTHS[0] * radius, LENGTHS[1] * radius);
        let layers = (length / step).ceil().max(1.0);
        if mesh.hexes.len() as f64 + layers * of_end.len() as f64 > MOST_HEXES {
            return Err(Error::Options(format!("ends lengthened by {radii} radii would take too many hexes")));
        }
        let quads: Vec<[u32; 4]> = of_end.iter().map(|&f| mesh.quads[f]).collect();
        let mut vertices: Vec<u32> = quads.as_flattened().to_vec();
        vertices.sort_unstable();
        vertices.dedup();
        let place = |v: u32| vertices.binary_search(&v).unwrap_or(0);
        let mut below = vertices.clone();
        let layers = layers as u32;
        let Growth { result, known, wall_at } = self;
        for layer in 1..=layers {
            let first = result.mesh.points.len() as u32;
            let share = f64::from(layer) / f64::from(layers);
            for &v in &vertices {
                let p = result.mesh.points[v as usize];
                let to_go = length - (p - centre).dot(normal);
                result.mesh.points.push(p + normal * (share * to_go));
                result.bases.push(result.bases[v as usize]);
            }
            for q in &quads {
                let [low, high] = [q.map(|v| below[place(v)]), q.map(|v| first + place(v) as u32)];
                result.mesh.hexes.push([low[0], low[1], low[2], low[3], high[0], high[1], high[2], high[3]]);
                known.remove(&sorted(low));
                if layer == layers {
                    known.insert(sorted(high), (tag, sorted(high)));
                }
                for k in 0..4 {
                    let (a, b) = (k, (k + 1) % 4);
                    if let Some(&wall) = wall_at.get(&pair(q[a], q[b])) {
                        known.insert(sorted([low[a], low[b], high[b], high[a]]), (1, wall));
                    }
                }
            }
            below = (first..).take(vertices.len()).collect();
        }
        Ok(())
    }

    /// The mean length of the edges that lead to the vertices of an end from inside.
    fn step(&self, of_end: &[usize]) -> f64 {
        let mesh = &self.result.mesh;
        let wanted: FxHashMap<[u32; 4], ()> = of_end.iter().map(|&f| (sorted(mesh.quads[f]), ())).collect();
        let (mut sum, mut count) = (0.0, 0.0);
        for h in &mesh.hexes {
            for (face, opposite) in crate::mesh::HEX_FACES.iter().zip(OPPOSITE) {
                if wanted.contains_key(&sorted(face.map(|c| h[c]))) {
                    for (&a, b) in face.iter().zip(opposite) {
                        sum += mesh.points[h[a] as usize].distance(mesh.points[h[b] as usize]);
                        count += 1.0;
                    }
                }
            }
        }
        sum / f64::max(count, 1.0)
    }

    /// The boundary of the longer mesh.
    fn finish(self) {
        let Growth { result, known, .. } = self;
        let quads: Vec<[u32; 4]> = boundary_faces(&result.mesh.hexes).into_iter().map(|f| f.0).collect();
        let found: Vec<(i32, [u32; 4])> =
            quads.iter().map(|q| sorted(*q)).map(|key| known.get(&key).copied().unwrap_or((1, key))).collect();
        let place: FxHashMap<[u32; 4], u32> = quads.iter().map(|q| sorted(*q)).zip(0..).collect();
        result.mesh.tags = found.iter().map(|f| f.0).collect();
        result.origins = (0..).zip(&found).map(|(own, f)| place.get(&f.1).copied().unwrap_or(own)).collect();
        result.mesh.quads = quads;
    }
}

fn sorted(mut q: [u32; 4]) -> [u32; 4] {
    q.sort_unstable();
    q
}

fn pair(a: u32, b: u32) -> [u32; 2] {
    [a.min(b), a.max(b)]
}
