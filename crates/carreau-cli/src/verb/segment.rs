//! `segment`: the faces of a part, with clean borders, and the surface of each.

use super::contract::Verb;
use crate::choice::choice;
use crate::common::{Common, positive_length};
use crate::host::Found;
use crate::labels::read_labels;
use crate::outputs::Outputs;
use crate::prepare::PrepareFlags;
use crate::session::Session;
use carreau::geometry::curvature::Estimator;
use carreau::geometry::primitive::Primitive;
use carreau::io::{ResultKind, WriteOptions, extension};
use carreau::mesh::{Column, PrepareOptions, Prepared, RawMesh, SurfaceMesh, VertexId};
use carreau::report::page::Scene;
use carreau::segment::{self, Basis, Rectify, Region, Scale, SegmentOptions, Segmentation};
use carreau::{Error, Length};
use clap::Args;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Finds the faces of a part, and the surface that each lies on
///
/// Writes the same triangles with the face properties region (0 is the largest), primitive (0 plane, 1 sphere, 2 cylinder,
/// 3 cone, 4 torus, 5 freeform) and fit_error (largest distance of the region's vertices from its surface). Parameters of
/// the surfaces and the boundary lines are in the record (--json).
#[derive(Args)]
#[command(after_help = "Examples:\n  \
    carreau segment part.stl -o part.ply --json part.json --picture part.png\n  \
    carreau segment scan.ply -o scan.vtu --merge-threshold 3\n  \
    carreau segment part.ply -o clean.ply --labels face_id\n  \
    carreau segment fandisk.obj -o fandisk.ply --preset paper --clusters 18")]
pub struct Segment {
    /// The mesh; polygons are cut into fans of triangles
    input: PathBuf,
    /// The file to write; PLY, VTU, VTP and VTK keep the properties, OBJ gets a group per region
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Takes all options from the paper's pipeline, or the defaults
    #[arg(long, value_name = "PRESET", value_parser = choice::<Preset>(&["default", "paper"]))]
    preset: Option<Preset>,
    /// Recognises planes, spheres, cylinders, cones and tori before it uses curvature [default: true]
    #[arg(long, value_name = "BOOL", num_args = 0..=1, default_missing_value = "true")]
    surfaces: Option<bool>,
    /// Number of clusters of curvature [default: from the data]
    #[arg(long, value_name = "K")]
    clusters: Option<u32>,
    /// Merges regions up to this distance from each other, in the paper's measure [default: auto]
    #[arg(long, value_name = "N|auto", value_parser = threshold)]
    merge_threshold: Option<Threshold>,
    /// Merges regions of near-constant curvature down to this number
    #[arg(long, value_name = "N", conflicts_with = "merge_threshold")]
    regions: Option<u32>,
    /// How boundaries are corrected [default: cut]
    #[arg(long, value_name = "METHOD", value_parser = choice::<Rectify>(&["paper", "cut", "none"]))]
    rectify: Option<Rectify>,
    /// Starts from labels: a face property of the input, or a file with one integer per triangle
    #[arg(long, value_name = "FILE|PROPERTY")]
    labels: Option<String>,
    /// Angle from which edges are sharp, in degrees [default: from the data, near 25]
    #[arg(long, value_name = "DEG")]
    sharp_angle: Option<f64>,
    /// Score below which boundary edges count as correct, for --rectify paper [default: 0.2]
    #[arg(long, value_name = "S")]
    score_threshold: Option<f64>,
    /// How curvatures are estimated [default: corrected]
    #[arg(long, value_name = "ESTIMATOR", value_parser = choice::<Estimator>(&["corrected", "normal-cycle-1ring", "normal-cycle-ball", "mepp"]))]
    estimator: Option<Estimator>,
    /// Radius of estimator normal-cycle-ball [default: three mean edge lengths]
    #[arg(long, value_name = "LENGTH")]
    radius: Option<Length>,
    /// The length that curvatures are multiplied by [default: root-area; preset paper: largest-side]
    #[arg(long, value_name = "LENGTH", value_parser = choice::<Scale>(&["largest-side", "root-area"]))]
    scale: Option<Scale>,
    /// Area below which regions are merged first, as a share of the whole [default: 0.001]
    #[arg(long, value_name = "SHARE")]
    min_area: Option<f64>,
    /// Largest distance of a region's vertices from its surface [default: 0.003%]
    #[arg(long, value_name = "LENGTH")]
    tolerance: Option<Length>,
    #[command(flatten)]
    prepare: PrepareFlags,
    #[command(flatten)]
    common: Common,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Preset {
    #[default]
    Default,
    Paper,
}

/// A number, or from the data.
#[derive(Debug, Clone, Copy)]
struct Threshold(Option<f64>);

fn threshold(text: &str) -> Result<Threshold, String> {
    match text {
        "auto" => Ok(Threshold(None)),
        _ => text.parse().map(|x| Threshold(Some(x))).map_err(|_| format!("'{text}' is neither a number nor auto")),
    }
}

/// What replays a run.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct Options {
    #[serde(flatten)]
    segment: SegmentOptions,
    labels: Option<String>,
    radius: Option<Length>,
    tolerance: Option<Length>,
    #[serde(flatten)]
    prepare: PrepareOptions,
}

impl Verb for Segment {
    const NAME: &'static str = "segment";
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
        let labels = self.labels.as_deref().map(Path::new).filter(|file| file.is_file());
        let files = Outputs::of(&self.common).reads(&self.input, ResultKind::Surface).needs(labels);
        files.writes(self.output.as_deref(), ResultKind::Surface)
    }

    fn defaults(&self) -> Options {
        let preset = match self.preset {
            Some(Preset::Paper) => SegmentOptions::paper(),
            _ => SegmentOptions::default(),
        };
        Options { segment: preset, ..Options::default() }
    }

    fn lay_over(&self, all: &mut Options) -> Result<(), Error> {
        let o = &mut all.segment;
        o.surfaces = self.surfaces.unwrap_or(o.surfaces);
        o.clusters = self.clusters.or(o.clusters);
        o.merge_threshold = self.merge_threshold.map_or(o.merge_threshold, |t| t.0);
        o.regions = self.regions.or(o.regions);
        // Who asks for a number of regions, or for clusters and thresholds, asks for regions of near-constant curvature.
        if self.surfaces.is_none() && (self.regions.is_some() || self.clusters.is_some()) {
            o.surfaces = false;
        }
        if self.surfaces.is_none() && self.merge_threshold.is_some_and(|t| t.0.is_some()) {
            o.surfaces = false;
        }
        o.rectify = self.rectify.unwrap_or(o.rectify);
        o.sharp_angle = self.sharp_angle.or(o.sharp_angle);
        o.score_threshold = self.score_threshold.unwrap_or(o.score_threshold);
        o.estimator = self.estimator.unwrap_or(o.estimator);
        o.scale = self.scale.unwrap_or(o.scale);
        o.min_area = self.min_area.unwrap_or(o.min_area);
        all.labels = self.labels.clone().or(all.labels.take());
        all.radius = self.radius.or(all.radius);
        all.tolerance = self.tolerance.or(all.tolerance);
        all.prepare = self.prepare.over(all.prepare);
        positive_length("radius", all.radius)?;
        positive_length("tolerance", all.tolerance)?;
        all.segment.validate()?;
        Ok(())
    }

    fn work(&self, session: &mut Session, options: &Options) -> Result<(), Error> {
        let prepared = session.read_fans(&self.input, &options.prepare)?;
        let mesh = &prepared.mesh;
        let context = session.context.clone();
        let mut wanted = options.segment.clone();
        wanted.radius = options.radius.map(|r| r.resolve(mesh.diagonal()));
        wanted.tolerance = options.tolerance.map(|t| t.resolve(mesh.diagonal()));
        wanted.labels = options.labels.as_deref().map(|labels| read_labels(&prepared, labels)).transpose()?;
        let result = of_file(&prepared, context.install(|| segment::segment(mesh, &wanted, &context))?);
        tell(session, &result);
        for name in ["region", "primitive", "fit_error"].into_iter().filter(|n| mesh.attributes.face.contains_key(*n)) {
            session
                .warn(format!("the method: the face property '{name}' of the input is replaced by that of the result"));
        }
        let mut out = labelled(prepared.into_input(), &result);
        session.draw(&out)?;
        session.keep(|| Found::Mesh(out.clone()));
        session.show_result(self.output.as_deref(), |name, context| {
            Scene::of_mesh(name, &worded(&out, &result))?.show("region").with_curvature(context)
        })?;
        if let Some(file) = &self.output {
            if extension(file) == "obj" {
                if out.attributes.face.contains_key("group") {
                    session.warn("the method: the face property 'group' of the input is replaced by the regions, which are groups in OBJ files");
                }
                group(&mut out, &result);
            }
            session.write_mesh(file, &out, &WriteOptions::default())?;
            let counts =
                json!({ "file": file.to_string_lossy(), "vertices": out.points.len(), "faces": out.faces.len() });
            session.record.set("output", counts);
        }
        Ok(())
    }
}

/// The regions with the ids of the file.
fn of_file(prepared: &Prepared, mut found: Segmentation) -> Segmentation {
    if !prepared.is_changed() {
        return found;
    }
    found.labels = prepared.labels_of_faces(&found.labels);
    found.regions.iter_mut().for_each(|region| region.triangles = 0);
    found.labels.iter().for_each(|&l| found.regions[l as usize].triangles += 1);
    let on_lines = found.boundaries.iter_mut().flat_map(|b| &mut b.vertices);
    let vertices = on_lines.chain(found.junctions.iter_mut().map(|j| &mut j.vertex));
    vertices.for_each(|v| *v = VertexId(prepared.vertex(v.0)));
    found
}

/// The mesh with its regions.
pub fn labelled(mut mesh: SurfaceMesh, result: &Segmentation) -> RawMesh {
    let of = |value: &dyn Fn(&Region) -> i32| {
        Column::Label(result.labels.iter().map(|&l| value(&result.regions[l as usize])).collect())
    };
    let kind = of(&|r: &Region| r.primitive.map_or(5, |p| p.kind() as i32));
    let error = Column::Scalar(result.labels.iter().map(|&l| result.regions[l as usize].max).collect());
    let region = Column::Label(result.labels.iter().map(|&l| l as i32).collect());
    let face = &mut mesh.attributes.face;
    face.extend([("region".into(), region), ("primitive".into(), kind), ("fit_error".into(), error)]);
    RawMesh::from(mesh)
}

/// The mesh with words for its regions and their kinds, for pages.
pub fn worded(out: &RawMesh, result: &Segmentation) -> RawMesh {
    let mut out = out.clone();
    let kinds = ["plane", "sphere", "cylinder", "cone", "torus", "freeform"];
    let mut word = |column: &str, label: i32, word: String| out.attributes.names.insert((column.into(), label), word);
    for (label, kind) in (0..).zip(kinds) {
        word("primitive", label, kind.into());
    }
    for (label, region) in (0..).zip(&result.regions) {
        word("region", label, described(region));
    }
    out
}

/// A region's surface in a few words.
fn described(region: &Region) -> String {
    let measures = match region.primitive {
        Some(Primitive::Cylinder { radius, .. } | Primitive::Sphere { radius, .. }) => {
            format!(", radius {}", rounded(radius))
        }
        Some(Primitive::Cone { half_angle, .. }) => format!(", half angle {}°", rounded(half_angle.to_degrees())),
        Some(Primitive::Torus { major_radius, minor_radius, .. }) => {
            format!(", radii {} and {}", rounded(major_radius), rounded(minor_radius))
        }
        _ => String::new(),
    };
    format!("{}{measures}", kind(region))
}

/// A number to six digits.
fn rounded(x: f64) -> f64 {
    format!("{x:.5e}").parse().unwrap_or(x)
}

/// Regions as named groups, for OBJ, which knows no face properties.
fn group(out: &mut RawMesh, result: &Segmentation) {
    let labels = result.labels.iter().map(|&l| l as i32).collect();
    out.attributes.face.insert("group".into(), Column::Label(labels));
    out.attributes.names.retain(|(column, _), _| column != "group");
    for (l, region) in result.regions.iter().enumerate() {
        let name = format!("region_{l}_{}", kind(region));
        out.attributes.names.insert(("group".into(), l as i32), name);
    }
}

/// The name of the kind of surface.
fn kind(region: &Region) -> &'static str {
    region.primitive.map_or("freeform", |p| p.kind().name())
}

/// The record and the summary.
fn tell(session: &mut Session, result: &Segmentation) {
    let regions: Vec<Value> = result
        .regions
        .iter()
        .enumerate()
        .map(|(id, r)| {
            json!({
                "id": id, "triangles": r.triangles, "area": r.area, "kmin": r.kmin, "kmax": r.kmax,
                "primitive": primitive(r), "neighbours": r.neighbours,
            })
        })
        .collect();
    let boundaries: Vec<Value> = result
        .boundaries
        .iter()
        .map(|b| {
            let vertices: Vec<u32> = b.vertices.iter().map(|v| v.0).collect();
            json!({ "regions": [b.regions.0, b.regions.1], "vertices": vertices, "closed": b.closed, "sharp": b.sharp })
        })
        .collect();
    let junctions: Vec<Value> = result
        .junctions
        .iter()
        .map(|j| {
            let p = j.position;
            json!({ "vertex": j.vertex.0, "regions": j.regions, "position": [p.x, p.y, p.z], "distance": j.distance })
        })
        .collect();
    let count = |name: &str| regions.iter().filter(|r| r["primitive"]["type"] == name).count();
    let kinds: Vec<String> = ["plane", "cylinder", "cone", "sphere", "torus", "freeform"]
        .into_iter()
        .map(|name| (count(name), name))
        .filter(|(n, _)| *n > 0)
        .map(|(n, name)| format!("{n} {name}"))
        .collect();
    let chosen = &result.chosen;
    session.say(format!("{} regions: {}", regions.len(), kinds.join(", ")));
    session.say(match chosen.basis {
        Basis::Surfaces => format!(
            "{:.1} % of the area lies on recognised surfaces; sharp edges from {:.1}° on",
            100.0 * chosen.recognised,
            chosen.sharp_angle_deg
        ),
        Basis::Curvature => format!(
            "near-constant curvature: {} clusters, merged up to {:.3}; sharp edges from {:.1}° on",
            chosen.clusters, chosen.merge_threshold, chosen.sharp_angle_deg
        ),
        Basis::Labels => format!("given labels; rectification moved {} triangles", chosen.rectified),
    });
    session.record.set("chosen", chosen);
    session.record.set("dendrogram", &result.dendrogram);
    session.record.set("boundaries", boundaries);
    session.record.set("junctions", junctions);
    session.record.set("regions", regions);
}

fn primitive(region: &Region) -> Value {
    let v = |p: carreau::DVec3| json!([p.x, p.y, p.z]);
    let mut out = match region.primitive {
        None => json!({}),
        Some(Primitive::Plane { origin, normal }) => json!({ "origin": v(origin), "normal": v(normal) }),
        Some(Primitive::Cylinder { origin, axis, radius }) => {
            json!({ "origin": v(origin), "axis": v(axis), "radius": radius })
        }
        Some(Primitive::Cone { apex, axis, half_angle }) => {
            json!({ "apex": v(apex), "axis": v(axis), "half_angle_deg": half_angle.to_degrees() })
        }
        Some(Primitive::Sphere { center, radius }) => json!({ "center": v(center), "radius": radius }),
        Some(Primitive::Torus { center, axis, major_radius, minor_radius }) => json!({
            "center": v(center), "axis": v(axis), "major_radius": major_radius, "minor_radius": minor_radius,
        }),
    };
    out["type"] = json!(kind(region));
    out["rms"] = json!(region.rms);
    out["max"] = json!(region.max);
    out
}
