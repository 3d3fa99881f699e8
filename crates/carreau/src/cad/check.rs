//! What a model must pass before it is written.

use super::model::Obstacle;
use super::regions::Map;
use crate::brep::Brep;
use crate::context::Context;
use crate::error::Result;

/// The pieces that are in the way of a valid model.
pub fn obstacles(map: &Map<'_>, brep: &Brep, context: &Context) -> Result<Vec<Obstacle>> {
    let _stage = context.stage("check");
    if let Err(defect) = brep.check() {
        let pieces = (0..map.pieces.len() as u32).collect();
        return Ok(vec![Obstacle { pieces, reason: defect.to_string() }]);
    }
    Ok(Vec::new())
}
