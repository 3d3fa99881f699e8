//! The keywords of both Medit formats.

/// Sections of rows of integers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    Edges,
    Triangles,
    Quadrilaterals,
    Tetrahedra,
    Prisms,
    Hexahedra,
    Pyramids,
    Corners,
    Ridges,
    RequiredVertices,
    RequiredEdges,
}

/// How such a section is written in a file.
#[derive(Debug)]
pub struct Keyword {
    pub kind: Kind,
    /// The name that is written, then the others that are read.
    pub names: &'static [&'static str],
    /// In binary files.
    pub code: i32,
    /// Indices of a row.
    pub indices: usize,
    /// Whether a reference number follows them.
    pub reference: bool,
}

pub const fn element(kind: Kind, names: &'static [&'static str], code: i32, indices: usize) -> Keyword {
    Keyword { kind, names, code, indices, reference: true }
}

pub const fn list(kind: Kind, names: &'static [&'static str], code: i32) -> Keyword {
    Keyword { kind, names, code, indices: 1, reference: false }
}

/// The sections that are read, with their names and codes.
pub const KEYWORDS: [Keyword; 11] = [
    element(Kind::Edges, &["Edges"], 5, 2),
    element(Kind::Triangles, &["Triangles"], 6, 3),
    element(Kind::Quadrilaterals, &["Quadrilaterals"], 7, 4),
    element(Kind::Tetrahedra, &["Tetrahedra"], 8, 4),
    element(Kind::Prisms, &["Prisms", "Pentahedra"], 9, 6),
    element(Kind::Hexahedra, &["Hexahedra", "Hexaedra"], 10, 8),
    element(Kind::Pyramids, &["Pyramids"], 49, 5),
    list(Kind::Corners, &["Corners"], 13),
    list(Kind::Ridges, &["Ridges"], 14),
    list(Kind::RequiredVertices, &["RequiredVertices"], 15),
    list(Kind::RequiredEdges, &["RequiredEdges"], 16),
];

impl Keyword {
    /// The keyword of this name, in any case.
    pub fn named(word: &[u8]) -> Option<&'static Keyword> {
        KEYWORDS.iter().find(|k| k.names.iter().any(|name| name.as_bytes().eq_ignore_ascii_case(word)))
    }

    /// The keyword of this code.
    pub fn coded(code: i32) -> Option<&'static Keyword> {
        KEYWORDS.iter().find(|k| k.code == code)
    }

    pub(super) fn of(kind: Kind) -> &'static Keyword {
        // Every kind has its row; the first stands in for a row forgotten, which a test would notice.
        KEYWORDS.iter().find(|k| k.kind == kind).unwrap_or(&KEYWORDS[0])
    }

    /// Its usual name.
    pub fn name(&self) -> &'static str {
        self.names[0]
    }

    /// Numbers of a row.
    pub fn width(&self) -> usize {
        self.indices + usize::from(self.reference)
    }
}
