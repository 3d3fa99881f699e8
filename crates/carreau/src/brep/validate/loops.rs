//! Loops in the parameter plane: closed, simple, and the outer one around the holes.

use super::{Fault, Finding};
use crate::brep::Brep;
use crate::brep::boundary::{EdgeSamples, Ring, unroll};
use crate::brep::tessellate::Tessellation;
use crate::context::Context;
use crate::error::Result;
use glam::DVec2;

/// The gap of a closed loop, as a share of its parameters.
const CLOSED: f64 = 1e-6;

/// All findings about loops.
pub(super) fn loops(
    brep: &Brep,
    samples: &[EdgeSamples],
    tessellation: &Tessellation,
    context: &Context,
) -> Result<Vec<Finding>> {
    let mut out = Vec::new();
    for (f, face) in brep.faces.iter().enumerate().filter(|(_, f)| !f.loops.is_empty()) {
        context.check()?;
        let rings = unroll(brep, face, samples);
        let before = out.len();
        for (ring, uses) in rings.iter().zip(&face.loops) {
            let size = ring.samples.iter().map(|s| s.uv.abs().max_element()).fold(1e-3, f64::max);
            let gap = ring.gap().length();
            if !(gap <= CLOSED * size) {
                let at = brep.point(brep.start(&uses[0]));
                out.push(Finding::new(Fault::OpenLoop, gap, CLOSED * size, at).of_face(f as u32));
            }
        }
        if out.len() > before {
            continue;
        }
        let at = brep.point(brep.start(&face.loops[0][0]));
        let sense = if face.same_sense { 1.0 } else { -1.0 };
        for (k, ring) in rings.iter().enumerate() {
            let area = sense * ring.area();
            let inverted = if k == 0 { area <= 0.0 } else { area >= 0.0 || !is_inside(&rings[0], ring.samples[0].uv) };
            if inverted {
                out.push(Finding::new(Fault::InvertedLoop, area, 0.0, at).of_face(f as u32));
            }
        }
        if tessellation.crossed.binary_search(&(f as u32)).is_ok() {
            out.push(Finding::new(Fault::CrossedLoop, 1.0, 0.0, at).of_face(f as u32));
        }
    }
    Ok(out)
}

/// Whether a ray from a point towards +u crosses a loop an odd number of times.
fn is_inside(ring: &Ring, p: DVec2) -> bool {
    let crossed = ring
        .samples
        .windows(2)
        .map(|w| (w[0].uv, w[1].uv))
        .filter(|(a, b)| (a.y <= p.y) != (b.y <= p.y) && a.x + (b.x - a.x) * (p.y - a.y) / (b.y - a.y) > p.x);
    crossed.count() % 2 == 1
}
