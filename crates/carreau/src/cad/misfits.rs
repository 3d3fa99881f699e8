//! Pieces most of which lie on a surface exactly, and some of which does not: divided into both.
//!
//! ```text
//!     ┌───────────┬──╮             the wall of a cylinder and a blend, taken for one cylinder: that through most of the vertices
//!     │  cylinder │ blend          holds the wall, and the blend is free
//!     └───────────┴──╯
//! ```
//!
//! What does not lie on it goes to a neighbour that it lies on, if there is one: a facet with all corners on the border of two surfaces
//! lies on both but for its depth.

use super::clean::{CERTAIN_TRIANGLES, normals};
use super::regions::{Map, Piece, area_vector, connected, vertices};
use super::scraps::SCRAP_TILT;
use super::swept::SPARE_VERTICES;
use super::tuning::REFINE_STEPS;
use crate::brep::Surface;
use crate::geometry::primitive::{Kind, Primitive, Scratch, fit_robust, refine};
use glam::DVec3;

/// A count: fewest triangles of both parts together, because fewer lie on some surface by chance.
const LEAST_PARTED: usize = 12;
/// A count: most vertices of a piece that is parted, because time grows with them.
const MISFIT_VERTICES: usize = 5000;

/// How much of the area of a piece is on the surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Share {
    /// Nine tenths, on one of the kind that it was taken for, or of any kind where it was taken for none.
    Most,
    /// Half of the triangles, of what was taken for round: on the simplest kind, because a few triangles of a neighbour make a torus
    /// of a cylinder.
    Round,
    /// Half, on one of any kind where it was taken for a round one.
    Half,
}

impl Map<'_> {
    /// Divides the pieces that do not fit, where so much of them does; whether there were any.
    pub fn part_misfits(&mut self, share: Share) -> bool {
        let mut any = false;
        for p in 0..self.pieces.len() {
            let Some((own, primitive)) = self.fitting(&self.pieces[p], share) else { continue };
            let mut rest = self.pieces[p].triangles.clone();
            rest.retain(|k| own.binary_search(k).is_err());
            for part in connected(self.t, &rest, |_, _| true) {
                if let Some(home) = self.home(p as u32, &part, self.precision) {
                    self.give(p as u32, &part, home);
                    rest.retain(|k| part.binary_search(k).is_err());
                }
            }
            let described = (Surface::of_primitive(&primitive), Some(primitive));
            self.replace(&[p as u32], vec![(own, Some(described)), (rest, None)]);
            any = true;
        }
        self.compact();
        any
    }

    /// The connected part of a piece that lies on a surface, with its share of the area at least.
    fn fitting(&self, piece: &Piece, share: Share) -> Option<(Vec<u32>, Primitive)> {
        let kind = piece.primitive.map(|p| p.kind());
        if piece.triangles.len() < LEAST_PARTED || (kind.is_some() && !(piece.max > self.precision)) {
            return None;
        }
        let (points, normals) = (vertices(self.t, &piece.triangles), normals(self.t, &piece.triangles));
        if points.len() > MISFIT_VERTICES {
            return None;
        }
        let near = self.precision;
        let on = |p: &Primitive| -> Vec<u32> {
            let is_on = |c: u32| p.distance(self.t.point(c)).abs() <= near;
            // Lids have all corners on the surface that their rim is on.
            let faces = |&k: &u32| {
                let middle = (3 * k..3 * k + 3).map(|c| self.t.point(c)).sum::<DVec3>() / 3.0;
                p.normal(middle).dot(area_vector(self.t, k).normalize_or_zero()).abs() > SCRAP_TILT
            };
            piece.triangles.iter().copied().filter(|k| (3 * k..3 * k + 3).all(is_on)).filter(faces).collect()
        };
        let area = |of: &[u32]| of.iter().map(|&k| area_vector(self.t, k).length()).sum::<f64>();
        let round = [Kind::Cylinder, Kind::Sphere, Kind::Cone, Kind::Torus];
        let kinds: Vec<Kind> = match (kind, share) {
            (None | Some(Kind::Plane), Share::Round) => return None,
            (Some(_), Share::Round) => round.to_vec(),
            (Some(Kind::Plane), _) | (Some(_), Share::Most) => kind.into_iter().collect(),
            (Some(own), Share::Half) => [own].into_iter().chain(round.into_iter().filter(|&k| k != own)).collect(),
            (None, Share::Most) => round.to_vec(),
            // A band of some other surface may be half of it.
            (None, Share::Half) => return None,
        };
        let least = if share == Share::Most { 0.9 } else { 0.5 } * area(&piece.triangles);
        let is_most = |own: &[u32]| match share {
            Share::Round => 2 * own.len() >= piece.triangles.len(),
            _ => area(own) >= least,
        };
        let mut scratch = Scratch::default();
        kinds.into_iter().find_map(|kind| {
            let found = fit_robust(kind, &points, &normals, &mut scratch)?.fit.primitive;
            let inliers: Vec<_> = points.iter().copied().filter(|&q| found.distance(q).abs() <= near).collect();
            let primitive = refine(found, &inliers, None, REFINE_STEPS).map_or(found, |f| f.primitive);
            let parts = connected(self.t, &on(&primitive), |_, _| true);
            let own = parts.into_iter().max_by(|a, b| area(a).total_cmp(&area(b)).then(b[0].cmp(&a[0])))?;
            let enough =
                own.len() >= CERTAIN_TRIANGLES && vertices(self.t, &own).len() >= kind.parameters() + SPARE_VERTICES;
            (enough && is_most(&own)).then_some((own, primitive))
        })
    }
}
