//! Coordinates brought into a range where products of lengths neither overflow nor vanish.
//!
//! A file may be in any unit: at 1e160 squares of lengths are infinite, at 1e-110 their cubes are zero, and a last digit that differs
//! is enough for another mesh. The methods look at that once, at their doors: they work at a size of about one, and the result goes
//! back. The factor is a power of two, which rounds nothing: the result is that of the scaled mesh, bit for bit.

use super::{Column, CurveNet, SurfaceMesh, Triangles};
use glam::DVec3;
use rayon::prelude::*;

/// The power of two that lengths are divided by.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct UnitScale(i32);

impl UnitScale {
    /// The scale of the vertices that faces use.
    pub fn of(triangles: Triangles<'_>) -> Self {
        let corners = 3 * triangles.len() as u32;
        Self::of_used(triangles.points(), corners, |c| triangles.point(c))
    }

    /// [`UnitScale::of`] for any faces.
    pub fn of_mesh(mesh: &SurfaceMesh) -> Self {
        let corners = mesh.faces().corners();
        Self::of_used(mesh.points(), corners.len() as u32, |c| mesh.points()[corners[c as usize] as usize])
    }

    /// The scale of the nodes of a net.
    pub fn of_net(net: &CurveNet) -> Self {
        Self::of_used(&net.points, net.points.len() as u32, |v| net.points[v as usize])
    }

    /// The scale of `count` corners among points.
    fn of_used(points: &[DVec3], count: u32, corner: impl Fn(u32) -> DVec3 + Sync) -> Self {
        let largest = |p: DVec3| p.abs().max_element();
        let all = points.par_iter().with_min_len(4096).map(|p| largest(*p)).reduce(|| 0.0, f64::max);
        let some = if count == 0 { 0.0 } else { largest(corner(0)) };
        // The largest is between these two: there may be no need to look which vertices are used.
        if some > 0.0 && exponent(some) == exponent(all) {
            return UnitScale(exponent(all));
        }
        let corners = (0..count).into_par_iter().with_min_len(4096);
        UnitScale(exponent(corners.map(|c| largest(corner(c))).reduce(|| 0.0, f64::max)))
    }

    /// The larger of two scales: one for two meshes that belong together.
    pub fn with(self, other: Self) -> Self {
        UnitScale(self.0.max(other.0))
    }

    /// The way back.
    pub fn back(self) -> Self {
        UnitScale(-self.0)
    }

    /// The points to work on, where they are not the mesh's own.
    pub fn points(self, points: &[DVec3]) -> Option<Vec<DVec3>> {
        // Vertices without faces may lie anywhere; nothing depends on them.
        (self.0 != 0).then(|| points.iter().map(|&p| self.point(p)).collect())
    }

    /// The mesh to work on, where it is not the given one; vertex properties of these names are lengths.
    pub fn mesh(self, mesh: &SurfaceMesh, lengths: &[&str]) -> Option<SurfaceMesh> {
        (self.0 != 0).then(|| self.moved(mesh.clone(), lengths))
    }

    /// A mesh in this scale; vertex properties of these names are lengths.
    pub fn moved(self, mesh: SurfaceMesh, lengths: &[&str]) -> SurfaceMesh {
        let mut mesh = mesh.with_points_mapped(|p| self.point(p));
        for name in lengths {
            if let Some(Column::Scalar(values)) = mesh.attributes.vertex.get_mut(*name) {
                values.iter_mut().for_each(|x| *x = self.length(*x));
            }
        }
        mesh
    }

    /// The net to work on, where it is not the given one.
    pub fn net(self, net: &CurveNet) -> Option<CurveNet> {
        (self.0 != 0).then(|| self.moved_net(net.clone()))
    }

    /// A net in this scale.
    pub fn moved_net(self, mut net: CurveNet) -> CurveNet {
        net.points.iter_mut().for_each(|p| *p = self.point(*p));
        net.radii.iter_mut().for_each(|r| *r = self.length(*r));
        net
    }

    /// A place of the model as one to work with.
    pub fn point(self, p: DVec3) -> DVec3 {
        DVec3::from_array(p.to_array().map(|x| self.length(x)))
    }

    /// A length of the model as one to work with.
    pub fn length(self, x: f64) -> f64 {
        times(x, -self.0)
    }

    /// A curvature as one of the model.
    pub fn curvature(self, k: f64) -> f64 {
        times(k, -self.0)
    }

    /// An area as one of the model.
    pub fn area(self, area: f64) -> f64 {
        times(times(area, self.0), self.0)
    }

    /// A volume as one of the model.
    pub fn volume(self, volume: f64) -> f64 {
        times(self.area(volume), self.0)
    }
}

/// Of the power of two just below a length; zero of none.
fn exponent(length: f64) -> i32 {
    // From its bits: a logarithm rounds, up to the next power at times.
    let of_normal = |x: f64| ((x.to_bits() >> 52) & 0x7ff) as i32 - 1023;
    match length {
        x if !(x > 0.0 && x.is_finite()) => 0,
        x if x < f64::MIN_POSITIVE => of_normal(x * 2f64.powi(64)) - 64,
        x => of_normal(x),
    }
}

/// x · 2ⁿ; the largest number where that is beyond the range.
fn times(x: f64, n: i32) -> f64 {
    if n == 0 {
        return x;
    }
    let halves = [n / 2, n - n / 2].map(|half| 2f64.powi(half));
    (x * halves[0] * halves[1]).clamp(f64::MIN, f64::MAX)
}

#[cfg(test)]
mod tests {
    use super::super::test_models;
    use super::*;

    #[test]
    fn what_is_brought_into_range_comes_back_bit_for_bit() {
        let mesh = test_models::tetrahedron();
        assert!(UnitScale::of_mesh(&mesh).mesh(&mesh, &[]).is_none());
        for n in [-1010, -700, -65, -3, -1, 1, 30, 65, 513, 1010] {
            let there = UnitScale(-n).moved(mesh.clone(), &[]);
            let scale = UnitScale::of_mesh(&there);
            let inside = scale.mesh(&there, &[]).unwrap();
            let size = inside.points().iter().map(|p| p.abs().max_element()).fold(0.0, f64::max);
            assert!((1.0..2.0).contains(&size), "2^{n}: {size}");
            assert_eq!(scale.back().moved(inside, &[]).points(), there.points(), "2^{n}");
        }
    }

    #[test]
    fn vertices_without_faces_do_not_count() {
        let mesh = test_models::tetrahedron();
        let mut points = mesh.points().to_vec();
        points.push(DVec3::splat(1e300));
        let with_a_far_vertex = SurfaceMesh::new(points, mesh.faces().clone()).unwrap();
        assert_eq!(UnitScale::of_mesh(&with_a_far_vertex), UnitScale(0));
    }
}
