//! Triangles of one face, in the parameter plane of its surface.

use super::chart::Chart;
use super::{Fineness, refine};
use crate::brep::boundary::{EdgeSamples, Ring, unroll};
use crate::brep::{Brep, Face, Surface};
use crate::error::{Error, Result};
use glam::{DVec2, DVec3};
use spade::handles::FixedVertexHandle;
use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation};
use std::collections::VecDeque;
use std::f64::consts::{FRAC_PI_2, TAU};

/// What became of one face. Ids below the number of shared points are those of [`EdgeSamples`], others count `inner`.
#[derive(Debug, Default)]
pub(super) struct FaceTriangles {
    pub inner: Vec<DVec3>,
    pub triangles: Vec<[u32; 3]>,
    pub places: Vec<[DVec2; 3]>,
    pub crossed: bool,
}

/// Coordinates below this are none: spade refuses what is below 2^−142.
const SMALLEST: f64 = 1e-40;

/// The triangulation of the parameter plane under construction.
pub(super) struct Plane<'a> {
    pub surface: &'a Surface,
    pub chart: Chart,
    pub cdt: ConstrainedDelaunayTriangulation<Point2<f64>>,
    /// By vertex of the triangulation.
    pub ids: Vec<u32>,
    pub inner: Vec<DVec3>,
    /// Number of shared points: the id of the first inner one.
    pub shared: u32,
}

/// Triangulates one face.
pub(super) fn triangulate(
    brep: &Brep,
    f: usize,
    samples: &[EdgeSamples],
    fineness: &Fineness,
) -> Result<FaceTriangles> {
    let face = &brep.faces[f];
    let surface = brep.surface(face);
    let inner_samples: usize = samples.iter().map(|s| s.points.len() - 2).sum();
    let shared = (brep.vertices.len() + inner_samples) as u32;
    let mut plane = Plane {
        surface,
        chart: Chart::Stretched(DVec2::ONE),
        cdt: ConstrainedDelaunayTriangulation::new(),
        ids: Vec::new(),
        inner: Vec::new(),
        shared,
    };
    let rings = if face.loops.is_empty() {
        match whole_sphere(brep, face, fineness, &mut plane) {
            Some(ring) => vec![ring],
            None => return Ok(FaceTriangles { crossed: true, ..Default::default() }),
        }
    } else {
        unroll(brep, face, samples)
    };
    let open = |ring: &Ring| {
        let size = ring.samples.iter().map(|s| s.uv.abs().max_element()).fold(1e-3, f64::max);
        ring.gap().length() > 1e-6 * size || ring.samples.len() < 3
    };
    if rings.iter().any(open) || rings.iter().flat_map(|r| &r.samples).any(|s| !s.uv.is_finite()) {
        return Ok(FaceTriangles { crossed: true, ..Default::default() });
    }
    plane.chart = Chart::new(surface, &rings);
    let mut crossed = false;
    for ring in &rings {
        crossed |= !plane.constrain(ring, fineness)?;
    }
    refine::fill(&mut plane, &rings, fineness)?;
    let (triangles, places) = plane.triangles(face.same_sense);
    crossed |= triangles.is_empty();
    Ok(FaceTriangles { inner: plane.inner, triangles, places, crossed })
}

/// The border of a whole sphere's parameters: up one side of a seam of its own, down the other.
fn whole_sphere(brep: &Brep, face: &Face, fineness: &Fineness, plane: &mut Plane) -> Option<Ring> {
    let (Surface::Sphere { radius, .. }, Some(&pole)) = (plane.surface, face.poles.first()) else { return None };
    let step = refine::arc_step(1.0 / radius, fineness) / radius;
    let n = ((2.0 * FRAC_PI_2 / step).ceil() as usize).max(3);
    let v = |k: usize| -FRAC_PI_2 + 2.0 * FRAC_PI_2 * k as f64 / n as f64;
    // The pole with a vertex is the one nearest to it.
    let at_top = plane.surface.project(brep.point(pole))[1] > 0.0;
    let other = plane.add(plane.surface.point(0.0, if at_top { -FRAC_PI_2 } else { FRAC_PI_2 }));
    let [south, north] = if at_top { [other, pole] } else { [pole, other] };
    let mut ids = vec![south];
    for k in 1..n {
        ids.push(plane.add(plane.surface.point(0.0, v(k))));
    }
    ids.push(north);
    let sample = |u: f64, k: usize| crate::brep::boundary::Sample {
        uv: DVec2::new(u, v(k)),
        id: ids[k],
        edge: u32::MAX,
        span: [0.0; 2],
    };
    let up = (0..=n).map(|k| sample(TAU, k));
    let down = (0..=n).rev().map(|k| sample(0.0, k));
    Some(Ring { samples: up.chain(down).chain([sample(TAU, 0)]).collect() })
}

impl Plane<'_> {
    /// A new inner point; returns its id.
    pub fn add(&mut self, p: DVec3) -> u32 {
        self.inner.push(p);
        self.shared + self.inner.len() as u32 - 1
    }

    /// The vertex at a place of the parameter plane; a new one gets the id that `id` makes.
    pub fn insert(&mut self, uv: DVec2, id: impl FnOnce(&mut Self) -> u32) -> Result<FixedVertexHandle> {
        let at = self.chart.place(uv);
        // Smaller numbers are refused, because their products are out of range.
        let clean = |x: f64| if x.abs() < SMALLEST { 0.0 } else { x };
        let handle = self
            .cdt
            .insert(Point2::new(clean(at.x), clean(at.y)))
            .map_err(|e| Error::Numeric(format!("a face cannot be triangulated: {e}")))?;
        if handle.index() == self.ids.len() {
            let id = id(self);
            self.ids.push(id);
        }
        Ok(handle)
    }

    /// Parameters of a place; those of a pole have the u of `beside`.
    pub fn uv(&self, p: DVec2, beside: DVec2) -> DVec2 {
        let uv = self.chart.parameters(p);
        if self.chart.is_pole(p) { DVec2::new(self.chart.parameters(beside).x, uv.y) } else { uv }
    }

    /// Inserts a loop; false where it crosses itself or another.
    fn constrain(&mut self, ring: &Ring, fineness: &Fineness) -> Result<bool> {
        let mut simple = true;
        let mut last: Option<FixedVertexHandle> = None;
        let mut before = ring.samples[0];
        let mut place: Vec<(DVec2, u32)> = Vec::with_capacity(ring.samples.len());
        for (k, s) in ring.samples.iter().enumerate() {
            // A piece of a pole is divided, so that triangles fan out from it.
            let turn = (s.uv.x - before.uv.x).abs();
            if k > 0 && s.id == before.id && turn > fineness.angle {
                let n = (turn / fineness.angle).ceil() as usize;
                place.extend((1..n).map(|j| (before.uv.lerp(s.uv, j as f64 / n as f64), s.id)));
            }
            // The end is the beginning, to the bit.
            let uv = if k + 1 == ring.samples.len() { ring.samples[0].uv } else { s.uv };
            place.push((uv, s.id));
            before = *s;
        }
        for (uv, id) in place {
            let handle = self.insert(uv, |_| id)?;
            if let Some(from) = last.filter(|&from| from != handle) {
                simple &= self.cdt.can_add_constraint(from, handle);
                if self.cdt.try_add_constraint(from, handle).is_empty() {
                    simple &= self.cdt.exists_constraint(from, handle);
                }
            }
            last = Some(handle);
        }
        Ok(simple)
    }

    /// Triangles inside the loops; those that a pole has made flat are left out.
    fn triangles(&self, same_sense: bool) -> (Vec<[u32; 3]>, Vec<[DVec2; 3]>) {
        let inside = self.inside();
        let (mut out, mut places) = (Vec::new(), Vec::new());
        for face in self.cdt.inner_faces().filter(|f| inside[f.fix().index()]) {
            let [a, b, c] = face.vertices().map(|v| self.ids[v.fix().index()]);
            if a != b && b != c && c != a {
                let at = face.vertices().map(|v| DVec2::new(v.position().x, v.position().y));
                let middle = (at[0] + at[1] + at[2]) / 3.0;
                let [p, q, r] = at.map(|p| self.uv(p, middle));
                out.push(if same_sense { [a, b, c] } else { [a, c, b] });
                places.push(if same_sense { [p, q, r] } else { [p, r, q] });
            }
        }
        (out, places)
    }

    /// For every face of the triangulation, whether an odd number of constraints separates it from the outside.
    pub fn inside(&self) -> Vec<bool> {
        let cdt = &self.cdt;
        let mut inside: Vec<Option<bool>> = vec![None; cdt.num_all_faces()];
        inside[cdt.outer_face().fix().index()] = Some(false);
        let mut queue = VecDeque::new();
        let mut cross =
            |edge: spade::handles::DirectedEdgeHandle<'_, _, _, _, _>, here: bool, queue: &mut VecDeque<_>| {
                let beyond = edge.rev().face().fix();
                let slot = &mut inside[beyond.index()];
                if slot.is_none() {
                    *slot = Some(here != edge.is_constraint_edge());
                    queue.push_back((beyond, here != edge.is_constraint_edge()));
                }
            };
        cdt.convex_hull().for_each(|e| cross(e, false, &mut queue));
        while let Some((face, here)) = queue.pop_front() {
            if let Some(face) = cdt.face(face).as_inner() {
                face.adjacent_edges().into_iter().for_each(|e| cross(e, here, &mut queue));
            }
        }
        inside.into_iter().map(|i| i == Some(true)).collect()
    }
}
