//! Motorcycle graphs as cell complexes: counted again from their triangles and tags alone.

use super::*;
use crate::mesh::test_models::{cube, triangles};
use crate::mesh::{CornerId, DisjointSets, Topology};
use crate::sample;
use glam::{DMat3, DVec2};
use rustc_hash::FxHashMap;
use std::f64::consts::TAU;

fn part(name: &str) -> SurfaceMesh {
    sample::make(name, None, &Context::new()).unwrap()
}

fn graph_of(mesh: &SurfaceMesh, quads: usize) -> MotorcycleGraph {
    motorcycle_graph(mesh, &GraphOptions { quads, ..GraphOptions::default() }, &Context::new()).unwrap()
}

/// The quads of every start, sorted: inner ones and those on features.
fn starts(graph: &MotorcycleGraph) -> [Vec<u32>; 2] {
    [true, false].map(|inner| {
        let mut quads: Vec<u32> = graph.starts.iter().filter(|s| s.inner == inner).map(|s| s.quads).collect();
        quads.sort_unstable();
        quads
    })
}

/// The triangles between two circles of radii 1 and 2.
fn ring(sides: u32) -> SurfaceMesh {
    let circle =
        |r: f64| (0..sides).map(move |k| r * DVec2::from_angle(TAU * f64::from(k) / f64::from(sides)).extend(0.0));
    let points: Vec<DVec3> = circle(1.0).chain(circle(2.0)).collect();
    let faces = (0..sides).flat_map(|k| {
        let next = (k + 1) % sides;
        [[k, k + sides, next + sides], [k, next + sides, next]]
    });
    triangles(&points, &faces.collect::<Vec<_>>())
}

fn key(a: u32, b: u32) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

/// The tag of every marked edge.
fn tags(graph: &MotorcycleGraph) -> FxHashMap<[u32; 2], i32> {
    let tags: FxHashMap<_, _> =
        graph.mesh.tagged_edges.iter().map(|e| (key(e.ends[0].0, e.ends[1].0), e.tag)).collect();
    assert_eq!(tags.len(), graph.mesh.tagged_edges.len());
    tags
}

/// Patches and their Euler numbers from the triangles, cut open along all marked edges.
fn recounted(graph: &MotorcycleGraph) -> (Vec<u32>, Vec<i64>) {
    let (mesh, tags) = (&graph.mesh, tags(graph));
    let mut patches = DisjointSets::new(mesh.face_count());
    let mut fans = DisjointSets::new(mesh.corner_count());
    let corners = || (0..mesh.corner_count()).map(CornerId::new);
    let is_marked = |c: CornerId| tags.contains_key(&key(mesh.vertex(c).0, mesh.vertex(mesh.next(c)).0));
    for c in corners().filter(|&c| !is_marked(c)) {
        let o = mesh.opposite(c).expect("borders are marked");
        patches.union(mesh.face_of(c).0, mesh.face_of(o).0);
        fans.union(c.0, mesh.next(o).0);
    }
    let (patch, count) = patches.labels();
    let mut euler = vec![0; count];
    for c in corners() {
        let own = &mut euler[patch[mesh.face_of(c).index()] as usize];
        *own += i64::from(c.index() % 3 == 0);
        *own -= i64::from(is_marked(c) || mesh.opposite(c).is_some_and(|o| o.0 < c.0));
    }
    let (fan, fans) = fans.labels();
    let mut seen = vec![false; fans];
    for c in corners().filter(|c| !std::mem::replace(&mut seen[fan[c.index()] as usize], true)) {
        euler[patch[mesh.face_of(c).index()] as usize] += 1;
    }
    (patch, euler)
}

/// What every graph promises.
fn check(mesh: &SurfaceMesh, graph: &MotorcycleGraph) {
    let (had, has) = (Topology::of(mesh), Topology::of(&graph.mesh));
    assert_eq!((had.components, had.euler, had.boundary_loops), (has.components, has.euler, has.boundary_loops));
    assert_eq!(has.nonmanifold_edges + has.nonmanifold_vertices + has.inconsistent_edges, 0);
    check_patches(graph, has.euler);
    check_tracks(graph);
    check_starts(graph);
}

fn check_patches(graph: &MotorcycleGraph, euler: i64) {
    let (patch, count) = recounted(graph);
    assert_eq!(patch, graph.patch_of().iter().map(|&p| p as u32).collect::<Vec<_>>());
    assert_eq!(count, graph.patches.iter().map(|p| p.euler).collect::<Vec<_>>());
    // The surface from its cells; those that are no discs count with their Euler numbers.
    let cells = count.iter().sum::<i64>();
    assert_eq!(graph.nodes.len() as i64 - graph.arcs.len() as i64 + cells, euler);
    let area: f64 = graph.patches.iter().map(|p| p.area).sum();
    assert!(area > 0.0 && graph.patches.iter().all(|p| p.area > 0.0));
    // Singular vertices inside patches: those without any track.
    let mut inside = vec![0; graph.patches.len()];
    let tags = tags(graph);
    let marked: rustc_hash::FxHashSet<u32> = tags.keys().flatten().copied().collect();
    for start in graph.starts.iter().filter(|s| s.inner && !marked.contains(&s.vertex)) {
        let corner = graph.mesh.faces().corners().iter().position(|&v| v == start.vertex).unwrap();
        inside[patch[corner / 3] as usize] += 4 - start.quads as i32;
    }
    let mut used = vec![[0, 0]; graph.arcs.len()];
    for (p, inside) in graph.patches.iter().zip(inside) {
        let mut is_cut = false;
        for around in &p.loops {
            for (k, side) in around.iter().enumerate() {
                used[side.arc as usize][usize::from(side.reversed)] += 1;
                let [from, to] = ends(graph, side);
                let next = &around[(k + 1) % around.len()];
                assert_eq!(to, ends(graph, next)[0], "arcs around a patch join");
                assert!(side.quads >= 0 && from < graph.nodes.len() as u32);
                let arc = &graph.arcs[side.arc as usize];
                is_cut |= tags[&key(arc.vertices[0], arc.vertices[1])] == CUT;
            }
        }
        let sides = || p.loops.iter().flatten();
        assert_eq!(p.corners, sides().filter(|s| s.quads == 1).count());
        // The field turns around a patch as often as its Euler number and what is singular inside say.
        if !is_cut {
            let turns: i32 = sides().map(|s| 2 - s.quads).sum();
            assert_eq!(i64::from(turns + inside), 4 * p.euler);
        }
        if p.is_disc() {
            assert_eq!(p.sides().len(), p.corners.max(1));
            assert_eq!(p.sides().concat(), p.loops[0]);
        }
        if p.is_regular() {
            assert_eq!((p.corners, inside), (4, 0));
        }
    }
    // Every arc has a patch on both sides, on borders on one.
    for (arc, used) in graph.arcs.iter().zip(used) {
        assert!(used == [1, 1] || used.iter().sum::<i32>() == 1 && arc.track.is_none(), "{used:?}");
    }
}

/// The nodes that an arc runs between, as a patch sees it.
fn ends(graph: &MotorcycleGraph, side: &Side) -> [u32; 2] {
    let [a, b] = graph.arcs[side.arc as usize].nodes;
    if side.reversed { [b, a] } else { [a, b] }
}

fn check_tracks(graph: &MotorcycleGraph) {
    let mut tags = tags(graph);
    let on_feature: rustc_hash::FxHashSet<u32> = graph.edges(|t| t == FEATURE).into_iter().flatten().collect();
    let mut borders = rustc_hash::FxHashSet::default();
    for c in (0..graph.mesh.corner_count()).map(CornerId::new).filter(|&c| graph.mesh.opposite(c).is_none()) {
        borders.extend([graph.mesh.vertex(c).0, graph.mesh.vertex(graph.mesh.next(c)).0]);
    }
    let Some(Column::Label(singular)) = graph.mesh.attributes.vertex.get("singularity") else { panic!("no column") };
    let mut passed: FxHashMap<u32, usize> = FxHashMap::default();
    let mut ending: FxHashMap<u32, usize> = FxHashMap::default();
    for track in &graph.tracks {
        let list = &track.vertices;
        for w in list.windows(2) {
            let tag = tags.remove(&key(w[0], w[1])).expect("a track runs along marked edges, once");
            assert_eq!(tag, if track.kind == TrackKind::Shortcut { CUT } else { TRACK });
        }
        for &v in &list[1..list.len() - 1] {
            assert!(
                !on_feature.contains(&v) && singular[v as usize] == 0,
                "a track ends at features and singularities"
            );
            *passed.entry(v).or_default() += 1;
        }
        for (node, &v) in track.nodes.iter().zip([&list[0], &list[list.len() - 1]]) {
            assert_eq!(graph.nodes[*node as usize].vertex, v);
            *ending.entry(v).or_default() += 1;
        }
    }
    assert!(tags.values().all(|&tag| tag == FEATURE), "all tracks are told");
    for node in &graph.nodes {
        let v = node.vertex;
        let (passed, ending) = (passed.get(&v).copied().unwrap_or(0), ending.get(&v).copied().unwrap_or(0));
        match node.kind {
            NodeKind::Singularity => assert!(singular[v as usize] != 0 && passed == 0 && ending > 0),
            NodeKind::Track => assert!(singular[v as usize] == 0 && 2 * passed + ending > 2, "tracks end at others"),
            NodeKind::Border => assert!(borders.contains(&v)),
            NodeKind::Feature => assert!(on_feature.contains(&v) && !borders.contains(&v)),
            NodeKind::Corner => assert!(on_feature.contains(&v)),
        }
        let off = matches!(node.kind, NodeKind::Singularity | NodeKind::Track);
        assert!(off != on_feature.contains(&v));
    }
}

fn check_starts(graph: &MotorcycleGraph) {
    let Some(Column::Label(singular)) = graph.mesh.attributes.vertex.get("singularity") else { panic!("no column") };
    let mut ends: FxHashMap<u32, u32> = FxHashMap::default();
    for v in graph.tracks.iter().flat_map(|t| [t.vertices[0], t.vertices[t.vertices.len() - 1]]) {
        *ends.entry(v).or_default() += 1;
    }
    let inner = || graph.starts.iter().filter(|s| s.inner);
    assert_eq!(inner().count(), singular.iter().filter(|&&k| k != 0).count());
    for start in &graph.starts {
        assert!(start.tracks <= start.ways(), "{start:?}");
        let at = ends.get(&start.vertex).copied().unwrap_or(0);
        if start.inner {
            assert_eq!((start.quads as i32, start.tracks), (singular[start.vertex as usize], at));
        } else {
            assert!(start.quads > 2 && start.tracks <= at);
        }
    }
}

#[test]
fn graphs_are_cell_complexes_whose_tracks_end_where_they_say() {
    for name in ["bracket", "wedge"] {
        let mesh = part(name);
        for quads in [500, 3000] {
            let graph = graph_of(&mesh, quads);
            check(&mesh, &graph);
        }
    }
}

#[test]
fn a_box_has_no_tracks() {
    let graph = graph_of(&cube(DVec3::ZERO, 2.0), 600);
    check(&cube(DVec3::ZERO, 2.0), &graph);
    assert_eq!((graph.nodes.len(), graph.arcs.len(), graph.patches.len()), (8, 12, 6));
    assert!(graph.tracks.is_empty() && graph.starts.is_empty() && graph.patches.iter().all(Patch::is_regular));
}

#[test]
fn a_ring_is_cut_once() {
    let mesh = ring(48);
    let graph = graph_of(&mesh, 400);
    check(&mesh, &graph);
    let [track] = &graph.tracks[..] else { panic!("{:?}", graph.tracks) };
    assert_eq!(track.kind, TrackKind::Cut);
    assert!(graph.starts.is_empty() && graph.patches.len() == 1 && graph.patches[0].is_regular());
}

#[test]
fn what_is_singular_on_closed_surfaces_adds_up() {
    // All around a surface the quads lack four times its Euler number.
    for (name, lacking) in [("icosphere", 8), ("torus", 0)] {
        let graph = graph_of(&part(name), 500);
        let lack: i32 = graph.starts.iter().map(|s| 4 - s.quads as i32).sum();
        assert_eq!(lack, lacking, "{name}");
        assert!(graph.patches.iter().all(Patch::is_disc), "{name}");
    }
}

#[test]
fn nearly_every_way_of_every_start_is_taken_on_plain_parts() {
    for name in ["bracket", "wedge", "cube-cylinders"] {
        let graph = graph_of(&part(name), 1500);
        assert!(!graph.starts.is_empty(), "{name}");
        let [taken, ways] =
            [|s: &Start| s.tracks, |s: &Start| s.ways()].map(|of| graph.starts.iter().map(of).sum::<u32>());
        // Two tracks that would run side by side are one.
        assert!(20 * taken >= 19 * ways, "{name}: {:?}", graph.starts);
    }
}

#[test]
fn vertices_lie_on_the_part() {
    let mesh = part("bracket");
    let graph = graph_of(&mesh, 1500);
    let faces: Vec<[u32; 3]> = mesh.faces().iter().map(|f| [f[0], f[1], f[2]]).collect();
    let tree = crate::geometry::search_tree::TriangleTree::new(mesh.points(), &faces);
    let far = graph.mesh.points().iter().filter_map(|&p| tree.closest(p)).map(|c| c.distance_squared.sqrt());
    assert!(far.fold(0.0, f64::max) < 1e-3 * mesh.diagonal());
}

#[test]
fn the_same_for_any_number_of_threads_and_in_any_place() {
    let mesh = part("bracket");
    let of = |threads: usize| {
        let context = Context::new().with_threads(threads).unwrap();
        context.install(|| motorcycle_graph(&mesh, &GraphOptions::default(), &context)).unwrap().layout()
    };
    assert_eq!(of(1), of(2));
    let turn = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, -0.5).normalize(), 0.7);
    let place = |p: &DVec3| 3.0 * (turn * *p) + DVec3::new(40.0, -7.0, 300.0);
    let moved = SurfaceMesh::new(mesh.points().iter().map(place).collect(), mesh.faces().clone()).unwrap();
    let [here, there] = [&mesh, &moved].map(|mesh| graph_of(mesh, 3000));
    check(&moved, &there);
    // Where tracks meet at a grazing angle, rounding decides which of them is taken back; where they start it does not.
    assert_eq!(starts(&here), starts(&there));
    assert!(here.patches.len().abs_diff(there.patches.len()) <= here.patches.len() / 10);
}

#[test]
fn wrong_options_and_meshes_are_refused() {
    let of = |mesh: &SurfaceMesh, options: GraphOptions| motorcycle_graph(mesh, &options, &Context::new());
    let mesh = part("wedge");
    let none = GraphOptions { quads: 0, ..GraphOptions::default() };
    assert!(matches!(of(&mesh, none), Err(Error::Options(_))));
    let flat = GraphOptions { edge_length: Some(0.0), ..GraphOptions::default() };
    assert!(matches!(of(&mesh, flat), Err(Error::Options(_))));
    let empty = triangles(&[DVec3::ZERO], &[]);
    assert!(matches!(of(&empty, GraphOptions::default()), Err(Error::Input { .. })));
}
