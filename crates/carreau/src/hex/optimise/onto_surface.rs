//! Moves vertices onto what they are tied to (the surface, a rim), each with its surroundings only.

use super::patches::{Descent, Mesh, Patch, Ties, descended};
use crate::context::Context;
use crate::error::Result;
use glam::DVec3;
use rayon::prelude::*;
use rustc_hash::FxHashSet;

/// Most patches in all.
const SEATINGS: usize = 1500;
/// Rings of cells around vertices that are put in place, one attempt after the other.
const SEATING: [usize; 3] = [2, 3, 5];
/// Powers of the energy of these attempts, with the iterations of each: what is tied comes first.
const SEATS: [(i32, usize); 3] = [(1, 60), (2, 60), (4, 60)];

/// Puts vertices onto what they are tied to, each with its surroundings alone, wider and wider ones; returns those that are
/// there now, with others that have come with them. No cell becomes poorer than `least`, or than the poorest around.
pub fn seat(
    points: &mut [DVec3],
    hexes: &[[u32; 8]],
    ties: &impl Ties,
    stuck: &[u32],
    least: f64,
    context: &Context,
) -> Result<FxHashSet<u32>> {
    let mesh = Mesh::new(points.len(), hexes);
    let mut seated: FxHashSet<u32> = FxHashSet::default();
    let mut tried = 0;
    for rings in SEATING {
        let mut given_up = FxHashSet::default();
        loop {
            let open = stuck.iter().filter(|v| !seated.contains(v)).filter_map(|&v| mesh.at(v).first().copied());
            let patches = mesh.disjoint(open.filter(|c| !given_up.contains(c)), rings, SEATINGS - tried);
            if patches.is_empty() {
                break;
            }
            tried += patches.len();
            let here = &*points;
            let one = |cells: &Vec<u32>| {
                let patch = Patch::new(&mesh, here, cells, ties);
                let least = least.min(patch.worst(&patch.places));
                let places = descended(&patch, &patch.places, ties, &Descent::Energy(&SEATS), context)?
                    .filter(|p| patch.worst(p) >= least);
                Ok(places.map(|p| (patch, p)))
            };
            let found: Vec<_> = patches.par_iter().map(one).collect::<Result<_>>()?;
            for (cells, found) in patches.iter().zip(found) {
                given_up.insert(cells[0]);
                let Some((patch, places)) = found else {
                    given_up.extend(mesh.around(cells[0], 1));
                    continue;
                };
                for (k, &v) in patch.vertices.iter().enumerate().filter(|(k, _)| !patch.fixed[*k]) {
                    points[v as usize] = places[k];
                    seated.insert(v);
                }
            }
        }
    }
    tracing::debug!(stuck = stuck.len(), tried, seated = seated.len(), "vertices put in place with their surroundings");
    Ok(seated)
}

#[cfg(test)]
mod tests {
    use super::super::optimiser::Spring;
    use super::super::patches::tests::{SIDE, block};
    use super::*;
    use crate::geometry::hexes::uncertified;

    /// The top of the block is tied to its plane, the rest of the boundary held.
    struct Top<'a>(&'a [DVec3], &'a [bool]);

    impl Top<'_> {
        fn has(&self, v: u32) -> bool {
            let p = self.0[v as usize];
            p.z == f64::from(SIDE) && [p.x, p.y].iter().all(|x| *x > 0.0 && *x < f64::from(SIDE))
        }
    }

    impl Ties for Top<'_> {
        fn springs(&self, vertex: u32, at: DVec3) -> Vec<Spring> {
            let to = self.tied_place(vertex, at);
            let spring = |to| Spring { vertex, to, normal: DVec3::Z, along: 1000.0, across: 1e-3 };
            to.map(spring).into_iter().collect()
        }

        fn is_fixed(&self, vertex: u32) -> bool {
            self.1[vertex as usize] && !self.has(vertex)
        }

        fn tied_place(&self, vertex: u32, at: DVec3) -> Option<DVec3> {
            self.has(vertex).then(|| DVec3::new(at.x, at.y, f64::from(SIDE)))
        }
    }

    #[test]
    fn a_vertex_off_its_plane_is_put_there_with_its_surroundings() {
        let (straight, hexes, fixed) = block();
        let top = Top(&straight, &fixed);
        let n = (SIDE + 1) as usize;
        let vertex = (SIDE as usize * n + 6) * n + 6;
        let mut points = straight.clone();
        points[vertex] += DVec3::new(0.1, 0.05, -0.4);
        let seated = seat(&mut points, &hexes, &top, &[vertex as u32], 0.1, &Context::new()).unwrap();
        assert!(seated.contains(&(vertex as u32)) && points[vertex].z == f64::from(SIDE));
        assert!(uncertified(&points, &hexes).is_empty());
        let far = |v: &usize| straight[*v].distance(straight[vertex]) > 7.0;
        assert!((0..points.len()).filter(far).all(|v| points[v] == straight[v]));
    }
}
