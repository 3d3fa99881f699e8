//! `.skel`: a line of words, the number of nodes, then `id x y z radius k n₁ … n_k`; ids may have gaps.

use super::super::source::Source;
use super::super::text::{push_float, push_integer};
use super::lines::lines;
use crate::error::{Place, Result};
use crate::mesh::{CurveNet, NetBuilder};
use rustc_hash::FxHashSet;

pub(super) fn read(source: &Source) -> Result<CurveNet> {
    let lines = lines(source, None);
    let [_, count, rows @ ..] = &lines[..] else {
        return Err(source.error(Place::File, "a line of words and the number of nodes are expected first"));
    };
    let promised = count.integer(source, 0)?;
    let mut builder = NetBuilder::default();
    let mut links = Vec::new();
    let mut ids = Vec::new();
    for line in rows {
        line.has(source, 6, "a node")?;
        let (id, neighbours) = (line.integer(source, 0)?, line.integer(source, 5)?);
        builder.node(id, line.point(source, 1)?, Some(line.float(source, 4)?), line.number)?;
        ids.push(id);
        let listed = line.words.len() - 6;
        if neighbours != listed as i64 {
            builder.note(format!("line {}: node {id} promises {neighbours} neighbours, {listed} follow", line.number));
        }
        for k in 0..listed {
            links.push((id, line.integer(source, 6 + k)?, line.number));
        }
    }
    if promised != rows.len() as i64 {
        builder.note(format!("{promised} nodes are promised, {} follow", rows.len()));
    }
    ids.sort_unstable();
    if let [low, .., high] = ids[..]
        && (high as i128 - low as i128) != ids.len() as i128 - 1
    {
        builder.note(format!("the ids have gaps: {} nodes from {low} to {high}", ids.len()));
    }
    let listed: FxHashSet<(i64, i64)> = links.iter().map(|&(a, b, _)| (a, b)).collect();
    let known = |id: i64| ids.binary_search(&id).is_ok();
    for (a, b, line) in links {
        let mutual = listed.contains(&(b, a));
        if !mutual && known(b) {
            builder.note(format!("line {line}: {a} lists {b}, but {b} does not list {a}; the edge was kept"));
        }
        // A mutual pair counts once.
        if !mutual || a <= b {
            builder.link(a, b, line);
        }
    }
    builder.finish()
}

pub(super) fn write(net: &CurveNet, out: &mut Vec<u8>) {
    out.extend_from_slice(b"ID Cx Cy Cz RADIUS #NEIGHBORS NEIGHBORS_LIST\n");
    push_integer(out, net.points.len());
    out.push(b'\n');
    let around = net.incidence();
    for v in 0..net.points.len() as u32 {
        push_integer(out, v);
        let r = net.radii[v as usize];
        for x in net.points[v as usize].to_array().into_iter().chain([if r.is_finite() { r } else { 0.0 }]) {
            out.push(b' ');
            push_float(out, x);
        }
        out.push(b' ');
        push_integer(out, around.valence(v));
        for &[_, other] in around.of(v) {
            out.push(b' ');
            push_integer(out, other);
        }
        out.push(b'\n');
    }
}
