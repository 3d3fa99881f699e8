//! Directory and parameter records of 80 columns.

use crate::io::cad::push_real;
use crate::io::text::push_integer;
use glam::DVec3;
use std::collections::BTreeMap;

/// Columns of data in a record of the parameter section.
const WIDTH: usize = 64;

/// The directory and the parameter section under construction. An entity is named by its first directory record.
#[derive(Default)]
pub(super) struct Writer {
    pub(super) directory: Vec<u8>,
    pub(super) directory_lines: u32,
    pub(super) parameters: Vec<u8>,
    pub(super) parameter_lines: u32,
    /// Columns used in the current parameter record.
    pub(super) column: usize,
    pub(super) field: Vec<u8>,
    /// Entities of colours.
    pub(super) colors: BTreeMap<[u8; 3], Entity>,
}

/// The first directory record of an entity, by which it is named; 0 is none.
pub(super) type Entity = u32;

/// What a directory record says.
#[derive(Debug, Clone, Copy)]
pub(super) struct Head<'a> {
    pub kind: u32,
    pub status: &'a str,
    pub form: u32,
    /// The transformation (124) that carries the entity into space.
    pub matrix: Entity,
    /// The colour (314).
    pub color: Entity,
}

impl Default for Head<'_> {
    fn default() -> Self {
        Head { kind: 0, status: super::words::DEPENDENT, form: 0, matrix: 0, color: 0 }
    }
}

impl Writer {
    /// Writes one entity whose parameters are pushed by `fill`.
    pub(super) fn entity(&mut self, kind: u32, status: &str, fill: impl FnOnce(&mut Self)) -> Entity {
        self.record(&Head { kind, status, ..Default::default() }, fill)
    }

    /// The same with what a directory record may say besides.
    pub(super) fn record(&mut self, head: &Head, fill: impl FnOnce(&mut Self)) -> Entity {
        let first = self.parameter_lines;
        let id = self.directory_lines + 1;
        let Head { kind, status, form, matrix, color } = *head;
        self.column = 0;
        self.integer(kind);
        fill(self);
        // The delimiter after the last parameter ends the entity.
        if let Some(last) = self.parameters.last_mut() {
            *last = b';';
        }
        self.end_record();
        let lines = self.parameter_lines - first;
        // A colour that is an entity is named by its negative number.
        let color = -i64::from(color);
        let record = format!(
            "{kind:>8}{:>8}{:>8}{:>8}{:>8}{:>8}{matrix:>8}{:>8}{status}D{id:>7}\n\
             {kind:>8}{:>8}{color:>8}{lines:>8}{form:>8}{:>8}{:>8}{:>8}{:>8}D{:>7}\n",
            first + 1,
            0,
            0,
            0,
            0,
            0,
            0,
            "",
            "",
            "",
            0,
            id + 1
        );
        self.directory.extend_from_slice(record.as_bytes());
        self.directory_lines += 2;
        id
    }

    /// Pads the record and writes its number and that of its entity.
    pub(super) fn end_record(&mut self) {
        let blanks = WIDTH - self.column;
        self.parameters.extend(std::iter::repeat_n(b' ', blanks));
        self.parameter_lines += 1;
        let tail = format!("{:>8}P{:>7}\n", self.directory_lines + 1, self.parameter_lines);
        self.parameters.extend_from_slice(tail.as_bytes());
        self.column = 0;
    }

    /// Moves the field that was prepared, with its delimiter, into the parameters; fields are never broken.
    pub(super) fn push_field(&mut self) {
        self.field.push(b',');
        if self.column + self.field.len() > WIDTH {
            self.end_record();
        }
        self.parameters.extend_from_slice(&self.field);
        self.column += self.field.len();
        self.field.clear();
    }

    pub(super) fn integer(&mut self, k: u32) {
        push_integer(&mut self.field, k);
        self.push_field();
    }

    pub(super) fn integers(&mut self, list: impl IntoIterator<Item = u32>) {
        list.into_iter().for_each(|k| self.integer(k));
    }

    pub(super) fn real(&mut self, x: f64) {
        push_real(&mut self.field, x, b'D');
        self.push_field();
    }

    pub(super) fn reals(&mut self, list: impl IntoIterator<Item = f64>) {
        list.into_iter().for_each(|x| self.real(x));
    }

    pub(super) fn point(&mut self, p: DVec3) {
        self.reals(p.to_array());
    }
}
