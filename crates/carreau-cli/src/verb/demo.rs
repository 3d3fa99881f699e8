//! `demo`: the methods on built-in models, in a folder with an index.

use crate::common::{Common, CommonValues};
use crate::session::{Failure, Session};
use carreau::io::cad::{CadOptions, write_cad};
use carreau::io::{self, WriteOptions};
use carreau::mesh::RawMesh;
use carreau::patch::cad::{BrepOptions, to_brep};
use carreau::patch::{PatchOptions, decompose, quad_mesh};
use carreau::report::figure;
use carreau::{Error, sample};
use clap::Args;
use serde_json::json;
use std::path::{Path, PathBuf};

/// The models that are shown.
const MODELS: &[&str] = &["cube-cylinders", "bracket", "rounded-box", "torus", "tube-tree"];

/// Makes built-in models, runs the methods on them and writes a folder with index.html
#[derive(Args)]
#[command(after_help = "Example:\n  carreau demo -o shown")]
pub struct Demo {
    /// The folder to write
    #[arg(short, long, value_name = "DIR", default_value = "carreau-demo")]
    output: PathBuf,
    #[command(flatten)]
    common: Common,
}

/// One line of the index.
struct Row {
    name: &'static str,
    summary: &'static str,
    triangles: usize,
    patches: usize,
    coverage: f64,
    faces: usize,
    solids: usize,
}

impl Demo {
    /// Runs the verb.
    pub fn run(&self) -> Result<(), Failure> {
        let values = self.common.over(CommonValues::default());
        Session::run("demo", &self.common, &values, None, |session| {
            session.record.set("options", &values);
            std::fs::create_dir_all(&self.output).map_err(|e| Error::write(&self.output, e))?;
            let context = session.context.clone();
            let rows = context
                .install(|| MODELS.iter().map(|name| self.show(session, name)).collect::<Result<Vec<_>, _>>())?;
            let index = self.output.join("index.html");
            session.write_bytes(&index, page(&rows).as_bytes())?;
            let models: Vec<_> = rows
                .iter()
                .map(|r| json!({ "model": r.name, "patches": r.patches, "coverage": r.coverage, "faces": r.faces }))
                .collect();
            session.record.set("output", json!({ "index": index.to_string_lossy(), "models": models }));
            session.say(format!("open {}", index.display()));
            Ok(())
        })
    }

    /// One model: triangles, patches, CAD file, picture.
    fn show(&self, session: &mut Session, name: &'static str) -> Result<Row, Error> {
        let context = session.context.clone();
        let file = |end: &str| self.output.join(format!("{name}{end}"));
        let summary = sample::find(name)?.summary;
        let mesh = sample::make(name, None, &context)?;
        let result = decompose(&mesh, &PatchOptions::default(), &context)?;
        let model = to_brep(&mesh, &result.patches, &result.leftover, &BrepOptions::default(), &context)?;
        let quads = quad_mesh(&mesh, &result);
        let mut step = Vec::new();
        let cad = CadOptions { name: name.into(), ..CadOptions::default() };
        write_cad(Path::new("model.step"), &model.brep, &cad, &mut step)?;
        session.write_bytes(&file(".step"), &step)?;
        session.write_bytes(&file(".png"), &figure(&quads).to_png()?)?;
        session.write_mesh(&file("-patches.ply"), &quads, &WriteOptions::default())?;
        let row = Row {
            name,
            summary,
            triangles: mesh.face_count(),
            patches: result.patches.len(),
            coverage: result.figures.coverage,
            faces: model.brep.faces.len(),
            solids: model.brep.solids.len(),
        };
        io::write(&file(".ply"), &RawMesh::from(mesh), &WriteOptions::default())?;
        session.say(format!(
            "{name}: {} triangles, {} patches hold {:.2} %, {} CAD faces",
            row.triangles,
            row.patches,
            100.0 * row.coverage,
            row.faces
        ));
        Ok(row)
    }
}

/// The index: one figure per model, with its files.
fn page(rows: &[Row]) -> String {
    let figures: String = rows
        .iter()
        .map(|r| {
            format!(
                "<figure><a href=\"{n}.png\"><img src=\"{n}.png\" alt=\"Quad patches of {n}\"></a><figcaption><h2>{n}</h2>\
                 <p>{s}</p><p>{t} triangles → {p} patches hold {c:.2} %; {f} CAD faces, {k} solid{plural}</p>\
                 <p><a href=\"{n}.ply\">triangles</a> · <a href=\"{n}-patches.ply\">patches</a> · <a href=\"{n}.step\">STEP</a></p>\
                 </figcaption></figure>\n",
                n = r.name,
                s = r.summary,
                t = r.triangles,
                p = r.patches,
                c = 100.0 * r.coverage,
                f = r.faces,
                k = r.solids,
                plural = if r.solids == 1 { "" } else { "s" },
            )
        })
        .collect();
    format!(
        "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width\">\
         <title>carreau demo</title><style>\
         body{{font:16px/1.5 system-ui,sans-serif;margin:2rem auto;max-width:72rem;padding:0 1rem;color:#1b2230;background:#fff}}\
         main{{display:grid;grid-template-columns:repeat(auto-fill,minmax(20rem,1fr));gap:2rem}}\
         figure{{margin:0}}img{{width:100%;border:1px solid #d5dae3;border-radius:6px}}h2{{margin:.5rem 0 0;font-size:1.1rem}}\
         p{{margin:.2rem 0}}@media(prefers-color-scheme:dark){{body{{background:#14181f;color:#dfe5ee}}a{{color:#8ab4f8}}}}\
         </style><h1>carreau: quad patches</h1>\
         <p>Triangles in, grids of quads on the same vertices out; each patch is one B-spline face of the STEP file.</p>\
         <main>\n{figures}</main></html>\n"
    )
}
