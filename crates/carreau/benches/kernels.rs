//! Kernels by themselves: `cargo bench -p carreau`. What a user waits for, beside peers, is measured by `bench/`.

// Panics are how a benchmark fails.
#![allow(clippy::unwrap_used, missing_docs)]

use carreau::geometry::curvature::{CurvatureOptions, curvature};
use carreau::geometry::search_tree::TriangleTree;
use carreau::mesh::{CurveNet, Triangles};
use carreau::{Context, DVec3, field, hex, sample};
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use std::hint::black_box;

/// A binary tree: every branch has `steps` segments, and divides `levels` times by half an angle of 35° about its direction.
fn tree(levels: usize, steps: usize) -> CurveNet {
    let (mut points, mut radii, mut edges) = (vec![DVec3::ZERO], vec![1.0], Vec::new());
    let mut open = vec![(0u32, DVec3::Z, DVec3::X, 1.0)];
    for _ in 0..=levels {
        let mut next = Vec::new();
        for (start, direction, across, radius) in open {
            let mut last = start;
            for _ in 0..steps {
                points.push(points[last as usize] + direction * 2.0 * radius);
                radii.push(radius);
                edges.push([last, points.len() as u32 - 1]);
                last = points.len() as u32 - 1;
            }
            let (sin, cos) = 35f64.to_radians().sin_cos();
            for side in [sin, -sin] {
                let turned = direction * cos + across * side;
                next.push((last, turned, direction.cross(across), 0.8 * radius));
            }
        }
        open = next;
    }
    CurveNet::new(points, radii, edges)
}

fn base_mesh(c: &mut Criterion) {
    let mut group = c.benchmark_group("hex base mesh");
    for (levels, steps) in [(10, 8), (13, 8), (13, 1)] {
        let net = tree(levels, steps);
        group.throughput(Throughput::Elements(hex::base_mesh(&net).hexes.len() as u64));
        let name = format!("tree of {} segments, a branch", net.edges.len());
        group.bench_with_input(BenchmarkId::new(name, steps), &net, |b, net| {
            b.iter(|| hex::base_mesh(black_box(net)));
        });
    }
}

fn surfaces(c: &mut Criterion) {
    let context = Context::new();
    let mesh = sample::make("bracket", None, &context).unwrap();
    let triangles = Triangles::of(&mesh).unwrap();
    let faces = mesh.faces().fan().0;
    let tree = TriangleTree::new(mesh.points(), &faces);
    let far: Vec<DVec3> = mesh.points().iter().map(|p| *p * 1.01).collect();
    let mut group = c.benchmark_group("bracket");
    group.throughput(Throughput::Elements(faces.len() as u64));
    group.bench_function("curvature", |b| {
        let none = vec![false; mesh.corner_count()];
        b.iter(|| curvature(black_box(triangles), &none, &CurvatureOptions::default(), &context).unwrap());
    });
    group.bench_function("search tree", |b| b.iter(|| TriangleTree::new(black_box(mesh.points()), &faces)));
    group.bench_function("closest points", |b| {
        b.iter(|| far.iter().filter_map(|&p| tree.closest(black_box(p))).map(|found| found.distance()).sum::<f64>());
    });
    group.sample_size(10);
    group.bench_function("frame field", |b| {
        b.iter(|| field::field(black_box(&mesh), &field::FieldOptions::default(), &context).unwrap());
    });
}

criterion_group!(kernels, base_mesh, surfaces);
criterion_main!(kernels);
