//! What a program holds for a verb, and what it is handed back: in memory, without files.

use carreau::context::Progress;
use carreau::field::Field;
use carreau::hex::HexResult;
use carreau::mesh::{CurveNet, RawMesh, VertexId};
use carreau::patch::PatchResult;
use carreau::quad::MotorcycleGraph;
use carreau::skeleton::Skeleton;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex};

/// What stands for a file.
#[allow(clippy::large_enum_variant)] // a few per call
pub enum Input {
    /// A mesh.
    Mesh(RawMesh),
    /// A skeleton.
    Skeleton(CurveNet),
    /// A list of edges.
    Edges(Vec<[VertexId; 2]>),
}

/// What a verb made.
#[allow(clippy::large_enum_variant)] // one per call
pub enum Found {
    /// The mesh that the command line would write.
    Mesh(RawMesh),
    /// Quad patches, and the mesh of their cells.
    Patches(RawMesh, PatchResult),
    /// A frame field, and the mesh that carries it.
    Field(RawMesh, Field),
    /// A motorcycle graph, and the mesh that it is drawn into.
    Graph(RawMesh, MotorcycleGraph),
    /// A skeleton.
    Skeleton(Skeleton),
    /// A mesh of hexahedra.
    Hexes(HexResult),
}

/// What a verb hands back.
#[derive(Default)]
pub struct Outcome {
    /// The result; `info` and `compare` have none but their record.
    pub found: Option<Found>,
    /// The result record (JSON).
    pub record: String,
    /// What the command line would print, line by line.
    pub summary: Vec<String>,
}

/// The surroundings of a verb that runs inside another program.
#[derive(Default)]
pub struct Host {
    /// Stops the run once it is set.
    pub(crate) cancel: Arc<AtomicBool>,
    /// Where progress is told.
    pub(crate) progress: Option<Arc<dyn Progress>>,
    /// What stands for files, by the names that the arguments use.
    pub(crate) inputs: BTreeMap<PathBuf, Input>,
    outcome: Mutex<Outcome>,
}

impl Host {
    /// A host that can stop the run by a flag, is told the progress, and holds these inputs.
    pub fn new(cancel: Arc<AtomicBool>, progress: Arc<dyn Progress>, inputs: BTreeMap<PathBuf, Input>) -> Self {
        Host { cancel, progress: Some(progress), inputs, ..Host::default() }
    }

    /// What stands for this file.
    pub(crate) fn input(&self, file: &Path) -> Option<&Input> {
        self.inputs.get(file)
    }

    /// Keeps the result for who called.
    pub(crate) fn keep(&self, found: Found) {
        self.with_outcome(|outcome| outcome.found = Some(found));
    }

    /// Keeps what is told about it.
    pub(crate) fn tell(&self, record: &str, summary: &[String]) {
        self.with_outcome(|outcome| (outcome.record, outcome.summary) = (record.to_string(), summary.to_vec()));
    }

    /// What the run handed back.
    pub(super) fn take_outcome(&self) -> Outcome {
        let mut outcome = Outcome::default();
        self.with_outcome(|kept| outcome = std::mem::take(kept));
        outcome
    }

    fn with_outcome(&self, change: impl FnOnce(&mut Outcome)) {
        change(&mut self.outcome.lock().unwrap_or_else(std::sync::PoisonError::into_inner));
    }
}
