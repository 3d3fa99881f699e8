//! `.cgr` and `.cg`: `# D:3 NV:n NE:m`, then nodes `v x y z [radius]` and edges `e i j`, counted from 0.
//!
//! Some programs count from 1: taken so where no edge uses node 0 and one uses the number of nodes.

use super::super::source::Source;
use super::super::text::{push_float, push_integer, shown};
use super::lines::lines;
use crate::error::Result;
use crate::mesh::{CurveNet, NetBuilder};

pub(super) fn read(source: &Source) -> Result<CurveNet> {
    let mut builder = NetBuilder::default();
    let mut links = Vec::new();
    for line in lines(source, Some(b'#')) {
        match line.words[0] {
            b"v" => {
                line.has(source, 4, "a node")?;
                let radius = if line.words.len() > 4 { Some(line.float(source, 4)?) } else { None };
                builder.node(builder.node_count() as i64, line.point(source, 1)?, radius, line.number)?;
            }
            b"e" => {
                line.has(source, 3, "an edge")?;
                links.push((line.integer(source, 1)?, line.integer(source, 2)?, line.number));
            }
            other => return Err(line.error(source, format!("'v' or 'e' is expected, found '{}'", shown(other)))),
        }
    }
    let count = builder.node_count() as i64;
    let from_one = links.iter().all(|&(a, b, _)| (1..=count).contains(&a) && (1..=count).contains(&b))
        && links.iter().any(|&(a, b, _)| a == count || b == count);
    if from_one {
        builder.note("the edges count nodes from 1");
    }
    let base = i64::from(from_one);
    links.iter().for_each(|&(a, b, line)| builder.link(a - base, b - base, line));
    promised(source, &mut builder, [count as u64, links.len() as u64]);
    builder.finish()
}

/// Compares the counts of the first comment with what the file has.
fn promised(source: &Source, builder: &mut NetBuilder, found: [u64; 2]) {
    let head: String = String::from_utf8_lossy(source.bytes).lines().take_while(|l| l.starts_with('#')).collect();
    for (key, found) in ["NV", "NE"].into_iter().zip(found) {
        let value = head.split(key).nth(1).map(|rest| rest.trim_start_matches([' ', ':', '=']));
        let digits: String = value.unwrap_or_default().chars().take_while(char::is_ascii_digit).collect();
        if let Ok(n) = digits.parse::<u64>()
            && n != found
        {
            builder.note(format!("the header says {key}:{n}, the file has {found}"));
        }
    }
}

pub(super) fn write(net: &CurveNet, out: &mut Vec<u8>) {
    out.extend_from_slice(format!("# D:3 NV:{} NE:{}\n", net.points.len(), net.edges.len()).as_bytes());
    for (p, &r) in net.points.iter().zip(&net.radii) {
        out.push(b'v');
        for x in p.to_array().into_iter().chain(r.is_finite().then_some(r)) {
            out.push(b' ');
            push_float(out, x);
        }
        out.push(b'\n');
    }
    for &[a, b] in &net.edges {
        out.extend_from_slice(b"e ");
        push_integer(out, a);
        out.push(b' ');
        push_integer(out, b);
        out.push(b'\n');
    }
}
