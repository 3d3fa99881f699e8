//! Feature edges, for all verbs that keep them: the flags that say which these are, and what record and page tell of them.

use crate::prepare::edges_of_surface;
use crate::session::Session;
use carreau::bounds::angle;
use carreau::geometry::features::{FeatureOptions, FoundFeatures};
use carreau::mesh::{Prepared, VertexId};
use carreau::report::page::{Path as Lines, Scene, Style};
use carreau::{DVec3, Error};
use clap::Args;
use serde::{Deserialize, Serialize};
use serde_json::json;
use std::path::{Path, PathBuf};

/// Which edges are features, as flags.
#[derive(Args)]
pub struct FeatureFlags {
    /// Makes every edge with a larger angle between its faces a feature, in degrees; 180: none [default: only creases, from 35°]
    #[arg(long, value_name = "DEG")]
    feature_angle: Option<f64>,
    /// auto: creases at the size of the result; or a file with two vertex ids per line, to add these edges [default: auto]
    #[arg(long, value_name = "auto|FILE", value_parser = auto_or_file)]
    features: Option<AutoOrFile>,
    /// Ignores edges tagged in the file
    #[arg(long)]
    ignore_tags: bool,
}

/// The word `auto`, or a file of edges.
#[derive(Debug, Clone)]
pub struct AutoOrFile(Option<PathBuf>);

fn auto_or_file(text: &str) -> Result<AutoOrFile, String> {
    Ok(AutoOrFile((text != "auto").then(|| PathBuf::from(text))))
}

/// Which edges are features: what replays a run.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct FeatureValues {
    /// Every edge above it; else creases at the size of the result.
    feature_angle: Option<f64>,
    features: Option<PathBuf>,
    ignore_tags: bool,
}

impl FeatureFlags {
    /// The file that lists edges.
    pub fn file(&self) -> Option<&Path> {
        self.features.as_ref().and_then(|given| given.0.as_deref())
    }

    /// These flags laid over values from an options file.
    pub fn over(&self, values: FeatureValues) -> FeatureValues {
        let is_auto = matches!(self.features, Some(AutoOrFile(None)));
        FeatureValues {
            feature_angle: self.feature_angle.or(values.feature_angle.filter(|_| !is_auto)),
            features: self.features.as_ref().map_or(values.features, |given| given.0.clone()),
            ignore_tags: self.ignore_tags || values.ignore_tags,
        }
    }
}

impl FeatureValues {
    /// Refuses an angle that is none.
    pub fn validate(&self) -> Result<(), Error> {
        self.feature_angle.map_or(Ok(()), |degrees| angle("feature-angle", degrees))
    }

    /// Features by angle, borders, tags and the listed edges, which are read here.
    pub fn load(&self, session: &Session, prepared: &Prepared) -> Result<FeatureOptions, Error> {
        let edges = self.features.as_deref().map(|file| session.load_edges(file)).transpose()?.unwrap_or_default();
        let edges = edges_of_surface(prepared, edges);
        let every = |angle| FeatureOptions { angle_deg: Some(angle), ..FeatureOptions::default() };
        let creases = self.feature_angle.map_or_else(FeatureOptions::auto, every);
        Ok(FeatureOptions { tags: !self.ignore_tags, edges, ..creases })
    }
}

/// The segments of the polylines in a file of guides; none without one.
pub fn load_guides(session: &Session, file: Option<&Path>) -> Result<Vec<[DVec3; 2]>, Error> {
    let Some(file) = file else { return Ok(Vec::new()) };
    let (points, edges) = if session.is_skeleton(file) {
        let net = session.load_skeleton(file)?;
        (net.points, net.edges)
    } else {
        let mesh = session.load_mesh(file)?;
        (mesh.points, mesh.edges)
    };
    if edges.is_empty() {
        let what = format!("{} has no polylines", file.display());
        return Err(Error::input(what, "", "give guides as lines of an OBJ, VTP or VTK file, or as a skeleton"));
    }
    Ok(edges.iter().map(|ends| ends.map(|v| points[v as usize])).collect())
}

/// Tells of the features that were found, and of sharp edges that are none.
pub fn tell_features(found: &FoundFeatures, session: &mut Session) {
    let dropped = found.dropped.len();
    if let Some(longest) = found.longest_dropped {
        let (kept, [x, y, z]) = (found.kept.len(), longest.place.to_array());
        session.say(format!(
            "features: {kept} edges; {dropped} sharp edges are none at this size, the longest strand is {:.4} long, near {x:.4} {y:.4} {z:.4}",
            longest.length
        ));
    }
    let longest = found.longest_dropped.map(|l| json!({ "length": l.length, "place": l.place.to_array() }));
    let record =
        json!({ "edges": found.kept.len(), "dropped": dropped, "longest_dropped": longest, "noise": found.noise });
    session.record.set("features", record);
}

/// A scene with features and sharp edges that are none, as lines of two colours, where there are any of these.
pub fn with_both(scene: Scene, found: &FoundFeatures) -> Scene {
    if found.dropped.is_empty() {
        return scene;
    }
    with_dropped(scene.lines("features", Style::Feature, Lines::Segments(found.kept.clone())), found)
}

/// A scene with the sharp edges of the input that are no features, as lines of their own.
pub fn with_dropped(scene: Scene, found: &FoundFeatures) -> Scene {
    if found.dropped.is_empty() {
        return scene;
    }
    scene.lines("sharp edges that are no features", Style::Singular, Lines::Segments(found.dropped.clone()))
}

/// Tells of features that were asked for and do not exist.
pub fn warn_missing(missing: &[[VertexId; 2]], prepared: &Prepared, session: &mut Session) {
    if let Some([a, b]) = missing.first().map(|ends| ends.map(|v| VertexId(prepared.vertex(v.0)))) {
        let count = missing.len();
        session.warn(format!("{count} tagged or listed edges do not exist in the mesh, the first is {} {}", a.0, b.0));
    }
}
