//! `.swc`: `id type x y z radius parent`, one line per node in any order, parent −1 at a root; `#` starts a comment.

use super::super::source::Source;
use super::super::text::{push_float, push_integer};
use super::lines::lines;
use crate::error::{Error, Result};
use crate::mesh::{CurveNet, NetBuilder};

pub(super) fn read(source: &Source) -> Result<CurveNet> {
    let mut builder = NetBuilder::default();
    let mut parents = Vec::new();
    for line in lines(source, Some(b'#')) {
        line.has(source, 7, "a node")?;
        let (id, parent) = (line.integer(source, 0)?, line.integer(source, 6)?);
        builder.node(id, line.point(source, 2)?, Some(line.float(source, 5)?), line.number)?;
        if parent >= 0 {
            builder.link(id, parent, line.number);
            parents.push(());
        }
    }
    let rootless = builder.node_count() > 0 && parents.len() == builder.node_count();
    let mut net = builder.finish()?;
    if rootless || net.cycles().iter().any(|&c| c > 0) {
        net.notes.push("the parents form a ring; it was kept".into());
    }
    Ok(net)
}

/// Parents are found from the first node of every component on.
pub(super) fn write(net: &CurveNet, out: &mut Vec<u8>) -> Result<()> {
    if net.cycles().iter().any(|&c| c > 0) {
        return Err(Error::input("SWC holds only trees, but this skeleton has cycles", "", "write .cgr instead"));
    }
    let around = net.incidence();
    let mut parent = vec![None; net.points.len()];
    for root in 0..net.points.len() as u32 {
        if parent[root as usize].is_some() {
            continue;
        }
        parent[root as usize] = Some(-1);
        let mut stack = vec![root];
        while let Some(v) = stack.pop() {
            for &[_, w] in around.of(v) {
                if parent[w as usize].is_none() {
                    parent[w as usize] = Some(i64::from(v));
                    stack.push(w);
                }
            }
        }
    }
    for (v, p) in net.points.iter().enumerate() {
        push_integer(out, v);
        out.extend_from_slice(b" 0");
        let r = net.radii[v];
        for x in p.to_array().into_iter().chain([if r.is_finite() { r } else { 0.0 }]) {
            out.push(b' ');
            push_float(out, x);
        }
        out.push(b' ');
        push_integer(out, parent[v].unwrap_or(-1));
        out.push(b'\n');
    }
    Ok(())
}
