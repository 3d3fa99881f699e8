//! Fills cavities: shells inside the body, as a segmentation leaves them where it missed some voxels. A
//! skeleton and cells along it fill the tube, so that a curve of its own in a cavity would be a tube within a tube.
//!
//! What is hollow to a large part is no tube with flaws, and is refused.

use super::lids::{Closed, Lid};
use crate::error::{Error, Result};
use crate::geometry::search_tree::TriangleTree;
use crate::geometry::winding::WindingTree;
use crate::mesh::{DisjointSets, SurfaceMesh, triangle_area_vector};
use glam::DVec3;
use rustc_hash::FxHashMap;

/// Largest share of the volume within the outer side that cavities have which are filled.
const MOST_HOLLOW: f64 = 0.05;

/// A surface whose cavities are filled.
pub struct Filled {
    /// The rest; the vertices of cavities stay, without triangles.
    pub closed: Closed,
    /// How many cavities there were.
    pub count: usize,
    /// Their share of the volume within the outer side.
    pub share: f64,
}

/// The same surface without its cavities, if it has some.
///
/// # Errors
/// [`Error::Input`] for cavities that are more than a flaw.
pub fn filled(closed: &Closed) -> Result<Option<Filled>> {
    let points = closed.mesh.points();
    let triangles = closed.mesh.faces().fan().0;
    let (part_of, volumes) = parts(points, &triangles);
    let hollow = within_others(points, &triangles, &part_of, &volumes);
    let is_hollow = |t: &&[u32; 3]| hollow[part_of[t[0] as usize] as usize];
    let Some(one) = triangles.iter().find(is_hollow) else { return Ok(None) };
    let of = |kept: bool| (0..volumes.len()).filter(|&k| hollow[k] == kept).map(|k| volumes[k].abs()).sum::<f64>();
    let share = of(true) / of(false);
    if !(share <= MOST_HOLLOW) {
        let p = points[one[0] as usize];
        let what = format!("the surface has a hollow inside, {:.1} % of its volume", 100.0 * share);
        let place = format!("near {:.6} {:.6} {:.6}", p.x, p.y, p.z);
        return Err(Error::input(what, place, "give only the outer side, because cells fill the tube"));
    }
    let stays: Vec<bool> = triangles.iter().map(|t| !is_hollow(&t)).collect();
    let closed = without(closed, &triangles, &stays)?;
    Ok(Some(Filled { closed, count: hollow.iter().filter(|h| **h).count(), share }))
}

/// Which parts lie within a larger one. Their sense says nothing: that of a shell within an open tube is not known before the tube is
/// closed.
fn within_others(points: &[DVec3], triangles: &[[u32; 3]], part_of: &[u32], volumes: &[f64]) -> Vec<bool> {
    let mut bounds = vec![[DVec3::INFINITY, DVec3::NEG_INFINITY]; volumes.len()];
    let mut of_part = vec![Vec::new(); volumes.len()];
    for t in triangles {
        let part = part_of[t[0] as usize] as usize;
        of_part[part].push(*t);
        let [low, high] = &mut bounds[part];
        t.iter().for_each(|&v| (*low, *high) = (low.min(points[v as usize]), high.max(points[v as usize])));
    }
    let mut trees: FxHashMap<usize, WindingTree> = FxHashMap::default();
    let mut contains = |outer: usize, p: DVec3| {
        let tree = || WindingTree::new(&TriangleTree::new(points, &of_part[outer]));
        trees.entry(outer).or_insert_with(tree).number(p).abs() > 0.5
    };
    let holds = |[low, high]: [DVec3; 2], [a, b]: [DVec3; 2]| low.cmple(a).all() && high.cmpge(b).all();
    let mut is_within = |part: usize| {
        let Some(t) = of_part[part].first() else { return false };
        let mut larger = (0..volumes.len()).filter(|&k| volumes[k].abs() > volumes[part].abs());
        larger.any(|k| holds(bounds[k], bounds[part]) && contains(k, points[t[0] as usize]))
    };
    (0..volumes.len()).map(&mut is_within).collect()
}

/// The connected part of every vertex, and the volumes of the parts, negative where they look inward.
fn parts(points: &[DVec3], triangles: &[[u32; 3]]) -> (Vec<u32>, Vec<f64>) {
    let mut sets = DisjointSets::new(points.len());
    for &[a, b, c] in triangles {
        sets.union(a, b);
        sets.union(b, c);
    }
    let (part_of, count) = sets.labels();
    let (mut volumes, mut origin) = (vec![0.0; count], vec![None; count]);
    for t in triangles {
        let part = part_of[t[0] as usize] as usize;
        let origin = *origin[part].get_or_insert(points[t[0] as usize]);
        let [a, b, c] = t.map(|v| points[v as usize] - origin);
        volumes[part] += a.dot(triangle_area_vector(a, b, c)) / 3.0;
    }
    (part_of, volumes)
}

/// The surface of the triangles that stay, with the lids that have some.
fn without(closed: &Closed, triangles: &[[u32; 3]], stays: &[bool]) -> Result<Closed> {
    let kept = |range: std::ops::Range<usize>| range.filter(|&t| stays[t]).map(|t| triangles[t]);
    let mut all: Vec<[u32; 3]> = kept(0..closed.wall).collect();
    let (wall, mut lids) = (all.len(), Vec::new());
    for lid in &closed.lids {
        let first = all.len() as u32;
        all.extend(kept(lid.triangles.start as usize..lid.triangles.end as usize));
        if all.len() as u32 > first {
            lids.push(Lid { triangles: first..all.len() as u32, ..lid.clone() });
        }
    }
    let mesh = SurfaceMesh::from_triangles(closed.mesh.points().to_vec(), &all)?;
    Ok(Closed { mesh, lids, wall })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::context::Context;
    use crate::mesh::test_models::sphere;
    use crate::skeleton::{SkeletonOptions, closed, extract};

    /// A tube along z, with a ball of a radius inside it that looks inward.
    fn tube_around(radius: f64) -> SurfaceMesh {
        let tube = crate::sample::open_cylinder(1.0, 8.0, 24, 24).unwrap().mesh.triangulated().unwrap();
        let (mut points, mut triangles) = (tube.points().to_vec(), tube.faces().fan().0);
        let first = points.len() as u32;
        let ball = sphere(2);
        points.extend(ball.points().iter().map(|p| *p * radius + DVec3::new(0.1, 0.05, 3.0)));
        triangles.extend(ball.faces().fan().0.iter().map(|&[a, b, c]| [first + a, first + c, first + b]));
        SurfaceMesh::from_triangles(points, &triangles).unwrap()
    }

    #[test]
    fn a_tube_with_a_small_cavity_has_one_branch() {
        let mesh = tube_around(0.3);
        let found = filled(&closed(&mesh).unwrap()).unwrap().unwrap();
        assert_eq!((found.count, found.closed.lids.len()), (1, 2));
        assert!((found.share - 0.113 / 25.1).abs() < 3e-4, "{}", found.share);
        let thin = extract(&mesh, &SkeletonOptions::default(), &Context::new()).unwrap();
        assert_eq!((thin.figures.components, thin.figures.extremities, thin.figures.branchings), (1, 2, 0));
        assert!(thin.warnings.iter().any(|w| w.starts_with("1 cavity ")), "{:?}", thin.warnings);
        assert_eq!(thin.preimage.len(), thin.closed.mesh.vertex_count());
    }

    #[test]
    fn a_large_cavity_is_refused_and_a_tube_without_any_is_left_alone() {
        let refused = filled(&closed(&tube_around(0.8)).unwrap()).map(|_| ()).unwrap_err();
        assert!(refused.to_string().contains("hollow inside"), "{refused}");
        let plain = crate::sample::open_cylinder(1.0, 8.0, 24, 24).unwrap().mesh.triangulated().unwrap();
        assert!(filled(&closed(&plain).unwrap()).unwrap().is_none());
    }
}
