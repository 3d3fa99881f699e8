//! The binary part of a page: arrays of numbers one after the other, packed so that they deflate well.
//!
//! Numbers of four bytes are replaced by their differences from the number `stride` places before (its bits, wrapping; the
//! sign goes to the lowest bit) and stored by planes: all lowest bytes first, then all second bytes and so on. Neighbours in
//! a mesh file are neighbours in space, so the higher planes are nearly constant. Everything together is one zlib stream in
//! base64. `viewer/src/decode.js` is the reader.

use crate::error::{Error, Result};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::ZlibEncoder;
use serde::Serialize;
use std::io::Write;

/// What the numbers of an array are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    F32,
    U32,
    I32,
    U8,
}

/// Where an array is, and how it is stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Slot {
    /// First byte, after inflation.
    at: usize,
    /// Numbers.
    count: usize,
    kind: Kind,
    /// Each number is stored as its difference from the one this many places before.
    stride: usize,
}

/// Arrays under construction.
#[derive(Debug, Default)]
pub struct Container {
    bytes: Vec<u8>,
}

impl Container {
    /// Appends single-precision numbers.
    pub fn f32(&mut self, values: impl IntoIterator<Item = f32>, stride: usize) -> Slot {
        self.planes(values.into_iter().map(f32::to_bits).collect(), Kind::F32, stride)
    }

    /// Appends indices.
    pub fn u32(&mut self, values: impl IntoIterator<Item = u32>, stride: usize) -> Slot {
        self.planes(values.into_iter().collect(), Kind::U32, stride)
    }

    /// Appends labels.
    pub fn i32(&mut self, values: impl IntoIterator<Item = i32>) -> Slot {
        self.planes(values.into_iter().map(|v| v as u32).collect(), Kind::I32, 1)
    }

    /// Appends bytes as they are.
    pub fn u8(&mut self, values: impl IntoIterator<Item = u8>) -> Slot {
        let at = self.bytes.len();
        self.bytes.extend(values);
        Slot { at, count: self.bytes.len() - at, kind: Kind::U8, stride: 0 }
    }

    fn planes(&mut self, values: Vec<u32>, kind: Kind, stride: usize) -> Slot {
        let slot = Slot { at: self.bytes.len(), count: values.len(), kind, stride };
        let before = |k: usize| if k < stride { 0 } else { values[k - stride] };
        let packed: Vec<u32> = values.iter().enumerate().map(|(k, v)| zigzag(v.wrapping_sub(before(k)))).collect();
        for byte in 0..4 {
            self.bytes.extend(packed.iter().map(|v| (v >> (8 * byte)) as u8));
        }
        slot
    }

    /// Bytes before deflation.
    pub fn len(&self) -> usize {
        self.bytes.len()
    }

    /// All arrays: zlib, then base64.
    ///
    /// # Errors
    /// [`Error::Bug`]: memory takes every byte.
    pub fn finish(self) -> Result<String> {
        let mut zlib = ZlibEncoder::new(Vec::new(), Compression::new(6));
        let packed = zlib.write_all(&self.bytes).and_then(|()| zlib.finish());
        packed.map(|bytes| STANDARD.encode(bytes)).map_err(|e| Error::Bug(format!("deflation: {e}")))
    }
}

/// A signed difference with its sign in the lowest bit: 0, −1, 1, −2 … become 0, 1, 2, 3 …
fn zigzag(difference: u32) -> u32 {
    (difference << 1) ^ ((difference as i32 >> 31) as u32)
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::io::Read;

    /// What the viewer does with the text.
    pub fn inflated(text: &str) -> Vec<u8> {
        let mut bytes = Vec::new();
        flate2::read::ZlibDecoder::new(&STANDARD.decode(text).unwrap()[..]).read_to_end(&mut bytes).unwrap();
        bytes
    }

    /// The bits of an array of four-byte numbers.
    pub fn decoded(bytes: &[u8], at: usize, count: usize, stride: usize) -> Vec<u32> {
        let mut out: Vec<u32> = Vec::new();
        for k in 0..count {
            let packed = (0..4).fold(0, |v, byte| v | u32::from(bytes[at + byte * count + k]) << (8 * byte));
            let difference = (packed >> 1) ^ (packed & 1).wrapping_neg();
            out.push(difference.wrapping_add(if k < stride { 0 } else { out[k - stride] }));
        }
        out
    }

    proptest! {
        #[test]
        fn every_bit_comes_back(
            reals in prop::collection::vec(any::<u32>(), 0..50),
            indices in prop::collection::vec(any::<u32>(), 0..50),
            bytes in prop::collection::vec(any::<u8>(), 0..9),
            stride in 1usize..5,
        ) {
            let mut all = Container::default();
            let small = all.u8(bytes.iter().copied());
            let first = all.f32(reals.iter().map(|&bits| f32::from_bits(bits)), stride);
            let second = all.u32(indices.iter().copied(), stride);
            let third = all.i32(indices.iter().map(|&v| v as i32));
            let length = all.len();
            let raw = inflated(&all.finish().unwrap());
            prop_assert_eq!(raw.len(), length);
            prop_assert_eq!(&raw[small.at..small.at + small.count], &bytes[..]);
            for (slot, want) in [(first, &reals), (second, &indices), (third, &indices)] {
                prop_assert_eq!(&decoded(&raw, slot.at, slot.count, slot.stride), want);
            }
        }
    }

    #[test]
    fn a_run_of_indices_takes_next_to_nothing() {
        let mut all = Container::default();
        all.u32(0..100_000, 1);
        assert!(all.finish().unwrap().len() < 2000);
    }
}
