//! Nodes: which meshes are shown, and where.

use super::super::source::Source;
use super::schema::{Document, Node};
use crate::error::{Error, Place, Result};
use glam::{DMat4, DQuat, DVec3};

/// A mesh at its place in the world.
pub struct Instance {
    pub mesh: usize,
    /// `None` where the mesh stays as it is: its coordinates are kept to the last bit.
    pub transform: Option<DMat4>,
    pub skinned: bool,
    /// Of its node.
    pub name: Option<String>,
}

/// The meshes of the default scene (the first where none is named), of all nodes where there is no scene, or all meshes
/// where there are no nodes; in the order in which a walk from each root meets them.
pub fn instances(source: &Source, document: &Document) -> Result<Vec<Instance>> {
    if document.nodes.is_empty() {
        return Ok((0..document.meshes.len())
            .map(|mesh| Instance { mesh, transform: None, skinned: false, name: None })
            .collect());
    }
    let failed = |what: String| -> Error { source.error(Place::File, what) };
    let scene = document.scene.or((!document.scenes.is_empty()).then_some(0));
    let roots = match scene {
        None => roots(&document.nodes),
        Some(scene) => match document.scenes.get(scene) {
            Some(scene) => scene.nodes.clone(),
            None => return Err(failed(format!("scene {scene} does not exist, there are {}", document.scenes.len()))),
        },
    };
    let mut instances = Vec::new();
    let mut met = vec![false; document.nodes.len()];
    let mut waiting: Vec<(usize, Option<DMat4>)> = roots.into_iter().rev().map(|node| (node, None)).collect();
    while let Some((index, parent)) = waiting.pop() {
        let Some(node) = document.nodes.get(index) else {
            return Err(failed(format!("node {index} does not exist, there are {}", document.nodes.len())));
        };
        // The nodes of a valid file form trees. So a walk meets each at most once and ends.
        if std::mem::replace(&mut met[index], true) {
            return Err(failed(format!("node {index} has two parents or is its own ancestor")));
        }
        let transform = match (parent, local_transform(node)) {
            (Some(parent), Some(local)) => Some(parent * local),
            (parent, local) => parent.or(local),
        };
        let instance = |mesh| Instance { mesh, transform, skinned: node.skin.is_some(), name: node.name.clone() };
        instances.extend(node.mesh.map(instance));
        waiting.extend(node.children.iter().rev().map(|&child| (child, transform)));
    }
    // A node that no root leads to is on a cycle, or below one.
    match met.iter().position(|&met| !met) {
        Some(index) if scene.is_none() => {
            Err(failed(format!("node {index} is its own ancestor, or below such a node")))
        }
        _ => Ok(instances),
    }
}

/// Nodes that are no other's children.
fn roots(nodes: &[Node]) -> Vec<usize> {
    let mut is_child = vec![false; nodes.len()];
    for &child in nodes.iter().flat_map(|node| &node.children) {
        if let Some(mark) = is_child.get_mut(child) {
            *mark = true;
        }
    }
    (0..nodes.len()).filter(|&node| !is_child[node]).collect()
}

/// Translation × rotation × scale, or the matrix; `None` where the node has no transform or that of identity.
fn local_transform(node: &Node) -> Option<DMat4> {
    let matrix = match node.matrix {
        Some(matrix) => DMat4::from_cols_array(&matrix),
        None => {
            // A quaternion of length zero is no rotation.
            let rotation = node.rotation.map(DQuat::from_array).filter(|q| q.length_squared() > 0.0);
            DMat4::from_scale_rotation_translation(
                node.scale.map_or(DVec3::ONE, DVec3::from_array),
                rotation.map_or(DQuat::IDENTITY, DQuat::normalize),
                node.translation.map_or(DVec3::ZERO, DVec3::from_array),
            )
        }
    };
    (matrix != DMat4::IDENTITY).then_some(matrix)
}
