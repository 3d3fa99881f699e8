//! A cursor over bytes: every read is checked against the end of the file.

use super::source::Source;
use crate::error::{Error, Place, Result};

/// Byte order of a binary file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Endian {
    /// Least significant byte first.
    Little,
    /// Most significant byte first.
    Big,
}

/// Reads numbers one after the other.
pub struct Cursor<'a> {
    source: &'a Source<'a>,
    /// Byte offset of the next read.
    pub position: usize,
    /// Byte order of the numbers.
    pub endian: Endian,
}

macro_rules! number {
    ($($name:ident: $type:ty),*) => {$(
        /// The next number.
        #[inline]
        pub fn $name(&mut self) -> Result<$type> {
            let bytes = self.array()?;
            Ok(match self.endian {
                Endian::Little => <$type>::from_le_bytes(bytes),
                Endian::Big => <$type>::from_be_bytes(bytes),
            })
        }
    )*};
}

#[allow(dead_code)] // one set of numbers for all formats, whether or not each is in use today
impl<'a> Cursor<'a> {
    /// Starts at a byte offset.
    pub fn new(source: &'a Source<'a>, position: usize, endian: Endian) -> Self {
        Cursor { source, position, endian }
    }

    /// An error at the current position.
    pub fn error(&self, what: impl Into<String>) -> Error {
        self.source.error(Place::Byte(self.position as u64), what)
    }

    /// Number of bytes left.
    pub fn remaining(&self) -> usize {
        self.source.bytes.len().saturating_sub(self.position)
    }

    /// The next `n` bytes.
    #[inline]
    pub fn take(&mut self, n: usize) -> Result<&'a [u8]> {
        match self.source.bytes.get(self.position..).and_then(|rest| rest.get(..n)) {
            Some(bytes) => {
                self.position += n;
                Ok(bytes)
            }
            None => Err(self.ends_before(n)),
        }
    }

    #[inline]
    fn array<const N: usize>(&mut self) -> Result<[u8; N]> {
        match self.source.bytes.get(self.position..).and_then(|rest| rest.first_chunk()) {
            Some(bytes) => {
                self.position += N;
                Ok(*bytes)
            }
            None => Err(self.ends_before(N)),
        }
    }

    #[cold]
    fn ends_before(&self, n: usize) -> Error {
        self.error(format!("{n} bytes are expected here, the file ends after {}", self.remaining()))
    }

    /// Checks that `count` records of `size` bytes can follow; returns `count` as an array length.
    pub fn room_for(&self, count: i128, size: usize, what: &str) -> Result<usize> {
        if count >= 0 && count <= (self.remaining() / size.max(1)) as i128 {
            return Ok(count as usize);
        }
        Err(self.error(format!("{count} {what} are announced, the rest of the file is {} bytes", self.remaining())))
    }

    number!(u8: u8, i8: i8, u16: u16, i16: i16, u32: u32, i32: i32, u64: u64, i64: i64, f32: f32, f64: f64);
}
