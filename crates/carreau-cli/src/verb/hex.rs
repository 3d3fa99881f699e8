//! `hex`: a hexahedral mesh of a tubular surface or of a skeleton.

use super::contract::Verb;
use crate::choice::choice;
use crate::common::Common;
use crate::host::Found;
use crate::outputs::Outputs;
use crate::prepare::PrepareFlags;
use crate::session::Session;
use carreau::hex::{self, Figures, HexOptions, HexResult, Layers, Order, Padding, Stage};
use carreau::io::{ResultKind, WriteOptions, check_second_order};
use carreau::mesh::{Attributes, Column, CurveNet, HexMesh, PrepareOptions, RawMesh, SurfaceMesh};
use carreau::report::hex_figure;
use carreau::report::page::Scene;
use carreau::words::{counted, rounded};
use carreau::{Error, Length};
use clap::Args;
use serde::{Deserialize, Serialize};
use serde_json::json;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Meshes a tubular surface, or the tubes around a skeleton, with hexahedra
///
/// The skeleton of a surface is found first (see `carreau skeleton`), or given. A skeleton is a graph with radii: .cgr, .cg, .skel,
/// .swc, .tgf, or the lines of a .vtp, .vtk or .obj file. The cells follow its branches, and every cell is certified to have
/// a positive Jacobian everywhere. Boundary faces are tagged: 1 is the wall; 2, 3 … are the ends, which are open, or flat with a sharp
/// rim. If the file of the surface has groups (face label ref), boundary faces keep them, and other ends get numbers above. A mesh
/// that is far from the surface, or covers a place twice, is not written (exit code 4).
#[derive(Args)]
#[command(after_help = "Examples:\n  \
    carreau hex vessel.stl -o vessel.vtu --picture vessel.png\n  \
    carreau hex cactus.obj -o cactus.mesh --hexes 3000 --json cactus.json\n  \
    carreau hex neuron.swc -o neuron.msh --padding all --refine-across 1")]
pub struct Hex {
    /// The surface or the skeleton
    input: PathBuf,
    /// The file to write: .mesh, .vtu, .vtk, .msh …
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// The skeleton of the surface
    #[arg(long, value_name = "FILE")]
    skeleton: Option<PathBuf>,
    /// The surface around the skeleton
    #[arg(long, value_name = "FILE", conflicts_with = "skeleton")]
    surface: Option<PathBuf>,
    /// Where a layer of hexes is added on the boundary [default: all]
    #[arg(long, value_name = "WHERE", value_parser = choice::<Padding>(&["none", "sides", "all"]))]
    padding: Option<Padding>,
    /// Halves every cell across its axis this many times, the layer included [default: 0; for surfaces as often as their shape needs]
    #[arg(long, value_name = "N")]
    refine_across: Option<u32>,
    /// Halves every cell along its axis this many times [default: 0]
    #[arg(long, value_name = "N")]
    refine_along: Option<u32>,
    /// Largest number of hexes, met approximately: sets the steps along the branches
    #[arg(long, value_name = "N", conflicts_with = "edge_length")]
    hexes: Option<usize>,
    /// Length of the steps along the branches
    #[arg(long, value_name = "LENGTH")]
    edge_length: Option<Length>,
    /// Gives all nodes this radius
    #[arg(long, value_name = "LENGTH")]
    radius: Option<Length>,
    /// Inserts cells where a branch of a skeleton is more than twice as thick as where it is thinnest
    #[arg(long)]
    adapt_radius: bool,
    /// base takes the graph as given, without clean-up and resampling [default: full]
    #[arg(long, value_name = "STAGE", value_parser = choice::<Stage>(&["base", "full"]))]
    stage: Option<Stage>,
    /// Adds this many boundary layers on the wall, for flow
    #[arg(long, value_name = "N")]
    layers: Option<u32>,
    /// Thickness of the first layer, the one at the wall
    #[arg(long, value_name = "LENGTH")]
    first_layer: Option<Length>,
    /// Thickness of a layer divided by that of the one before it [default: 1.2]
    #[arg(long, value_name = "R")]
    growth: Option<f64>,
    /// Adds a straight piece of this many radii at every end
    #[arg(long, value_name = "RADII")]
    extend: Option<f64>,
    /// Order of the cells: 2 adds nodes in the middle of edges and faces, those of the boundary on the surface [default: 1]
    #[arg(long, value_name = "1|2", value_parser = choice::<Order>(&["1", "2"]))]
    order: Option<Order>,
    /// Also writes cells without a certificate; the record lists them
    #[arg(long)]
    allow_invalid: bool,
    /// Largest two-sided distance between cells and surface that is accepted [default: 2%]
    #[arg(long, value_name = "LENGTH")]
    max_distance: Option<Length>,
    /// Also writes meshes that are farther than that from the surface, or whose cells overlap
    #[arg(long)]
    allow_far: bool,
    #[command(flatten)]
    prepare: PrepareFlags,
    #[command(flatten)]
    common: Common,
}

/// All options of a run.
#[derive(Default, Serialize, Deserialize)]
#[serde(default)]
pub struct Options {
    padding: Padding,
    skeleton: Option<PathBuf>,
    surface: Option<PathBuf>,
    refine_across: Option<u32>,
    refine_along: u32,
    hexes: Option<usize>,
    edge_length: Option<Length>,
    radius: Option<Length>,
    adapt_radius: bool,
    stage: Stage,
    layers: Option<u32>,
    first_layer: Option<Length>,
    growth: Option<f64>,
    extend: Option<f64>,
    order: Order,
    allow_invalid: bool,
    max_distance: Option<Length>,
    allow_far: bool,
    #[serde(flatten)]
    prepare: PrepareOptions,
}

impl Options {
    /// The options of the method, for a shape with this diagonal.
    fn resolved(&self, diagonal: f64) -> HexOptions {
        HexOptions {
            padding: self.padding,
            refine_across: self.refine_across,
            refine_along: self.refine_along,
            adapt_radius: self.adapt_radius,
            stage: self.stage,
            hexes: self.hexes,
            edge_length: self.edge_length.map(|l| l.resolve(diagonal)),
            radius: self.radius.map(|l| l.resolve(diagonal)),
            layers: self.layers.zip(self.first_layer).map(|(count, first)| Layers {
                count,
                first: first.resolve(diagonal),
                growth: self.growth.unwrap_or(hex::GROWTH),
            }),
            extend: self.extend,
            order: self.order,
            allow_invalid: self.allow_invalid,
            max_distance: self.max_distance.map(|l| l.resolve(diagonal)),
            allow_far: self.allow_far,
        }
    }
}

impl Verb for Hex {
    const NAME: &'static str = "hex";
    type Options = Options;

    fn common(&self) -> &Common {
        &self.common
    }

    fn common_mut(&mut self) -> &mut Common {
        &mut self.common
    }

    fn subject(&self) -> Option<&Path> {
        Some(&self.input)
    }

    fn files(&self) -> Outputs {
        let files = Outputs::of(&self.common).needs(Some(&self.input));
        let files = files.needs(self.skeleton.as_deref()).needs(self.surface.as_deref());
        files.writes(self.output.as_deref(), ResultKind::Hexes)
    }

    fn defaults(&self) -> Options {
        Options::default()
    }

    fn lay_over(&self, all: &mut Options) -> Result<(), Error> {
        all.padding = self.padding.unwrap_or(all.padding);
        all.refine_across = self.refine_across.or(all.refine_across);
        all.skeleton = self.skeleton.clone().or(all.skeleton.take());
        all.surface = self.surface.clone().or(all.surface.take());
        all.refine_along = self.refine_along.unwrap_or(all.refine_along);
        all.hexes = self.hexes.or(all.hexes);
        all.edge_length = self.edge_length.or(all.edge_length);
        all.radius = self.radius.or(all.radius);
        all.adapt_radius |= self.adapt_radius;
        all.stage = self.stage.unwrap_or(all.stage);
        all.layers = self.layers.or(all.layers);
        all.first_layer = self.first_layer.or(all.first_layer);
        all.growth = self.growth.or(all.growth);
        all.order = self.order.unwrap_or(all.order);
        if let Some(file) = self.output.as_deref().filter(|_| all.order == Order::Second) {
            check_second_order(file)?;
        }
        all.extend = self.extend.or(all.extend);
        all.allow_invalid |= self.allow_invalid;
        all.max_distance = self.max_distance.or(all.max_distance);
        all.allow_far |= self.allow_far;
        all.prepare = self.prepare.over(all.prepare);
        match (all.layers, all.first_layer, all.growth) {
            (Some(_), None, _) => {
                return Err(Error::Options("--layers needs --first-layer, the thickness of the first one".into()));
            }
            (None, Some(_), _) | (None, _, Some(_)) => {
                return Err(Error::Options("--first-layer and --growth need --layers, the number of layers".into()));
            }
            _ => {}
        }
        // Lengths above zero on a diagonal above zero.
        all.resolved(1.0).validate()?;
        Ok(())
    }

    fn work(&self, session: &mut Session, options: &Options) -> Result<(), Error> {
        let shape = self.read(session, options)?;
        let diagonal = shape.diagonal();
        let wanted = options.resolved(diagonal);
        if wanted.adapt_radius && matches!(shape, Shape::Surface(..)) {
            return Err(Error::Options("--adapt-radius works on a skeleton without a surface only".into()));
        }
        if wanted.max_distance.is_some() && matches!(shape, Shape::Graph(..)) {
            return Err(Error::Options("--max-distance needs a surface".into()));
        }
        let context = session.context.clone();
        let mut found = context.install(|| match &shape {
            Shape::Graph(net) => hex::from_net(net, &wanted, &context),
            Shape::Surface(mesh, net) => hex::from_surface(mesh, net.as_ref(), &wanted, &context),
        })?;
        found.warnings.iter().for_each(|w| session.warn(w));
        let names = match &shape {
            Shape::Surface(surface, _) => tag_after(surface, &mut found, session)?,
            Shape::Graph(_) => None,
        };
        let has_groups = names.is_some();
        let names = names.unwrap_or_else(|| own_names(&found.mesh));
        session.record.set("tags", &names);
        let HexResult { mesh, figures, skeleton, .. } = &found;
        session.draw_as(|| hex_figure(mesh))?;
        session.show_result(self.output.as_deref(), |name, _| {
            Ok(Scene::of_hexes(name, mesh)?.net("skeleton", skeleton))
        })?;
        session.record.set_all(figures);
        session.record.set("quality", &figures.quality);
        session.record.set("output", json!({ "hexes": figures.hexes, "vertices": figures.vertices }));
        tell(session, figures);
        if let Some(file) = &self.output {
            let mut raw = found.raw();
            // A format without a place for names need not say that it leaves out those of tags that all files have.
            let names = if has_groups || holds_names(file) { names } else { BTreeMap::new() };
            raw.attributes.names = names.into_iter().map(|(tag, name)| (("ref".to_string(), tag), name)).collect();
            session.write_mesh(file, &raw, &WriteOptions::default())?;
        }
        session.keep(|| Found::Hexes(found));
        Ok(())
    }
}

impl Hex {
    /// What the files hold; a file of lines and faces is a surface.
    fn read(&self, session: &mut Session, options: &Options) -> Result<Shape, Error> {
        if !session.is_skeleton(&self.input) {
            let raw = session.read(&self.input)?;
            if !(raw.faces.is_empty() && raw.cells.is_empty()) {
                let net = options.skeleton.as_deref().map(|file| session.load_skeleton(file)).transpose()?;
                return Ok(Shape::Surface(Box::new(session.read_body(raw, &options.prepare)?.mesh), net));
            }
        }
        if options.skeleton.is_some() {
            return Err(Error::Options("--skeleton belongs to a surface, but the input is a skeleton itself".into()));
        }
        let net = session.read_skeleton(&self.input)?;
        Ok(match &options.surface {
            Some(file) => {
                let raw = session.load_mesh(file)?;
                Shape::Surface(Box::new(session.read_body(raw, &options.prepare)?.mesh), Some(net))
            }
            None => Shape::Graph(net),
        })
    }
}

/// The summary.
fn tell(session: &mut Session, figures: &Figures) {
    let quality = &figures.quality;
    session.say(format!(
        "{} hexes on {} segments, scaled Jacobian {:.3} at least, {:.3} on average",
        figures.hexes, figures.segments, quality.scaled_jacobian_min, quality.scaled_jacobian_mean
    ));
    session.say(match quality.uncertified.len() {
        0 => "every cell is certified".into(),
        n => format!("{n} cells are not certified"),
    });
    session.say(figures.verdict());
    if let Some(straight) = &figures.straight_edges {
        let edges = counted(straight.count, "edge stays", "edges stay");
        session.say(format!("cells of second order, {edges} straight"));
    }
    if let Some(layers) = &figures.layers {
        session.say(format!(
            "{} layers, together {} thick on {:.1}% of the wall, within a tenth",
            layers.asked.count,
            rounded(layers.thickness, layers.thickness),
            100.0 * layers.as_asked
        ));
    }
}

/// The names of the tags of a mesh whose surface has no groups.
fn own_names(mesh: &HexMesh) -> BTreeMap<i32, String> {
    let name = |tag: i32| if tag == 1 { "wall".to_string() } else { format!("cap_{}", tag - 1) };
    mesh.tags.iter().map(|&tag| (tag, name(tag))).collect()
}

fn holds_names(file: &Path) -> bool {
    file.extension()
        .and_then(|e| e.to_str())
        .is_some_and(|e| ["msh", "inp", "bdf"].contains(&e.to_lowercase().as_str()))
}

/// Gives the boundary faces the groups of the surface, where its file has some (label `ref`), and returns the names. The wall
/// gets the group of the nearest face, a flat end its own group if the file has one for it. Other ends get numbers above all groups:
/// the surface has no face there, or none that is told from its wall. Everything else that the surface carries is left
/// behind, with a word.
fn tag_after(
    surface: &SurfaceMesh,
    found: &mut HexResult,
    session: &mut Session,
) -> Result<Option<BTreeMap<i32, String>>, Error> {
    const GROUP: &str = "ref";
    let groups = match surface.attributes.face.get(GROUP) {
        Some(Column::Label(groups)) => Some(groups.clone()),
        _ => None,
    };
    let mut rest = surface.clone();
    rest.attributes.face.remove(GROUP);
    session.leave_behind(&rest, "a volume mesh", |_| false);
    let Some(groups) = groups else { return Ok(None) };
    let most = groups.iter().copied().max().unwrap_or(0).max(0);
    rest.attributes = Attributes::words_of(&surface.attributes);
    rest.attributes.face.insert(GROUP.into(), Column::Label(groups));
    rest.tagged_edges.clear();
    let faces = found.mesh.quads.iter().map(|q| &q[..]).collect();
    let mut boundary = RawMesh { points: found.mesh.points.clone(), faces, ..RawMesh::default() };
    session.carry(&rest, &mut boundary)?;
    let Some(Column::Label(carried)) = boundary.attributes.face.get(GROUP) else { return Ok(None) };
    let carried: Vec<i32> = found.origins.iter().map(|&face| carried[face as usize]).collect();
    let own = surface.attributes.names.iter().filter(|((column, _), _)| column == GROUP);
    let mut names: BTreeMap<i32, String> = own.map(|((_, tag), name)| (*tag, name.clone())).collect();
    let groups_of_ends: BTreeMap<i32, i32> = found
        .flat_caps
        .iter()
        .filter_map(|&cap| group_of_end(cap, &found.mesh.tags, &carried).map(|group| (cap, group)))
        .collect();
    for (tag, group) in found.mesh.tags.iter_mut().zip(carried) {
        // The wall has tag 1, the ends 2, 3 ….
        let end = *tag - 1;
        if end == 0 {
            *tag = group;
        } else if let Some(group) = groups_of_ends.get(tag) {
            *tag = *group;
        } else {
            *tag = most.saturating_add(end);
            names.entry(*tag).or_insert_with(|| format!("cap_{end}"));
        }
    }
    Ok(Some(names))
}

/// The group that most faces of an end have, unless more faces of the wall have it.
fn group_of_end(cap: i32, tags: &[i32], groups: &[i32]) -> Option<i32> {
    let mut counts: BTreeMap<i32, [usize; 2]> = BTreeMap::new();
    for (&tag, &group) in tags.iter().zip(groups) {
        let [on_end, on_wall] = counts.entry(group).or_default();
        *on_end += usize::from(tag == cap);
        *on_wall += usize::from(tag == 1);
    }
    let (group, [on_end, on_wall]) = counts.into_iter().max_by_key(|(group, [on_end, _])| (*on_end, -group))?;
    (on_end > on_wall).then_some(group)
}

/// What is meshed.
enum Shape {
    Graph(CurveNet),
    Surface(Box<SurfaceMesh>, Option<CurveNet>),
}

impl Shape {
    fn diagonal(&self) -> f64 {
        match self {
            Shape::Graph(net) => net.diagonal(),
            Shape::Surface(mesh, _) => mesh.diagonal(),
        }
    }
}
