//! Control points evened out along the surface: least squares alone draw them to sharp rims, where strips between them would become
//! slivers and then turn over.

use super::net::{Net, Role};
use super::refine::rim;
use glam::DVec3;

/// A share of the way to the mean of the neighbours, below one because neighbours move as well.
const RELAXATION: f64 = 0.5;
/// A count: steps, because what is uneven is so over a few quads.
const RELAX_STEPS: usize = 3;

/// Moves control points towards the mean of their neighbours, in their tangent planes; along borders those of the border.
pub fn relax(net: &Net, points: &mut [DVec3]) {
    for _ in 0..RELAX_STEPS {
        let before = points.to_vec();
        for fan in &net.fans {
            let v = fan.vertex as usize;
            let p = before[v];
            let to = |o: u32| before[o as usize] - p;
            points[v] = match net.role[v] {
                Role::Corner => p,
                Role::Border => {
                    let [a, b] = rim(net, &fan.spokes).map(to);
                    let along = (b - a).normalize_or_zero();
                    p + RELAXATION * (0.5 * (a + b)).dot(along) * along
                }
                Role::Smooth | Role::Dart => {
                    let around: Vec<DVec3> = fan.spokes.iter().map(|&h| to(net.end(h))).collect();
                    let n = around.len();
                    let normal: DVec3 = (0..n).map(|k| around[k].cross(around[(k + 1) % n])).sum();
                    let mean = around.iter().sum::<DVec3>() / n as f64;
                    p + RELAXATION * mean.reject_from_normalized(normal.normalize_or(DVec3::Z))
                }
            };
        }
    }
}
