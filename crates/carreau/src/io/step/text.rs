//! Entities, lists, numbers and strings of a STEP file.

use super::writer::{Id, Writer};
use crate::io::cad::push_real;
use crate::io::text::push_integer;

impl Writer<'_> {
    pub(super) fn text(&mut self, text: &str) {
        self.out.extend_from_slice(text.as_bytes());
    }

    pub(super) fn id(&mut self, id: Id) {
        self.out.push(b'#');
        push_integer(self.out, id);
    }

    pub(super) fn real(&mut self, x: f64) {
        push_real(self.out, x, b'E');
    }

    /// `(a,b,c)`
    pub(super) fn list<T>(&mut self, items: impl IntoIterator<Item = T>, mut item: impl FnMut(&mut Self, T)) {
        self.out.push(b'(');
        for (k, x) in items.into_iter().enumerate() {
            if k > 0 {
                self.out.push(b',');
            }
            item(self, x);
        }
        self.out.push(b')');
    }

    pub(super) fn ids(&mut self, ids: impl IntoIterator<Item = Id>) {
        self.list(ids, |w, id| w.id(id));
    }

    /// `'text'` with quotes doubled and everything outside printable ASCII as `\X2\…\X0\` (part 21, 6.4.3).
    pub(super) fn string(&mut self, text: &str) {
        self.out.push(b'\'');
        for c in text.chars() {
            match c {
                '\'' => self.text("''"),
                '\\' => self.text("\\\\"),
                ' '..='~' => self.out.push(c as u8),
                _ if u32::from(c) < 0x1_0000 => self.text(&format!("\\X2\\{:04X}\\X0\\", u32::from(c))),
                _ => self.text(&format!("\\X4\\{:08X}\\X0\\", u32::from(c))),
            }
        }
        self.out.push(b'\'');
    }

    /// Begins `#n=`; to be closed with [`Self::end`].
    pub(super) fn begin(&mut self) -> Id {
        self.last += 1;
        let id = self.last;
        self.id(id);
        self.out.push(b'=');
        id
    }

    pub(super) fn end(&mut self) {
        self.text(";\n");
    }

    /// A whole entity whose `#` stand for the given ids, in order.
    pub(super) fn entity(&mut self, template: &str, ids: &[Id]) -> Id {
        let number = self.begin();
        let mut ids = ids.iter();
        for part in template.split_inclusive('#') {
            match (part.strip_suffix('#'), ids.next()) {
                (Some(before), Some(&id)) => {
                    self.text(before);
                    self.id(id);
                }
                _ => self.text(part),
            }
        }
        self.end();
        number
    }
}
