//! Random operations on small meshes keep every promise of the structure.

use super::*;
use crate::mesh::surface::SurfaceMesh;
use crate::mesh::test_models::*;
use crate::mesh::triangles::NONE;
use crate::mesh::{CornerId, Topology};
use glam::DVec3;
use proptest::prelude::*;

/// Every invariant of the structure.
fn check(mesh: &EditMesh) {
    let (mut triangles, mut vertices) = (0, 0);
    for t in (0..mesh.triangle_slots()).filter(|&t| mesh.is_triangle(t)) {
        triangles += 1;
        let [a, b, c] = mesh.triangle(t);
        assert!(a != b && b != c && c != a);
        for h in 3 * t..3 * t + 3 {
            assert!(mesh.is_vertex(mesh.vertex(h)));
            let o = mesh.opposite(h);
            if o != NONE {
                assert_eq!((mesh.opposite(o), mesh.vertex(o), mesh.head(o)), (h, mesh.head(h), mesh.vertex(h)));
                assert_eq!(mesh.curve(o), mesh.curve(h));
            }
        }
    }
    let mut corners = 0;
    for v in (0..mesh.vertex_slots()).filter(|&v| mesh.is_vertex(v)) {
        vertices += 1;
        let around: Vec<u32> = mesh.around(v).collect();
        assert!(around.iter().all(|&h| mesh.vertex(h) == v));
        assert!(around.iter().skip(1).all(|&h| mesh.opposite(h) != NONE));
        let mut neighbours = Vec::new();
        mesh.for_neighbours(v, |n| neighbours.push(n));
        neighbours.sort_unstable();
        // A slit, cut along an edge that was not manifold, has two sides with the same ends.
        let slits = neighbours.windows(2).filter(|w| w[0] == w[1] && mesh.is_copy(v) && mesh.is_copy(w[0])).count();
        neighbours.dedup();
        assert_eq!(neighbours.len() + slits, mesh.valence(v), "an edge twice at {v}");
        // Between two curves all corners share a wedge.
        for w in around.windows(2) {
            assert!(mesh.curve(w[1]) != NONE || mesh.wedge(w[0]) == mesh.wedge(w[1]));
        }
        corners += around.len();
    }
    assert_eq!((triangles, vertices), (mesh.triangle_count(), mesh.vertex_count()));
    assert_eq!(corners, 3 * triangles, "every corner is reached from its vertex");
}

/// The mesh with each border on a curve, and one wedge per vertex.
fn editable(mesh: &SurfaceMesh) -> EditMesh {
    let mut edit = EditMesh::new(mesh).unwrap();
    for h in 0..edit.half_edge_slots() {
        if edit.opposite(h) == NONE {
            edit.set_curve(h, 0);
        }
        edit.set_wedge(h, edit.vertex(h));
    }
    edit
}

fn surface(mesh: &EditMesh) -> SurfaceMesh {
    let compact = mesh.compact();
    let points: Vec<DVec3> = compact.vertices.iter().map(|&v| mesh.points[v as usize]).collect();
    triangles(&points, &compact.faces)
}

/// Counts that no operation may change.
fn invariants(mesh: &SurfaceMesh) -> (i64, usize, usize, Option<usize>, bool) {
    let t = Topology::of(mesh);
    assert!(t.manifold && t.consistently_oriented && t.duplicate_faces == 0);
    (t.euler, t.components, t.boundary_loops, t.genus, t.closed)
}

/// Tries an operation on a half-edge: nothing happens where it is not allowed.
fn operate(mesh: &mut EditMesh, kind: u8, pick: u32) {
    let h = pick % mesh.half_edge_slots();
    if !mesh.is_half_edge(h) {
        return;
    }
    let keep = if kind == 0 { Keep::Head } else { Keep::Tail };
    match kind {
        0 | 1 if mesh.check_collapse(h).is_ok() => {
            let (gone, kept) = mesh.gone_and_kept(h, keep);
            // A border vertex goes along the border only.
            if !mesh.is_border(gone) || mesh.curve(h) != NONE {
                let before = (mesh.triangle_count(), mesh.valence(gone));
                mesh.collapse(h, keep);
                assert!(!mesh.is_vertex(gone) && mesh.is_vertex(kept) && before.0 > mesh.triangle_count());
            }
        }
        2 if mesh.can_flip(h) => {
            let ends = [mesh.apex(h), mesh.apex(mesh.opposite(h))];
            mesh.flip(h);
            assert_eq!([mesh.vertex(h), mesh.head(h)], ends);
        }
        3 => {
            let middle = 0.5 * (mesh.points[mesh.vertex(h) as usize] + mesh.points[mesh.head(h) as usize]);
            let wedge = mesh.vertex_slots();
            let m = mesh.split(h, middle, [wedge; 2]);
            assert_eq!((mesh.head(h), m), (m, wedge));
        }
        _ => {}
    }
}

fn models() -> Vec<SurfaceMesh> {
    let single = triangles(&[DVec3::ZERO, DVec3::X, DVec3::Y], &[[0, 1, 2]]);
    let all = [tetrahedron(), torus(5, 4), grid(4), sphere(1), strip(7, 0), strip(7, 1), single];
    all.into_iter().map(|mesh| mesh.triangulated().unwrap()).collect()
}

proptest! {
    #[test]
    fn operations_keep_structure_and_topology(model in 0usize..7, steps in prop::collection::vec((0u8..4, any::<u32>()), 1..120)) {
        let mesh = models().swap_remove(model);
        let mut edit = editable(&mesh);
        check(&edit);
        // A Möbius strip is cut open: what counts is the mesh as it was when editing began.
        let before = invariants(&surface(&edit));
        for (kind, pick) in steps {
            operate(&mut edit, kind, pick);
            check(&edit);
        }
        prop_assert_eq!(invariants(&surface(&edit)), before);
    }

    #[test]
    fn a_flip_undoes_itself_and_a_collapse_undoes_a_split(pick in any::<u32>()) {
        let mut edit = editable(&torus(6, 5).triangulated().unwrap());
        let before = surface(&edit);
        let h = pick % edit.half_edge_slots();
        let m = edit.split(h, DVec3::ZERO, [edit.vertex_slots(); 2]);
        let half = edit.half_edge(m, edit.vertex(h)).unwrap();
        prop_assert!(edit.check_collapse(half).is_ok());
        // The new vertex goes back into the head of the edge that was split.
        let back = edit.around(m).find(|&g| edit.head(g) != edit.vertex(h) && edit.half_edge(edit.vertex(h), edit.head(g)).is_none());
        edit.collapse(back.unwrap(), Keep::Head);
        if edit.can_flip(h) {
            (0..4).for_each(|_| edit.flip(h));
        }
        check(&edit);
        prop_assert_eq!(sorted(&surface(&edit)), sorted(&before));
    }
}

/// Triangles as sorted vertex triples.
fn sorted(mesh: &SurfaceMesh) -> Vec<Vec<u32>> {
    let mut faces: Vec<Vec<u32>> = mesh.faces().iter().map(|f| f.to_vec()).collect();
    faces.iter_mut().for_each(|f| f.sort_unstable());
    faces.sort_unstable();
    faces
}

#[test]
fn meshes_without_a_spare_triangle_refuse_to_collapse() {
    for mesh in [tetrahedron(), triangles(&[DVec3::ZERO, DVec3::X, DVec3::Y], &[[0, 1, 2]])] {
        let edit = editable(&mesh);
        assert!(edit.edges().all(|h| edit.check_collapse(h) == Err(CollapseError::Apex)));
    }
}

#[test]
fn borders_are_not_pinched() {
    // A band of quads: every inner edge joins the two borders.
    let edit = editable(&strip(9, 0).triangulated().unwrap());
    for h in edit.edges() {
        let inner = edit.opposite(h) != NONE;
        assert_eq!(edit.check_collapse(h) == Err(CollapseError::Pinch), inner, "{h}");
    }
}

#[test]
fn irregular_vertices_are_cut_into_fans() {
    for (mesh, copies) in [(cubes_sharing_an_edge(), 2), (cubes_sharing_a_vertex(), 1)] {
        let mesh = mesh.triangulated().unwrap();
        let edit = editable(&mesh);
        check(&edit);
        let used = Topology::of(&mesh);
        assert_eq!(edit.vertex_count() - (used.vertices - used.unreferenced_vertices), copies);
        for v in 0..edit.vertex_slots() {
            assert_eq!(edit.points[v as usize], mesh.points()[edit.origin[v as usize] as usize]);
        }
        let same = |h: u32| edit.origin[edit.vertex(h) as usize] == mesh.vertex(CornerId(h)).0;
        assert!((0..edit.half_edge_slots()).all(same));
    }
}

#[test]
fn wedges_follow_their_side_of_a_curve() {
    // A row of squares left and right of a straight curve.
    let mesh = grid(4);
    let mut edit = editable(&mesh);
    let on_curve = |p: DVec3| (p.x - 2.0).abs() < 1e-9;
    let ridge: Vec<u32> = edit
        .edges()
        .filter(|&h| [edit.vertex(h), edit.head(h)].iter().all(|&v| on_curve(edit.points[v as usize])))
        .collect();
    ridge.iter().for_each(|&h| edit.set_curve(h, 1));
    for h in 0..edit.half_edge_slots() {
        let centre = edit.positions(h / 3).iter().sum::<DVec3>() / 3.0;
        edit.set_wedge(h, u32::from(centre.x > 2.0));
    }
    let middle = ridge.into_iter().find(|&h| !edit.is_border(edit.vertex(h)) && !edit.is_border(edit.head(h)));
    edit.collapse(middle.unwrap(), Keep::Head);
    for h in (0..edit.half_edge_slots()).filter(|&h| edit.is_half_edge(h)) {
        let centre = edit.positions(h / 3).iter().sum::<DVec3>() / 3.0;
        assert_eq!(edit.wedge(h), u32::from(centre.x > 2.0));
    }
    check(&edit);
}

/// A slit that ends at a vertex without copies: its two sides must not become edges with the same ends.
///
/// ```text
///        t                 v: two copies, one on each side
///      ╱ │ ╲
///     v──x──u──r           the slit is v x u y
///     v──y──u──r
///      ╲ │ ╱
///        b
/// ```
#[test]
fn slits_stay_open() {
    let points = [[0.0, 0.0], [1.0, 0.1], [1.0, -0.1], [2.0, 0.0], [3.0, 0.0], [1.0, 1.0], [1.0, -1.0]];
    let [v, x, y, u, r, t, b] = [0, 1, 2, 3, 4, 5, 6];
    let triangles = [[v, x, t], [x, u, t], [y, v, b], [u, y, b], [u, r, t], [r, u, b]];
    let points = points.iter().map(|p| DVec3::new(p[0], p[1], 0.0)).collect();
    let mut mesh = editable(&SurfaceMesh::from_triangles(points, &triangles).unwrap());
    let onto_u = |mesh: &EditMesh, gone: u32| {
        let h = mesh.half_edge(gone, u).or(mesh.half_edge(u, gone)).unwrap();
        let keep = if mesh.gone_and_kept(h, Keep::Head).0 == gone { Keep::Head } else { Keep::Tail };
        (h, keep)
    };
    assert!((0..mesh.vertex_slots()).filter(|&w| mesh.origin[w as usize] == v).count() == 2);
    let (h, keep) = onto_u(&mesh, x);
    assert!(!mesh.joins_copies(h, keep));
    mesh.collapse(h, keep);
    let (h, keep) = onto_u(&mesh, y);
    assert!(mesh.joins_copies(h, keep));
}
