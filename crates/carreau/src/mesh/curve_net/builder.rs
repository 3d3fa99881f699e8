//! A net under construction from a file: nodes and links by id, in any order.
//!
//! What a skeleton cannot mean is refused: coordinates that are no numbers, negative radii, repeated ids, links to
//! nothing, links of a node with itself, nothing at all. The rest is noted and mended.

use super::net::CurveNet;
use crate::error::{Error, Result};
use glam::DVec3;
use rustc_hash::FxHashMap;

/// Collects the nodes and links of a file.
#[derive(Default)]
pub struct NetBuilder {
    net: CurveNet,
    at: FxHashMap<i64, u32>,
    lines: Vec<u64>,
    links: Vec<([i64; 2], u64)>,
}

impl NetBuilder {
    /// Adds a node; `line` is where the file has it. A missing radius is no error here.
    ///
    /// # Errors
    /// [`Error::Input`] for a coordinate or radius that is not finite, a negative radius, or an id
    /// that is used twice.
    pub fn node(&mut self, id: i64, point: DVec3, radius: Option<f64>, line: u64) -> Result<()> {
        let place = || format!("line {line}, node {id}");
        if !point.is_finite() || radius.is_some_and(|r| !r.is_finite()) {
            return Err(Error::input("a coordinate or radius is not a finite number", place(), "remove the node"));
        }
        if let Some(r) = radius.filter(|r| *r < 0.0) {
            return Err(Error::input(
                format!("the radius is negative: {r}"),
                place(),
                "give a positive radius, or leave it out",
            ));
        }
        if let Some(&first) = self.at.get(&id) {
            let first = self.lines[first as usize];
            return Err(Error::input(format!("id {id} is used twice, first on line {first}"), place(), "renumber"));
        }
        if self.net.points.len() >= u32::MAX as usize {
            return Err(Error::input("the skeleton has too many nodes", place(), ""));
        }
        self.at.insert(id, self.net.points.len() as u32);
        self.net.points.push(point);
        self.net.radii.push(radius.unwrap_or(f64::NAN));
        self.net.ids.push(id);
        self.lines.push(line);
        Ok(())
    }

    /// Adds a link; its nodes may come later.
    pub fn link(&mut self, a: i64, b: i64, line: u64) {
        self.links.push(([a, b], line));
    }

    /// Adds something to the notes.
    pub fn note(&mut self, what: impl Into<String>) {
        self.net.notes.push(what.into());
    }

    /// Number of nodes so far.
    pub fn node_count(&self) -> usize {
        self.net.points.len()
    }

    /// The net.
    ///
    /// # Errors
    /// [`Error::Input`] for an empty skeleton, an edge to a node that does not exist, or of a node
    /// with itself.
    pub fn finish(mut self) -> Result<CurveNet> {
        for &([a, b], line) in &self.links {
            let place = || format!("line {line}, edge {a}-{b}");
            if a == b {
                return Err(Error::input("an edge joins a node with itself", place(), "remove the edge"));
            }
            match (self.at.get(&a), self.at.get(&b)) {
                (Some(&a), Some(&b)) => self.net.edges.push([a, b]),
                (found, _) => {
                    let missing = if found.is_none() { a } else { b };
                    let known = self.net.points.len();
                    return Err(Error::input(
                        format!("there is no node {missing} ({known} nodes)"),
                        place(),
                        "add the node or remove the edge",
                    ));
                }
            }
        }
        if self.net.points.is_empty() || self.net.edges.is_empty() {
            let (nodes, edges) = (self.net.points.len(), self.net.edges.len());
            return Err(Error::input(format!("the skeleton is empty: {nodes} nodes, {edges} edges"), "", ""));
        }
        let twice = self.net.drop_multiple_edges();
        if twice > 0 {
            self.net.notes.push(format!("{twice} edges are listed twice: one of each was kept"));
        }
        Ok(self.net)
    }
}
