use super::super::binary::Endian;
use super::super::source::{Source, WriteOptions};
use super::super::vtk_arrays::Numbers;
use super::super::vtk_cells::samples::{any_mesh, assert_same, mangle, one_of_everything};
use super::super::vtk_cells::{CellTable, kind};
use super::payload::Compressor;
use super::{read, write_vtp, write_vtu};
use crate::error::{Error, Result};
use crate::mesh::{Cells, Column, RawMesh};
use base64::Engine;
use base64::engine::general_purpose::STANDARD as BASE64;
use proptest::prelude::*;
use std::io::Write;
use std::path::Path;

fn parse(bytes: &[u8]) -> Result<RawMesh> {
    let mesh = read(&Source { path: Path::new("a.vtu"), bytes })?;
    mesh.check()?;
    Ok(mesh)
}

fn vtu(mesh: &RawMesh, ascii: bool) -> Vec<u8> {
    let mut out = Vec::new();
    write_vtu(mesh, &WriteOptions { ascii }, &mut out).unwrap();
    out
}

fn vtp(mesh: &RawMesh, ascii: bool) -> Vec<u8> {
    let mut out = Vec::new();
    write_vtp(mesh, &WriteOptions { ascii }, &mut out).unwrap();
    out
}

/// Ways to store arrays that the writer does not use but the reader knows.
#[derive(Debug, Clone, Copy)]
struct Variant {
    big: bool,
    wide: bool,
    compressor: Option<Compressor>,
    appended: bool,
    raw: bool,
    /// Head and data in one base64 stream.
    together: bool,
    /// lzma in its own container instead of xz.
    alone: bool,
    block: usize,
}

fn any_variant() -> impl Strategy<Value = Variant> {
    let compressor = prop_oneof![
        Just(None),
        Just(Some(Compressor::Zlib)),
        Just(Some(Compressor::Lzma)),
        Just(Some(Compressor::Lz4))
    ];
    (any::<[bool; 6]>(), compressor, 8usize..200).prop_map(
        |([big, wide, appended, raw, together, alone], compressor, block)| Variant {
            big,
            wide,
            compressor,
            appended,
            raw,
            together,
            alone,
            block,
        },
    )
}

impl Variant {
    fn compress(&self, data: &[u8]) -> Vec<u8> {
        match self.compressor {
            Some(Compressor::Zlib) => {
                let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::best());
                encoder.write_all(data).unwrap();
                encoder.finish().unwrap()
            }
            Some(Compressor::Lzma) if self.alone => {
                let options = lzma_rust2::LzmaOptions::with_preset(1);
                let mut encoder = lzma_rust2::LzmaWriter::new_use_header(Vec::new(), &options, None).unwrap();
                encoder.write_all(data).unwrap();
                encoder.finish().unwrap()
            }
            Some(Compressor::Lzma) => {
                let mut encoder = lzma_rust2::XzWriter::new(Vec::new(), lzma_rust2::XzOptions::with_preset(1)).unwrap();
                encoder.write_all(data).unwrap();
                encoder.finish().unwrap()
            }
            Some(Compressor::Lz4) => lz4_flex::block::compress(data),
            None => data.to_vec(),
        }
    }

    fn head(&self, words: &[usize]) -> Vec<u8> {
        let word = |&word: &usize| match (self.wide, self.big) {
            (true, true) => (word as u64).to_be_bytes().to_vec(),
            (true, false) => (word as u64).to_le_bytes().to_vec(),
            (false, true) => (word as u32).to_be_bytes().to_vec(),
            (false, false) => (word as u32).to_le_bytes().to_vec(),
        };
        words.iter().flat_map(word).collect()
    }

    fn array(&self, numbers: Numbers) -> Vec<u8> {
        let mut data = Vec::new();
        numbers.push_bytes(if self.big { Endian::Big } else { Endian::Little }, &mut data);
        let (head, body) = if self.compressor.is_none() {
            (self.head(&[data.len()]), data)
        } else {
            let blocks: Vec<Vec<u8>> = data.chunks(self.block).map(|block| self.compress(block)).collect();
            let mut words = vec![blocks.len(), self.block, data.len() % self.block];
            words.extend(blocks.iter().map(Vec::len));
            (self.head(&words), blocks.concat())
        };
        match (self.appended && self.raw, self.together) {
            (true, _) => [head, body].concat(),
            (false, true) => BASE64.encode([head, body].concat()).into_bytes(),
            (false, false) => (BASE64.encode(head) + &BASE64.encode(body)).into_bytes(),
        }
    }

    /// The mesh as unstructured grid, without data.
    fn file(&self, mesh: &RawMesh) -> Vec<u8> {
        let table = CellTable::new(mesh).unwrap();
        let points: Vec<f64> = mesh.points.iter().flat_map(|p| p.to_array()).collect();
        let arrays = [
            ("Points", "Points", Numbers::F64(&points), 3),
            ("Cells", "connectivity", Numbers::I64(&table.corners), 1),
            ("Cells", "offsets", Numbers::I64(&table.ends), 1),
            ("Cells", "types", Numbers::U8(&table.kinds), 1),
        ];
        let mut tail = Vec::new();
        let mut text = format!(
            "<VTKFile type='UnstructuredGrid' byte_order='{}' header_type='{}'{}><UnstructuredGrid><Piece>",
            if self.big { "BigEndian" } else { "LittleEndian" },
            if self.wide { "UInt64" } else { "UInt32" },
            match self.compressor {
                Some(Compressor::Zlib) => " compressor='vtkZLibDataCompressor'",
                Some(Compressor::Lzma) => " compressor='vtkLZMADataCompressor'",
                Some(Compressor::Lz4) => " compressor='vtkLZ4DataCompressor'",
                None => "",
            }
        );
        for section in ["Points", "Cells"] {
            text += &format!("<{section}>");
            for (_, name, numbers, width) in arrays.iter().filter(|array| array.0 == section) {
                let bytes = self.array(*numbers);
                text += &format!("<DataArray type='{}' Name='{name}' ", numbers.xml_type());
                text += &format!("NumberOfComponents='{width}' ");
                if self.appended {
                    text += &format!("format='appended' offset='{}'/>", tail.len());
                    tail.extend(bytes);
                } else {
                    text += &format!("format='binary'>\n  {}\n</DataArray>", String::from_utf8(bytes).unwrap());
                }
            }
            text += &format!("</{section}>");
        }
        text += "</Piece></UnstructuredGrid>";
        let mut file = text.into_bytes();
        if self.appended {
            file.extend(format!("<AppendedData encoding='{}'>\n _", if self.raw { "raw" } else { "base64" }).bytes());
            file.extend(tail);
            file.extend(b"\n</AppendedData>");
        }
        file.extend(b"</VTKFile>");
        file
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn every_mesh_comes_back_from_vtu_to_the_last_bit(mesh in any_mesh(true), ascii in any::<bool>()) {
        assert_same(&parse(&vtu(&mesh, ascii)).unwrap(), &mesh);
    }

    #[test]
    fn every_surface_comes_back_from_vtp_to_the_last_bit(mesh in any_mesh(false), ascii in any::<bool>()) {
        assert_same(&parse(&vtp(&mesh, ascii)).unwrap(), &mesh);
    }

    #[test]
    fn all_ways_to_store_arrays_are_read(mesh in any_mesh(true), variant in any_variant()) {
        let mut bare = RawMesh { attributes: Default::default(), ..mesh };
        bare.edge_tags.fill(0);
        bare.cells.tags.clear();
        assert_same(&parse(&variant.file(&bare)).unwrap(), &bare);
    }

    #[test]
    fn mangled_files_never_panic(
        variant in any_variant(),
        which in 0usize..4,
        edits in proptest::collection::vec(any::<(u16, u16, u8)>(), 1..6),
    ) {
        let mut mesh = one_of_everything();
        let valid = match which {
            0 => vtu(&mesh, true),
            1 => vtu(&mesh, false),
            2 => {
                mesh.cells = Cells::default();
                vtp(&mesh, true)
            }
            _ => variant.file(&mesh),
        };
        let _ = parse(&mangle(valid, &edits));
    }

    /// Damage behind base64 and compression, which mangled files seldom reach.
    #[test]
    fn mangled_payloads_never_panic(
        variant in any_variant(),
        edits in proptest::collection::vec(any::<(u16, u16, u8)>(), 1..4),
    ) {
        let variant = Variant { appended: true, raw: true, ..variant };
        let file = variant.file(&one_of_everything());
        let tail = file.windows(2).position(|w| w == b" _").unwrap() + 2;
        let mut mangled = file[..tail].to_vec();
        mangled.extend(mangle(file[tail..].to_vec(), &edits));
        let _ = parse(&mangled);
    }
}

/// Two pieces of polydata in text, with all parts.
const PIECES: &str = r#"<?xml version="1.0"?>
<VTKFile type="PolyData" version="0.1">
<PolyData>
<FieldData><DataArray type="Float64" Name="time" NumberOfTuples="1">1</DataArray></FieldData>
<Piece NumberOfPoints="4" NumberOfVerts="1" NumberOfLines="0" NumberOfStrips="1" NumberOfPolys="1">
<PointData><DataArray type="Float32" Name="size">1 2 3 4</DataArray><DataArray type="Int8" Name="odd">1 2 3 4</DataArray></PointData>
<CellData>
<DataArray type="Int64" Name="region">10 11 12</DataArray>
<Array type="String" Name="words">97 0 98 0 99 0</Array>
<DataArray type="UInt8" Name="RGB &amp; more" NumberOfComponents="3">0 0 0 1 2 3 4 5 6</DataArray>
</CellData>
<Points><DataArray type="Float32" NumberOfComponents="3">0 0 0 1 0 0 1 1 0 0 1 0
<InformationKey name="x"><Value index="0">7</Value></InformationKey></DataArray></Points>
<Verts><DataArray type="Int32" Name="connectivity">0</DataArray><DataArray type="Int32" Name="offsets">1</DataArray></Verts>
<Strips><DataArray type="Int32" Name="connectivity">0 1 3 2</DataArray><DataArray type="Int32" Name="offsets">4</DataArray></Strips>
<Polys><DataArray type="Int32" Name="connectivity">3 2 1 0</DataArray><DataArray type="Int32" Name="offsets">4</DataArray></Polys>
<Lines/>
</Piece>
<Piece NumberOfPoints="3" NumberOfVerts="0" NumberOfLines="1" NumberOfStrips="0" NumberOfPolys="1">
<PointData><DataArray type="Float64" Name="size">5 6 7</DataArray></PointData>
<CellData>
<DataArray type="Int64" Name="region">0 22</DataArray>
<DataArray type="UInt8" Name="RGB &amp; more" NumberOfComponents="3">0 0 0 7 8 9</DataArray>
</CellData>
<Points><DataArray type="Float64" NumberOfComponents="3">0 0 5 1 0 5 1 1 5</DataArray></Points>
<Lines><DataArray type="Int32" Name="connectivity">0 1 2</DataArray><DataArray type="Int32" Name="offsets">3</DataArray></Lines>
<Polys><DataArray type="Int32" Name="connectivity">0 1 2</DataArray><DataArray type="Int32" Name="offsets">3</DataArray></Polys>
</Piece>
</PolyData>
</VTKFile>"#;

#[test]
fn pieces_are_joined_in_the_order_of_the_cell_data() {
    let mesh = parse(PIECES.as_bytes()).unwrap();
    assert_eq!(mesh.points.len(), 7);
    let faces: Vec<&[u32]> = mesh.faces.iter().collect();
    assert_eq!(faces, [&[3, 2, 1, 0][..], &[0, 1, 3], &[3, 1, 2], &[4, 5, 6]]);
    assert_eq!(mesh.edges, [[4, 5], [5, 6]]);
    assert_eq!(mesh.attributes.face["region"], Column::Label(vec![11, 12, 12, 22]));
    let colors = vec![[1, 2, 3, 255], [4, 5, 6, 255], [4, 5, 6, 255], [7, 8, 9, 255]];
    assert_eq!(mesh.attributes.face["RGB & more"], Column::Color(colors));
    assert_eq!(mesh.attributes.vertex["size"], Column::Scalar((1..8).map(f64::from).collect()));
    assert!(!mesh.attributes.vertex.contains_key("odd"));
    for left_out in ["field data", "words", "odd"] {
        assert_eq!(mesh.notes.iter().filter(|n| n.contains(left_out)).count(), 1, "{left_out}: {:?}", mesh.notes);
    }
}

#[test]
fn errors_say_where() {
    let error = |from: &str, to: &str| parse(PIECES.replacen(from, to, 1).as_bytes()).unwrap_err().to_string();
    assert!(
        error("NumberOfPoints=\"4\"", "NumberOfPoints=\"5\"").contains("line 5: NumberOfPoints is '5', there are 4")
    );
    assert!(error("NumberOfPolys=\"1\"", "NumberOfPolys=\"2\"").contains("NumberOfPolys"));
    assert!(error("3 2 1 0", "3 2 1 4").contains("point 4"));
    assert!(error("3 2 1 0", "3 2 1 x").contains("line 16: 'x'"));
    assert!(error("3 2 1 0", "3 2 1 -1").contains("out of range"));
    assert!(error("Name=\"offsets\"", "Name=\"offset\"").contains("'offsets' is missing"));
    assert!(error("</PolyData>", "</Poly>").contains("line 29: "));
    assert!(error("<PolyData>", "<!DOCTYPE x [<!ENTITY a 'b'>]><PolyData>").contains("XML"));
    assert!(error("type=\"PolyData\"", "type=\"ImageData\"").contains("ImageData"));
    assert!(error("type=\"PolyData\"", "type=\"PPolyData\"").contains("parts"));
    assert!(error("type=\"Float64\" NumberOf", "type=\"Complex\" NumberOf").contains("Complex"));
}

#[test]
fn entities_of_a_document_type_are_not_expanded() {
    let bomb = "<!DOCTYPE a [<!ENTITY a 'aaaaaaaaaa'><!ENTITY b '&a;&a;&a;&a;'>]><VTKFile>&b;</VTKFile>";
    assert!(parse(bomb.as_bytes()).is_err());
    // Deep nesting costs no stack.
    let deep = "<a>".repeat(200_000);
    assert!(parse(deep.as_bytes()).is_err());
}

/// A file whose only array announces blocks of these sizes and holds this block.
fn one_block(compressor: &str, sizes: [u64; 4], block: &[u8]) -> Vec<u8> {
    let head: Vec<u8> = sizes.iter().flat_map(|word| word.to_le_bytes()).collect();
    let array = BASE64.encode(head) + &BASE64.encode(block);
    format!(
        "<VTKFile type='PolyData' header_type='UInt64' compressor='vtk{compressor}DataCompressor'><PolyData><Piece><Points>\
         <DataArray type='Float64' format='binary'>{array}</DataArray></Points></Piece></PolyData></VTKFile>"
    )
    .into_bytes()
}

#[test]
fn lying_sizes_are_refused() {
    let variant = |compressor| Variant {
        big: false,
        wide: true,
        compressor: Some(compressor),
        appended: false,
        raw: false,
        together: false,
        alone: false,
        block: 1 << 20,
    };
    let names = [("ZLib", Compressor::Zlib), ("LZMA", Compressor::Lzma), ("LZ4", Compressor::Lz4)];
    for (name, compressor) in names {
        let block = variant(compressor).compress(&[0; 480]);
        let size = block.len() as u64;
        let read = |sizes: [u64; 4]| parse(&one_block(name, sizes, &block));
        assert_eq!(read([1, 480, 0, size]).unwrap().points.len(), 20, "{name}");
        assert_eq!(read([1, 999, 480, size]).unwrap().points.len(), 20, "{name}");
        for wrong in [
            [1, 240, 0, size],
            [1, 960, 0, size],
            [1, u64::MAX, 0, size],
            [1, 1 << 40, 0, size],
            [1, 480, 0, size + 1],
            [1, 480, 0, size - 1],
            [2, 480, 0, size],
            [u64::MAX, 480, 0, size],
            [1 << 61, 480, 0, size],
        ] {
            assert!(read(wrong).is_err(), "{name} {wrong:?}");
        }
    }
}

#[test]
fn a_bomb_shared_by_many_arrays_is_refused() {
    let variant = Variant {
        big: false,
        wide: false,
        compressor: Some(Compressor::Zlib),
        appended: true,
        raw: true,
        together: false,
        alone: false,
        block: 1 << 20,
    };
    let zeros = vec![0u8; 1 << 20];
    let array = variant.array(Numbers::U8(&zeros));
    let reference = "<DataArray type='UInt8' Name='x' NumberOfComponents='9' format='appended' offset='0'/>";
    let references: String = (0..2000).map(|k| reference.replace('x', &format!("x{k}"))).collect();
    let mut file = b"<VTKFile type='PolyData' compressor='vtkZLibDataCompressor'><PolyData><Piece><PointData>".to_vec();
    file.extend(references.bytes());
    file.extend(b"</PointData></Piece></PolyData><AppendedData encoding='raw'>_");
    file.extend(array);
    file.extend(b"</AppendedData></VTKFile>");
    assert!(parse(&file).unwrap_err().to_string().contains("impossible size"));
}

#[test]
fn volume_cells_do_not_fit_into_polydata() {
    let refused = write_vtp(&one_of_everything(), &WriteOptions::default(), &mut Vec::new());
    assert!(matches!(refused, Err(Error::Input { remedy, .. }) if remedy.contains("--boundary")));
}

#[test]
fn kinds_of_faces_follow_their_corners() {
    let table = CellTable::new(&one_of_everything()).unwrap();
    let want = [
        kind::LINE,
        kind::LINE,
        kind::TRIANGLE,
        kind::QUAD,
        kind::POLYGON,
        kind::TETRA,
        kind::HEXAHEDRON,
        kind::WEDGE,
        kind::PYRAMID,
    ];
    assert_eq!(table.kinds, want);
}
