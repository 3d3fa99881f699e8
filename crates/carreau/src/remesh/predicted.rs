//! How many triangles a size map will give.

use super::support::Support;
use crate::mesh::triangle_area_vector;

/// The number of triangles that a size map asks for.
pub fn predicted(support: &Support) -> f64 {
    let sum: f64 = (0..support.mesh.triangle_slots())
        .map(|t| {
            let [a, b, c] = support.mesh.positions(t);
            let stretch = |v: u32| support.stretch.get(v as usize).map_or(0.0, |w| w.length_squared());
            let inverse =
                support.mesh.triangle(t).map(|v| (1.0 - stretch(v)).sqrt() * support.size[v as usize].powi(-2));
            triangle_area_vector(a, b, c).length() * (inverse[0] + inverse[1] + inverse[2]) / 3.0
        })
        .sum();
    sum * 4.0 / 3f64.sqrt()
}
