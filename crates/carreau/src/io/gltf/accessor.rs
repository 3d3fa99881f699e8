//! Accessors: arrays of numbers in buffers.
//!
//! ```text
//! buffer       ░░░░░░░░░░░░░░░░░░░░░░░░░░░░░░░░
//! buffer view       [──── byteLength ────]          from byteOffset
//! accessor            xyz··xyz··xyz··xyz            from its own byteOffset, byteStride apart
//! ```

use super::super::source::Source;
use super::super::text::shown;
use super::container::Buffers;
use super::schema::{Accessor, Document, SparsePart};
use crate::error::{Error, Place, Result};

/// Type of the numbers of an accessor.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    fn from_code(code: u32) -> Option<Self> {
        Some(match code {
            5120 => Component::I8,
            5121 => Component::U8,
            5122 => Component::I16,
            5123 => Component::U16,
            5125 => Component::U32,
            5126 => Component::F32,
            _ => return None,
        })
    }

    fn size(self) -> usize {
        match self {
            Component::I8 | Component::U8 => 1,
            Component::I16 | Component::U16 => 2,
            Component::U32 | Component::F32 => 4,
        }
    }

    /// The number at the front of these bytes.
    fn number(self, bytes: &[u8]) -> f64 {
        match (self, bytes) {
            (Component::I8, &[a, ..]) => f64::from(a as i8),
            (Component::U8, &[a, ..]) => f64::from(a),
            (Component::I16, &[a, b, ..]) => f64::from(i16::from_le_bytes([a, b])),
            (Component::U16, &[a, b, ..]) => f64::from(u16::from_le_bytes([a, b])),
            (Component::U32, &[a, b, c, d, ..]) => f64::from(u32::from_le_bytes([a, b, c, d])),
            (Component::F32, &[a, b, c, d, ..]) => f64::from(f32::from_le_bytes([a, b, c, d])),
            _ => 0.0,
        }
    }

    /// What a normalised integer stands for (section 3.11 of the specification).
    fn normalized(self, x: f64) -> f64 {
        match self {
            Component::I8 => (x / 127.0).max(-1.0),
            Component::U8 => x / 255.0,
            Component::I16 => (x / 32767.0).max(-1.0),
            Component::U16 => x / 65535.0,
            Component::U32 | Component::F32 => x,
        }
    }
}

/// Elements of `N` numbers each, in a buffer.
struct Layout {
    view: usize,
    offset: usize,
    component: Component,
    count: usize,
}

/// Gives the elements of accessors.
pub struct Accessors<'a> {
    source: &'a Source<'a>,
    document: &'a Document,
    pub buffers: Buffers<'a>,
}

impl<'a> Accessors<'a> {
    pub fn new(source: &'a Source<'a>, document: &'a Document, buffers: Buffers<'a>) -> Self {
        Accessors { source, document, buffers }
    }

    fn error(&self, index: usize, what: impl std::fmt::Display) -> Error {
        self.source.error(Place::File, format!("accessor {index}: {what}"))
    }

    /// The accessor itself, for its count and type.
    pub fn accessor(&self, index: usize) -> Result<&'a Accessor> {
        let accessors = &self.document.accessors;
        accessors
            .get(index)
            .ok_or_else(|| self.error(index, format!("it does not exist, there are {}", accessors.len())))
    }

    /// The elements of an accessor with `N` components.
    pub fn elements<const N: usize>(&mut self, index: usize) -> Result<Vec<[f64; N]>> {
        let accessor = self.accessor(index)?;
        let kind = ["SCALAR", "VEC2", "VEC3", "VEC4"].get(N - 1).copied().unwrap_or_default();
        if accessor.kind != kind {
            let found = shown(accessor.kind.as_bytes());
            return Err(self.error(index, format!("it is of type {found}, {kind} is expected")));
        }
        let component = Component::from_code(accessor.component_type);
        let unknown = || self.error(index, format!("unknown component type {}", accessor.component_type));
        let component = component.ok_or_else(unknown)?;
        let layout = |view, offset, count| Layout { view, offset, component, count };
        let mut elements: Vec<[f64; N]> = match accessor.buffer_view {
            Some(view) => self.stored(index, &layout(view, accessor.byte_offset, accessor.count))?,
            // No buffer view: zeros. A count that has nothing to do with the size of the file is a lie.
            None if accessor.count <= self.source.bytes.len() => vec![[0.0; N]; accessor.count],
            None => return Err(self.error(index, format!("{} elements without data", accessor.count))),
        };
        if let Some(sparse) = &accessor.sparse {
            let SparsePart { buffer_view, byte_offset, .. } = sparse.values;
            let values = self.stored::<N>(index, &layout(buffer_view, byte_offset, sparse.count))?;
            for (at, value) in self.sparse_indices(index, &sparse.indices, sparse.count)?.into_iter().zip(values) {
                match elements.get_mut(at) {
                    Some(element) => *element = value,
                    None => return Err(self.error(index, format!("a sparse index {at}, there are {}", accessor.count))),
                }
            }
        }
        if accessor.normalized {
            elements.as_flattened_mut().iter_mut().for_each(|x| *x = component.normalized(*x));
        }
        Ok(elements)
    }

    /// The elements of an accessor of indices.
    pub fn indices(&mut self, index: usize) -> Result<Vec<u32>> {
        let code = self.accessor(index)?.component_type;
        if !matches!(Component::from_code(code), Some(Component::U8 | Component::U16 | Component::U32)) {
            return Err(self.error(index, "indices must be unsigned integers"));
        }
        // Exact: every u32 is a double.
        Ok(self.elements::<1>(index)?.into_iter().map(|[x]| x as u32).collect())
    }

    fn sparse_indices(&mut self, index: usize, part: &SparsePart, count: usize) -> Result<Vec<usize>> {
        let component = part.component_type.and_then(Component::from_code);
        let Some(component @ (Component::U8 | Component::U16 | Component::U32)) = component else {
            return Err(self.error(index, "sparse indices must be unsigned integers"));
        };
        let layout = Layout { view: part.buffer_view, offset: part.byte_offset, component, count };
        Ok(self.stored::<1>(index, &layout)?.into_iter().map(|[x]| x as usize).collect())
    }

    /// Elements as they are in a buffer, not normalised.
    fn stored<const N: usize>(&mut self, index: usize, layout: &Layout) -> Result<Vec<[f64; N]>> {
        let Layout { view, offset, component, count } = *layout;
        let views = &self.document.buffer_views;
        let Some(buffer_view) = views.get(view) else {
            return Err(self.error(index, format!("buffer view {view} does not exist, there are {}", views.len())));
        };
        if let Some(name) = buffer_view.extensions.keys().find(|name| name.ends_with("meshopt_compression")) {
            let name = shown(name.as_bytes());
            return Err(self.error(index, format!("the extension {name} compresses its data, which is not supported")));
        }
        let size = N * component.size();
        let stride = buffer_view.byte_stride.unwrap_or(size);
        let last = buffer_view.byte_offset.checked_add(buffer_view.byte_length);
        let bytes = self.buffers.get(buffer_view.buffer)?;
        let bytes = last.and_then(|last| bytes.get(buffer_view.byte_offset..last));
        let Some(bytes) = bytes else {
            return Err(self.error(index, format!("buffer view {view} is larger than its buffer")));
        };
        let length = count.checked_sub(1).map_or(Some(0), |steps| steps.checked_mul(stride)?.checked_add(size));
        let data = length.and_then(|length| bytes.get(offset..offset.checked_add(length)?));
        match data {
            Some(data) if stride >= size => {
                let element = |row: &[u8]| std::array::from_fn(|k| component.number(&row[k * component.size()..]));
                // The last element may be shorter than the stride.
                Ok(data.chunks(stride.max(1)).take(count).map(element).collect())
            }
            Some(_) => Err(self.error(index, format!("elements of {size} bytes are {stride} bytes apart"))),
            None => Err(self.error(index, format!("{count} elements are announced, buffer view {view} has fewer"))),
        }
    }
}
