//! Colours of vertices and faces, in shares of 1 or of 255.

use crate::mesh::Column;

/// A colour as the file gives it: shares of 1 or of 255, with or without opacity.
#[derive(Clone, Copy)]
pub struct Color {
    rgb: [f64; 3],
    opacity: Option<f64>,
}

impl Color {
    /// Three numbers, or four with the opacity.
    pub fn new(values: &[f64]) -> Option<Self> {
        match *values {
            [r, g, b] => Some(Color { rgb: [r, g, b], opacity: None }),
            [r, g, b, a] => Some(Color { rgb: [r, g, b], opacity: Some(a) }),
            _ => None,
        }
    }

    fn values(&self) -> impl Iterator<Item = f64> {
        self.rgb.into_iter().chain(self.opacity)
    }
}

/// Colours of vertices or faces, kept while all have one.
#[derive(Default)]
pub struct Colors {
    values: Vec<Color>,
    without: usize,
}

impl Colors {
    /// The colour of the next element.
    pub fn push(&mut self, color: Option<Color>) {
        match color {
            Some(color) => self.values.push(color),
            None => self.without += 1,
        }
    }

    /// The column, where all `count` elements have a colour.
    ///
    /// A colour with a value larger than 1 is in shares of 255, one with a fraction in shares of 1; one of only zeros
    /// and ones is what the others of the file are.
    pub fn finish(self, count: usize, what: &str, notes: &mut Vec<String>) -> Option<Column> {
        if self.without > 0 && !self.values.is_empty() {
            notes.push(format!("left out the colours: only {} of {count} {what} have one", self.values.len()));
        }
        if self.without > 0 || self.values.is_empty() {
            return None;
        }
        let in_bytes = |c: &Color| c.values().any(|x| x > 1.0);
        let in_shares = |c: &Color| c.values().any(|x| x > 0.0 && x < 1.0);
        let any_in_bytes = self.values.iter().any(in_bytes);
        let quantised = self.values.iter().map(|c| {
            let full = if in_bytes(c) || (any_in_bytes && !in_shares(c)) { 255.0 } else { 1.0 };
            // `as` saturates, which suits values out of range.
            let byte = |x: f64| (x / full * 255.0).round() as u8;
            let [r, g, b] = c.rgb.map(byte);
            [r, g, b, c.opacity.map_or(255, byte)]
        });
        Some(Column::Color(quantised.collect()))
    }
}
