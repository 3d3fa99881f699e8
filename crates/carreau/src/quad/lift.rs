//! Quads whose vertices are on a surface that bends lie on one side of it. Where they would be too far off, their vertices
//! leave it to the other side, by as little as brings both within what is allowed:
//!
//! ```text
//!      ╭──╮  surface        v────v
//!    ╭╯    ╰╮       →      ╱╭╯  ╰╮╲
//!   v────────v           v╯      ╰v
//! ```

use super::around::{Around, Ring};
use super::quality::halves;
use super::smooth::{GOOD, SHARES};
use super::source::Source;
use super::work::{Place, Work};
use crate::context::Context;
use crate::error::Result;
use crate::geometry::normals::unit;
use crate::geometry::search_tree::{TriangleTree, closest_on_triangle};
use crate::mesh::NONE;
use glam::DVec3;
use rayon::prelude::*;

/// How far quads may be from the surface, as a share of the diagonal.
const FAR: f64 = 0.0017;
/// A vertex moves by no more than so many times what its quad is off by, where others of the quad cannot move.
const MOST: f64 = 2.0;
/// Rounds at most; one that leaves more than this share of what was too much is the last, and none is needed where all
/// quads together are less than the other share of what is allowed too far off.
const ROUNDS: usize = 8;
const PROGRESS: f64 = 0.97;
const LITTLE: f64 = 0.01;
/// Places along an edge of half a quad that are looked at, and as many rows of them, where the middles of its edges and its
/// own are off by more than this share of what is allowed.
const FINE: usize = 5;
const ROUGH: f64 = 0.5;
/// Places of the source that are looked at are as far from each other as this share of the edges of quads; the most in a row.
const APART: f64 = 0.5;
const FINEST: f64 = 100.0;

/// A place that wants smaller quads.
#[derive(Debug, Clone, Copy)]
pub struct Tight {
    pub place: DVec3,
    /// The direction in which the surface bends.
    pub way: DVec3,
    /// How long edges along it may be.
    pub length: f64,
}

/// How far quads are from the surface.
pub struct Gap {
    pub largest: f64,
    /// Where it is more than allowed.
    pub tight: Vec<Tight>,
}

impl Gap {
    fn new(work: &Work, source: &Source, gaps: &[DVec3], far: f64) -> Self {
        let largest = gaps.iter().map(|gap| gap.length()).fold(0.0, f64::max);
        let beyond = (0..gaps.len()).filter(|&q| gaps[q].length() > far);
        Gap { largest, tight: beyond.flat_map(|q| tight(work, source, q, far / gaps[q].length())).collect() }
    }
}

/// Directions of a quad that bend less than this share of the other are not to blame.
const STRAIGHT: f64 = 0.4;

/// In which directions a quad is too long, where what is allowed is a share of what it is off by.
fn tight(work: &Work, source: &Source, q: usize, share: f64) -> impl Iterator<Item = Tight> + use<> {
    let face = work.faces.face(q);
    let p = [0, 1, 2, 3].map(|k| work.points[face[k] as usize]);
    let gap = |p: DVec3| to_surface(source, work.region[q], p);
    let sag = |a: DVec3, b: DVec3| (gap(a.midpoint(b)) - gap(a).midpoint(gap(b))).length();
    let place = p.iter().sum::<DVec3>() / 4.0;
    let found = [[[p[0], p[1]], [p[3], p[2]]], [[p[0], p[3]], [p[1], p[2]]]].map(|pair: [[DVec3; 2]; 2]| {
        let ways = pair.map(|[a, b]| b - a);
        let longest = ways[0].length().max(ways[1].length());
        let sags = pair.map(|[a, b]| sag(a, b));
        // The sag of an arc grows with the square of its chord.
        (Tight { place, way: unit(ways[0] + ways[1]), length: longest * share.sqrt() }, sags[0].max(sags[1]))
    });
    let most = found[0].1.max(found[1].1);
    found.into_iter().filter(move |f| f.1 >= STRAIGHT * most).map(|f| f.0)
}

/// The way from a point to a region.
fn to_surface(source: &Source, region: u32, p: DVec3) -> DVec3 {
    source.on_region(region, p).map_or(DVec3::ZERO, |found| found.0 - p)
}

/// Moves the vertices inside regions off the surface where their quads are too far from it. Returns how far they are then.
pub fn lift(work: &mut Work, source: &Source, context: &Context) -> Result<Gap> {
    let _stage = context.stage("lift");
    let around = &Around::new(work);
    let far = FAR * source.diagonal;
    let mut gaps = Gaps::new(work, source, far);
    let beyond = |gaps: &[DVec3]| gaps.iter().map(|gap| (gap.length() - far).max(0.0)).sum::<f64>();
    let mut has_moved = vec![true; work.points.len()];
    let mut now = gaps.of(work, &has_moved);
    for _ in 0..ROUNDS {
        let before = beyond(&now);
        if before <= LITTLE * far {
            break;
        }
        context.check()?;
        let points = work.points.clone();
        for v in 0..work.points.len() {
            has_moved[v] = false;
            if let Place::Region(region) = work.place[v]
                && let Some(step) = step(work, around, &now, v, far)
            {
                let from = work.points[v];
                let ring = Ring::new(work, around, v as u32);
                let least = ring.worst(from).min(GOOD);
                let may_be = |&to: &DVec3| {
                    source.on_region(region, to).is_some_and(|found| found.0.distance(to) <= far)
                        && ring.worst(to) >= least
                };
                if let Some(to) = SHARES.map(|share| from + share * step).into_iter().find(may_be) {
                    work.points[v] = to;
                    has_moved[v] = true;
                }
            }
        }
        let moved = gaps.of(work, &has_moved);
        let after = beyond(&moved);
        if after >= before {
            work.points = points;
            break;
        }
        now = moved;
        if after > PROGRESS * before {
            break;
        }
    }
    Ok(Gap::new(work, source, &now, far))
}

/// What a vertex has to move by: the most that one of its quads asks for.
fn step(work: &Work, around: &Around, gaps: &[DVec3], v: usize, far: f64) -> Option<DVec3> {
    let gap = around.quads[v]
        .iter()
        .map(|&q| (gaps[q as usize], q))
        .reduce(|a, b| if b.0.length_squared() > a.0.length_squared() { b } else { a });
    let (gap, q) = gap.filter(|gap| gap.0.length() > far)?;
    let is_free = |v: &&u32| matches!(work.place[**v as usize], Place::Region(_));
    let free = work.faces.face(q as usize).iter().filter(is_free).count();
    Some(gap * (1.0 - far / gap.length()) * (4.0 / free as f64).min(MOST))
}

/// Between quads and the surface.
struct Gaps<'a> {
    source: &'a Source,
    far: f64,
    /// What every quad found beneath itself.
    below: Vec<DVec3>,
    /// Places of the source, with the half of a quad that was nearest to each.
    above: Vec<(DVec3, u32)>,
}

impl<'a> Gaps<'a> {
    fn new(work: &Work, source: &'a Source, far: f64) -> Self {
        let apart = APART * (source.area / work.faces.len().max(1) as f64).sqrt();
        let faces = 0..source.surface.mesh.face_count();
        let above = faces.into_par_iter().flat_map_iter(|f| places(source, f, apart)).map(|p| (p, NONE)).collect();
        Gaps { source, far, below: vec![DVec3::ZERO; work.faces.len()], above }
    }

    /// From each quad to the surface where they are farthest from each other. Quads with a vertex that has moved look beneath
    /// themselves again; places of the source look for another half of a quad where theirs is no longer near enough.
    fn of(&mut self, work: &Work, has_moved: &[bool]) -> Vec<DVec3> {
        let Gaps { source, far, below, above } = self;
        let far = *far;
        let triangles = halves(work);
        let corners = |t: u32| triangles[t as usize].map(|v| work.points[v as usize]);
        let look = |(q, gap): (usize, &mut DVec3)| {
            let of = |p: DVec3| to_surface(source, work.region[q], p);
            *gap = DVec3::ZERO;
            for [a, b, c] in [2 * q as u32, 2 * q as u32 + 1].map(corners) {
                let rough = [a.midpoint(b), b.midpoint(c), c.midpoint(a), (a + b + c) / 3.0].map(of);
                *gap = rough.into_iter().fold(*gap, longer);
                if gap.length() > ROUGH * far {
                    for (i, j) in (0..=FINE).flat_map(|i| (0..=FINE - i).map(move |j| (i, j))) {
                        let p = a + (b - a) * (i as f64 / FINE as f64) + (c - a) * (j as f64 / FINE as f64);
                        *gap = longer(*gap, of(p));
                    }
                }
            }
        };
        let has_moved = |q: usize| work.faces.face(q).iter().any(|&v| has_moved[v as usize]);
        below.par_iter_mut().enumerate().filter(|(q, _)| has_moved(*q)).for_each(look);
        let tree = TriangleTree::new(&work.points, &triangles);
        let beyond = |(p, nearest): &mut (DVec3, u32)| {
            if *nearest != NONE && closest_on_triangle(*p, corners(*nearest)).distance(*p) <= far {
                return None;
            }
            let found = tree.closest(*p)?;
            *nearest = found.triangle;
            (found.distance() > far).then_some((found.triangle / 2, *p - found.point))
        };
        let above: Vec<(u32, DVec3)> = above.par_iter_mut().filter_map(beyond).collect();
        let mut gaps = below.clone();
        for (q, gap) in above {
            gaps[q as usize] = longer(gaps[q as usize], gap);
        }
        gaps
    }
}

/// The middle of a triangle of the source; on a larger one and its edges places about so far apart.
fn places(source: &Source, face: usize, apart: f64) -> Vec<DVec3> {
    let mesh = &source.surface.mesh;
    let steps = |length: f64| (length / apart).ceil().clamp(1.0, FINEST) as usize;
    let p = [0, 1, 2].map(|k| mesh.points()[mesh.faces().face(face)[k] as usize]);
    let length = |k: &usize| p[*k].distance(p[(k + 1) % 3]);
    if (0..3).all(|k| length(&k) <= apart) {
        return vec![p.iter().sum::<DVec3>() / 3.0];
    }
    // Rows along the shortest side.
    let first = (0..3).min_by(|j, k| length(j).total_cmp(&length(k))).unwrap_or(0);
    let [a, b, c] = [0, 1, 2].map(|k| p[(first + k) % 3]);
    let rows = steps(c.distance(a.midpoint(b)));
    let mut places = vec![c];
    for row in 0..rows {
        let [from, to] = [a, b].map(|p| p.lerp(c, row as f64 / rows as f64));
        let count = steps(from.distance(to));
        places.extend((0..=count).map(|k| from.lerp(to, k as f64 / count as f64)));
    }
    places
}

fn longer(a: DVec3, b: DVec3) -> DVec3 {
    if b.length_squared() > a.length_squared() { b } else { a }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::features::FeatureOptions;
    use crate::geometry::quality::scaled_jacobian;
    use crate::mesh::{Polygons, SurfaceMesh, test_models::cube};
    use rustc_hash::FxHashMap;

    /// The unit sphere as a cube blown up: `n` by `n` quads to a side.
    fn sphere(n: usize) -> SurfaceMesh {
        let cube = cube(DVec3::splat(-1.0), 2.0);
        let (mut points, mut faces, mut known) = (Vec::new(), Polygons::new(), FxHashMap::default());
        for face in cube.faces().iter() {
            let [a, b, c, d] = [0, 1, 2, 3].map(|k| cube.points()[face[k] as usize]);
            let mut at = |i: usize, j: usize| {
                let share = |k: usize| (std::f64::consts::FRAC_PI_2 * (k as f64 / n as f64 - 0.5)).tan() / 2.0 + 0.5;
                let p = a.lerp(b, share(i)).lerp(d.lerp(c, share(i)), share(j)).normalize();
                *known.entry(p.to_array().map(|x| (x * 1e6).round() as i64)).or_insert_with(|| {
                    points.push(p);
                    points.len() as u32 - 1
                })
            };
            for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
                faces.push(&[at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
            }
        }
        SurfaceMesh::new(points, faces).unwrap()
    }

    fn on_sphere(n: usize) -> Work {
        let mesh = sphere(n);
        let (place, region) = (vec![Place::Region(0); mesh.vertex_count()], vec![0; mesh.face_count()]);
        Work { points: mesh.points().to_vec(), place, faces: mesh.faces().clone(), region, features: Vec::new() }
    }

    /// The least and the largest distance of the middles of shorter diagonals from the centre.
    fn middles(work: &Work) -> (f64, f64) {
        let middle = |f: &[u32]| {
            let [a, b, c, d] = [0, 1, 2, 3].map(|k| work.points[f[k] as usize]);
            if a.distance(c) < b.distance(d) { a.midpoint(c).length() } else { b.midpoint(d).length() }
        };
        let all = work.faces.iter().map(middle);
        all.fold((f64::INFINITY, 0.0), |(a, b), m| (a.min(m), b.max(m)))
    }

    #[test]
    fn vertices_leave_a_sphere_until_its_quads_are_near_enough() {
        let context = Context::new();
        let options = FeatureOptions { angle_deg: None, ..FeatureOptions::default() };
        let source = Source::new(&sphere(40), &options, &context).unwrap();
        let far = FAR * source.diagonal;
        let mut work = on_sphere(8);
        assert!(1.0 - middles(&work).0 > 1.5 * far);
        let before = work.clone();
        let left = lift(&mut work, &source, &context).unwrap().largest;
        assert!(left <= (1.0 + LITTLE) * far, "{left} of {far}");
        let (low, high) = middles(&work);
        assert!(1.0 - low <= 1.1 * far && high - 1.0 <= 1.1 * far, "{low} {high} {far}");
        // Outwards, no farther than that, and square as before.
        let least = |work: &Work| {
            let of = |f: &[u32]| scaled_jacobian([0, 1, 2, 3].map(|k| work.points[f[k] as usize]));
            work.faces.iter().map(of).fold(1.0, f64::min)
        };
        assert!(work.points.iter().all(|p| (0.999..=1.0 + 1.01 * far).contains(&p.length())));
        assert!(least(&work) > 0.95 * least(&before));
    }

    #[test]
    fn a_quad_on_a_cylinder_is_too_long_around_it_only() {
        let context = Context::new();
        let mesh = crate::sample::make("open-cylinder", None, &context).unwrap();
        let options = FeatureOptions { angle_deg: None, ..FeatureOptions::default() };
        let source = Source::new(&mesh, &options, &context).unwrap();
        let (low, high) = source.surface.mesh.bounds();
        let (middle, radius) = (low.midpoint(high), 0.5 * (high.x - low.x));
        let at = |angle: f64, z: f64| middle + DVec3::new(radius * angle.cos(), radius * angle.sin(), z);
        let work = Work {
            points: vec![at(-0.4, -0.3), at(0.4, -0.3), at(0.4, 0.3), at(-0.4, 0.3)],
            place: vec![Place::Region(0); 4],
            faces: std::iter::once(&[0u32, 1, 2, 3][..]).collect(),
            region: vec![0],
            features: Vec::new(),
        };
        let found: Vec<Tight> = tight(&work, &source, 0, 0.25).collect();
        let [only] = found[..] else { panic!("{found:?}") };
        assert!(only.way.y.abs() > 0.99, "{:?}", only.way);
        let chord = 2.0 * radius * 0.4f64.sin();
        assert!((only.length - 0.5 * chord).abs() < 1e-9 * chord, "a quarter of the sag is half of the chord");
    }

    #[test]
    fn what_is_near_enough_stays_to_the_bit() {
        let context = Context::new();
        let options = FeatureOptions { angle_deg: None, ..FeatureOptions::default() };
        let source = Source::new(&sphere(40), &options, &context).unwrap();
        let mut work = on_sphere(20);
        let before = work.points.clone();
        assert!(lift(&mut work, &source, &context).unwrap().largest < FAR * source.diagonal);
        assert_eq!(work.points, before);
    }
}
