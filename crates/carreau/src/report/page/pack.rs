//! Scenes as the viewer reads them: a JSON head that says where each array is, and the arrays.

use super::container::{Container, Slot};
use super::layer::{Layer, Lines, Markers, Net, On, Path, Range, Style};
use super::scene::{Role, Scene};
use crate::mesh::{Column, Polygons};
use crate::report::picture::{Rgb, Scale, View, label_color, label_colors, ramp_colors};
use glam::DVec3;
use serde::Serialize;
use std::collections::BTreeMap;

/// Layers that give the colours at first, the first that a scene has.
const SHOWN: &[&str] = &["patch", "region", "truth", "group"];
/// Colours of a ramp.
const RAMP_COLOURS: usize = 256;

/// Everything of a page but its record.
#[derive(Serialize)]
pub struct Packed {
    /// Version of this layout.
    format: u32,
    /// Bytes of the arrays before deflation.
    bytes: usize,
    ramps: Ramps,
    scenes: Vec<PackedScene>,
}

/// Colours from low to high.
#[derive(Serialize)]
struct Ramps {
    sequential: Slot,
    diverging: Slot,
}

#[derive(Serialize)]
struct PackedScene {
    name: String,
    role: Role,
    /// Points are stored as (p − centre) / scale.
    centre: [f64; 3],
    scale: f64,
    /// From where pictures of it are taken: towards the eye, and upwards.
    eye: [f64; 3],
    up: [f64; 3],
    vertices: usize,
    points: Slot,
    faces: PackedPolygons,
    cells: PackedPolygons,
    layers: Vec<PackedLayer>,
    lines: Vec<PackedLines>,
    nets: Vec<PackedNet>,
    markers: Vec<PackedMarkers>,
    /// The layer shown at first.
    show: String,
}

#[derive(Serialize)]
struct PackedPolygons {
    count: usize,
    /// Corners of each where all have the same number.
    size: Option<usize>,
    /// Corners of each where they differ.
    sizes: Option<Slot>,
    corners: Slot,
}

#[derive(Serialize)]
struct PackedLayer {
    name: String,
    on: On,
    #[serde(flatten)]
    values: Values,
}

#[derive(Serialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
enum Values {
    /// Numbers, divided by `unit`.
    Scalar { values: Slot, range: Range, unit: f64 },
    /// Labels; `labels` lists those that occur, with a colour each.
    Label { values: Slot, labels: Slot, colors: Slot, words: BTreeMap<i32, String> },
    /// Directions, three numbers each.
    Vector { values: Slot },
    /// Red, green, blue, opacity.
    Color { values: Slot },
}

#[derive(Serialize)]
struct PackedLines {
    name: String,
    style: Style,
    /// Pairs of vertices, or
    edges: Option<Slot>,
    /// pairs of points.
    segments: Option<Slot>,
}

#[derive(Serialize)]
struct PackedNet {
    name: String,
    ids: Vec<i64>,
    points: Slot,
    /// Divided by the scale, as points.
    radii: Slot,
    edges: Slot,
}

#[derive(Serialize)]
struct PackedMarkers {
    name: String,
    vertices: Slot,
    values: Slot,
    usual: Slot,
}

/// Packs all scenes; their arrays go into the container.
pub fn pack(scenes: &[Scene], into: &mut Container) -> Packed {
    let mut ramp = |scale| into.u8(ramp_colors(scale, RAMP_COLOURS).into_iter().flatten());
    let ramps = Ramps { sequential: ramp(Scale::Sequential(None)), diverging: ramp(Scale::Diverging(None)) };
    let scenes = scenes.iter().map(|s| Frame::of(s).scene(s, into)).collect();
    Packed { format: 1, bytes: into.len(), ramps, scenes }
}

/// The box of a scene, which single-precision numbers are relative to.
struct Frame {
    centre: DVec3,
    scale: f64,
}

impl Frame {
    fn of(scene: &Scene) -> Self {
        let nets = scene.nets.iter().flat_map(|n| &n.net.points);
        let all = scene.points.iter().chain(nets).filter(|p| p.is_finite());
        let (low, high) =
            all.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(*p), high.max(*p)));
        // Halved first: the sum of two coordinates near the largest number would not be one.
        let (centre, scale) = (0.5 * low + 0.5 * high, (0.5 * high - 0.5 * low).max_element());
        if centre.is_finite() && scale > 0.0 {
            return Frame { centre, scale };
        }
        Frame { centre: if centre.is_finite() { centre } else { DVec3::ZERO }, scale: 1.0 }
    }

    fn local(&self, p: DVec3) -> [f32; 3] {
        // Scaled before they are subtracted, for the same reason.
        (p / self.scale - self.centre / self.scale).to_array().map(|x| x as f32)
    }

    fn points(&self, points: &[DVec3], into: &mut Container) -> Slot {
        into.f32(points.iter().flat_map(|&p| self.local(p)), 3)
    }

    fn scene(&self, scene: &Scene, into: &mut Container) -> PackedScene {
        let layers: Vec<PackedLayer> = scene.layers.iter().map(|l| layer(l, scene, into)).collect();
        let [eye, up] = view(scene).map(|d| d.to_array());
        PackedScene {
            eye,
            up,
            name: scene.name.clone(),
            role: scene.role,
            centre: self.centre.to_array(),
            scale: self.scale,
            vertices: scene.points.len(),
            points: self.points(&scene.points, into),
            faces: polygons(&scene.faces, into),
            cells: polygons(&scene.cells, into),
            show: shown(scene),
            layers,
            lines: scene.lines.iter().map(|l| self.lines(l, into)).collect(),
            nets: scene.nets.iter().map(|n| self.net(n, into)).collect(),
            markers: scene.markers.iter().map(|m| markers(m, into)).collect(),
        }
    }

    fn lines(&self, lines: &Lines, into: &mut Container) -> PackedLines {
        let (edges, segments) = match &lines.path {
            Path::Edges(edges) => (Some(into.u32(edges.iter().flatten().copied(), 2)), None),
            Path::Segments(ends) => (None, Some(into.f32(ends.iter().flatten().flat_map(|&p| self.local(p)), 6))),
        };
        PackedLines { name: lines.name.clone(), style: lines.style, edges, segments }
    }

    fn net(&self, net: &Net, into: &mut Container) -> PackedNet {
        let Net { name, net } = net;
        PackedNet {
            name: name.clone(),
            ids: net.ids.clone(),
            points: self.points(&net.points, into),
            radii: into.f32(net.radii.iter().map(|r| (r / self.scale) as f32), 1),
            edges: into.u32(net.edges.iter().flatten().copied(), 2),
        }
    }
}

/// The automatic view of a scene: towards the eye, and upwards.
fn view(scene: &Scene) -> [DVec3; 2] {
    let edges = |net: &Net| net.net.edges.iter().map(|e| &e[..]).collect::<Polygons>();
    let view = match scene.nets.first() {
        _ if !scene.faces.is_empty() => View::automatic(&scene.points, &scene.faces),
        Some(net) if scene.cells.is_empty() => View::automatic(&net.net.points, &edges(net)),
        _ => View::automatic(&scene.points, &scene.cells),
    };
    match view {
        View::From { eye, up } => [eye, up],
        View::Automatic => [DVec3::NEG_Y, DVec3::Z],
    }
}

/// The layer shown at first: what was asked for, else labels, else the quality of cells, else plain.
fn shown(scene: &Scene) -> String {
    let has = |name: &str| scene.layers.iter().any(|l| l.name == name);
    if let Some(name) = scene.show.as_ref().filter(|name| *name == "plain" || has(name)) {
        return name.clone();
    }
    let labels = SHOWN.iter().find(|name| has(name)).filter(|_| scene.cells.is_empty());
    let of_cells = scene.layers.iter().find(|l| l.on == On::Cell && l.name == "quality");
    labels.map(ToString::to_string).or_else(|| of_cells.map(|l| l.name.clone())).unwrap_or_else(|| "plain".into())
}

fn polygons(list: &Polygons, into: &mut Container) -> PackedPolygons {
    let first = list.iter().next().map(<[u32]>::len);
    let size = first.filter(|&size| list.iter().all(|f| f.len() == size));
    let sizes = if size.is_none() { Some(into.u32(list.iter().map(|f| f.len() as u32), 1)) } else { None };
    PackedPolygons {
        count: list.len(),
        size,
        sizes,
        corners: into.u32(list.corners().iter().copied(), size.unwrap_or(1)),
    }
}

fn layer(layer: &Layer, scene: &Scene, into: &mut Container) -> PackedLayer {
    let values = match &layer.column {
        Column::Scalar(values) => {
            let unit = unit(values);
            Values::Scalar { values: into.f32(values.iter().map(|v| (v / unit) as f32), 1), range: layer.range, unit }
        }
        Column::Label(labels) => self::labels(layer, labels, scene, into),
        Column::Vector2(v) => {
            let flat = v.iter().flat_map(|&[x, y]| [x as f32, y as f32, 0.0]);
            Values::Vector { values: into.f32(flat, 3) }
        }
        Column::Vector3(v) => Values::Vector { values: into.f32(v.iter().flatten().map(|&x| x as f32), 3) },
        Column::Color(colors) => Values::Color { values: into.u8(colors.iter().flatten().copied()) },
    };
    PackedLayer { name: layer.name.clone(), on: layer.on, values }
}

/// 1, or what numbers beyond single precision are divided by.
fn unit(values: &[f64]) -> f64 {
    let largest = values.iter().filter(|v| v.is_finite()).fold(0.0f64, |m, v| m.max(v.abs()));
    if largest > 0.0 && !(1e-30..1e30).contains(&largest) { largest } else { 1.0 }
}

fn labels(layer: &Layer, labels: &[i32], scene: &Scene, into: &mut Container) -> Values {
    let mut distinct = labels.to_vec();
    distinct.sort_unstable();
    distinct.dedup();
    let mut colors: Vec<Rgb> = (0..).zip(&distinct).map(|(rank, _)| label_color(rank)).collect();
    if layer.on == On::Face {
        // Regions that meet differ clearly.
        for (label, color) in labels.iter().zip(label_colors(&scene.faces, labels)) {
            if let Ok(rank) = distinct.binary_search(label) {
                colors[rank] = color;
            }
        }
    }
    Values::Label {
        values: into.i32(labels.iter().copied()),
        labels: into.i32(distinct),
        colors: into.u8(colors.into_iter().flatten()),
        words: layer.words.iter().cloned().collect(),
    }
}

fn markers(m: &Markers, into: &mut Container) -> PackedMarkers {
    PackedMarkers {
        name: m.name.clone(),
        vertices: into.u32(m.vertices.iter().copied(), 1),
        values: into.i32(m.values.iter().copied()),
        usual: into.i32(m.usual.iter().copied()),
    }
}
