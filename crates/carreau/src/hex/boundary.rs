//! The boundary of a mesh: what each of its vertices belongs to, and moves of all of them at once.

use super::target::{AGREES, Part, Seen, Target};
use crate::mesh::boundary_faces;
use glam::DVec3;
use rayon::prelude::*;

/// Distance, as a share of the size of the boundary's faces, from which the surface bulges away from the boundary.
const BULGE: f64 = 0.3;
/// The same as a share of the surface's diagonal: the smaller of both counts.
const FAR_BULGE: f64 = 0.01;
/// Number of places at which bulges are looked for, about.
const BULGE_SAMPLES: usize = 20_000;
/// Wall vertices lie off the surface by no more than this share of its diagonal, for the sake of the faces between them.
pub const SWELL: f64 = 9.5e-5;
/// By this share of the sag of the faces around: where these are the sides of a regular polygon of many, it has the area of the
/// circle then.
const SAG: f64 = 2.0 / 3.0;

/// The boundary of a mesh, and what its vertices belong to.
pub struct Skin {
    /// Its faces.
    pub quads: Vec<[u32; 4]>,
    /// What every vertex of the mesh belongs to.
    pub parts: Vec<Part>,
}

/// The boundary where its vertices are: unit normals, and the longest side of the faces at each.
pub struct Shape {
    pub normals: Vec<DVec3>,
    pub sizes: Vec<f64>,
}

impl Skin {
    /// `caps` numbers the end of every vertex from 1, `lid_of` the lid of every end, from 1, zero for a round tip.
    pub fn new(hexes: &[[u32; 8]], caps: &[u32], lid_of: &[u32]) -> Skin {
        let quads: Vec<[u32; 4]> = boundary_faces(hexes).into_iter().map(|f| f.0).collect();
        let lid = |v: u32| match caps[v as usize] {
            0 => 0,
            end => lid_of[end as usize - 1],
        };
        let mut parts = vec![Part::Inner; caps.len()];
        for q in &quads {
            let k = lid(q[0]);
            let own = if k > 0 && q.iter().all(|&v| lid(v) == k) { Part::Lid(k - 1) } else { Part::Wall };
            for &v in q {
                let part = &mut parts[v as usize];
                *part = match (*part, own) {
                    (Part::Inner, own) => own,
                    (Part::Wall, Part::Lid(k)) | (Part::Lid(k), Part::Wall) => Part::Rim(k),
                    (known, _) => known,
                };
            }
        }
        Skin { quads, parts }
    }

    /// How many vertices are on the boundary.
    pub fn len(&self) -> usize {
        self.parts.iter().filter(|&&part| part != Part::Inner).count()
    }

    /// Whether a vertex is on the boundary.
    pub fn has(&self, v: usize) -> bool {
        self.parts[v] != Part::Inner
    }

    /// Unit normals of the wall vertices, by the wall's own faces.
    pub fn normals(&self, points: &[DVec3]) -> Vec<DVec3> {
        let mut sums = vec![DVec3::ZERO; points.len()];
        for q in &self.quads {
            let p = q.map(|v| points[v as usize]);
            let area = (p[2] - p[0]).cross(p[3] - p[1]);
            let normal = area.normalize_or_zero() * area.length().sqrt();
            q.iter().for_each(|&v| sums[v as usize] += normal);
        }
        sums.iter().map(|s| s.normalize_or_zero()).collect()
    }

    pub fn shape(&self, points: &[DVec3]) -> Shape {
        Shape { normals: self.normals(points), sizes: self.sizes(points) }
    }

    /// Where every boundary vertex belongs, in their order.
    pub fn places(&self, points: &[DVec3], shape: &Shape, target: &Target) -> Vec<(u32, DVec3, DVec3)> {
        (0..points.len() as u32)
            .into_par_iter()
            .filter(|&v| self.parts[v as usize] != Part::Inner)
            .map(|v| {
                let k = v as usize;
                let (to, normal) = target.place(self.parts[k], points[k], shape.normals[k], 4.0 * shape.sizes[k]);
                (v, to, normal)
            })
            .collect()
    }

    /// Moves the places of wall vertices off the surface by a share of the sag of the faces around them, within a limit: faces
    /// with all corners on a round wall lie inside of it, and the volume would be too small. And all of them by the same distance
    /// `outward`, within the same limit.
    pub fn swell(&self, points: &[DVec3], target: &Target, outward: f64, places: &mut [(u32, DVec3, DVec3)]) {
        let mut placed = points.to_vec();
        places.iter().for_each(|p| placed[p.0 as usize] = p.1);
        let sag = |q: &[u32; 4]| {
            let p = q.map(|v| placed[v as usize]);
            let (middle, normal) =
                (p.iter().sum::<DVec3>() / 4.0, (p[2] - p[0]).cross(p[3] - p[1]).normalize_or_zero());
            target.closest_wall(middle).map_or(0.0, |(on, _)| (on - middle).dot(normal))
        };
        let sags: Vec<f64> = self.quads.par_iter().map(sag).collect();
        let mut sums = vec![(0.0, 0.0); points.len()];
        for (q, sag) in self.quads.iter().zip(sags) {
            for &v in q {
                let (sum, count) = sums[v as usize];
                sums[v as usize] = (sum + sag, count + 1.0);
            }
        }
        let normals = self.normals(&placed);
        let most = SWELL * target.surface().diagonal();
        for (v, to, _) in places.iter_mut().filter(|p| self.parts[p.0 as usize] == Part::Wall) {
            let (sum, count) = sums[*v as usize];
            *to += normals[*v as usize] * (SAG * sum / f64::max(count, 1.0) + outward).clamp(-most, most);
        }
    }

    /// Draws boundary vertices to where the surface bulges away from the boundary, though all of its vertices be on it: the
    /// one nearest to each bulge goes to its farthest place.
    ///
    /// ```text
    ///     ╭──s──╮         ╭──v──╮
    ///     │  ↑  │    →    │ ╱ ╲ │
    ///   ──v──v──v──     ──v╯   ╰v──
    /// ```
    pub fn reach_out(&self, points: &[DVec3], shape: &Shape, target: &Target, places: &mut [(u32, DVec3, DVec3)]) {
        let far = FAR_BULGE * target.surface().diagonal();
        let bulge = |seen: Seen| {
            let near = |v: &u32| points[*v as usize].distance_squared(seen.place);
            let walls = seen.half.into_iter().filter(|&v| self.parts[v as usize] == Part::Wall);
            let v = walls.min_by(|a, b| near(a).total_cmp(&near(b)))?;
            let k = v as usize;
            let bulges = seen.distance > far.min(BULGE * shape.sizes[k]) && shape.normals[k].dot(seen.normal) > AGREES;
            bulges.then_some((v, seen.distance, seen.place, seen.normal))
        };
        let bulges = target.looking_at(points, &self.quads, BULGE_SAMPLES, bulge);
        let mut farthest = vec![0f64; places.len()];
        for (v, distance, to, normal) in bulges {
            if let Ok(k) = places.binary_search_by_key(&v, |p| p.0)
                && distance > farthest[k]
            {
                farthest[k] = distance;
                places[k] = (v, to, normal);
            }
        }
    }

    /// Of all faces.
    pub fn area(&self, points: &[DVec3]) -> f64 {
        let area = |q: &[u32; 4]| {
            let p = q.map(|v| points[v as usize]);
            0.5 * (p[2] - p[0]).cross(p[3] - p[1]).length()
        };
        self.quads.iter().map(area).sum()
    }

    /// The longest side of the boundary faces at each vertex.
    pub fn sizes(&self, points: &[DVec3]) -> Vec<f64> {
        let mut sizes = vec![0f64; points.len()];
        for q in &self.quads {
            let longest =
                (0..4).map(|k| points[q[k] as usize].distance(points[q[(k + 1) % 4] as usize])).fold(0.0, f64::max);
            q.iter().for_each(|&v| sizes[v as usize] = sizes[v as usize].max(longest));
        }
        sizes
    }
}
