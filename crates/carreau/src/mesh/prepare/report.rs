//! The report of the preparation: numbers, places, and one line of text.

use super::super::repair::Soup;
use super::super::repair::degenerate::is_flat_face;
use super::super::surface::SurfaceMesh;
use super::super::topology::Topology;
use super::bodies::Body;
use super::ids::{first, some, used_vertices};
use super::mend::Mended;
use serde::Serialize;

/// What was done, and the first place of each kind. Ids are those of the file.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct PrepareReport {
    /// The surface was taken as it is.
    pub as_is: bool,
    /// Vertices that became one with another.
    pub welded_vertices: usize,
    /// Faces without area that were left out, or flipped so that the surface stays closed.
    pub degenerate_faces: usize,
    /// Faces on the same vertices as another one: left out.
    pub duplicate_faces: usize,
    /// Triangles of fans that lay on each other in opposite senses: both of each pair left out.
    pub folded_faces: usize,
    /// Faces turned to agree with their neighbours.
    pub turned_faces: usize,
    /// Closed components turned outward, or inward where they are cavities.
    pub turned_components: usize,
    /// Edges of four and more faces whose sheets came apart.
    pub paired_edges: usize,
    /// Vertices that were doubled, where sheets touched.
    pub split_vertices: usize,
    /// Bodies that were left out.
    pub left_out: Pieces,
    /// Small bodies that stay.
    pub small: Pieces,
    /// Bodies that there are now.
    pub bodies: usize,
    /// Edges of more than two faces that stay.
    pub nonmanifold_edges: usize,
    /// Edges whose two faces do not agree: the surface has one side only.
    pub inconsistent_edges: usize,
    /// Faces without area that stay.
    pub degenerate_faces_left: usize,
    /// Where to look: the first place of every kind that there is.
    pub places: PreparePlaces,
}

/// The first place of every kind, under the name of its count.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct PreparePlaces {
    /// A vertex and the one that it became.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub welded_vertices: Option<[u32; 2]>,
    /// A face.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub degenerate_faces: Option<u32>,
    /// A face and the one that stands for it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub duplicate_faces: Option<[u32; 2]>,
    /// A face and the one that it lay on.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub folded_faces: Option<[u32; 2]>,
    /// A face.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub turned_faces: Option<u32>,
    /// A face of the component.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub turned_components: Option<u32>,
    /// The ends of an edge.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub paired_edges: Option<[u32; 2]>,
    /// The ends of an edge.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nonmanifold_edges: Option<[u32; 2]>,
    /// The ends of an edge.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub inconsistent_edges: Option<[u32; 2]>,
}

/// Some bodies together.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Pieces {
    /// How many.
    pub count: usize,
    /// Their faces.
    pub faces: usize,
    /// Their area, in the unit of the file.
    pub area: f64,
    /// A face of the first.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub first: Option<u32>,
}

impl Pieces {
    pub(super) fn of<'a>(bodies: impl Iterator<Item = &'a Body>, source: impl Fn(u32) -> u32) -> Self {
        bodies.fold(Pieces::default(), |sum, body| Pieces {
            count: sum.count + 1,
            faces: sum.faces + body.faces,
            area: sum.area + body.area,
            first: sum.first.or(Some(source(body.first))),
        })
    }
}

impl PrepareReport {
    /// What was done to a surface.
    pub(super) fn of(mended: &Mended, mesh: &SurfaceMesh) -> Self {
        let mut report = PrepareReport {
            degenerate_faces: mended.degenerate.len(),
            duplicate_faces: mended.doubles.len(),
            folded_faces: 2 * mended.folds.len(),
            paired_edges: mended.paired.len(),
            split_vertices: mended.copies,
            ..PrepareReport::default()
        };
        report.places.degenerate_faces = first(&mended.degenerate);
        report.places.duplicate_faces = first(&mended.doubles);
        report.places.folded_faces = first(&mended.folds);
        report.places.paired_edges = first(&mended.paired);
        report.note_turned(&mended.turned, &mended.inverted, &mended.soup.face_source);
        report.note_welded(mesh, &mended.soup);
        report
    }

    fn note_turned(&mut self, turned: &[bool], inverted: &[u32], face_source: &[u32]) {
        let mut faces = (0..turned.len()).filter(|&f| turned[f]).map(|f| face_source[f]);
        self.places.turned_faces = faces.next();
        self.turned_faces = faces.count() + usize::from(self.places.turned_faces.is_some());
        self.turned_components = inverted.len();
        self.places.turned_components = inverted.iter().map(|&f| face_source[f as usize]).min();
    }

    /// Vertices that faces use and that are not themselves any more.
    fn note_welded(&mut self, mesh: &SurfaceMesh, soup: &Soup) {
        let used = used_vertices(mesh);
        let mut stays = vec![false; mesh.vertex_count()];
        soup.vertex_source.iter().for_each(|&v| stays[v as usize] = true);
        let became = |v: usize| some(soup.vertex_image[v]).map(|now| soup.vertex_source[now as usize]);
        let gone = (0..mesh.vertex_count()).filter(|&v| used[v] && !stays[v]);
        let mut gone = gone.filter_map(|v| became(v).map(|now| [v as u32, now]));
        self.places.welded_vertices = gone.next();
        self.welded_vertices = gone.count() + usize::from(self.places.welded_vertices.is_some());
        // Where every sheet has got its own vertices back nothing has happened.
        if self.welded_vertices == 0 && self.split_vertices == 0 {
            self.paired_edges = 0;
            self.places.paired_edges = None;
        }
    }

    /// What is still wrong with the surface.
    pub(super) fn count_left(&mut self, mesh: &SurfaceMesh, source: impl Fn(u32) -> u32) {
        let t = Topology::of(mesh);
        self.nonmanifold_edges = t.nonmanifold_edges;
        self.inconsistent_edges = t.inconsistent_edges;
        let diagonal = mesh.diagonal();
        let tiny = |f: &[u32]| is_flat_face(mesh.points(), f, diagonal);
        self.degenerate_faces_left = mesh.faces().iter().filter(|f| tiny(f)).count();
        self.places.nonmanifold_edges = t.places.nonmanifold_edges.first().map(|ends| ends.map(|v| source(v.0)));
        self.places.inconsistent_edges = t.places.inconsistent_edges.first().map(|ends| ends.map(|v| source(v.0)));
    }

    /// What was done in one line; none where nothing was.
    pub fn line(&self) -> Option<String> {
        let p = &self.places;
        let pair = |pair: Option<[u32; 2]>, word: &str| pair.map(|[a, b]| format!("first {a} {word} {b}"));
        let one = |id: Option<u32>, word: &str| id.map(|id| format!("first {word}{id}"));
        let mut said = Vec::new();
        let mut say = |count: usize, verb: &str, one: &str, many: &str, place: Option<String>| {
            if count > 0 {
                let place = place.map(|place| format!(" ({place})")).unwrap_or_default();
                said.push(format!("{verb} {count} {}{place}", if count == 1 { one } else { many }));
            }
        };
        say(self.welded_vertices, "welded", "vertex", "vertices", pair(p.welded_vertices, "at"));
        say(self.degenerate_faces, "left out", "face without area", "faces without area", one(p.degenerate_faces, ""));
        say(self.duplicate_faces, "left out", "duplicate face", "duplicate faces", pair(p.duplicate_faces, "on"));
        // Always an even number of them.
        say(self.folded_faces, "left out", "folded face", "faces folded onto each other", pair(p.folded_faces, "on"));
        say(
            self.turned_faces,
            "turned",
            "face to agree with its neighbours",
            "faces to agree with their neighbours",
            one(p.turned_faces, ""),
        );
        say(
            self.turned_components,
            "turned",
            "component that was inside out",
            "components that were inside out",
            one(p.turned_components, "at face "),
        );
        say(
            self.paired_edges,
            "told bodies apart at",
            "edge of more than two faces",
            "edges of more than two faces",
            pair(p.paired_edges, "to"),
        );
        if self.paired_edges == 0 {
            say(self.split_vertices, "doubled", "vertex where sheets touch", "vertices where sheets touch", None);
        }
        let faces = |n: usize| format!("{n} {}", if n == 1 { "face" } else { "faces" });
        if let Some(first) = self.left_out.first {
            let Pieces { count, faces: n, .. } = self.left_out;
            let what = if count == 1 { "piece" } else { "pieces" };
            said.push(format!(
                "left out {count} {what} of {} (first at face {first}; --keep all keeps them)",
                faces(n)
            ));
        }
        if let Some(first) = self.small.first {
            let Pieces { count, faces: n, .. } = self.small;
            let what = if count == 1 { "small piece" } else { "small pieces" };
            said.push(format!(
                "kept {count} {what} of {} (first at face {first}; --keep largest leaves them out)",
                faces(n)
            ));
        }
        (!said.is_empty()).then(|| format!("prepared the surface: {}", said.join("; ")))
    }

    /// A sentence for everything that is still wrong, in the words of `info`.
    pub fn left(&self) -> Vec<String> {
        let pair = |pair: Option<[u32; 2]>| pair.map(|[a, b]| format!(": [{a},{b}]")).unwrap_or_default();
        let left = [
            (self.nonmanifold_edges, "non-manifold edge", "non-manifold edges", pair(self.places.nonmanifold_edges)),
            (
                self.inconsistent_edges,
                "inconsistently oriented edge",
                "inconsistently oriented edges",
                pair(self.places.inconsistent_edges),
            ),
            (self.degenerate_faces_left, "degenerate face", "degenerate faces", String::new()),
        ];
        let sentence = |(n, one, many, place): &(usize, &str, &str, String)| {
            format!("{n} {}{place}", if *n == 1 { one } else { many })
        };
        left.iter().filter(|s| s.0 > 0).map(sentence).collect()
    }
}
