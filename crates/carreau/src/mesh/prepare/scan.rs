//! Decides in one pass whether there is anything to prepare.

use super::super::connectivity::{Connectivity, faces_with_repeats, umbrellas};
use super::super::disjoint_sets::DisjointSets;
use super::super::duplicates::first_on_same_vertices;
use super::super::id::CornerId;
use super::super::nesting::Shells;
use super::super::repair::{degenerate, is_umbrella};
use super::super::surface::{Side, SurfaceMesh};
use super::super::weld::{first_at_same_position, leaders_within};
use glam::DVec3;
use rayon::prelude::*;

/// What was found.
pub(super) struct Scan {
    /// For every vertex the one that it joins; none where all stay.
    pub leader: Option<Vec<u32>>,
    /// Faces without area or in the wrong sense, edges and vertices that are not manifold.
    flawed: bool,
    /// Component of every face, and their number.
    pub component: Vec<u32>,
    pub components: usize,
    pub shells: Shells,
    inverted: bool,
}

impl Scan {
    pub fn of(mesh: &SurfaceMesh, tolerance: f64) -> Self {
        let (leader, flawed) = rayon::join(|| leaders(mesh, tolerance), || is_flawed(mesh));
        if flawed || leader.is_some() {
            let (component, components, shells) = (Vec::new(), 0, Shells::none());
            return Scan { leader, flawed, component, components, shells, inverted: false };
        }
        let (component, components, shells) = parts(mesh);
        let inverted = (0..components as u32).any(|c| shells.is_inverted(c));
        Scan { leader, flawed, component, components, shells, inverted }
    }

    pub fn is_sound(&self) -> bool {
        self.leader.is_none() && !self.flawed && !self.inverted
    }
}

/// For every vertex that faces use the one that it joins.
pub(in crate::mesh) fn leaders(mesh: &SurfaceMesh, tolerance: f64) -> Option<Vec<u32>> {
    let used = super::ids::used_vertices(mesh);
    let find = |points: &[DVec3]| {
        if tolerance > 0.0 { leaders_within(points, tolerance) } else { first_at_same_position(points) }
    };
    let leader = if used.iter().all(|&u| u) {
        find(mesh.points())
    } else {
        let ids: Vec<u32> = (0u32..).zip(&used).filter(|(_, used)| **used).map(|(v, _)| v).collect();
        let points: Vec<DVec3> = ids.iter().map(|&v| mesh.points()[v as usize]).collect();
        let mut leader: Vec<u32> = (0..mesh.vertex_count() as u32).collect();
        find(&points).into_iter().zip(&ids).for_each(|(l, &v)| leader[v as usize] = ids[l as usize]);
        leader
    };
    leader.iter().zip(0u32..).any(|(&l, v)| l != v).then_some(leader)
}

fn is_flawed(mesh: &SurfaceMesh) -> bool {
    let irregular = |c: usize| matches!(mesh.side(CornerId::new(c)), Side::Inconsistent | Side::NonManifold);
    if (0..mesh.corner_count()).into_par_iter().with_min_len(4096).any(irregular) || degenerate::any(mesh) {
        return true;
    }
    if mesh.is_triangular() {
        return (0..mesh.face_count()).into_par_iter().with_min_len(4096).any(|f| is_pillow(mesh, f))
            || !is_umbrella(mesh);
    }
    let repeats = faces_with_repeats(mesh.faces(), mesh.vertex_count());
    let first = first_on_same_vertices(mesh.faces(), &repeats);
    let mut seen = vec![false; mesh.vertex_count()];
    let umbrella = umbrellas(mesh.faces(), &mesh.half_edges(), &repeats, |_, _| true);
    let mut bow_tie = false;
    for (_, &v) in mesh.faces().corners().iter().enumerate().filter(|(c, _)| umbrella[*c] as usize == *c) {
        bow_tie |= std::mem::replace(&mut seen[v as usize], true);
    }
    bow_tie || repeats.contains(&true) || first.iter().enumerate().any(|(f, &l)| f != l as usize)
}

/// Whether all three neighbours of a triangle are one: two faces on the same vertices.
fn is_pillow(mesh: &SurfaceMesh, f: usize) -> bool {
    let across = |k: usize| mesh.opposite(CornerId::new(3 * f + k)).map(|o| mesh.face_of(o));
    across(0).is_some() && across(0) == across(1) && across(1) == across(2)
}

/// The components of a surface, their number, and those that are closed.
pub(super) fn parts(mesh: &SurfaceMesh) -> (Vec<u32>, usize, Shells) {
    let faces = mesh.faces();
    let repeats = vec![false; faces.len()];
    let is_regular =
        (0..mesh.corner_count()).all(|c| matches!(mesh.side(CornerId::new(c)), Side::Inner(_) | Side::Border));
    if !is_regular {
        let repeats = faces_with_repeats(faces, mesh.vertex_count());
        let parts = Connectivity::of(faces, &mesh.half_edges(), &repeats);
        let shells = Shells::of(mesh.points(), faces, &parts, &repeats);
        return (parts.component, parts.components, shells);
    }
    let mut sets = DisjointSets::new(faces.len());
    let mut open_faces = Vec::new();
    for c in (0..mesh.corner_count()).map(CornerId::new) {
        match mesh.opposite(c) {
            Some(o) if o > c => sets.union(mesh.face_of(c).0, mesh.face_of(o).0),
            Some(_) => {}
            None => open_faces.push(mesh.face_of(c).index()),
        }
    }
    let (component, components) = sets.labels();
    let mut closed = vec![true; components];
    open_faces.into_iter().for_each(|f| closed[component[f] as usize] = false);
    let parts = Connectivity {
        edges: 0,
        boundary: Vec::new(),
        nonmanifold: Vec::new(),
        inconsistent: Vec::new(),
        component,
        components,
        closed,
        orientable: vec![true; components],
        turned: repeats.clone(),
    };
    let mut shells = Shells::of(mesh.points(), faces, &parts, &repeats);
    let names = super::body_labels(mesh);
    let name = |f: u32| names.map(|names| names[f as usize]);
    shells.tell_apart(|inner, outer| name(inner) != name(outer));
    (parts.component, parts.components, shells)
}
