//! Boundary layers: thin cells on the wall, whose thickness grows inwards in proportion, as flow solvers want them.
//!
//! Padding (section 4 of the paper) graded: the whole mesh shrinks by the thickness of all layers, and these fill the gap.
//!
//! ```text
//!   p ──┬──┬── wall          p ──┬──┬──   first
//!       │  │                   ──┼──┼──   first × growth
//!       │  │        →          ──┼──┼──   first × growth²
//!       │  │                 q ──┼──┼──
//!     ──┴──┴──                 ──┴──┴──
//! ```
//!
//! 1. Every wall vertex p gets a place q inside, along the wall's normal (at the rim of an end: in the plane of that), so
//!    far that the layers have the thickness asked for; less where the room to the opposite wall is narrow.
//! 2. The vertices inside follow: a harmonic displacement shrinks a round section in proportion.
//! 3. Where cells would become weak, or lose their certificate, the layers are thinned, and 2 is done again.
//! 4. The inside is smoothed with its boundary held.

use super::extend::disc;
use super::optimise::{INNER, Optimiser};
use super::{HexResult, MOST_HEXES};
use crate::context::Context;
use crate::error::{Error, Result};
use crate::geometry::hexes::is_certified;
use crate::geometry::search_tree::TriangleTree;
use crate::mesh::{HEX_EDGES, HexMesh, UnitScale, boundary_faces, split_quad};
use glam::DVec3;
use rustc_hash::FxHashMap;
use serde::{Deserialize, Serialize};

/// Boundary layers that are asked for.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Layers {
    /// Their number.
    pub count: u32,
    /// Thickness of the first one, on the wall, in the unit of the file.
    pub first: f64,
    /// Every layer is so many times as thick as the one before it.
    pub growth: f64,
}

/// Growth where nothing else is said: what solvers for turbulent flow take as a rule.
pub const GROWTH: f64 = 1.2;
/// More layers, and steeper growth, are refused: the last layer would be thicker than any room.
pub const MOST_LAYERS: u32 = 50;
pub const STEEPEST: f64 = 3.0;
/// Layers take this share of the way to the opposite wall at most: 70 % of the radius of a tube.
const ROOM: f64 = 0.35;
/// The thickness changes by at most this share of the way along the wall.
const SLOPE: f64 = 0.5;
/// Cells inside keep this share of their scaled Jacobian when they shrink.
const KEPT: f64 = 0.4;
/// Layers are thinned to this share around weak cells, in so many rounds at most.
const THINNED: f64 = 0.75;
const ROUNDS: usize = 16;
/// Where that is not enough all of the wall's are halved, so often at most.
const HALVINGS: usize = 6;
/// Rings of cells around a weak one whose wall vertices are thinned at first.
const RINGS: usize = 2;
/// Sweeps of the harmonic displacement, and its over-relaxation.
const SWEEPS: usize = 120;
const RELAXATION: f64 = 1.6;
/// Where normals of faces at a vertex differ much the way is not made longer than this for the thickness to hold.
const LONGEST_WAY: f64 = 1.5;
/// Layers this near to the thickness asked for count as such.
const NEAR: f64 = 0.1;
/// The user is told where they are on less than this share of the wall.
const MOST_OF_THE_WALL: f64 = 0.95;

/// What has become of layers; lengths in the unit of the file.
#[derive(Debug, Clone, Serialize)]
pub struct LayerFigures {
    /// What was asked for.
    #[serde(flatten)]
    pub asked: Layers,
    /// The thickness of all together that was asked for.
    pub thickness: f64,
    /// The share of the wall, by area, where they are that thick within a tenth, along the wall's normal.
    pub as_asked: f64,
    /// The least thickness as a share of that asked for, and where it is.
    pub least: f64,
    /// Where that is.
    pub least_at: [f64; 3],
}

impl Layers {
    /// The same lengths in another scale.
    pub(super) fn in_scale(self, scale: UnitScale) -> Layers {
        Layers { first: scale.length(self.first), ..self }
    }

    /// The thickness of all layers together.
    pub fn thickness(&self) -> f64 {
        self.first * self.heights().iter().sum::<f64>()
    }

    /// The thickness of every layer from the wall inwards, as a multiple of the first.
    fn heights(&self) -> Vec<f64> {
        (0..self.count as i32).map(|k| self.growth.powi(k)).collect()
    }
}

impl LayerFigures {
    /// What is to be said where the layers are thinner than asked.
    pub(super) fn warning(&self) -> Option<String> {
        let ([x, y, z], share, least) = (self.least_at, 100.0 * (1.0 - self.as_asked), self.least);
        (self.as_asked < MOST_OF_THE_WALL).then(|| {
            format!(
                "the layers are not as thick as asked on {share:.1}% of the wall, because there is no room; least {least:.2} \
                 of the thickness near {x:.6} {y:.6} {z:.6}"
            )
        })
    }

    pub(super) fn in_scale(self, scale: UnitScale) -> LayerFigures {
        LayerFigures {
            asked: self.asked.in_scale(scale),
            thickness: scale.length(self.thickness),
            least_at: scale.point(DVec3::from(self.least_at)).to_array(),
            ..self
        }
    }
}

/// Puts layers on the wall of a mesh that has its boundary and tags.
pub fn add(result: &mut HexResult, layers: Layers, context: &Context) -> Result<()> {
    let _stage = context.stage("layers");
    let of_wall = result.mesh.tags.iter().filter(|tag| **tag == 1).count() as f64;
    if result.mesh.hexes.len() as f64 + f64::from(layers.count) * of_wall > MOST_HEXES {
        return Err(Error::Options(format!("{} layers would take too many hexes", layers.count)));
    }
    let mut wall = Wall::of(&result.mesh, layers.thickness());
    let inside = Inside::of(&result.mesh, &wall);
    let optimiser = Optimiser::new(&result.mesh.points, &result.mesh.hexes);
    let floors: Vec<f64> = optimiser.qualities(&result.mesh.points).into_iter().map(|q| KEPT * q).collect();
    let mut moves = vec![DVec3::ZERO; result.mesh.points.len()];
    let mut points = result.mesh.points.clone();
    for round in 0..ROUNDS + HALVINGS {
        context.check()?;
        inside.follow(&wall, &mut moves, context)?;
        points = result.mesh.points.iter().zip(&moves).map(|(p, m)| *p + *m).collect();
        let mut weak = optimiser.weak(&points, &floors);
        weak.extend(wall.weak_columns(&result.mesh, &points, &layers).map(|f| wall.cells[f]));
        tracing::debug!(round, weak = weak.len(), "layers");
        if weak.is_empty() {
            break;
        }
        weak.sort_unstable();
        weak.dedup();
        if round < ROUNDS {
            // What stays weak has its reason farther away.
            wall.thin(&inside.wall_near(&result.mesh, &wall, &weak, RINGS + round / 4));
        } else {
            wall.thickness.iter_mut().for_each(|t| *t *= 0.5);
            moves.iter_mut().for_each(|m| *m *= 0.5);
        }
    }
    let mut inner = Optimiser::new(&points, &result.mesh.hexes);
    inner.fix(wall.on_boundary.clone());
    inner.run(&mut points, &INNER, context)?;
    let figures = wall.figures(&result.mesh, &points, layers);
    result.figures.layers = Some(figures);
    wall.fill(&mut result.mesh, points, &layers)?;
    let outermost = |k: usize| (result.bases.len() + (k + 1) * layers.count as usize - 1) as u32;
    let outermost: Vec<u32> = (0..wall.vertices.len()).map(outermost).collect();
    wall.vertices.iter().zip(&outermost).for_each(|(&v, &out)| result.bases[v as usize] = out);
    result.bases.extend(outermost.iter().flat_map(|&out| std::iter::repeat_n(out, layers.count as usize)));
    result.origins = (0..result.mesh.quads.len() as u32).collect();
    Ok(())
}

/// The wall of a mesh.
struct Wall {
    /// Its faces, outward, and the cell behind each.
    quads: Vec<[u32; 4]>,
    cells: Vec<u32>,
    /// Its vertices, ascending.
    vertices: Vec<u32>,
    /// The way inwards from each of them along which layers have a thickness of 1.
    inward: Vec<DVec3>,
    /// The thickness of the layers there.
    thickness: Vec<f64>,
    /// The normals of the ends that vertices lie on, two where ends meet.
    planes: FxHashMap<u32, Vec<DVec3>>,
    /// Whether a vertex of the mesh is on its boundary.
    on_boundary: Vec<bool>,
}

impl Wall {
    fn of(mesh: &HexMesh, thickness: f64) -> Wall {
        let faces = boundary_faces(&mesh.hexes);
        let cell_of: FxHashMap<[u32; 4], u32> = faces.iter().map(|(q, h)| (sorted(*q), *h)).collect();
        let of_wall = mesh.quads.iter().zip(&mesh.tags).filter(|(_, tag)| **tag == 1);
        let quads: Vec<[u32; 4]> = of_wall.map(|(q, _)| *q).collect();
        let cells = quads.iter().map(|q| cell_of.get(&sorted(*q)).copied().unwrap_or(0)).collect();
        let mut vertices = quads.as_flattened().to_vec();
        vertices.sort_unstable();
        vertices.dedup();
        let mut on_boundary = vec![false; mesh.points.len()];
        mesh.quads.as_flattened().iter().for_each(|&v| on_boundary[v as usize] = true);
        let planes = planes(mesh);
        let inward = inward(mesh, &quads, &vertices, &planes);
        let room = room(mesh, &quads, &vertices, &inward);
        let mut wall = Wall { quads, cells, vertices, inward, thickness: Vec::new(), planes, on_boundary };
        wall.thickness = room.into_iter().map(|room| thickness.min(ROOM * room)).collect();
        wall.even_out(mesh);
        wall
    }

    fn place(&self, v: u32) -> Option<usize> {
        self.vertices.binary_search(&v).ok()
    }

    /// Where the layers are thin, those around thin out towards it.
    fn even_out(&mut self, mesh: &HexMesh) {
        let at = |v: u32| mesh.points[v as usize];
        let sides: Vec<(usize, usize, f64)> = self
            .quads
            .iter()
            .flat_map(|q| (0..4).map(move |k| [q[k], q[(k + 1) % 4]]))
            .filter_map(|[a, b]| Some((self.place(a)?, self.place(b)?, SLOPE * at(a).distance(at(b)))))
            .collect();
        // Every side is met in both senses, and the reach of a thin place ends after some rings.
        for _ in 0..ROUNDS {
            let mut any = false;
            for &(a, b, step) in &sides {
                let (ta, tb) = (self.thickness[a], self.thickness[b]);
                self.thickness[a] = ta.min(tb + step);
                self.thickness[b] = tb.min(ta + step);
                any |= self.thickness[a] < ta || self.thickness[b] < tb;
            }
            if !any {
                break;
            }
        }
    }

    fn thin(&mut self, places: &[usize]) {
        places.iter().for_each(|&k| self.thickness[k] *= THINNED);
    }

    /// Where the vertices of the layers are over a wall vertex: from inside to the wall.
    fn column(&self, mesh: &HexMesh, points: &[DVec3], layers: &Layers, v: u32) -> Vec<DVec3> {
        let (q, p) = (points[v as usize], mesh.points[v as usize]);
        let heights = layers.heights();
        let all: f64 = heights.iter().sum();
        let mut left = all;
        let mut column: Vec<DVec3> = vec![p];
        for height in &heights {
            left -= height;
            column.push(if left > 1e-9 * all { q.lerp(p, left / all) } else { q });
        }
        column.reverse();
        column
    }

    /// The wall faces with a layer that has no certificate.
    fn weak_columns<'a>(
        &'a self,
        mesh: &'a HexMesh,
        points: &'a [DVec3],
        layers: &'a Layers,
    ) -> impl Iterator<Item = usize> + 'a {
        (0..self.quads.len()).filter(move |&f| {
            let columns = self.quads[f].map(|v| self.column(mesh, points, layers, v));
            (0..layers.count as usize).any(|k| {
                let corners = std::array::from_fn(|c| columns[c % 4][k + c / 4]);
                !is_certified(&corners)
            })
        })
    }

    fn figures(&self, mesh: &HexMesh, points: &[DVec3], asked: Layers) -> LayerFigures {
        let total = asked.thickness();
        let (mut area, mut good, mut least) = (0.0, 0.0, (f64::INFINITY, DVec3::ZERO));
        for q in &self.quads {
            let p = q.map(|v| mesh.points[v as usize]);
            let vector = 0.5 * (p[2] - p[0]).cross(p[3] - p[1]);
            let normal = vector.normalize_or_zero();
            let depth = q.iter().map(|&v| (mesh.points[v as usize] - points[v as usize]).dot(normal)).sum::<f64>();
            let share = 0.25 * depth / total;
            area += vector.length();
            if (share - 1.0).abs() <= NEAR {
                good += vector.length();
            }
            if share < least.0 {
                least = (share, 0.25 * p.iter().sum::<DVec3>());
            }
        }
        let as_asked = if area > 0.0 { good / area } else { 0.0 };
        LayerFigures { asked, thickness: total, as_asked, least: least.0, least_at: least.1.to_array() }
    }

    /// The mesh with its inside at new places and the layers around it.
    fn fill(&self, mesh: &mut HexMesh, points: Vec<DVec3>, layers: &Layers) -> Result<()> {
        let count = layers.count as usize;
        if points.len() + count * self.vertices.len() > u32::MAX as usize {
            return Err(Error::Options(format!("{count} layers would take too many vertices")));
        }
        let first = points.len() as u32;
        let columns: Vec<Vec<DVec3>> = self.vertices.iter().map(|&v| self.column(mesh, &points, layers, v)).collect();
        mesh.points = points;
        columns.iter().for_each(|column| mesh.points.extend_from_slice(&column[1..]));
        let vertex = |v: u32, level: usize| match (level, self.place(v)) {
            (0, _) | (_, None) => v,
            (level, Some(k)) => first + (k * count + level - 1) as u32,
        };
        let mut tags: FxHashMap<[u32; 4], i32> = FxHashMap::default();
        let mut rims: FxHashMap<[u32; 2], i32> = FxHashMap::default();
        for (q, &tag) in mesh.quads.iter().zip(&mesh.tags).filter(|(_, tag)| **tag > 1) {
            tags.insert(sorted(*q), tag);
            rims.extend((0..4).map(|k| (pair(q[k], q[(k + 1) % 4]), tag)));
        }
        for level in 0..count {
            for q in &self.quads {
                let [low, high] = [level, level + 1].map(|l| q.map(|v| vertex(v, l)));
                mesh.hexes.push([low[0], low[1], low[2], low[3], high[0], high[1], high[2], high[3]]);
                for k in 0..4 {
                    let next = (k + 1) % 4;
                    if let Some(&tag) = rims.get(&pair(q[k], q[next])) {
                        tags.insert(sorted([low[k], low[next], high[next], high[k]]), tag);
                    }
                }
            }
        }
        mesh.quads = boundary_faces(&mesh.hexes).into_iter().map(|f| f.0).collect();
        mesh.tags = mesh.quads.iter().map(|q| tags.get(&sorted(*q)).copied().unwrap_or(1)).collect();
        Ok(())
    }
}

/// The normals of the ends at the vertices of these.
pub(super) fn planes(mesh: &HexMesh) -> FxHashMap<u32, Vec<DVec3>> {
    let mut planes: FxHashMap<u32, Vec<DVec3>> = FxHashMap::default();
    for tag in 2..=mesh.tags.iter().copied().max().unwrap_or(1) {
        let faces: Vec<usize> = (0..mesh.quads.len()).filter(|&f| mesh.tags[f] == tag).collect();
        let Some((_, normal, _)) = disc(mesh, &faces) else { continue };
        let mut vertices: Vec<u32> = faces.iter().flat_map(|&f| mesh.quads[f]).collect();
        vertices.sort_unstable();
        vertices.dedup();
        vertices.into_iter().for_each(|v| planes.entry(v).or_default().push(normal));
    }
    planes
}

/// Takes away what leads out of planes.
pub(super) fn within(planes: Option<&Vec<DVec3>>, v: DVec3) -> DVec3 {
    planes.into_iter().flatten().fold(v, |v, n| v - *n * n.dot(v))
}

/// Inwards along the wall's normal from each of its vertices, so long that a plane through its end parallel to a face there is
/// 1 from that, on average.
fn inward(mesh: &HexMesh, quads: &[[u32; 4]], vertices: &[u32], planes: &FxHashMap<u32, Vec<DVec3>>) -> Vec<DVec3> {
    let place = |v: u32| vertices.binary_search(&v).ok();
    let corners = |q: &[u32; 4]| -> Vec<(usize, DVec3)> {
        let p = q.map(|v| mesh.points[v as usize]);
        let normal = |k: usize| (p[(k + 1) % 4] - p[k]).cross(p[(k + 3) % 4] - p[k]).normalize_or_zero();
        (0..4).filter_map(|k| Some((place(q[k])?, normal(k)))).collect()
    };
    let at_corners: Vec<(usize, DVec3)> = quads.iter().flat_map(corners).collect();
    let mut sums = vec![DVec3::ZERO; vertices.len()];
    at_corners.iter().for_each(|&(k, normal)| sums[k] += normal);
    let units: Vec<DVec3> =
        sums.iter().zip(vertices).map(|(s, v)| within(planes.get(v), *s).normalize_or_zero()).collect();
    let mut cosines = vec![(0.0, 0.0); vertices.len()];
    for &(k, normal) in &at_corners {
        cosines[k] = (cosines[k].0 + normal.dot(units[k]), cosines[k].1 + 1.0);
    }
    let longer = |(sum, count): (f64, f64)| (f64::max(count, 1.0) / f64::max(sum, 1e-9)).clamp(1.0, LONGEST_WAY);
    units.into_iter().zip(cosines).map(|(unit, cosine)| -unit * longer(cosine)).collect()
}

/// The way from every wall vertex to the opposite wall.
fn room(mesh: &HexMesh, quads: &[[u32; 4]], vertices: &[u32], inward: &[DVec3]) -> Vec<f64> {
    let triangles: Vec<[u32; 3]> = quads.iter().flat_map(|&q| split_quad(&mesh.points, q)).collect();
    let tree = TriangleTree::new(&mesh.points, &triangles);
    let way = |(&v, inward): (&u32, &DVec3)| {
        let (from, direction) = (mesh.points[v as usize], inward.normalize_or_zero());
        let mut way = f64::INFINITY;
        tree.along_ray(from, direction, f64::INFINITY, |hit| {
            let is_own = triangles[hit.triangle as usize].contains(&v);
            if !is_own && !hit.front && hit.t > 0.0 {
                way = way.min(hit.t);
            }
        });
        way
    };
    vertices.iter().zip(inward).map(way).collect()
}

/// The edges of a mesh around each vertex, and how its inside follows the wall.
struct Inside {
    offsets: Vec<u32>,
    /// Neighbours with their weights.
    around: Vec<(u32, f64)>,
    is_wall: Vec<bool>,
}

impl Inside {
    fn of(mesh: &HexMesh, wall: &Wall) -> Inside {
        let mut edges: Vec<[u32; 2]> =
            mesh.hexes.iter().flat_map(|h| HEX_EDGES.iter().flat_map(|&[a, b]| [[h[a], h[b]], [h[b], h[a]]])).collect();
        edges.sort_unstable();
        edges.dedup();
        let mut offsets = vec![0u32; mesh.points.len() + 1];
        edges.iter().for_each(|e| offsets[e[0] as usize + 1] += 1);
        (0..mesh.points.len()).for_each(|v| offsets[v + 1] += offsets[v]);
        let weight = |&[a, b]: &[u32; 2]| {
            let length = mesh.points[a as usize].distance(mesh.points[b as usize]);
            (b, 1.0 / length.max(f64::MIN_POSITIVE))
        };
        let mut is_wall = vec![false; mesh.points.len()];
        wall.vertices.iter().for_each(|&v| is_wall[v as usize] = true);
        Inside { offsets, around: edges.iter().map(weight).collect(), is_wall }
    }

    fn around(&self, v: usize) -> &[(u32, f64)] {
        &self.around[self.offsets[v] as usize..self.offsets[v + 1] as usize]
    }

    /// The displacement of all vertices: that of the wall as it is, inside the mean of those around.
    fn follow(&self, wall: &Wall, moves: &mut [DVec3], context: &Context) -> Result<()> {
        for (k, &v) in wall.vertices.iter().enumerate() {
            moves[v as usize] = wall.inward[k] * wall.thickness[k];
        }
        for _ in 0..SWEEPS {
            context.check()?;
            for v in (0..moves.len()).filter(|&v| !self.is_wall[v]) {
                let (sum, weight) = self.around(v).iter().fold((DVec3::ZERO, 0.0), |(sum, all), &(w, weight)| {
                    (sum + moves[w as usize] * weight, all + weight)
                });
                let mean = sum / f64::max(weight, f64::MIN_POSITIVE);
                let next = moves[v] + RELAXATION * (mean - moves[v]);
                moves[v] = within(wall.planes.get(&(v as u32)), next);
            }
        }
        Ok(())
    }

    /// The wall vertices of cells and of those some rings around them, or as many rings as it takes to reach the wall; as places.
    fn wall_near(&self, mesh: &HexMesh, wall: &Wall, cells: &[u32], rings: usize) -> Vec<usize> {
        let mut seen = vec![false; mesh.points.len()];
        let mut front: Vec<u32> = cells.iter().flat_map(|&h| mesh.hexes[h as usize]).collect();
        let mut found = Vec::new();
        for ring in 0.. {
            front.retain(|&v| !std::mem::replace(&mut seen[v as usize], true));
            found.extend(front.iter().filter_map(|&v| wall.place(v)));
            if front.is_empty() || (ring >= rings && !found.is_empty()) {
                break;
            }
            front = front.iter().flat_map(|&v| self.around(v as usize).iter().map(|a| a.0)).collect();
        }
        found.sort_unstable();
        found
    }
}

fn sorted(mut q: [u32; 4]) -> [u32; 4] {
    q.sort_unstable();
    q
}

fn pair(a: u32, b: u32) -> [u32; 2] {
    [a.min(b), a.max(b)]
}
