//! The flags that say which edges are features, shared by `field` and `quad`, and the files that list edges.

use crate::session::Session;
use carreau::bounds::angle;
use carreau::geometry::features::FeatureOptions;
use carreau::mesh::VertexId;
use carreau::{Error, Place};
use clap::Args;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Which edges are features, as flags.
#[derive(Args)]
pub struct FeatureFlags {
    /// Edges with a larger angle between their faces are features, in degrees; 180: none is sharp [default: 35]
    #[arg(long, value_name = "DEG")]
    feature_angle: Option<f64>,
    /// Further features: a file with two vertex ids per line
    #[arg(long, value_name = "FILE")]
    features: Option<PathBuf>,
    /// Edges tagged in the file are not special
    #[arg(long)]
    ignore_tags: bool,
}

/// Which edges are features: what replays a run.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(default)]
pub struct FeatureValues {
    feature_angle: f64,
    features: Option<PathBuf>,
    ignore_tags: bool,
}

impl Default for FeatureValues {
    fn default() -> Self {
        FeatureValues { feature_angle: 35.0, features: None, ignore_tags: false }
    }
}

impl FeatureFlags {
    /// The file that lists edges.
    pub fn file(&self) -> Option<&Path> {
        self.features.as_deref()
    }

    /// These flags laid over values from an options file.
    pub fn over(&self, values: FeatureValues) -> FeatureValues {
        FeatureValues {
            feature_angle: self.feature_angle.unwrap_or(values.feature_angle),
            features: self.features.clone().or(values.features),
            ignore_tags: self.ignore_tags || values.ignore_tags,
        }
    }
}

impl FeatureValues {
    /// Refuses an angle that is none.
    pub fn validate(&self) -> Result<(), Error> {
        angle("feature-angle", self.feature_angle)
    }

    /// Features by angle, borders, tags and the listed edges, which are read here.
    pub fn load(&self, session: &Session) -> Result<FeatureOptions, Error> {
        let edges = self.features.as_deref().map(|file| session.load_edges(file)).transpose()?.unwrap_or_default();
        Ok(FeatureOptions { angle_deg: Some(self.feature_angle), borders: true, tags: !self.ignore_tags, edges })
    }
}

/// Tells of features that were asked for and do not exist.
pub fn warn_missing(missing: &[[VertexId; 2]], session: &mut Session) {
    if let Some([a, b]) = missing.first() {
        let count = missing.len();
        session.warn(format!("{count} tagged or listed edges are no edges of the mesh, the first is {} {}", a.0, b.0));
    }
}

/// Edges listed in a text file, two vertex ids per line; `#` starts a comment.
pub fn read_edges(file: &Path) -> Result<Vec<[VertexId; 2]>, Error> {
    let text = std::fs::read_to_string(file).map_err(|e| Error::read(file, Place::File, e.to_string()))?;
    let lines = text.lines().zip(1..).map(|(line, number)| (line.split('#').next().unwrap_or("").trim(), number));
    lines
        .filter(|(line, _)| !line.is_empty())
        .map(|(line, number)| {
            let ids: Vec<u32> = line.split_whitespace().map_while(|word| word.parse().ok()).collect();
            match ids[..] {
                [a, b] => Ok([VertexId(a), VertexId(b)]),
                _ => {
                    Err(Error::read(file, Place::Line(number), format!("two vertex ids are expected, found '{line}'")))
                }
            }
        })
        .collect()
}
