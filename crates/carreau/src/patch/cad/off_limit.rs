//! How far the face of a cell may be off the triangles that it stands for.

use crate::mesh::triangle_area_vector;
use glam::DVec3;

/// Gauss points for areas of bilinear surfaces, in each direction: exact to the eighth digit but for cells that fold.
pub const POINTS: [[f64; 2]; 4] = [
    [0.069_431_844_202_973_71, 0.173_927_422_568_726_93],
    [0.330_009_478_207_571_87, 0.326_072_577_431_273_07],
    [0.669_990_521_792_428_1, 0.326_072_577_431_273_07],
    [0.930_568_155_797_026_3, 0.173_927_422_568_726_93],
];

/// How far a cell may be off its triangles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OffLimit {
    pub(super) share: f64,
    /// Volume through area of a closed mesh.
    pub(super) thickness: Option<f64>,
}

impl OffLimit {
    /// Whether the face of a cell is farther off; corners in cyclic order, cut from the first or the second, whatever is worse.
    pub(in crate::patch) fn is_exceeded(&self, corners: [DVec3; 4]) -> bool {
        let [a, b, c, d] = corners;
        let cuts = [area([a, b, c]) + area([a, c, d]), area([a, b, d]) + area([b, c, d])];
        let least = cuts[0].min(cuts[1]);
        let face = bilinear_area(corners);
        cuts.iter().any(|cut| (face - cut).abs() > self.share * least)
            || self.thickness.is_some_and(|t| twelfth(corners).abs() > self.share * least * t)
    }
}

pub fn area([a, b, c]: [DVec3; 3]) -> f64 {
    triangle_area_vector(a, b, c).length()
}

/// Volume between the bilinear surface and the triangles a b c, a c d.
pub fn twelfth([a, b, c, d]: [DVec3; 4]) -> f64 {
    (b - a).dot((c - a).cross(d - a)) / 12.0
}

/// Area of the bilinear surface through four corners.
pub fn bilinear_area([a, b, c, d]: [DVec3; 4]) -> f64 {
    let (along, up, twist) = (b - a, d - a, a - b + c - d);
    let element = |u: f64, v: f64| (along + v * twist).cross(up + u * twist).length();
    POINTS.iter().map(|&[u, p]| POINTS.iter().map(|&[v, q]| p * q * element(u, v)).sum::<f64>()).sum()
}
