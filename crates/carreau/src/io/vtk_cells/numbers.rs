//! Names and numbers of the formats.

/// The cell data array with the reference numbers of lines, faces and volume cells.
pub const TAGS: &str = "ref";

/// Numbers of the cell types, as in `vtkCellType.h`.
pub mod kind {
    pub const EMPTY: u8 = 0;
    pub const VERTEX: u8 = 1;
    pub const POLY_VERTEX: u8 = 2;
    pub const LINE: u8 = 3;
    pub const POLY_LINE: u8 = 4;
    pub const TRIANGLE: u8 = 5;
    pub const TRIANGLE_STRIP: u8 = 6;
    pub const POLYGON: u8 = 7;
    pub const PIXEL: u8 = 8;
    pub const QUAD: u8 = 9;
    pub const TETRA: u8 = 10;
    pub const VOXEL: u8 = 11;
    pub const HEXAHEDRON: u8 = 12;
    pub const WEDGE: u8 = 13;
    pub const PYRAMID: u8 = 14;
    pub const BIQUADRATIC_QUAD: u8 = 28;
    pub const TRIQUADRATIC_HEXAHEDRON: u8 = 29;
}
