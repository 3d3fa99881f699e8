//! The nodes that a search has still to look at.

/// Deeper than any tree over 2³² triangles.
pub const DEEPEST: usize = 34;

/// A node during a descent.
#[derive(Clone, Copy)]
pub struct Node {
    pub(super) index: u32,
    pub(super) first_leaf: u32,
    pub(super) leaves: u32,
}

impl Node {
    pub(super) fn children(self) -> [Node; 2] {
        let left = self.leaves.div_ceil(2);
        [
            Node { index: self.index + 1, first_leaf: self.first_leaf, leaves: left },
            Node { index: self.index + 2 * left, first_leaf: self.first_leaf + left, leaves: self.leaves - left },
        ]
    }
}

/// Nodes still to visit, with a bound each.
pub struct Stack {
    pub(super) nodes: [(Node, f64); DEEPEST],
    pub(super) len: usize,
}

impl Stack {
    pub(super) fn new() -> Self {
        Stack { nodes: [(Node { index: 0, first_leaf: 0, leaves: 0 }, 0.0); DEEPEST], len: 0 }
    }

    #[inline]
    pub(super) fn push(&mut self, node: Node, bound: f64) {
        self.nodes[self.len] = (node, bound);
        self.len += 1;
    }

    #[inline]
    pub(super) fn pop(&mut self) -> Option<(Node, f64)> {
        self.len = self.len.checked_sub(1)?;
        Some(self.nodes[self.len])
    }
}
