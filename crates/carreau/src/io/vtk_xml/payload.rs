//! The bytes of a binary data array.
//!
//! ```text
//! plain       [bytes] data
//! compressed  [blocks n] [bytes of a block] [bytes of the last, 0: it is full] [compressed bytes of each of the n] data
//! ```
//!
//! The bracketed words are integers of 32 or 64 bits. Inline data, and appended data of encoding base64, are base64 of the
//! head followed by base64 of the data, each with its own padding, or of both together.

use super::super::binary::Endian;
use base64::Engine;
use base64::engine::general_purpose::GeneralPurposeConfig;
use base64::engine::{DecodePaddingMode, GeneralPurpose};
use std::borrow::Cow;
use std::io::Read;

/// Most bytes that all arrays of a file may expand to, for each byte of the file: the most that zlib can reach.
const ZLIB_EXPANSION: usize = 1100;
/// Memory that an lzma decoder may ask for, in KiB: enough for the dictionary of its highest preset.
const LZMA_MEMORY_KIB: u32 = 80 << 10;
/// First bytes of an lzma stream in the xz container.
const XZ: &[u8] = b"\xfd7zXZ\0";

/// Unpadded base64 is accepted, and bits behind the last byte are ignored.
const LENIENT_BASE64: GeneralPurpose = GeneralPurpose::new(
    &base64::alphabet::STANDARD,
    GeneralPurposeConfig::new()
        .with_decode_padding_mode(DecodePaddingMode::Indifferent)
        .with_decode_allow_trailing_bits(true),
);

/// How blocks are compressed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Compressor {
    /// `vtkZLibDataCompressor`.
    Zlib,
    /// `vtkLZMADataCompressor`: xz, or the older container of lzma alone.
    Lzma,
    /// `vtkLZ4DataCompressor`: LZ4 blocks without a frame.
    Lz4,
}

/// How the binary arrays of a file are written.
#[derive(Debug, Clone, Copy)]
pub struct Encoding {
    pub endian: Endian,
    /// Heads are of 64 bits instead of 32.
    pub wide: bool,
    pub compressor: Option<Compressor>,
}

/// The appended section of a file.
#[derive(Default)]
pub struct Appended<'a> {
    /// From behind the underscore on.
    pub bytes: &'a [u8],
    pub raw: bool,
    /// Offsets of all arrays in ascending order: where one may begin, the one before ends.
    pub offsets: Vec<usize>,
}

/// Gives the bytes of arrays, keeping account of how much the file expands to.
pub struct Payloads<'a> {
    pub encoding: Encoding,
    pub appended: Appended<'a>,
    budget: usize,
}

impl<'a> Payloads<'a> {
    /// `file_size` bounds what the arrays may expand to.
    pub fn new(encoding: Encoding, appended: Appended<'a>, file_size: usize) -> Self {
        Payloads { encoding, appended, budget: file_size.saturating_mul(ZLIB_EXPANSION) }
    }

    /// The data of an inline array.
    pub fn inline(&mut self, text: &str) -> Result<Vec<u8>, String> {
        let block = self.decode_base64(text.as_bytes())?;
        self.unpack(&block).map(Cow::into_owned)
    }

    /// The data of the array at this offset of the appended section.
    pub fn appended(&mut self, offset: usize) -> Result<Vec<u8>, String> {
        let section = self.appended.bytes;
        let Some(rest) = section.get(offset..) else {
            return Err(format!("the offset {offset} is beyond the appended data ({} bytes)", section.len()));
        };
        if self.appended.raw {
            return self.unpack(rest).map(Cow::into_owned);
        }
        let next = self.appended.offsets.partition_point(|&other| other <= offset);
        let end = self.appended.offsets.get(next).map_or(rest.len(), |next| next - offset);
        let block = self.decode_base64(&rest[..end.min(rest.len())])?;
        self.unpack(&block).map(Cow::into_owned)
    }

    fn spend(&mut self, bytes: usize) -> Result<(), String> {
        self.budget = self.budget.checked_sub(bytes).ok_or("the arrays of the file expand to an impossible size")?;
        Ok(())
    }

    /// One or several base64 streams one after the other.
    fn decode_base64(&mut self, text: &[u8]) -> Result<Vec<u8>, String> {
        self.spend(text.len())?;
        let text: Vec<u8> = text.iter().copied().filter(|b| !b.is_ascii_whitespace()).collect();
        let mut bytes = Vec::with_capacity(text.len() / 4 * 3);
        for stream in text.split_inclusive(|&b| b == b'=').filter(|stream| *stream != b"=") {
            let digits = stream.strip_suffix(b"=").unwrap_or(stream);
            LENIENT_BASE64.decode_vec(digits, &mut bytes).map_err(|e| format!("no valid base64: {e}"))?;
        }
        Ok(bytes)
    }

    /// The data behind the head of a block; what follows them is ignored.
    fn unpack<'b>(&mut self, block: &'b [u8]) -> Result<Cow<'b, [u8]>, String> {
        let Some(compressor) = self.encoding.compressor else {
            if block.is_empty() {
                return Ok(Cow::Borrowed(block));
            }
            let size = self.word(block, 0)?;
            self.spend(size)?;
            let data = &block[self.word_size()..];
            let announced = || format!("{size} bytes are announced, there are {}", data.len());
            return data.get(..size).map(Cow::Borrowed).ok_or_else(announced);
        };
        let blocks = if block.is_empty() { 0 } else { self.word(block, 0)? };
        if blocks == 0 {
            return Ok(Cow::Borrowed(&[]));
        }
        let head = blocks.checked_add(3).and_then(|words| words.checked_mul(self.word_size()));
        let head = head.filter(|&head| head <= block.len());
        let mut rest = &block[head.ok_or_else(|| format!("{blocks} compressed blocks are announced"))?..];
        let (full, last) = (self.word(block, 1)?, self.word(block, 2)?);
        let mut data = Vec::new();
        for k in 0..blocks {
            let size = if k + 1 == blocks && last > 0 { last } else { full };
            let packed = self.word(block, 3 + k)?;
            let Some((packed, behind)) = rest.split_at_checked(packed) else {
                return Err(format!("compressed block {k} has {packed} bytes, {} are left", rest.len()));
            };
            rest = behind;
            self.spend(size)?;
            let before = data.len();
            compressor.decompress(packed, size, &mut data).map_err(|e| format!("compressed block {k}: {e}"))?;
            let found = data.len() - before;
            if found != size {
                let at_least = if found > size { "more" } else { &found.to_string() };
                return Err(format!("compressed block {k} holds {at_least} bytes, {size} are announced"));
            }
        }
        Ok(Cow::Owned(data))
    }

    fn word_size(&self) -> usize {
        if self.encoding.wide { 8 } else { 4 }
    }

    /// Word `k` of a head.
    fn word(&self, block: &[u8], k: usize) -> Result<usize, String> {
        let size = self.word_size();
        let bytes = block.get(k * size..(k + 1) * size).ok_or("the data are shorter than their head")?;
        let fold = |value: u64, byte: &u8| value << 8 | u64::from(*byte);
        let value = match self.encoding.endian {
            Endian::Little => bytes.iter().rev().fold(0, fold),
            Endian::Big => bytes.iter().fold(0, fold),
        };
        usize::try_from(value).map_err(|_| format!("a size of {value} bytes"))
    }
}

impl Compressor {
    /// Appends the `size` bytes that a block expands to: at most one more, and none that the block cannot hold.
    fn decompress(self, packed: &[u8], size: usize, out: &mut Vec<u8>) -> Result<(), String> {
        // Streams grow the output as they go: a wrong size costs no memory.
        let mut stream = |reader: &mut dyn Read| {
            let read = reader.take((size as u64).saturating_add(1)).read_to_end(out);
            read.map(drop).map_err(|e| e.to_string())
        };
        match self {
            Compressor::Zlib => stream(&mut flate2::read::ZlibDecoder::new(packed)),
            Compressor::Lzma if packed.starts_with(XZ) => {
                stream(&mut lzma_rust2::XzReader::new_mem_limit(packed, true, LZMA_MEMORY_KIB))
            }
            Compressor::Lzma => {
                let reader = lzma_rust2::LzmaReader::new_mem_limit(packed, LZMA_MEMORY_KIB, None);
                stream(&mut reader.map_err(|e| e.to_string())?)
            }
            Compressor::Lz4 => {
                // A byte of an LZ4 block stands for at most 255.
                if size > packed.len().saturating_mul(255) {
                    return Err(format!("{} bytes cannot expand to {size}", packed.len()));
                }
                let start = out.len();
                out.resize(start + size, 0);
                let written = lz4_flex::block::decompress_into(packed, &mut out[start..]);
                out.truncate(start + written.map_err(|e| e.to_string())?);
                Ok(())
            }
        }
    }
}
