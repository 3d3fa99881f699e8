//! Curve skeletons of closed surfaces, with radii.
//!
//! Tagliasacchi, Alhashim, Olson, Zhang, "Mean Curvature Skeletons", SGP 2012. The surface flows along its mean curvature and
//! is drawn to the centres of its largest inner balls. After some dozens of steps it is so thin that collapsing its edges,
//! shortest first, leaves curves.
//!
//! | stage, in the order of the calls | file |
//! |---|---|
//! | options | `options` |
//! | open ends get lids | `lids` |
//! | plane pieces of the surface that may be ends (used by `hex`) | `flat_ends` |
//! | surfaces with a wall (pipes with an inside) are refused | `wall` |
//! | small cavities are filled | `cavities` |
//! | straight tubes from one point: the axes of their flat ends; all that follows is for other shapes | `straight` |
//! | long edges are divided | `divide` |
//! | poles: the centres of the largest inner balls | `poles` |
//! | the flow, with its collapses and splits | `flow` |
//! | the thin surface becomes curves | `curves` |
//! | the axis of a thick tube is straight where a thin one leaves it | `mouths` |
//! | limbs that the flow has lost get branches | `limbs` |
//! | stubs are dropped, radii measured, nodes outside brought in | `tidy`; `body`, `sections` for all three |
//! | branches are extended to flat ends | `ends` |
//!
//! Departures from the paper:
//! - The poles are centres of shrinking balls (Ma, Bae, Choi 2012); no Voronoi diagram is made.
//! - Every node has a radius: its distance to the surface, or at flat ends that of the section across.
//! - Branches end at flat ends, and the long triangles of CAD systems are divided first.
//! - The result is checked: as many cycles as the surface has handles, and every node inside. If the number of cycles is
//!   wrong, the flow is repeated at a finer scale.

mod body;
mod cavities;
mod curves;
mod divide;
mod ends;
pub(crate) mod flat_ends;
mod flow;
mod lids;
mod limbs;
mod mouths;
mod options;
mod poles;
mod sections;
mod straight;
#[cfg(test)]
mod tests;
mod tidy;
mod tuning;
mod wall;

use crate::context::Context;
use crate::error::{Error, Result};
use crate::geometry::normals::face_normals;
use crate::geometry::search_tree::TriangleTree;
use crate::geometry::winding::WindingTree;
use crate::mesh::{CurveNet, RepairOptions, SurfaceMesh, Topology, UnitScale, repair};
use crate::words::counted;
use body::Body;
use serde::Serialize;
use tuning::{EMPTY, FINER, THINNEST};

pub(crate) use ends::Reach;
pub use lids::{Closed, Lid, closed};
pub use options::SkeletonOptions;
pub(crate) use tidy::centre;

/// A skeleton with its radii.
#[derive(Debug, Clone)]
pub struct Skeleton {
    /// The net; the radii are distances to the surface, in flat ends those of sections.
    pub net: CurveNet,
    /// The node that every vertex of the surface was drawn to.
    pub preimage: Vec<u32>,
    /// The surface with lids on its open ends.
    pub closed: Closed,
    /// Counts.
    pub figures: SkeletonFigures,
    /// Warnings for the user, one sentence each.
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

/// The surface with lids on its open ends, and a sentence for each thing that was mended.
///
/// # Errors
/// As [`extract`].
pub fn prepared(mesh: &SurfaceMesh, context: &Context) -> Result<(Closed, Vec<String>)> {
    close_and_check(mesh, context).map(|(closed, _, _, warnings)| (closed, warnings))
}

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
    context.install(|| extract_in_unit_scale(mesh, options, reach, context))
}

fn extract_in_unit_scale(
    mesh: &SurfaceMesh,
    options: &SkeletonOptions,
    reach: Reach,
    context: &Context,
) -> Result<Skeleton> {
    let (closed, genus, components, mut warnings) = close_and_check(mesh, context)?;
    let sharp = flat_ends::sharp(&closed);
    if reach == Reach::All
        && let Some(net) = straight_net(&closed)
    {
        let preimage = nearest_nodes(&closed.mesh, &net);
        let figures = SkeletonFigures::of(&net, genus, closed.lids.len(), 0, 0);
        return Ok(Skeleton { net, preimage, closed, figures, warnings });
    }
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
        let known = ends::Known { lids: &sharp, alone: reach == Reach::Sharp };
        let (brought_in, grown) = tidy::tidy(&mut net, &mut preimage, &body, &known, options.prune);
        warnings.extend(told_of_mends(brought_in, grown));
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
}

/// The skeleton of straight tubes from one point, if the surface is one of such.
pub(crate) fn straight_net(closed: &Closed) -> Option<CurveNet> {
    let topology = Topology::of(&closed.mesh);
    if (topology.genus, topology.components) != (Some(0), 1) {
        return None;
    }
    let tree = TriangleTree::new(closed.mesh.points(), &closed.mesh.faces().fan().0);
    let (normals, inside) = (face_normals(&closed.mesh), WindingTree::new(&tree));
    let body = Body { surface: &closed.mesh, poles: &[], tree: &tree, normals: &normals, inside: &inside };
    straight::straight(closed, &flat_ends::sharp(closed), &body)
}

/// What had to be mended, in words.
fn told_of_mends(brought_in: usize, grown: usize) -> impl Iterator<Item = String> {
    let inside = (brought_in > 0).then(|| format!("{brought_in} nodes lay outside and were moved inside"));
    let limbs = (grown > 0).then(|| format!("{grown} limbs had no branch and were given one"));
    inside.into_iter().chain(limbs)
}

/// The node nearest to every vertex.
fn nearest_nodes(surface: &SurfaceMesh, net: &CurveNet) -> Vec<u32> {
    let nodes: Vec<[u32; 3]> = (0..net.points.len() as u32).map(|v| [v; 3]).collect();
    let tree = TriangleTree::new(&net.points, &nodes);
    surface.points().iter().map(|&p| tree.closest(p).map_or(0, |near| near.triangle)).collect()
}

fn no_room(place: String) -> Error {
    Error::input("the surface has no room inside", place, "give a surface that encloses a volume")
}

/// Checks the surface and closes its open ends; also its handles and components.
fn close_and_check(mesh: &SurfaceMesh, context: &Context) -> Result<(Closed, usize, usize, Vec<String>)> {
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
        warnings.push(format!("{} components were inside out and were turned", topology.inverted_components));
        let outward = RepairOptions { weld: None, ..RepairOptions::default() };
        mesh = repair(&mesh, &outward, context)?.mesh.triangulated()?;
    }
    let mut closed = closed(&mesh)?;
    // An open surface shows its sense only when its ends are closed.
    if Topology::of(&closed.mesh).volume.is_some_and(|v| v < 0.0) && !closed.lids.is_empty() {
        warnings.push("the surface was inside out and was turned".into());
        let flipped: Vec<[u32; 3]> = mesh.faces().fan().0.iter().map(|&[a, b, c]| [a, c, b]).collect();
        closed = lids::closed(&SurfaceMesh::from_triangles(mesh.points().to_vec(), &flipped)?)?;
    }
    if !closed.lids.is_empty() {
        warnings.push(format!("{} open ends were closed by lids", closed.lids.len()));
    }
    if let Some(bent) = closed.lids.iter().position(|l| l.flatness > lids::BENT) {
        warnings
            .push(format!("the border of open end {} is far from plane, so that its lid is only a guess", bent + 1));
    }
    let topology = Topology::of(&closed.mesh);
    let box_volume = closed.mesh.diagonal().powi(3);
    if topology.volume.is_some_and(|volume| !(volume.abs() > EMPTY * box_volume)) {
        return Err(no_room(String::new()));
    }
    if let Some(thickness) = wall::thickness(&closed.mesh, &topology) {
        let share = 100.0 * thickness / closed.mesh.diagonal();
        return Err(Error::input(
            format!("the surface is a wall around a hollow, {share:.2} % of the diagonal thick, not a filled tube"),
            "",
            "give only its outer side, without the inner side and the rings between both: its open ends are closed by lids \
             (a segmentation tells the faces apart)",
        ));
    }
    let (closed, topology) = without_cavities(closed, topology, &mut warnings)?;
    Ok((closed, topology.genus.unwrap_or(0), topology.components, warnings))
}

/// The surface with its cavities filled, and what it is then.
fn without_cavities(closed: Closed, topology: Topology, warnings: &mut Vec<String>) -> Result<(Closed, Topology)> {
    if topology.components < 2 {
        return Ok((closed, topology));
    }
    let Some(filled) = cavities::filled(&closed)? else { return Ok((closed, topology)) };
    let cavities = counted(filled.count, "cavity was", "cavities were");
    let share = 100.0 * filled.share;
    warnings.push(format!("{cavities} filled ({share:.2} % of the volume), because they are flaws of a tube"));
    let topology = Topology::of(&filled.closed.mesh);
    Ok((filled.closed, topology))
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
