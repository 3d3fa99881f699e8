//! `.tgf` (trivial graph format): `id x y z` lines, a line `#`, `i j` lines. It has no radii.

use super::super::source::Source;
use super::super::text::{push_float, push_integer};
use super::lines::lines;
use crate::error::Result;
use crate::mesh::{CurveNet, NetBuilder};

pub(super) fn read(source: &Source) -> Result<CurveNet> {
    let mut builder = NetBuilder::default();
    let mut edges = false;
    for line in lines(source, None) {
        if line.words[0] == b"#" {
            edges = true;
        } else if edges {
            line.has(source, 2, "an edge")?;
            builder.link(line.integer(source, 0)?, line.integer(source, 1)?, line.number);
        } else {
            line.has(source, 4, "a node")?;
            builder.node(line.integer(source, 0)?, line.point(source, 1)?, None, line.number)?;
        }
    }
    builder.finish()
}

pub(super) fn write(net: &CurveNet, out: &mut Vec<u8>) {
    for (v, p) in net.points.iter().enumerate() {
        push_integer(out, v);
        for x in p.to_array() {
            out.push(b' ');
            push_float(out, x);
        }
        out.push(b'\n');
    }
    out.extend_from_slice(b"#\n");
    for &[a, b] in &net.edges {
        push_integer(out, a);
        out.push(b' ');
        push_integer(out, b);
        out.push(b'\n');
    }
}
