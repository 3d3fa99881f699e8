//! Where the JSON and the buffers of a file are.

use super::super::binary::{Cursor, Endian};
use super::super::percent;
use super::super::source::Source;
use super::super::text::shown;
use super::schema::{Buffer, Document, Head};
use crate::error::{Error, Place, Result};
use base64::Engine;
use base64::engine::general_purpose::GeneralPurposeConfig;
use base64::engine::{DecodePaddingMode, GeneralPurpose};
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::fs::File;
use std::io::Read;
use std::path::{Component, Path};

/// The first bytes of a GLB file.
const MAGIC: &[u8] = b"glTF";
/// The kind of the chunk with the JSON.
const JSON_CHUNK: u32 = u32::from_le_bytes(*b"JSON");
/// The kind of the chunk with the buffer.
const BINARY_CHUNK: u32 = u32::from_le_bytes(*b"BIN\0");

/// Unpadded base64 is accepted.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &base64::alphabet::STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent),
);

/// The JSON text and the binary chunk of a file.
pub struct Container<'a> {
    json: &'a [u8],
    binary: Option<&'a [u8]>,
    /// Where the JSON begins, in a GLB file.
    start: Option<usize>,
}

impl<'a> Container<'a> {
    /// Looks for the GLB chunks; a file without its signature is JSON as a whole.
    ///
    /// ```text
    /// "glTF" version length │ length "JSON" text │ length "BIN\0" bytes │ others, passed over
    /// ```
    pub fn open(source: &'a Source<'a>) -> Result<Self> {
        if !source.bytes.starts_with(MAGIC) {
            return Ok(Container { json: source.bytes, binary: None, start: None });
        }
        let mut cursor = Cursor::new(source, MAGIC.len(), Endian::Little);
        let version = cursor.u32()?;
        if version != 2 {
            return Err(cursor.error(format!("this is GLB of version {version}, only version 2 is read")));
        }
        let length = cursor.u32()? as usize;
        if length > source.bytes.len() {
            return Err(cursor.error(format!("{length} bytes are announced, the file has {}", source.bytes.len())));
        }
        let mut chunk = || -> Result<(u32, &'a [u8])> {
            let length = cursor.u32()? as usize;
            Ok((cursor.u32()?, cursor.take(length)?))
        };
        let (kind, json) = chunk()?;
        if kind != JSON_CHUNK {
            return Err(source.error(Place::Byte(12), "the first chunk is not JSON"));
        }
        // The chunk begins behind the head of the file (12 bytes) and its own (8 bytes).
        let after_json = 20 + json.len();
        let binary = if after_json < length { Some(chunk()?) } else { None };
        let binary = binary.filter(|(kind, _)| *kind == BINARY_CHUNK).map(|(_, bytes)| bytes);
        Ok(Container { json, binary, start: Some(20) })
    }

    /// The document; errors of the JSON carry the line, in GLB files the byte where the JSON begins.
    pub fn document(&self, source: &Source) -> Result<Document> {
        let malformed = |e: serde_json::Error| match self.start {
            Some(start) => source.error(Place::Byte(start as u64), format!("the JSON cannot be read: {e}")),
            None => source.error(Place::Line(e.line() as u64), format!("the JSON cannot be read: {e}")),
        };
        let text = self.json.strip_prefix(b"\xef\xbb\xbf").unwrap_or(self.json);
        let head: Head = serde_json::from_slice(text).map_err(malformed)?;
        let version = head.asset.version;
        if !version.is_empty() && version.split('.').next() != Some("2") {
            let version = shown(version.as_bytes());
            return Err(source.error(Place::File, format!("this is glTF of version {version}, only version 2 is read")));
        }
        serde_json::from_slice(text).map_err(malformed)
    }
}

/// The buffers of a file, loaded when they are first asked for.
pub struct Buffers<'a> {
    source: &'a Source<'a>,
    buffers: &'a [Buffer],
    binary: Option<&'a [u8]>,
    /// Decoded embedded buffers by number, external ones by address.
    embedded: BTreeMap<usize, Vec<u8>>,
    external: BTreeMap<&'a str, Vec<u8>>,
}

impl<'a> Buffers<'a> {
    pub fn new(source: &'a Source<'a>, buffers: &'a [Buffer], container: &Container<'a>) -> Self {
        Buffers { source, buffers, binary: container.binary, embedded: BTreeMap::new(), external: BTreeMap::new() }
    }

    /// The bytes of a buffer.
    pub fn get(&mut self, index: usize) -> Result<&[u8]> {
        let failed = |what: String| self.source.error(Place::File, what);
        let Some(buffer) = self.buffers.get(index) else {
            return Err(failed(format!("buffer {index} does not exist, there are {}", self.buffers.len())));
        };
        let bytes: &[u8] = match buffer.uri.as_deref() {
            None if index == 0 && self.binary.is_some() => self.binary.unwrap_or_default(),
            None => return Err(failed(format!("buffer {index} has neither an address nor a binary chunk"))),
            Some(uri) if uri.starts_with("data:") => match self.embedded.entry(index) {
                Entry::Occupied(known) => known.into_mut(),
                Entry::Vacant(new) => {
                    new.insert(decode_data_uri(uri).map_err(|e| failed(format!("buffer {index}: {e}")))?)
                }
            },
            Some(uri) => match self.external.entry(uri) {
                Entry::Occupied(known) => known.into_mut(),
                Entry::Vacant(new) => new.insert(load_beside(self.source.path, uri, buffer.byte_length)?),
            },
        };
        bytes.get(..buffer.byte_length).ok_or_else(|| {
            let found = bytes.len();
            self.source
                .error(Place::File, format!("buffer {index} has {found} bytes, {} are announced", buffer.byte_length))
        })
    }

    /// Number of bytes loaded so far, besides the file itself.
    pub fn external_size(&self) -> usize {
        self.external.values().map(Vec::len).sum()
    }
}

/// The bytes of `data:TYPE;base64,DATA`.
fn decode_data_uri(uri: &str) -> std::result::Result<Vec<u8>, String> {
    match uri.split_once(',') {
        Some((head, data)) if head.ends_with(";base64") => {
            BASE64.decode(data.trim_end()).map_err(|e| format!("no valid base64: {e}"))
        }
        _ => Err("a data address that is not base64".to_string()),
    }
}

/// Reads a file named by a document; it must lie beside the document or below.
fn load_beside(document: &Path, uri: &str, size: usize) -> Result<Vec<u8>> {
    let name = percent::decode(uri.as_bytes());
    let failed =
        |what: String| Error::read(document, Place::File, format!("the buffer '{}' {what}", shown(name.as_bytes())));
    let relative = Path::new(&name);
    let inside = relative.components().all(|part| matches!(part, Component::Normal(_) | Component::CurDir));
    if !inside || name.contains(['\\', ':']) || name.is_empty() {
        return Err(failed("is outside of the folder of this file and is not read".to_string()));
    }
    let path = document.parent().unwrap_or(Path::new("")).join(relative);
    let cannot = |e: std::io::Error| failed(format!("cannot be read: {e}"));
    let file = File::open(&path).map_err(cannot)?;
    let found = file.metadata().map_err(cannot)?;
    if !found.is_file() || found.len() < size as u64 {
        return Err(failed(format!("has {} bytes, {size} are announced", found.len())));
    }
    let mut bytes = Vec::new();
    file.take(size as u64).read_to_end(&mut bytes).map_err(cannot)?;
    Ok(bytes)
}
