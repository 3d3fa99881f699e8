//! Flat regions: connected triangles in one plane, grown from the largest triangle.
//!
//! A triangle joins when its corners are as near to the plane of the region so far as the numbers of the file can tell, and
//! its normal does not turn away. Regions never cross labels (bodies, materials, colours), so each is one face to be.

use crate::context::Context;
use crate::error::Result;
use crate::mesh::{FaceId, NONE, SurfaceMesh, Triangles, VertexId};
use glam::DVec3;

/// How far vertices may be off a plane, as a share of the mean edge: between facets of a curved surface the angle is larger.
const FLAT_SHARE: f64 = 1e-4;
/// The same as a share of the diagonal: readers find the borders of faces again within this.
const FARTHEST_SHARE: f64 = 1e-6;
/// The same as a share of volume through area of a closed surface: planes that all err to one side change the volume by this share.
const THIN: f64 = 1e-5;
/// Coordinates of single precision are exact to this share of the largest one.
const SINGLE: f64 = 2.4e-7;
/// Largest angle between the normals of a triangle and its region, by its cosine (20°), unless rounding explains it.
const TURN: f64 = 0.94;
/// Width over that of a neighbour from which on a region is a lid beside it.
const LID: f64 = 2.0;

/// Which triangles lie in a plane with neighbours.
pub struct Flats {
    /// The region of every triangle; [`NONE`] for those that are alone.
    pub of: Vec<u32>,
    /// Unit normal of every region.
    pub normals: Vec<DVec3>,
    /// How far vertices may be off their plane.
    pub flatness: f64,
}

/// A plane under construction.
#[derive(Clone, Copy, Default)]
struct Plane {
    /// Twice the sum of the area vectors.
    vector: DVec3,
    /// Sum of the areas times the centroids, and of the areas.
    moment: DVec3,
    area: f64,
}

impl Plane {
    fn add(&mut self, corners: [DVec3; 3]) {
        let vector = area_vector(corners);
        let area = vector.length();
        self.vector += vector;
        self.moment += area * (corners[0] + corners[1] + corners[2]) / 3.0;
        self.area += area;
    }

    fn normal(&self) -> DVec3 {
        self.vector.normalize_or_zero()
    }

    fn off(&self, p: DVec3) -> f64 {
        ((p - self.moment / self.area).dot(self.normal())).abs()
    }
}

impl Flats {
    /// Finds the regions of two and more triangles; `labels` has one value per triangle, or none at all.
    pub fn new(mesh: &SurfaceMesh, labels: &[u32], ctx: &Context) -> Result<Self> {
        let mut flats = Flats { of: vec![NONE; mesh.face_count()], normals: Vec::new(), flatness: flatness(mesh) };
        let Some(triangles) = Triangles::of(mesh) else { return Ok(flats) };
        let corners = |t: u32| triangles.triangle(t).map(|v| triangles.points()[v as usize]);
        let areas: Vec<f64> = (0..triangles.len() as u32).map(|t| area_vector(corners(t)).length()).collect();
        let mut order: Vec<u32> = (0..triangles.len() as u32).filter(|&t| areas[t as usize] > 0.0).collect();
        order.sort_unstable_by(|&a, &b| areas[b as usize].total_cmp(&areas[a as usize]).then(a.cmp(&b)));
        let mut grower = Grower { triangles, labels, flatness: flats.flatness, region: Vec::new() };
        for (k, &seed) in order.iter().enumerate() {
            ctx.check_every(k)?;
            if flats.of[seed as usize] != NONE {
                continue;
            }
            let id = flats.normals.len() as u32;
            let normal = grower.grow(seed, id, &mut flats.of);
            if grower.region.len() > 1 {
                flats.normals.push(normal);
            } else {
                flats.of[seed as usize] = NONE;
            }
        }
        Ok(flats)
    }

    /// Edges between a wide flat region and what is narrower beside it, and between labels: where patches ought to end, so
    /// that the wide one is a face of its own. Facets of a curved surface are as wide as their neighbours.
    pub fn borders(&self, mesh: &SurfaceMesh, labels: &[u32]) -> Vec<[VertexId; 2]> {
        let Some(triangles) = Triangles::of(mesh) else { return Vec::new() };
        let other = |c: u32| triangles.opposite(c);
        // Of regions, then of triangles: area, length of the border.
        let n = self.normals.len();
        let owner = |t: u32| if self.of[t as usize] == NONE { n + t as usize } else { self.of[t as usize] as usize };
        let mut size = vec![[0.0f64; 2]; n + triangles.len()];
        for t in 0..triangles.len() as u32 {
            let own = owner(t);
            size[own][0] += area_vector(triangles.triangle(t).map(|v| triangles.points()[v as usize])).length();
            for c in 3 * t..3 * t + 3 {
                if other(c) == NONE || owner(other(c) / 3) != own {
                    size[own][1] += triangles.point(c).distance(triangles.point(triangles.next(c)));
                }
            }
        }
        let width = |k: usize| if size[k][1] > 0.0 { size[k][0] / size[k][1] } else { f64::INFINITY };
        let mut out = Vec::new();
        for c in (0..3 * triangles.len() as u32).filter(|&c| other(c) != NONE) {
            let (a, b) = (owner(c / 3), owner(other(c) / 3));
            let label = |c: u32| labels.get((c / 3) as usize);
            // Once, from the side of the lid.
            let lid = a != b && a < n && width(a) > LID * width(b);
            if lid || c < other(c) && label(c) != label(other(c)) {
                out.push([triangles.vertex(c), triangles.vertex(triangles.next(c))].map(VertexId));
            }
        }
        out
    }

    /// Takes triangles out of their regions.
    pub fn release(&mut self, triangles: impl IntoIterator<Item = FaceId>) {
        triangles.into_iter().for_each(|t| self.of[t.index()] = NONE);
    }
}

struct Grower<'a> {
    triangles: Triangles<'a>,
    labels: &'a [u32],
    flatness: f64,
    /// The triangles of the region under construction.
    region: Vec<u32>,
}

impl Grower<'_> {
    fn corners(&self, t: u32) -> [DVec3; 3] {
        self.triangles.triangle(t).map(|v| self.triangles.points()[v as usize])
    }

    /// Grows a region from a triangle and marks it; what is off the plane of all is let go again.
    fn grow(&mut self, seed: u32, id: u32, of: &mut [u32]) -> DVec3 {
        let mut plane = Plane::default();
        self.region.clear();
        self.region.push(seed);
        of[seed as usize] = id;
        plane.add(self.corners(seed));
        let mut next = 0;
        while next < self.region.len() {
            let t = self.region[next];
            next += 1;
            for c in 3 * t..3 * t + 3 {
                let o = self.triangles.opposite(c);
                if o != NONE && of[(o / 3) as usize] == NONE && self.joins(t, o / 3, &plane, 1.0) {
                    of[(o / 3) as usize] = id;
                    plane.add(self.corners(o / 3));
                    self.region.push(o / 3);
                }
            }
        }
        let all = std::mem::take(&mut self.region);
        let fits: Vec<bool> = all.iter().map(|&t| self.joins(seed, t, &plane, 2.0)).collect();
        for (&t, fits) in all.iter().zip(fits) {
            if fits || t == seed { self.region.push(t) } else { of[t as usize] = NONE }
        }
        plane.normal()
    }

    /// Whether a triangle lies in the plane, within a multiple of the flatness.
    fn joins(&self, from: u32, t: u32, plane: &Plane, slack: f64) -> bool {
        if self.labels.get(from as usize) != self.labels.get(t as usize) {
            return false;
        }
        let corners = self.corners(t);
        if corners.iter().any(|&p| plane.off(p) > slack * self.flatness) {
            return false;
        }
        let vector = area_vector(corners);
        let longest = (0..3).map(|k| corners[k].distance(corners[(k + 1) % 3])).fold(0.0, f64::max);
        let rounded = vector.length() <= 4.0 * self.flatness * longest;
        rounded || vector.dot(plane.normal()) > TURN * vector.length()
    }
}

/// Twice the area vector.
fn area_vector([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a)
}

/// How far vertices may be off a plane that they lie in.
fn flatness(mesh: &SurfaceMesh) -> f64 {
    let diagonal = mesh.diagonal();
    let largest = mesh.points().iter().map(|p| p.abs().max_element()).filter(|x| x.is_finite()).fold(0.0, f64::max);
    let (mut sum, mut count) = (0.0, 0.0);
    for face in mesh.faces().iter() {
        for (k, &a) in face.iter().enumerate() {
            sum += mesh.points()[a as usize].distance(mesh.points()[face[(k + 1) % face.len()] as usize]);
            count += 1.0;
        }
    }
    let mean = if count > 0.0 { sum / count } else { 0.0 };
    (FLAT_SHARE * mean)
        .min(THIN * thickness(mesh))
        .max(SINGLE * largest)
        .clamp(1e-9 * diagonal, FARTHEST_SHARE * diagonal)
}

/// Volume through area of a closed surface, without limit for an open one.
fn thickness(mesh: &SurfaceMesh) -> f64 {
    let Some(triangles) = Triangles::of(mesh) else { return f64::INFINITY };
    if (0..3 * triangles.len() as u32).any(|c| triangles.opposite(c) == NONE) {
        return f64::INFINITY;
    }
    let origin = mesh.points().first().copied().unwrap_or_default();
    let [volume, area] = (0..triangles.len() as u32).fold([0.0; 2], |[volume, area], t| {
        let corners = triangles.triangle(t).map(|v| triangles.points()[v as usize]);
        let vector = area_vector(corners);
        [volume + vector.dot(corners[0] - origin) / 3.0, area + vector.length()]
    });
    if area > 0.0 { volume.abs() / area } else { 0.0 }
}
