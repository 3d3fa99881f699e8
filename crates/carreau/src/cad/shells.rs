//! Shells and bodies: the connected parts of the mesh, and which of them are cavities of which.

use crate::brep::{Brep, Shell, Solid};
use crate::error::Result;
use crate::geometry::search_tree::TriangleTree;
use crate::geometry::winding::WindingTree;
use crate::mesh::{DisjointSets, NONE, Triangles};
use glam::DVec3;

/// Gives the faces of a model, so many of which triangles are labelled with, to shells and the closed shells to solids.
pub fn enclose(t: Triangles<'_>, label: &[u32], faces: usize, brep: &mut Brep) -> Result<()> {
    let mut sets = DisjointSets::new(faces);
    let mut open = vec![false; faces];
    for c in 0..3 * t.len() as u32 {
        let (own, o) = (label[c as usize / 3], t.opposite(c));
        if o == NONE {
            open[own as usize] = true;
        } else {
            sets.union(own, label[o as usize / 3]);
        }
    }
    let (of, count) = sets.labels();
    let mut shells = vec![Shell { closed: true, ..Shell::default() }; count];
    for (p, &s) in of.iter().enumerate() {
        shells[s as usize].faces.push(p as u32);
        shells[s as usize].closed &= !open[p];
    }
    let bodies = Bodies::new(t, label, &of, count);
    // A shell that looks inwards is a cavity of the smallest body around it; all others are bodies, also within each other.
    let is_cavity: Vec<bool> = (0..count).map(|s| bodies.volume[s] < 0.0).collect();
    let mut solids: Vec<Solid> = Vec::new();
    let mut of_shell = vec![NONE; count];
    for s in (0..count).filter(|&s| shells[s].closed && !is_cavity[s]) {
        of_shell[s] = solids.len() as u32;
        solids.push(Solid { outer: s as u32, ..Solid::default() });
    }
    for s in (0..count).filter(|&s| shells[s].closed && is_cavity[s]) {
        let around = bodies.around(s, &shells).filter(|&p| of_shell[p] != NONE && !is_cavity[p]);
        match around.min_by(|&a, &b| bodies.volume[a].total_cmp(&bodies.volume[b])) {
            Some(parent) => solids[of_shell[parent] as usize].voids.push(s as u32),
            None => solids.push(Solid { outer: s as u32, ..Solid::default() }),
        }
    }
    (brep.shells, brep.solids) = (shells, solids);
    Ok(())
}

struct Bodies {
    trees: Vec<WindingTree>,
    bounds: Vec<(DVec3, DVec3)>,
    /// A vertex of each.
    probe: Vec<DVec3>,
    /// Signed volumes, where closed.
    volume: Vec<f64>,
}

impl Bodies {
    fn new(t: Triangles<'_>, label: &[u32], of: &[u32], count: usize) -> Self {
        let mut triangles = vec![Vec::new(); count];
        for (k, &l) in label.iter().enumerate() {
            triangles[of[l as usize] as usize].push(t.triangle(k as u32));
        }
        let mut bounds = vec![(DVec3::INFINITY, DVec3::NEG_INFINITY); count];
        for (b, triangles) in bounds.iter_mut().zip(&triangles) {
            for &v in triangles.iter().flatten() {
                let p = t.points()[v as usize];
                *b = (b.0.min(p), b.1.max(p));
            }
        }
        let probe = triangles.iter().map(|f| t.points()[f[0][0] as usize]).collect();
        let cone = |[a, b, c]: [DVec3; 3], o: DVec3| (a - o).dot((b - o).cross(c - o)) / 6.0;
        let of_all = |(all, o): (&Vec<[u32; 3]>, &DVec3)| -> f64 {
            all.iter().map(|f| cone(f.map(|v| t.points()[v as usize]), *o)).sum()
        };
        let volume = triangles.iter().zip(&probe).map(of_all).collect();
        let trees = match count {
            0 | 1 => Vec::new(),
            _ => triangles.iter().map(|f| WindingTree::new(&TriangleTree::new(t.points(), f))).collect(),
        };
        Bodies { trees, bounds, probe, volume }
    }

    /// The closed shells around a shell.
    fn around<'a>(&'a self, s: usize, shells: &'a [Shell]) -> impl Iterator<Item = usize> + 'a {
        let (low, high) = self.bounds[s];
        (0..self.trees.len()).filter(move |&o| {
            let (l, h) = self.bounds[o];
            o != s && shells[o].closed && l.cmplt(low).all() && h.cmpgt(high).all() && {
                self.trees[o].contains(self.probe[s])
            }
        })
    }
}
