//! The element types of Gmsh: what they are, how many nodes they have. The corners always come first.

/// What an element is, its order apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Shape {
    Point,
    Line,
    Triangle,
    Quad,
    Tet,
    Hex,
    Wedge,
    Pyramid,
    /// A quad with nodes in the middle of its sides and in its own.
    Quad9,
    /// A hexahedron with nodes in the middle of its edges and faces and in its own.
    Hex27,
}

impl Shape {
    /// Number of corners; of shapes of second order that of all nodes.
    pub fn corners(self) -> usize {
        match self {
            Shape::Point => 1,
            Shape::Line => 2,
            Shape::Triangle => 3,
            Shape::Quad | Shape::Tet => 4,
            Shape::Pyramid => 5,
            Shape::Wedge => 6,
            Shape::Hex => 8,
            Shape::Quad9 => 9,
            Shape::Hex27 => 27,
        }
    }

    /// Dimension of the entities that it is an element of.
    pub fn dimension(self) -> i32 {
        match self {
            Shape::Point => 0,
            Shape::Line => 1,
            Shape::Triangle | Shape::Quad | Shape::Quad9 => 2,
            Shape::Tet | Shape::Hex | Shape::Wedge | Shape::Pyramid | Shape::Hex27 => 3,
        }
    }

    /// The type number of the element, of first order but for two.
    pub fn code(self) -> i32 {
        match self {
            Shape::Line => 1,
            Shape::Triangle => 2,
            Shape::Quad => 3,
            Shape::Tet => 4,
            Shape::Hex => 5,
            Shape::Wedge => 6,
            Shape::Pyramid => 7,
            Shape::Point => 15,
            Shape::Quad9 => 10,
            Shape::Hex27 => 12,
        }
    }
}

/// Gmsh's order of the nodes of a hexahedron with 27, as places in VTK's.
pub(super) const HEX27: [usize; 27] =
    [0, 1, 2, 3, 4, 5, 6, 7, 8, 11, 16, 9, 17, 10, 18, 19, 12, 15, 13, 14, 24, 22, 20, 21, 23, 25, 26];

/// Elements of first order.
const FIRST_ORDER: [Shape; 8] =
    [Shape::Line, Shape::Triangle, Shape::Quad, Shape::Tet, Shape::Hex, Shape::Wedge, Shape::Pyramid, Shape::Point];

/// Elements of higher order: type numbers with their number of nodes, complete ones first, then those without inner
/// nodes (or, of triangles and tetrahedra, without inner nodes of faces or volume).
const HIGHER_ORDER: [(Shape, &[(i32, usize)]); 7] = [
    (Shape::Line, &[(8, 3), (26, 4), (27, 5), (28, 6), (62, 7), (63, 8), (64, 9), (65, 10), (66, 11)]),
    (Shape::Triangle, &[(9, 6), (21, 10), (23, 15), (25, 21), (42, 28), (43, 36), (44, 45), (45, 55), (46, 66)]),
    (Shape::Triangle, &[(20, 9), (22, 12), (24, 15), (52, 18), (53, 21), (54, 24), (55, 27), (56, 30)]),
    (
        Shape::Quad,
        &[(10, 9), (36, 16), (37, 25), (38, 36), (47, 49), (48, 64), (49, 81), (50, 100), (51, 121), (16, 8)],
    ),
    (Shape::Tet, &[(11, 10), (29, 20), (30, 35), (31, 56), (71, 84), (72, 120), (73, 165), (74, 220), (75, 286)]),
    (Shape::Hex, &[(12, 27), (92, 64), (93, 125), (94, 216), (95, 343), (96, 512), (97, 729), (98, 1000), (17, 20)]),
    (
        Shape::Wedge,
        &[(13, 18), (90, 40), (91, 75), (106, 126), (107, 196), (108, 288), (109, 405), (110, 550), (18, 15)],
    ),
];

/// Codes and numbers of nodes of pyramids of higher order.
const PYRAMIDS: [(i32, usize); 9] =
    [(14, 14), (118, 30), (119, 55), (120, 91), (121, 140), (122, 204), (123, 285), (124, 385), (19, 13)];

/// An element type.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct ElementType {
    pub shape: Shape,
    /// Number of nodes, corners included.
    pub nodes: usize,
}

/// The element type of a number; `None` for those not known: polygons, polyhedra, sub-elements, the rarest orders.
pub(super) fn element_type(code: i32) -> Option<ElementType> {
    if let Some(&shape) = FIRST_ORDER.iter().find(|s| s.code() == code) {
        return Some(ElementType { shape, nodes: shape.corners() });
    }
    let rows = HIGHER_ORDER.into_iter().chain([(Shape::Pyramid, &PYRAMIDS[..])]);
    rows.flat_map(|(shape, types)| types.iter().map(move |&(c, nodes)| (c, ElementType { shape, nodes })))
        .find_map(|(c, element)| (c == code).then_some(element))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_number_is_given_once() {
        let higher = HIGHER_ORDER.iter().flat_map(|(_, types)| types.iter()).chain(&PYRAMIDS).map(|&(code, _)| code);
        let mut codes: Vec<i32> = FIRST_ORDER.iter().map(|s| s.code()).chain(higher).collect();
        let count = codes.len();
        codes.sort_unstable();
        codes.dedup();
        assert_eq!(codes.len(), count);
    }

    /// The complete elements of order p have as many nodes as there are monomials.
    #[test]
    fn complete_elements_have_all_nodes() {
        let nodes = |shape, p: usize| match shape {
            Shape::Line => p + 1,
            Shape::Triangle => (p + 1) * (p + 2) / 2,
            Shape::Quad => (p + 1).pow(2),
            Shape::Tet => (p + 1) * (p + 2) * (p + 3) / 6,
            Shape::Hex => (p + 1).pow(3),
            Shape::Wedge => (p + 1).pow(2) * (p + 2) / 2,
            Shape::Pyramid => (p + 1) * (p + 2) * (2 * p + 3) / 6,
            Shape::Point => 1,
            Shape::Quad9 | Shape::Hex27 => 0,
        };
        let complete = HIGHER_ORDER.into_iter().filter(|(_, types)| types[0].0 != 20);
        for (shape, types) in complete.chain([(Shape::Pyramid, &PYRAMIDS[..])]) {
            for (k, &(code, count)) in types.iter().enumerate().take(8) {
                assert_eq!(count, nodes(shape, k + 2), "type {code}");
            }
        }
    }
}
