//! Tori around the z axis: closed, noisy, open.

use super::builder::Builder;
use super::limits::{affordable, at_least, positive, within};
use super::model::Model;
use super::random::Random;
use super::shape::{Measure, Shape};
use crate::error::Result;
use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// A torus around the z axis: `rings` ≥ 3 circles of `sides` ≥ 3 points each. Label 0: the torus.
///
/// `minor` is the radius of the tube, `major` that of its centre line; `major` > `minor`.
///
/// # Errors
/// [`Error::Options`](crate::Error::Options) for sizes that make no such model, or one of too many triangles.
pub fn torus(major: f64, minor: f64, rings: u32, sides: u32) -> Result<Model> {
    check(major, minor, rings, sides)?;
    let mut b = Builder::default();
    let label = b.shape("torus", shape(major, minor));
    let mut circles = circles(&mut b, major, minor, (0..rings).map(|k| f64::from(k) / f64::from(rings)), sides);
    circles.extend(circles.first().cloned());
    b.rings(label, &circles);
    b.finish(Measure::closed(4.0 * PI * PI * major * minor, 2.0 * PI * PI * major * minor * minor))
}

/// A [`torus`] whose vertices are moved along the exact normals by independent amounts, uniform in
/// `-amplitude..=amplitude`. The model's `noise` is the amplitude.
///
/// # Errors
/// [`Error::Options`](crate::Error::Options) for sizes that make no such model, or one of too many triangles.
pub fn noisy_torus(major: f64, minor: f64, rings: u32, sides: u32, amplitude: f64, seed: u64) -> Result<Model> {
    within("amplitude", amplitude, 0.0, minor)?;
    let mut model = torus(major, minor, rings, sides)?;
    let mut random = Random::new(seed);
    let (mut points, faces, attributes, _) = model.mesh.into_parts();
    for p in &mut points {
        let centre = DVec3::new(p.x, p.y, 0.0).normalize() * major;
        *p += (*p - centre) / minor * amplitude * random.symmetric();
    }
    model.mesh = crate::mesh::SurfaceMesh::new(points, faces)?;
    model.mesh.attributes = attributes;
    model.noise = amplitude;
    Ok(model)
}

/// The part of a [`torus`] that is swept in turning by `sweep` degrees, more than 0 and less than 360, from the x axis:
/// an open tube with two borders.
///
/// # Errors
/// [`Error::Options`](crate::Error::Options) for sizes that make no such model, or one of too many triangles.
pub fn open_torus(major: f64, minor: f64, sweep: f64, rings: u32, sides: u32) -> Result<Model> {
    check(major, minor, rings, sides)?;
    positive("sweep", sweep)?;
    within("sweep", sweep, 0.0, 359.0)?;
    let share = sweep / 360.0;
    let mut b = Builder::default();
    let label = b.shape("torus", shape(major, minor));
    let turns = (0..=rings).map(|k| share * f64::from(k) / f64::from(rings));
    let circles = circles(&mut b, major, minor, turns, sides);
    b.rings(label, &circles);
    b.finish(Measure::open(share * 4.0 * PI * PI * major * minor))
}

fn check(major: f64, minor: f64, rings: u32, sides: u32) -> Result<()> {
    positive("minor radius", minor)?;
    within("major radius", major, minor * (1.0 + 1e-6), f64::MAX)?;
    at_least("rings", rings, 3)?;
    at_least("sides", sides, 3)?;
    affordable(2.0 * f64::from(rings) * f64::from(sides))
}

fn shape(major_radius: f64, minor_radius: f64) -> Shape {
    Shape::Torus { center: DVec3::ZERO, axis: DVec3::Z, major_radius, minor_radius }
}

/// Circles of the tube at these shares of a full turn. They run so that bands from one to the next face outwards.
fn circles(b: &mut Builder, major: f64, minor: f64, turns: impl Iterator<Item = f64>, sides: u32) -> Vec<Vec<u32>> {
    let circle = |turn: f64| {
        let (sin, cos) = (TAU * turn).sin_cos();
        let out = DVec3::new(cos, sin, 0.0);
        super::builder::circle(out * major, out * minor, DVec3::NEG_Z * minor, sides)
    };
    turns.map(|turn| b.points(circle(turn))).collect()
}
