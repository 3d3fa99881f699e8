//! Nodes and elements of version 2.2.
//!
//! ```text
//! $Nodes                          $Elements
//! 3                               1
//! 1 0 0 0     tag x y z           1 2 2 7 1 1 2 3     tag, type, number of tags, tags, nodes
//! …                               $EndElements
//! $EndNodes
//! ```
//!
//! In binary files the two counts are text; elements come in blocks that start with type, number of elements and number
//! of tags, then each has its tag, its tags and its nodes. All integers have 32 bits.

use super::collector::{Collector, Tags};
use super::elements::{ElementType, element_type};
use super::stream::{Row, Stream};
use crate::error::Result;
use glam::DVec3;

pub(super) fn read_nodes(stream: &mut Stream, mesh: &mut Collector) -> Result<()> {
    let count = stream.text_integer("the number of nodes")?;
    let count = stream.room_for(count.into(), Row { ints: 1, doubles: 3, ..Row::default() }, "nodes")?;
    let mut tags = Vec::with_capacity(count);
    mesh.points.reserve(count);
    for _ in 0..count {
        tags.push(read_tag(stream, "the number of a node")?);
        let mut coordinate = || stream.double("a coordinate");
        mesh.points.push(DVec3::new(coordinate()?, coordinate()?, coordinate()?));
    }
    mesh.set_nodes(&tags).map_err(|what| stream.error(what))
}

fn read_tag(stream: &mut Stream, what: &str) -> Result<u64> {
    let tag = stream.int(what)?;
    u64::try_from(tag).map_err(|_| stream.error(format!("{what} is {tag}, it cannot be negative")))
}

pub(super) fn read_elements(stream: &mut Stream, mesh: &mut Collector) -> Result<()> {
    let count = stream.text_integer("the number of elements")?;
    // The shortest element is a point without tags: a number and a node, in text its type and number of tags too.
    let ints = if stream.is_binary() { 2 } else { 4 };
    let count = stream.room_for(count.into(), Row { ints, ..Row::default() }, "elements")?;
    mesh.set_elements();
    if stream.is_binary() {
        return read_blocks(stream, mesh, count);
    }
    for _ in 0..count {
        stream.int("the number of an element")?;
        let element = read_type(stream)?;
        let tag_count = read_tag_count(stream)?;
        read_element(stream, mesh, element, tag_count)?;
    }
    Ok(())
}

fn read_blocks(stream: &mut Stream, mesh: &mut Collector, count: usize) -> Result<()> {
    let mut left = count;
    while left > 0 {
        let element = read_type(stream)?;
        let here = stream.int("a number of elements")?;
        let tag_count = read_tag_count(stream)?;
        let row = Row { ints: 1 + tag_count + element.nodes, ..Row::default() };
        let here = stream.room_for(here.into(), row, "elements")?;
        if here > left {
            return Err(stream.error(format!("a block of {here} elements, but only {left} are left of {count}")));
        }
        left -= here;
        for _ in 0..here {
            stream.int("the number of an element")?;
            read_element(stream, mesh, element, tag_count)?;
        }
    }
    Ok(())
}

fn read_type(stream: &mut Stream) -> Result<ElementType> {
    let code = stream.int("the type of an element")?;
    element_type(code).ok_or_else(|| stream.error(format!("elements of type {code} are not known")))
}

fn read_tag_count(stream: &mut Stream) -> Result<usize> {
    let count = stream.int("the number of tags")?;
    stream.room_for(count.into(), Row { ints: 1, ..Row::default() }, "tags")
}

/// The tags (physical, elementary, others) and nodes of an element.
#[inline]
fn read_element(stream: &mut Stream, mesh: &mut Collector, element: ElementType, tag_count: usize) -> Result<()> {
    let mut tags = Tags::default();
    for k in 0..tag_count {
        let tag = stream.int("a tag")?;
        match k {
            0 => tags.physical = tag,
            1 => tags.entity = tag,
            _ => {}
        }
    }
    super::element::read_element(stream, mesh, element, tags, |stream| read_tag(stream, "the number of a node"))
}
