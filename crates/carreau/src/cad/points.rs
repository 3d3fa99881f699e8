//! The points that a spline surface is fitted to: the vertices of its region, points of the curves around it, middles of its edges.

use super::curves::Track;
use super::flatten::Flat;
use super::grid::Sample;
use super::regions::area_vector;
use super::topology::Chain;
use crate::geometry::bspline::BSplineSurface;
use crate::mesh::{NONE, Triangles};
use glam::{DVec2, DVec3};

/// A count: fewest points of an edge's curve for each side of the mesh, because the curve bends between the ends of a
/// side.
const POINTS_A_SIDE: usize = 3;

/// A curve around the region: parameters of points along it, and their places.
pub struct Border<'a> {
    /// The curve.
    pub track: &'a Track,
    /// Parameters on the curve, and those of the surface.
    pub at: Vec<(f64, DVec2)>,
}

impl<'a> Border<'a> {
    /// Points at the vertices of the mesh.
    pub fn new(t: Triangles<'_>, chain: &Chain, track: &'a Track, flat: &Flat) -> Self {
        let sides = chain.vertices.len() - 1;
        let mut from = track.range[0];
        let mut at = vec![(from, flat.place(chain.vertices[0]))];
        for k in 0..sides {
            let [a, b] = [k, k + 1].map(|k| chain.vertices[k]);
            let to = if k + 1 == sides {
                track.range[1]
            } else {
                let chord = t.points()[a as usize].distance(t.points()[b as usize]);
                let guess = from + chord / track.curve.derivatives(from)[1].length().max(f64::MIN_POSITIVE);
                track.curve.project_near(t.points()[b as usize], guess).clamp(from, track.range[1])
            };
            at.push((to, flat.place(b)));
            from = to;
        }
        let mut border = Border { track, at };
        // Splines may bend between two vertices.
        let spans = match &track.curve {
            crate::brep::Curve::Spline(s) => s.knots().breaks().len() - 1,
            _ => 1,
        };
        while border.at.len() < (POINTS_A_SIDE * sides).max(2 * spans) {
            border.double(0.0);
        }
        border
    }

    /// Points in the middle of steps that are longer than a length; whether there were any.
    pub fn double(&mut self, step: f64) -> bool {
        let mut out = vec![self.at[0]];
        for w in self.at.windows(2) {
            let ([(s, p), (t, q)], long) = ([w[0], w[1]], w[0].1.distance(w[1].1) > step);
            if long || step == 0.0 {
                out.push((0.5 * (s + t), 0.5 * (p + q)));
            }
            out.push((t, q));
        }
        let more = out.len() > self.at.len();
        self.at = out;
        more
    }

    /// The place of a point.
    pub fn point(&self, k: usize) -> DVec3 {
        self.track.curve.point(self.at[k].0)
    }

    /// The largest distance from a surface: at the points, and between them.
    pub fn gap(&self, surface: &BSplineSurface) -> f64 {
        let off = |t: f64, near: DVec2| {
            let p = self.track.curve.point(t);
            let [u, v] = surface.project(p, near.into());
            surface.point(u, v).distance(p)
        };
        let between = self.at.windows(2).map(|w| off(0.5 * (w[0].0 + w[1].0), 0.5 * (w[0].1 + w[1].1)));
        self.at.iter().map(|&(t, uv)| off(t, uv)).chain(between).fold(0.0, f64::max)
    }
}

/// Middles of the edges inside of a region, raised by what they cut off as the normals at their ends say; still without a weight.
pub fn raised(t: Triangles<'_>, triangles: &[u32], label: &[u32], p: u32, flat: &Flat) -> Vec<Sample> {
    let mut normals = vec![DVec3::ZERO; flat.vertices.len()];
    let at = |v: u32| flat.vertices.binary_search(&v).unwrap_or(0);
    for &k in triangles {
        let n = area_vector(t, k);
        t.triangle(k).into_iter().for_each(|v| normals[at(v)] += n);
    }
    normals.iter_mut().for_each(|n| *n = n.normalize_or_zero());
    let mut out = Vec::new();
    for c in triangles.iter().flat_map(|&k| 3 * k..3 * k + 3) {
        let o = t.opposite(c);
        if o == NONE || o < c || label[o as usize / 3] != p {
            continue;
        }
        let [a, b] = [t.vertex(c), t.vertex(t.next(c))];
        let [m, n] = [a, b].map(|v| normals[at(v)]);
        let side = t.points()[b as usize] - t.points()[a as usize];
        let up = (m + n).normalize_or_zero();
        let height = ((n - m).dot(side) / 8.0).clamp(-0.25 * side.length(), 0.25 * side.length());
        let point = t.points()[a as usize] + 0.5 * side + up * height;
        out.push(Sample { uv: 0.5 * (flat.place(a) + flat.place(b)), point, weight: 0.0 });
    }
    out
}
