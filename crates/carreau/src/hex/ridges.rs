//! Ridges and tips of a boundary: where its faces bend so much that a vertex which slid off would leave the surface bare.
//!
//! ```text
//!      ╲ v ╱
//!       ╲│╱   → held      v slides along the ridge only
//!        │
//! ```
//!
//! The normals of the faces around a vertex scatter about their mean in the directions in which the boundary is bent: in one on a
//! ridge or in a cleft, in two at a tip.

use super::boundary::Skin;
use super::target::Part;
use crate::numeric::eigen3::{Eigen3, outer};
use glam::{DMat3, DVec3};
use rayon::prelude::*;

/// Mean square of the normals' part in a direction from which on the boundary is bent there: two faces 33° apart. The faces
/// around a tube of 32 sides are 11° apart.
const BENT_ACROSS: f64 = 0.08;

/// The directions in which the boundary is bent at every vertex of the wall; zero for none.
pub fn bends(points: &[DVec3], skin: &Skin) -> Vec<[DVec3; 2]> {
    let mut sums = vec![(DMat3::ZERO, 0.0); points.len()];
    for q in &skin.quads {
        let p = q.map(|v| points[v as usize]);
        for k in 0..4 {
            let normal = (p[(k + 1) % 4] - p[k]).cross(p[(k + 3) % 4] - p[k]).normalize_or_zero();
            let (sum, count) = &mut sums[q[k] as usize];
            *sum += outer(normal);
            *count += 1.0;
        }
    }
    let directions = |(&(sum, count), part): (&(DMat3, f64), &Part)| {
        if *part != Part::Wall || count == 0.0 {
            return [DVec3::ZERO; 2];
        }
        let scatter = Eigen3::new(sum * (1.0 / count));
        [1, 0].map(|k| if scatter.values[k] > BENT_ACROSS { scatter.vectors[k] } else { DVec3::ZERO })
    };
    sums.par_iter().zip(&skin.parts).map(directions).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::test_models::bricks;

    /// Of a block, faces are bent nowhere, edges across, corners in two directions.
    #[test]
    fn edges_are_ridges_and_corners_are_tips() {
        let (points, hexes) = bricks([3; 3]);
        let bends = bends(&points, &Skin::new(&hexes, &vec![0; points.len()], &[]));
        for (p, bends) in points.iter().zip(bends) {
            let outer = p.to_array().iter().filter(|x| **x == 0.0 || **x == 3.0).count();
            let bent = bends.iter().filter(|d| **d != DVec3::ZERO).count();
            assert_eq!(bent, outer.saturating_sub(1), "{p}");
            if outer == 2 {
                let along = DVec3::from(p.to_array().map(|x| if x == 0.0 || x == 3.0 { 0.0 } else { 1.0 }));
                assert!(bends[0].dot(along).abs() < 1e-9, "{p} {}", bends[0]);
            }
        }
    }
}
