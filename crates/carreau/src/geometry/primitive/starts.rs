//! Start values: from normals, from the paraboloid of the patch, from the spread of the points.
//!
//! No single start serves all: normals of coarse meshes are poor, paraboloids need a patch that is a graph over its plane,
//! the spread of points tells the axis of whole surfaces only. The starts of a kind are offered one after the other,
//! likely ones first, until the receiver has had enough.

use super::anchored::Anchored;
use super::axis::{Axis, kinematic, of_tangent_planes, orthogonal_to_all, spread};
use super::circle::{circle, line};
use super::paraboloid::Paraboloid;
use super::refine::central;
use super::shape::{Kind, Primitive, profile_point};
use crate::numeric::levenberg::solve_cholesky;
use glam::{DVec2, DVec3};
use std::ops::ControlFlow::{self, Continue};

/// Leanings of the axis, in radians, that are tried for cones. To second order a patch does not tell them: curvature
/// across the profile is cos φ / (distance from the axis).
const CONE_ANGLES: [f64; 5] = [0.0, 0.5, -0.5, 1.1, -1.1];
/// The same for tori.
const TORUS_ANGLES: [f64; 5] = [0.0, 0.8, -0.8, 1.3, -1.3];

/// Points in the unit box with what is known of the normals.
#[derive(Clone, Copy)]
pub(super) struct Sample<'a> {
    pub points: &'a [DVec3],
    /// Those points whose normal is known.
    pub oriented: &'a [DVec3],
    /// Unit normals of the oriented points.
    pub normals: &'a [DVec3],
}

/// Takes a start, says whether to go on; `None` is no start.
pub(super) trait Receiver: FnMut(Option<Anchored>) -> ControlFlow<()> {}
impl<F: FnMut(Option<Anchored>) -> ControlFlow<()>> Receiver for F {}

/// Offers the starts of a kind.
pub(super) fn offer(kind: Kind, sample: &Sample, receiver: &mut impl Receiver) -> ControlFlow<()> {
    match kind {
        Kind::Plane => receiver(sample.plane()),
        Kind::Sphere => spheres(sample, receiver),
        Kind::Cylinder => cylinders(sample, receiver),
        Kind::Cone => cones(sample, receiver),
        Kind::Torus => tori(sample, receiver),
    }
}

fn spheres(sample: &Sample, receiver: &mut impl Receiver) -> ControlFlow<()> {
    receiver(sample.algebraic_sphere())?;
    let flat = sample.plane();
    receiver(flat.and_then(|plane| Anchored::isotropic(Kind::Sphere, plane.foot, plane.radial, 0.0)))
}

fn cylinders(sample: &Sample, receiver: &mut impl Receiver) -> ControlFlow<()> {
    receiver(orthogonal_to_all(sample.normals).and_then(|axis| sample.cylinder_along(axis)))?;
    if let Some(patch) = sample.paraboloid() {
        let [along, _] = patch.directions;
        receiver(Anchored::from_tangents(
            Kind::Cylinder,
            patch.foot,
            patch.normal,
            along,
            patch.curvatures[1],
            0.0,
            0.0,
        ))?;
    }
    receiver(sample.crossing_normals().and_then(|axis| sample.cylinder_along(axis)))?;
    for axis in spread(sample.points).1.vectors {
        receiver(sample.cylinder_along(axis))?;
    }
    Continue(())
}

fn cones(sample: &Sample, receiver: &mut impl Receiver) -> ControlFlow<()> {
    receiver(of_tangent_planes(sample.oriented, sample.normals).and_then(|axis| sample.cone_around(axis)))?;
    receiver(kinematic(sample.oriented, sample.normals).and_then(|axis| sample.cone_around(axis)))?;
    if let Some(patch) = sample.paraboloid() {
        let ([along, _], [_, across]) = (patch.directions, patch.curvatures);
        for angle in CONE_ANGLES {
            let reach = across / angle.cos();
            receiver(Anchored::from_tangents(Kind::Cone, patch.foot, patch.normal, along, reach, angle, 0.0))?;
        }
    }
    let (point, spread) = spread(sample.points);
    for direction in spread.vectors {
        receiver(sample.cone_around(Axis { point, direction }))?;
    }
    Continue(())
}

fn tori(sample: &Sample, receiver: &mut impl Receiver) -> ControlFlow<()> {
    receiver(kinematic(sample.oriented, sample.normals).and_then(|axis| sample.torus_around(axis)))?;
    if let Some(patch) = sample.paraboloid() {
        for angle in TORUS_ANGLES {
            for (profile, across) in [(0, 1), (1, 0)] {
                let (t, bend, reach) =
                    (patch.directions[profile], patch.curvatures[profile], patch.curvatures[across] / angle.cos());
                receiver(Anchored::from_tangents(Kind::Torus, patch.foot, patch.normal, t, reach, angle, bend))?;
            }
        }
    }
    let (point, spread) = spread(sample.points);
    for direction in spread.vectors {
        receiver(sample.torus_around(Axis { point, direction }))?;
    }
    Continue(())
}

impl Sample<'_> {
    /// The plane of least squares, its normal on the side of the given normals.
    fn plane(&self) -> Option<Anchored> {
        let (mean, spread) = spread(self.points);
        let normal = spread.vectors[0];
        let side = if self.normals.iter().sum::<DVec3>().dot(normal) < 0.0 { -1.0 } else { 1.0 };
        // Of collinear points no plane is better than the others.
        let determined = spread.values[1] > f64::EPSILON * f64::EPSILON * spread.values[2].max(1.0);
        determined.then(|| Anchored::isotropic(Kind::Plane, mean, normal * side, 0.0))?
    }

    /// Least Σ (|p − c|² − r²)²: linear in the centre c and in r² − |c|².
    fn algebraic_sphere(&self) -> Option<Anchored> {
        let (mean, _) = spread(self.points);
        let (mut matrix, mut rhs) = ([[0.0; 4]; 4], [0.0; 4]);
        for d in self.points.iter().map(|p| *p - mean) {
            let row = [2.0 * d.x, 2.0 * d.y, 2.0 * d.z, 1.0];
            for i in 0..4 {
                (0..4).for_each(|j| matrix[i][j] += row[i] * row[j]);
                rhs[i] += row[i] * d.length_squared();
            }
        }
        let [x, y, z, rest] = solve_cholesky(&matrix, &rhs)?;
        let offset = DVec3::new(x, y, z);
        let sphere = Primitive::Sphere { center: mean + offset, radius: (rest + offset.length_squared()).sqrt() };
        Anchored::of(&sphere, central(self.points)?)
    }

    /// The cylinder of an axis direction through the projected points.
    fn cylinder_along(&self, axis: DVec3) -> Option<Anchored> {
        let u = axis.any_orthonormal_vector();
        let v = axis.cross(u);
        let (centre, radius) = circle(self.points.iter().map(|p| DVec2::new(p.dot(u), p.dot(v))))?;
        let cylinder = Primitive::Cylinder { origin: u * centre.x + v * centre.y, axis, radius };
        Anchored::of(&cylinder, central(self.points)?)
    }

    /// The cone of an axis through the profile points.
    fn cone_around(&self, axis: Axis) -> Option<Anchored> {
        let profile = self.points.iter().map(|p| profile_point(*p - axis.point, axis.direction));
        let (middle, along) = line(profile)?;
        // t = −e sin φ + a cos φ
        let tilt = if along.y < 0.0 { DVec2::new(-along.y, along.x) } else { DVec2::new(along.y, -along.x) };
        let radial = self.radial_of_farthest(axis);
        let foot = axis.point + radial * middle.x + axis.direction * middle.y;
        Anchored::new(Kind::Cone, foot, radial, axis.direction, middle.x.recip(), tilt, 0.0)
    }

    /// The torus of an axis through the profile points.
    fn torus_around(&self, Axis { point, direction: axis }: Axis) -> Option<Anchored> {
        let (centre, minor_radius) = circle(self.points.iter().map(|p| profile_point(*p - point, axis)))?;
        let (center, major_radius) = (point + axis * centre.y, centre.x);
        let sound = major_radius > 0.0;
        let torus = Primitive::Torus { center, axis, major_radius, minor_radius };
        sound.then(|| Anchored::of(&torus, self.farthest(Axis { point, direction: axis })))?
    }

    fn paraboloid(&self) -> Option<Paraboloid> {
        let mean = self.normals.iter().sum::<DVec3>() / self.normals.len().max(1) as f64;
        Paraboloid::through(self.points, mean)
    }

    /// The direction orthogonal to two normals that differ most from each other, or nearly so: the one most different from
    /// the first, and the one most different from that.
    fn crossing_normals(&self) -> Option<DVec3> {
        let across = |n: DVec3| {
            let sine = |m: &DVec3| m.cross(n).length_squared();
            self.normals.iter().copied().max_by(|a, b| sine(a).total_cmp(&sine(b)))
        };
        let one = across(*self.normals.first()?)?;
        across(one)?.cross(one).try_normalize()
    }

    fn farthest(&self, axis: Axis) -> DVec3 {
        let from_axis = |p: &DVec3| profile_point(*p - axis.point, axis.direction).x;
        self.points.iter().copied().max_by(|a, b| from_axis(a).total_cmp(&from_axis(b))).unwrap_or_default()
    }

    fn radial_of_farthest(&self, axis: Axis) -> DVec3 {
        let offset = self.farthest(axis) - axis.point;
        (offset - axis.direction * offset.dot(axis.direction)).normalize_or_zero()
    }
}
