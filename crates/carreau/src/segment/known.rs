//! The surfaces of triangles that are known before regions are fitted. Two rings of vertices are on many surfaces, and those of
//! rounded edges on none: what was found with all that is around is not to be found again from less.

use super::regions::{fit_region, measure};
use super::surface::Surface;
use crate::geometry::primitive::{Fit, Kind, Primitive};

/// A factor: another surface is taken instead of a torus that is so many times farther from the vertices, because the seven numbers of one
/// through two rings of vertices fit nearly anything; both within rounding say nothing.
const MUCH_NEARER: f64 = 1e-3;

/// The surface of every triangle; empty where none is known.
#[derive(Default)]
pub struct Known {
    of: Vec<Option<Primitive>>,
    /// Triangles without are on no surface; otherwise nothing is known of them.
    all: bool,
}

impl Known {
    /// The surfaces of labels; labels beyond have none.
    pub fn of(label: &[u32], surface: impl Fn(u32) -> Option<Primitive>, all: bool) -> Self {
        Known { of: label.iter().map(|&l| surface(l)).collect(), all }
    }

    /// The surface of a region: of the known kind, fitted to all of it; else the simplest of these kinds within the tolerance.
    pub fn fit(&self, surface: &Surface<'_>, triangles: &[u32], tolerance: f64, kinds: &[Kind]) -> Option<Fit> {
        match self.of.get(triangles[0] as usize) {
            Some(&Some(known)) if self.all => measure(surface, triangles, known),
            Some(&Some(known)) => {
                let own = measure(surface, triangles, known);
                let is_likelier = |fit: &Fit| {
                    let is_nearer = || own.as_ref().is_none_or(|own| fit.max < MUCH_NEARER * own.max);
                    fit.primitive.kind() == known.kind() || known.kind() == Kind::Torus && is_nearer()
                };
                fit_region(surface, triangles, tolerance, kinds).filter(is_likelier).or(own)
            }
            Some(None) if self.all => None,
            _ => fit_region(surface, triangles, tolerance, kinds),
        }
    }
}
