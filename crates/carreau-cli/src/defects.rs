//! Defects of a surface in words.

use crate::session::Session;
use carreau::Error;
use carreau::geometry::intersections::Intersections;
use carreau::mesh::{SurfaceMesh, Topology};
use serde_json::Value;

/// One line per kind of defect that there is, with its first places; what is open or unused is no defect to a method.
pub fn defect_lines(t: &Topology, all: bool) -> Vec<String> {
    let places = serde_json::to_value(&t.places).unwrap_or_default();
    let unused = [
        ("boundary loop", "boundary loops", t.boundary_loops, "boundary_loops"),
        ("boundary edge", "boundary edges", t.boundary_edges, "boundary_edges"),
        ("unreferenced vertex", "unreferenced vertices", t.unreferenced_vertices, "unreferenced_vertices"),
    ];
    let defects = [
        ("non-manifold edge", "non-manifold edges", t.nonmanifold_edges, "nonmanifold_edges"),
        ("non-manifold vertex", "non-manifold vertices", t.nonmanifold_vertices, "nonmanifold_vertices"),
        ("inconsistently oriented edge", "inconsistently oriented edges", t.inconsistent_edges, "inconsistent_edges"),
        ("degenerate face", "degenerate faces", t.degenerate_faces, "degenerate_faces"),
        ("duplicate face", "duplicate faces", t.duplicate_faces, "duplicate_faces"),
        ("coincident vertex", "coincident vertices", t.coincident_vertices, "coincident_vertices"),
        ("inverted component", "inverted components", t.inverted_components, "inverted_components"),
    ];
    let listed = unused.iter().filter(|_| all).chain(&defects).filter(|(_, _, count, _)| *count > 0);
    let line = |(one, many, count, key): &(&str, &str, usize, &str)| {
        let shown: Vec<String> = places[*key].as_array().into_iter().flatten().take(3).map(Value::to_string).collect();
        let dots = if *count > shown.len() { ", …" } else { "" };
        format!("{count} {}: {}{dots}", if *count == 1 { one } else { many }, shown.join(", "))
    };
    listed.map(line).collect()
}

/// The self-intersections of a surface.
pub fn intersections(session: &Session, mesh: &SurfaceMesh) -> Result<Intersections, Error> {
    let context = session.context.clone();
    context.install(|| {
        let _stage = context.stage("intersections");
        Intersections::of(mesh, &context)
    })
}

/// How many self-intersections there are, and where the first ones are.
pub fn intersection_line(found: &Intersections) -> Option<String> {
    let shown: Vec<String> = found.places.iter().take(3).map(|[a, b]| format!("[{a},{b}]")).collect();
    let dots = if found.pairs > shown.len() { ", …" } else { "" };
    let least = if found.more { "at least " } else { "" };
    let pairs = if found.pairs == 1 { "pair of faces meets" } else { "pairs of faces meet" };
    (found.pairs > 0)
        .then(|| format!("{least}{} {pairs} (self-intersections): {}{dots}", found.pairs, shown.join(", ")))
}
