//! The usual figure of a mesh: faces coloured by label where there are labels, edges faint, borders of labels bold.

use super::picture::{
    Colors, Image, Lines, Path, Picture, Rgb, Scale, View, crease_edges, label_borders, mesh_edges, render,
};
use crate::geometry::hexes::scaled_jacobian;
use crate::geometry::summary::Summary;
use crate::mesh::{Column, CurveNet, HexMesh, Polygons, RawMesh, SurfaceMesh, boundary_faces};
use glam::DVec3;

/// Face labels that a figure shows, the first one that a mesh has.
const LABELS: &[&str] = &["patch", "region", "truth", "ref", "group"];
/// Meshes with more faces are drawn without their edges, which would cover everything.
const MOST_FACES_WITH_EDGES: usize = 60_000;
/// Edges sharper than this are drawn bold where there are no labels, in degrees.
const BOLD_CREASE: f64 = 35.0;

/// Colour of skeletons.
const SKELETON: Rgb = [190, 30, 45];
/// Width of its lines, in pixels: they are seen through the surface.
const SKELETON_WIDTH: f64 = 4.0;
/// How much of the skeleton the surface around it covers: both are clearly seen.
const VEIL: f64 = 0.45;

/// Draws a mesh as a person would expect to see it.
pub fn figure(mesh: &RawMesh) -> Image {
    let labels = LABELS.iter().find_map(|name| match mesh.attributes.face.get(*name) {
        Some(Column::Label(labels)) => Some(labels.as_slice()),
        _ => None,
    });
    let n = mesh.points.len();
    let edges = if mesh.faces.len() <= MOST_FACES_WITH_EDGES { mesh_edges(n, &mesh.faces) } else { Vec::new() };
    let bold = match labels {
        Some(labels) => label_borders(n, &mesh.faces, labels),
        None => crease_edges(&mesh.points, &mesh.faces, BOLD_CREASE),
    };
    let mut picture = Picture::new(&mesh.points, &mesh.faces);
    if let Some(labels) = labels {
        picture.colors = Colors::Labels(labels);
    }
    // On a fine mesh lines of the usual width would hide the faces.
    let fine = mesh.faces.len() > MOST_FACES_WITH_EDGES / 4;
    picture.lines.push(Lines { opacity: if fine { 0.25 } else { 0.5 }, ..Lines::fine(Path::Edges(&edges)) });
    picture.lines.push(Lines { width: if fine { 1.2 } else { 1.8 }, ..Lines::bold(Path::Edges(&bold)) });
    render(&picture)
}

/// Draws the triangles of a CAD model, coloured by a kind per triangle, with the edges of the faces that the property `face` names.
pub fn cad_figure(mesh: &RawMesh, kinds: &[i32]) -> Image {
    let bold = match mesh.attributes.face.get("face") {
        Some(Column::Label(faces)) => label_borders(mesh.points.len(), &mesh.faces, faces),
        _ => Vec::new(),
    };
    let mut picture = Picture::new(&mesh.points, &mesh.faces);
    picture.colors = Colors::Labels(kinds);
    picture.lines.push(Lines { width: 1.8, ..Lines::bold(Path::Edges(&bold)) });
    render(&picture)
}

/// Draws a mesh coloured by a curvature per vertex: blue concave, white flat, red convex. Colours end at the 95th
/// percentile of the magnitudes, so that a few wild values do not bleach the rest.
pub fn curvature_figure(mesh: &RawMesh, values: &[f64]) -> Image {
    let bound = Summary::of(values.iter().map(|k| k.abs()).collect()).map_or(0.0, |s| s.p95);
    let bold = crease_edges(&mesh.points, &mesh.faces, BOLD_CREASE);
    let mut picture = Picture::new(&mesh.points, &mesh.faces);
    picture.colors = Colors::VertexScalars(values, Scale::Diverging(Some(if bound > 0.0 { bound } else { 1.0 })));
    picture.lines.push(Lines { width: 1.2, ..Lines::bold(Path::Edges(&bold)) });
    render(&picture)
}

/// Draws a skeleton through its surface.
pub fn skeleton_figure(surface: &SurfaceMesh, net: &CurveNet) -> Image {
    // One list of points for both: the nodes follow the vertices.
    let first = surface.vertex_count() as u32;
    let points: Vec<DVec3> = surface.points().iter().chain(&net.points).copied().collect();
    let edges: Vec<[u32; 2]> = net.edges.iter().map(|e| e.map(|v| first + v)).collect();
    let view = View::automatic(surface.points(), surface.faces());
    let none = Polygons::new();
    let mut inside = Picture { view, framed: &points, ..Picture::new(&points, &none) };
    inside.lines.push(Lines::new(Path::Edges(&edges), SKELETON, SKELETON_WIDTH));
    let outside = Picture { view, framed: &points, ..Picture::new(&points, surface.faces()) };
    render(&inside).behind(&render(&outside), VEIL)
}

/// Draws a hexahedral mesh: its boundary, and beside it the cells behind a plane through its middle, across its
/// thinnest extent. Colours are scaled Jacobians, dark blue at 0 to yellow at 1.
pub fn hex_figure(mesh: &HexMesh) -> Image {
    let low = mesh.points.iter().copied().fold(DVec3::INFINITY, DVec3::min);
    let high = mesh.points.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
    let size = high - low;
    let axis = [DVec3::X, DVec3::Y, DVec3::Z].into_iter().min_by(|a, b| a.dot(size).total_cmp(&b.dot(size)));
    let axis = axis.unwrap_or(DVec3::Z);
    let centre = |h: &[u32; 8]| h.iter().map(|&v| mesh.points[v as usize]).sum::<DVec3>() / 8.0;
    let middle = 0.5 * (low + high);
    let behind: Vec<[u32; 8]> = mesh.hexes.iter().filter(|h| (centre(h) - middle).dot(axis) <= 0.0).copied().collect();
    let view = View::automatic(&mesh.points, &mesh.quads.iter().map(|q| &q[..]).collect());
    let draw = |hexes: &[[u32; 8]]| {
        let outer = boundary_faces(hexes);
        let faces: Polygons = outer.iter().map(|(q, _)| &q[..]).collect();
        let quality: Vec<f64> =
            outer.iter().map(|&(_, h)| scaled_jacobian(&hexes[h as usize].map(|v| mesh.points[v as usize]))).collect();
        let edges =
            if faces.len() <= MOST_FACES_WITH_EDGES { mesh_edges(mesh.points.len(), &faces) } else { Vec::new() };
        let mut picture = Picture::new(&mesh.points, &faces);
        picture.colors = Colors::FaceScalars(&quality, Scale::Sequential(Some([0.0, 1.0])));
        picture.lines.push(Lines::fine(Path::Edges(&edges)));
        picture.view = view;
        render(&picture)
    };
    Image::beside(&[draw(&mesh.hexes), draw(&behind)], [255; 3])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::test_models::*;

    /// The curve lies where it is in the surface: in the middle of a tube that is drawn from aside, however short the curve.
    #[test]
    fn a_skeleton_is_drawn_where_it_is() {
        let points = vec![DVec3::new(0.3, 0.0, 0.0), DVec3::new(0.7, 0.0, 0.0)];
        let net = CurveNet { points, radii: vec![0.5; 2], edges: vec![[0, 1]], ids: vec![0, 1], notes: Vec::new() };
        let ball = sphere(4);
        let picture = skeleton_figure(&ball, &net);
        let width = picture.width() as usize;
        let middle = |is: &dyn Fn(&Rgb) -> bool| {
            let (mut sum, mut count) = ([0.0; 2], 0.0);
            for (k, _) in picture.pixels().iter().enumerate().filter(|(_, p)| is(p)) {
                sum = [sum[0] + (k % width) as f64, sum[1] + (k / width) as f64];
                count += 1.0;
            }
            [sum[0] / count, sum[1] / count, count]
        };
        let [x, y, area] = middle(&|p| p.iter().any(|&c| c < 245));
        let [u, v, _] = middle(&|p| p[0] > p[1].saturating_add(40));
        let radius = (area / std::f64::consts::PI).sqrt();
        // The middle of the curve is half a radius from that of the ball, foreshortened by the view.
        let off = (u - x).hypot(v - y) / radius;
        assert!((0.2..0.56).contains(&off), "{off}");
    }

    /// The curve shows through the surface.
    #[test]
    fn a_skeleton_is_drawn_inside_its_surface() {
        let points = vec![DVec3::new(-0.5, 0.0, 0.0), DVec3::new(0.5, 0.0, 0.0)];
        let net = CurveNet { points, radii: vec![0.5; 2], edges: vec![[0, 1]], ids: vec![0, 1], notes: Vec::new() };
        let picture = skeleton_figure(&sphere(3), &net);
        let count = |is: fn(&Rgb) -> bool| picture.pixels().iter().filter(|&p| is(p)).count();
        let (red, all) = (count(|p| p[0] > p[1].saturating_add(40)), picture.pixels().len());
        assert!(red > 500 && red < all / 20, "{red} of {all}");
        assert!(count(|p| p.iter().any(|&c| c < 245)) > all / 5);
    }
}
