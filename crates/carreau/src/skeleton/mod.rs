//! Curve skeletons of closed surfaces.
//!
//! Tagliasacchi, Alhashim, Olson, Zhang, "Mean Curvature Skeletons", SGP 2012. The surface flows along its mean curvature,
//! drawn to the centres of its largest inner balls, and is thinned as it shrinks; what is left after some dozens of steps
//! is so thin that collapsing its edges, shortest first, leaves curves.
//!
//! | stage | file |
//! |---|---|
//! | open ends get lids | `lids` |
//! | plane pieces of the surface that may be ends (for `hex`) | `flat_ends` |
//! | walls are refused | `wall` |
//! | long edges are divided | `divide` |
//! | centres of the largest inner balls | `poles` |
//! | flow, collapses and splits | `flow` |
//! | what is thin becomes curves | `curves` |
//! | limbs that the flow has lost get branches | `limbs` |
//! | stubs go, radii, nodes outside are brought in | `tidy` |
//! | branches are led to flat ends | `ends` |
//!
//! Departures from the paper: the poles are centres of shrinking balls (Ma, Bae, Choi 2012), no Voronoi diagram is made;
//! every node has a radius, the distance to the surface (in flat ends: across); branches end at flat ends; the triangles of
//! CAD systems are divided first; and the result is checked: as many cycles as the surface has
//! handles, every node inside. Where the cycles are too many or too few the flow is repeated at a finer scale.

mod curves;
mod divide;
mod ends;
pub(crate) mod flat_ends;
mod flow;
mod lids;
mod limbs;
mod poles;
#[cfg(test)]
mod tests;
mod tidy;
mod wall;

pub(crate) use ends::Reach;
pub use lids::{Closed, Lid, closed};
use tidy::Body;
pub(crate) use tidy::centre;

use crate::bounds::within;
use crate::context::Context;
use crate::error::{Error, Result};
use crate::geometry::normals::face_normals;
use crate::geometry::search_tree::TriangleTree;
use crate::geometry::winding::WindingTree;
use crate::mesh::{CurveNet, RepairOptions, SurfaceMesh, Topology, UnitScale, repair};
use serde::{Deserialize, Serialize};
use std::ops::Bound;

/// Options of [`extract`]; the defaults are the paper's.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct SkeletonOptions {
    /// Weight of the pull back to where a vertex is: larger is slower and closer to the shape.
    pub speed: f64,
    /// Weight of the pull to the centre of the inner ball.
    pub medial: f64,
    /// Edges shorter than this share of the diagonal are collapsed.
    pub detail: f64,
    /// Whether branches within the ball of their branching are dropped.
    pub prune: bool,
}

impl Default for SkeletonOptions {
    fn default() -> Self {
        SkeletonOptions { speed: 0.1, medial: 0.2, detail: 0.002, prune: true }
    }
}

impl SkeletonOptions {
    /// Refuses values out of range.
    ///
    /// # Errors
    /// [`Error::Options`].
    pub fn validate(&self) -> Result<()> {
        let above_zero = |most: f64| (Bound::Excluded(0.0), Bound::Included(most));
        within("speed", self.speed, above_zero(10.0), "")?;
        within("medial", self.medial, above_zero(10.0), "")?;
        within("detail", self.detail, above_zero(0.1), "")
    }
}

/// A skeleton with its radii.
#[derive(Debug, Clone)]
pub struct Skeleton {
    /// The net; the radii are distances to the surface, in flat ends those of sections.
    pub net: CurveNet,
    /// The node that every vertex of the surface was drawn to.
    pub preimage: Vec<u32>,
    /// The surface with lids on its open ends.
    pub closed: Closed,
    /// What was counted.
    pub figures: SkeletonFigures,
    /// What the user should know.
    pub warnings: Vec<String>,
}

/// Counts of a skeleton; the result record's own part.
#[derive(Debug, Clone, Serialize)]
pub struct SkeletonFigures {
    /// Nodes.
    pub nodes: usize,
    /// Segments.
    pub segments: usize,
    /// Nodes of valence 1.
    pub extremities: usize,
    /// Nodes of valence 3 and more.
    pub branchings: usize,
    /// Independent cycles of all components together.
    pub cycles: usize,
    /// Components.
    pub components: usize,
    /// Handles of the surface.
    pub genus: usize,
    /// Open ends that got a lid.
    pub lids: usize,
    /// Nodes that lay outside and were brought in.
    pub brought_in: usize,
    /// Steps of the flow.
    pub steps: usize,
}

/// The surface with lids on its open ends, and what was mended.
///
/// # Errors
/// As [`extract`].
pub fn prepared(mesh: &SurfaceMesh, context: &Context) -> Result<(Closed, Vec<String>)> {
    prepare(mesh, context).map(|(closed, _, _, warnings)| (closed, warnings))
}

/// What takes longer than in proportion is done with about so many of the vertices of a surface that has more.
const MANY: usize = 100_000;

/// Shares of the detail tried in turn, until the cycles are as many as the handles.
const FINER: [f64; 3] = [1.0, 0.5, 0.25];

/// The curve skeleton of a surface.
///
/// ```
/// use carreau::{Context, sample, skeleton};
/// let context = Context::new();
/// let mesh = sample::make("tube-tree", Some(46), &context)?;
/// let thin = skeleton::extract(&mesh, &skeleton::SkeletonOptions::default(), &context)?;
/// assert_eq!((thin.figures.cycles, thin.figures.components), (0, 1));
/// assert!(thin.net.radii.iter().all(|&r| r > 0.0));
/// # Ok::<(), carreau::Error>(())
/// ```
///
/// # Errors
/// [`Error::Input`] for a surface that is not triangular, not manifold or not consistently oriented, [`Error::Numeric`]
/// where the cycles do not come out as many as the handles; [`Error::Cancelled`], [`Error::Deadline`].
pub fn extract(mesh: &SurfaceMesh, options: &SkeletonOptions, context: &Context) -> Result<Skeleton> {
    extract_with(mesh, options, Reach::All, context)
}

/// As [`extract`]; branches are led to some of the flat ends, and stop before others.
pub(crate) fn extract_with(
    mesh: &SurfaceMesh,
    options: &SkeletonOptions,
    reach: Reach,
    context: &Context,
) -> Result<Skeleton> {
    options.validate()?;
    let scale = UnitScale::of_mesh(mesh);
    if let Some(mesh) = scale.mesh(mesh, &[]) {
        let found = extract_with(&mesh, options, reach, context)?;
        let closed = found.closed.moved(scale.back());
        return Ok(Skeleton { net: scale.back().moved_net(found.net), closed, ..found });
    }
    context.install(|| {
        let (closed, genus, components, mut warnings) = prepare(mesh, context)?;
        let divided = divide::divided(&closed.mesh, context)?;
        let surface = divided.as_ref().unwrap_or(&closed.mesh);
        let triangles = surface.faces().fan().0;
        let tree = TriangleTree::new(surface.points(), &triangles);
        let normals = face_normals(surface);
        let poles = {
            let _stage = context.stage("inner balls");
            poles::poles(surface, context)?
        };
        let mut found = (0, 0);
        for share in FINER {
            let options = SkeletonOptions { detail: share * options.detail, ..options.clone() };
            let thin = flow::contract(surface, &poles, &options, context)?;
            let steps = thin.steps;
            let _stage = context.stage("curves");
            let curves = curves::curves(thin);
            found = (curves.net.cycles().iter().sum(), curves.net.components().1);
            if found != (genus, components) {
                tracing::debug!(?found, genus, components, share, "cycles");
                continue;
            }
            let (mut net, mut preimage) = (curves.net, curves.preimage);
            let inside = WindingTree::new(&tree);
            let body = Body { surface, poles: &poles, tree: &tree, normals: &normals, inside: &inside };
            let sharp = flat_ends::sharp(&closed);
            let known = ends::Known { lids: &sharp, alone: reach == Reach::Sharp };
            let (brought_in, grown) = tidy::tidy(&mut net, &mut preimage, &body, &known, options.prune);
            if brought_in > 0 {
                warnings.push(format!("{brought_in} nodes lay outside and were brought in"));
            }
            if grown > 0 {
                warnings.push(format!("{grown} limbs had no branch and were given one"));
            }
            let is_thin = |v: &usize| !(net.radii[*v] > THINNEST * surface.diagonal());
            if let Some(p) = (0..net.points.len()).find(is_thin).map(|v| net.points[v]) {
                return Err(no_room(format!("near {:.6} {:.6} {:.6}", p.x, p.y, p.z)));
            }
            let ends = ends::reach_ends(&mut net, &body, &known);
            tidy::drop_beside(&mut net, &mut preimage, &ends);
            preimage.truncate(closed.mesh.vertex_count());
            let figures = SkeletonFigures::of(&net, genus, closed.lids.len(), brought_in, steps);
            return Ok(Skeleton { net, preimage, closed, figures, warnings });
        }
        let (cycles, parts) = found;
        Err(Error::Numeric(format!(
            "the skeleton came out with {cycles} cycles in {parts} parts, the surface has {genus} handles in {components}; \
             refine the surface, or look for tunnels in it"
        )))
    })
}

/// What is thinner than this share of the diagonal is a sheet, flat or folded onto itself, but for rounding to single precision.
const THINNEST: f64 = 1e-6;
/// Volumes below this share of the cube of the diagonal are rounding.
const EMPTY: f64 = 1e-14;

fn no_room(place: String) -> Error {
    Error::input("the surface has no room inside", place, "give a surface that encloses a volume")
}

/// Checks the surface and closes its open ends; also its handles and components.
fn prepare(mesh: &SurfaceMesh, context: &Context) -> Result<(Closed, usize, usize, Vec<String>)> {
    let _stage = context.stage("surface");
    if mesh.face_count() == 0 {
        return Err(Error::input("the surface has no faces", "", "give a surface of triangles"));
    }
    let mesh = mesh.clone().triangulated()?;
    let topology = Topology::of(&mesh);
    topology.require_manifold()?;
    topology.require_consistent_orientation()?;
    let (mut warnings, mut mesh) = (Vec::new(), mesh);
    if topology.inverted_components > 0 {
        warnings.push(format!("{} components were turned inside out", topology.inverted_components));
        let outward = RepairOptions { weld: None, ..RepairOptions::default() };
        mesh = repair(&mesh, &outward, context)?.mesh.triangulated()?;
    }
    let mut closed = closed(&mesh)?;
    // An open surface shows its sense only when its ends are closed.
    if Topology::of(&closed.mesh).volume.is_some_and(|v| v < 0.0) && !closed.lids.is_empty() {
        warnings.push("the surface was turned inside out".into());
        let flipped: Vec<[u32; 3]> = mesh.faces().fan().0.iter().map(|&[a, b, c]| [a, c, b]).collect();
        closed = lids::closed(&SurfaceMesh::from_triangles(mesh.points().to_vec(), &flipped)?)?;
    }
    if !closed.lids.is_empty() {
        warnings.push(format!("{} open ends were closed by lids", closed.lids.len()));
    }
    if let Some(bent) = closed.lids.iter().position(|l| l.flatness > lids::BENT) {
        warnings.push(format!("the border of open end {} is far from a plane: its lid is a guess", bent + 1));
    }
    let topology = Topology::of(&closed.mesh);
    let box_volume = closed.mesh.diagonal().powi(3);
    if topology.volume.is_some_and(|volume| !(volume.abs() > EMPTY * box_volume)) {
        return Err(no_room(String::new()));
    }
    if let Some(thickness) = wall::thickness(&closed.mesh, &topology) {
        let share = 100.0 * thickness / closed.mesh.diagonal();
        return Err(Error::input(
            format!("the surface is that of a wall around a room, {share:.2} % of the diagonal thick: no filled tube"),
            "",
            "give its outer side alone, without the inner side and the rings between both: its open ends are closed by lids \
             (a segmentation tells the faces apart)",
        ));
    }
    let genus = topology.genus.unwrap_or(0);
    Ok((closed, genus, topology.components, warnings))
}

impl SkeletonFigures {
    fn of(net: &CurveNet, genus: usize, lids: usize, brought_in: usize, steps: usize) -> Self {
        let around = net.incidence();
        let with = |least: usize, most: usize| {
            (0..net.points.len() as u32).filter(|&v| (least..=most).contains(&around.valence(v))).count()
        };
        SkeletonFigures {
            nodes: net.points.len(),
            segments: net.edges.len(),
            extremities: with(1, 1),
            branchings: with(3, usize::MAX),
            cycles: net.cycles().iter().sum(),
            components: net.components().1,
            genus,
            lids,
            brought_in,
            steps,
        }
    }
}
