//! What all entities are written into.

use rustc_hash::FxHashMap;

/// The entities of the shells and faces.
pub struct Written {
    pub(super) shells: Vec<Id>,
    pub(super) faces: Vec<Id>,
}

/// Number of an entity, as in `#17`.
pub type Id = u32;

pub struct Writer<'a> {
    pub(super) out: &'a mut Vec<u8>,
    pub(super) last: Id,
    pub(super) points: FxHashMap<[u64; 3], Id>,
    pub(super) points_2d: FxHashMap<[u64; 2], Id>,
}
