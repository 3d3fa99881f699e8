//! Rows of flat strips that are the facets of a fillet: columns on one circle, which touches the planes on both sides.
//!
//! A chamfer of one strip is a chamfer. Two strips or more, whose vertices are on a circle tangent to both neighbours, are no chance.
//!
//! ```text
//!     n₀ ↑   _______ c₀          c₀ − R n₀ = c₁ − R n₁ = the centre,
//!          plane    ╲ strip      and all columns between are R away from it
//!                    ╲
//!                     │ strip
//!                  c₁ │ ─► n₁
//! ```

use super::regions::{Map, Piece, vertices};
use super::topology::Graph;
use super::tuning::{COLUMN_DISTANCE, NAMED_DISTANCE};
use crate::brep::Surface;
use crate::error::Result;
use crate::geometry::primitive::Primitive;
use crate::mesh::NONE;
use glam::DVec3;

/// Cosine of the least angle between strips of a fillet, 1°, because what turns less is one plane.
const LEAST_TURN: f64 = 0.99985;
/// Cosine of the largest angle between strips of a fillet, 50°, because two strips around a right angle turn by 45°.
const MOST_TURN: f64 = 0.643;
/// A count: fewest strips of a fillet, because a chamfer of one strip is a chamfer.
const LEAST_STRIPS: usize = 2;
/// A count: most strips of a fillet, because time grows with their square.
const MOST_STRIPS: usize = 128;

/// Where two plane pieces meet at a small angle.
#[derive(Clone, Copy)]
struct Link {
    pieces: [u32; 2],
    point: DVec3,
    direction: DVec3,
}

impl Link {
    fn other(&self, p: u32) -> u32 {
        if self.pieces[0] == p { self.pieces[1] } else { self.pieces[0] }
    }
}

/// Makes cylinders of the rows of strips that are some.
pub fn round(map: &mut Map<'_>) -> Result<()> {
    let rows = Rows::of(map)?;
    let mut found = Vec::new();
    let mut taken = vec![false; map.pieces.len()];
    for row in rows.all() {
        let mut i = 0;
        while i + LEAST_STRIPS < row.links.len() {
            let last = (i + MOST_STRIPS).min(row.links.len() - 1);
            let arc = (i + LEAST_STRIPS..=last).rev().find_map(|j| row.cylinder(map, &rows, i, j).map(|c| (j, c)));
            let Some((j, cylinder)) = arc else {
                i += 1;
                continue;
            };
            let strips = row.pieces[i + 1..=j].to_vec();
            if strips.iter().all(|&p| !taken[p as usize]) {
                strips.iter().for_each(|&p| taken[p as usize] = true);
                found.push((strips, cylinder));
            }
            i = j;
        }
    }
    for (strips, cylinder) in found {
        merge(map, &strips, cylinder);
    }
    map.compact();
    Ok(())
}

fn merge(map: &mut Map<'_>, strips: &[u32], cylinder: Primitive) {
    let mut triangles: Vec<u32> =
        strips.iter().flat_map(|&p| map.pieces[p as usize].triangles.iter().copied()).collect();
    triangles.sort_unstable();
    map.replace(strips, vec![(triangles, Some((Surface::of_primitive(&cylinder), Some(cylinder))))]);
}

/// Links and the two of them that a strip has.
struct Rows {
    links: Vec<Link>,
    /// Both links of a strip; none for pieces that are none.
    of: Vec<Option<[u32; 2]>>,
    normals: Vec<DVec3>,
}

/// Pieces one after the other, and the links between them: one less.
struct Row {
    pieces: Vec<u32>,
    links: Vec<u32>,
}

impl Rows {
    fn of(map: &Map<'_>) -> Result<Self> {
        let graph = Graph::of(map.t, &map.label, map.pieces.len(), &[])?;
        let normal = |piece: &Piece| match piece.primitive {
            Some(Primitive::Plane { normal, .. }) if piece.same_sense => normal,
            Some(Primitive::Plane { normal, .. }) => -normal,
            _ => DVec3::ZERO,
        };
        let normals: Vec<DVec3> = map.pieces.iter().map(normal).collect();
        let mut links = Vec::new();
        let mut at: Vec<Vec<u32>> = vec![Vec::new(); map.pieces.len()];
        for chain in graph.chains.iter().filter(|c| !c.closed && !c.sides.contains(&NONE)) {
            let [m, n] = chain.sides.map(|s| normals[s as usize]);
            let turn = m.dot(n);
            let ends =
                [chain.vertices[0], chain.vertices[chain.vertices.len() - 1]].map(|v| map.t.points()[v as usize]);
            if turn < LEAST_TURN && turn > MOST_TURN && m != DVec3::ZERO && n != DVec3::ZERO {
                let id = links.len() as u32;
                let direction = (ends[1] - ends[0]).normalize_or_zero();
                links.push(Link { pieces: chain.sides, point: ends[0], direction });
                chain.sides.iter().for_each(|&s| at[s as usize].push(id));
            }
        }
        let parallel = |a: u32, b: u32| {
            links[a as usize].direction.cross(links[b as usize].direction).length() < NAMED_DISTANCE.sqrt()
        };
        let two = |l: &Vec<u32>| match l[..] {
            [a, b] if parallel(a, b) => Some([a, b]),
            _ => None,
        };
        Ok(Rows { of: at.iter().map(two).collect(), links, normals })
    }

    /// Every row once: from end to end, or twice around.
    fn all(&self) -> Vec<Row> {
        let mut seen = vec![false; self.of.len()];
        let mut out = Vec::new();
        for p in 0..self.of.len() as u32 {
            let Some([back, _]) = self.of[p as usize].filter(|_| !seen[p as usize]) else { continue };
            // To one end, and from there to the other.
            let start = self.walk(p, back);
            let from = start.links.last().copied().unwrap_or(back);
            let turned = start.pieces.last().copied().unwrap_or(p);
            let closed = turned == p && start.pieces.len() > 2;
            let mut row = if closed {
                let mut twice = self.walk(p, back);
                let again = (twice.pieces[1..].to_vec(), twice.links.clone());
                twice.pieces.extend(again.0);
                twice.links.extend(again.1);
                twice
            } else {
                let before = self.links[from as usize].other(turned);
                let mut rest = self.walk(before, self.onward(before, from));
                rest.pieces.insert(0, turned);
                rest.links.insert(0, from);
                rest
            };
            row.pieces.iter().for_each(|&q| seen[q as usize] = true);
            row.links.truncate(row.pieces.len().saturating_sub(1));
            out.push(row);
        }
        out
    }

    /// The other link of a strip.
    fn onward(&self, p: u32, from: u32) -> u32 {
        self.of[p as usize].map_or(from, |[a, b]| if a == from { b } else { a })
    }

    /// From a strip over one of its links, until there is no strip any more, or the first one again.
    fn walk(&self, p: u32, over: u32) -> Row {
        let mut row = Row { pieces: vec![p], links: Vec::new() };
        let (mut at, mut link) = (p, over);
        loop {
            at = self.links[link as usize].other(at);
            row.pieces.push(at);
            row.links.push(link);
            if at == p || self.of[at as usize].is_none() || row.pieces.len() > self.of.len() {
                return row;
            }
            link = self.onward(at, link);
        }
    }
}

impl Row {
    /// The cylinder through columns i to j that touches the pieces before and after.
    fn cylinder(&self, map: &Map<'_>, rows: &Rows, i: usize, j: usize) -> Option<Primitive> {
        let near = COLUMN_DISTANCE * map.diagonal;
        let link = |k: usize| rows.links[self.links[k] as usize];
        let axis = link(i).direction;
        let flat = |p: DVec3| p - axis * (p - link(i).point).dot(axis);
        let [m, n] = [self.pieces[i], self.pieces[j + 1]].map(|p| rows.normals[p as usize]);
        let (a, b) = (flat(link(i).point), flat(link(j).point));
        let turn = m - n;
        let radius = (a - b).dot(turn) / turn.length_squared();
        let center = a - radius * m;
        let touches = radius.is_finite() && radius.abs() > near && (b - radius * n).distance(center) <= near;
        let on = |k: usize| (flat(link(k).point).distance(center) - radius.abs()).abs() <= near;
        // The strips follow each other round the centre, by less than half a turn in all.
        let ahead = (i..j).all(|k| rows.normals[self.pieces[k + 1] as usize].dot(m + n) > 0.0);
        if !(touches && (i..=j).all(on) && ahead) {
            return None;
        }
        // Columns of a fillet have no vertices between them, which a plane has that stands for itself.
        let cylinder = Primitive::Cylinder { origin: center, axis, radius: radius.abs() };
        let is_bare = |&p: &u32| {
            let own = vertices(map.t, &map.pieces[p as usize].triangles);
            own.iter().all(|&q| cylinder.distance(q).abs() <= near)
        };
        self.pieces[i + 1..=j].iter().all(is_bare).then_some(cylinder)
    }
}
