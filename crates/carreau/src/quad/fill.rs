//! Grids in regular patches: a patch is mapped to a rectangle, each side in proportion to length on every arc, the inside
//! by the mean of neighbours; the points of the grid are read off. Triangles, paired, in all others.

use super::chart::Chart;
use super::layout::{Arc, Layout, Patch, Side};
use super::pair::paired_triangles;
use super::sheet::Sheet;
use super::work::{Place, Work};
use crate::context::Context;
use crate::error::Result;
use crate::geometry::planar;
use crate::mesh::{NONE, Polygons};
use glam::{DVec2, DVec3};
use rustc_hash::FxHashSet;

/// Triangles are no smaller than this share of the wanted length, however short the arcs around are.
const SHORTEST: f64 = 0.7;
/// Patches that are laid flat have no normal farther from the mean than this cosine.
const STEEPEST: f64 = 0.3;

/// The faces of a layout with the patch of each, or a patch that takes neither a grid nor triangles.
pub type Filling = std::result::Result<(Work, Vec<u32>), usize>;

/// All faces of a layout: quads, and triangles where a patch has no grid. `place` tells where the vertices of the sheet belong.
pub fn fill(
    sheet: &Sheet,
    layout: &Layout,
    place: impl Fn(u32) -> Option<Place>,
    context: &Context,
) -> Result<Filling> {
    let _stage = context.stage("fill");
    let mut work = Work { faces: Polygons::new(), ..Work::default() };
    let mut node = vec![NONE; sheet.points.len()];
    let mut along: Vec<Vec<u32>> = Vec::new();
    for arc in &layout.arcs {
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
        for k in 1..arc.count {
            ids.push(add(point_on(sheet, arc, k as f64 / arc.count as f64), inner));
        }
        ids.push(node[arc.vertices[last] as usize]);
        if let Some(curve) = arc.curve {
            work.features.extend(ids.windows(2).map(|w| ([w[0], w[1]], curve)));
        }
        along.push(ids);
    }
    let mut patch_of_face = Vec::new();
    for (p, patch) in layout.patches.iter().enumerate() {
        context.check()?;
        let done = match &patch.sides {
            Some(sides) => grid(sheet, layout, patch, sides, &along, &mut work)?,
            None => triangles(sheet, layout, patch, &along, &mut work, context)?,
        };
        if done.is_none() {
            return Ok(Err(p));
        }
        patch_of_face.resize(work.faces.len(), p as u32);
    }
    Ok(Ok((work, patch_of_face)))
}

fn region_at(sheet: &Sheet, a: u32, b: u32) -> u32 {
    sheet.between(a, b).or_else(|| sheet.between(b, a)).map_or(0, |h| sheet.region[h as usize / 3])
}

/// The point at a station of an arc.
fn point_on(sheet: &Sheet, arc: &Arc, station: f64) -> DVec3 {
    let k = arc.stations.partition_point(|&s| s < station).clamp(1, arc.vertices.len() - 1);
    let [a, b] = [arc.vertices[k - 1], arc.vertices[k]].map(|v| sheet.points[v as usize]);
    let (from, to) = (arc.stations[k - 1], arc.stations[k]);
    a.lerp(b, if to > from { ((station - from) / (to - from)).clamp(0.0, 1.0) } else { 0.0 })
}

/// What runs along a side: its new vertices, and the half-edges of the sheet with the places of their ends, in units of quads.
struct Run {
    ids: Vec<u32>,
    places: Vec<(u32, [f64; 2])>,
}

fn run(layout: &Layout, along: &[Vec<u32>], side: &[Side]) -> Run {
    let (mut run, mut offset) = (Run { ids: Vec::new(), places: Vec::new() }, 0.0);
    for s in side {
        let arc = &layout.arcs[s.arc as usize];
        let (mut new, last) = (along[s.arc as usize].clone(), arc.stations.len() - 1);
        let station = |j: usize| if s.reversed { 1.0 - arc.stations[last - j] } else { arc.stations[j] };
        if s.reversed {
            new.reverse();
        }
        let place = |j: usize| offset + station(j) * arc.count as f64;
        run.places.extend(s.halves.iter().enumerate().map(|(j, &h)| (h, [place(j), place(j + 1)])));
        offset += arc.count as f64;
        run.ids.extend(&new[usize::from(!run.ids.is_empty())..]);
    }
    run
}

/// The grid of a patch.
fn grid(
    sheet: &Sheet,
    layout: &Layout,
    patch: &Patch,
    sides: &[Vec<Side>; 4],
    along: &[Vec<u32>],
    work: &mut Work,
) -> Result<Option<()>> {
    let sides = [0, 1, 2, 3].map(|k| run(layout, along, &sides[k]));
    let (m, n) = (sides[0].ids.len() - 1, sides[1].ids.len() - 1);
    if sides[2].ids.len() != m + 1 || sides[3].ids.len() != n + 1 {
        return Ok(None);
    }
    // Places of the boundary in the rectangle.
    let chart = Chart::new(sheet, &patch.triangles);
    let (w, h) = (m as f64, n as f64);
    let mut given = vec![None; chart.len()];
    for (k, side) in sides.iter().enumerate() {
        let on = |x: f64| [DVec2::new(x, 0.0), DVec2::new(w, x), DVec2::new(w - x, h), DVec2::new(0.0, h - x)][k];
        side.places.iter().for_each(|p| settle(&chart, &mut given, *p, on));
    }
    let Some(uv) = chart.spread(given)? else { return Ok(None) };
    let region = sheet.region[patch.triangles[0] as usize];
    // Vertices of the grid, row by row.
    let mut ids = vec![NONE; (m + 1) * (n + 1)];
    for i in 0..=m {
        (ids[i], ids[n * (m + 1) + i]) = (sides[0].ids[i], sides[2].ids[m - i]);
    }
    for j in 0..=n {
        (ids[j * (m + 1)], ids[j * (m + 1) + m]) = (sides[3].ids[n - j], sides[1].ids[j]);
    }
    let points = chart.read_off(&uv, m, n);
    for j in 1..n {
        for i in 1..m {
            let Some(p) = points[j * (m + 1) + i] else { return Ok(None) };
            ids[j * (m + 1) + i] = work.points.len() as u32;
            work.points.push(p);
            work.place.push(Place::Region(region));
        }
    }
    for j in 0..n {
        for i in 0..m {
            let at = |i: usize, j: usize| ids[j * (m + 1) + i];
            work.faces.push(&[at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
            work.region.push(region);
        }
    }
    Ok(Some(()))
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

/// Triangles of about the length of the sides around, paired, in a patch that has no grid.
fn triangles(
    sheet: &Sheet,
    layout: &Layout,
    patch: &Patch,
    along: &[Vec<u32>],
    work: &mut Work,
    context: &Context,
) -> Result<Option<()>> {
    let ring = |list: &Vec<Side>| {
        let mut ids = run(layout, along, list).ids;
        ids.pop();
        ids
    };
    let rings: Vec<Vec<u32>> = patch.loops.iter().map(ring).collect();
    let chart = Chart::new(sheet, &patch.triangles);
    let length = layout.length_around(patch).max(SHORTEST * layout.length);
    let mut filled = None;
    if let Some(flat) = projected(sheet, patch, &chart, &rings, work) {
        filled = laid_out(&chart, flat, length, context);
    }
    if filled.is_none()
        && let Some(flat) = unrolled(layout, patch, &chart, along)
    {
        filled = laid_out(&chart, flat, length, context);
    }
    if filled.is_none()
        && let Some(flat) = on_circle(layout, patch, &chart, along)?
    {
        filled = laid_out(&chart, flat, length, context);
    }
    let Some((inner, triangles)) = filled else { return Ok(None) };
    let region = sheet.region[patch.triangles[0] as usize];
    let mut ids = rings.concat();
    for p in inner {
        ids.push(work.points.len() as u32);
        work.points.push(p);
        work.place.push(Place::Region(region));
    }
    let faces: Vec<[u32; 3]> = triangles.iter().map(|t| t.map(|v| ids[v as usize])).collect();
    for face in paired_triangles(&work.points, &faces, context)?.iter() {
        work.faces.push(face);
        work.region.push(region);
    }
    Ok(Some(()))
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
fn unrolled(layout: &Layout, patch: &Patch, chart: &Chart, along: &[Vec<u32>]) -> Option<Flat> {
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
fn on_circle(layout: &Layout, patch: &Patch, chart: &Chart, along: &[Vec<u32>]) -> Result<Option<Flat>> {
    let [list] = &patch.loops[..] else { return Ok(None) };
    let total: f64 = list.iter().map(|s| layout.arcs[s.arc as usize].length).sum();
    let radius = total / std::f64::consts::TAU;
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
    Ok(chart.spread(given)?.map(|at| Flat { outlines: vec![outline], at, scale }))
}

/// New points inside, and triangles over the outlines and them.
type Filled = (Vec<DVec3>, Vec<[u32; 3]>);

fn laid_out(chart: &Chart, flat: Flat, length: f64, context: &Context) -> Option<Filled> {
    let filled = planar::fill(&flat.outlines, length * flat.scale, context).ok()?;
    let inner = filled.inner.iter().map(|&q| chart.above(&flat.at, q)).collect::<Option<_>>()?;
    Some((inner, filled.triangles))
}
