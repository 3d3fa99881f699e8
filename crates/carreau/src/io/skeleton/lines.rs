//! The lines of a text file that hold something.

use crate::error::{Error, Place, Result};
use crate::io::source::Source;
use crate::io::text::{Scanner, parse_float, parse_integer, shown};

/// Line of a text file with its words.
pub struct Line<'a> {
    pub(super) number: u64,
    pub(super) words: Vec<&'a [u8]>,
}

/// The lines that hold anything, comments left out.
pub fn lines<'a>(source: &'a Source<'a>, comment: Option<u8>) -> Vec<Line<'a>> {
    let mut text = Scanner::new(source, comment);
    let mut lines = Vec::new();
    loop {
        let number = text.line_number();
        let words: Vec<&[u8]> = std::iter::from_fn(|| text.word_on_line()).collect();
        if !words.is_empty() {
            lines.push(Line { number, words });
        }
        if !text.next_line() {
            return lines;
        }
    }
}

impl Line<'_> {
    pub(super) fn error(&self, source: &Source, what: impl Into<String>) -> Error {
        source.error(Place::Line(self.number), what)
    }

    pub(super) fn has(&self, source: &Source, fields: usize, what: &str) -> Result<()> {
        match self.words.len() {
            n if n >= fields => Ok(()),
            n => Err(self.error(source, format!("{what} needs {fields} fields, there are {n}"))),
        }
    }

    /// The number in a field; NaN and infinity are numbers here, refused later with exit code 3.
    pub(super) fn float(&self, source: &Source, field: usize) -> Result<f64> {
        let word = self.words.get(field).copied().unwrap_or_default();
        parse_float(word).ok_or_else(|| self.error(source, format!("a number is expected, found '{}'", shown(word))))
    }

    pub(super) fn integer(&self, source: &Source, field: usize) -> Result<i64> {
        let word = self.words.get(field).copied().unwrap_or_default();
        parse_integer(word)
            .ok_or_else(|| self.error(source, format!("an integer is expected, found '{}'", shown(word))))
    }

    pub(super) fn point(&self, source: &Source, first: usize) -> Result<glam::DVec3> {
        let x = |k: usize| self.float(source, first + k);
        Ok(glam::DVec3::new(x(0)?, x(1)?, x(2)?))
    }
}
