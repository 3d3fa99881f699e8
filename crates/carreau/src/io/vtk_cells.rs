//! VTK's cell types to and from [`RawMesh`](crate::mesh::RawMesh), with the data on points and cells; shared by the legacy and XML formats.
//!
//! VTK numbers all cells of a dataset in one list and its cell data follows that list. [`RawMesh`] keeps faces, lines and
//! volume cells apart, with columns on faces only. So the reader notes for every element which cell it came from, and
//! gathers the columns of the faces; the writer pads them with zeros for the lines before and the volume cells behind.
//! The column [`TAGS`](numbers::TAGS) is the exception: it carries the reference numbers of lines and volume cells too.
//!
//! Corner orders are VTK's (M. Schroeder et al., *The Visualization Toolkit*, figure "linear cell types"), except for the
//! two cells of image data, whose corners come in grid order:
//!
//! ```text
//! pixel (8)   2───3        quad   3───2        voxel (11): two such layers, one above the other
//!             │   │    →          │   │
//!             0───1               0───1
//! ```

mod numbers;
mod read;
#[cfg(test)]
pub(super) mod samples;
#[cfg(test)]
mod tests;
mod write;

pub(super) use numbers::kind;
pub(super) use read::{CellReader, strip_triangles};
pub(super) use write::{CellTable, check_writable, warnings};
