//! Whether the data is exact, and how exact.
//!
//! Vertices of a tessellation lie on their surfaces to the last digits of the file; noise leaves nothing like that. Where most of what
//! is round does, the rest does not because it is something else: a blend is a torus to 1e-6 of the size, and a row of its triangles
//! belongs to the cylinder beside it within that.

use super::clean::CERTAIN_TRIANGLES;
use super::regions::{Map, Piece, Rung, area_vector};
use super::tuning::{EXACT_TOLERANCE, FILE_PRECISION, SOME_AREA};

/// A share of the area of what is round and exact: so much of it says how exact the data is, because the rest may have
/// triangles of a neighbour.
const SURE_ROUND: f64 = 0.7;
/// A factor: vertices are so many times farther from their surfaces than those of most, because those on edges are where the
/// part's own tolerance has them.
const PRECISION_FACTOR: f64 = 10.0;
/// A share of the diagonal: vertices nearer than this lie on their surface whatever the others do, because a fit to
/// few of them is no surer.
const LEAST_PRECISION: f64 = 1e-9;
/// A share of the area of what is round: data is exact where so much of it is, because noise leaves nothing exact.
const ROUND_EXACT: f64 = 0.5;

/// A share of the area: below it the other faces of a model are worth more than that it has no facets.
const FACETED_AREA: f64 = 0.5;
/// A count: with fewer facets a model can still be edited.
const MOST_FACETS: usize = 300;

impl Map<'_> {
    /// The share of the area in pieces of some triangles whose vertices lie on their surface.
    pub fn exact_share(&self) -> f64 {
        self.share(|p| self.fits(p))
    }

    /// The share of the area in pieces that have a surface.
    pub fn known_share(&self) -> f64 {
        self.share(|p| p.rung < Rung::Spline)
    }

    /// Whether more of the surface went down to facets than has a face of its own, so that nobody could edit the model.
    pub fn is_faceted(&self) -> bool {
        let facets = self.pieces.iter().filter(|p| p.rung >= Rung::Planes).count();
        facets > MOST_FACETS && self.share(|p| p.rung >= Rung::Planes) > FACETED_AREA
    }

    /// Whether what is off its surface may be something else than noise, because some of the data is exact. Where there is
    /// noise that says nothing: planes stay exact beside round surfaces that have it.
    pub fn has_misfits(&self) -> bool {
        !self.is_noisy() && self.exact_share() > SOME_AREA
    }

    /// Whether the data is exact: most of what is taken for round lies on its surface to the precision of the file, which noise would
    /// leave nothing of, and vertices on the chords of something round nothing but planes.
    pub fn is_exact(&self) -> bool {
        let round = self.share(|p| p.is_round());
        let exact = self.share(|p| p.is_round() && self.fits(p));
        exact >= SOME_AREA && exact >= ROUND_EXACT * round
    }

    /// In exact data, finds out how exact it is, from the best of what is round: files of full precision are so by far more than
    /// [`FILE_PRECISION`], and a blend is a torus within that.
    pub fn measure_precision(&mut self) {
        if !self.is_exact() {
            return;
        }
        self.tolerance = self.tolerance.min(EXACT_TOLERANCE * self.diagonal);
        let area = |p: &Piece| p.triangles.iter().map(|&k| area_vector(self.t, k).length()).sum::<f64>();
        let exact = self.pieces.iter().filter(|p| p.is_round() && self.fits(p));
        let mut off: Vec<(f64, f64)> = exact.map(|p| (p.max, area(p))).collect();
        off.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut left = SURE_ROUND * off.iter().map(|o| o.1).sum::<f64>();
        let most = off.iter().find(|o| {
            left -= o.1;
            left <= 0.0
        });
        let least = LEAST_PRECISION * self.diagonal;
        self.precision = most.map_or(self.precision, |o| (PRECISION_FACTOR * o.0).clamp(least, self.precision));
    }

    /// Whether a piece of some triangles lies on its surface to the precision of the file.
    fn fits(&self, p: &Piece) -> bool {
        p.rung < Rung::Spline && p.triangles.len() >= CERTAIN_TRIANGLES && p.max <= FILE_PRECISION * self.diagonal
    }

    fn share(&self, counts: impl Fn(&Piece) -> bool) -> f64 {
        let area = |p: &Piece| p.triangles.iter().map(|&k| area_vector(self.t, k).length()).sum::<f64>();
        let all: f64 = self.pieces.iter().map(area).sum();
        self.pieces.iter().filter(|p| counts(p)).map(area).sum::<f64>() / all
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::context::Context;
    use crate::mesh::Triangles;
    use crate::sample;
    use crate::segment::{SegmentOptions, segment};
    use glam::DVec3;

    /// The map of a cylinder whose vertices are moved by up to a share of the diagonal: exactness, and the precision as a share.
    fn of_cylinder(share: f64) -> (bool, f64) {
        let context = Context::new();
        let mesh = sample::make("cylinder", None, &context).unwrap();
        let shift = |k: usize| DVec3::new((7 * k % 13) as f64, (5 * k % 11) as f64, (3 * k % 7) as f64) / 13.0;
        let size = share * mesh.diagonal();
        let points = mesh.points().iter().enumerate().map(|(k, &p)| p + size * shift(k)).collect();
        let triangles: Vec<[u32; 3]> = mesh.faces().iter().map(|f| [f[0], f[1], f[2]]).collect();
        let mesh = crate::mesh::SurfaceMesh::from_triangles(points, &triangles).unwrap();
        let found = segment(&mesh, &SegmentOptions::default(), &context).unwrap();
        let mut map = Map::new(Triangles::of(&mesh).unwrap(), mesh.diagonal(), &found);
        map.measure_precision();
        (map.is_exact(), map.precision / mesh.diagonal())
    }

    #[test]
    fn precision_is_that_of_the_digits_and_noise_has_none() {
        let (exact, share) = of_cylinder(0.0);
        assert!(exact && share <= LEAST_PRECISION, "{share}");
        // Digits of single precision.
        let (exact, share) = of_cylinder(6e-8);
        assert!(exact && (1e-8..=FILE_PRECISION).contains(&share), "{share}");
        let (exact, share) = of_cylinder(1e-3);
        assert!(!exact && share == FILE_PRECISION, "{share}");
    }
}
