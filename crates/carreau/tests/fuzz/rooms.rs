//! Spoiled meshes through the rooms.

use crate::models::Models;
use crate::random::Random;
use carreau::geometry::curvature::{CurvatureOptions, curvature};
use carreau::geometry::distance::{DistanceOptions, compare};
use carreau::geometry::intersections::Intersections;
use carreau::io::{self, WriteOptions};
use carreau::mesh::{Polygons, PrepareOptions, RepairOptions, SurfaceMesh, Takes, Triangles, prepare, repair};
use carreau::{Context, DVec3, Error, field, hex, patch, quad, remesh, segment, skeleton};
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// What a room may take before it has to give up.
const DEADLINE: Duration = Duration::from_secs(2);

type Held = Result<(), String>;
type Try = fn(&Rooms, &SurfaceMesh, &mut Random, &Context) -> carreau::Result<Held>;

/// Every room, the quick ones more often.
const ROOMS: &[(&str, usize, Try)] = &[
    ("repair", 24, |_, mesh, _, context| repaired(mesh, context)),
    ("prepare", 24, |_, mesh, rng, context| prepared(mesh, rng, context)),
    ("curvature", 20, |_, mesh, _, context| curvatures(mesh, context)),
    ("compare", 8, |_, mesh, _, context| compared(mesh, context)),
    ("segment", 20, |_, mesh, _, context| segmented(mesh, context)),
    ("patch", 24, |_, mesh, rng, context| patched(mesh, rng, context)),
    ("simplify", 6, |_, mesh, rng, context| remeshed(mesh, rng, context)),
    ("enrich", 3, |_, mesh, _, context| enriched(mesh, context)),
    ("field", 16, |_, mesh, _, context| framed(mesh, context)),
    ("quad", 1, |_, mesh, _, context| quadded(mesh, context)),
    ("skeleton", 1, |_, mesh, _, context| thinned(mesh, context)),
    ("hex of a surface", 1, |_, mesh, _, context| hexed(mesh, context)),
    ("hex of a skeleton", 2, |rooms, _, rng, context| tubed(rooms, rng, context)),
];

/// Rooms with an open finding: only runs that are asked for try them.
const OPEN: &[&str] = &["quad", "hex of a surface"];

pub struct Rooms {
    models: Models,
    /// Inputs of each room so far.
    tried: RefCell<BTreeMap<&'static str, u64>>,
    /// Rooms that are tried, and how often.
    weights: Vec<usize>,
    one: Context,
    three: Context,
}

impl Rooms {
    pub fn new() -> Self {
        let threads = |n| Context::new().with_threads(n).unwrap();
        let asked = std::env::var_os("CARREAU_FUZZ_ROOMS").is_some() || std::env::var_os("CARREAU_FUZZ_ONLY").is_some();
        let weights = ROOMS.iter().map(|r| if asked || !OPEN.contains(&r.0) { r.1 } else { 0 }).collect();
        Rooms { models: Models::new(), tried: RefCell::default(), weights, one: threads(1), three: threads(3) }
    }

    /// One spoiled mesh through one room.
    pub fn one(&self, k: u64, rng: &mut Random, keep: Option<PathBuf>) -> Held {
        let mesh = self.models.surface(rng);
        let mut at = rng.below(self.weights.iter().sum());
        let chosen = self.weights.iter().position(|&w| {
            let here = at < w;
            at = at.wrapping_sub(w);
            here
        });
        let (name, _, room) = ROOMS[chosen.unwrap()];
        *self.tried.borrow_mut().entry(name).or_default() += 1;
        let context = if rng.one_in(8) { &self.three } else { &self.one };
        let context = context.clone().with_deadline(Instant::now() + DEADLINE);
        let file = keep.map(|folder| folder.join(format!("{k}-{}.ply", name.replace(' ', "-"))));
        if let Some(file) = &file {
            io::write(file, &mesh.clone().into(), &WriteOptions::default()).unwrap();
        }
        let held = match room(self, &mesh, rng, &context) {
            Ok(held) => held,
            // What is the input's or the method's to say.
            Err(Error::Input { .. } | Error::Options(_) | Error::Numeric(_) | Error::Deadline) => Ok(()),
            Err(other) => Err(other.to_string()),
        };
        if let (Some(file), Ok(())) = (&file, &held) {
            std::fs::remove_file(file).unwrap();
        }
        held.map_err(|what| format!("{name} ({} triangles): {what}", mesh.face_count()))
    }
}

impl Drop for Rooms {
    fn drop(&mut self) {
        eprintln!("rooms, and their inputs: {:?}", self.tried.borrow());
    }
}

fn holds(condition: bool, what: &str) -> Held {
    if condition { Ok(()) } else { Err(what.into()) }
}

fn finite(points: &[DVec3]) -> bool {
    points.iter().all(|p| p.is_finite())
}

fn repaired(mesh: &SurfaceMesh, context: &Context) -> carreau::Result<Held> {
    let result = repair(mesh, &RepairOptions::default(), context)?;
    let after = &result.report.after;
    Ok(holds(finite(result.mesh.points()), "a coordinate is not finite")
        .and_then(|()| after.require_manifold().map_err(|e| e.to_string()))
        // One side only is what a surface may have been given: the report says so.
        .and_then(|()| holds(after.consistently_oriented || !after.orientable, "neighbours disagree")))
}

/// A surface as a soup, or twice in one, and what becomes of it.
fn prepared(mesh: &SurfaceMesh, rng: &mut Random, context: &Context) -> carreau::Result<Held> {
    let all = mesh.faces().fan().0;
    let twice = rng.one_in(2);
    let listed: Vec<[u32; 3]> = if twice { all.iter().chain(&all).copied().collect() } else { all };
    let listed: Vec<[u32; 3]> =
        listed.into_iter().map(|[a, b, c]| if rng.one_in(9) { [a, c, b] } else { [a, b, c] }).collect();
    let soup = match rng.below(3) {
        0 => SurfaceMesh::new(mesh.points().to_vec(), Polygons::from_triangles(&listed))?,
        _ => {
            let points = listed.iter().flatten().map(|&v| mesh.points()[v as usize]).collect();
            let faces: Vec<[u32; 3]> = (0..listed.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
            SurfaceMesh::new(points, Polygons::from_triangles(&faces))?
        }
    };
    let takes = if rng.one_in(4) { Takes::OneBody } else { Takes::Bodies };
    let done = prepare(soup.clone(), &PrepareOptions::default(), takes, context)?;
    let faces = done.mesh.face_count() as u32;
    let leads_back = (0..done.mesh.vertex_count() as u32)
        .all(|v| soup.points().get(done.vertex(v) as usize) == Some(&done.mesh.points()[v as usize]));
    let labels = done.labels_of_faces(&(0..faces).collect::<Vec<_>>());
    let again = prepare(done.mesh.clone(), &PrepareOptions::default(), Takes::Bodies, context)?;
    let crossed = Intersections::of(&done.mesh, context)?;
    Ok(holds(leads_back, "a vertex does not lead back")
        .and(holds(labels.len() == soup.face_count(), "a face of the file has no label"))
        .and(holds(labels.iter().all(|&l| l < faces.max(1)), "a label of no face"))
        .and(holds(done.bodies.of_face.len() == faces as usize, "a face without a body"))
        .and(holds(again.report.turned_components == 0, "a second preparation turns something"))
        .and(holds(crossed.places.len() <= crossed.pairs, "more places than pairs")))
}

fn curvatures(mesh: &SurfaceMesh, context: &Context) -> carreau::Result<Held> {
    let Some(triangles) = Triangles::of(mesh) else { return Ok(Err("no triangles".into())) };
    let none = vec![false; mesh.corner_count()];
    let k = curvature(triangles, &none, &CurvatureOptions::default(), context)?;
    let numbers = k.kmin.iter().chain(&k.kmax).all(|x| x.is_finite()) && finite(&k.dmin) && finite(&k.dmax);
    let ordered = k.kmin.iter().zip(&k.kmax).all(|(a, b)| a <= b);
    Ok(holds(k.kmin.len() == mesh.vertex_count() && numbers && ordered, "curvatures are not finite or not in order"))
}

/// A surface has no distance from itself, but for what rounding does to needles.
fn compared(mesh: &SurfaceMesh, context: &Context) -> carreau::Result<Held> {
    let options = DistanceOptions { samples: 200, refinements: 100, normals: true };
    let found = compare(mesh, mesh, &options, context)?;
    let size = mesh.points().iter().map(|p| p.abs().max_element()).fold(0.0, f64::max);
    let numbers = [found.distance.mean, found.distance.rms, found.distance.max, found.diagonal];
    Ok(holds(numbers.iter().all(|x| x.is_finite()), "a distance is not finite")
        .and_then(|()| holds(found.distance.max <= 1e-7 * size, "a surface is away from itself")))
}

fn segmented(mesh: &SurfaceMesh, context: &Context) -> carreau::Result<Held> {
    let result = segment::segment(mesh, &segment::SegmentOptions::default(), context)?;
    let mut sizes = vec![0; result.regions.len()];
    for &label in &result.labels {
        match sizes.get_mut(label as usize) {
            Some(size) => *size += 1,
            None => return Ok(Err(format!("label {label} of {} regions", result.regions.len()))),
        }
    }
    let right = result.regions.iter().zip(&sizes).all(|(r, &n)| r.triangles == n && n > 0);
    Ok(holds(result.labels.len() == mesh.face_count() && right, "the regions are not those of the labels"))
}

fn patched(mesh: &SurfaceMesh, rng: &mut Random, context: &Context) -> carreau::Result<Held> {
    let min_cells = 1 + rng.below(3) as u32;
    let result = patch::decompose(mesh, &patch::PatchOptions { min_cells, ..Default::default() }, context)?;
    let coverage = result.figures.coverage;
    Ok(holds((0.0..=1.0).contains(&coverage), "the coverage is no share"))
}

fn sound(mesh: &SurfaceMesh) -> Held {
    holds(finite(mesh.points()) && mesh.face_count() > 0, "no face, or a coordinate that is not finite")
}

fn remeshed(mesh: &SurfaceMesh, rng: &mut Random, context: &Context) -> carreau::Result<Held> {
    let mut options = remesh::RemeshOptions { deviation: 5.0 + 40.0 * rng.share(), ..Default::default() };
    match rng.below(5) {
        0 => options.geometric = true,
        1 => options.anisotropic = true,
        _ => {}
    }
    if options.geometric || rng.one_in(5) {
        options.triangles = Some(1 + rng.below(2 * mesh.face_count()));
    }
    let result = remesh::simplify(mesh, &options, context)?;
    Ok(sound(&result.mesh).and_then(|()| holds(result.quality.shape_min.is_finite(), "the shape is no number")))
}

fn enriched(mesh: &SurfaceMesh, context: &Context) -> carreau::Result<Held> {
    let options = remesh::RemeshOptions { deviation: 12.0, ..Default::default() };
    Ok(sound(&remesh::enrich(mesh, &options, context)?.mesh))
}

fn framed(mesh: &SurfaceMesh, context: &Context) -> carreau::Result<Held> {
    let result = field::field(mesh, &field::FieldOptions::default(), context)?;
    let faces = result.mesh.face_count();
    let unit = |d: &DVec3| (d.length() - 1.0).abs() < 1e-6;
    let frames = result.u.len() == faces && result.v.len() == faces && result.u.iter().chain(&result.v).all(unit);
    Ok(sound(&result.mesh).and_then(|()| holds(frames, "a frame is missing or not of unit length")))
}

fn quadded(mesh: &SurfaceMesh, context: &Context) -> carreau::Result<Held> {
    let result = quad::quads(
        mesh,
        &quad::QuadOptions { quads: 20 + mesh.face_count().min(180), ..Default::default() },
        context,
    )?;
    let all = result.mesh.faces().iter().all(|f| f.len() == 4);
    // The last rung moves nothing: the quads of triangles without area are what they are.
    let fair = all && (result.quality.inverted == 0 || result.rung() == 4);
    Ok(sound(&result.mesh).and_then(|()| holds(fair, "a face is no quad, or inverted")))
}

fn thinned(mesh: &SurfaceMesh, context: &Context) -> carreau::Result<Held> {
    let net = skeleton::extract(mesh, &skeleton::SkeletonOptions::default(), context)?.net;
    let radii = net.radii.len() == net.points.len() && net.radii.iter().all(|r| *r > 0.0 && r.is_finite());
    Ok(holds(finite(&net.points) && radii, "a node of the skeleton is not finite or has no radius"))
}

fn hexed(mesh: &SurfaceMesh, context: &Context) -> carreau::Result<Held> {
    let result = hex::from_surface(mesh, None, &hex::HexOptions::default(), context)?;
    Ok(cells(&result))
}

fn tubed(rooms: &Rooms, rng: &mut Random, context: &Context) -> carreau::Result<Held> {
    let net = rooms.models.net(rng);
    let padding = *rng.pick(&[hex::Padding::None, hex::Padding::Sides, hex::Padding::All]);
    let result = hex::from_net(&net, &hex::HexOptions { padding, ..Default::default() }, context)?;
    Ok(cells(&result))
}

fn cells(result: &hex::HexResult) -> Held {
    let mesh = &result.mesh;
    let ids = mesh.hexes.iter().flatten().chain(mesh.quads.iter().flatten()).all(|&v| (v as usize) < mesh.points.len());
    holds(finite(&mesh.points) && !mesh.hexes.is_empty() && ids, "no hex, or a coordinate that is not finite")
}
