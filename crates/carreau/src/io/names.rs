//! Words for the labels of faces: OBJ groups, objects and materials, the solids of STL.

use crate::mesh::{Attributes, Column, RawMesh};
use rustc_hash::FxHashMap;

/// Numbers names in the order in which faces first use them.
pub(super) struct FaceNames {
    /// The name of faces that come before the first statement.
    unnamed: &'static str,
    words: Vec<String>,
    numbers: FxHashMap<String, i32>,
    /// The name in force; its number once a face has used it.
    current: String,
    number: Option<i32>,
    /// Of every face; empty until the first name is given.
    labels: Vec<i32>,
    given: bool,
}

impl FaceNames {
    pub fn new(unnamed: &'static str) -> Self {
        FaceNames {
            unnamed,
            words: Vec::new(),
            numbers: FxHashMap::default(),
            current: String::new(),
            number: None,
            labels: Vec::new(),
            given: false,
        }
    }

    /// Gives a name to the faces that follow; `faces` is the number of those before. An empty name is that of faces
    /// before the first statement.
    pub fn name(&mut self, name: &[u8], faces: usize) {
        let name = if name.is_empty() { self.unnamed.as_bytes() } else { name };
        if !self.given {
            self.given = true;
            if faces > 0 {
                self.current = self.unnamed.to_string();
                self.labels = vec![self.number(); faces];
            }
        }
        if self.current.as_bytes() != name {
            self.current = String::from_utf8_lossy(name).into_owned();
            self.number = None;
        }
    }

    /// Counts one more face.
    #[inline]
    pub fn face(&mut self) {
        if self.given {
            let number = self.number();
            self.labels.push(number);
        }
    }

    fn number(&mut self) -> i32 {
        if let Some(number) = self.number {
            return number;
        }
        let next = self.words.len() as i32;
        let number = *self.numbers.entry(self.current.clone()).or_insert(next);
        if number == next {
            self.words.push(self.current.clone());
        }
        self.number = Some(number);
        number
    }

    /// How many names are in use.
    pub fn count(&self) -> usize {
        self.words.len()
    }

    /// The name, where there is only one.
    pub fn only(&self) -> Option<String> {
        match &self.words[..] {
            [only] => Some(only.clone()),
            _ => None,
        }
    }

    /// The column and its words; nothing where no name was given.
    pub fn store(self, column: &str, attributes: &mut Attributes) {
        if self.labels.is_empty() {
            return;
        }
        attributes.face.insert(column.to_string(), Column::Label(self.labels));
        for (label, word) in (0..).zip(self.words) {
            attributes.names.insert((column.to_string(), label), word);
        }
    }
}

/// The labels of a face column, where there is one and it holds labels.
pub(super) fn labels<'a>(mesh: &'a RawMesh, column: &str) -> Option<&'a [i32]> {
    match mesh.attributes.face.get(column) {
        Some(Column::Label(labels)) => Some(labels),
        _ => None,
    }
}

/// The word of a label as it can stand in a file: without line ends and comment marks; the number where it has no word.
pub(super) fn written_name(mesh: &RawMesh, column: &str, label: i32) -> String {
    mesh.attributes.name(column, label).map_or_else(|| label.to_string(), plain_name)
}

/// A name as it can stand in a file: without line ends and comment marks.
pub(super) fn plain_name(word: &str) -> String {
    let plain: String = word.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    let plain = plain.replace(" #", " _");
    let plain = plain.trim().trim_end_matches('\\');
    match plain.strip_prefix('#') {
        Some(rest) => format!("_{rest}"),
        None => plain.to_string(),
    }
}
