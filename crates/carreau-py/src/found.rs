//! Calls of verbs, and what they hand back.

use crate::mesh::Mesh;
use crate::net::Net;
use crate::{raise, run, views};
use carreau::Error;
use carreau::field::Field;
use carreau::hex::HexResult;
use carreau::mesh::{RawMesh, VertexId};
use carreau::patch::PatchResult;
use carreau::quad::MotorcycleGraph;
use carreau::report::page::{Page, Role, Scene};
use carreau::report::{field_figure, figure, graph_figure, hex_figure, skeleton_figure};
use carreau::skeleton::Skeleton;
use carreau_cli::host::{self, Host, Input, Outcome, Value};
use numpy::PyReadonlyArray2;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

/// Bytes of the longest part of a record that a page shows.
const LONGEST: usize = 4000;

/// What a verb made, besides its mesh.
enum Kind {
    None,
    Mesh,
    Patches(PatchResult),
    Field(Box<Field>),
    Graph(Box<MotorcycleGraph>),
    Skeleton(Box<Skeleton>),
    Hexes(Box<HexResult>),
}

/// The result of a verb.
#[pyclass(frozen, module = "carreau._core")]
pub struct Found {
    kind: Kind,
    mesh: Option<Arc<RawMesh>>,
    /// The result record (JSON).
    #[pyo3(get)]
    record: String,
    /// What the command line would print.
    #[pyo3(get)]
    summary: Vec<String>,
}

impl From<Outcome> for Found {
    fn from(outcome: Outcome) -> Self {
        let (kind, mesh) = match outcome.found {
            None => (Kind::None, None),
            Some(host::Found::Mesh(mesh)) => (Kind::Mesh, Some(mesh)),
            Some(host::Found::Patches(mesh, layout)) => (Kind::Patches(layout), Some(mesh)),
            Some(host::Found::Field(mesh, field)) => (Kind::Field(Box::new(field)), Some(mesh)),
            Some(host::Found::Graph(mesh, graph)) => (Kind::Graph(Box::new(graph)), Some(mesh)),
            Some(host::Found::Skeleton(skeleton)) => (Kind::Skeleton(Box::new(skeleton)), None),
            Some(host::Found::Hexes(hexes)) => {
                let mesh = hexes.raw();
                (Kind::Hexes(Box::new(hexes)), Some(mesh))
            }
        };
        Found { kind, mesh: mesh.map(Arc::new), record: outcome.record, summary: outcome.summary }
    }
}

#[pymethods]
impl Found {
    /// The mesh that the command line would write.
    #[getter]
    fn mesh(&self) -> Option<Mesh> {
        self.mesh.as_ref().map(|mesh| Mesh(Arc::clone(mesh)))
    }

    /// The skeleton that was found, or that was meshed.
    #[getter]
    fn net(&self) -> Option<Net> {
        match &self.kind {
            Kind::Skeleton(found) => Some(Net(Arc::new(found.net.clone()))),
            Kind::Hexes(found) => Some(Net(Arc::new(found.skeleton.clone()))),
            _ => None,
        }
    }

    /// The arrays that only this kind of result has, by name.
    #[getter]
    fn arrays<'py>(this: &Bound<'py, Self>) -> PyResult<Bound<'py, PyDict>> {
        let py = this.py();
        let all = PyDict::new(py);
        match &this.get().kind {
            Kind::Patches(found) => {
                let shapes = found.patches.iter().flat_map(|p| [p.rows, p.cols]).collect();
                let vertices = found.patches.iter().flat_map(|p| p.vertices.iter().map(|v| v.0)).collect();
                let triangles = found.patches.iter().flat_map(|p| p.triangles.iter().map(|t| t.0)).collect();
                all.set_item("shapes", views::owned_table(py, shapes, 2)?)?;
                all.set_item("vertices", views::owned_list(py, vertices)?)?;
                all.set_item("triangles", views::owned_list(py, triangles)?)?;
                all.set_item("leftover", views::owned_list(py, found.leftover.iter().map(|t| t.0).collect())?)?;
            }
            Kind::Field(found) => {
                let owner = this.as_any();
                all.set_item("u", views::points(owner, &found.u)?)?;
                all.set_item("v", views::points(owner, &found.v)?)?;
                all.set_item("source", views::list(owner, &found.source))?;
                all.set_item("features", views::table(owner, found.features.as_flattened(), 2)?)?;
                let pairs = found.matchings.iter().flat_map(|m| m.triangles).collect();
                all.set_item("pairs", views::owned_table(py, pairs, 2)?)?;
                // A turn p is told modulo 4.
                let turns = found.matchings.iter().map(|m| m.p.rem_euclid(4) as u32).collect();
                all.set_item("turns", views::owned_list(py, turns)?)?;
                let singular = || found.corners.iter().filter(|c| c.is_singular());
                all.set_item("singular_vertices", views::owned_list(py, singular().map(|c| c.vertex).collect())?)?;
                let quads = singular().map(|c| c.quads.max(0) as u32).collect();
                all.set_item("singular_quads", views::owned_list(py, quads)?)?;
            }
            Kind::Skeleton(found) => {
                all.set_item("preimage", views::list(this.as_any(), &found.preimage))?;
            }
            Kind::Graph(found) => {
                let sizes = found.tracks.iter().map(|t| t.vertices.len() as u32).collect();
                let vertices = found.tracks.iter().flat_map(|t| t.vertices.iter().copied()).collect();
                all.set_item("track_sizes", views::owned_list(py, sizes)?)?;
                all.set_item("track_vertices", views::owned_list(py, vertices)?)?;
                let ends = found.tracks.iter().flat_map(|t| t.nodes).collect();
                all.set_item("track_nodes", views::owned_table(py, ends, 2)?)?;
                all.set_item("nodes", views::owned_list(py, found.nodes.iter().map(|n| n.vertex).collect())?)?;
                let corners = found.patches.iter().map(|p| p.corners as u32).collect();
                all.set_item("corners", views::owned_list(py, corners)?)?;
                let inner = || found.starts.iter().filter(|s| s.inner);
                all.set_item("singular_vertices", views::owned_list(py, inner().map(|s| s.vertex).collect())?)?;
                all.set_item("singular_quads", views::owned_list(py, inner().map(|s| s.quads).collect())?)?;
            }
            Kind::None | Kind::Mesh | Kind::Hexes(_) => {}
        }
        Ok(all)
    }

    /// The layout file (JSON) of patches and fields.
    fn layout<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyBytes>>> {
        let bytes = run::beside(py, None, |_, _| {
            Ok(match &self.kind {
                Kind::Patches(found) => {
                    let layout = serde_json::json!({ "patches": found.patches, "leftover": found.leftover });
                    Some(layout.to_string().into_bytes())
                }
                Kind::Field(found) => Some(found.layout()),
                Kind::Graph(found) => Some(found.layout()),
                _ => None,
            })
        })?;
        Ok(bytes.map(|bytes| PyBytes::new(py, &bytes)))
    }

    /// The page (HTML) that shows the result beside its input.
    fn page(&self, py: Python<'_>, title: &str, before: Option<Bound<'_, Mesh>>) -> PyResult<String> {
        let before = before.map(|mesh| Arc::clone(&mesh.get().0));
        run::beside(py, None, |_, _| {
            let mut page = Page::new(title).record(self.brief());
            if let Some(mesh) = &before {
                page = page.scene(Scene::of_mesh("input", mesh)?.role(Role::Before));
            }
            if let Some(scene) = self.scene()? {
                page = page.scene(scene.role(Role::After));
            }
            page.html()
        })
    }

    /// The picture that the command line would draw (PNG).
    fn picture<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyBytes>>> {
        let png = run::beside(py, None, |_, _| {
            let image = match (&self.kind, &self.mesh) {
                (Kind::Field(found), _) => field_figure(found),
                (Kind::Graph(found), _) => graph_figure(found),
                (Kind::Skeleton(found), _) => skeleton_figure(&found.closed.mesh, &found.net),
                (Kind::Hexes(found), _) => hex_figure(&found.mesh),
                (_, Some(mesh)) => figure(mesh),
                (_, None) => return Ok(None),
            };
            image.to_png().map(Some)
        })?;
        Ok(png.map(|png| PyBytes::new(py, &png)))
    }
}

impl Found {
    /// What the page shows of the result.
    fn scene(&self) -> Result<Option<Scene>, Error> {
        Ok(Some(match (&self.kind, &self.mesh) {
            (Kind::Field(found), _) => Scene::of_field("field", found)?,
            (Kind::Graph(found), _) => Scene::of_graph("graph", found)?,
            (Kind::Skeleton(found), _) => {
                Scene::of_surface("skeleton", &found.closed.mesh)?.net("skeleton", &found.net).show("plain")
            }
            (Kind::Hexes(found), _) => Scene::of_hexes("hexes", &found.mesh)?.net("skeleton", &found.skeleton),
            (_, Some(mesh)) => Scene::of_mesh("result", mesh)?,
            (_, None) => return Ok(None),
        }))
    }

    /// The record without its long parts.
    fn brief(&self) -> serde_json::Value {
        let mut record = serde_json::from_str(&self.record).unwrap_or_default();
        if let serde_json::Value::Object(parts) = &mut record {
            parts.retain(|name, part| name == "warnings" || part.to_string().len() <= LONGEST);
        }
        record
    }
}

/// Runs a verb. `inputs` and the values of `options` may name what `hosted` holds: meshes, nets, and arrays of edges.
#[pyfunction]
pub fn call(
    py: Python<'_>,
    verb: &str,
    inputs: Vec<String>,
    options: Vec<(String, Bound<'_, PyAny>)>,
    hosted: BTreeMap<PathBuf, Bound<'_, PyAny>>,
    watch: Option<Bound<'_, PyAny>>,
) -> PyResult<Found> {
    let options = options.into_iter().map(|(name, v)| Ok((name, value(&v)?))).collect::<PyResult<Vec<_>>>()?;
    let inputs_by_name = hosted.into_iter().map(|(name, o)| Ok((name, input(&o)?))).collect::<PyResult<_>>()?;
    let outcome = run::beside(py, watch.as_ref(), |cancel, progress| {
        host::call(verb, &inputs, &options, Host::new(cancel, progress, inputs_by_name))
    })?;
    Ok(outcome.into())
}

/// The words of a command line, without the program's name.
#[pyfunction]
pub fn arguments(
    py: Python<'_>,
    verb: &str,
    inputs: Vec<String>,
    options: Vec<(String, Bound<'_, PyAny>)>,
) -> PyResult<Vec<String>> {
    let options = options.into_iter().map(|(name, v)| Ok((name, value(&v)?))).collect::<PyResult<Vec<_>>>()?;
    let words = host::arguments(verb, &inputs, &options).map_err(|e| raise::exception(py, &e))?;
    Ok(words.into_iter().skip(1).collect())
}

/// The long names of a verb's options.
#[pyfunction]
pub fn option_names(verb: &str) -> Vec<String> {
    host::option_names(verb)
}

fn value(value: &Bound<'_, PyAny>) -> PyResult<Value> {
    match value.extract::<bool>() {
        Ok(flag) => Ok(Value::Bool(flag)),
        Err(_) => Ok(Value::Text(value.extract()?)),
    }
}

fn input(object: &Bound<'_, PyAny>) -> PyResult<Input> {
    if let Ok(mesh) = object.cast::<Mesh>() {
        return Ok(Input::Mesh(RawMesh::clone(&mesh.get().0)));
    }
    if let Ok(net) = object.cast::<Net>() {
        return Ok(Input::Skeleton(carreau::mesh::CurveNet::clone(&net.get().0)));
    }
    let edges = object.extract::<PyReadonlyArray2<'_, u32>>();
    let edges = edges.map_err(|_| PyTypeError::new_err("a mesh, a skeleton or an array of edges is expected"))?;
    Ok(Input::Edges(edges.as_array().rows().into_iter().map(|e| [e[0], e[1]].map(VertexId)).collect()))
}
