//! Quads in patches. One with a grid is mapped to a rectangle, each side in proportion to length on every arc, the inside
//! by the mean of neighbours or by a harmonic map; the points of the grid are read off. One with a pattern is mapped to a
//! regular polygon. All others take triangles of twice the size, paired, and halved, so that their outlines have the edges
//! that they should.

use super::chart::Chart;
use super::graft::{Donor, Planted};
use super::layout::{Arc, Kind, Layout, Patch, Side};
use super::pair::paired_triangles;
use super::pattern::pattern;
use super::sheet::Sheet;
use super::ticks::{locate, place};
use super::work::{Place, Work};
use crate::context::Context;
use crate::error::Result;
use crate::geometry::planar;
use crate::geometry::quality::scaled_jacobian;
use crate::mesh::{NONE, Polygons};
use glam::{DVec2, DVec3};
use rustc_hash::{FxHashMap, FxHashSet};
use std::f64::consts::TAU;

/// Triangles are no smaller than this share of the wanted length, however short the arcs around are.
const SHORTEST: f64 = 0.7;
/// Patches that are laid flat have no normal farther from the mean than this cosine.
const STEEPEST: f64 = 0.3;
/// Corners of outlines with a lower cosine are nearly straight.
const FLAT: f64 = -0.6;
/// A harmonic map is taken where it makes the worst quad of a grid better by this much: where triangles are graded. Else the
/// two are nearly alike, and the means of neighbours never fold.
const CLEARLY: f64 = 0.1;

/// The quads of a layout with the patch of each.
pub struct Filled {
    pub work: Work,
    pub patch: Vec<u32>,
    /// What every patch took.
    pub kind: Vec<Kind>,
    /// The edges along arcs that are no features.
    pub tracks: Vec<[u32; 2]>,
}

/// All quads of a layout, or the patches that take none. `place` tells where the vertices of the sheet belong; grafted patches
/// take the quads of `donor`.
pub fn fill(
    sheet: &Sheet,
    layout: &Layout,
    place: impl Fn(u32) -> Option<Place>,
    donor: Option<&Donor>,
    context: &Context,
) -> Result<std::result::Result<Filled, Vec<usize>>> {
    let _stage = context.stage("fill");
    let mut work = Work { faces: Polygons::new(), ..Work::default() };
    let mut node = vec![NONE; sheet.points.len()];
    let (mut along, mut tracks): (Vec<Along>, Vec<[u32; 2]>) = Default::default();
    let mut planted = match donor.map(|donor| donor.plant(layout, &mut work, &mut node)) {
        Some(Err(unfilled)) => return Ok(Err(unfilled)),
        Some(Ok(planted)) => planted,
        None => Planted::default(),
    };
    let inside = layout.inside();
    for (a, arc) in (0u32..).zip(&layout.arcs) {
        if inside[a as usize] {
            along.push(Along::default());
            continue;
        }
        let ticks = arc.bends.ticks(arc.count.max(1) as usize);
        if let (Some(curve), Some(ids)) = (arc.curve, planted.along.remove(&a)) {
            work.features.extend(ids.windows(2).map(|w| ([w[0], w[1]], curve)));
            along.push(Along { ids, ticks });
            continue;
        }
        let inner = match arc.curve {
            Some(curve) => Place::Curve(curve),
            None => Place::Region(region_at(sheet, arc.vertices[0], arc.vertices[1])),
        };
        let mut add = |p: DVec3, place: Place| {
            work.points.push(p);
            work.place.push(place);
            work.points.len() as u32 - 1
        };
        let last = arc.vertices.len() - 1;
        for v in [arc.vertices[0], arc.vertices[last]] {
            if node[v as usize] == NONE {
                node[v as usize] = add(sheet.points[v as usize], place(v).unwrap_or(inner));
            }
        }
        let mut ids = vec![node[arc.vertices[0] as usize]];
        for &station in &ticks[1..ticks.len() - 1] {
            ids.push(add(point_on(sheet, arc, station), inner));
        }
        ids.push(node[arc.vertices[last] as usize]);
        let edges = ids.windows(2).map(|w| [w[0], w[1]]);
        match arc.curve {
            Some(curve) => work.features.extend(edges.map(|ends| (ends, curve))),
            None => tracks.extend(edges),
        }
        along.push(Along { ids, ticks });
    }
    let (mut patch_of_face, mut kinds, mut unfilled) = (Vec::new(), Vec::new(), Vec::new());
    let filler = Filler { sheet, layout, along: &along, context };
    for (p, patch) in layout.patches.iter().enumerate() {
        context.check()?;
        if let (Kind::Grafted, Some(donor)) = (patch.kind, donor) {
            donor.fill(sheet.region[patch.triangles[0] as usize], &mut planted, &mut work);
            kinds.push(Kind::Grafted);
            patch_of_face.resize(work.faces.len(), p as u32);
            continue;
        }
        match filler.fill(patch, &mut work)? {
            Some(kind) => kinds.push(kind),
            None => unfilled.push(p),
        }
        patch_of_face.resize(work.faces.len(), p as u32);
    }
    if !unfilled.is_empty() {
        return Ok(Err(unfilled));
    }
    if let Some(donor) = donor {
        donor.inner_features(&planted, &mut work);
    }
    Ok(Ok(Filled { work, patch: patch_of_face, kind: kinds, tracks }))
}

fn region_at(sheet: &Sheet, a: u32, b: u32) -> u32 {
    sheet.between(a, b).or_else(|| sheet.between(b, a)).map_or(0, |h| sheet.region[h as usize / 3])
}

/// The point at a station of an arc.
fn point_on(sheet: &Sheet, arc: &Arc, station: f64) -> DVec3 {
    let (k, share) = locate(&arc.stations, station);
    let [a, b] = [arc.vertices[k], arc.vertices[k + 1]].map(|v| sheet.points[v as usize]);
    a.lerp(b, share)
}

/// What runs along an arc: its new vertices, and their stations.
#[derive(Default)]
struct Along {
    ids: Vec<u32>,
    ticks: Vec<f64>,
}

/// What runs along a side: its new vertices, and the half-edges of the sheet with the places of their ends, in units of quads.
struct Run {
    ids: Vec<u32>,
    places: Vec<(u32, [f64; 2])>,
}

fn run(layout: &Layout, along: &[Along], side: &[Side]) -> Run {
    let (mut run, mut offset) = (Run { ids: Vec::new(), places: Vec::new() }, 0.0);
    for s in side {
        let arc = &layout.arcs[s.arc as usize];
        let Along { ids, ticks } = &along[s.arc as usize];
        let (mut new, last) = (ids.clone(), arc.stations.len() - 1);
        if s.reversed {
            new.reverse();
        }
        let at = |j: usize| match s.reversed {
            true => offset + arc.count as f64 - place(ticks, arc.stations[last - j]),
            false => offset + place(ticks, arc.stations[j]),
        };
        run.places.extend(s.halves.iter().enumerate().map(|(j, &h)| (h, [at(j), at(j + 1)])));
        offset += arc.count as f64;
        run.ids.extend(&new[usize::from(!run.ids.is_empty())..]);
    }
    run
}

/// Fills patches between arcs whose vertices are there already.
struct Filler<'a> {
    sheet: &'a Sheet,
    layout: &'a Layout,
    along: &'a [Along],
    context: &'a Context,
}

impl Filler<'_> {
    /// The best that a patch takes.
    fn fill(&self, patch: &Patch, work: &mut Work) -> Result<Option<Kind>> {
        let done = match patch.kind {
            Kind::Grid => self.grid(patch, work)?,
            Kind::Pattern => self.pattern(patch, work)?,
            Kind::Triangles | Kind::Grafted => None,
        };
        if done.is_some() {
            return Ok(Some(patch.kind));
        }
        Ok(self.triangles(patch, work)?.map(|()| Kind::Triangles))
    }

    fn run(&self, side: &[Side]) -> Run {
        run(self.layout, self.along, side)
    }

    /// The grid of a patch.
    fn grid(&self, patch: &Patch, work: &mut Work) -> Result<Option<()>> {
        let Some(sides) = <[_; 4]>::try_from(patch.sides.iter().map(|s| self.run(s)).collect::<Vec<Run>>()).ok() else {
            return Ok(None);
        };
        let (m, n) = (sides[0].ids.len() - 1, sides[1].ids.len() - 1);
        if sides[2].ids.len() != m + 1 || sides[3].ids.len() != n + 1 {
            return Ok(None);
        }
        // Places of the boundary in the rectangle.
        let chart = Chart::new(self.sheet, &patch.triangles);
        let (w, h) = (m as f64, n as f64);
        let mut given = vec![None; chart.len()];
        for (k, side) in sides.iter().enumerate() {
            let on = |x: f64| [DVec2::new(x, 0.0), DVec2::new(w, x), DVec2::new(w - x, h), DVec2::new(0.0, h - x)][k];
            side.places.iter().for_each(|p| settle(&chart, &mut given, *p, on));
        }
        let Ok(Some(uv)) = chart.spread(&given) else { return Ok(None) };
        // Vertices of the grid, row by row.
        let mut ids = vec![NONE; (m + 1) * (n + 1)];
        for i in 0..=m {
            (ids[i], ids[n * (m + 1) + i]) = (sides[0].ids[i], sides[2].ids[m - i]);
        }
        for j in 0..=n {
            (ids[j * (m + 1)], ids[j * (m + 1) + m]) = (sides[3].ids[n - j], sides[1].ids[j]);
        }
        let mut points = chart.read_off(&uv, m, n);
        if let Some(uv) = chart.harmonic(&given) {
            let harmonic = chart.read_off(&uv, m, n);
            if worst_shape(work, &ids, &harmonic, m) > worst_shape(work, &ids, &points, m) + CLEARLY {
                points = harmonic;
            }
        }
        for j in 1..n {
            for i in 1..m {
                let Some(p) = points[j * (m + 1) + i] else { return Ok(None) };
                ids[j * (m + 1) + i] = self.add(patch, p, work);
            }
        }
        for j in 0..n {
            for i in 0..m {
                let at = |i: usize, j: usize| ids[j * (m + 1) + i];
                self.push(patch, [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)], work);
            }
        }
        Ok(Some(()))
    }

    /// A pattern in a disc, mapped to a polygon with a straight side for each of its own.
    fn pattern(&self, patch: &Patch, work: &mut Work) -> Result<Option<()>> {
        let sides: Vec<Run> = patch.sides.iter().map(|s| self.run(s)).collect();
        let counts: Vec<usize> = sides.iter().map(|s| s.ids.len().saturating_sub(1)).collect();
        let quads = patch.area / self.layout.length_around(patch).powi(2);
        let Some(pattern) = pattern(&counts, patch.corners, quads) else { return Ok(None) };
        let chart = Chart::new(self.sheet, &patch.triangles);
        let outline = Outline::new(&counts, patch.corners);
        let mut given = vec![None; chart.len()];
        for (k, side) in sides.iter().enumerate() {
            side.places.iter().for_each(|p| settle(&chart, &mut given, *p, |x| outline.at(k, x)));
        }
        let Ok(Some(uv)) = chart.spread(&given) else { return Ok(None) };
        let around: Vec<DVec2> = counts
            .iter()
            .enumerate()
            .flat_map(|(k, &n)| (0..n).map(move |x| (k, x as f64)))
            .map(|(k, x)| outline.at(k, x))
            .collect();
        let Ok(flat) = pattern.spread(&around) else { return Ok(None) };
        let Some(points) = flat[pattern.outline..].iter().map(|&q| chart.above(&uv, q)).collect::<Option<Vec<DVec3>>>()
        else {
            return Ok(None);
        };
        let mut ids: Vec<u32> = sides.iter().flat_map(|s| &s.ids[..s.ids.len() - 1]).copied().collect();
        ids.extend(points.into_iter().map(|p| self.add(patch, p, work)).collect::<Vec<u32>>());
        pattern.quads.iter().for_each(|q| self.push(patch, q.map(|v| ids[v as usize]), work));
        Ok(Some(()))
    }

    /// A new vertex inside a patch.
    fn add(&self, patch: &Patch, p: DVec3, work: &mut Work) -> u32 {
        work.points.push(p);
        work.place.push(Place::Region(self.sheet.region[patch.triangles[0] as usize]));
        work.points.len() as u32 - 1
    }

    fn push(&self, patch: &Patch, quad: [u32; 4], work: &mut Work) {
        work.faces.push(&quad);
        work.region.push(self.sheet.region[patch.triangles[0] as usize]);
    }

    /// Triangles of about twice the length of the sides around, paired and halved: every second vertex of the outlines is
    /// one of theirs, the others are in the middle of their edges.
    fn triangles(&self, patch: &Patch, work: &mut Work) -> Result<Option<()>> {
        let (sheet, layout, context) = (self.sheet, self.layout, self.context);
        let runs: Vec<Run> = patch.loops.iter().map(|list| self.run(list)).collect();
        let rings: Vec<Vec<u32>> = runs.iter().map(|run| run.ids[..run.ids.len().saturating_sub(1)].to_vec()).collect();
        if let [ring] = &rings[..]
            && let Ok(quad) = <[u32; 4]>::try_from(ring.clone())
        {
            self.push(patch, quad, work);
            return Ok(Some(()));
        }
        if rings.iter().any(|ring| ring.len() < 6 || !ring.len().is_multiple_of(2)) {
            return Ok(None);
        }
        let firsts: Vec<usize> = patch.loops.iter().map(|list| self.first(list)).collect();
        let chart = Chart::new(sheet, &patch.triangles);
        let length = 2.0 * layout.length_around(patch).max(SHORTEST * layout.length);
        let thinned = |mut flat: Flat| {
            for (outline, &first) in flat.outlines.iter_mut().zip(&firsts) {
                *outline = outline.iter().skip(first).step_by(2).copied().collect();
            }
            flat
        };
        let mut filled = None;
        if let Some(flat) = projected(sheet, patch, &chart, &rings, work) {
            filled = laid_out(&chart, thinned(flat), length, context);
        }
        if filled.is_none()
            && let Some(flat) = unrolled(layout, patch, &chart, self.along)
        {
            filled = laid_out(&chart, thinned(flat), length, context);
        }
        if filled.is_none()
            && let Ok(Some(flat)) = on_circle(layout, patch, &chart, self.along)
        {
            filled = laid_out(&chart, thinned(flat), length, context);
        }
        let Some((inner, triangles)) = filled else { return Ok(None) };
        // Vertices of the triangles, and those in the middle of their edges.
        let mut ids: Vec<u32> = Vec::new();
        let mut middle: FxHashMap<[u32; 2], u32> = FxHashMap::default();
        for (ring, &first) in rings.iter().zip(&firsts) {
            let (offset, n) = (ids.len() as u32, ring.len() / 2);
            for k in 0..n {
                ids.push(ring[first + 2 * k]);
                let ends = [offset + k as u32, offset + ((k + 1) % n) as u32];
                middle.insert([ends[0].min(ends[1]), ends[0].max(ends[1])], ring[(first + 2 * k + 1) % ring.len()]);
            }
        }
        ids.extend(inner.into_iter().map(|p| self.add(patch, p, work)).collect::<Vec<u32>>());
        let points: Vec<DVec3> = ids.iter().map(|&v| work.points[v as usize]).collect();
        for face in paired_triangles(&points, &triangles, context)?.iter() {
            self.halve(patch, face, &ids, &mut middle, work);
        }
        Ok(Some(()))
    }

    /// A quad in every corner of a face.
    fn halve(&self, patch: &Patch, face: &[u32], ids: &[u32], middle: &mut FxHashMap<[u32; 2], u32>, work: &mut Work) {
        let n = face.len();
        let mean = |list: &[u32], work: &Work| {
            list.iter().map(|&v| work.points[ids[v as usize] as usize]).sum::<DVec3>() / list.len() as f64
        };
        let mut middles = Vec::with_capacity(n);
        for k in 0..n {
            let [a, b] = [face[k], face[(k + 1) % n]];
            let m = *middle.entry([a.min(b), a.max(b)]).or_insert_with(|| self.add(patch, mean(&[a, b], work), work));
            middles.push(m);
        }
        let centre = self.add(patch, mean(face, work), work);
        for k in 0..n {
            self.push(patch, [ids[face[k] as usize], middles[k], centre, middles[(k + n - 1) % n]], work);
        }
    }

    /// Whether the even or the odd vertices of a loop are to be those of triangles: of which more are nodes.
    fn first(&self, list: &[Side]) -> usize {
        let (mut at, mut odd) = (0, 0);
        for s in list {
            odd += if at % 2 == 1 { 1 } else { -1 };
            at += self.layout.arcs[s.arc as usize].count;
        }
        usize::from(odd > 0)
    }
}

/// A polygon with straight sides; a circle for fewer than three.
struct Outline {
    counts: Vec<f64>,
    corners: Vec<DVec2>,
    total: f64,
}

impl Outline {
    fn new(counts: &[usize], corners: usize) -> Self {
        let counts: Vec<f64> = counts.iter().map(|&n| n as f64).collect();
        let total = counts.iter().sum();
        let corners = match (corners, &counts[..]) {
            (4, [a, b, c, d]) => {
                let (w, h) = (0.5 * (a + c), 0.5 * (b + d));
                vec![DVec2::ZERO, DVec2::new(w, 0.0), DVec2::new(w, h), DVec2::new(0.0, h)]
            }
            (c @ 3.., _) => (0..c).map(|k| DVec2::from_angle(TAU * k as f64 / c as f64)).collect(),
            _ => Vec::new(),
        };
        Outline { counts, corners, total }
    }

    /// The place so many edges along a side.
    fn at(&self, side: usize, x: f64) -> DVec2 {
        if self.corners.is_empty() {
            let before: f64 = self.counts[..side].iter().sum();
            return DVec2::from_angle(TAU * (before + x) / self.total);
        }
        let next = self.corners[(side + 1) % self.corners.len()];
        self.corners[side].lerp(next, x / self.counts[side])
    }
}

/// Puts both ends of a half-edge on the boundary to their places.
fn settle(chart: &Chart, given: &mut [Option<DVec2>], (h, ends): (u32, [f64; 2]), on: impl Fn(f64) -> DVec2) {
    for (corner, x) in [h, Sheet::next(h)].into_iter().zip(ends) {
        if let Some(v) = chart.tail(corner) {
            given[v].get_or_insert(on(x));
        }
    }
}

/// A patch in the plane: its outlines of new vertices, and the vertices of its chart.
struct Flat {
    outlines: Vec<Vec<DVec2>>,
    at: Vec<DVec2>,
    /// Of the plane over that of the patch, as a length.
    scale: f64,
}

/// The smallest scaled Jacobian of a grid of `m` quads a row: its outline's vertices are there, its inside is at `points`.
fn worst_shape(work: &Work, ids: &[u32], points: &[Option<DVec3>], m: usize) -> f64 {
    let at = |k: usize| if ids[k] == NONE { points[k] } else { Some(work.points[ids[k] as usize]) };
    let shape = |k: usize| match [k, k + 1, k + m + 2, k + m + 1].map(at) {
        [Some(a), Some(b), Some(c), Some(d)] => scaled_jacobian([a, b, c, d]),
        _ => f64::NEG_INFINITY,
    };
    (0..ids.len() - m - 1).filter(|k| k % (m + 1) < m).map(shape).fold(f64::INFINITY, f64::min)
}

/// Looked at from the side that most of it faces; `None` where some of it looks away, or meets itself along a cut.
fn projected(sheet: &Sheet, patch: &Patch, chart: &Chart, rings: &[Vec<u32>], work: &Work) -> Option<Flat> {
    let mean = patch.triangles.iter().map(|&t| sheet.normal(t) * sheet.area(t)).sum::<DVec3>().normalize_or_zero();
    let mut once = FxHashSet::default();
    if patch.triangles.iter().any(|&t| sheet.normal(t).dot(mean) < STEEPEST)
        || !rings.iter().flatten().all(|v| once.insert(*v))
    {
        return None;
    }
    let x = mean.any_orthonormal_vector();
    let y = mean.cross(x);
    let flat = |p: DVec3| DVec2::new(p.dot(x), p.dot(y));
    let outlines = rings.iter().map(|ring| ring.iter().map(|&v| flat(work.points[v as usize])).collect()).collect();
    let mut at = vec![DVec2::ZERO; chart.len()];
    for (vertices, points) in chart.faces() {
        vertices.iter().zip(points).for_each(|(&v, p)| at[v as usize] = flat(p));
    }
    Some(Flat { outlines, at, scale: 1.0 })
}

/// Unrolled into the plane, where that turns nothing over.
fn unrolled(layout: &Layout, patch: &Patch, chart: &Chart, along: &[Along]) -> Option<Flat> {
    let at = chart.unrolled().ok()??;
    let outline = |list: &Vec<Side>| -> Option<Vec<DVec2>> {
        let run = run(layout, along, list);
        let mut outline = Vec::with_capacity(run.ids.len());
        let mut places = run.places.iter().peekable();
        for k in 0..run.ids.len().saturating_sub(1) {
            let x = k as f64;
            while places.peek().is_some_and(|(_, ends)| ends[1] <= x) {
                places.next();
            }
            let &&(h, [from, to]) = places.peek()?;
            let [p, q] = [at[chart.tail(h)?], at[chart.tail(Sheet::next(h))?]];
            outline.push(p.lerp(q, ((x - from) / (to - from)).clamp(0.0, 1.0)));
        }
        Some(outline)
    };
    let outlines = patch.loops.iter().map(outline).collect::<Option<_>>()?;
    Some(Flat { outlines, at, scale: 1.0 })
}

/// A disc with its outline on a circle, in proportion to length.
fn on_circle(layout: &Layout, patch: &Patch, chart: &Chart, along: &[Along]) -> Result<Option<Flat>> {
    let [list] = &patch.loops[..] else { return Ok(None) };
    let total: f64 = list.iter().map(|s| layout.arcs[s.arc as usize].length).sum();
    let radius = total / TAU;
    let (mut outline, mut given, mut offset) = (Vec::new(), vec![None; chart.len()], 0.0);
    for s in list {
        let arc = &layout.arcs[s.arc as usize];
        let per_quad = arc.length / arc.count as f64;
        let on = |x: f64| DVec2::from_angle((offset + x * per_quad) / radius) * radius;
        outline.extend((0..arc.count).map(|k| on(k as f64)));
        run(layout, along, std::slice::from_ref(s)).places.iter().for_each(|p| settle(chart, &mut given, *p, on));
        offset += arc.length;
    }
    let scale = (std::f64::consts::PI * radius * radius / patch.area).sqrt();
    Ok(chart.spread(&given)?.map(|at| Flat { outlines: vec![outline], at, scale }))
}

/// New points inside, and triangles over the outlines and them.
type LaidOut = (Vec<DVec3>, Vec<[u32; 3]>);

fn laid_out(chart: &Chart, flat: Flat, length: f64, context: &Context) -> Option<LaidOut> {
    let planar::Filled { inner, mut triangles } = planar::fill(&flat.outlines, length * flat.scale, context).ok()?;
    let mut points = flat.outlines.concat();
    points.extend(&inner);
    share_flat_corners(&points, &mut triangles);
    let inner = inner.iter().map(|&q| chart.above(&flat.at, q)).collect::<Option<_>>()?;
    Some((inner, triangles))
}

/// Turns edges so that no triangle has a nearly straight corner of the outline to itself: its halves would, too.
///
/// ```text
///   b ──v── a        b ──v── a
///    ╲     ╱          ╲  │  ╱
///      ╲ ╱      from a ─ b to v ─ d
///       d                d
/// ```
fn share_flat_corners(points: &[DVec2], triangles: &mut [[u32; 3]]) {
    let at = |v: u32| points[v as usize];
    let is_flat = |v: u32, a: u32, b: u32| {
        let (to_a, to_b) = (at(a) - at(v), at(b) - at(v));
        to_a.dot(to_b) < FLAT * to_a.length() * to_b.length()
    };
    let turns_left = |[a, b, c]: [u32; 3]| (at(b) - at(a)).perp_dot(at(c) - at(a)) > 0.0;
    let mut count = vec![0u32; points.len()];
    triangles.as_flattened().iter().for_each(|&v| count[v as usize] += 1);
    let ears: Vec<usize> =
        (0..triangles.len()).filter(|&t| triangles[t].iter().any(|&v| count[v as usize] == 1)).collect();
    for ear in ears {
        for k in 0..3 {
            let [v, b, a] = [0, 1, 2].map(|j| triangles[ear][(k + j) % 3]);
            if count[v as usize] != 1 || !is_flat(v, a, b) {
                continue;
            }
            let across = |t: &[u32; 3]| (0..3).find(|&j| [t[j], t[(j + 1) % 3]] == [a, b]);
            let Some((other, j)) = triangles.iter().enumerate().find_map(|(n, t)| Some((n, across(t)?))) else {
                continue;
            };
            let d = triangles[other][(j + 2) % 3];
            let turned = [[v, b, d], [v, d, a]];
            let moves_on = |x: u32, y: u32| count[x as usize] == 2 && is_flat(x, y, d);
            if !turned.into_iter().all(turns_left) || moves_on(a, v) || moves_on(b, v) {
                continue;
            }
            (triangles[ear], triangles[other]) = (turned[0], turned[1]);
            for (x, by) in [(v, 1), (d, 1), (a, -1), (b, -1)] {
                count[x as usize] = count[x as usize].saturating_add_signed(by);
            }
            break;
        }
    }
}
