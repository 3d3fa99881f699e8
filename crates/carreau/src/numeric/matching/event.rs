//! What may happen in the tree.

use super::graph::Dart;

/// Something that may happen in the tree at some time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Event {
    /// The edge of a dart with an outer tail becomes tight.
    Tight(Dart),
    /// The dual of an inner blossom becomes 0.
    Zero(u32),
}
