//! Entities, nodes and elements of version 4.1.
//!
//! ```text
//! $Entities
//! 1 0 1 0                                  numbers of points, curves, surfaces, volumes
//! 1 0 0 0 0                                point: tag, x y z, number of physical tags, physical tags
//! 5 0 0 0 1 1 0 1 7 0                      others: tag, box, number of physical tags, physical tags, number of bounding
//! $EndEntities                             entities, their tags
//! $Nodes
//! 1 3 1 3                                  blocks, nodes, smallest and largest tag
//! 2 5 0 3                                  block: dimension and tag of the entity, parametric, nodes
//! 1                                        all tags,
//! 2
//! 3
//! 0 0 0                                    then all positions, each with as many parameters as the entity's dimension
//! 1 0 0                                    where parametric is 1
//! 0 1 0
//! $EndNodes
//! $Elements
//! 1 1 1 1                                  blocks, elements, smallest and largest tag
//! 2 5 2 1                                  block: dimension and tag of the entity, type, elements
//! 1 1 2 3                                  tag, nodes
//! $EndElements
//! ```
//!
//! Numbers and tags of nodes and elements are size_t, tags of entities int.

use super::collector::{Collector, Tags};
use super::element::read_element;
use super::elements::element_type;
use super::stream::{Row, Stream};
use crate::error::Result;
use glam::DVec3;

pub(super) fn read_entities(stream: &mut Stream, mesh: &mut Collector) -> Result<()> {
    let mut counts = [0; 4];
    for (dimension, count) in (0..).zip(&mut counts) {
        let size = stream.size("a number of entities")?;
        let row = Row { ints: 1, sizes: 1, doubles: if dimension == 0 { 3 } else { 6 } };
        *count = stream.room_for(size.into(), row, "entities")?;
    }
    let mut several = 0;
    for (dimension, count) in (0..).zip(counts) {
        for _ in 0..count {
            let tag = stream.int("the tag of an entity")?;
            for _ in 0..if dimension == 0 { 3 } else { 6 } {
                stream.double("the box of an entity")?;
            }
            let (first, number) = read_tags(stream)?;
            mesh.entities.insert((dimension, tag), first);
            several += usize::from(number > 1);
            if dimension > 0 {
                read_tags(stream)?;
            }
        }
    }
    if several > 0 {
        mesh.notes.push(format!("{several} entities have several physical tags: the first is kept"));
    }
    Ok(())
}

/// A number of int tags, then these; returns the first one (0 if there is none) and their number.
fn read_tags(stream: &mut Stream) -> Result<(i32, usize)> {
    let count = stream.size("a number of tags")?;
    let count = stream.room_for(count.into(), Row { ints: 1, ..Row::default() }, "tags")?;
    let mut first = 0;
    for k in 0..count {
        let tag = stream.int("a tag")?;
        if k == 0 {
            first = tag;
        }
    }
    Ok((first, count))
}

/// Number of blocks, and of nodes or elements in all of them.
fn read_totals(stream: &mut Stream, what: &str) -> Result<(usize, u64)> {
    let blocks = stream.size("a number of blocks")?;
    let total = stream.size(what)?;
    stream.size("the smallest tag")?;
    stream.size("the largest tag")?;
    let blocks = stream.room_for(blocks.into(), Row { ints: 3, sizes: 1, ..Row::default() }, "blocks")?;
    Ok((blocks, total))
}

pub(super) fn read_nodes(stream: &mut Stream, mesh: &mut Collector) -> Result<()> {
    let (blocks, total) = read_totals(stream, "the number of nodes")?;
    let mut tags = Vec::new();
    for _ in 0..blocks {
        let dimension = stream.int("the dimension of an entity")?;
        stream.int("the tag of an entity")?;
        let parameters = match (stream.int("0 or 1 for parametric nodes")?, dimension) {
            (0, _) => 0,
            (1, 0..=3) => dimension as usize,
            (flag, _) => {
                let found = format!("parametric nodes (0 or 1) is {flag}, on an entity of dimension {dimension}");
                return Err(stream.error(found));
            }
        };
        let count = stream.size("a number of nodes")?;
        let row = Row { sizes: 1, doubles: 3 + parameters, ..Row::default() };
        let count = stream.room_for(count.into(), row, "nodes")?;
        tags.reserve(count);
        for _ in 0..count {
            tags.push(stream.size("the tag of a node")?);
        }
        mesh.points.reserve(count);
        for _ in 0..count {
            let mut coordinate = || stream.double("a coordinate");
            mesh.points.push(DVec3::new(coordinate()?, coordinate()?, coordinate()?));
            for _ in 0..parameters {
                stream.double("a parameter of a node")?;
            }
        }
    }
    if tags.len() as u64 != total {
        mesh.notes.push(format!("$Nodes announces {total} nodes, its blocks have {}", tags.len()));
    }
    mesh.set_nodes(&tags).map_err(|what| stream.error(what))
}

pub(super) fn read_elements(stream: &mut Stream, mesh: &mut Collector) -> Result<()> {
    let (blocks, total) = read_totals(stream, "the number of elements")?;
    mesh.set_elements();
    let mut read = 0;
    for _ in 0..blocks {
        let dimension = stream.int("the dimension of an entity")?;
        let entity = stream.int("the tag of an entity")?;
        let code = stream.int("the type of elements")?;
        let element =
            element_type(code).ok_or_else(|| stream.error(format!("elements of type {code} are not known")))?;
        let count = stream.size("a number of elements")?;
        let row = Row { sizes: 1 + element.nodes, ..Row::default() };
        let count = stream.room_for(count.into(), row, "elements")?;
        let physical = mesh.entities.get(&(dimension, entity)).copied().unwrap_or(0);
        for _ in 0..count {
            stream.size("the tag of an element")?;
            read_element(stream, mesh, element, Tags { physical, entity }, |stream| stream.size("the tag of a node"))?;
        }
        read += count as u64;
    }
    if read != total {
        mesh.notes.push(format!("$Elements announces {total} elements, its blocks have {read}"));
    }
    Ok(())
}
