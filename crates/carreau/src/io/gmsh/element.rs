//! Reads one element.

use super::collector::{Collector, Tags};
use super::elements::ElementType;
use super::stream::Stream;
use crate::error::Result;

/// Reads the nodes of an element and keeps its corners. `node` reads a tag.
#[inline]
pub fn read_element(
    stream: &mut Stream,
    mesh: &mut Collector,
    element: ElementType,
    tags: Tags,
    node: impl Fn(&mut Stream) -> Result<u64>,
) -> Result<()> {
    let mut vertices = [0; 8];
    let corners = &mut vertices[..element.shape.corners()];
    for corner in corners.iter_mut() {
        let tag = node(stream)?;
        *corner = mesh.vertex(tag).ok_or_else(|| stream.error(format!("node {tag} of an element does not exist")))?;
    }
    for _ in corners.len()..element.nodes {
        node(stream)?;
    }
    mesh.add(element, corners, tags);
    Ok(())
}
