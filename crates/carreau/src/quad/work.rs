//! An all-quad mesh at work: its vertices know where they belong on the source.

use super::source::Source;
use crate::error::Result;
use crate::mesh::{Polygons, SurfaceMesh, TaggedEdge, VertexId};
use glam::DVec3;

/// A cosine: the surface looks against a direction from which it turns by more, far above a right angle because needles look
/// anywhere.
const AGAINST: f64 = -0.5;

/// Where a vertex belongs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// It stays where it is.
    Fixed,
    /// On a feature curve of the source.
    Curve(u32),
    /// In a region of the source.
    Region(u32),
}

/// Polygons on their way to quads.
#[derive(Debug, Clone, Default)]
pub struct Work {
    pub points: Vec<DVec3>,
    pub place: Vec<Place>,
    pub faces: Polygons,
    /// Region of every face.
    pub region: Vec<u32>,
    /// Edges on features, by their ends, with the curve of each.
    pub features: Vec<([u32; 2], u32)>,
}

impl Work {
    /// The nearest point of where a vertex belongs.
    pub fn put_back(&self, source: &Source, v: u32, p: DVec3) -> DVec3 {
        match self.place[v as usize] {
            Place::Fixed => self.points[v as usize],
            Place::Curve(curve) => source.on_curve(curve, p).unwrap_or(p),
            Place::Region(region) => source.on_region(region, p).map_or(p, |found| found.0),
        }
    }

    /// The same, but `None` where the surface there looks against a direction: on a limb that is thinner than quads the nearest place
    /// may be on its other side.
    pub fn put_back_facing(&self, source: &Source, v: u32, p: DVec3, up: DVec3) -> Option<DVec3> {
        let Place::Region(region) = self.place[v as usize] else { return Some(self.put_back(source, v, p)) };
        let Some((to, t)) = source.on_region(region, p) else { return Some(p) };
        (source.normal(t).dot(up) >= AGAINST * up.length()).then_some(to)
    }

    /// The quads as a mesh whose tagged edges are the features.
    pub fn to_mesh(&self) -> Result<SurfaceMesh> {
        let mut mesh = SurfaceMesh::new(self.points.clone(), self.faces.clone())?;
        let tagged = |(ends, _): &([u32; 2], u32)| TaggedEdge { ends: ends.map(VertexId), tag: 1 };
        mesh.tagged_edges = self.features.iter().map(tagged).collect();
        Ok(mesh)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::context::Context;
    use crate::geometry::features::FeatureOptions;
    use crate::sample;

    #[test]
    fn nothing_is_put_onto_the_other_side_of_a_thin_limb() {
        let context = Context::new();
        let ball = sample::make("icosphere", Some(20), &context).unwrap();
        let flat = ball.points().iter().map(|&p| p * DVec3::new(1.0, 1.0, 0.02)).collect();
        let lens = SurfaceMesh::new(flat, ball.faces().clone()).unwrap();
        let options = FeatureOptions { angle_deg: None, ..FeatureOptions::default() };
        let source = Source::new(&lens, &options, &context).unwrap();
        let top = DVec3::new(0.0, 0.0, 0.02);
        let work = Work { points: vec![top], place: vec![Place::Region(0)], ..Work::default() };
        let put = |z: f64, up: DVec3| work.put_back_facing(&source, 0, DVec3::new(0.1, 0.0, z), up);
        assert!(put(-0.05, DVec3::Z).is_none() && put(0.05, -DVec3::Z).is_none());
        assert!(put(0.05, DVec3::Z).unwrap().z > 0.0 && put(-0.05, -DVec3::Z).unwrap().z < 0.0);
        // What stays where it is may look anywhere.
        let fixed = Work { place: vec![Place::Fixed], ..work.clone() };
        assert_eq!(fixed.put_back_facing(&source, 0, DVec3::ZERO, -DVec3::Z), Some(top));
    }
}
