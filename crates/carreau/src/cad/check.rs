//! What a model must pass before it is written: the validator of [`crate::brep`], whose findings name pieces.

use super::model::Obstacle;
use super::regions::Map;
use super::tuning::{MODEL_DISTANCE, NOISY_DISTANCE};
use crate::brep::Brep;
use crate::brep::validate::{Finding, Limits, Reference, validate};
use crate::context::Context;
use crate::error::Result;
use crate::mesh::SurfaceMesh;

/// The pieces that are in the way of a valid model.
pub fn obstacles(map: &Map<'_>, mesh: &SurfaceMesh, brep: &Brep, context: &Context) -> Result<Vec<Obstacle>> {
    let _stage = context.stage("check");
    if let Err(defect) = brep.check() {
        let pieces = (0..map.pieces.len() as u32).collect();
        return Ok(vec![Obstacle { pieces, reason: defect.to_string() }]);
    }
    let region_of: Vec<u32> = map.label.iter().map(|&l| map.pieces[l as usize].region).collect();
    let reference = Reference { mesh, region_of: &region_of };
    let noise = if map.is_noisy() { NOISY_DISTANCE * map.tolerance } else { map.tolerance };
    let mut limits = Limits::new(map.diagonal, noise.max(MODEL_DISTANCE * map.diagonal));
    limits.tolerance = map.gap();
    let findings = validate(brep, Some(&reference), &limits, context)?;
    Ok(findings.iter().map(|f| obstacle(brep, f)).collect())
}

/// The pieces that a finding is about: its faces, or those around its edge or vertex.
fn obstacle(brep: &Brep, finding: &Finding) -> Obstacle {
    let mut pieces: Vec<u32> = finding.face.into_iter().chain(finding.other).collect();
    if pieces.is_empty() {
        let meets = |e: u32| {
            finding.edge == Some(e) || finding.vertex.is_some_and(|v| brep.edges[e as usize].ends.contains(&v))
        };
        let around = brep.faces.iter().zip(0u32..).filter(|(f, _)| f.uses().any(|u| meets(u.edge)));
        pieces = around.map(|(_, p)| p).collect();
    }
    if pieces.is_empty() {
        pieces = (0..brep.faces.len() as u32).collect();
    }
    let (what, measured, bound) = (finding.fault.name(), finding.measured, finding.bound);
    Obstacle { pieces, reason: format!("of the {what}: {measured:.1e}, {bound:.1e} allowed") }
}
