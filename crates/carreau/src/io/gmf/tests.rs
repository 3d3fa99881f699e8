//! Every version, in both byte orders.

use super::*;
use crate::io::round_trips::{content, read as read_as};
use glam::DVec3;

/// Appends numbers as a version and byte order ask.
struct Builder {
    version: Version,
    endian: Endian,
    out: Vec<u8>,
}

impl Builder {
    fn new(version: Version, endian: Endian) -> Self {
        let mut builder = Builder { version, endian, out: Vec::new() };
        builder.int(1);
        builder.int(version as i32);
        builder
    }

    fn push(&mut self, mut big_endian: Vec<u8>) {
        if self.endian == Endian::Little {
            big_endian.reverse();
        }
        self.out.extend(big_endian);
    }

    fn int(&mut self, k: i32) {
        self.push(k.to_be_bytes().to_vec());
    }

    fn sized(&mut self, k: i64, size: usize) {
        self.push(k.to_be_bytes()[8 - size..].to_vec());
    }

    fn real(&mut self, x: f64) {
        self.push(if self.version.real() == 4 { (x as f32).to_be_bytes().to_vec() } else { x.to_be_bytes().to_vec() });
    }

    /// A keyword, the position behind `size` further bytes, and these.
    fn section(&mut self, code: i32, size: usize, content: impl FnOnce(&mut Self)) {
        self.int(code);
        let bytes = self.version.position();
        self.sized((self.out.len() + bytes + size) as i64, bytes);
        content(self);
    }

    fn rows(&mut self, code: i32, rows: &[&[i64]]) {
        let whole = self.version.whole();
        let numbers: Vec<i64> = rows.iter().flat_map(|row| row.iter().copied()).collect();
        self.section(code, whole * (1 + numbers.len()), |b| {
            b.sized(rows.len() as i64, whole);
            numbers.iter().for_each(|&k| b.sized(k, whole));
        });
    }

    fn vertices(&mut self, dimension: usize, points: &[[f64; 3]]) {
        let (whole, real) = (self.version.whole(), self.version.real());
        self.section(DIMENSION, 4, |b| b.int(dimension as i32));
        self.section(VERTICES, whole + points.len() * (dimension * real + whole), |b| {
            b.sized(points.len() as i64, whole);
            for p in points {
                p[..dimension].iter().for_each(|&x| b.real(x));
                b.sized(9, whole);
            }
        });
    }
}

const SQUARE: [[f64; 3]; 4] = [[0.0, 0.0, 0.0], [1.5, 0.0, 0.0], [1.5, 1.0, 0.0], [0.0, 1.0, 0.0]];
const VERSIONS: [Version; 4] = [Version::V1, Version::V2, Version::V3, Version::V4];

#[test]
fn all_versions_in_both_byte_orders() {
    for (version, endian) in VERSIONS.into_iter().flat_map(|v| [(v, Endian::Little), (v, Endian::Big)]) {
        for dimension in [2, 3] {
            let mut b = Builder::new(version, endian);
            b.vertices(dimension, &SQUARE);
            b.rows(7, &[&[4, 3, 2, 1, -5]]);
            b.rows(77, &[&[1, 2, 3]]);
            b.rows(6, &[&[1, 2, 3, 0], &[1, 3, 4, 8]]);
            b.int(END);
            b.sized(0, version.position());
            let mesh = read_as("meshb", &b.out).unwrap();
            assert_eq!(mesh.points, SQUARE.map(DVec3::from));
            let faces: Vec<&[u32]> = mesh.faces.iter().collect();
            assert_eq!(faces, [&[3, 2, 1, 0][..], &[0, 1, 2], &[0, 2, 3]]);
            assert_eq!(mesh.attributes.face["ref"], crate::mesh::Column::Label(vec![-5, 0, 8]));
            assert_eq!(mesh.notes, ["sections left out: keyword 77"]);
        }
    }
}

#[test]
fn every_version_that_is_written_is_read_back() {
    let mut b = Builder::new(Version::V2, Endian::Little);
    b.vertices(3, &SQUARE);
    b.rows(5, &[&[1, 2, 3]]);
    b.rows(8, &[&[1, 2, 3, 4, 7]]);
    b.rows(13, &[&[2]]);
    let mesh = read_as("meshb", &b.out).unwrap();
    for version in VERSIONS {
        let (mut out, sections) = (Vec::new(), Sections::of(&mesh));
        write_version(&sections, version, &mut out);
        assert_eq!(out.len(), file_size(&sections, version));
        assert_eq!(content(&read_as("meshb", &out).unwrap()), content(&mesh));
    }
}

#[test]
fn the_version_grows_with_the_file() {
    let most = i32::MAX as usize;
    assert_eq!(smallest_version(most, most), Version::V2);
    assert_eq!(smallest_version(most, most + 1), Version::V3);
    assert_eq!(smallest_version(most + 1, most + 1), Version::V4);
}

/// The error that a file with this change at the end gives.
fn error_of(change: impl FnOnce(&mut Builder)) -> String {
    let mut b = Builder::new(Version::V2, Endian::Little);
    b.vertices(3, &SQUARE);
    change(&mut b);
    read_as("meshb", &b.out).unwrap_err().to_string()
}

#[test]
fn broken_chains_and_counts_are_named_with_their_byte() {
    let end = 8 + 12 + 12 + 4 * 28;
    let back = error_of(|b| [6, 8, 0].into_iter().for_each(|k| b.int(k)));
    assert!(back.starts_with(&format!("test: byte {}: Triangles points to byte 8", end + 8)), "{back}");
    let beyond = error_of(|b| [6, 1 << 30, 0].into_iter().for_each(|k| b.int(k)));
    assert!(beyond.contains("Triangles points to byte 1073741824"), "{beyond}");
    let negative = error_of(|b| [6, -4, 0].into_iter().for_each(|k| b.int(k)));
    assert!(negative.contains("Triangles points to byte -4"), "{negative}");
    let overlap = error_of(|b| b.section(6, 8, |b| [1, 1, 2, 3, 0].into_iter().for_each(|k| b.int(k))));
    assert!(overlap.contains("Triangles ends here, but the next section is announced"), "{overlap}");
    let count = error_of(|b| [6, 0, i32::MAX].into_iter().for_each(|k| b.int(k)));
    assert!(count.contains("2147483647 Triangles are announced"), "{count}");
    let index = error_of(|b| b.rows(6, &[&[1, 2, 3, 0], &[1, 2, 5, 0]]));
    let byte = end + 12 + 16 + 8;
    assert_eq!(index, format!("test: byte {byte}: Triangles, row 2: vertex 5 does not exist, there are 4"));
    let zero = error_of(|b| b.rows(6, &[&[1, 0, 3, 0]]));
    assert!(zero.contains("Triangles: 0 is not an index"), "{zero}");
    let twice = error_of(|b| b.vertices(3, &SQUARE));
    assert!(twice.contains("second section Vertices"), "{twice}");
}

#[test]
fn other_files_are_refused() {
    for (bytes, what) in [
        (&b"\x02\0\0\0\x02\0\0\0"[..], "the number 1 is expected"),
        (b"\x01\0\0\0\x05\0\0\0", "version 5"),
        (b"\x01\0\0", "the number 1 is expected"),
        (b"\x01\0\0\0\x02\0\0\0", "no section Vertices"),
    ] {
        let error = read_as("meshb", bytes).unwrap_err().to_string();
        assert!(error.contains(what), "{error}");
    }
}
