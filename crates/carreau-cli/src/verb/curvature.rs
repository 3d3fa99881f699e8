//! `curvature`: principal curvatures and directions at every vertex.

use super::contract::Verb;
use crate::choice::choice;
use crate::common::{Common, positive_length};
use crate::host::Found as Handed;
use crate::outputs::Outputs;
use crate::prepare::PrepareFlags;
use crate::session::Session;
use carreau::bounds::angle;
use carreau::geometry::curvature::{Curvature as Found, CurvatureOptions, Estimator, curvature};
use carreau::geometry::features::{FeatureOptions, feature_edges};
use carreau::geometry::summary::Summary;
use carreau::io::{ResultKind, WriteOptions};
use carreau::mesh::{Column, PrepareOptions, RawMesh, SurfaceMesh, Triangles};
use carreau::report::curvature_figure;
use carreau::report::page::Scene;
use carreau::{DVec3, Error, Length};
use clap::Args;
use serde::{Deserialize, Serialize};
use serde_json::json;
use std::path::{Path, PathBuf};

/// Measures principal curvatures and directions at every vertex
///
/// Writes the mesh with the vertex properties kmin, kmax (1/length, kmin <= kmax, positive where a surface oriented
/// outwards is convex) and dmin, dmax (unit vectors; in PLY files dmin_x, dmin_y, dmin_z and so on). Nothing is measured
/// across features: sharp edges, borders, edges tagged in the file.
#[derive(Args)]
#[command(after_help = "Examples:\n  \
    carreau curvature part.stl -o part.ply\n  \
    carreau curvature scan.ply -o scan.vtu --estimator normal-cycle-ball --radius 1%\n  \
    carreau curvature part.obj --json - | jq .quality.kmax")]
pub struct Curvature {
    /// The mesh; polygons are cut into fans of triangles
    input: PathBuf,
    /// The file to write; PLY, VTU, VTP and VTK keep the properties
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// How curvatures are estimated [default: corrected]
    #[arg(long, value_name = "ESTIMATOR", value_parser = choice::<Estimator>(&["corrected", "normal-cycle-1ring", "normal-cycle-ball", "mepp"]))]
    estimator: Option<Estimator>,
    /// Radius of estimator normal-cycle-ball [default: three mean edge lengths]
    #[arg(long, value_name = "LENGTH")]
    radius: Option<Length>,
    /// Edges with a larger angle between their faces are features, in degrees; 180: none is sharp [default: 25]
    #[arg(long, value_name = "DEG")]
    feature_angle: Option<f64>,
    #[command(flatten)]
    prepare: PrepareFlags,
    #[command(flatten)]
    common: Common,
}

/// What replays a run.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(default)]
pub struct Options {
    estimator: Estimator,
    radius: Option<Length>,
    feature_angle: f64,
    #[serde(flatten)]
    prepare: PrepareOptions,
}

impl Default for Options {
    fn default() -> Self {
        Options {
            estimator: Estimator::default(),
            radius: None,
            feature_angle: 25.0,
            prepare: PrepareOptions::default(),
        }
    }
}

impl Verb for Curvature {
    const NAME: &'static str = "curvature";
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
        Outputs::of(&self.common)
            .reads(&self.input, ResultKind::Surface)
            .writes(self.output.as_deref(), ResultKind::Surface)
    }

    fn defaults(&self) -> Options {
        Options::default()
    }

    fn lay_over(&self, all: &mut Options) -> Result<(), Error> {
        all.estimator = self.estimator.unwrap_or(all.estimator);
        all.radius = self.radius.or(all.radius);
        all.feature_angle = self.feature_angle.unwrap_or(all.feature_angle);
        all.prepare = self.prepare.over(all.prepare);
        if all.radius.is_some() && all.estimator != Estimator::NormalCycleBall {
            return Err(Error::Options(
                "--radius needs --estimator normal-cycle-ball; the other estimators have no radius".into(),
            ));
        }
        angle("feature-angle", all.feature_angle)?;
        positive_length("radius", all.radius)?;
        Ok(())
    }

    fn work(&self, session: &mut Session, options: &Options) -> Result<(), Error> {
        let prepared = session.read_surface(&self.input, &options.prepare)?.triangulated()?;
        let found = compute(session, &prepared.mesh, options)?;
        describe(session, &prepared.mesh, &found);
        // Vertices that no face is left at have no curvature.
        let found = Found {
            kmin: prepared.values_of_vertices(found.kmin, 0.0),
            kmax: prepared.values_of_vertices(found.kmax, 0.0),
            dmin: prepared.values_of_vertices(found.dmin, DVec3::ZERO),
            dmax: prepared.values_of_vertices(found.dmax, DVec3::ZERO),
            border: prepared.values_of_vertices(found.border, false),
            area: prepared.values_of_vertices(found.area, 0.0),
        };
        let mut out = RawMesh::from(prepared.into_input().triangulated()?);
        session.draw_as(|| curvature_figure(&out, &found.kmax))?;
        let vectors = |v: Vec<DVec3>| Column::Vector3(v.into_iter().map(|d| d.to_array()).collect());
        let columns = [
            ("kmin", Column::Scalar(found.kmin)),
            ("kmax", Column::Scalar(found.kmax)),
            ("dmin", vectors(found.dmin)),
            ("dmax", vectors(found.dmax)),
        ];
        out.attributes.vertex.extend(columns.map(|(name, column)| (name.to_string(), column)));
        session.show_result(self.output.as_deref(), |name, _| Ok(Scene::of_mesh(name, &out)?.show("kmax")))?;
        if let Some(file) = &self.output {
            session.write_mesh(file, &out, &WriteOptions::default())?;
            let counts =
                json!({ "file": file.to_string_lossy(), "vertices": out.points.len(), "faces": out.faces.len() });
            session.record.set("output", counts);
        }
        session.keep(|| Handed::Mesh(out));
        Ok(())
    }
}

fn compute(session: &mut Session, mesh: &SurfaceMesh, options: &Options) -> Result<Found, Error> {
    let context = session.context.clone();
    let wanted =
        CurvatureOptions { estimator: options.estimator, radius: options.radius.map(|r| r.resolve(mesh.diagonal())) };
    let limits = FeatureOptions { angle_deg: Some(options.feature_angle), ..FeatureOptions::default() };
    let (found, missing) = context.install(|| {
        let features = {
            let _stage = context.stage("features");
            feature_edges(mesh, &limits)?
        };
        let _stage = context.stage("curvature");
        let triangles = Triangles::of(mesh).ok_or_else(|| Error::Bug("a face is no triangle".into()))?;
        Ok::<_, Error>((curvature(triangles, &features.corners, &wanted, &context)?, features.missing.len()))
    })?;
    if missing > 0 {
        session.warn(format!("{missing} edges tagged in the file do not exist in the mesh"));
    }
    Ok(found)
}

/// The record's figures, the summary, and warnings about vertices that are measured badly or not at all.
fn describe(session: &mut Session, mesh: &SurfaceMesh, found: &Found) {
    let mut used = vec![false; mesh.vertex_count()];
    mesh.faces().corners().iter().for_each(|&v| used[v as usize] = true);
    let count = |marks: &[bool], mark: bool| marks.iter().filter(|&&m| m == mark).count();
    let (border, isolated) = (count(&found.border, true), count(&used, false));
    if border > 0 {
        session.warn(format!("{border} vertices lie on a border or an irregular edge: measured on one side only"));
    }
    if isolated > 0 {
        session.warn(format!("{isolated} vertices have no face: their curvatures are written as zero"));
    }
    let of_used = |k: &[f64]| Summary::of(k.iter().zip(&used).filter(|&(_, &u)| u).map(|(&k, _)| k).collect());
    let (kmin, kmax) = (of_used(&found.kmin), of_used(&found.kmax));
    for (name, summary) in [("kmin", &kmin), ("kmax", &kmax)] {
        if let Some(s) = summary {
            let range = format!("5 % {:.4e}, median {:.4e}, 95 % {:.4e}", s.p05, s.p50, s.p95);
            session.say(format!("{name}: {range} (from {:.4e} to {:.4e})", s.min, s.max));
        }
    }
    session.record.set("quality", json!({ "kmin": kmin, "kmax": kmax }));
    session.record.set("border_vertices", border);
}
