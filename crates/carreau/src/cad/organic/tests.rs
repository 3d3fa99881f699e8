//! Organic models as a whole, and the surface that they are made of.

use super::*;
use crate::brep::Surface;
use crate::cad::{Style, rebuild};
use crate::mesh::test_models::{grid, moved, sphere, together, torus};
use crate::mesh::{TaggedEdge, VertexId};
use counts::{EDGES_A_HOLE, around_holes};
use feet::{find_first_feet, own};

/// A cube of quads, each side in n × n.
fn cage(n: u32) -> (Vec<DVec3>, Vec<[u32; 4]>) {
    let mut points: Vec<DVec3> = Vec::new();
    let mut id = |p: [u32; 3]| {
        let p = DVec3::from(p.map(f64::from)) / f64::from(n);
        points.iter().position(|&q| q == p).unwrap_or_else(|| {
            points.push(p);
            points.len() - 1
        }) as u32
    };
    let mut quads = Vec::new();
    for axis in 0..3 {
        for far in [0, n] {
            for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
                let mut at = |i: u32, j: u32| {
                    let mut p = [0; 3];
                    (p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) = (far, i, j);
                    id(p)
                };
                let quad = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                quads.push(if far == n { quad } else { [quad[0], quad[3], quad[2], quad[1]] });
            }
        }
    }
    (points, quads)
}

#[test]
fn a_cube_has_six_blocks_and_its_faces_are_the_limit_surface() {
    let context = Context::new();
    for n in [2u32, 3, 5] {
        let (points, quads) = cage(n);
        let net = Net::new(&points, quads, &[]).unwrap();
        let mut walls = Walls::new(&net, &points, &context).unwrap();
        let found = blocks(&net, &mut walls, &context).unwrap();
        assert!(found.len() == 6 && found.iter().all(|b| b.size == [n as usize; 2]), "{n}");
        let surface = Limit::new(&net, &points, GRADES[0] + 2);
        for block in &found {
            let face = sheet(&net, block, &surface, GRADES[0]).unwrap();
            let [u, v] = face.knots.clone();
            let spline = crate::geometry::bspline::BSplineSurface::new(u, v, face.points.clone()).unwrap();
            for k in 0..200u32 {
                // Anywhere but in the first cells of the corners.
                let [u, v] = [k * 37 % 199, k * 61 % 193].map(|x| f64::from(x) / 199.0 * f64::from(n));
                if [u, v].iter().all(|x| x.min(f64::from(n) - x) < 0.13) {
                    continue;
                }
                let (part, quarter, quad) = control::part_at(block, u, v);
                let at = control::to_part(quarter, [u - quad[0], v - quad[1]]);
                let off = spline.point(u, v).distance(surface.piece(part, at).point(at));
                assert!(off < 1e-12, "{n}: {off} at {u}, {v}");
            }
        }
    }
}

/// Quads as a mesh, with points moved.
fn quads_of((points, quads): (Vec<DVec3>, Vec<[u32; 4]>), place: impl Fn(DVec3) -> DVec3) -> SurfaceMesh {
    SurfaceMesh::new(points.into_iter().map(place).collect(), quads.iter().map(|q| &q[..]).collect()).unwrap()
}

/// A cube blown up to an ellipsoid.
fn blown_up(p: DVec3) -> DVec3 {
    (p - 0.5).normalize() * DVec3::new(1.3, 1.0, 0.8)
}

fn ellipsoid() -> SurfaceMesh {
    moved(&sphere(4), |p| p * DVec3::new(1.3, 1.0, 0.8))
}

fn asked(tolerance: f64) -> Asked {
    Asked { tolerance, most_divided: MOST_DIVIDED, is_strict: false }
}

fn model_over(mesh: &SurfaceMesh, quads: &SurfaceMesh) -> CadModel {
    over(mesh, quads, asked(1e-3 * mesh.diagonal()), &Context::new()).unwrap()
}

/// Faces that are what every system takes as smooth, and near the scan.
fn check_smooth(model: &CadModel, mesh: &SurfaceMesh) {
    let smooth = model.smooth.as_ref().unwrap();
    assert!(smooth.angles.max < 0.1, "{:?}", smooth.angles);
    assert!(model.brep.surfaces.iter().all(|s| matches!(s, Surface::Spline(_))));
    assert!(model.warnings.is_empty() && model.distance_max < 1e-3 * mesh.diagonal(), "{}", model.distance_max);
    assert!(model.distance_rms < 1e-4 * mesh.diagonal(), "{}", model.distance_rms);
    assert!(model.brep.tolerance() == 0.0);
}

#[test]
fn an_ellipsoid_over_a_cube_has_six_faces_and_its_volume() {
    let mesh = ellipsoid();
    let model = model_over(&mesh, &quads_of(cage(4), blown_up));
    check_smooth(&model, &mesh);
    assert_eq!((model.brep.faces.len(), model.brep.edges.len(), model.brep.vertices.len()), (6, 12, 8));
    assert_eq!((model.brep.solids.len(), model.brep.free_shells().len()), (1, 0));
    let volume = 4.0 / 3.0 * std::f64::consts::PI * 1.3 * 0.8;
    assert!((model.volume / volume - 1.0).abs() < 2e-3, "{} of {volume}", model.volume);
}

#[test]
fn any_number_of_threads_makes_the_same_model() {
    let (mesh, quads) = (ellipsoid(), quads_of(cage(3), blown_up));
    let made = |threads: usize| {
        let context = Context::new().with_threads(threads).unwrap();
        context.install(|| over(&mesh, &quads, asked(1e-2), &context)).unwrap().brep
    };
    assert!(made(1) == made(3));
}

#[test]
fn every_body_is_a_solid() {
    let away = |p: DVec3| p + DVec3::new(5.0, 0.5, 0.0);
    let mesh = together(&[ellipsoid(), moved(&ellipsoid(), away)]);
    let quads = quads_of(cage(4), blown_up);
    let model = model_over(&mesh, &together(&[quads.clone(), moved(&quads, away)]));
    check_smooth(&model, &mesh);
    assert_eq!((model.brep.faces.len(), model.brep.solids.len()), (12, 2));
}

#[test]
fn a_torus_of_regular_quads_is_cut_into_blocks() {
    let (n, m) = (12, 8);
    let mesh = torus(48, 32);
    let quads: Vec<[u32; 4]> = (0..n * m)
        .map(|k| {
            let at = |i: u32, j: u32| (k / m + i) % n * m + (k % m + j) % m;
            [at(0, 0), at(1, 0), at(1, 1), at(0, 1)]
        })
        .collect();
    let quads = quads_of((torus(n, m).points().to_vec(), quads), |p| p);
    let model = model_over(&mesh, &quads);
    check_smooth(&model, &mesh);
    assert_eq!(model.brep.solids.len(), 1);
    assert!(model.brep.faces.len() <= 4, "{}", model.brep.faces.len());
    assert!((model.volume / (2.0 * std::f64::consts::PI.powi(2) * 2.0 * 0.25) - 1.0).abs() < 5e-3, "{}", model.volume);
}

#[test]
fn an_open_surface_is_a_shell() {
    let bent = |p: DVec3| DVec3::new(p.x, p.y, 0.1 * p.x * p.y - 0.05 * p.y * p.y);
    let mesh = moved(&grid(24), |p| bent(p / 6.0));
    let n = 5;
    let quads = (0..n * n).map(|k| [k + k / n, k + k / n + n + 1, k + k / n + n + 2, k + k / n + 1]).collect();
    let quads = quads_of((grid(n).points().to_vec(), quads), |p| bent(0.8 * p));
    let model = model_over(&mesh, &quads);
    check_smooth(&model, &mesh);
    assert_eq!((model.brep.faces.len(), model.brep.solids.len(), model.brep.free_shells().len()), (1, 0, 1));
}

#[test]
fn creases_stay_edges() {
    let mesh = quads_of(cage(8), |p| p).triangulated().unwrap();
    let mut quads = quads_of(cage(4), |p| p);
    let flat = |p: DVec3| [p.x, p.y, p.z].iter().filter(|&&x| x == 0.0 || x == 1.0).count();
    let points = quads.points().to_vec();
    for f in quads.faces().clone().iter() {
        for k in 0..4 {
            let ends = [f[k], f[(k + 1) % 4]];
            let middle = 0.5 * (points[ends[0] as usize] + points[ends[1] as usize]);
            if flat(middle) == 2 {
                quads.tagged_edges.push(TaggedEdge { ends: ends.map(VertexId), tag: 1 });
            }
        }
    }
    let model = model_over(&mesh, &quads);
    assert_eq!((model.brep.faces.len(), model.brep.edges.len(), model.brep.solids.len()), (6, 12, 1));
    assert!(model.distance_max < 1e-6 && (model.volume - 1.0).abs() < 1e-5, "{} {}", model.distance_max, model.volume);
}

#[test]
fn a_scan_becomes_a_solid() {
    let mesh = moved(&sphere(2), |p| DVec3::new(1.3, 1.0, 0.8) * p + DVec3::new(5.0, 0.0, 1.0));
    let options = CadOptions { style: Style::Organic, ..CadOptions::default() };
    let model = rebuild(&mesh, &options, &Context::new()).unwrap();
    assert_eq!((model.brep.solids.len(), model.brep.free_shells().len()), (1, 0));
    assert!(model.smooth.as_ref().unwrap().angles.max < 0.5, "{:?}", model.smooth);
    assert!(model.distance_max < 1e-3 * mesh.diagonal(), "{}", model.distance_max);
    assert_eq!(model.face_of_triangle.len(), mesh.face_count());
    let few = CadOptions { max_faces: Some(3), ..options };
    assert!(matches!(rebuild(&mesh, &few, &Context::new()), Err(Error::Numeric(_))));
}

#[test]
fn a_foot_is_on_the_side_of_a_thin_part_that_looks_the_same_way() {
    let (points, quads) = cage(2);
    let points: Vec<DVec3> = points.into_iter().map(|p| p * DVec3::new(1.0, 1.0, 0.01)).collect();
    let net = Net::new(&points, quads, &[]).unwrap();
    // Nearer to the bottom than to the top.
    let scan = moved(&grid(1), |p| DVec3::new(0.2 + 0.1 * p.x, 0.3 + 0.1 * p.y, 0.002));
    let mut samples = Scan::new(&scan).vertices();
    for turned in [1.0, -1.0] {
        samples.iter_mut().for_each(|s| s.normal *= turned);
        find_first_feet(&mut samples, &net, &points, &Context::new()).unwrap();
        let side = if samples[0].normal.z > 0.0 { 0.01 } else { 0.0 };
        for sample in &samples {
            let quad = net.quads[sample.part as usize / 4];
            assert!(quad.iter().all(|&v| points[v as usize].z == side), "{sample:?}");
        }
    }
}

#[test]
fn control_points_are_evened_out_along_the_surface() {
    let n = 6;
    let quads: Vec<[u32; 4]> =
        (0..n * n).map(|k| [k + k / n, k + k / n + 1, k + k / n + n + 2, k + k / n + n + 1]).collect();
    // A strip drawn together within a tilted plane.
    let uneven = |p: DVec3| DVec3::new(if p.x == 3.0 { 2.05 } else { p.x }, p.y, 0.5 * p.y);
    let first: Vec<DVec3> = grid(n).points().iter().map(|&p| uneven(p)).collect();
    let net = Net::new(&first, quads, &[]).unwrap();
    let mut points = first.clone();
    relax::relax(&net, &mut points);
    let narrowest = |points: &[DVec3]| {
        let ends = net.ends.iter().map(|e| e.map(|v| points[v as usize]));
        let along = ends.filter(|[a, b]| (a.y - b.y).abs() < 1e-9);
        along.map(|[a, b]| (a.x - b.x).abs()).fold(f64::INFINITY, f64::min)
    };
    assert!(narrowest(&first) < 0.06 && narrowest(&points) > 0.3, "{}", narrowest(&points));
    assert!(points.iter().all(|p| (p.z - 0.5 * p.y).abs() < 1e-12));
    let borders = |p: &DVec3| [p.x, p.y].map(|x| x.abs() < 1e-12 || (x - f64::from(n)).abs() < 1e-12);
    assert!(first.iter().zip(&points).all(|(a, b)| borders(a) == borders(b)));
}

#[test]
fn a_surface_that_is_turned_over_unfolds() {
    let context = Context::new();
    let mesh = ellipsoid();
    let (points, quads) = cage(12);
    let points: Vec<DVec3> = points.into_iter().map(blown_up).collect();
    let net = Net::new(&points, quads, &[]).unwrap();
    // Around the pole the control points are on the other side of it: closest points keep them there.
    let is_near = |p: &DVec3| p.z > 0.0 && p.truncate().length() < 0.4 * p.length();
    let mut points: Vec<DVec3> =
        points.into_iter().map(|p| if is_near(&p) { p * DVec3::new(-1.0, -1.0, 1.0) } else { p }).collect();
    let scan = Scan::new(&mesh);
    let mut vertices = scan.fitted(&mesh);
    let mut fitting = Fitting::new(&net, &scan, &context);
    let turned = |points: &[DVec3]| {
        let surface = Limit::new(&net, points, fit::FIT_LEVELS);
        own(&net, &surface, points, &scan, &context).unwrap().1.len()
    };
    assert!(turned(&points) > 0);
    fitting.unfold(&mut points, &mut vertices).unwrap();
    assert_eq!(turned(&points), 0);
}

#[test]
fn there_are_quads_enough_to_go_around_the_smallest_hole() {
    let whole = grid(30);
    let is_inside = |f: &[u32]| {
        let middle = f.iter().map(|&v| whole.points()[v as usize]).sum::<DVec3>() / f.len() as f64;
        middle.x > 14.0 && middle.x < 16.0 && middle.y > 14.0 && middle.y < 16.0
    };
    let kept: Vec<[u32; 3]> = whole.faces().iter().filter(|f| !is_inside(f)).map(|f| f.try_into().unwrap()).collect();
    let open = SurfaceMesh::from_triangles(whole.points().to_vec(), &kept).unwrap();
    // Around it are eight sides of the cells, of which there are 900 less four.
    assert_eq!(around_holes(&open), (896.0 * (EDGES_A_HOLE / 8.0).powi(2)) as usize);
    assert_eq!(around_holes(&sphere(1)), 0);
}

/// Quads of a plane of n × n, with edges along its middle tagged that are so many steps from its lower border, at most.
fn creased(n: u32, steps: u32, place: impl Fn(DVec3) -> DVec3) -> SurfaceMesh {
    let row = n + 1;
    let quads = (0..n * n).map(|k| k % n + k / n * row);
    let quads: Vec<Vec<u32>> = quads.map(|k| vec![k, k + 1, k + row + 1, k + row]).collect();
    let points = grid(n).points().iter().map(|&p| place(p)).collect();
    let mut mesh = SurfaceMesh::new(points, quads.iter().map(Vec::as_slice).collect()).unwrap();
    let edge = |j: u32| [n / 2 + j * row, n / 2 + (j + 1) * row].map(VertexId);
    mesh.tagged_edges = (0..steps).map(|j| TaggedEdge { ends: edge(j), tag: 1 }).collect();
    mesh
}

#[test]
fn faces_meet_smoothly_where_a_crease_ends() {
    let context = Context::new();
    let n = 8;
    for steps in [2, 4, 5] {
        // A roof that flattens to the end of its ridge, on uneven quads.
        let roof = |p: DVec3| {
            let [dx, dy] = [(3.0 * p.y).sin(), (2.0 * p.x).sin()].map(|d| 0.1 * d * f64::from(u8::from(p.x != 4.0)));
            let slope = 0.3 * (f64::from(steps) - p.y).max(0.0) / f64::from(steps);
            DVec3::new(p.x + dx, p.y + dy, -slope * (p.x - 4.0).abs() + 0.02 * p.x * p.y)
        };
        let mut cage = Cage::new(&creased(n, steps, roof), &context).unwrap();
        for division in 0..2 {
            let blocks = blocks(&cage.net, &mut cage.walls, &context).unwrap();
            let layout = layout(&cage.net, &cage.walls, &blocks).unwrap();
            let sheets = faces(&cage, &blocks, &context).unwrap();
            let brep = assemble::assemble(&cage.net, &blocks, &layout, &sheets).unwrap();
            let angles = measure::angles(&cage.net, &blocks, &layout, &sheets, &brep);
            assert!(angles.max < KINK_DEGREES, "{steps} steps, {division} divisions: {angles:?}");
            cage = cage.divided().unwrap();
        }
    }
}

#[test]
fn what_the_fit_bends_is_no_new_corner_after_a_division() {
    let context = Context::new();
    let mut cage = Cage::new(&creased(6, 6, |p| p), &context).unwrap();
    let before = cage.net.role.clone();
    // The border and the crease, bent by more than a right angle.
    for v in [3, 7 * 3 + 3, 7 * 6 + 2] {
        cage.points[v] += DVec3::new(0.0, 2.0, 3.0);
    }
    let divided = cage.divided().unwrap();
    assert_eq!(divided.net.role[..before.len()], before);
    // No block runs past an irregular vertex.
    let mut walls = divided.walls;
    let net = &divided.net;
    for block in blocks(net, &mut walls, &context).unwrap() {
        for h in (0..4).flat_map(|s| block.side(s).split_off(1)) {
            assert!(net.is_regular(&net.fans[net.fan_of[h as usize] as usize]), "{h}");
        }
    }
}
