//! Curvatures of surfaces whose curvatures are known, and what must hold for any surface.

use super::*;
use crate::geometry::features::{FeatureOptions, feature_edges};
use crate::mesh::SurfaceMesh;
use crate::mesh::test_models::*;

fn curvatures(mesh: &SurfaceMesh, options: &CurvatureOptions) -> Curvature {
    let features = feature_edges(mesh, &FeatureOptions { angle_deg: Some(40.0), ..FeatureOptions::default() }).unwrap();
    curvature(Triangles::of(mesh).unwrap(), &features.corners, options, &Context::new()).unwrap()
}

/// All estimators with the error that each may make on meshes as regular as those of the tests.
fn estimators() -> Vec<(CurvatureOptions, f64)> {
    vec![(CurvatureOptions { estimator: Estimator::Corrected, ..CurvatureOptions::default() }, 0.02)]
}

#[test]
fn spheres_curve_alike_everywhere() {
    let mesh = moved(&sphere(4), |p| 2.0 * p + DVec3::new(10.0, 20.0, -5.0));
    for (options, error) in estimators() {
        for (surface, sign) in [(mesh.clone(), 0.5), (turned(&mesh, |_| true), -0.5)] {
            let k = curvatures(&surface, &options);
            for v in 0..surface.vertex_count() {
                assert!(
                    (k.kmin[v] / sign - 1.0).abs() < error && (k.kmax[v] / sign - 1.0).abs() < error,
                    "{options:?}"
                );
            }
        }
    }
}
