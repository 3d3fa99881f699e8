//! The figure of a motorcycle graph: patches in colours, features bold, tracks between them, dots where these start off the
//! features, as in the figure of a field.

use super::field::{FEWER, MORE};
use super::picture::{Colors, Image, Lines, Path, Picture, Rgb, render};
use crate::quad::graph::{CUT, FEATURE, MotorcycleGraph, TRACK};
use glam::DVec3;

/// Colour of tracks.
const TRACKS: Rgb = [20, 24, 36];
/// Opacity of cuts, which do not all follow the field.
const FAINT: f64 = 0.5;

/// Draws a motorcycle graph.
pub fn graph_figure(graph: &MotorcycleGraph) -> Image {
    let [features, tracks, cuts] = [FEATURE, TRACK, CUT].map(|tag| graph.edges(|t| t == tag));
    let mut picture = Picture::new(graph.mesh.points(), graph.mesh.faces());
    picture.colors = Colors::Labels(graph.patch_of());
    picture.lines.push(Lines { opacity: FAINT, ..Lines::new(Path::Edges(&cuts), TRACKS, 1.4) });
    picture.lines.push(Lines::new(Path::Edges(&tracks), TRACKS, 1.4));
    picture.lines.push(Lines { width: 3.0, ..Lines::bold(Path::Edges(&features)) });
    let dots = |fewer: bool| {
        let chosen = graph.starts.iter().filter(|s| s.inner && (s.quads < 4) == fewer);
        chosen.map(|s| [graph.mesh.points()[s.vertex as usize]; 2]).collect::<Vec<[DVec3; 2]>>()
    };
    let (fewer, more) = (dots(true), dots(false));
    picture.lines.push(Lines::new(Path::Segments(&fewer), FEWER, 9.0));
    picture.lines.push(Lines::new(Path::Segments(&more), MORE, 9.0));
    render(&picture)
}
