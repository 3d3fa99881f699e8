//! Grids in regular patches: a patch is mapped to a rectangle, each side in proportion to length on every arc, the inside
//! by the mean of neighbours (Tutte; positive weights, so that nothing folds); the points of the grid are read off.

use super::layout::{Arc, Layout, Patch, Side};
use super::pair::paired_triangles;
use super::sheet::Sheet;
use super::work::{Place, Work};
use crate::context::Context;
use crate::error::Result;
use crate::geometry::planar;
use crate::mesh::{NONE, Polygons};
use crate::numeric::sparse::Matrix;
use glam::{DVec2, DVec3};
use rustc_hash::FxHashMap;

/// Patches that are laid flat have no normal farther from the mean than this cosine.
const STEEPEST: f64 = 0.3;

/// All faces of a layout: quads, and triangles where a patch has no grid. `place` tells where the vertices of the sheet belong.
pub fn fill(
    sheet: &Sheet,
    layout: &Layout,
    place: impl Fn(u32) -> Option<Place>,
    context: &Context,
) -> Result<Option<Work>> {
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
    for patch in &layout.patches {
        context.check()?;
        let done = match &patch.sides {
            Some(sides) => grid(sheet, layout, patch, sides, &along, &mut work)?,
            None => triangles(sheet, layout, patch, &along, &mut work, context)?,
        };
        if done.is_none() {
            return Ok(None);
        }
    }
    Ok(Some(work))
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

/// The vertices of an arc with their stations, from either end.
fn stations(arc: &Arc, reversed: bool) -> Vec<(u32, f64)> {
    let mut all: Vec<(u32, f64)> = arc.vertices.iter().copied().zip(arc.stations.iter().copied()).collect();
    if reversed {
        all.reverse();
        all.iter_mut().for_each(|s| s.1 = 1.0 - s.1);
    }
    all
}

/// What runs along a side: its new vertices, and the vertices of the sheet with their places in units of quads.
fn run(layout: &Layout, along: &[Vec<u32>], side: &[Side]) -> (Vec<u32>, Vec<(u32, f64)>) {
    let (mut ids, mut places, mut offset): (Vec<u32>, Vec<(u32, f64)>, f64) = (Vec::new(), Vec::new(), 0.0);
    for s in side {
        let arc = &layout.arcs[s.arc as usize];
        let mut new = along[s.arc as usize].clone();
        if s.reversed {
            new.reverse();
        }
        places.extend(stations(arc, s.reversed).into_iter().map(|(v, at)| (v, offset + at * arc.count as f64)));
        offset += arc.count as f64;
        ids.extend(&new[usize::from(!ids.is_empty())..]);
    }
    (ids, places)
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
    let (m, n) = (sides[0].0.len() - 1, sides[1].0.len() - 1);
    if sides[2].0.len() != m + 1 || sides[3].0.len() != n + 1 {
        return Ok(None);
    }
    // Places of the boundary in the rectangle.
    let (w, h) = (m as f64, n as f64);
    let mut uv: FxHashMap<u32, DVec2> = FxHashMap::default();
    for (k, (_, places)) in sides.iter().enumerate() {
        for &(v, x) in places {
            let p = [DVec2::new(x, 0.0), DVec2::new(w, x), DVec2::new(w - x, h), DVec2::new(0.0, h - x)][k];
            uv.entry(v).or_insert(p);
        }
    }
    let Some(uv) = spread(sheet, &patch.triangles, uv)? else { return Ok(None) };
    let region = sheet.region[patch.triangles[0] as usize];
    // Vertices of the grid, row by row.
    let mut ids = vec![NONE; (m + 1) * (n + 1)];
    for i in 0..=m {
        (ids[i], ids[n * (m + 1) + i]) = (sides[0].0[i], sides[2].0[m - i]);
    }
    for j in 0..=n {
        (ids[j * (m + 1)], ids[j * (m + 1) + m]) = (sides[3].0[n - j], sides[1].0[j]);
    }
    let points = read_off(sheet, &patch.triangles, &uv, m, n);
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

/// A patch in the plane: its outlines of new vertices, and the vertices of the sheet.
struct Flat {
    outlines: Vec<Vec<DVec2>>,
    at: FxHashMap<u32, DVec2>,
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
        let (mut ids, _) = run(layout, along, list);
        ids.pop();
        ids
    };
    let rings: Vec<Vec<u32>> = patch.loops.iter().map(ring).collect();
    let mut filled = None;
    if let Some(flat) = projected(sheet, patch, &rings, work) {
        filled = laid_out(sheet, patch, flat, context);
    }
    if filled.is_none()
        && let Some(flat) = on_circle(sheet, layout, patch, &rings)?
    {
        filled = laid_out(sheet, patch, flat, context);
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

/// Looked at from the side that most of it faces; `None` where some of it looks away.
fn projected(sheet: &Sheet, patch: &Patch, rings: &[Vec<u32>], work: &Work) -> Option<Flat> {
    let mean = patch.triangles.iter().map(|&t| sheet.normal(t) * sheet.area(t)).sum::<DVec3>().normalize_or_zero();
    if patch.triangles.iter().any(|&t| sheet.normal(t).dot(mean) < STEEPEST) {
        return None;
    }
    let x = mean.any_orthonormal_vector();
    let y = mean.cross(x);
    let flat = |p: DVec3| DVec2::new(p.dot(x), p.dot(y));
    let outlines = rings.iter().map(|ring| ring.iter().map(|&v| flat(work.points[v as usize])).collect()).collect();
    let corners = patch.triangles.iter().flat_map(|&t| sheet.triangles[t as usize]);
    Some(Flat { outlines, at: corners.map(|v| (v, flat(sheet.points[v as usize]))).collect() })
}

/// A disc with its outline on a circle, in proportion to length.
fn on_circle(sheet: &Sheet, layout: &Layout, patch: &Patch, rings: &[Vec<u32>]) -> Result<Option<Flat>> {
    let ([list], [ring]) = (&patch.loops[..], rings) else { return Ok(None) };
    let total: f64 = list.iter().map(|s| layout.arcs[s.arc as usize].length).sum();
    let radius = total / std::f64::consts::TAU;
    let on = |distance: f64| DVec2::from_angle(distance / radius) * radius;
    let (mut outline, mut at, mut offset) = (Vec::with_capacity(ring.len()), FxHashMap::default(), 0.0);
    for s in list {
        let arc = &layout.arcs[s.arc as usize];
        outline.extend((0..arc.count).map(|k| on(offset + arc.length * k as f64 / arc.count as f64)));
        for (v, station) in stations(arc, s.reversed) {
            at.entry(v).or_insert_with(|| on(offset + station * arc.length));
        }
        offset += arc.length;
    }
    let at = spread(sheet, &patch.triangles, at)?;
    Ok(at.map(|at| Flat { outlines: vec![outline], at }))
}

/// New points inside, and triangles over the outlines and them.
type Filled = (Vec<DVec3>, Vec<[u32; 3]>);

fn laid_out(sheet: &Sheet, patch: &Patch, flat: Flat, context: &Context) -> Option<Filled> {
    let length = |l: &Vec<DVec2>| (0..l.len()).map(|k| l[k].distance(l[(k + 1) % l.len()])).sum::<f64>();
    let count = flat.outlines.iter().map(Vec::len).sum::<usize>().max(1);
    let mean = flat.outlines.iter().map(length).sum::<f64>() / count as f64;
    let filled = planar::fill(&flat.outlines, mean, context).ok()?;
    let inner = filled.inner.iter().map(|&q| above(sheet, &patch.triangles, &flat.at, q)).collect::<Option<_>>()?;
    Some((inner, filled.triangles))
}

/// The point of the triangles over a point of the plane.
fn above(sheet: &Sheet, triangles: &[u32], at: &FxHashMap<u32, DVec2>, q: DVec2) -> Option<DVec3> {
    let mut best: (f64, Option<DVec3>) = (f64::NEG_INFINITY, None);
    for &t in triangles {
        let corners = sheet.triangles[t as usize];
        let p = [at.get(&corners[0])?, at.get(&corners[1])?, at.get(&corners[2])?];
        let area = (p[1] - p[0]).perp_dot(p[2] - p[0]);
        let w = [0, 1, 2].map(|k| (p[(k + 1) % 3] - q).perp_dot(p[(k + 2) % 3] - q) / area);
        let inside = w[0].min(w[1]).min(w[2]);
        if inside > best.0 && inside.is_finite() {
            // Over no triangle: the nearest place of the nearest one.
            let w = w.map(|w| w.max(0.0));
            let sum = w[0] + w[1] + w[2];
            best = (inside, Some((0..3).map(|k| sheet.points[corners[k] as usize] * (w[k] / sum)).sum()));
        }
    }
    best.1
}

/// Every vertex inside at the weighted mean of its neighbours.
fn spread(sheet: &Sheet, triangles: &[u32], mut uv: FxHashMap<u32, DVec2>) -> Result<Option<FxHashMap<u32, DVec2>>> {
    let mut number: FxHashMap<u32, u32> = FxHashMap::default();
    let mut inner = Vec::new();
    for &t in triangles {
        for v in sheet.triangles[t as usize] {
            if !uv.contains_key(&v) && !number.contains_key(&v) {
                number.insert(v, inner.len() as u32);
                inner.push(v);
            }
        }
    }
    if inner.is_empty() {
        return Ok(Some(uv));
    }
    let mut matrix = Matrix::new(inner.len());
    let mut rhs = [vec![0.0; inner.len()], vec![0.0; inner.len()]];
    for &t in triangles {
        for k in 0..3 {
            let [a, b] = [0, 1].map(|d| sheet.triangles[t as usize][(k + d) % 3]);
            let weight = 1.0 / sheet.points[a as usize].distance(sheet.points[b as usize]).max(f64::MIN_POSITIVE);
            for (v, other) in [(a, b), (b, a)] {
                let Some(&i) = number.get(&v) else { continue };
                matrix.add(i, i, weight);
                match number.get(&other) {
                    Some(&j) if j < i => matrix.add(i, j, -weight),
                    Some(_) => {}
                    None => {
                        let Some(p) = uv.get(&other) else { return Ok(None) };
                        rhs[0][i as usize] += weight * p.x;
                        rhs[1][i as usize] += weight * p.y;
                    }
                }
            }
        }
    }
    let factor = matrix.factor(&mut None)?;
    let (x, y) = (factor.solve(&rhs[0])?, factor.solve(&rhs[1])?);
    for (k, v) in inner.into_iter().enumerate() {
        uv.insert(v, DVec2::new(x[k], y[k]));
    }
    Ok(Some(uv))
}

/// The points of the surface at whole coordinates inside.
fn read_off(sheet: &Sheet, triangles: &[u32], uv: &FxHashMap<u32, DVec2>, m: usize, n: usize) -> Vec<Option<DVec3>> {
    /// How far outside a triangle counts as inside.
    const SLACK: f64 = 1e-9;
    let mut best: Vec<(f64, Option<DVec3>)> = vec![(-1e-3, None); (m + 1) * (n + 1)];
    for &t in triangles {
        let corners = sheet.triangles[t as usize];
        let Some(p) = corners.iter().map(|v| uv.get(v).copied()).collect::<Option<Vec<DVec2>>>() else { continue };
        let area = (p[1] - p[0]).perp_dot(p[2] - p[0]);
        if area.abs() < 1e-14 {
            continue;
        }
        let low = p[0].min(p[1]).min(p[2]).floor().max(DVec2::ONE);
        let high = p[0].max(p[1]).max(p[2]).ceil().min(DVec2::new(m as f64 - 1.0, n as f64 - 1.0));
        for j in low.y as usize..=high.y.max(0.0) as usize {
            for i in low.x as usize..=high.x.max(0.0) as usize {
                let q = DVec2::new(i as f64, j as f64);
                let w = [0, 1, 2].map(|k| (p[(k + 1) % 3] - q).perp_dot(p[(k + 2) % 3] - q) / area);
                let inside = w[0].min(w[1]).min(w[2]).min(SLACK);
                let of = &mut best[j * (m + 1) + i];
                if inside > of.0 {
                    let at = (0..3).map(|k| sheet.points[corners[k] as usize] * w[k]).sum();
                    *of = (inside, Some(at));
                }
            }
        }
    }
    best.into_iter().map(|b| b.1).collect()
}
