//! Data arrays of VTK files, which the legacy and the XML formats share, and the columns made of them.
//!
//! | VTK array | column |
//! |---|---|
//! | floating point, 1, 2, 3 components | `Scalar`, `Vector2`, `Vector3` |
//! | integer, 1 component, every value in 32 bits | `Label` |
//! | bytes, 3 or 4 components | `Color` (VTK itself takes such arrays for colours) |
//!
//! Other arrays have no column and are left out with a note.

use super::binary::Endian;
use super::text::{parse_float, parse_integer, push_float, push_integer};
use crate::mesh::Column;

/// Type of the numbers of an array in the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum NumberType {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

/// Numbers of an array, one component after the other.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Values {
    Floats(Vec<f64>),
    /// Unsigned numbers of 64 bits are capped: no index and no label is that large.
    Integers(Vec<i64>),
    Bytes(Vec<u8>),
}

impl NumberType {
    /// Bytes of one number.
    pub fn size(self) -> usize {
        match self {
            NumberType::I8 | NumberType::U8 => 1,
            NumberType::I16 | NumberType::U16 => 2,
            NumberType::I32 | NumberType::U32 | NumberType::F32 => 4,
            NumberType::I64 | NumberType::U64 | NumberType::F64 => 8,
        }
    }

    /// No values yet.
    pub fn empty(self) -> Values {
        match self {
            NumberType::F32 | NumberType::F64 => Values::Floats(Vec::new()),
            NumberType::U8 => Values::Bytes(Vec::new()),
            _ => Values::Integers(Vec::new()),
        }
    }

    /// Numbers from the bytes of a file; bytes behind the last whole number are ignored.
    pub fn decode(self, bytes: &[u8], endian: Endian) -> Values {
        macro_rules! numbers {
            ($type:ty) => {
                bytes.as_chunks().0.iter().map(|b| match endian {
                    Endian::Little => <$type>::from_le_bytes(*b),
                    Endian::Big => <$type>::from_be_bytes(*b),
                })
            };
        }
        match self {
            NumberType::U8 => Values::Bytes(bytes.to_vec()),
            NumberType::I8 => Values::Integers(numbers!(i8).map(i64::from).collect()),
            NumberType::I16 => Values::Integers(numbers!(i16).map(i64::from).collect()),
            NumberType::U16 => Values::Integers(numbers!(u16).map(i64::from).collect()),
            NumberType::I32 => Values::Integers(numbers!(i32).map(i64::from).collect()),
            NumberType::U32 => Values::Integers(numbers!(u32).map(i64::from).collect()),
            NumberType::I64 => Values::Integers(numbers!(i64).collect()),
            NumberType::U64 => Values::Integers(numbers!(u64).map(|x| i64::try_from(x).unwrap_or(i64::MAX)).collect()),
            NumberType::F32 => Values::Floats(numbers!(f32).map(f64::from).collect()),
            NumberType::F64 => Values::Floats(numbers!(f64).collect()),
        }
    }
}

/// An integer, also where it is written as a float without fraction.
fn whole(word: &[u8]) -> Option<i64> {
    parse_integer(word).or_else(|| parse_float(word).filter(|x| x.fract() == 0.0 && x.abs() < 1e15).map(|x| x as i64))
}

impl Values {
    /// Number of values.
    pub fn len(&self) -> usize {
        match self {
            Values::Floats(v) => v.len(),
            Values::Integers(v) => v.len(),
            Values::Bytes(v) => v.len(),
        }
    }

    /// Appends the number a word stands for; `None` when it is not one of this type.
    pub fn push_word(&mut self, word: &[u8]) -> Option<()> {
        match self {
            Values::Floats(v) => v.push(parse_float(word)?),
            Values::Integers(v) => v.push(whole(word)?),
            Values::Bytes(v) => v.push(u8::try_from(whole(word)?).ok()?),
        }
        Some(())
    }

    /// As coordinates or other floats.
    pub fn into_floats(self) -> Vec<f64> {
        match self {
            Values::Floats(v) => v,
            Values::Integers(v) => v.into_iter().map(|x| x as f64).collect(),
            Values::Bytes(v) => v.into_iter().map(f64::from).collect(),
        }
    }

    /// As indices or counts; `None` where a value is negative, has a fraction or does not fit.
    pub fn indices<T: TryFrom<i64>>(&self) -> Option<Vec<T>> {
        match self {
            Values::Floats(_) => None,
            Values::Integers(v) => v.iter().map(|&x| T::try_from(x).ok()).collect(),
            Values::Bytes(v) => v.iter().map(|&x| T::try_from(i64::from(x)).ok()).collect(),
        }
    }
}

/// A named array's values: `width` components for each element.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Array {
    pub values: Values,
    /// At least 1.
    pub width: usize,
}

impl Array {
    /// Number of elements, when the components fill the last one.
    pub fn rows(&self) -> Option<usize> {
        let (n, width) = (self.values.len(), self.width.max(1));
        n.is_multiple_of(width).then_some(n / width)
    }

    /// Appends the elements of the next piece; `false` when they are of another kind.
    pub fn append(&mut self, next: Array) -> bool {
        match (&mut self.values, next.values) {
            _ if self.width != next.width => return false,
            (Values::Floats(a), Values::Floats(b)) => a.extend(b),
            (Values::Integers(a), Values::Integers(b)) => a.extend(b),
            (Values::Bytes(a), Values::Bytes(b)) => a.extend(b),
            _ => return false,
        }
        true
    }

    /// The column of these values, or why there is none.
    pub fn into_column(self) -> Result<Column, String> {
        match (self.values, self.width) {
            (Values::Floats(v), 1) => Ok(Column::Scalar(v)),
            (Values::Floats(v), 2) => Ok(Column::Vector2(v.as_chunks().0.to_vec())),
            (Values::Floats(v), 3) => Ok(Column::Vector3(v.as_chunks().0.to_vec())),
            (Values::Bytes(v), 1) => Ok(Column::Label(v.into_iter().map(i32::from).collect())),
            (Values::Bytes(v), 3) => {
                Ok(Column::Color(v.as_chunks().0.iter().map(|&[r, g, b]| [r, g, b, u8::MAX]).collect()))
            }
            (Values::Bytes(v), 4) => Ok(Column::Color(v.as_chunks().0.to_vec())),
            (values @ Values::Integers(_), 1) => {
                values.indices().map(Column::Label).ok_or_else(|| "it has integers of more than 32 bits".to_string())
            }
            (values, width) => {
                let kind = if matches!(values, Values::Floats(_)) { "floating-point" } else { "integer" };
                Err(format!("arrays of {width} {kind} components are not kept"))
            }
        }
    }
}

/// Numbers to be written.
#[derive(Debug, Clone, Copy)]
pub(super) enum Numbers<'a> {
    F64(&'a [f64]),
    I64(&'a [i64]),
    I32(&'a [i32]),
    U8(&'a [u8]),
}

impl Numbers<'_> {
    /// The type's name in legacy files.
    pub fn legacy_type(&self) -> &'static str {
        match self {
            Numbers::F64(_) => "double",
            Numbers::I64(_) => "vtktypeint64",
            Numbers::I32(_) => "int",
            Numbers::U8(_) => "unsigned_char",
        }
    }

    /// The type's name in XML files.
    pub fn xml_type(&self) -> &'static str {
        match self {
            Numbers::F64(_) => "Float64",
            Numbers::I64(_) => "Int64",
            Numbers::I32(_) => "Int32",
            Numbers::U8(_) => "UInt8",
        }
    }

    /// Appends the numbers in binary.
    pub fn push_bytes(&self, endian: Endian, out: &mut Vec<u8>) {
        macro_rules! push {
            ($values:expr) => {
                match endian {
                    Endian::Little => $values.iter().for_each(|x| out.extend_from_slice(&x.to_le_bytes())),
                    Endian::Big => $values.iter().for_each(|x| out.extend_from_slice(&x.to_be_bytes())),
                }
            };
        }
        match self {
            Numbers::F64(v) => push!(v),
            Numbers::I64(v) => push!(v),
            Numbers::I32(v) => push!(v),
            Numbers::U8(v) => out.extend_from_slice(v),
        }
    }

    /// Appends the numbers as text, `width` to a line.
    pub fn push_text(&self, width: usize, out: &mut Vec<u8>) {
        fn lines<T: Copy>(values: &[T], width: usize, out: &mut Vec<u8>, push: fn(&mut Vec<u8>, T)) {
            for row in values.chunks(width.max(1)) {
                for (k, &x) in row.iter().enumerate() {
                    if k > 0 {
                        out.push(b' ');
                    }
                    push(out, x);
                }
                out.push(b'\n');
            }
        }
        match self {
            Numbers::F64(v) => lines(v, width, out, push_float),
            Numbers::I64(v) => lines(v, width, out, push_integer),
            Numbers::I32(v) => lines(v, width, out, push_integer),
            Numbers::U8(v) => lines(v, width, out, push_integer),
        }
    }
}

/// A column's numbers and their number for each element.
pub(super) fn numbers(column: &Column) -> (Numbers<'_>, usize) {
    match column {
        Column::Scalar(v) => (Numbers::F64(v), 1),
        Column::Vector2(v) => (Numbers::F64(v.as_flattened()), 2),
        Column::Vector3(v) => (Numbers::F64(v.as_flattened()), 3),
        Column::Label(v) => (Numbers::I32(v), 1),
        Column::Color(v) => (Numbers::U8(v.as_flattened()), 4),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_byte_orders_give_the_numbers_back() {
        let floats = [0.1, -0.0, f64::MAX, f64::NAN];
        let integers = [i64::MIN, -1, 0, i64::MAX];
        for endian in [Endian::Little, Endian::Big] {
            let mut bytes = Vec::new();
            Numbers::F64(&floats).push_bytes(endian, &mut bytes);
            let Values::Floats(back) = NumberType::F64.decode(&bytes, endian) else { panic!("floats are expected") };
            assert!(back.iter().zip(&floats).all(|(a, b)| a.to_bits() == b.to_bits()) && back.len() == 4);
            bytes.clear();
            Numbers::I64(&integers).push_bytes(endian, &mut bytes);
            assert_eq!(NumberType::I64.decode(&bytes, endian), Values::Integers(integers.to_vec()));
        }
    }

    #[test]
    fn narrow_types_are_widened_with_their_sign() {
        assert_eq!(NumberType::I8.decode(&[0xff], Endian::Big), Values::Integers(vec![-1]));
        assert_eq!(NumberType::U16.decode(&[0xff, 0xfe], Endian::Big), Values::Integers(vec![0xfffe]));
        assert_eq!(NumberType::U32.decode(&[0xff; 4], Endian::Little), Values::Integers(vec![i64::from(u32::MAX)]));
        assert_eq!(NumberType::U64.decode(&[0xff; 8], Endian::Little), Values::Integers(vec![i64::MAX]));
        assert_eq!(NumberType::F32.decode(&1.5f32.to_le_bytes(), Endian::Little), Values::Floats(vec![1.5]));
    }

    #[test]
    fn words_must_be_of_the_type() {
        let mut bytes = NumberType::U8.empty();
        assert_eq!(bytes.push_word(b"255"), Some(()));
        assert_eq!(bytes.push_word(b"256"), None);
        let mut integers = NumberType::I32.empty();
        assert_eq!(integers.push_word(b"2.0"), Some(()));
        assert_eq!(integers.push_word(b"2.5"), None);
        assert_eq!(integers.push_word(b"x"), None);
        assert_eq!(integers, Values::Integers(vec![2]));
    }

    #[test]
    fn arrays_without_a_column_say_why() {
        let tensor = Array { values: Values::Floats(vec![0.0; 9]), width: 9 };
        assert!(tensor.into_column().is_err_and(|why| why.contains('9')));
        let wide = Array { values: Values::Integers(vec![i64::from(i32::MAX) + 1]), width: 1 };
        assert!(wide.into_column().is_err_and(|why| why.contains("32 bits")));
        let rgb = Array { values: Values::Bytes(vec![1, 2, 3]), width: 3 };
        assert_eq!(rgb.into_column(), Ok(Column::Color(vec![[1, 2, 3, 255]])));
    }
}
