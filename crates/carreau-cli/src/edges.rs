//! Files that list edges.

use carreau::mesh::VertexId;
use carreau::{Error, Place};
use std::path::Path;

/// Edges listed in a text file, two vertex ids per line; `#` starts a comment.
pub fn read_edges(file: &Path) -> Result<Vec<[VertexId; 2]>, Error> {
    let text = std::fs::read_to_string(file).map_err(|e| Error::read(file, Place::File, e.to_string()))?;
    let lines = text.lines().zip(1..).map(|(line, number)| (line.split('#').next().unwrap_or("").trim(), number));
    lines
        .filter(|(line, _)| !line.is_empty())
        .map(|(line, number)| {
            let ids: Vec<u32> = line.split_whitespace().map_while(|word| word.parse().ok()).collect();
            match ids[..] {
                [a, b] => Ok([VertexId(a), VertexId(b)]),
                _ => {
                    Err(Error::read(file, Place::Line(number), format!("two vertex ids are expected, found '{line}'")))
                }
            }
        })
        .collect()
}
