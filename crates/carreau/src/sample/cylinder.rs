//! Cylinders around the z axis, from z = 0 upwards.

use super::Model;
use super::builder::{Builder, circle};
use super::limits::{affordable, affordable_edge, at_least, divisions, positive};
use super::shape::{Measure, Shape};
use crate::context::Context;
use crate::error::Result;
use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// A closed cylinder with edges of about this length; the circles have at least eight points.
///
/// Labels: 0 the wall, 1 the bottom, 2 the top.
pub fn cylinder(radius: f64, height: f64, edge: f64, context: &Context) -> Result<Model> {
    positive("radius", radius)?;
    positive("height", height)?;
    affordable_edge(edge, TAU * radius * (radius + height))?;
    let segments = divisions(TAU * radius, edge, 8);
    let mut b = Builder::default();
    let rings = wall(&mut b, radius, height, segments, divisions(height, edge, 1));
    if let (Some(bottom), Some(top)) = (rings.first(), rings.last()) {
        // Seen from below, the bottom's outline runs the other way; a fill does not mind.
        b.planar_face("bottom", DVec3::NEG_Z, &[bottom], edge, context)?;
        b.planar_face("top", DVec3::Z, &[top], edge, context)?;
    }
    b.finish(Measure::closed(TAU * radius * (radius + height), PI * radius.powi(2) * height))
}

/// The wall of a cylinder, without caps: `segments` ≥ 3 around, `bands` ≥ 1 along. Label 0: the wall.
pub fn open_cylinder(radius: f64, height: f64, segments: u32, bands: u32) -> Result<Model> {
    positive("radius", radius)?;
    positive("height", height)?;
    at_least("segments", segments, 3)?;
    at_least("bands", bands, 1)?;
    affordable(2.0 * f64::from(segments) * f64::from(bands))?;
    let mut b = Builder::default();
    wall(&mut b, radius, height, segments, bands);
    b.finish(Measure::open(TAU * radius * height))
}

/// Adds the wall; returns its rings from bottom to top.
fn wall(b: &mut Builder, radius: f64, height: f64, segments: u32, bands: u32) -> Vec<Vec<u32>> {
    let label = b.shape("wall", Shape::Cylinder { origin: DVec3::ZERO, axis: DVec3::Z, radius });
    let rings: Vec<Vec<u32>> = (0..=bands)
        .map(|k| DVec3::Z * (height * f64::from(k) / f64::from(bands)))
        .map(|centre| b.points(circle(centre, DVec3::X * radius, DVec3::Y * radius, segments)))
        .collect();
    b.rings(label, &rings);
    rings
}
