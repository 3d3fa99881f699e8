//! The reader: the primitives of all meshes at their places become one mesh.

use super::super::names::FaceNames;
use super::super::source::Source;
use super::super::text::shown;
use super::super::vtk_cells::strip_triangles;
use super::accessor::Accessors;
use super::container::{Buffers, Container};
use super::scene::{Instance, instances};
use super::schema::{Document, Primitive};
use super::srgb::srgb_of_linear;
use crate::error::{Error, Place, Result};
use crate::mesh::{Column, RawMesh};
use glam::{DMat3, DMat4, DVec3};
use std::collections::{BTreeMap, BTreeSet};

/// Points and corners that a mesh may have for each byte of its files. A file may use one mesh many times; one that
/// expands beyond this is meant to exhaust the memory.
const MESH_EXPANSION: usize = 16;

/// Extensions a file may require because they change nothing about the meshes, or are understood.
const HARMLESS: [&str; 6] =
    ["KHR_mesh_quantization", "KHR_materials_", "KHR_texture_", "EXT_texture_", "KHR_lights_", "MSFT_texture_"];

/// Reads a `.gltf` or `.glb` file; the content decides which it is.
pub fn read(source: &Source) -> Result<RawMesh> {
    let container = Container::open(source)?;
    let document = container.document(source)?;
    let harmless = |name: &String| HARMLESS.iter().any(|known| name.starts_with(known));
    if let Some(name) = document.extensions_required.iter().find(|name| !harmless(name)) {
        return Err(
            source.error(Place::File, format!("the file requires the extension {name}, which is not supported"))
        );
    }
    let buffers = Buffers::new(source, &document.buffers, &container);
    let accessors = Accessors::new(source, &document, buffers);
    let mut builder = Builder::new(source, &document, accessors);
    for instance in instances(source, &document)? {
        builder.instance(&instance)?;
    }
    Ok(builder.finish())
}

/// One of the optional values of vertices: a default where a primitive has none.
#[derive(Default)]
struct Optional<T> {
    values: Vec<T>,
    /// Whether some primitives have it, and whether some have not.
    present: bool,
    missing: bool,
}

impl<T: Clone> Optional<T> {
    fn append(&mut self, values: Option<Vec<T>>, count: usize, otherwise: T) {
        self.present |= values.is_some();
        self.missing |= values.is_none();
        match values {
            Some(values) => self.values.extend(values),
            None => self.values.resize(self.values.len() + count, otherwise),
        }
    }
}

/// Normal of vertices that have none.
const NO_NORMAL: [f64; 3] = [0.0; 3];
/// Texture coordinates of vertices that have none.
const NO_UV: [f64; 2] = [0.0; 2];
/// Colour of vertices that have none: white.
const NO_COLOR: [u8; 4] = [255; 4];

/// Puts the mesh together.
struct Builder<'a> {
    source: &'a Source<'a>,
    document: &'a Document,
    accessors: Accessors<'a>,
    mesh: RawMesh,
    normals: Optional<[f64; 3]>,
    uvs: Optional<[f64; 2]>,
    colors: Optional<[u8; 4]>,
    /// Corners of all primitives so far.
    corners: usize,
    /// Material of every face; -1 where it has none.
    materials: Vec<i32>,
    objects: FaceNames,
    left_out: BTreeSet<&'static str>,
}

impl<'a> Builder<'a> {
    fn new(source: &'a Source<'a>, document: &'a Document, accessors: Accessors<'a>) -> Self {
        Builder {
            source,
            document,
            accessors,
            mesh: RawMesh::default(),
            normals: Optional::default(),
            uvs: Optional::default(),
            colors: Optional::default(),
            corners: 0,
            materials: Vec::new(),
            objects: FaceNames::new(""),
            left_out: BTreeSet::new(),
        }
    }

    fn error(&self, what: impl Into<String>) -> Error {
        self.source.error(Place::File, what)
    }

    /// Adds the primitives of a mesh. Those with the same vertices share them.
    fn instance(&mut self, instance: &Instance) -> Result<()> {
        let meshes = &self.document.meshes;
        let Some(mesh) = meshes.get(instance.mesh) else {
            return Err(self.error(format!("mesh {} does not exist, there are {}", instance.mesh, meshes.len())));
        };
        if instance.skinned {
            self.left_out.insert("skins are left out: the mesh is in its bind pose");
        }
        let name = instance.name.as_deref().or(mesh.name.as_deref()).unwrap_or_default();
        self.objects.name(name.as_bytes(), self.mesh.faces.len());
        let mut known: BTreeMap<&BTreeMap<String, usize>, (u32, u32)> = BTreeMap::new();
        for primitive in &mesh.primitives {
            let Some(&position) = primitive.attributes.get("POSITION") else {
                self.left_out.insert("primitives without positions are left out");
                continue;
            };
            let mode = primitive.mode.unwrap_or(4);
            if mode == 0 {
                self.left_out.insert("points are left out");
                continue;
            }
            if !primitive.targets.is_empty() {
                self.left_out.insert("morph targets are left out");
            }
            self.refuse_compressed(primitive, position)?;
            let (first, count) = match known.get(&primitive.attributes) {
                Some(&vertices) => vertices,
                None => {
                    let vertices = self.vertices(primitive, position, instance.transform)?;
                    known.insert(&primitive.attributes, vertices);
                    vertices
                }
            };
            let corners = match primitive.indices {
                Some(indices) => self.accessors.indices(indices)?,
                None => (0..count).collect(),
            };
            self.corners += corners.len();
            self.check_size()?;
            if let Some(&beyond) = corners.iter().find(|&&v| v >= count) {
                return Err(self.error(format!("mesh {}: index {beyond}, there are {count} vertices", instance.mesh)));
            }
            let corners: Vec<u32> = corners.into_iter().map(|v| first + v).collect();
            let mirrored = instance.transform.is_some_and(|m| m.determinant() < 0.0);
            self.elements(mode, &corners, mirrored)?;
            self.label_faces(primitive)?;
        }
        Ok(())
    }

    /// Notes material and object of the faces that a primitive has added.
    fn label_faces(&mut self, primitive: &Primitive) -> Result<()> {
        let count = self.document.materials.len();
        if let Some(beyond) = primitive.material.filter(|&material| material >= count) {
            return Err(self.error(format!("material {beyond} does not exist, there are {count}")));
        }
        let material = primitive.material.and_then(|k| i32::try_from(k).ok()).unwrap_or(-1);
        while self.materials.len() < self.mesh.faces.len() {
            self.materials.push(material);
            self.objects.face();
        }
        Ok(())
    }

    /// The labels `material` and `object`, where the file tells materials and objects apart by name.
    fn store_labels(&mut self) {
        let attributes = &mut self.mesh.attributes;
        let objects = std::mem::replace(&mut self.objects, FaceNames::new(""));
        match objects.only() {
            None => objects.store("object", attributes),
            Some(only) if only.is_empty() => {}
            Some(only) => drop(attributes.names.insert(("object".into(), 0), only)),
        }
        if self.materials.iter().all(|&material| material < 0) {
            return;
        }
        let used: BTreeSet<i32> = self.materials.iter().copied().filter(|&material| material >= 0).collect();
        for label in used {
            let Some(material) = self.document.materials.get(label as usize) else { continue };
            let key = ("material".to_string(), label);
            attributes.names.insert(key.clone(), material.name.clone().unwrap_or_else(|| format!("material_{label}")));
            let Some(look) = &material.pbr_metallic_roughness else { continue };
            if look.base_color_texture.is_some() {
                self.left_out.insert("textures of materials are left out");
            }
            if let Some([r, g, b, a]) = look.base_color_factor {
                let opacity = (255.0 * a.clamp(0.0, 1.0)).round() as u8;
                attributes.colors.insert(key, [srgb_of_linear(r), srgb_of_linear(g), srgb_of_linear(b), opacity]);
            }
        }
        attributes.face.insert("material".into(), Column::Label(std::mem::take(&mut self.materials)));
    }

    fn refuse_compressed(&self, primitive: &Primitive, position: usize) -> Result<()> {
        let draco = primitive.extensions.keys().find(|name| name.contains("draco"));
        match draco {
            Some(name) if self.accessors.accessor(position)?.buffer_view.is_none() => {
                let name = shown(name.as_bytes());
                Err(self.error(format!("the mesh is compressed by the extension {name}, which is not supported")))
            }
            _ => Ok(()),
        }
    }

    /// Appends the vertices of a primitive; returns the first and their number.
    fn vertices(&mut self, primitive: &Primitive, position: usize, transform: Option<DMat4>) -> Result<(u32, u32)> {
        let mut points: Vec<DVec3> = self.accessors.elements(position)?.into_iter().map(DVec3::from_array).collect();
        let count = points.len();
        let attribute = |name: &str| primitive.attributes.get(name).copied();
        let mut normals = attribute("NORMAL").map(|index| self.accessors.elements::<3>(index)).transpose()?;
        let uvs = attribute("TEXCOORD_0").map(|index| self.accessors.elements::<2>(index)).transpose()?;
        let colors = attribute("COLOR_0").map(|index| self.colors(index)).transpose()?;
        let lengths = [normals.as_ref().map(Vec::len), uvs.as_ref().map(Vec::len), colors.as_ref().map(Vec::len)];
        if let Some(other) = lengths.into_iter().flatten().find(|&length| length != count) {
            return Err(
                self.error(format!("a primitive has {count} positions and {other} values of another attribute"))
            );
        }
        if let Some(transform) = transform {
            points.iter_mut().for_each(|p| *p = transform.transform_point3(*p));
            let of_normals = DMat3::from_mat4(transform).inverse().transpose();
            for normal in normals.iter_mut().flatten() {
                *normal = (of_normals * DVec3::from_array(*normal)).normalize_or_zero().to_array();
            }
        }
        let first = self.mesh.points.len();
        self.mesh.points.extend(points);
        self.normals.append(normals, count, NO_NORMAL);
        self.uvs.append(uvs, count, NO_UV);
        self.colors.append(colors, count, NO_COLOR);
        self.check_size()?;
        match (u32::try_from(first), u32::try_from(self.mesh.points.len())) {
            (Ok(first), Ok(end)) => Ok((first, end - first)),
            _ => Err(self.error("there are more than 2³² vertices")),
        }
    }

    /// Colours of three or four components.
    fn colors(&mut self, index: usize) -> Result<Vec<[u8; 4]>> {
        let opaque = |[r, g, b]: [f64; 3]| [r, g, b, 1.0];
        let colors = if self.accessors.accessor(index)?.kind == "VEC3" {
            self.accessors.elements(index)?.into_iter().map(opaque).collect()
        } else {
            self.accessors.elements(index)?
        };
        let bytes = |[r, g, b, a]: [f64; 4]| {
            [srgb_of_linear(r), srgb_of_linear(g), srgb_of_linear(b), (255.0 * a).round() as u8]
        };
        Ok(colors.into_iter().map(bytes).collect())
    }

    /// Appends the elements of a primitive (section 3.7.2.1 of the specification).
    fn elements(&mut self, mode: u32, corners: &[u32], mirrored: bool) -> Result<()> {
        let faces = &mut self.mesh.faces;
        // A transform that mirrors turns the sense of the triangles over.
        let mut push = |[a, b, c]: [u32; 3]| faces.push(&if mirrored { [a, c, b] } else { [a, b, c] });
        let edges = &mut self.mesh.edges;
        let unused = match (mode, corners) {
            (1, _) => {
                edges.extend(corners.as_chunks().0);
                corners.len() % 2
            }
            (2, &[first, .., last]) => {
                edges.extend(corners.array_windows());
                edges.push([last, first]);
                0
            }
            (2 | 3, _) => {
                edges.extend(corners.array_windows());
                0
            }
            (4, _) => {
                corners.as_chunks().0.iter().for_each(|&t| push(t));
                corners.len() % 3
            }
            (5, _) => {
                strip_triangles(corners).for_each(push);
                0
            }
            (6, &[hub, ref rim @ ..]) => {
                rim.array_windows().for_each(|&[a, b]| push([hub, a, b]));
                0
            }
            (6, []) => 0,
            _ => return Err(self.error(format!("primitives of mode {mode} do not exist"))),
        };
        if unused > 0 {
            return Err(self.error(format!("{} corners do not make up whole elements", corners.len())));
        }
        Ok(())
    }

    /// Bounds the work, and the corners of faces to 32 bits: strips and fans have up to three for each of theirs.
    fn check_size(&self) -> Result<()> {
        let size = self.mesh.points.len() + self.corners;
        let bytes = self.source.bytes.len() + self.accessors.buffers.external_size();
        if size <= bytes.saturating_mul(MESH_EXPANSION).min(u32::MAX as usize / 3) {
            return Ok(());
        }
        Err(self.error(format!(
            "used many times, the meshes of {bytes} bytes make up {size} points and corners, which is too many"
        )))
    }

    fn finish(mut self) -> RawMesh {
        self.store_labels();
        let mut mesh = self.mesh;
        mesh.edge_tags = vec![0; mesh.edges.len()];
        mesh.notes = self.left_out.into_iter().map(str::to_string).collect();
        if mesh.points.is_empty() {
            mesh.notes.push("the file shows no mesh".to_string());
        }
        let vertex = &mut mesh.attributes.vertex;
        let mut keep = |name: &str, column: Column, default: &str, present: bool, missing: bool| {
            if present {
                vertex.insert(name.to_string(), column);
            }
            if present && missing {
                mesh.notes.push(format!("'{name}' is {default} at vertices of primitives that have none"));
            }
        };
        keep("normal", Column::Vector3(self.normals.values), "0 0 0", self.normals.present, self.normals.missing);
        keep("uv", Column::Vector2(self.uvs.values), "0 0", self.uvs.present, self.uvs.missing);
        keep("color", Column::Color(self.colors.values), "white", self.colors.present, self.colors.missing);
        mesh
    }
}
