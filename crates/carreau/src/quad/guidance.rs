//! What quads are led by beside the surface and its features: sizes, guides, and the planes that the surface was cut at.

use super::QuadOptions;
use super::junction::EdgePlace;
use super::sizes::Sizes;
use super::source::Source;
use super::symmetry::MirrorPlane;
use crate::context::Context;
use crate::error::{Error, Result};
use crate::field::below_guides;
use crate::mesh::SurfaceMesh;
use glam::DVec3;
use rustc_hash::FxHashSet;
use std::sync::Arc;

/// None of all by default.
#[derive(Clone, Default)]
pub struct Guidance {
    /// Planes of symmetry that the surface was cut at.
    pub cuts: Vec<MirrorPlane>,
    /// The edges there that are no features of the whole.
    pub cut_places: FxHashSet<EdgePlace>,
    /// How long edges are to be, where they are not to be even.
    pub sizes: Option<Arc<Sizes>>,
    /// Weight of the directions of curvature in the field.
    pub curvature: f64,
    /// Segments that rows of quads follow.
    pub guides: Vec<[DVec3; 2]>,
}

impl Guidance {
    /// What is asked for, of a surface whose properties are those of a mesh. `length`: of the quads' edges.
    pub fn new(
        source: &Source,
        mesh: &SurfaceMesh,
        options: &QuadOptions,
        length: f64,
        context: &Context,
    ) -> Result<Self> {
        let sizes = match &options.sizes {
            Some(name) => Some(Sizes::of_property(mesh, name, length)?),
            None if options.adaptive => Sizes::of_curvature(source, length, context)?,
            None => Sizes::of_limbs(source, length, context)?,
        };
        let (guides, surface) = (&options.guides, &source.surface.mesh);
        let is_near = || !below_guides(surface.points(), &surface.faces().fan().0, guides, length).is_empty();
        if !guides.is_empty() && !is_near() {
            return Err(Error::Options(
                "guides: no place of them is within two edges of the quads from the surface".into(),
            ));
        }
        Ok(Guidance {
            sizes: sizes.map(Arc::new),
            curvature: options.curvature,
            guides: guides.clone(),
            ..Guidance::default()
        })
    }
}
