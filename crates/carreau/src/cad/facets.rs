//! Pieces as plane facets: which are no more than that from the beginning, and how the others are divided.

use super::regions::{Map, Piece, Rung, area_vector, vertex_ids};
use super::tuning::{COARSEST_SAGITTA, COPLANAR_ANGLE, COPLANAR_DISTANCE, FILE_PRECISION};
use super::unions::UNION_BEND;
use crate::brep::{Frame, Surface};
use crate::geometry::normals::{angle_between, unit};
use crate::geometry::primitive::Primitive;
use crate::mesh::{NONE, Triangles};
use glam::DVec3;

/// A count: facets that look different ways, because corners of fewer are on some cylinder by chance.
const CERTAIN_FACETS: usize = 4;
/// A count: so many vertices on a surface that bends both ways are no chance, because they are twice the numbers of a
/// torus and more. Facets at the seam of a sphere may bend by any angle.
const CERTAIN_VERTICES: usize = 16;
/// Radians: facets look different ways from here on, far above what rounding turns them by.
const OTHER_WAY_ANGLE: f64 = 1e-3;

impl Map<'_> {
    /// Pieces on surfaces that a few flat sides lie on by chance: facets cut off a lot, and there are few of them, or they bend as
    /// flat sides of a part do. Two flat sides have corners on some cylinder, and those of a prism are on one, too.
    pub fn coarse(&self) -> Vec<u32> {
        (0u32..).zip(&self.pieces).filter(|(_, piece)| self.is_coarse(piece)).map(|(p, _)| p).collect()
    }

    /// Whether a piece is on its surface by chance.
    pub fn is_coarse(&self, piece: &Piece) -> bool {
        piece.rung < Rung::Spline
            && sagitta(self.t, &piece.triangles, &piece.surface) > COARSEST_SAGITTA * self.diagonal
            && !self.is_certain(piece)
            && !self.is_fillet(piece)
    }

    /// Whether a piece has several facets that look different ways and bend as those of one surface.
    fn is_certain(&self, piece: &Piece) -> bool {
        let both_ways = matches!(piece.surface, Surface::Sphere { .. } | Surface::Torus { .. });
        if both_ways && vertex_ids(self.t, &piece.triangles).len() >= CERTAIN_VERTICES {
            return true;
        }
        let normal = |k: u32| unit(area_vector(self.t, k));
        let mut ways: Vec<DVec3> = Vec::new();
        for n in piece.triangles.iter().map(|&k| normal(k)) {
            if ways.len() < CERTAIN_FACETS && ways.iter().all(|m| angle_between(*m, n) > OTHER_WAY_ANGLE) {
                ways.push(n);
            }
        }
        let own = |o: u32| o != NONE && piece.triangles.binary_search(&(o / 3)).is_ok();
        let inside = piece.triangles.iter().flat_map(|&k| 3 * k..3 * k + 3).map(|c| (c / 3, self.t.opposite(c)));
        let bend =
            inside.filter(|i| own(i.1)).map(|(k, o)| angle_between(normal(k), normal(o / 3))).fold(0.0, f64::max);
        ways.len() >= CERTAIN_FACETS && bend < UNION_BEND
    }

    /// Whether a piece is a cylinder that touches two planes beside it.
    fn is_fillet(&self, piece: &Piece) -> bool {
        let Some(Primitive::Cylinder { origin, axis, radius }) = piece.primitive else { return false };
        let around = self.labels_beside(piece.triangles.iter().copied());
        let touches = |&p: &u32| match self.pieces[p as usize].primitive {
            Some(Primitive::Plane { origin: o, normal }) => {
                let off = (normal.dot(origin - o).abs() - radius).abs();
                normal.dot(axis).abs() < FILE_PRECISION && off <= FILE_PRECISION * self.diagonal
            }
            _ => false,
        };
        around.iter().filter(|p| touches(p)).count() >= 2
    }

    /// Puts plane facets in the place of pieces: sets of coplanar triangles, or single ones.
    pub fn divide(&mut self, which: &[u32], rung: Rung) {
        let t = self.t;
        let (angle, distance) = match rung {
            Rung::Triangles => (-1.0, -1.0),
            _ => (COPLANAR_ANGLE, COPLANAR_DISTANCE * self.diagonal),
        };
        for &p in which {
            let mut free: Vec<u32> = std::mem::take(&mut self.pieces[p as usize].triangles);
            let region = self.pieces[p as usize].region;
            let area = |k: u32| area_vector(t, k).length();
            // The largest triangles know their planes best.
            free.sort_by(|&a, &b| area(b).total_cmp(&area(a)).then(a.cmp(&b)));
            for &seed in &free {
                if self.label[seed as usize] != p {
                    continue;
                }
                let (origin, normal) = (t.point(3 * seed), unit(area_vector(t, seed)));
                let own = u32::MAX - 1;
                let mut group = vec![seed];
                self.label[seed as usize] = own;
                let mut at = 0;
                while at < group.len() {
                    for o in (3 * group[at]..3 * group[at] + 3).map(|c| t.opposite(c)).filter(|&o| o != NONE) {
                        let k = o / 3;
                        let flat = || {
                            let turn = angle_between(normal, unit(area_vector(t, k)));
                            turn <= angle && (t.point(t.previous(o)) - origin).dot(normal).abs() <= distance
                        };
                        if self.label[k as usize] == p && flat() {
                            self.label[k as usize] = own;
                            group.push(k);
                        }
                    }
                    at += 1;
                }
                group.sort_unstable();
                let surface = Surface::Plane { frame: Frame::along(origin, normal) };
                let primitive = Some(Primitive::Plane { origin, normal });
                let id = self.new_id();
                let piece = Piece { id, surface, primitive, rung, ..Piece::free(t, group, region) };
                let id = self.pieces.len() as u32;
                piece.triangles.iter().for_each(|&k| self.label[k as usize] = id);
                self.pieces.push(piece);
            }
        }
    }
}

/// How far facets cut off their surface: the largest distance of the middles of triangles and edges.
fn sagitta(t: Triangles<'_>, triangles: &[u32], surface: &Surface) -> f64 {
    let middles = triangles.iter().flat_map(|&k| {
        let [a, b, c] = [0, 1, 2].map(|i| t.point(3 * k + i));
        [(a + b) / 2.0, (b + c) / 2.0, (c + a) / 2.0, (a + b + c) / 3.0]
    });
    middles.map(|p| surface.distance(p).abs()).fold(0.0, f64::max)
}
