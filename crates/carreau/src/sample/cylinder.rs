//! Cylinders around the z axis, from z = 0 upwards.

use super::builder::{Builder, circle};
use super::limits::{affordable, affordable_edge, at_least, divisions, positive};
use super::model::Model;
use super::shape::{Measure, Shape};
use crate::error::Result;
use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// A closed cylinder with edges of about this length; the circles have a multiple of four points, at least eight. Wall and
/// caps are regular grids.
///
/// Labels: 0 the wall, 1 the bottom, 2 the top.
///
/// # Errors
/// [`Error::Options`](crate::Error::Options) for sizes that make no such model, or one of too many triangles.
pub fn cylinder(radius: f64, height: f64, edge: f64) -> Result<Model> {
    positive("radius", radius)?;
    positive("height", height)?;
    affordable_edge(edge, TAU * radius * (radius + height))?;
    let segments = divisions(TAU * radius, edge, 8).next_multiple_of(4);
    let mut b = Builder::default();
    let rings = wall(&mut b, radius, height, segments, divisions(height, edge, 1));
    if let (Some(bottom), Some(top)) = (rings.first(), rings.last()) {
        // Seen from below, the bottom's outline runs the other way.
        disc(&mut b, "bottom", DVec3::NEG_Z, bottom.iter().rev().copied().collect());
        disc(&mut b, "top", DVec3::Z, top.clone());
    }
    b.finish(Measure::closed(TAU * radius * (radius + height), PI * radius.powi(2) * height))
}

/// The wall of a cylinder, without caps: `segments` ≥ 3 around, `bands` ≥ 1 along. Label 0: the wall.
///
/// # Errors
/// [`Error::Options`](crate::Error::Options) for sizes that make no such model, or one of too many triangles.
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

/// How far the corners of a disc's square are from its centre, in radii.
const SQUARE: f64 = 0.75;

/// Fills a ring of 4k vertices, counter-clockwise seen along the normal: a square of k × k quads within closed rings of quads.
///
/// ```text
///        ●────●────●
///      ╱ │    │    │ ╲        the corners of the square are beside the vertices 0, k, 2k and 3k
///     ●──●────●────●──●
///     │  │    │    │  │
///     ●──●────●────●──●
///      ╲ │    │    │ ╱
///        ●────●────●
/// ```
fn disc(b: &mut Builder, name: &str, normal: DVec3, ring: Vec<u32>) {
    let k = ring.len() / 4;
    let centre = ring.iter().map(|&v| b.at(v)).sum::<DVec3>() / ring.len() as f64;
    let label = b.shape(name, Shape::Plane { origin: centre, normal });
    let corner = |b: &Builder, quarter: usize| centre.lerp(b.at(ring[quarter * k]), SQUARE);
    let [origin, right, up] = [corner(b, 0), corner(b, 1), corner(b, 3)];
    let at =
        |i: usize, j: usize| origin + (right - origin) * (i as f64 / k as f64) + (up - origin) * (j as f64 / k as f64);
    let rows: Vec<Vec<u32>> = (0..=k).map(|j| b.points((0..=k).map(|i| at(i, j)))).collect();
    rows.windows(2).for_each(|pair| b.band(label, &pair[0], &pair[1]));
    // Once around the square, from the corner beside vertex 0.
    let bottom = (0..k).map(|i| rows[0][i]);
    let sides = (0..k).map(|j| rows[j][k]).chain((1..=k).rev().map(|i| rows[k][i]));
    let inner: Vec<u32> = bottom.chain(sides).chain((1..=k).rev().map(|j| rows[j][0])).collect();
    // As many rings as keep the quads about square.
    let layers = (k as f64 * 0.28).round().max(1.0) as usize;
    let mut rings = vec![ring];
    for layer in 1..layers {
        let t = layer as f64 / layers as f64;
        let between: Vec<DVec3> = rings[0].iter().zip(&inner).map(|(&o, &i)| b.at(o).lerp(b.at(i), t)).collect();
        rings.push(b.points(between));
    }
    rings.push(inner);
    b.rings(label, &rings);
}
