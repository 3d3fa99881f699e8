//! Values that corners and vertices may or may not have.

use crate::error::Result;
use crate::io::text::Scanner;

/// A corner as the file gives it.
#[derive(Clone, Copy)]
pub struct Corner {
    pub(super) vertex: u32,
    pub(super) uv: Reference,
    pub(super) normal: Reference,
}

/// What an index of the file refers to.
#[derive(Clone, Copy)]
pub enum Reference {
    /// The index is not given.
    None,
    /// The index is 0, or counts back to before the first element.
    Nothing,
    /// This element, counted from 0; whether it exists is known at the end of the file.
    To(u32),
}

impl Reference {
    /// 1 is the first element, -1 the last of the `count` so far.
    pub(super) fn new(index: Option<i64>, count: usize) -> Self {
        let Some(index) = index else { return Reference::None };
        let position = if index < 0 { index.saturating_add_unsigned(count as u64) } else { index - 1 };
        match u32::try_from(position) {
            Ok(position) if position < u32::MAX => Reference::To(position),
            _ => Reference::Nothing,
        }
    }
}

/// The largest index in use, and its line.
#[derive(Default)]
pub struct Largest {
    pub(super) index: Option<u32>,
    pub(super) line: u64,
}

impl Largest {
    #[inline]
    pub(super) fn see(&mut self, index: u32, line: u64) {
        if self.index.is_none_or(|i| index > i) {
            *self = Largest { index: Some(index), line };
        }
    }

    /// The index, if it is beyond the elements.
    pub(super) fn beyond(&self, count: usize) -> Option<u32> {
        self.index.filter(|&i| i as usize >= count)
    }
}

/// How often something was left out, and the line where it first was.
#[derive(Default)]
pub struct LeftOut {
    pub(super) count: u64,
    pub(super) first_line: u64,
}

impl LeftOut {
    pub(super) fn count(&mut self, line: u64) {
        if self.count == 0 {
            self.first_line = line;
        }
        self.count += 1;
    }
}

/// Vertex colours, kept while every vertex has one.
#[derive(Default)]
pub struct Colors {
    pub(super) values: Vec<[f64; 3]>,
    pub(super) count: usize,
}

impl Colors {
    /// The colour of the last of `vertices` vertices.
    pub(super) fn push(&mut self, color: [f64; 3], vertices: usize) {
        if color.iter().all(|x| x.is_finite()) {
            self.count += 1;
            if self.count == vertices {
                self.values.push(color);
            }
        }
    }

    /// Files give shares of 1, or of 255: then some value is larger than 1.
    pub(super) fn finish(self, vertices: usize, notes: &mut Vec<String>) -> Option<Vec<[u8; 4]>> {
        if self.count < vertices {
            if self.count > 0 {
                notes.push(format!("left out the colours: only {} of {vertices} vertices have one", self.count));
            }
            return None;
        }
        let full = if self.values.iter().flatten().any(|&x| x > 1.0) { 255.0 } else { 1.0 };
        // `as` saturates, which suits values out of range.
        let byte = |x: f64| (x / full * 255.0).round() as u8;
        (vertices > 0).then(|| self.values.iter().map(|&[r, g, b]| [byte(r), byte(g), byte(b), 255]).collect())
    }
}

/// Texture coordinates or normals, and which of them each corner uses.
#[derive(Default)]
pub struct CornerValues<const N: usize> {
    pub(super) values: Vec<[f64; N]>,
    /// Of every corner so far, while all have one.
    pub(super) indices: Vec<u32>,
    pub(super) corners_with: u64,
    pub(super) corners_without: u64,
    pub(super) largest: Largest,
    pub(super) wrong: LeftOut,
}

impl<const N: usize> CornerValues<N> {
    /// One `vt` or `vn` statement; numbers beyond the `least` that must be there are 0 by default.
    pub(super) fn read(&mut self, scanner: &mut Scanner, least: usize, what: &str) -> Result<()> {
        let mut value = [0.0; N];
        let count = scanner.floats_on_line(&mut value, "a number")?;
        if count < least {
            return Err(scanner.error(format!("a {what} has only {count} of {least} numbers")));
        }
        self.values.push(value);
        Ok(())
    }

    /// What one corner of a face uses.
    #[inline]
    pub(super) fn corner(&mut self, reference: Reference, line: u64) {
        match reference {
            Reference::None => self.corners_without += 1,
            Reference::Nothing => self.wrong.count(line),
            Reference::To(index) => {
                self.corners_with += 1;
                self.largest.see(index, line);
                if self.corners_without == 0 {
                    self.indices.push(index);
                }
            }
        }
    }

    /// The value of every corner; `None`, with a note, where not all corners have one that exists: a wrong index costs
    /// no more than the column, since the surface does not depend on it.
    pub(super) fn finish(mut self, corners: usize, what: &str, notes: &mut Vec<String>) -> Option<Vec<[f64; N]>> {
        if self.largest.beyond(self.values.len()).is_some() {
            self.wrong.count(self.largest.line);
        }
        if self.wrong.count > 0 {
            notes.push(format!("left out the {what}: line {} uses one that does not exist", self.wrong.first_line));
            return None;
        }
        if self.corners_with > 0 && self.corners_without > 0 {
            notes.push(format!("left out the {what}: {} of {corners} corners have none", self.corners_without));
            return None;
        }
        (self.corners_with > 0).then(|| self.indices.iter().map(|&i| self.values[i as usize]).collect())
    }
}
