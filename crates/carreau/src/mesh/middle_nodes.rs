//! The middle nodes of cells of second order.

/// The nodes of hexahedra beyond their corners, as indices of points.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SecondOrder {
    /// Of every hexahedron: edges, faces, the middle, in the order of VTK's triquadratic hexahedron.
    pub hexes: Vec<[u32; 19]>,
    /// Of every face: its four sides, from the first corner, and its middle.
    pub quads: Vec<[u32; 5]>,
}
