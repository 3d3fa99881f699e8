//! Broken files through the readers.

use crate::bytes::mangle;
use crate::models;
use crate::random::Random;
use carreau::io::{self, FORMATS, SKELETON_EXTENSIONS, WriteOptions};
use carreau::mesh::{RawMesh, Topology};
use carreau::{Error, Result};
use std::env;
use std::fs;
use std::path::{Path, PathBuf};

/// Files of the corpus up to this size are starting points.
const LARGEST: u64 = 1 << 15;

/// Good files by extension, and a folder to write the broken ones to.
pub struct Files {
    folder: Folder,
    /// Extension, and the contents of at least one file.
    good: Vec<(String, Vec<Vec<u8>>)>,
}

/// A folder in memory where there is one; gone at the end.
struct Folder(PathBuf);

impl Folder {
    fn new() -> Self {
        let memory = Path::new("/dev/shm");
        let parent = if memory.is_dir() { memory.to_path_buf() } else { env::temp_dir() };
        let folder = parent.join(format!("carreau-fuzz-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        Folder(folder)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

impl Files {
    pub fn new() -> Self {
        let folder = Folder::new();
        let mut good: Vec<(String, Vec<Vec<u8>>)> = Vec::new();
        let mut add = |extension: &str, bytes: Vec<u8>| match good.iter_mut().find(|(e, _)| e == extension) {
            Some((_, files)) => files.push(bytes),
            None => good.push((extension.to_string(), vec![bytes])),
        };
        for extension in FORMATS.iter().flat_map(|f| f.extensions) {
            let path = folder.0.join(format!("good.{extension}"));
            for mesh in models::files() {
                for ascii in [false, true] {
                    // Not every format holds volume cells.
                    if io::write(&path, &mesh, &WriteOptions { ascii }).is_ok() {
                        add(extension, fs::read(&path).unwrap());
                    }
                }
            }
        }
        for extension in SKELETON_EXTENSIONS.iter().chain(&["vtp", "vtk", "obj"]) {
            let path = folder.0.join(format!("good.{extension}"));
            for net in models::nets() {
                io::write_skeleton(&path, &net).unwrap();
                add(extension, fs::read(&path).unwrap());
            }
        }
        let shared = env::var_os("CARREAU_SHARED").map(|s| PathBuf::from(s).join("data"));
        let mut found: Vec<PathBuf> = ["nasty", "graphs"]
            .iter()
            .filter_map(|f| fs::read_dir(shared.as_ref()?.join(f)).ok())
            .flatten()
            .map(|e| e.unwrap().path())
            .collect();
        found.sort();
        for path in found.iter().filter(|p| fs::metadata(p).is_ok_and(|m| m.is_file() && m.len() < LARGEST)) {
            let extension = io::extension(path);
            if io::format_of(path).is_some() || io::is_skeleton_file(path) {
                add(&extension, fs::read(path).unwrap());
            }
        }
        Files { folder, good }
    }

    /// One broken file.
    pub fn one(&self, k: u64, rng: &mut Random, keep: Option<PathBuf>) -> std::result::Result<(), String> {
        let (extension, files) = rng.pick(&self.good);
        let mut bytes = rng.pick(files).clone();
        let other: &Vec<u8> = rng.pick(files);
        mangle(&mut bytes, other, rng);
        let path = self.folder.0.join(format!("broken.{extension}"));
        fs::write(&path, &bytes).unwrap();
        if let Some(folder) = &keep {
            // A panic comes back far from here, so the file is written before and taken away after.
            fs::create_dir_all(folder).unwrap();
            fs::write(folder.join(format!("{k}.{extension}")), &bytes).unwrap();
        }
        let is_net =
            io::is_skeleton_file(&path) || (matches!(extension.as_str(), "vtp" | "vtk" | "obj") && rng.one_in(3));
        let held = if is_net { net(&path) } else { mesh(&path, rng) };
        let held = held.map_err(|e| format!("{extension}: {e}"));
        if let (Some(folder), Ok(())) = (&keep, &held) {
            fs::remove_file(folder.join(format!("{k}.{extension}"))).unwrap();
        }
        held
    }
}

/// An error of a reader: it tells something, and is the input's fault.
fn fair(error: &Error) -> std::result::Result<(), String> {
    match error {
        Error::Read { .. } | Error::Input { .. } if error.to_string().len() > 10 => Ok(()),
        other => Err(format!("error {other}")),
    }
}

fn net(path: &Path) -> std::result::Result<(), String> {
    match io::read_skeleton(path) {
        Err(e) => fair(&e),
        Ok(net) => {
            let n = net.points.len() as u32;
            let sound = net.radii.len() == net.points.len()
                && net.points.iter().all(|p| p.is_finite())
                && net.edges.iter().flatten().all(|&v| v < n);
            if sound { Ok(()) } else { Err("a skeleton with wrong ids, radii or coordinates".into()) }
        }
    }
}

fn mesh(path: &Path, rng: &mut Random) -> std::result::Result<(), String> {
    let mesh = match io::read(path) {
        Ok(mesh) => mesh,
        Err(e) => return fair(&e),
    };
    if rng.one_in(16) {
        survives(path, &mesh)?;
    }
    let surface = || -> Result<()> {
        let surface = mesh.into_surface()?;
        let faces = surface.face_count();
        let found = Topology::of(&surface);
        let triangles = surface.triangulated()?;
        let _ = (faces, found, Topology::of(&triangles));
        Ok(())
    };
    surface().or_else(|e| fair(&e))
}

/// What was read is written and read again: nothing is lost.
fn survives(path: &Path, mesh: &RawMesh) -> std::result::Result<(), String> {
    let copy = path.with_file_name("copy.vtu");
    match io::write(&copy, mesh, &WriteOptions::default()) {
        Err(Error::Input { .. }) => return Ok(()),
        Err(e) => return Err(format!("cannot be written as VTU: {e}")),
        Ok(_) => {}
    }
    let back = io::read(&copy).map_err(|e| format!("cannot be read back: {e}"))?;
    let same = back.points == mesh.points && back.faces == mesh.faces && back.cells.len() == mesh.cells.len();
    if same { Ok(()) } else { Err("what was written and read again differs".into()) }
}
