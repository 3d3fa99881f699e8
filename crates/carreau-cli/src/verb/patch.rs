//! `patch`: quad patches on the given vertices, as a mesh or as CAD faces.

use crate::choice::choice;
use crate::common::{Common, CommonValues};
use crate::host::Found;
use crate::outputs::{Content, Outputs};
use crate::replay::options_from;
use crate::session::{Failure, Session};
use carreau::io::ResultKind;
use carreau::io::cad::{CAD_EXTENSIONS, CadOptions, StepSchema, write_cad};
use carreau::io::{WriteOptions, extension};
use carreau::mesh::SurfaceMesh;
use carreau::patch::cad::{self, BrepOptions, Fit, Rung};
use carreau::patch::{self, Dissection, PatchOptions, PatchResult, Policy, Quality, Strategy, quad_mesh};
use carreau::report::page::Scene;
use carreau::{Error, Length};
use clap::Args;
use serde::{Deserialize, Serialize};
use serde_json::json;
use std::path::{Path, PathBuf};

/// Decomposes a triangle mesh into quad patches, on its own vertices
///
/// The output is a mesh (one quad per cell, then the triangles left over) or, by extension, an IGES or STEP file (one
/// B-spline face per patch).
#[derive(Args)]
#[command(after_help = "Examples:\n  \
    carreau patch part.stl -o part.step\n  \
    carreau patch scan.ply -o scan.obj --layout scan.json --picture scan.png\n  \
    carreau patch part.obj -o part.step --fit bicubic --tolerance 0.1%\n  \
    carreau patch scan.obj -o scan.igs --preset paper")]
pub struct Patch {
    /// The triangle mesh; polygons are fanned
    input: PathBuf,
    /// The file to write: a mesh, or .igs .iges .step .stp
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Writes the patches as grids of vertex and triangle ids (JSON)
    #[arg(long, value_name = "FILE.json")]
    layout: Option<PathBuf>,
    /// All options of the paper's pipeline, or the defaults
    #[arg(long, value_name = "PRESET", value_parser = choice::<Preset>(&["default", "paper"]))]
    preset: Option<Preset>,
    /// How patches are found [default: grow]
    #[arg(long, value_name = "STRATEGY", value_parser = choice::<Strategy>(&["grow", "zones", "matching", "matching-cardinality"]))]
    strategy: Option<Strategy>,
    /// What happens where rows and columns contradict each other [default: keep-first]
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
    /// Accepts no quad with a corner above 180 degrees
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
    /// Rectangles tried through each triangle by strategy grow; 0 tries all [default: 16, fewer on large meshes]
    #[arg(long, value_name = "N")]
    probes: Option<u32>,
    /// Strategy grow: rectangles end at sharper creases; merging may join them along complete sides [default: 40]
    #[arg(long, value_name = "DEG")]
    crease_angle: Option<f64>,
    /// Never crosses edges with more than this angle between the faces [default: none; 35 for bicubic faces]
    #[arg(long, value_name = "DEG")]
    feature_angle: Option<f64>,
    /// Never crosses these edges: a file with two vertex ids per line
    #[arg(long, value_name = "FILE")]
    features: Option<PathBuf>,
    /// Crosses edges tagged in the file, too
    #[arg(long)]
    ignore_tags: bool,
    /// CAD faces through every vertex, or bicubic ones within a tolerance, where these are smaller [default: bilinear]
    #[arg(long, value_name = "FIT", value_parser = choice::<Fit>(&["bilinear", "bicubic"]))]
    fit: Option<Fit>,
    /// Largest distance of a vertex from a bicubic face [default: 0.1%]
    #[arg(long, value_name = "LENGTH")]
    tolerance: Option<Length>,
    /// One trimmed CAD face per rectilinear polygon instead of one face per patch; not with strategy grow
    #[arg(long, conflicts_with = "fit")]
    trimmed: bool,
    /// Application protocol of STEP files [default: ap214]
    #[arg(long, value_name = "PROTOCOL", value_parser = choice::<StepSchema>(&["ap214", "ap242"]))]
    schema: Option<StepSchema>,
    #[command(flatten)]
    pub(super) common: Common,
}

/// Creases that bicubic patches do not cross unless told otherwise, in degrees.
const SMOOTH_FEATURE_ANGLE: f64 = 35.0;

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
struct Options {
    #[serde(flatten)]
    patch: PatchOptions,
    features: Option<PathBuf>,
    #[serde(flatten)]
    brep: BrepOptions,
    trimmed: bool,
    schema: StepSchema,
    #[serde(flatten)]
    common: CommonValues,
}

impl Patch {
    /// The files of a run.
    pub fn outputs(&self) -> Outputs {
        let files =
            Outputs::of(&self.common).reads(&self.input, ResultKind::SurfaceOrCad).needs(self.features.as_deref());
        files.writes(self.output.as_deref(), ResultKind::SurfaceOrCad).also(
            "--layout",
            self.layout.as_deref(),
            Content::Json,
        )
    }

    /// Runs the verb.
    pub fn run(&self) -> Result<(), Failure> {
        let options = self.options()?;
        Session::run("patch", &self.common, &options.common, Some(&self.input), |session| {
            session.record.set("options", &options);
            self.patch(session, &options)
        })
    }

    /// Preset, then options file, then flags.
    fn options(&self) -> Result<Options, Error> {
        let preset = match self.preset {
            Some(Preset::Paper) => PatchOptions::paper(),
            _ => PatchOptions::default(),
        };
        let base = Options { patch: preset, ..Options::default() };
        let mut all = options_from(self.common.options.as_deref(), "patch", base)?;
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
        o.feature_angle = self.feature_angle.or(o.feature_angle);
        o.tagged_edges &= !self.ignore_tags;
        all.brep.fit = self.fit.unwrap_or(all.brep.fit);
        all.brep.tolerance = self.tolerance.unwrap_or(all.brep.tolerance);
        all.trimmed |= self.trimmed;
        if all.trimmed && all.patch.strategy == Strategy::Grow {
            if self.strategy.is_some() {
                return Err(Error::Options(
                    "--trimmed needs polygons, which strategy grow has not: take zones or matching".into(),
                ));
            }
            all.patch.strategy = Strategy::Matching;
        }
        // A smooth face cannot follow a crease: it would have to fall back to degree 1.
        if all.brep.fit == Fit::Bicubic && all.patch.feature_angle.is_none() {
            all.patch.feature_angle = Some(SMOOTH_FEATURE_ANGLE);
        }
        all.schema = self.schema.unwrap_or(all.schema);
        all.features = self.features.clone().or(all.features);
        all.common = self.common.over(all.common);
        all.patch.validate()?;
        all.brep.validate()?;
        Ok(all)
    }

    fn patch(&self, session: &mut Session, options: &Options) -> Result<(), Error> {
        let mesh = session.read_fans(&self.input)?;
        let context = session.context.clone();
        let mut limits = options.patch.clone();
        if let Some(file) = &options.features {
            limits.feature_edges = session.load_edges(file)?;
        }
        let result = context.install(|| patch::decompose(&mesh, &limits, &context))?;
        self.write(session, &mesh, &result, options)?;
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

    fn write(
        &self,
        session: &mut Session,
        mesh: &SurfaceMesh,
        result: &PatchResult,
        options: &Options,
    ) -> Result<(), Error> {
        let f = &result.figures;
        session.record.set("patches", f.patches);
        session.record.set("coverage", f.coverage);
        session.record.set("patches_for", &f.patches_for);
        session.record.set("quality", f);
        if let Some(file) = &self.layout {
            let layout = json!({ "patches": result.patches, "leftover": result.leftover });
            session.write_bytes(file, layout.to_string().as_bytes())?;
        }
        let mut quads = quad_mesh(mesh, result);
        session.carry(mesh, &mut quads)?;
        session.draw(&quads)?;
        session.keep(|| Found::Patches(quads.clone(), result.clone()));
        session.show_result(self.output.as_deref(), |name, _| Scene::of_mesh(name, &quads))?;
        match &self.output {
            Some(file) if CAD_EXTENSIONS.contains(&extension(file).as_str()) => {
                self.write_cad(session, file, mesh, result, options)
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
        mesh: &SurfaceMesh,
        result: &PatchResult,
        options: &Options,
    ) -> Result<(), Error> {
        let context = session.context.clone();
        let model = context.install(|| match &result.polygons {
            Some(layout) if options.trimmed => cad::to_trimmed_brep(mesh, &layout.polygons, &layout.leftover, &context),
            _ => cad::to_brep(mesh, &result.patches, &result.leftover, &options.brep, &context),
        })?;
        let name = self.input.file_stem().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
        let cad = CadOptions { unit: options.common.unit, schema: options.schema, name, ..CadOptions::default() };
        let mut bytes = Vec::new();
        write_cad(file, &model.brep, &cad, &mut bytes)?;
        model.warnings.into_iter().for_each(|w| session.warn(w));
        session.record.set("faces", model.brep.faces.len());
        if options.brep.fit == Fit::Bicubic {
            let on = |rung: Rung| model.fits.iter().filter(|f| f.rung == rung).count();
            let (bicubic, planes) = (on(Rung::Bicubic), on(Rung::Plane));
            let worst = model.fits.iter().map(|f| f.deviation).fold(0.0, f64::max);
            let count = model.fits.len();
            session.say(format!("{bicubic} of {count} patches are bicubic, {planes} plane, within {worst:.3e}"));
            let fit = json!({ "bicubic": bicubic, "planes": planes, "deviation_max": worst, "patches": model.fits });
            session.record.set("fit", fit);
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
