//! `patch`: quad patches on the given vertices, as a mesh or as CAD faces.

use super::contract::Verb;
use crate::choice::choice;
use crate::common::Common;
use crate::host::Found;
use crate::outputs::{Content, Outputs};
use crate::prepare::{PrepareFlags, edges_of_surface};
use crate::session::Session;
use carreau::geometry::features::Creases;
use carreau::io::cad::{CAD_EXTENSIONS, CadOptions, StepSchema, write_cad};
use carreau::io::{ResultKind, WriteOptions, extension};
use carreau::mesh::{FaceId, PrepareOptions, Prepared, Takes, VertexId};
use carreau::patch::cad::{self, BrepOptions, Fit};
use carreau::patch::{self, Dissection, PatchOptions, PatchResult, Policy, Quality, Strategy, quad_mesh};
use carreau::report::page::Scene;
use carreau::words::counted;
use carreau::{Error, Length};
use clap::Args;
use serde::{Deserialize, Serialize};
use serde_json::json;
use std::path::{Path, PathBuf};

/// Decomposes a triangle mesh into quad patches on its own vertices
///
/// The output is a mesh (one quad per cell, then the leftover triangles) or, by extension, an IGES or STEP file. In these, flat
/// regions are planes and all other faces are free of bends, so that every program computes the right area and volume.
#[derive(Args)]
#[command(after_help = "Examples:\n  \
    carreau patch part.stl -o part.step\n  \
    carreau patch scan.ply -o scan.obj --layout scan.json --picture scan.png\n  \
    carreau patch part.obj -o part.step --fit bicubic --tolerance 0.1%\n  \
    carreau patch scan.obj -o scan.igs --preset paper")]
pub struct Patch {
    /// The triangle mesh; polygons are cut into fans of triangles
    input: PathBuf,
    /// The file to write: a mesh, or .igs .iges .step .stp
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Writes the patches as grids of vertex and triangle ids (JSON)
    #[arg(long, value_name = "FILE.json")]
    layout: Option<PathBuf>,
    /// Takes all options from the paper's pipeline, or the defaults
    #[arg(long, value_name = "PRESET", value_parser = choice::<Preset>(&["default", "paper"]))]
    preset: Option<Preset>,
    /// How patches are found [default: grow]
    #[arg(long, value_name = "STRATEGY", value_parser = choice::<Strategy>(&["grow", "zones", "matching", "matching-cardinality"]))]
    strategy: Option<Strategy>,
    /// How contradictions between rows and columns are resolved [default: keep-first]
    #[arg(long, value_name = "POLICY", value_parser = choice::<Policy>(&["paper", "keep-first"]))]
    policy: Option<Policy>,
    /// Smallest patch, in cells; 1 keeps single quads [default: 2]
    #[arg(long, value_name = "N")]
    min_cells: Option<u32>,
    /// Largest Q of equation 1, in degrees [default: 90]
    #[arg(long, value_name = "DEG")]
    q_max: Option<f64>,
    /// Largest angle between the two triangles of a quad [default: 30]
    #[arg(long, value_name = "DEG")]
    dihedral: Option<f64>,
    /// Accepts a larger angle where the surface around bends as much
    #[arg(long)]
    adapt_dihedral: bool,
    /// Rejects quads with a corner above 180 degrees
    #[arg(long)]
    convex_only: bool,
    /// How candidate quads are ranked [default: angles]
    #[arg(long, value_name = "MEASURE", value_parser = choice::<Quality>(&["angles", "adapted", "jacobian"]))]
    quality: Option<Quality>,
    /// How polygons are cut into rectangles [default: minimum]
    #[arg(long, value_name = "METHOD", value_parser = choice::<Dissection>(&["greedy", "longest-row", "minimum"]))]
    dissection: Option<Dissection>,
    /// Joins patches along complete common sides [default: true]
    #[arg(long, value_name = "BOOL", num_args = 0..=1, default_missing_value = "true")]
    merge: Option<bool>,
    /// Rectangles that strategy grow tries through each triangle; 0 tries all [default: 16, fewer on large meshes]
    #[arg(long, value_name = "N")]
    probes: Option<u32>,
    /// Strategy grow ends rectangles at creases sharper than this; merging may join them along complete sides [default: 40]
    #[arg(long, value_name = "DEG")]
    crease_angle: Option<f64>,
    /// Never crosses edges with more than this angle between the faces [default: none; 30 for CAD files]
    #[arg(long, value_name = "DEG")]
    feature_angle: Option<f64>,
    /// Never crosses these edges: a file with two vertex ids per line
    #[arg(long, value_name = "FILE")]
    features: Option<PathBuf>,
    /// Allows patches to cross edges tagged in the file
    #[arg(long)]
    ignore_tags: bool,
    /// CAD faces: auto makes planes, and divides patches at their bends; bicubic also makes curved patches splines within the
    /// tolerance; bilinear makes one face per patch, whose area and volume many programs get wrong [default: auto]
    #[arg(long, value_name = "FIT", value_parser = choice::<Fit>(&["auto", "bilinear", "bicubic"]))]
    fit: Option<Fit>,
    /// Largest distance of a vertex from a bicubic face [default: 0.1%]
    #[arg(long, value_name = "LENGTH")]
    tolerance: Option<Length>,
    /// Makes one trimmed CAD face per rectilinear polygon instead of one face per patch; not with strategy grow
    #[arg(long, conflicts_with = "fit")]
    trimmed: bool,
    /// Application protocol of STEP files [default: ap214]
    #[arg(long, value_name = "PROTOCOL", value_parser = choice::<StepSchema>(&["ap214", "ap242"]))]
    schema: Option<StepSchema>,
    #[command(flatten)]
    prepare: PrepareFlags,
    #[command(flatten)]
    common: Common,
}

/// Creases that no face of a CAD file crosses unless told otherwise, in degrees.
const CREASE_ANGLE: f64 = 30.0;

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Preset {
    #[default]
    Default,
    Paper,
}

/// What replays a run.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct Options {
    #[serde(flatten)]
    patch: PatchOptions,
    features: Option<PathBuf>,
    #[serde(flatten)]
    brep: BrepOptions,
    trimmed: bool,
    schema: StepSchema,
    #[serde(flatten)]
    prepare: PrepareOptions,
}

impl Verb for Patch {
    const NAME: &'static str = "patch";
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
        let files =
            Outputs::of(&self.common).reads(&self.input, ResultKind::SurfaceOrCad).needs(self.features.as_deref());
        files.writes(self.output.as_deref(), ResultKind::SurfaceOrCad).also(
            "--layout",
            self.layout.as_deref(),
            Content::Json,
        )
    }

    fn defaults(&self) -> Options {
        let preset = match self.preset {
            Some(Preset::Paper) => PatchOptions::paper(),
            _ => PatchOptions::default(),
        };
        Options { patch: preset, ..Options::default() }
    }

    fn lay_over(&self, all: &mut Options) -> Result<(), Error> {
        let o = &mut all.patch;
        o.strategy = self.strategy.unwrap_or(o.strategy);
        o.policy = self.policy.unwrap_or(o.policy);
        o.min_cells = self.min_cells.unwrap_or(o.min_cells);
        o.q_max = self.q_max.unwrap_or(o.q_max);
        o.dihedral = self.dihedral.unwrap_or(o.dihedral);
        o.adapt_dihedral |= self.adapt_dihedral;
        o.convex_only |= self.convex_only;
        o.quality = self.quality.unwrap_or(o.quality);
        o.dissection = self.dissection.unwrap_or(o.dissection);
        o.merge = self.merge.unwrap_or(o.merge);
        o.probes = self.probes.or(o.probes);
        o.crease_angle = self.crease_angle.unwrap_or(o.crease_angle);
        if self.feature_angle.is_some() {
            (o.feature_angle, o.creases) = (self.feature_angle, Creases::Every);
        }
        o.tagged_edges &= !self.ignore_tags;
        all.brep.fit = self.fit.unwrap_or(all.brep.fit);
        all.brep.tolerance = self.tolerance.unwrap_or(all.brep.tolerance);
        all.trimmed |= self.trimmed;
        if all.trimmed && all.patch.strategy == Strategy::Grow {
            if self.strategy.is_some() {
                return Err(Error::Options(
                    "--trimmed needs polygons, which strategy grow does not make: use --strategy zones or matching"
                        .into(),
                ));
            }
            all.patch.strategy = Strategy::Matching;
        }
        // A face that bends or folds weighs wrong.
        if self.is_divided(all) {
            all.patch.faces = true;
            all.patch.feature_angle = all.patch.feature_angle.or(Some(CREASE_ANGLE));
        }
        all.schema = self.schema.unwrap_or(all.schema);
        all.features = self.features.clone().or(all.features.take());
        all.prepare = self.prepare.over(all.prepare);
        all.patch.validate()?;
        all.brep.validate()?;
        Ok(())
    }

    fn work(&self, session: &mut Session, options: &Options) -> Result<(), Error> {
        let mut prepared = session.read_fans(&self.input, &options.prepare)?;
        if self.layout.is_some() && prepared.report.degenerate_faces + prepared.report.folded_faces > 0 {
            // Their neighbours meet across other edges than in the file once they are gone, and what a layout has left over is
            // a face.
            session.warn(
                "the layout names faces of the file, so those without area and those folded onto others are taken as they are there",
            );
            let as_is = PrepareOptions { as_is: true, ..options.prepare };
            prepared = session.prepare(prepared.into_input(), &as_is, Takes::Bodies)?;
        }
        let mesh = &prepared.mesh;
        let context = session.context.clone();
        let mut limits = options.patch.clone();
        if let Some(file) = &options.features {
            limits.feature_edges = edges_of_surface(&prepared, session.load_edges(file)?);
        }
        let seams = if self.layout.is_some() { prepared.seams() } else { Vec::new() };
        if !seams.is_empty() {
            session.warn(format!(
                "the layout names vertices of the file, so that no patch crosses the {} along which faces have others there",
                counted(seams.len(), "edge", "edges")
            ));
            limits.feature_edges.extend(seams);
        }
        if self.is_divided(options) {
            limits.feature_edges.extend(cad::borders(mesh, &context)?);
        }
        // A bicubic face keeps its distance from the vertices, whatever the cells do.
        let is_exact = self.is_divided(options) && options.brep.fit == Fit::Auto;
        let result = context.install(|| match is_exact {
            true => cad::decompose_for_faces(mesh, &limits, &context),
            false => patch::decompose(mesh, &limits, &context),
        })?;
        self.write(session, &prepared, &result, options)?;
        let f = &result.figures;
        session.say(format!(
            "{} patches hold {:.2} % of {} triangles ({} left over)",
            f.patches,
            100.0 * f.coverage,
            mesh.face_count(),
            result.leftover.len()
        ));
        session.say(format!("mean Q {:.2}°, {} cells with a corner above 150°", f.q_mean_deg, f.bad_cells));
        Ok(())
    }
}

impl Patch {
    /// Whether the output is a CAD file whose faces end at bends.
    fn is_divided(&self, options: &Options) -> bool {
        let cad = |file: &PathBuf| CAD_EXTENSIONS.contains(&extension(file).as_str());
        self.output.as_ref().is_some_and(cad) && !options.trimmed && options.brep.fit != Fit::Bilinear
    }

    fn write(
        &self,
        session: &mut Session,
        prepared: &Prepared,
        result: &PatchResult,
        options: &Options,
    ) -> Result<(), Error> {
        let (f, mesh) = (&result.figures, &prepared.mesh);
        session.record.set("patches", f.patches);
        session.record.set("coverage", f.coverage);
        session.record.set("patches_for", &f.patches_for);
        session.record.set("quality", f);
        if let Some(file) = &self.layout {
            let told = layout_of_file(prepared, result);
            let layout = json!({ "patches": told.patches, "leftover": told.leftover });
            session.write_bytes(file, layout.to_string().as_bytes())?;
        }
        let mut quads = quad_mesh(mesh, result);
        session.carry(mesh, &mut quads)?;
        session.draw(&quads)?;
        session.keep(|| Found::Patches(quads.clone(), layout_of_file(prepared, result)));
        session.show_result(self.output.as_deref(), |name, _| Scene::of_mesh(name, &quads))?;
        match &self.output {
            Some(file) if CAD_EXTENSIONS.contains(&extension(file).as_str()) => {
                self.write_cad(session, file, prepared, result, options)
            }
            Some(file) => {
                session.record.set("faces", quads.faces.len());
                session.write_mesh(file, &quads, &WriteOptions::default())
            }
            None => Ok(()),
        }
    }

    fn write_cad(
        &self,
        session: &mut Session,
        file: &Path,
        prepared: &Prepared,
        result: &PatchResult,
        options: &Options,
    ) -> Result<(), Error> {
        let mesh = &prepared.mesh;
        let context = session.context.clone();
        let model = context.install(|| match &result.polygons {
            Some(layout) if options.trimmed => cad::to_trimmed_brep(mesh, &layout.polygons, &layout.leftover, &context),
            _ => cad::to_brep(mesh, &result.patches, &result.leftover, &options.brep, &context),
        })?;
        let name = self.input.file_stem().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
        let cad = CadOptions { unit: session.unit, schema: options.schema, name, ..CadOptions::default() };
        let mut bytes = Vec::new();
        write_cad(file, &model.brep, &cad, &mut bytes)?;
        model.warnings.into_iter().for_each(|w| session.warn(w));
        session.record.set("faces", model.brep.faces.len());
        session.record.set("fit", model.faces);
        session.record.set("mass_error", model.mass_error);
        let cad::Faces { planes, bicubic, bilinear, deviation_max } = model.faces;
        session.say(format!("{planes} plane, {bicubic} bicubic, {bilinear} bilinear faces"));
        if bicubic > 0 {
            session.say(format!("vertices are within {deviation_max:.3e} of bicubic faces"));
        }
        session.write_bytes(file, &bytes)?;
        session.say(format!(
            "{}: {} faces, {} shells, {} solids",
            file.display(),
            model.brep.faces.len(),
            model.brep.shells.len(),
            model.brep.solids.len()
        ));
        Ok(())
    }
}

/// The file's vertices of a patch: each as the triangles of a cell that has it there name it.
fn vertices_of_file(prepared: &Prepared, grid: &patch::Patch) -> Vec<VertexId> {
    let nodes = (0..=grid.rows).flat_map(|r| (0..=grid.cols).map(move |c| (r, c)));
    let name = |(r, c): (u32, u32)| {
        let v = grid.vertex(r, c);
        let cell = grid.cell_triangles(r.min(grid.rows - 1), c.min(grid.cols - 1));
        let own = cell.into_iter().find_map(|t| {
            let at = prepared.mesh.face(t).iter().position(|&corner| corner == v.0)?;
            prepared.corners(t.0).get(at).copied()
        });
        VertexId(own.unwrap_or_else(|| prepared.vertex(v.0)))
    };
    nodes.map(name).collect()
}

/// The layout with the ids of the file. Patches whose triangles were turned are told in the sense of the file; triangles that were
/// left out are left over.
fn layout_of_file(prepared: &Prepared, result: &PatchResult) -> PatchResult {
    let mut told = result.clone();
    if !prepared.is_changed() {
        return told;
    }
    for patch in &mut told.patches {
        let is_turned = patch.triangles.iter().all(|t| prepared.is_turned(t.0));
        patch.vertices = vertices_of_file(prepared, patch);
        patch.triangles.iter_mut().for_each(|t| t.0 = prepared.face(t.0));
        if is_turned {
            *patch = patch.transposed();
        }
    }
    told.leftover.iter_mut().for_each(|t| t.0 = prepared.face(t.0));
    told.leftover.extend(prepared.left_out().into_iter().map(FaceId));
    told.leftover.sort_unstable();
    told
}
