//! From labels to regions: connected, numbered by size, with their figures and surfaces.

use super::boundaries::Boundary;
use super::surface::Surface;
use crate::geometry::curvature::Curvature;
use crate::geometry::primitive::{Fit, Kind, Primitive, Scratch, fit_robust, fit_within, refine};
use crate::mesh::NONE;
use glam::DVec3;
use rayon::prelude::*;

/// A region of the result.
#[derive(Debug, Clone, PartialEq)]
pub struct Region {
    /// Number of triangles.
    pub triangles: u32,
    /// Area, in the square of the file's unit.
    pub area: f64,
    /// Smallest principal curvature, area-weighted mean over its vertices (signed, 1/length).
    pub kmin: f64,
    /// Largest principal curvature, likewise.
    pub kmax: f64,
    /// The surface it lies on; `None`: freeform.
    pub primitive: Option<Primitive>,
    /// Root mean square distance of its vertices from the surface; 0 for freeform.
    pub rms: f64,
    /// Largest distance of its vertices from the surface; 0 for freeform.
    pub max: f64,
    /// Regions that share an edge with it, in order.
    pub neighbours: Vec<u32>,
}

/// Labels numbered from 0 in the order of their values.
pub fn dense(labels: &[u32]) -> Vec<u32> {
    let mut values = labels.to_vec();
    values.par_sort_unstable();
    values.dedup();
    labels.par_iter().map(|l| values.binary_search(l).map_or(NONE, |k| k as u32)).collect()
}

/// One more than the largest label.
pub fn count(label: &[u32]) -> usize {
    label.iter().filter(|&&l| l != NONE).max().map_or(0, |&m| m as usize + 1)
}

/// The connected parts of labels, numbered in the order of their first triangles.
pub fn connected(surface: &Surface<'_>, label: &[u32], order: &[u32]) -> Vec<u32> {
    let mut part = vec![NONE; label.len()];
    let same = |c: u32| label[c as usize / 3] == label[surface.triangles.opposite(c) as usize / 3];
    surface.flood(order, &mut part, 0, same, |_, _| ());
    part
}

/// Takes the label from all connected parts but the largest of each label; [`NONE`] is left there.
pub fn keep_largest_parts(surface: &Surface<'_>, label: &mut [u32], order: &[u32]) {
    let part = connected(surface, label, order);
    let mut area = vec![0.0; count(&part)];
    part.iter().zip(&surface.areas).for_each(|(&p, &a)| area[p as usize] += a);
    let mut largest = vec![NONE; count(label)];
    for &t in order {
        let (p, best) = (part[t as usize], &mut largest[label[t as usize] as usize]);
        if *best == NONE || area[p as usize] > area[*best as usize] {
            *best = p;
        }
    }
    for (label, &p) in label.iter_mut().zip(&part) {
        if largest[*label as usize] != p {
            *label = NONE;
        }
    }
}

/// Numbers labels by area, largest first; ties by the first triangle in the order. [`NONE`] stays.
pub fn by_size(surface: &Surface<'_>, label: &mut [u32], order: &[u32]) -> usize {
    let count = count(label);
    let (mut area, mut first) = (vec![0.0; count], vec![NONE; count]);
    for (k, &t) in order.iter().enumerate().filter(|(_, t)| label[**t as usize] != NONE) {
        let l = label[t as usize] as usize;
        area[l] += surface.areas[t as usize];
        first[l] = first[l].min(k as u32);
    }
    let mut rank: Vec<u32> = (0..count as u32).filter(|&l| first[l as usize] != NONE).collect();
    rank.sort_by(|&a, &b| {
        area[b as usize].total_cmp(&area[a as usize]).then(first[a as usize].cmp(&first[b as usize]))
    });
    let mut number = vec![NONE; count];
    rank.iter().enumerate().for_each(|(n, &l)| number[l as usize] = n as u32);
    label.par_iter_mut().filter(|l| **l != NONE).for_each(|l| *l = number[*l as usize]);
    rank.len()
}

/// Triangles grouped by label.
pub struct Groups {
    start: Vec<u32>,
    members: Vec<u32>,
}

impl Groups {
    pub fn new(label: &[u32], count: usize) -> Self {
        let mut start = vec![0u32; count + 1];
        label.iter().filter(|&&l| l != NONE).for_each(|&l| start[l as usize + 1] += 1);
        (1..start.len()).for_each(|k| start[k] += start[k - 1]);
        let mut members = vec![0u32; start[count] as usize];
        let mut fill = start.clone();
        for (t, &l) in label.iter().enumerate().filter(|(_, l)| **l != NONE) {
            members[fill[l as usize] as usize] = t as u32;
            fill[l as usize] += 1;
        }
        Groups { start, members }
    }

    pub fn len(&self) -> usize {
        self.start.len() - 1
    }

    pub fn of(&self, l: u32) -> &[u32] {
        &self.members[self.start[l as usize] as usize..self.start[l as usize + 1] as usize]
    }
}

/// A count: most points given to a fit, because more would not change it.
pub const FIT_SAMPLES: usize = 300;
/// A count: points of a first fit, few because it is tried from all kinds of starts and refuses most kinds at once.
pub const FIRST_SAMPLES: usize = 60;
/// A count: steps of a fit that starts from the result of another, few because it is near already.
const REFINE_STEPS: usize = 30;

/// The distinct vertices of some triangles, ascending, with their corners.
#[derive(Default)]
pub struct Corners {
    /// `vertex << 32 | corner`, ascending.
    sorted: Vec<u64>,
    /// Where each vertex begins, and the end.
    start: Vec<u32>,
}

impl Corners {
    pub fn of(surface: &Surface<'_>, triangles: &[u32]) -> Self {
        let mut corners = Corners::default();
        corners.collect(surface, triangles.iter().copied());
        corners
    }

    /// Takes other triangles into the same memory.
    pub fn collect(&mut self, surface: &Surface<'_>, triangles: impl Iterator<Item = u32>) {
        let key = |c: u32| u64::from(surface.triangles.vertex(c)) << 32 | u64::from(c);
        self.sorted.clear();
        self.sorted.extend(triangles.flat_map(|t| 3 * t..3 * t + 3).map(key));
        self.sorted.sort_unstable();
        self.start.clear();
        let mut last = None;
        for (at, &key) in (0u32..).zip(&self.sorted) {
            if last.replace(key >> 32) != Some(key >> 32) {
                self.start.push(at);
            }
        }
        self.start.push(self.sorted.len() as u32);
    }

    /// Number of distinct vertices.
    pub fn len(&self) -> usize {
        self.start.len() - 1
    }

    /// Position of the `k`-th vertex.
    pub fn point(&self, surface: &Surface<'_>, k: usize) -> DVec3 {
        surface.triangles.points()[(self.sorted[self.start[k] as usize] >> 32) as usize]
    }

    /// Mean normal of the `k`-th vertex over these triangles alone.
    pub fn normal(&self, surface: &Surface<'_>, k: usize) -> DVec3 {
        let corners = &self.sorted[self.start[k] as usize..self.start[k + 1] as usize];
        let normal = |&key: &u64| surface.normals[key as u32 as usize / 3] * surface.corner_angle(key as u32);
        corners.iter().map(normal).sum::<DVec3>().normalize_or_zero()
    }

    /// Evenly thinned, no more than `most`.
    fn thinned(&self, most: usize) -> impl Iterator<Item = usize> + Clone {
        (0..self.len()).step_by(self.len().div_ceil(most).max(1))
    }
}

/// The simplest surface of these kinds within the tolerance of all vertices of a region; triangles must look along it.
pub fn fit_region(surface: &Surface<'_>, triangles: &[u32], tolerance: f64, kinds: &[Kind]) -> Option<Fit> {
    let corners = Corners::of(surface, triangles);
    let point = |k| corners.point(surface, k);
    let (few, few_normals): (Vec<DVec3>, Vec<DVec3>) =
        corners.thinned(FIRST_SAMPLES).map(|k| (point(k), corners.normal(surface, k))).unzip();
    let points: Vec<DVec3> = corners.thinned(FIT_SAMPLES).map(point).collect();
    let mut scratch = Scratch::default();
    let mut best: Option<(Fit, f64)> = None;
    for &kind in kinds {
        if few.len() <= kind.parameters() && kind != Kind::Plane {
            continue;
        }
        // A few points refuse most kinds at once; the others are fitted to more.
        let quick = fit_within(kind, &few, &few_normals, tolerance, &mut scratch);
        let Some(found) = quick.and_then(|quick| refine(quick.primitive, &points, None, REFINE_STEPS)) else {
            continue;
        };
        let p = found.primitive;
        let d = (0..corners.len()).map(|k| p.distance(point(k)).abs());
        let (max, sum) = d.fold((0.0, 0.0), |(m, s): (f64, f64), d| (m.max(d), s + d * d));
        let fit = Fit { primitive: p, rms: (sum / corners.len() as f64).sqrt(), max };
        if fit.max > tolerance || !looks_along(surface, triangles, &p) {
            continue;
        }
        if kind == Kind::Plane {
            return Some(fit);
        }
        let step = triangles.len().div_ceil(FIT_SAMPLES).max(1);
        let s = sagitta(surface, triangles.iter().copied().step_by(step), &p);
        if best.as_ref().is_none_or(|b| s < 0.5 * b.1) {
            best = Some((fit, s));
        }
    }
    best.map(|b| b.0)
}

/// A surface with the distances of a region's vertices.
pub fn measure(surface: &Surface<'_>, triangles: &[u32], primitive: Primitive) -> Option<Fit> {
    let corners = Corners::of(surface, triangles);
    let d = (0..corners.len()).map(|k| primitive.distance(corners.point(surface, k)).abs());
    let (max, sum) = d.fold((0.0, 0.0), |(m, s): (f64, f64), d| (m.max(d), s + d * d));
    let rms = (sum / corners.len().max(1) as f64).sqrt();
    rms.is_finite().then_some(Fit { primitive, rms, max })
}

/// The simplest surface that most of a region lies on, for regions with spoiled borders: fitted to the triangles that only
/// have neighbours of their region, if there are enough of them.
pub fn fit_most(surface: &Surface<'_>, label: &[u32], triangles: &[u32], tolerance: f64) -> Option<Primitive> {
    const LEAST_INLIERS: f64 = 0.5;
    const POINTS: usize = 120;
    let t = surface.triangles;
    let own = |k: u32| label[k as usize];
    let neighbours = |k: u32| (3 * k..3 * k + 3).map(|c| t.opposite(c)).filter(|&o| o != NONE).map(|o| o / 3);
    let inner: Vec<u32> = triangles.iter().copied().filter(|&k| neighbours(k).all(|n| own(n) == own(k))).collect();
    let corners = Corners::of(surface, if inner.len() >= 4 { &inner } else { triangles });
    let (points, normals): (Vec<DVec3>, Vec<DVec3>) =
        corners.thinned(POINTS).map(|k| (corners.point(surface, k), corners.normal(surface, k))).unzip();
    let mut scratch = Scratch::default();
    Kind::ALL.into_iter().filter(|kind| points.len() >= kind.parameters() + 3).find_map(|kind| {
        let found = fit_robust(kind, &points, &normals, &mut scratch)?.fit.primitive;
        let on = points.iter().filter(|&&p| found.distance(p).abs() <= tolerance).count();
        (on as f64 >= LEAST_INLIERS * points.len() as f64 && on >= kind.parameters() + 3).then_some(found)
    })
}

/// Area-weighted mean distance of the edges' middles: small where the triangles follow the surface.
pub fn sagitta(surface: &Surface<'_>, triangles: impl Iterator<Item = u32>, p: &Primitive) -> f64 {
    let t = surface.triangles;
    let (mut sum, mut area) = (0.0, 0.0);
    for f in triangles {
        let q = t.triangle(f).map(|v| t.points()[v as usize]);
        let middle = (0..3).map(|k| p.distance((q[k] + q[(k + 1) % 3]) / 2.0).abs()).fold(0.0, f64::max);
        sum += surface.areas[f as usize] * middle;
        area += surface.areas[f as usize];
    }
    sum / f64::max(area, f64::MIN_POSITIVE)
}

/// Whether most of the area looks along the surface's normals, on one side.
fn looks_along(surface: &Surface<'_>, triangles: &[u32], p: &Primitive) -> bool {
    let (mut with, mut against, mut off) = (0.0, 0.0, 0.0);
    for &f in triangles {
        let cos = p.normal(surface.center(f)).dot(surface.normals[f as usize]);
        *(if cos > 0.7 {
            &mut with
        } else if cos < -0.7 {
            &mut against
        } else {
            &mut off
        }) += surface.areas[f as usize];
    }
    let all: f64 = with + against + off;
    with.max(against) >= 0.95 * all
}

/// Figures of all regions.
pub fn describe(
    surface: &Surface<'_>,
    groups: &Groups,
    boundaries: &[Boundary],
    curvature: &Curvature,
    surfaces: &[Option<Fit>],
) -> Vec<Region> {
    let count = groups.len();
    let mut neighbours = neighbours(boundaries, count);
    (0..count as u32)
        .map(|l| {
            let triangles = groups.of(l);
            let area = triangles.iter().map(|&t| surface.areas[t as usize]).sum();
            let (mut kmin, mut kmax, mut weight) = (0.0, 0.0, 0.0);
            for v in triangles.iter().flat_map(|&t| surface.triangles.triangle(t)) {
                // Shares, so that no size overflows.
                let w = if surface.total_area > 0.0 { curvature.area[v as usize] / surface.total_area } else { 0.0 };
                kmin += w * curvature.kmin[v as usize];
                kmax += w * curvature.kmax[v as usize];
                weight += w;
            }
            let mean = |x: f64| if weight > 0.0 { x / weight } else { 0.0 };
            let fit = surfaces[l as usize].as_ref();
            Region {
                triangles: triangles.len() as u32,
                area,
                kmin: mean(kmin),
                kmax: mean(kmax),
                primitive: fit.map(|f| f.primitive),
                rms: fit.map_or(0.0, |f| f.rms),
                max: fit.map_or(0.0, |f| f.max),
                neighbours: std::mem::take(&mut neighbours[l as usize]),
            }
        })
        .collect()
}

/// The regions on the other side of every region's boundaries, in order.
fn neighbours(boundaries: &[Boundary], count: usize) -> Vec<Vec<u32>> {
    let mut pairs: Vec<(u32, u32)> = boundaries.iter().filter_map(|b| Some((b.regions.0, b.regions.1?))).collect();
    pairs.sort_unstable();
    pairs.dedup();
    let mut out = vec![Vec::new(); count];
    for (a, b) in pairs {
        out[a as usize].push(b);
        out[b as usize].push(a);
    }
    out.iter_mut().for_each(|list| list.sort_unstable());
    out
}
