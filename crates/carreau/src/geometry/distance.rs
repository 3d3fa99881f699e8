//! Two-sided distance and normal deviation of two surfaces.
//!
//! From each surface to the other: the mean and the root mean square over samples spread evenly by area, and the maximum
//! between two bounds. The lower bound is the largest distance of any sampled point, vertices included, and of what the
//! farthest samples find uphill. The upper bound follows from convexity: the distance to one triangle of the other surface
//! is a convex function, so over a whole triangle it is largest at a corner, and the smallest of these maxima, over a few
//! candidate triangles, bounds the distance of the whole triangle (the culling of Tang, Lee, Kim, "Interactive Hausdorff
//! Distance Computation for General Polygonal Models", SIGGRAPH 2009). Triangles whose bound exceeds the lower bound are
//! divided in four, best first in rounds of fixed size, until the two bounds meet or the budget is spent.

use super::closest::closest_on_triangle;
use super::normals::{angle_between, face_normals};
use super::search_tree::{Closest, TriangleTree};
use super::summary::{Summary, sum};
use crate::bounds::within;
use crate::context::Context;
use crate::error::{Error, Result};
use crate::mesh::{SurfaceMesh, UnitScale, safe_length, triangle_area_vector};
use glam::DVec3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Queries between two looks at the clock.
const QUERIES_PER_CHECK: usize = 1024;
/// Triangles divided in one round.
const TRIANGLES_PER_ROUND: usize = 1024;
/// The bounds have met when they differ by less than this share of the diagonal.
const MET: f64 = 1e-5;
/// Closest points within this share of the diagonal of the true distance count as equally close.
const TIE: f64 = 1e-9;

/// How closely to look.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct DistanceOptions {
    /// Number of samples on each surface, in addition to its vertices.
    pub samples: usize,
    /// Most triangles to divide per direction in order to narrow the bounds of the maximum; 0: none.
    pub refinements: usize,
    /// Whether to compare normals as well.
    pub normals: bool,
}

/// Most samples and refinements: more do not fit into memory.
const MOST_SAMPLES: usize = 100_000_000;

impl DistanceOptions {
    /// Refuses numbers beyond what fits into memory.
    ///
    /// # Errors
    /// [`Error::Options`].
    pub fn validate(&self) -> Result<()> {
        within("samples", self.samples, 0..=MOST_SAMPLES, "")?;
        within("refinements", self.refinements, 0..=MOST_SAMPLES, "")
    }
}

impl Default for DistanceOptions {
    fn default() -> Self {
        DistanceOptions { samples: 200_000, refinements: 100_000, normals: true }
    }
}

/// Distance of two surfaces, in the unit of the files.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Comparison {
    /// Bounding-box diagonal of the first surface, to which shares refer.
    pub diagonal: f64,
    /// Both directions together.
    pub distance: Distance,
    /// The same as shares of the diagonal.
    pub relative: Distance,
    /// Angle between the normals of both surfaces at samples and their closest points, in degrees, both directions
    /// together; `None` where no sample has a normal on both sides.
    pub normal_deg: Option<Summary>,
    /// From the first surface to the second.
    pub a_to_b: OneSided,
    /// From the second surface to the first.
    pub b_to_a: OneSided,
}

/// Mean and maximum of a distance.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Distance {
    /// Mean over the area.
    pub mean: f64,
    /// Root mean square, over the area.
    pub rms: f64,
    /// The same with two standard errors added: as many random samples would hardly give more. Where few places are far
    /// away, that is some percent.
    pub rms_upper: f64,
    /// The largest distance found; the true maximum (the Hausdorff distance) is not smaller.
    pub max: f64,
    /// Upper bound of the true maximum.
    pub max_upper: f64,
}

/// Distance from one surface to another.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OneSided {
    /// Mean and maximum.
    #[serde(flatten)]
    pub distance: Distance,
    /// Where the maximum was found.
    pub max_at: [f64; 3],
    /// Angle between the normals, in degrees.
    pub normal_deg: Option<Summary>,
    /// Number of points that were measured.
    pub points: usize,
}

/// Compares two surfaces. Polygons are taken as fans from their first corner.
///
/// The same for any number of threads; the samples do not depend on the seed.
///
/// # Errors
/// [`Error::Input`] where a surface has no face; [`Error::Cancelled`], [`Error::Deadline`].
pub fn compare(a: &SurfaceMesh, b: &SurfaceMesh, options: &DistanceOptions, context: &Context) -> Result<Comparison> {
    options.validate()?;
    for (mesh, which) in [(a, "first"), (b, "second")] {
        if mesh.faces().is_empty() {
            return Err(Error::input(format!("the {which} surface has no faces: there is no distance to it"), "", ""));
        }
    }
    let scale = UnitScale::of_mesh(a).with(UnitScale::of_mesh(b));
    if let (Some(a), Some(b)) = (scale.mesh(a, &[]), scale.mesh(b, &[])) {
        return Ok(compare(&a, &b, options, context)?.in_scale(scale.back()));
    }
    let _stage = context.stage("compare");
    context.install(|| {
        let (a, b) = (Target::new(a), Target::new(b));
        let (to_b, angles_to_b) = one_sided(&a, &b, options, context)?;
        let (to_a, angles_to_a) = one_sided(&b, &a, options, context)?;
        let distance = to_b.distance.with(to_a.distance);
        Ok(Comparison {
            diagonal: a.diagonal,
            distance,
            relative: distance.over(a.diagonal),
            normal_deg: Summary::of([angles_to_b, angles_to_a].concat()),
            a_to_b: to_b,
            b_to_a: to_a,
        })
    })
}

impl Comparison {
    /// The same for the meshes in another scale; shares stay.
    fn in_scale(mut self, scale: UnitScale) -> Comparison {
        self.diagonal = scale.length(self.diagonal);
        self.distance = self.distance.map(|x| scale.length(x));
        for side in [&mut self.a_to_b, &mut self.b_to_a] {
            side.distance = side.distance.map(|x| scale.length(x));
            side.max_at = side.max_at.map(|x| scale.length(x));
        }
        self
    }
}

impl Distance {
    /// Every figure, changed in the same way.
    fn map(self, change: impl Fn(f64) -> f64) -> Distance {
        Distance {
            mean: change(self.mean),
            rms: change(self.rms),
            rms_upper: change(self.rms_upper),
            max: change(self.max),
            max_upper: change(self.max_upper),
        }
    }

    /// Two directions taken together.
    fn with(self, other: Distance) -> Distance {
        let quadratic = |a: f64, b: f64| ((a * a + b * b) / 2.0).sqrt();
        Distance {
            mean: (self.mean + other.mean) / 2.0,
            rms: quadratic(self.rms, other.rms),
            rms_upper: quadratic(self.rms_upper, other.rms_upper),
            max: self.max.max(other.max),
            max_upper: self.max_upper.max(other.max_upper),
        }
    }

    /// As shares of a length; zero where the length is zero and the distance too.
    fn over(self, length: f64) -> Distance {
        self.map(|x| if x == 0.0 { 0.0 } else { x / length })
    }
}

/// A surface prepared for questions.
struct Target<'a> {
    points: &'a [DVec3],
    /// Vertices of the triangles, neighbours close to each other.
    used: Vec<u32>,
    triangles: Vec<[u32; 3]>,
    /// Normal of every triangle: that of the face it belongs to.
    normals: Vec<DVec3>,
    tree: TriangleTree,
    diagonal: f64,
}

impl<'a> Target<'a> {
    fn new(mesh: &'a SurfaceMesh) -> Self {
        let (triangles, parent) = mesh.faces().fan();
        let of_face = face_normals(mesh);
        let tree = TriangleTree::new(mesh.points(), &triangles);
        let mut is_new = vec![true; mesh.vertex_count()];
        let first = |v: &u32| std::mem::take(&mut is_new[*v as usize]);
        Target {
            points: mesh.points(),
            used: tree.in_order().flat_map(|(t, _)| triangles[t as usize]).filter(first).collect(),
            tree,
            normals: parent.into_iter().map(|f| of_face[f as usize]).collect(),
            triangles,
            diagonal: mesh.diagonal(),
        }
    }

    fn corners(&self, triangle: u32) -> [DVec3; 3] {
        self.triangles[triangle as usize].map(|v| self.points[v as usize])
    }

    /// Twice the area of every triangle.
    fn areas(&self) -> Vec<f64> {
        let area = |t: u32| {
            let [a, b, c] = self.corners(t);
            safe_length(triangle_area_vector(a, b, c))
        };
        (0..self.triangles.len() as u32).map(area).collect()
    }

    /// The closest point, from the answer to the question before: points in a row are near each other, as a rule. The tree
    /// is never empty here.
    fn closest_near(&self, p: DVec3, last: &mut Option<u32>) -> Closest {
        let nothing = Closest { triangle: 0, point: p, distance_squared: f64::INFINITY };
        let found = match last {
            Some(triangle) => self.tree.closest_near(p, self.corners(*triangle)),
            None => self.tree.closest(p),
        };
        let found = found.unwrap_or(nothing);
        *last = Some(found.triangle);
        found
    }

    /// The smallest angle between a normal and those of the equally close triangles: at an edge of this surface any of
    /// its faces may be meant. `None` where there is no normal on either side.
    fn angle_to(&self, normal: DVec3, p: DVec3, closest: &Closest) -> Option<f64> {
        let angle = |triangle: u32| angle_between(normal, self.normals[triangle as usize]);
        if normal == DVec3::ZERO {
            return None;
        }
        let mut best = f64::INFINITY;
        self.tree.within(p, closest.distance() + TIE * self.diagonal, |c| {
            if self.normals[c.triangle as usize] != DVec3::ZERO {
                best = best.min(angle(c.triangle));
            }
        });
        best.is_finite().then_some(best)
    }
}

/// A point on a surface and the triangle it lies on.
#[derive(Clone, Copy)]
struct Sample {
    point: DVec3,
    triangle: u32,
}

/// Everything about one direction; the angles in degrees for the summary of both.
fn one_sided(from: &Target, to: &Target, options: &DistanceOptions, context: &Context) -> Result<(OneSided, Vec<f64>)> {
    let at_vertices = map_chunks(&from.used, context, |&v, last| to.closest_near(from.points[v as usize], last))?;
    let (samples, apart) = spread_samples(from, options.samples);
    let found = map_chunks(&samples, context, |s, last| {
        let closest = to.closest_near(s.point, last);
        let angle = || to.angle_to(from.normals[s.triangle as usize], s.point, &closest);
        (closest.distance(), options.normals.then(angle).flatten())
    })?;

    let mut bracket = Bracket::default();
    at_vertices.iter().zip(&from.used).for_each(|(c, &v)| bracket.see(from.points[v as usize], c.distance()));
    found.iter().zip(&samples).for_each(|(f, s)| bracket.see(s.point, f.0));
    let distances: Vec<f64> = found.iter().map(|f| f.0).collect();
    climb(&mut bracket, &samples, &distances, apart, from, to);
    narrow(&mut bracket, from, to, &at_vertices, options.refinements, context)?;

    let squares: Vec<f64> = distances.iter().map(|d| d * d).collect();
    let count = distances.len().max(1) as f64;
    let square = sum(&squares) / count;
    let deviations: Vec<f64> = squares.iter().map(|s| (s - square).powi(2)).collect();
    let error = sum(&deviations).sqrt() / count;
    let angles: Vec<f64> = found.iter().filter_map(|f| f.1).map(f64::to_degrees).collect();
    let side = OneSided {
        distance: Distance {
            mean: sum(&distances) / count,
            rms: square.sqrt(),
            rms_upper: (square + 2.0 * error).sqrt(),
            max: bracket.lower,
            max_upper: bracket.upper,
        },
        max_at: bracket.at.to_array(),
        normal_deg: Summary::of(angles.clone()),
        points: bracket.points,
    };
    Ok((side, angles))
}

/// The maximum between two bounds.
struct Bracket {
    /// The largest distance seen.
    lower: f64,
    /// Where; the first of several.
    at: DVec3,
    /// Upper bound of the true maximum.
    upper: f64,
    /// Points seen.
    points: usize,
}

impl Default for Bracket {
    fn default() -> Self {
        Bracket { lower: f64::NEG_INFINITY, at: DVec3::ZERO, upper: 0.0, points: 0 }
    }
}

impl Bracket {
    fn see(&mut self, point: DVec3, distance: f64) {
        self.points += 1;
        if distance > self.lower {
            (self.lower, self.at) = (distance, point);
        }
    }
}

/// Samples from which the distance is climbed.
const CLIMBERS: usize = 256;
/// Steps of each. The first is as long as samples are `apart`; where no step leads up, the next is half as long.
const STEPS: usize = 24;
/// A step that raises the distance by a smaller share is none.
const CLIMB: f64 = 1e-3;

/// Raises the lower bound of the maximum: the farthest samples go uphill within their triangles. Dividing triangles begins
/// where bounds are loosest, and on large flat faces above small triangles that is everywhere but at the maximum.
fn climb(bracket: &mut Bracket, samples: &[Sample], distances: &[f64], apart: f64, from: &Target, to: &Target) {
    let mut farthest: Vec<usize> = (0..samples.len()).collect();
    let order = |a: &usize, b: &usize| distances[*b].total_cmp(&distances[*a]).then(a.cmp(b));
    if farthest.len() > CLIMBERS {
        farthest.select_nth_unstable_by(CLIMBERS, order);
        farthest.truncate(CLIMBERS);
    }
    farthest.sort_unstable_by(order);
    let summit = |&k: &usize| {
        let Sample { point: mut top, triangle } = samples[k];
        let (mut height, mut last) = (distances[k], None);
        let corners = from.corners(triangle);
        let (x, y) = from.normals[triangle as usize].any_orthonormal_pair();
        let mut step = apart;
        for _ in 0..STEPS {
            let around = [x, y, -x, -y].map(|way| closest_on_triangle(top + step * way, corners));
            let heights = around.map(|p| to.closest_near(p, &mut last).distance());
            let best = (0..4).fold(0, |best, i| if heights[i] > heights[best] { i } else { best });
            if heights[best] > height * (1.0 + CLIMB) {
                (top, height) = (around[best], heights[best]);
            } else {
                step *= 0.5;
            }
        }
        (top, height)
    };
    let summits: Vec<(DVec3, f64)> = farthest.par_iter().filter(|&&k| distances[k] > 0.0).map(summit).collect();
    summits.into_iter().for_each(|(point, height)| bracket.see(point, height));
}

/// What chunks give, in parallel and in order, looking at the clock between them.
fn of_chunks<T: Sync, R: Send>(items: &[T], context: &Context, of: impl Fn(&[T]) -> R + Sync) -> Result<Vec<R>> {
    let of = |chunk: &[T]| {
        context.check()?;
        Ok(of(chunk))
    };
    items.par_chunks(QUERIES_PER_CHECK).map(of).collect()
}

/// Maps in parallel, in order, looking at the clock between chunks; the items of a chunk hand on something.
fn map_chunks<T: Sync, R: Send, S: Default>(
    items: &[T],
    context: &Context,
    map: impl Fn(&T, &mut S) -> R + Sync,
) -> Result<Vec<R>> {
    let chunks = of_chunks(items, context, |items| {
        let mut handed_on = S::default();
        items.iter().map(|item| map(item, &mut handed_on)).collect::<Vec<R>>()
    })?;
    Ok(chunks.into_iter().flatten().collect())
}

/// Samples spread evenly by area: sample k lies where the running total of the areas reaches (k + ½) / n, so that every
/// triangle gets its share to within one. In the triangle it is placed by the R2 sequence (Roberts 2018, "The
/// Unreasonable Effectiveness of Quasirandom Sequences"), folded from the square. Empty where nothing has an area. Returns how far
/// they are apart, too.
fn spread_samples(surface: &Target, n: usize) -> (Vec<Sample>, f64) {
    // Areas are doubled, and so is their total.
    let areas = surface.areas();
    let total = sum(&areas);
    let mut samples = Vec::with_capacity(if total > 0.0 { n } else { 0 });
    let mut running = 0.0;
    for (triangle, area) in (0u32..).zip(areas) {
        running += area;
        while samples.len() < n && (samples.len() as f64 + 0.5) * total <= running * n as f64 {
            let [a, b, c] = surface.corners(triangle);
            let (u, v) = r2(samples.len());
            let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
            samples.push(Sample { point: a + u * (b - a) + v * (c - a), triangle });
        }
    }
    let apart = (0.5 * total / samples.len() as f64).sqrt();
    (samples, apart)
}

/// Point `k` of the R2 sequence in the unit square; its steps are the powers of the inverse of the plastic number.
fn r2(k: usize) -> (f64, f64) {
    const STEPS: (f64, f64) = (0.754_877_666_246_692_7, 0.569_840_290_998_053_3);
    ((0.5 + k as f64 * STEPS.0).fract(), (0.5 + k as f64 * STEPS.1).fract())
}

/// A part of a triangle, the closest triangles of its corners, and a bound for the distance of all its points.
#[derive(Clone, Copy)]
struct Part {
    corners: [DVec3; 3],
    closest: [u32; 3],
    bound: f64,
}

impl Part {
    /// Bounded by what is known of the corners.
    fn at_corners(corners: [DVec3; 3], closest: [u32; 3], to: &Target) -> Part {
        Part { corners, closest, bound: bound_by(corners, &closest, to) }
    }

    fn centre(&self) -> DVec3 {
        self.corners.iter().sum::<DVec3>() / 3.0
    }

    /// Bounded by the closest triangle of the centre as well; returns the centre's distance too.
    fn with_centre(mut self, to: &Target) -> (Part, f64) {
        let centre = self.centre();
        let closest = to.closest_near(centre, &mut Some(self.closest[0]));
        // The distance changes by no more than the way: a second bound, better for parts far away.
        let reach = self.corners.iter().map(|c| c.distance(centre)).fold(0.0, f64::max);
        let by_centre = bound_by(self.corners, &[closest.triangle], to).min(closest.distance() + reach);
        self.bound = self.bound.min(by_centre);
        (self, closest.distance())
    }

    /// The four quarters, and all points that were looked at.
    ///
    /// ```text
    ///       c
    ///      ╱ ╲
    ///    ca───bc
    ///    ╱ ╲ ╱ ╲
    ///   a───ab──b
    /// ```
    fn quarters(&self, to: &Target) -> ([Part; 4], [(DVec3, f64); 7]) {
        let ([a, b, c], [ka, kb, kc]) = (self.corners, self.closest);
        let middles = [(a + b) / 2.0, (b + c) / 2.0, (c + a) / 2.0];
        let found = middles.map(|m| to.closest_near(m, &mut Some(ka)));
        let ([ab, bc, ca], [kab, kbc, kca]) = (middles, found.map(|f| f.triangle));
        let quarters = [
            ([a, ab, ca], [ka, kab, kca]),
            ([ab, b, bc], [kab, kb, kbc]),
            ([ca, bc, c], [kca, kbc, kc]),
            ([ab, bc, ca], [kab, kbc, kca]),
        ]
        .map(|(corners, closest)| Part::at_corners(corners, closest, to).with_centre(to));
        let middle = |k: usize| (middles[k], found[k].distance());
        let centre = |k: usize| (quarters[k].0.centre(), quarters[k].1);
        let seen = [middle(0), middle(1), middle(2), centre(0), centre(1), centre(2), centre(3)];
        (quarters.map(|(part, _)| Part { bound: part.bound.min(self.bound), ..part }), seen)
    }
}

/// The smallest, over the candidates, of the largest distance of a corner.
fn bound_by(corners: [DVec3; 3], candidates: &[u32], to: &Target) -> f64 {
    let largest = |candidate: u32| {
        let target = to.corners(candidate);
        corners.iter().map(|&c| c.distance_squared(closest_on_triangle(c, target))).fold(0.0, f64::max)
    };
    let is_first = |k: &usize| !candidates[..*k].contains(&candidates[*k]);
    let bounds = (0..candidates.len()).filter(is_first).map(|k| largest(candidates[k]));
    bounds.fold(f64::INFINITY, f64::min).sqrt()
}

/// Raises the lower bound of the maximum and lowers the upper one until they meet or the budget is spent.
fn narrow(
    bracket: &mut Bracket,
    from: &Target,
    to: &Target,
    at_vertices: &[Closest],
    budget: usize,
    context: &Context,
) -> Result<()> {
    let slack = MET * from.diagonal.max(to.diagonal);
    let mut open = first_parts(bracket, from, to, at_vertices, slack, context)?;
    let mut left = budget;
    loop {
        let limit = bracket.lower + slack;
        open.retain(|part| {
            if part.bound <= limit {
                bracket.upper = bracket.upper.max(part.bound);
            }
            part.bound > limit
        });
        if open.is_empty() || left == 0 {
            break;
        }
        // The largest bounds first; the sort is stable, so of equal ones the first.
        open.sort_by(|a, b| b.bound.total_cmp(&a.bound));
        let rest = open.split_off(open.len().min(TRIANGLES_PER_ROUND).min(left));
        left -= open.len();
        let divided = map_chunks(&open, context, |part, ()| part.quarters(to))?;
        open = rest;
        for (parts, seen) in divided {
            seen.iter().for_each(|&(point, distance)| bracket.see(point, distance));
            open.extend(parts);
        }
    }
    bracket.upper = open.iter().map(|part| part.bound).fold(bracket.upper.max(bracket.lower), f64::max);
    Ok(())
}

/// All triangles that what is known of their corners does not settle, bounded by their centres too.
fn first_parts(
    bracket: &mut Bracket,
    from: &Target,
    to: &Target,
    at_vertices: &[Closest],
    slack: f64,
    context: &Context,
) -> Result<Vec<Part>> {
    let mut closest_of = vec![0; from.points.len()];
    from.used.iter().zip(at_vertices).for_each(|(&v, found)| closest_of[v as usize] = found.triangle);
    let limit = bracket.lower + slack;
    // Of most triangles no more than the largest bound is kept: there may be millions.
    let chunks = of_chunks(&from.triangles, context, |triangles| {
        let (mut decided, mut open) = (0.0f64, Vec::new());
        for t in triangles {
            let part = Part::at_corners(t.map(|v| from.points[v as usize]), t.map(|v| closest_of[v as usize]), to);
            if part.bound <= limit {
                decided = decided.max(part.bound);
            } else {
                open.push(part.with_centre(to));
            }
        }
        (decided, open)
    })?;
    let mut parts = Vec::new();
    for (decided, open) in chunks {
        bracket.upper = bracket.upper.max(decided);
        for (part, distance) in open {
            bracket.see(part.centre(), distance);
            parts.push(part);
        }
    }
    Ok(parts)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::test_models::*;
    use proptest::prelude::*;

    fn options() -> DistanceOptions {
        DistanceOptions { samples: 5000, refinements: 20_000, normals: true }
    }

    fn compared(a: &SurfaceMesh, b: &SurfaceMesh) -> Comparison {
        compare(a, b, &options(), &Context::new()).unwrap()
    }

    fn brackets(d: &Distance, truth: f64, tolerance: f64) -> bool {
        d.max <= truth + 1e-12 && truth <= d.max_upper + 1e-12 && d.max_upper - d.max <= tolerance
    }

    #[test]
    fn a_surface_is_at_no_distance_from_itself_however_it_is_cut() {
        let mesh = torus(40, 20);
        let c = compared(&mesh, &mesh);
        assert!(c.distance.max_upper < 1e-9 && c.normal_deg.unwrap().max < 1e-6, "{c:?}");
        let quads = cube(DVec3::ZERO, 2.0);
        let fine = together(&[quads.clone().triangulated().unwrap()]);
        let c = compared(&quads, &fine);
        assert!(c.distance.max_upper < 1e-9 && c.normal_deg.unwrap().max < 1e-6, "{c:?}");
    }

    #[test]
    fn concentric_spheres_are_as_far_apart_as_their_radii() {
        let (inner, outer) = (sphere(4), moved(&sphere(4), |p| 1.25 * p));
        let c = compared(&inner, &outer);
        assert!((c.distance.mean - 0.25).abs() < 0.002 && (c.distance.rms - 0.25).abs() < 0.002);
        assert!((c.distance.rms..0.2525).contains(&c.distance.rms_upper), "{c:?}");
        assert!(c.distance.max <= 0.2501 && c.distance.max_upper - c.distance.max < 1e-4);
        assert!((c.relative.mean - c.distance.mean / c.diagonal).abs() < 1e-15);
        assert!(c.normal_deg.unwrap().p95 < 5.0);
    }

    #[test]
    fn the_maximum_is_found_between_the_vertices() {
        // A square of two triangles and a pyramid over its diagonal's middle, which is a vertex of neither.
        let flat = grid(1);
        let p = [(0., 0., 0.), (1., 0., 0.), (1., 1., 0.), (0., 1., 0.), (0.5, 0.5, 0.3)].map(DVec3::from);
        let roof = triangles(&p, &[[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]]);
        let coarse = DistanceOptions { samples: 10, ..options() };
        let c = compare(&flat, &roof, &coarse, &Context::new()).unwrap();
        // From the middle of the square to the faces of the pyramid.
        let to_roof = 0.3 * 0.5 / f64::hypot(0.3, 0.5);
        assert!(brackets(&c.a_to_b.distance, to_roof, 1e-4), "{c:?}");
        assert!(brackets(&c.b_to_a.distance, 0.3, 1e-4), "{c:?}");
        let at = DVec3::from_array(c.a_to_b.max_at);
        assert!(at.distance(DVec3::new(0.5, 0.5, 0.0)) < 0.02, "{at}");
    }

    #[test]
    fn without_refinement_the_bounds_still_hold() {
        let (a, b) = (sphere(1), sphere(3));
        let exact = compared(&a, &b).distance;
        let rough = compare(&a, &b, &DistanceOptions { samples: 50, refinements: 0, ..options() }, &Context::new())
            .unwrap()
            .distance;
        assert!(rough.max <= exact.max_upper && rough.max_upper >= exact.max);
        assert!(rough.max_upper - rough.max > exact.max_upper - exact.max);
    }

    #[test]
    fn a_missing_part_shows_in_one_direction_only() {
        let whole = grid(8);
        let half = without(&whole, &(64..128).collect::<Vec<_>>());
        let c = compared(&whole, &half);
        assert!(brackets(&c.a_to_b.distance, 4.0, 1e-3), "{c:?}");
        assert!(c.b_to_a.distance.max_upper < 1e-9);
        assert!((c.a_to_b.distance.mean - 1.0).abs() < 0.01);
    }

    #[test]
    fn samples_follow_the_area() {
        let mesh = together(&[moved(&grid(1), |p| p * 3.0), grid(4)]);
        let (samples, _) = spread_samples(&Target::new(&mesh), 10_000);
        let on_first = samples.iter().filter(|s| s.triangle < 2).count();
        assert_eq!(samples.len(), 10_000);
        assert!((on_first as f64 / 10_000.0 - 9.0 / 25.0).abs() < 1e-3);
        let mean = samples.iter().filter(|s| s.triangle < 2).map(|s| s.point).sum::<DVec3>() / on_first as f64;
        assert!(mean.distance(DVec3::new(1.5, 1.5, 0.0)) < 0.02);
    }

    #[test]
    fn inverted_normals_differ_by_a_half_turn() {
        let c = compared(&sphere(2), &turned(&sphere(2), |_| true));
        assert!(c.distance.max < 1e-9 && c.normal_deg.unwrap().p50 > 179.0);
    }

    #[test]
    fn the_result_does_not_depend_on_the_number_of_threads() {
        let (a, b) = (torus(30, 17), moved(&torus(33, 15), |p| p * 1.01));
        let with = |threads| compare(&a, &b, &options(), &Context::new().with_threads(threads).unwrap()).unwrap();
        assert_eq!(with(1), with(3));
    }

    #[test]
    fn surfaces_without_faces_or_area_are_no_trouble() {
        let empty = triangles(&[DVec3::ZERO], &[]);
        assert!(matches!(compare(&empty, &grid(1), &options(), &Context::new()), Err(Error::Input { .. })));
        let point = triangles(&[DVec3::Z; 3], &[[0, 1, 2]]);
        let c = compared(&point, &point);
        assert_eq!((c.distance.max_upper, c.relative.max, c.normal_deg), (0.0, 0.0, None));
        let far = compared(&point, &grid(1));
        assert!(brackets(&far.a_to_b.distance, 1.0, 1e-9));
        assert!(brackets(&far.b_to_a.distance, 3f64.sqrt(), 1e-4));
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(6))]
        #[test]
        fn motions_do_not_change_distances(axis in prop::array::uniform3(-1.0f64..1.0), angle in 0.0f64..6.0, shift in -9.0f64..9.0) {
            let axis = DVec3::from_array(axis);
            prop_assume!(axis.length() > 0.1);
            let turn = glam::DQuat::from_axis_angle(axis.normalize(), angle);
            let motion = |p: DVec3| turn * p + DVec3::splat(shift);
            let (a, b) = (torus(24, 12), moved(&torus(20, 10), |p| p * 1.02 + DVec3::X * 0.1));
            let before = compared(&a, &b);
            let after = compared(&moved(&a, motion), &moved(&b, motion));
            for (x, y) in [(before.a_to_b.distance, after.a_to_b.distance), (before.b_to_a.distance, after.b_to_a.distance)] {
                // A sample on the border of two shares of the area may change sides.
                prop_assert!((x.mean - y.mean).abs() < 1e-5 && (x.rms - y.rms).abs() < 1e-5);
                // Rounding may change which triangles are divided, but both brackets hold the same number.
                prop_assert!(x.max <= y.max_upper + 1e-9 && y.max <= x.max_upper + 1e-9);
            }
        }
    }
}
