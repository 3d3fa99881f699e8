//! Models made by hand, with every kind of surface and curve, and their volumes.

#![allow(clippy::unwrap_used)] // only tests use these

use super::*;
use crate::geometry::bspline::{BSplineCurve, BSplineSurface, Knots};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// A model under construction.
#[derive(Default)]
pub(crate) struct Maker {
    pub brep: Brep,
}

impl Maker {
    pub fn vertex(&mut self, x: f64, y: f64, z: f64) -> u32 {
        self.brep.vertices.push(Vertex::exact(DVec3::new(x, y, z)));
        self.brep.vertices.len() as u32 - 1
    }

    pub fn edge(&mut self, curve: Curve, range: [f64; 2], ends: [u32; 2]) -> u32 {
        self.brep.edges.push(Edge { curve, range, ends, tolerance: 0.0 });
        self.brep.edges.len() as u32 - 1
    }

    pub fn line(&mut self, a: u32, b: u32) -> u32 {
        let (curve, range) = Curve::segment(self.brep.point(a), self.brep.point(b));
        self.edge(curve, range, [a, b])
    }

    /// A whole circle about a vertical axis, counter-clockwise seen from above, from a vertex on it.
    pub fn ring(&mut self, center: DVec3, at: u32) -> u32 {
        let offset = self.brep.point(at) - center;
        let frame = Frame::new(center, DVec3::Z, offset);
        self.edge(Curve::Circle { frame, radius: offset.length() }, [0.0, TAU], [at, at])
    }

    /// A face by the uses of edges: `k` forwards, `!k` backwards.
    pub fn face(&mut self, surface: Surface, same_sense: bool, loops: &[&[i32]]) -> u32 {
        let of = |&k: &i32| if k < 0 { EdgeUse::new(!k as u32, true) } else { EdgeUse::new(k as u32, false) };
        let loops = loops.iter().map(|l| l.iter().map(of).collect()).collect();
        self.brep.surfaces.push(surface);
        let face = Face { same_sense, ..Face::new(self.brep.surfaces.len() as u32 - 1, loops) };
        self.brep.faces.push(face);
        self.brep.faces.len() as u32 - 1
    }

    pub fn plane(&mut self, origin: DVec3, normal: DVec3, loops: &[&[i32]]) -> u32 {
        self.face(Surface::Plane { frame: Frame::along(origin, normal) }, true, loops)
    }

    /// All faces as one solid.
    pub fn solid(mut self) -> Brep {
        let faces = (0..self.brep.faces.len() as u32).collect();
        self.brep.shells.push(Shell { faces, closed: true, name: String::new() });
        self.brep.solids.push(Solid { name: "body".into(), ..Default::default() });
        let names: Vec<String> = self
            .brep
            .faces
            .iter()
            .enumerate()
            .map(|(k, f)| format!("{}_{k}", self.brep.surface(f).kind().name()))
            .collect();
        for (face, name) in self.brep.faces.iter_mut().zip(names) {
            face.name = name;
            face.color = Some([200, 60, 30]);
        }
        self.brep.check().unwrap();
        self.brep
    }
}

/// The frame at the origin with this axis.
fn upright(origin: DVec3) -> Frame {
    Frame { origin, z: DVec3::Z, x: DVec3::X }
}

/// Every model with its name and volume.
pub(crate) fn all() -> Vec<(&'static str, Brep, f64)> {
    vec![
        ("box", block(0.0), 24.0),
        ("bored", block(0.5), 24.0 - PI),
        ("cone", cone(), 2.0 * PI / 3.0),
        ("sphere", sphere(), 4.0 * PI / 3.0),
        ("cap", cap(), PI * 0.49 * (3.0 - 0.7) / 3.0),
        ("zone", zone(), PI * (0.8 - 2.0 * 0.064 / 3.0)),
        ("torus", torus(), 2.0 * PI * PI * 2.0 * 0.25),
        ("rounded", rounded(), rounded_volume()),
        ("oblique", oblique(), 2.0 * PI),
        ("hyperbola", hyperbola(), hyperbola_volume()),
        ("parabola", parabola(), parabola_volume()),
        ("extrusion", extrusion(), 1.0 * 2.0),
        ("vase", vase(), vase_volume()),
        ("drilled", drilled(), drilled_volume()),
        ("pillow", pillow(), pillow_volume()),
    ]
}

/// A box of 2 × 3 × 4 with a vertical hole of this radius through its middle.
pub(crate) fn block(hole: f64) -> Brep {
    let mut m = Maker::default();
    let v: Vec<u32> = (0..8)
        .map(|k| m.vertex(f64::from(k & 1) * 2.0 - 1.0, f64::from(k >> 1 & 1) * 3.0 - 1.5, f64::from(k >> 2) * 4.0))
        .collect();
    let e = |m: &mut Maker, a: usize, b: usize| m.line(v[a], v[b]) as i32;
    let bottom = [e(&mut m, 0, 1), e(&mut m, 1, 3), e(&mut m, 3, 2), e(&mut m, 2, 0)];
    let top = [e(&mut m, 4, 5), e(&mut m, 5, 7), e(&mut m, 7, 6), e(&mut m, 6, 4)];
    let up = [e(&mut m, 0, 4), e(&mut m, 1, 5), e(&mut m, 3, 7), e(&mut m, 2, 6)];
    let high = DVec3::new(0.0, 0.0, 4.0);
    let rings = (hole > 0.0).then(|| {
        let [a, b] = [0.0, 4.0].map(|z| m.vertex(hole, 0.0, z));
        let rings = [m.ring(DVec3::ZERO, a) as i32, m.ring(high, b) as i32];
        let seam = m.line(a, b) as i32;
        let surface = Surface::Cylinder { frame: upright(DVec3::ZERO), radius: hole };
        m.face(surface, false, &[&[!rings[0], seam, rings[1], !seam]]);
        rings
    });
    let outer_bottom = [!bottom[3], !bottom[2], !bottom[1], !bottom[0]];
    match rings {
        Some([a, b]) => {
            m.plane(DVec3::ZERO, -DVec3::Z, &[&outer_bottom, &[a]]);
            m.plane(high, DVec3::Z, &[&top, &[!b]]);
        }
        None => {
            m.plane(DVec3::ZERO, -DVec3::Z, &[&outer_bottom]);
            m.plane(high, DVec3::Z, &[&top]);
        }
    }
    for k in 0..4 {
        let normal = [-DVec3::Y, DVec3::X, DVec3::Y, -DVec3::X][k];
        let origin = normal * [1.5, 1.0, 1.5, 1.0][k];
        m.plane(origin, normal, &[&[bottom[k], up[(k + 1) % 4], !top[k], !up[k]]]);
    }
    m.solid()
}

/// The lateral surface of the cone of height 2 over the unit circle.
fn steep_cone() -> Surface {
    let frame = Frame { origin: DVec3::new(0.0, 0.0, 2.0), z: -DVec3::Z, x: DVec3::X };
    Surface::Cone { frame, radius: 0.0, half_angle: 0.5f64.atan() }
}

fn cone() -> Brep {
    let mut m = Maker::default();
    let (a, tip) = (m.vertex(1.0, 0.0, 0.0), m.vertex(0.0, 0.0, 2.0));
    let ring = m.ring(DVec3::ZERO, a) as i32;
    let seam = m.line(a, tip) as i32;
    m.face(steep_cone(), true, &[&[ring, seam, !seam]]);
    m.plane(DVec3::ZERO, -DVec3::Z, &[&[!ring]]);
    m.solid()
}

pub(crate) fn sphere() -> Brep {
    let mut m = Maker::default();
    let pole = m.vertex(0.0, 0.0, 1.0);
    let f = m.face(Surface::Sphere { frame: upright(DVec3::ZERO), radius: 1.0 }, true, &[]);
    m.brep.faces[f as usize].poles.push(pole);
    m.solid()
}

/// A meridian of a sphere about the origin at the angle 0, from one latitude to another.
fn meridian(m: &mut Maker, radius: f64, range: [f64; 2], ends: [u32; 2]) -> i32 {
    let frame = Frame { origin: DVec3::ZERO, z: -DVec3::Y, x: DVec3::X };
    m.edge(Curve::Circle { frame, radius }, range, ends) as i32
}

/// The part of the unit ball above z = 0.3.
fn cap() -> Brep {
    let mut m = Maker::default();
    let latitude = 0.3f64.asin();
    let (a, pole) = (m.vertex(latitude.cos(), 0.0, 0.3), m.vertex(0.0, 0.0, 1.0));
    let center = DVec3::new(0.0, 0.0, 0.3);
    let ring = m.ring(center, a) as i32;
    let seam = meridian(&mut m, 1.0, [latitude, FRAC_PI_2], [a, pole]);
    m.face(Surface::Sphere { frame: upright(DVec3::ZERO), radius: 1.0 }, true, &[&[ring, seam, !seam]]);
    m.plane(center, -DVec3::Z, &[&[!ring]]);
    m.solid()
}

/// The part of the unit ball between z = −0.4 and 0.4.
fn zone() -> Brep {
    let mut m = Maker::default();
    let latitude = 0.4f64.asin();
    let [a, b] = [-0.4, 0.4].map(|z| m.vertex(latitude.cos(), 0.0, z));
    let [low, high] = [-0.4, 0.4].map(|z| DVec3::new(0.0, 0.0, z));
    let rings = [m.ring(low, a) as i32, m.ring(high, b) as i32];
    let seam = meridian(&mut m, 1.0, [-latitude, latitude], [a, b]);
    let surface = Surface::Sphere { frame: upright(DVec3::ZERO), radius: 1.0 };
    m.face(surface, true, &[&[rings[0], seam, !rings[1], !seam]]);
    m.plane(low, -DVec3::Z, &[&[!rings[0]]]);
    m.plane(high, DVec3::Z, &[&[rings[1]]]);
    m.solid()
}

pub(crate) fn torus() -> Brep {
    let mut m = Maker::default();
    let a = m.vertex(2.5, 0.0, 0.0);
    let equator = m.ring(DVec3::ZERO, a) as i32;
    let frame = Frame { origin: DVec3::new(2.0, 0.0, 0.0), z: -DVec3::Y, x: DVec3::X };
    let tube = m.edge(Curve::Circle { frame, radius: 0.5 }, [0.0, TAU], [a, a]) as i32;
    let surface = Surface::Torus { frame: upright(DVec3::ZERO), major_radius: 2.0, minor_radius: 0.5 };
    m.face(surface, true, &[&[equator, tube, !equator, !tube]]);
    m.solid()
}

/// A disk of radius 2 and height 1 whose upper rim is rounded with radius 0.3.
fn rounded() -> Brep {
    let mut m = Maker::default();
    let [a, b, c] = [(2.0, 0.0), (2.0, 0.7), (1.7, 1.0)].map(|(x, z)| m.vertex(x, 0.0, z));
    let level = |z: f64| DVec3::new(0.0, 0.0, z);
    let rings = [(0.0, a), (0.7, b), (1.0, c)].map(|(z, v)| m.ring(level(z), v) as i32);
    let wall = m.line(a, b) as i32;
    let frame = Frame { origin: DVec3::new(1.7, 0.0, 0.7), z: -DVec3::Y, x: DVec3::X };
    let arc = m.edge(Curve::Circle { frame, radius: 0.3 }, [0.0, FRAC_PI_2], [b, c]) as i32;
    m.plane(DVec3::ZERO, -DVec3::Z, &[&[!rings[0]]]);
    let cylinder = Surface::Cylinder { frame: upright(DVec3::ZERO), radius: 2.0 };
    m.face(cylinder, true, &[&[rings[0], wall, !rings[1], !wall]]);
    let torus = Surface::Torus { frame: upright(level(0.7)), major_radius: 1.7, minor_radius: 0.3 };
    m.face(torus, true, &[&[rings[1], arc, !rings[2], !arc]]);
    m.plane(level(1.0), DVec3::Z, &[&[rings[2]]]);
    m.solid()
}

fn rounded_volume() -> f64 {
    PI * (4.0 * 0.7 + 1.7 * 1.7 * 0.3 + 2.0 * 1.7 * PI * 0.09 / 4.0 + 2.0 / 3.0 * 0.027)
}

/// The unit cylinder between z = 0 and z = 2 + x / 2.
fn oblique() -> Brep {
    let mut m = Maker::default();
    let (a, b) = (m.vertex(1.0, 0.0, 0.0), m.vertex(1.0, 0.0, 2.5));
    let ring = m.ring(DVec3::ZERO, a) as i32;
    let center = DVec3::new(0.0, 0.0, 2.0);
    let slant = DVec3::new(1.0, 0.0, 0.5);
    let frame = Frame::new(center, DVec3::new(-0.5, 0.0, 1.0), slant);
    let ellipse = m.edge(Curve::Ellipse { frame, radii: [slant.length(), 1.0] }, [0.0, TAU], [b, b]) as i32;
    let seam = m.line(a, b) as i32;
    let cylinder = Surface::Cylinder { frame: upright(DVec3::ZERO), radius: 1.0 };
    m.face(cylinder, true, &[&[ring, seam, !ellipse, !seam]]);
    m.plane(DVec3::ZERO, -DVec3::Z, &[&[!ring]]);
    m.plane(center, frame.z, &[&[ellipse]]);
    m.solid()
}

/// Simpson's rule, for volumes from sections.
fn simpson(a: f64, b: f64, f: impl Fn(f64) -> f64) -> f64 {
    let n = 200_000;
    let h = (b - a) / f64::from(n);
    let weight = |k: u32| {
        if k == 0 || k == n {
            1.0
        } else if k % 2 == 1 {
            4.0
        } else {
            2.0
        }
    };
    (0..=n).map(|k| weight(k) * f(a + h * f64::from(k))).sum::<f64>() * h / 3.0
}

/// The cone of height 2 over the unit circle, cut off at x = 1/2.
fn hyperbola() -> Brep {
    let mut m = Maker::default();
    let half = 0.75f64.sqrt();
    let (a, b) = (m.vertex(0.5, half, 0.0), m.vertex(0.5, -half, 0.0));
    let (c, tip) = (m.vertex(-1.0, 0.0, 0.0), m.vertex(0.0, 0.0, 2.0));
    let circle = Curve::Circle { frame: upright(DVec3::ZERO), radius: 1.0 };
    let (third, two_thirds) = (PI / 3.0, PI * 5.0 / 3.0);
    let arcs = [m.edge(circle.clone(), [third, PI], [a, c]) as i32, m.edge(circle, [PI, two_thirds], [c, b]) as i32];
    let chord = m.line(b, a) as i32;
    // On x = 1/2 the cone is (2 − z)² = 4 (1/4 + y²): a hyperbola that opens downwards with semi-axes 1 and 1/2.
    let frame = Frame { origin: DVec3::new(0.5, 0.0, 2.0), z: DVec3::X, x: -DVec3::Z };
    let t = (half / 0.5).asinh();
    // y of the frame is z × x = X × −Z = Y.
    let branch = m.edge(Curve::Hyperbola { frame, radii: [1.0, 0.5] }, [-t, t], [b, a]) as i32;
    let seam = m.line(c, tip) as i32;
    m.face(steep_cone(), true, &[&[arcs[0], seam, !seam, arcs[1], branch]]);
    m.plane(DVec3::ZERO, -DVec3::Z, &[&[!arcs[1], !arcs[0], !chord]]);
    m.plane(DVec3::new(0.5, 0.0, 0.0), DVec3::X, &[&[!branch, chord]]);
    m.solid()
}

fn hyperbola_volume() -> f64 {
    // At height z the section is a disk of radius r, without the segment beyond x = 1/2.
    let segment = |r: f64| if r > 0.5 { r * r * (0.5 / r).acos() - 0.5 * (r * r - 0.25).sqrt() } else { 0.0 };
    2.0 * PI / 3.0
        - simpson(0.0, 1.0, |s| {
            // s ↦ z with r − 1/2 = s²/2: the root is smooth in s.
            let r = 0.5 + 0.5 * s * s;
            segment(r) * 2.0 * s
        })
}

/// The cone of height 2 over the unit circle, without what is beyond the plane z = 2 (x − 0.2), parallel to a generator.
fn parabola() -> Brep {
    let mut m = Maker::default();
    let half = 0.96f64.sqrt();
    let (a, b) = (m.vertex(0.2, half, 0.0), m.vertex(0.2, -half, 0.0));
    let (c, tip) = (m.vertex(-1.0, 0.0, 0.0), m.vertex(0.0, 0.0, 2.0));
    let angle = half.atan2(0.2);
    let circle = Curve::Circle { frame: upright(DVec3::ZERO), radius: 1.0 };
    let arcs = [m.edge(circle.clone(), [angle, PI], [a, c]) as i32, m.edge(circle, [PI, TAU - angle], [c, b]) as i32];
    let chord = m.line(b, a) as i32;
    // The apex is at (0.6, 0, 0.8); down the plane by l, y² = 4 f l.
    let apex = DVec3::new(0.6, 0.0, 0.8);
    let down = DVec3::new(-1.0, 0.0, -2.0).normalize();
    let length = apex.distance(DVec3::new(0.2, 0.0, 0.0));
    let focal = 0.96 / (4.0 * length);
    let normal = DVec3::new(2.0, 0.0, -1.0).normalize();
    let frame = Frame { origin: apex, z: normal, x: down };
    let t = half / (2.0 * focal);
    let [start, end] = if frame.y().y > 0.0 { [b, a] } else { [a, b] };
    let branch = m.edge(Curve::Parabola { frame, focal }, [-t, t], [start, end]) as i32;
    let (forth, back) = if start == b { (branch, !branch) } else { (!branch, branch) };
    let seam = m.line(c, tip) as i32;
    m.face(steep_cone(), true, &[&[arcs[0], seam, !seam, arcs[1], forth]]);
    m.plane(DVec3::ZERO, -DVec3::Z, &[&[!arcs[1], !arcs[0], !chord]]);
    m.plane(apex, normal, &[&[back, chord]]);
    m.solid()
}

fn parabola_volume() -> f64 {
    // At height z, without the segment beyond x = 0.2 + z / 2, for z up to 0.8.
    let segment = |r: f64, x: f64| {
        let share = (x / r).clamp(-1.0, 1.0);
        r * r * share.acos() - x * (r * r - x * x).max(0.0).sqrt()
    };
    let cut = simpson(0.0, 1.0, |s| {
        let z = 0.8 * (1.0 - s * s);
        segment(1.0 - 0.5 * z, 0.2 + 0.5 * z) * 1.6 * s
    });
    2.0 * PI / 3.0 - cut
}

/// A cubic without inner knots.
fn bezier(points: [DVec3; 4]) -> BSplineCurve {
    BSplineCurve::new(Knots::from_breaks(3, &[0.0, 1.0], 1).unwrap(), points.to_vec()).unwrap()
}

/// Between y = 0 and the arch of a cubic from (−1, 0) to (1, 0) with an area of 1, from z = 0 to 2.
fn extrusion() -> Brep {
    let mut m = Maker::default();
    // Control points (−1, 0), (−1, h), (1, h), (1, 0): the area is 6/5 h … of x' y integrated.
    let h = 1.0 / 1.2;
    let arch = |z: f64| [(-1.0, 0.0), (-1.0, h), (1.0, h), (1.0, 0.0)].map(|(x, y)| DVec3::new(x, y, z));
    let [a, b] = [-1.0, 1.0].map(|x| m.vertex(x, 0.0, 0.0));
    let [c, d] = [-1.0, 1.0].map(|x| m.vertex(x, 0.0, 2.0));
    let low = m.edge(Curve::Spline(bezier(arch(0.0))), [0.0, 1.0], [a, b]) as i32;
    let high = m.edge(Curve::Spline(bezier(arch(2.0))), [0.0, 1.0], [c, d]) as i32;
    let floor = [m.line(a, b) as i32, m.line(c, d) as i32];
    let up = [m.line(a, c) as i32, m.line(b, d) as i32];
    let surface = Surface::Extrusion { profile: Curve::Spline(bezier(arch(0.0))), direction: DVec3::Z };
    // C' × Z points to −y on the way from −1 to 1 … so the surface's normal points inwards.
    m.face(surface, false, &[&[!low, up[0], high, !up[1]]]);
    m.plane(DVec3::ZERO, -DVec3::Y, &[&[floor[0], up[1], !floor[1], !up[0]]]);
    m.plane(DVec3::ZERO, -DVec3::Z, &[&[low, !floor[0]]]);
    m.plane(DVec3::new(0.0, 0.0, 2.0), DVec3::Z, &[&[floor[1], !high]]);
    m.solid()
}

fn vase_profile() -> BSplineCurve {
    bezier([(1.0, 0.0), (1.5, 0.7), (0.5, 1.3), (0.8, 2.0)].map(|(x, z)| DVec3::new(x, 0.0, z)))
}

/// A solid of revolution over a cubic.
fn vase() -> Brep {
    let mut m = Maker::default();
    let [a, b] = [(1.0, 0.0), (0.8, 2.0)].map(|(x, z)| m.vertex(x, 0.0, z));
    let high = DVec3::new(0.0, 0.0, 2.0);
    let rings = [m.ring(DVec3::ZERO, a) as i32, m.ring(high, b) as i32];
    let seam = m.edge(Curve::Spline(vase_profile()), [0.0, 1.0], [a, b]) as i32;
    let surface = Surface::Revolution { profile: Curve::Spline(vase_profile()), frame: upright(DVec3::ZERO) };
    m.face(surface, true, &[&[rings[0], seam, !rings[1], !seam]]);
    m.plane(DVec3::ZERO, -DVec3::Z, &[&[!rings[0]]]);
    m.plane(high, DVec3::Z, &[&[rings[1]]]);
    m.solid()
}

fn vase_volume() -> f64 {
    let profile = vase_profile();
    simpson(0.0, 1.0, |t| {
        let [p, d, _] = profile.derivatives(t);
        PI * p.x * p.x * d.z
    })
}

/// The pieces of a closed curve by Hermite interpolation.
fn hermite(n: u32, point: impl Fn(f64) -> [DVec3; 2]) -> BSplineCurve {
    let h = TAU / f64::from(n);
    let mut points = vec![point(0.0)[0]];
    for k in 0..n {
        let ([p, d], [q, e]) = (point(h * f64::from(k)), point(h * f64::from(k + 1)));
        points.extend([p + h / 3.0 * d, q - h / 3.0 * e, q]);
    }
    let last = points.len() - 1;
    points[last] = points[0];
    let breaks: Vec<f64> = (0..=n).map(|k| h * f64::from(k)).collect();
    BSplineCurve::new(Knots::from_breaks(3, &breaks, 3).unwrap(), points).unwrap()
}

/// Radius of the bore through a ball of radius one.
const BORE: f64 = 0.4;

/// The unit cylinder from z = −2 to 2 with a hole of radius 0.4 along x.
fn drilled() -> Brep {
    let mut m = Maker::default();
    let level = |z: f64| DVec3::new(0.0, 0.0, z);
    let [a, b] = [-2.0, 2.0].map(|z| m.vertex(0.0, -1.0, z));
    let rings = [m.ring(level(-2.0), a) as i32, m.ring(level(2.0), b) as i32];
    let seam = m.line(a, b) as i32;
    // y = r cos t, z = r sin t, x = ± √(1 − y²).
    let mouth = |side: f64| {
        hermite(512, move |t| {
            let (y, z) = (BORE * t.cos(), BORE * t.sin());
            let x = side * (1.0 - y * y).sqrt();
            [DVec3::new(x, y, z), DVec3::new(y * z / x, -z, y)]
        })
    };
    let x = (1.0 - BORE * BORE).sqrt();
    let [p, q] = [1.0, -1.0].map(|side| m.vertex(side * x, BORE, 0.0));
    let mouths = [(1.0, p), (-1.0, q)].map(|(side, v)| {
        let edge = m.edge(Curve::Spline(mouth(side)), [0.0, TAU], [v, v]);
        m.brep.edges[edge as usize].tolerance = 1e-9;
        edge as i32
    });
    let inner = m.line(q, p) as i32;
    let outside = Surface::Cylinder { frame: upright(DVec3::ZERO), radius: 1.0 };
    // Seen from +x, y to the right and z up, the mouth at +x runs counter-clockwise; a hole runs clockwise.
    m.face(outside, true, &[&[rings[0], seam, !rings[1], !seam], &[!mouths[0]], &[mouths[1]]]);
    m.plane(level(-2.0), -DVec3::Z, &[&[!rings[0]]]);
    m.plane(level(2.0), DVec3::Z, &[&[rings[1]]]);
    let frame = Frame { origin: DVec3::ZERO, z: DVec3::X, x: DVec3::Y };
    let bore = Surface::Cylinder { frame, radius: BORE };
    m.face(bore, false, &[&[!mouths[1], inner, mouths[0], !inner]]);
    m.solid()
}

fn drilled_volume() -> f64 {
    // The common part: twice the length to the outer cylinder over the bore's disk, in polar coordinates about the bore.
    let strip = |y: f64| 2.0 * (1.0 - y * y).sqrt() * 2.0 * (BORE * BORE - y * y).max(0.0).sqrt();
    4.0 * PI - simpson(-FRAC_PI_2, FRAC_PI_2, |a| strip(BORE * a.sin()) * BORE * a.cos())
}

/// Under a bicubic surface over the square from −1 to 1, over z = 0; the walls are plane.
fn pillow() -> Brep {
    let mut m = Maker::default();
    let knots = Knots::from_breaks(3, &[-1.0, 1.0], 1).unwrap();
    let third = |k: usize| -1.0 + 2.0 * k as f64 / 3.0;
    let heights = [1.0, 1.2, 0.9, 1.1, 1.3, 2.0, 1.6, 1.0, 0.8, 1.5, 1.9, 1.2, 1.0, 1.1, 1.4, 0.9];
    let points = (0..16).map(|k| DVec3::new(third(k % 4), third(k / 4), heights[k])).collect();
    let surface = BSplineSurface::new(knots.clone(), knots, points).unwrap();
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    let low = corners.map(|(x, y)| m.vertex(x, y, 0.0));
    let high = corners.map(|(x, y)| {
        let p = surface.point(x, y);
        m.vertex(p.x, p.y, p.z)
    });
    let sides = surface.sides().unwrap();
    // Sides run with growing parameters: the third and the fourth against the loop.
    let ends = [[0, 1], [1, 2], [3, 2], [0, 3]];
    let mut top = [0; 4];
    for (k, side) in sides.into_iter().enumerate() {
        let edge = m.edge(Curve::Spline(side), [-1.0, 1.0], ends[k].map(|c| high[c])) as i32;
        top[k] = if k < 2 { edge } else { !edge };
    }
    let bottom = [0, 1, 2, 3].map(|k| m.line(low[k], low[(k + 1) % 4]) as i32);
    let up = [0, 1, 2, 3].map(|k| m.line(low[k], high[k]) as i32);
    m.face(Surface::Spline(surface), true, &[&top]);
    m.plane(DVec3::ZERO, -DVec3::Z, &[&[!bottom[3], !bottom[2], !bottom[1], !bottom[0]]]);
    for k in 0..4 {
        let normal = [-DVec3::Y, DVec3::X, DVec3::Y, -DVec3::X][k];
        m.plane(normal, normal, &[&[bottom[k], up[(k + 1) % 4], !top[k], !up[k]]]);
    }
    m.solid()
}

fn pillow_volume() -> f64 {
    // Bernstein polynomials have the integral 1/4 each: the mean of the heights, times the area.
    let heights = [1.0, 1.2, 0.9, 1.1, 1.3, 2.0, 1.6, 1.0, 0.8, 1.5, 1.9, 1.2, 1.0, 1.1, 1.4, 0.9];
    4.0 * heights.iter().sum::<f64>() / 16.0
}
