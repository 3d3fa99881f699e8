//! Statements that name parts.

/// The statement and the face column of each kind of name.
pub const NAMES: [(&str, &str); 3] = [("o", "object"), ("g", "group"), ("usemtl", "material")];
