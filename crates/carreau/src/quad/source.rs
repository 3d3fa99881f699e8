//! The surface that quads are made of: its regions between features, its feature curves, and the way back to both.

use super::apices::{Tip, tips};
use super::bends::{BEND_DEG, bends};
use super::curve::{Curve, paths};
use super::guidance::Guidance;
use super::junction::{EdgePlace, edge_place, meeting_borders, shared_borders, with_shared_borders_divided};
use super::scraps::drop_around_scraps;
use super::sew::sewn;
use super::work::{Place, Work};
use crate::context::Context;
use crate::error::{Error, Result};
use crate::geometry::features::{Creases, FeatureOptions, FeaturedSurface};
use crate::geometry::normals::face_normals;
use crate::geometry::search_tree::TriangleTree;
use crate::mesh::{CornerId, DisjointSets, NONE, SurfaceMesh};
use crate::remesh::RIDGE_TURN_DEG;
use glam::DVec3;
use rustc_hash::{FxHashMap, FxHashSet};

/// Shares of a chord: places where it is compared with its curve, inside of its ends because curves may bend there, and so
/// close to each other that a bend between two is no farther off than a sixteenth more.
const CHORD_PLACES: [f64; 9] = [0.02, 0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875, 0.98];

/// Options: features as they are marked already, because they were looked for in the surface as it was given.
const AS_MARKED: FeatureOptions =
    FeatureOptions { angle_deg: None, creases: Creases::Every, borders: true, tags: true, edges: Vec::new() };

/// The surface, its regions and its feature curves.
pub struct Source {
    pub surface: FeaturedSurface,
    pub diagonal: f64,
    pub area: f64,
    /// Region of every triangle.
    pub region: Vec<u32>,
    pub regions: usize,
    /// Unit normals of the triangles.
    pub normals: Vec<DVec3>,
    /// For every region its triangles, and the tree over them.
    trees: Vec<(Vec<u32>, TriangleTree)>,
    /// The feature edges, by their ends, and the curve of each.
    pub edges: Vec<[u32; 2]>,
    pub curve: Vec<u32>,
    /// All feature edges, and those of every curve, as flat triangles.
    all_curves: TriangleTree,
    curves: Vec<(Vec<u32>, TriangleTree)>,
    /// The curves in the order of their length, by number.
    pub paths: Vec<Curve>,
    /// Where every curve bends inside.
    pub bends: FxHashMap<u32, Vec<DVec3>>,
    /// Where regions come to a point.
    pub tips: Vec<Tip>,
    /// The regions on both sides of every curve, the smaller number first; [`NONE`] beside a border.
    pub sides: Vec<[u32; 2]>,
    /// Curves that are borders and lie on others.
    pub is_shared: Vec<bool>,
    /// Curves along which borders were sewn.
    pub is_sewn: Vec<bool>,
    sewn_places: FxHashSet<EdgePlace>,
    /// Sewn curves that end where their feature goes on: they stay as they are, or nobody would know later where they end.
    is_kept: Vec<bool>,
    /// The points where curves end.
    at_corner: FxHashSet<[u64; 3]>,
    /// The edges of these stay as they are.
    pub is_held: bool,
    /// What quads are led by besides.
    pub guidance: Guidance,
    /// Curves along which it was cut: they are borders, and no features of the whole.
    pub is_cut: Vec<bool>,
    /// Sharp edges are noise to a part: what features are left fades out and is as rough as its scan.
    pub is_noisy: bool,
    /// None of these is asked for by name: what leaves no room for quads may go.
    pub may_lose_creases: bool,
}

impl Source {
    pub fn new(mesh: &SurfaceMesh, options: &FeatureOptions, context: &Context) -> Result<Self> {
        let mut surface = FeaturedSurface::new(mesh, options, context)?;
        if let Some((met, what)) = meeting_borders(&surface.mesh)? {
            let again = FeaturedSurface::new(&met, &AS_MARKED, context)?;
            let repaired = surface.repaired.into_iter().chain(what).chain(again.repaired).collect();
            surface = FeaturedSurface { repaired, missing: surface.missing, found: surface.found, ..again };
        }
        let is_marked = !options.edges.is_empty() || options.tags && !mesh.tagged_edges.is_empty();
        let may_lose_creases = surface.found.noise.is_high() && !is_marked && options.creases != Creases::Every;
        if let Creases::AtSize(length) = options.creases
            && may_lose_creases
        {
            drop_around_scraps(&mut surface, length);
        }
        Ok(Source { may_lose_creases, ..Self::of(surface, &FxHashSet::default(), context)? })
    }

    /// The same with the borders sewn that lie on others; `None` where there are none. Regions keep their numbers, curves do
    /// not.
    pub fn sewn(&self, context: &Context) -> Result<Option<Self>> {
        if !self.is_shared.contains(&true) {
            return Ok(None);
        }
        let Some((mesh, places)) = sewn(&self.surface.mesh)? else { return Ok(None) };
        let surface = FeaturedSurface::new(&mesh, &AS_MARKED, context)?;
        // Whatever needs a repair now is better left open.
        if !surface.repaired.is_empty() {
            return Ok(None);
        }
        Ok(Some(Self::of(surface, &places, context)?.guided(self.guidance.clone())))
    }

    /// The same, led by more than itself.
    pub fn guided(mut self, guidance: Guidance) -> Self {
        let mesh = &self.surface.mesh;
        self.is_cut = vec![!guidance.cuts.is_empty(); self.sides.len()];
        for (c, &curve) in self.surface.features.edges(mesh).zip(&self.curve) {
            self.is_cut[curve as usize] &= guidance.cut_places.contains(&edge_place(mesh, c));
        }
        self.guidance = guidance;
        self
    }

    /// The same with the borders that lie on others in edges up to a length, which stay as they are; `None` where there are
    /// none. Regions keep their numbers, curves do not.
    pub fn held(&self, length: f64, context: &Context) -> Result<Option<Self>> {
        if !self.is_shared.contains(&true) {
            return Ok(None);
        }
        let mesh = with_shared_borders_divided(&self.surface.mesh, length)?;
        let surface = FeaturedSurface::new(&mesh, &AS_MARKED, context)?;
        Ok(Some(Source {
            is_held: true,
            ..Self::of(surface, &self.sewn_places, context)?.guided(self.guidance.clone())
        }))
    }

    /// Where the edges of borders that lie on others are, nothing moves.
    pub fn hold(&self, work: &mut Work) {
        let held = work.features.iter().filter(|(_, curve)| self.is_held && self.is_shared[*curve as usize]);
        held.flat_map(|(ends, _)| ends).for_each(|&v| work.place[v as usize] = Place::Fixed);
    }

    /// The edges that are held, by their ends.
    pub fn held_edges(&self) -> impl Iterator<Item = [u32; 2]> + '_ {
        let is_held = |&(_, &curve): &(&[u32; 2], &u32)| {
            self.is_held && self.is_shared[curve as usize] || self.is_kept[curve as usize]
        };
        self.edges.iter().zip(&self.curve).filter(is_held).map(|(&ends, _)| ends)
    }

    /// Edges at these places were sewn.
    fn of(surface: FeaturedSurface, sewn_places: &FxHashSet<EdgePlace>, context: &Context) -> Result<Self> {
        let mesh = &surface.mesh;
        if mesh.face_count() == 0 {
            return Err(Error::input("the mesh has no faces", "", ""));
        }
        let edges: Vec<[u32; 2]> = surface.features.edges(mesh).map(|c| ends(mesh, c)).collect();
        let sewn = |c: CornerId| sewn_places.contains(&edge_place(mesh, c));
        let sewn: Vec<bool> = surface.features.edges(mesh).map(sewn).collect();
        let is_end = ends_of_sewn(mesh, &edges, &sewn);
        let is_corner = corners(mesh, &edges, &is_end);
        let curve = curves(mesh, &edges, &is_corner);
        let at_corner = (0..is_corner.len()).filter(|&v| is_corner[v]).map(|v| bits(mesh.points()[v])).collect();
        let (region, regions) = regions(&surface);
        let of = |t: u32| [0, 1, 2].map(|k| mesh.faces().corners()[3 * t as usize + k]);
        let in_regions = members(&region, regions);
        context.check()?;
        let tree = |list: Vec<u32>| {
            let faces: Vec<[u32; 3]> = list.iter().map(|&t| of(t)).collect();
            let tree = TriangleTree::new(mesh.points(), &faces);
            (list, tree)
        };
        let trees = in_regions.into_iter().map(tree).collect();
        let curve_count = curve.iter().max().map_or(0, |&m| m as usize + 1);
        let mut sides = vec![[NONE; 2]; curve_count];
        for (c, &curve) in surface.features.edges(mesh).zip(&curve) {
            let [own, other] = [Some(c), mesh.opposite(c)].map(|c| c.map_or(NONE, |c| region[mesh.face_of(c).index()]));
            sides[curve as usize] = [own.min(other), own.max(other)];
        }
        let mut is_shared = vec![false; curve_count];
        let shared: FxHashSet<[u32; 2]> = shared_borders(mesh).into_iter().map(|c| ends(mesh, c)).collect();
        let (mut is_sewn, mut is_kept) = (vec![false; curve_count], vec![false; curve_count]);
        for ((ends, &curve), &sewn) in edges.iter().zip(&curve).zip(&sewn) {
            is_shared[curve as usize] |= shared.contains(ends);
            is_sewn[curve as usize] |= sewn;
            is_kept[curve as usize] |= sewn && ends.iter().any(|&v| is_end[v as usize]);
        }
        let line = |list: Vec<u32>| {
            let tree = TriangleTree::of_segments(mesh.points(), list.iter().map(|&e| edges[e as usize]));
            (list, tree)
        };
        let lines = members(&curve, curve_count).into_iter().map(line).collect();
        let every: Vec<u32> = (0..edges.len() as u32).collect();
        let mut source = Source {
            paths: Vec::new(),
            diagonal: mesh.diagonal(),
            is_noisy: surface.found.noise.is_high(),
            bends: bends(mesh.points(), &edges, &curve, BEND_DEG),
            tips: tips(mesh, &edges),
            area: (0..mesh.face_count() as u32).map(|t| area(mesh, of(t))).sum(),
            normals: face_normals(mesh),
            all_curves: line(every).1,
            curves: lines,
            trees,
            region,
            regions,
            edges,
            curve,
            sides,
            is_shared,
            is_sewn,
            is_kept,
            sewn_places: sewn_places.clone(),
            is_held: false,
            may_lose_creases: false,
            guidance: Guidance::default(),
            is_cut: vec![false; curve_count],
            at_corner,
            surface,
        };
        source.paths = paths(&source);
        Ok(source)
    }

    /// Whether a curve has the same region on both sides.
    pub fn is_seam(&self, curve: u32) -> bool {
        let [a, b] = self.sides[curve as usize];
        a == b
    }

    /// Whether a curve is to have the edges that keep it. Creases of a scan, unlike its borders, are as rough as it is, and may be too
    /// short, or bend too much, for an edge of the quads.
    pub fn asks_for_edges(&self, curve: usize) -> bool {
        !self.is_cut[curve] && (!self.is_noisy || self.sides[curve].contains(&NONE))
    }

    /// Whether curves end at a point: to the bit.
    pub fn is_corner(&self, p: DVec3) -> bool {
        self.at_corner.contains(&bits(p))
    }

    /// The closest point of a region, and the triangle that it is in.
    pub fn on_region(&self, region: u32, p: DVec3) -> Option<(DVec3, u32)> {
        let (triangles, tree) = self.trees.get(region as usize)?;
        let found = tree.closest(p)?;
        Some((found.point, triangles[found.triangle as usize]))
    }

    /// Whether a region has a triangle within a distance that looks the same way.
    pub fn has_alike(&self, region: u32, p: DVec3, distance: f64, normal: DVec3) -> bool {
        let Some((triangles, tree)) = self.trees.get(region as usize) else { return false };
        let mut found = false;
        tree.within(p, distance, |near| {
            found |= self.normals[triangles[near.triangle as usize] as usize].dot(normal) > 0.0;
        });
        found
    }

    /// Unit normal of a triangle.
    pub fn normal(&self, triangle: u32) -> DVec3 {
        self.normals[triangle as usize]
    }

    /// The closest point of a curve.
    pub fn on_curve(&self, curve: u32, p: DVec3) -> Option<DVec3> {
        Some(self.curves.get(curve as usize)?.1.closest(p)?.point)
    }

    /// Whether a chord is near a curve, and about parallel to it.
    pub fn is_along(&self, curve: u32, [a, b]: [DVec3; 2], near: f64, cos: f64) -> bool {
        let Some((edges, tree)) = self.curves.get(curve as usize) else { return true };
        let along = (b - a).normalize_or_zero();
        CHORD_PLACES.iter().all(|&share| {
            tree.closest(a.lerp(b, share)).is_none_or(|found| {
                let [from, to] = self.edges[edges[found.triangle as usize] as usize];
                let way = self.surface.mesh.points()[to as usize] - self.surface.mesh.points()[from as usize];
                found.distance() <= near && way.normalize_or_zero().dot(along).abs() >= cos
            })
        })
    }

    /// The closest feature edge whose direction differs by no more than an angle, within a distance.
    pub fn feature_along(&self, p: DVec3, along: DVec3, distance: f64, cos: f64) -> Option<u32> {
        let mut best: Option<(f64, u32)> = None;
        self.all_curves.within(p, distance, |found| {
            let [a, b] = self.edges[found.triangle as usize].map(|v| self.surface.mesh.points()[v as usize]);
            let is_along = (b - a).normalize_or_zero().dot(along).abs() >= cos;
            let key = (found.distance_squared, found.triangle);
            if is_along && best.is_none_or(|b| key < b) {
                best = Some(key);
            }
        });
        best.map(|b| b.1)
    }
}

/// The vertices of the edge that leaves a corner.
pub fn ends(mesh: &SurfaceMesh, c: CornerId) -> [u32; 2] {
    [mesh.vertex(c).0, mesh.vertex(mesh.next(c)).0]
}

/// What a point is to the bit.
pub fn bits(p: DVec3) -> [u64; 3] {
    p.to_array().map(f64::to_bits)
}

fn area(mesh: &SurfaceMesh, t: [u32; 3]) -> f64 {
    let [a, b, c] = t.map(|v| mesh.points()[v as usize]);
    (b - a).cross(c - a).length() / 2.0
}

/// The members of every class.
fn members(class: &[u32], count: usize) -> Vec<Vec<u32>> {
    let mut lists = vec![Vec::new(); count];
    class.iter().zip(0u32..).for_each(|(&c, k)| lists[c as usize].push(k));
    lists
}

/// The vertices in the course of features where the part of them ends that was sewn.
fn ends_of_sewn(mesh: &SurfaceMesh, edges: &[[u32; 2]], sewn: &[bool]) -> Vec<bool> {
    let mut arms = vec![[0, 0]; mesh.vertex_count()];
    for (ends, &sewn) in edges.iter().zip(sewn) {
        ends.iter().for_each(|&v| arms[v as usize][usize::from(sewn)] += 1);
    }
    arms.into_iter().map(|arms| arms == [1, 1]).collect()
}

/// The vertices where feature curves end, branch or bend, and others that are known.
fn corners(mesh: &SurfaceMesh, edges: &[[u32; 2]], is_known: &[bool]) -> Vec<bool> {
    let mut arms = vec![Vec::new(); mesh.vertex_count()];
    for &[a, b] in edges {
        let along = (mesh.points()[b as usize] - mesh.points()[a as usize]).normalize_or_zero();
        arms[a as usize].push(along);
        arms[b as usize].push(-along);
    }
    let cos = RIDGE_TURN_DEG.to_radians().cos();
    let is_corner = |arms: &Vec<DVec3>| match arms[..] {
        [] => false,
        [a, b] => -a.dot(b) < cos,
        _ => true,
    };
    arms.iter().zip(is_known).map(|(arms, &known)| known || is_corner(arms)).collect()
}

/// Curve of every feature edge: they run from corner to corner.
fn curves(mesh: &SurfaceMesh, edges: &[[u32; 2]], is_corner: &[bool]) -> Vec<u32> {
    let mut sets = DisjointSets::new(edges.len());
    let mut last = vec![u32::MAX; mesh.vertex_count()];
    for (e, ends) in (0u32..).zip(edges) {
        for &v in ends.iter().filter(|&&v| !is_corner[v as usize]) {
            if last[v as usize] != u32::MAX {
                sets.union(last[v as usize], e);
            }
            last[v as usize] = e;
        }
    }
    sets.labels().0
}

/// Region of every triangle: features divide them.
fn regions(surface: &FeaturedSurface) -> (Vec<u32>, usize) {
    let mesh = &surface.mesh;
    let mut sets = DisjointSets::new(mesh.face_count());
    for c in (0..mesh.corner_count()).map(CornerId::new).filter(|&c| !surface.features.contains(c)) {
        if let Some(o) = mesh.opposite(c) {
            sets.union(mesh.face_of(c).0, mesh.face_of(o).0);
        }
    }
    sets.labels()
}
