//! The wall of a mesh: the thickness of the layers on it, and their cells.

use super::options::{LayerFigures, Layers};
use crate::error::{Error, Result};
use crate::geometry::hexes::is_certified;
use crate::geometry::search_tree::TriangleTree;
use crate::hex::disc::disc;
use crate::mesh::{HexMesh, boundary_faces, split_quad};
use glam::DVec3;
use rustc_hash::FxHashMap;

/// Layers take this share of the way to the opposite wall at most: 70 % of the radius of a tube.
const MOST_OF_WAY: f64 = 0.35;
/// The thickness changes by at most this share of the way along the wall.
const SLOPE: f64 = 0.5;
/// Rounds in which a thin place thins those around it, by a ring of vertices each.
const EVENING_ROUNDS: usize = 16;
/// Share of their thickness to which layers are thinned around weak cells, round by round.
const THINNED: f64 = 0.75;
/// Where normals of faces at a vertex differ much the way is not made longer than this for the thickness to hold.
const LONGEST_WAY: f64 = 1.5;
/// Layers this near to the thickness asked for count as such.
const NEARLY_AS_ASKED: f64 = 0.1;

/// The wall of a mesh.
pub(super) struct Wall {
    /// Its faces, outward, and the cell behind each.
    pub(super) quads: Vec<[u32; 4]>,
    pub(super) cells: Vec<u32>,
    /// Its vertices, ascending.
    pub(super) vertices: Vec<u32>,
    /// The way inwards from each of them along which layers have a thickness of 1.
    pub(super) inward: Vec<DVec3>,
    /// The thickness of the layers there.
    pub(super) thickness: Vec<f64>,
    /// The normals of the ends that vertices lie on, two where ends meet.
    pub(super) planes: FxHashMap<u32, Vec<DVec3>>,
    /// Whether a vertex of the mesh is on its boundary.
    pub(super) on_boundary: Vec<bool>,
}

impl Wall {
    pub(super) fn of(mesh: &HexMesh, thickness: f64) -> Wall {
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
        wall.thickness = room.into_iter().map(|room| thickness.min(MOST_OF_WAY * room)).collect();
        wall.even_out(mesh);
        wall
    }

    pub(super) fn place(&self, v: u32) -> Option<usize> {
        self.vertices.binary_search(&v).ok()
    }

    /// Where the layers are thin, those around thin out towards it.
    pub(super) fn even_out(&mut self, mesh: &HexMesh) {
        let at = |v: u32| mesh.points[v as usize];
        let sides: Vec<(usize, usize, f64)> = self
            .quads
            .iter()
            .flat_map(|q| (0..4).map(move |k| [q[k], q[(k + 1) % 4]]))
            .filter_map(|[a, b]| Some((self.place(a)?, self.place(b)?, SLOPE * at(a).distance(at(b)))))
            .collect();
        // Every side is met in both senses, and the reach of a thin place ends after some rings.
        for _ in 0..EVENING_ROUNDS {
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

    pub(super) fn thin(&mut self, places: &[usize]) {
        places.iter().for_each(|&k| self.thickness[k] *= THINNED);
    }

    /// Where the vertices of the layers are over a wall vertex: from inside to the wall.
    pub(super) fn column(&self, mesh: &HexMesh, points: &[DVec3], layers: &Layers, v: u32) -> Vec<DVec3> {
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
    pub(super) fn weak_columns<'a>(
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

    pub(super) fn figures(&self, mesh: &HexMesh, points: &[DVec3], asked: Layers) -> LayerFigures {
        let total = asked.thickness();
        let (mut area, mut good, mut least) = (0.0, 0.0, (f64::INFINITY, DVec3::ZERO));
        for q in &self.quads {
            let p = q.map(|v| mesh.points[v as usize]);
            let vector = 0.5 * (p[2] - p[0]).cross(p[3] - p[1]);
            let normal = vector.normalize_or_zero();
            let depth = q.iter().map(|&v| (mesh.points[v as usize] - points[v as usize]).dot(normal)).sum::<f64>();
            let share = 0.25 * depth / total;
            area += vector.length();
            if (share - 1.0).abs() <= NEARLY_AS_ASKED {
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
    pub(super) fn fill(&self, mesh: &mut HexMesh, points: Vec<DVec3>, layers: &Layers) -> Result<()> {
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
pub fn planes(mesh: &HexMesh) -> FxHashMap<u32, Vec<DVec3>> {
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
pub fn within(planes: Option<&Vec<DVec3>>, v: DVec3) -> DVec3 {
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

fn sorted(mut q: [u32; 4]) -> [u32; 4] {
    q.sort_unstable();
    q
}

fn pair(a: u32, b: u32) -> [u32; 2] {
    [a.min(b), a.max(b)]
}
