//! Cubic junctions (named as future work by Viville et al.): a branching of three to six segments that stand
//! about at right angles gets 2 × 2 × 2 hexes, and every segment one of the six faces of that cube.
//!
//! ```text
//!        │ tube │            e─────C─────e        a face of the cube is the section of a tube:
//!        │      │            │     │     │        c the centre of its four hexes, e (middles of the
//!   ─────C──e───C─────       e─────c─────e        cube's edges) their corners, C their middles
//!    tube│  │   │tube        │     │     │
//!   ─────e──┼───e─────       C─────e─────C
//!        │  │   │
//!   ─────C──e───C─────       Faces without a segment belong to the wall.
//! ```
//!
//! No edge inside has more than four cells. A partition of the sphere about the same directions has edges of six, whose
//! cells cannot be better than an angle of 60° lets them.

use super::connection::PartitionSearch;
use crate::mesh::{CurveNet, Incidence, NONE};
use glam::{DMat3, DVec3};
use rayon::prelude::*;

/// Vertices of a junction: a grid of 3 × 3 × 3, its middle first.
pub const VERTICES: u32 = 27;
/// Angles between segments may be this far from 90° or 180°.
const OFF_DEGREES: f64 = 30.0;
/// The middle of the grid.
const MIDDLE: usize = 13;
/// Where the section of a tube begins, in radii from the branching.
const START: f64 = 0.8;
/// Where two tubes meet, in radii from either axis: a little less than the radius.
const CREASE: f64 = 0.9;
/// Branchings that one task looks at: enough work to pay for a task.
const BRANCHINGS_PER_TASK: usize = 64;

/// A junction; face 2 a + 1 is opposite to face 2 a.
#[derive(Debug, Clone)]
pub struct Cube {
    /// Unit vectors to the faces: of a segment, or of an axis of the cube where there is none.
    towards: [DVec3; 6],
    /// The face of every segment, in the order of the directions.
    face_of: Vec<u8>,
    /// Whether a face has a segment.
    taken: [bool; 6],
}

impl Cube {
    /// The cube for unit directions, where they stand about at right angles and take different faces.
    pub fn of(directions: &[DVec3]) -> Option<Cube> {
        if !(3..=6).contains(&directions.len()) {
            return None;
        }
        let mut lines: Vec<DVec3> = Vec::new();
        let mut faces: Vec<usize> = Vec::new();
        for d in directions {
            let sines_and_signs = lines.iter().map(|l| d.dot(*l));
            let beside = sines_and_signs.enumerate().find(|(_, cos)| cos.abs() > OFF_DEGREES.to_radians().cos());
            match beside {
                Some((axis, cos)) => faces.push(2 * axis + usize::from(cos < 0.0)),
                None => {
                    faces.push(2 * lines.len());
                    lines.push(*d);
                }
            }
        }
        let mut taken = [false; 6];
        if lines.len() < 2 || lines.len() > 3 || !directions_fit(directions, &faces) {
            return None;
        }
        faces.iter().for_each(|&f| taken[f] = true);
        let mut axes = [DVec3::ZERO; 3];
        directions.iter().zip(&faces).for_each(|(d, f)| axes[f / 2] += if f % 2 == 0 { *d } else { -*d });
        if lines.len() == 2 {
            axes[2] = axes[0].cross(axes[1]);
        }
        let mut frame = DMat3::from_cols(axes[0].normalize(), axes[1].normalize(), axes[2].normalize());
        if frame.determinant() < 0.0 {
            // The third axis the other way round makes the frame right-handed; its faces change their places.
            frame.z_axis = -frame.z_axis;
            taken.swap(4, 5);
            faces.iter_mut().filter(|f| **f > 3).for_each(|f| *f ^= 1);
        }
        let frame = nearest_rotation(frame);
        let mut towards: [DVec3; 6] =
            std::array::from_fn(|f| if f % 2 == 0 { frame.col(f / 2) } else { -frame.col(f / 2) });
        directions.iter().zip(&faces).for_each(|(d, &f)| towards[f] = *d);
        Some(Cube { towards, face_of: faces.into_iter().map(|f| f as u8).collect(), taken })
    }

    /// The least determinant of the directions of three faces at a corner: the scaled Jacobian of the cells at the branching,
    /// as inclusion is for a partition.
    pub fn least_determinant(&self) -> f64 {
        let of_corner = |c: usize| {
            let [x, y, z] = [0, 1, 2].map(|a| self.towards[2 * a + (c >> a & 1)]);
            let mirrored = c.count_ones() % 2 == 1;
            x.cross(y).dot(z) * if mirrored { -1.0 } else { 1.0 }
        };
        (0..8).map(of_corner).fold(f64::INFINITY, f64::min)
    }

    /// The vertices from the middle, in radii.
    pub fn points(&self) -> [DVec3; VERTICES as usize] {
        let mut points = [DVec3::ZERO; VERTICES as usize];
        for (n, place) in grid().enumerate() {
            let faces = faces_at(place);
            let tubes = faces.iter().filter(|f| self.taken[**f]).count();
            // Off a tube's axis by its radius: where one tube passes by, along it only as far as its section begins.
            let open = faces.len() - tubes;
            let along = if tubes > 1 { CREASE * [0.0, 1.0, 1.0, 1.0 / 2f64.sqrt()][faces.len()] } else { START };
            let aside = if tubes > 1 { along } else { 1.0 / (open.max(1) as f64).sqrt() };
            let point = |f: &usize| self.towards[*f] * if self.taken[*f] { along } else { aside };
            points[vertex(n) as usize] = faces.iter().map(point).sum();
        }
        points
    }

    /// The vertices of the face of a segment: the four corners of its cells, counter-clockwise seen from outside, the
    /// middles that follow them, and the centre.
    pub fn section(&self, direction: usize) -> [u32; 9] {
        let face = usize::from(self.face_of[direction]);
        let [mut from, mut to] = [2 * (face / 2 + 1) % 6, 2 * (face / 2 + 2) % 6];
        if face % 2 == 1 {
            std::mem::swap(&mut from, &mut to);
        }
        let round = [from, to, from ^ 1, to ^ 1];
        std::array::from_fn(|k| match k {
            0..4 => vertex_of(&[face, round[k]]),
            4..8 => vertex_of(&[face, round[k - 4], round[(k - 3) % 4]]),
            _ => vertex_of(&[face]),
        })
    }

    /// The faces without a segment.
    pub fn open_faces(&self) -> impl Iterator<Item = usize> + '_ {
        (0..6).filter(|&f| !self.taken[f])
    }

    /// Whether a vertex lies off the wall: the middle, and the centres of the sections.
    pub fn is_inside(&self, v: u32) -> bool {
        v == 0 || (0..6).any(|f| self.taken[f] && vertex_of(&[f]) == v)
    }
}

/// The cells of any junction.
pub fn hexes() -> impl Iterator<Item = [u32; 8]> {
    const UNIT: [[usize; 3]; 8] =
        [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]];
    (0..8).map(|c| UNIT.map(|up| vertex((c & 1) + up[0] + 3 * ((c >> 1 & 1) + up[1]) + 9 * ((c >> 2) + up[2]))))
}

/// The quads of a face, counter-clockwise seen from outside.
pub fn quads(face: usize) -> impl Iterator<Item = [u32; 4]> {
    let [mut from, mut to] = [2 * (face / 2 + 1) % 6, 2 * (face / 2 + 2) % 6];
    if face % 2 == 1 {
        std::mem::swap(&mut from, &mut to);
    }
    let round = [from, to, from ^ 1, to ^ 1];
    (0..4).map(move |k| {
        let next = round[(k + 1) % 4];
        [vertex_of(&[face]), vertex_of(&[face, round[k]]), vertex_of(&[face, round[k], next]), vertex_of(&[face, next])]
    })
}

/// Which branchings of a net are cubic.
#[derive(Debug, Clone, Default)]
pub struct Cubes {
    /// Number of the cube of every node, or [`NONE`]; empty where there is no cube.
    of_node: Vec<u32>,
    /// The nodes with their cubes, in the order of the nodes.
    pub list: Vec<(u32, Cube)>,
}

impl Cubes {
    /// Every branching that a cube can be put into and whose partition of the sphere has a smaller determinant.
    pub fn new(net: &CurveNet, around: &Incidence) -> Cubes {
        let branchings: Vec<u32> = (0..net.points.len() as u32).filter(|&v| around.valence(v) > 2).collect();
        let better = |search: &mut PartitionSearch, v: u32| {
            let directions = directions(net, around, v);
            let cube = Cube::of(&directions)?;
            let partition = search.partition(&directions).least_determinant(&directions);
            (cube.least_determinant() > partition).then_some((v, cube))
        };
        let of_chunk = |chunk: &[u32]| {
            let mut search = PartitionSearch::default();
            chunk.iter().filter_map(|&v| better(&mut search, v)).collect::<Vec<_>>()
        };
        let list: Vec<(u32, Cube)> = branchings
            .par_chunks(BRANCHINGS_PER_TASK)
            .map(of_chunk)
            .collect::<Vec<_>>()
            .into_iter()
            .flatten()
            .collect();
        let mut of_node = vec![NONE; if list.is_empty() { 0 } else { net.points.len() }];
        list.iter().zip(0..).for_each(|((v, _), k)| of_node[*v as usize] = k);
        Cubes { of_node, list }
    }

    /// The cube of a node.
    pub fn get(&self, node: u32) -> Option<&Cube> {
        let k = self.of_node.get(node as usize)?;
        self.list.get(*k as usize).map(|c| &c.1)
    }
}

/// Unit vectors along the segments of a node.
pub fn directions(net: &CurveNet, around: &Incidence, v: u32) -> Vec<DVec3> {
    let centre = net.points[v as usize];
    around.of(v).iter().map(|s| (net.points[s[1] as usize] - centre).normalize_or(DVec3::X)).collect()
}

/// Whether every two directions are as far apart as their faces, but for [`OFF_DEGREES`].
fn directions_fit(directions: &[DVec3], faces: &[usize]) -> bool {
    let off = OFF_DEGREES.to_radians();
    (0..faces.len()).all(|i| {
        (0..i).all(|j| {
            let cos = directions[i].dot(directions[j]);
            if faces[i] / 2 == faces[j] / 2 { cos <= -off.cos() } else { cos.abs() <= off.sin() }
        })
    })
}

/// The rotation nearest to a matrix: its polar factor, by Newton's iteration (Higham 1986).
fn nearest_rotation(mut m: DMat3) -> DMat3 {
    for _ in 0..20 {
        m = (m + m.inverse().transpose()) * 0.5;
    }
    m
}

/// The places of the grid, in order, each coordinate −1, 0 or 1.
fn grid() -> impl Iterator<Item = [i8; 3]> {
    (0..27i8).map(|n| [n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1])
}

/// The faces that a place lies on.
fn faces_at(place: [i8; 3]) -> Vec<usize> {
    (0..3).filter(|&a| place[a] != 0).map(|a| 2 * a + usize::from(place[a] < 0)).collect()
}

/// The number of a place of the grid: the middle comes first.
fn vertex(place: usize) -> u32 {
    match place {
        MIDDLE => 0,
        0 => MIDDLE as u32,
        n => n as u32,
    }
}

/// The vertex on some faces and no others.
fn vertex_of(faces: &[usize]) -> u32 {
    let place = faces.iter().map(|f| [1, 3, 9][f / 2] * if f % 2 == 0 { 1 } else { -1 }).sum::<isize>();
    vertex((MIDDLE as isize + place) as usize)
}

#[cfg(test)]
mod tests {
    use super::super::refine::CORE;
    use super::super::tests::{assert_conforming, star_net};
    use super::super::*;
    use super::*;
    use crate::mesh::boundary_faces;
    use crate::mesh::irregular_hex_edges;
    use glam::DQuat;

    const AXES: [DVec3; 6] = [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::Z, DVec3::NEG_Y, DVec3::NEG_Z];

    /// The first few axes, turned, and each bent aside by some degrees.
    fn cross(n: usize, turn: f64, bent: f64) -> Vec<DVec3> {
        let turn = DQuat::from_axis_angle(DVec3::new(1.0, -2.0, 0.7).normalize(), turn);
        let bend = |(d, k): (DVec3, usize)| {
            let (u, v) = d.any_orthonormal_pair();
            let (sin, cos) = (2.4 * k as f64).sin_cos();
            turn * DQuat::from_axis_angle(u * cos + v * sin, bent.to_radians()) * d
        };
        AXES[..n].iter().copied().zip(0..).map(bend).collect()
    }

    /// Hexes, boundary quads and vertices of stars with a cube, in closed form: as without it, and 8 cells, 4 quads for every
    /// face without a segment, 27 vertices.
    #[test]
    fn counts_are_the_closed_form() {
        for n in 3..=6 {
            let open = 6 - n;
            let net = star_net(&cross(n, 0.4, 5.0), 0.2);
            let base = assemble::base_mesh(&net, true);
            assert_eq!(base.cubes.list.len(), 1, "{n}");
            assert_eq!((base.hexes.len(), base.points.len()), (4 * n + 8, 27 + 9 * n));
            assert_conforming(&base.hexes, &base.points, &[0]);
            for (padding, hexes, quads) in [
                (Padding::None, 4 * n + 8, 12 * n + 4 * open),
                (Padding::Sides, 12 * n + 8 + 4 * open, 20 * n + 4 * open),
                (Padding::All, 16 * n + 8 + 4 * open, 12 * n + 4 * open),
            ] {
                let mut tube = refine::pad(&net, &base, padding, CORE);
                assert_eq!((tube.hexes.len(), boundary_faces(&tube.hexes).len()), (hexes, quads));
                assert_eq!(refine::places(&net, &base, padding).len(), hexes);
                assert_conforming(&tube.hexes, &tube.points, &[0]);
                tube.refine_across();
                tube.refine_along(|s| s == 1);
                assert_conforming(&tube.hexes, &tube.points, &[0]);
            }
        }
    }

    /// However the cross is turned, and in whatever order its segments come.
    #[test]
    fn no_edge_inside_has_more_than_four_cells() {
        for (n, turn) in [(3, 0.0), (4, 1.1), (5, 2.0), (6, 3.3)] {
            let mut directions = cross(n, turn, 10.0);
            directions.rotate_left(n / 2);
            let base = assemble::base_mesh(&star_net(&directions, 0.2), true);
            assert_eq!(base.cubes.list.len(), 1);
            let quads: Vec<[u32; 4]> = boundary_faces(&base.hexes).into_iter().map(|f| f.0).collect();
            assert_eq!(irregular_hex_edges(&base.hexes, &quads), []);
            let cube = &base.cubes.list[0].1;
            assert!(cube.least_determinant() > 0.85);
            for (d, k) in directions.iter().zip(0..) {
                // Its section is where the segment goes, and runs about it counter-clockwise.
                let section = cube.section(k).map(|v| cube.points()[v as usize]);
                assert!(section[8].angle_between(*d) < 1e-6);
                assert!((0..4).all(|i| d.dot(section[i].cross(section[4 + i])) > 0.2));
                assert!((0..4).all(|i| d.dot(section[4 + i].cross(section[(i + 1) % 4])) > 0.2));
            }
        }
    }

    #[test]
    fn not_where_directions_are_far_from_right_angles() {
        let at = |degrees: f64| DVec3::new(degrees.to_radians().cos(), degrees.to_radians().sin(), 0.0);
        assert!(Cube::of(&[at(0.0), at(120.0), at(240.0)]).is_none_or(|c| c.least_determinant() > 0.8));
        assert!(Cube::of(&[at(0.0), at(45.0), at(180.0)]).is_none());
        assert!(Cube::of(&[at(0.0), at(90.0)]).is_none());
        // The corners of a tetrahedron are four lines.
        let tetrahedron = [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];
        assert!(Cube::of(&tetrahedron.map(|d| DVec3::from_array(d).normalize())).is_none());
        assert!(Cube::of(&cross(6, 0.0, 12.0)).is_some());
    }

    /// The graph as given has none.
    #[test]
    fn crosses_are_better_with_a_cube() {
        for n in [4, 6] {
            let net = star_net(&cross(n, 0.9, 8.0), 0.2);
            let of = |stage| {
                let options = HexOptions { stage, ..HexOptions::default() };
                from_net(&net, &options, &Context::new()).unwrap().figures
            };
            let (with, without) = (of(Stage::Full), of(Stage::Base));
            assert_eq!((with.cubic_junctions, without.cubic_junctions), (1, 0));
            assert!(with.quality.certified);
            let [a, b] = [with, without].map(|f| f.quality.scaled_jacobian_min);
            assert!(a > b + 0.02, "{n}: {a} {b}");
        }
    }
}
