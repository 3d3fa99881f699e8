//! The container: a ZIP archive whose parts are named by relationships.

use crate::error::{Error, Place, Result};
use crate::io::source::Source;
use crate::io::text::shown;
use roxmltree::{Document, ParsingOptions};
use std::io::{Cursor, Read, Write};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipArchive, ZipWriter};

/// Bytes that a part may unpack to for each of the file's: text of coordinates shrinks to a fourth, of repeated ones to a
/// thirtieth. What expands beyond is meant to exhaust the memory.
const PART_EXPANSION: u64 = 200;
/// Bytes that any file may unpack to.
const ALWAYS: u64 = 1 << 20;
/// Bytes that no part may exceed.
const LARGEST_PART: u64 = 4 << 30;
/// Where the model is unless a relationship says otherwise.
const MODEL: &str = "3D/3dmodel.model";
/// The end of the type of the relationship that names the model.
const MODEL_TYPE: &str = "/3dmodel";

/// An archive that is read.
pub struct Package<'a> {
    source: &'a Source<'a>,
    archive: ZipArchive<Cursor<&'a [u8]>>,
    /// Bytes that may still be unpacked.
    left: u64,
}

impl<'a> Package<'a> {
    pub fn open(source: &'a Source<'a>) -> Result<Self> {
        let wrong = |e: zip::result::ZipError| {
            source.error(Place::File, format!("this is not a 3MF package (a ZIP archive): {e}"))
        };
        let archive = ZipArchive::new(Cursor::new(source.bytes)).map_err(wrong)?;
        let left = (source.bytes.len() as u64).saturating_mul(PART_EXPANSION).clamp(ALWAYS, LARGEST_PART);
        Ok(Package { source, archive, left })
    }

    fn error(&self, part: &str, what: impl std::fmt::Display) -> Error {
        self.source.error(Place::File, format!("part '{}': {what}", shown(part.as_bytes())))
    }

    /// The text of a part.
    pub fn part(&mut self, name: &str) -> Result<String> {
        let name = name.trim_start_matches('/');
        let limit = self.left;
        let mut bytes = Vec::new();
        let read = match self.archive.by_name(name) {
            Ok(part) => part.take(limit + 1).read_to_end(&mut bytes).map_err(|e| e.to_string()),
            Err(e) => Err(e.to_string()),
        };
        read.map_err(|what| self.error(name, what))?;
        if bytes.len() as u64 > limit {
            return Err(self.error(name, "it unpacks to more than a model of this size can have"));
        }
        self.left -= bytes.len() as u64;
        String::from_utf8(bytes).map_err(|_| self.error(name, "it is not UTF-8 text"))
    }

    /// The name of the part with the model.
    pub fn model(&mut self) -> String {
        let Ok(text) = self.part("_rels/.rels") else { return MODEL.to_string() };
        let Ok(document) = parsed(&text) else { return MODEL.to_string() };
        let is_model =
            |node: &roxmltree::Node| node.has_tag_name("Relationship") || node.tag_name().name() == "Relationship";
        let mut named = document.descendants().filter(is_model);
        let wanted = named.find(|node| node.attribute("Type").is_some_and(|t| t.ends_with(MODEL_TYPE)));
        wanted.and_then(|node| node.attribute("Target")).unwrap_or(MODEL).to_string()
    }
}

/// The XML of a part; without a document type there are no entities, so nothing in it can expand.
pub fn parsed(text: &str) -> std::result::Result<Document<'_>, roxmltree::Error> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    Document::parse_with_options(text, ParsingOptions { allow_dtd: false, ..ParsingOptions::default() })
}

/// The part that names the kinds of the others.
const TYPES: &str = concat!(
    "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n",
    "<Types xmlns=\"http://schemas.openxmlformats.org/package/2006/content-types\">",
    "<Default Extension=\"rels\" ContentType=\"application/vnd.openxmlformats-package.relationships+xml\"/>",
    "<Default Extension=\"model\" ContentType=\"application/vnd.ms-package.3dmanufacturing-3dmodel+xml\"/></Types>\n"
);
/// The part that points to the model.
const RELATIONSHIPS: &str = concat!(
    "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n",
    "<Relationships xmlns=\"http://schemas.openxmlformats.org/package/2006/relationships\">",
    "<Relationship Target=\"/3D/3dmodel.model\" Id=\"rel0\" ",
    "Type=\"http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel\"/></Relationships>\n"
);

/// Packs a model.
pub fn pack(model: &[u8], out: &mut Vec<u8>) -> Result<()> {
    let failed = |e: &dyn std::fmt::Display| Error::Bug(format!("packing in memory failed: {e}"));
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    // No time of day: equal meshes give equal bytes.
    let large = model.len() as u64 > u64::from(u32::MAX) / 2;
    let options = SimpleFileOptions::default().compression_method(CompressionMethod::Deflated).large_file(large);
    let options = options.last_modified_time(zip::DateTime::default());
    for (name, bytes) in
        [("[Content_Types].xml", TYPES.as_bytes()), ("_rels/.rels", RELATIONSHIPS.as_bytes()), (MODEL, model)]
    {
        archive.start_file(name, options).map_err(|e| failed(&e))?;
        archive.write_all(bytes).map_err(|e| failed(&e))?;
    }
    let packed = archive.finish().map_err(|e| failed(&e))?;
    out.extend_from_slice(packed.get_ref());
    Ok(())
}
