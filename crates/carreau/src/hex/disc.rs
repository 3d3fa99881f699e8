//! The quads of an end.

use crate::mesh::HexMesh;
use glam::DVec3;
use std::f64::consts::PI;

/// The corners across the cell from those of each of its faces.
pub const OPPOSITE: [[usize; 4]; 6] =
    [[4, 7, 6, 5], [0, 1, 2, 3], [3, 2, 6, 7], [0, 3, 7, 4], [1, 0, 4, 5], [2, 1, 5, 6]];

/// Centre, unit normal and radius of the disc as large as some faces.
pub fn disc(mesh: &HexMesh, faces: &[usize]) -> Option<(DVec3, DVec3, f64)> {
    let (mut sum, mut centre, mut area) = (DVec3::ZERO, DVec3::ZERO, 0.0);
    for &f in faces {
        let p = mesh.quads[f].map(|v| mesh.points[v as usize]);
        let vector = 0.5 * (p[2] - p[0]).cross(p[3] - p[1]);
        sum += vector;
        area += vector.length();
        centre += vector.length() * 0.25 * p.iter().sum::<DVec3>();
    }
    let normal = sum.try_normalize()?;
    (area > 0.0).then(|| (centre / area, normal, (sum.length() / PI).sqrt()))
}
