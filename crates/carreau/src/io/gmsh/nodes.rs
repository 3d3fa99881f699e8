//! From the node tags of a file, which may have gaps and any order, to vertex ids.

/// Vertex id of every node tag.
pub(super) enum NodeIndex {
    /// Tags up to a few times the number of nodes: a table, `NONE` in the gaps.
    Table(Vec<u32>),
    /// Any tags: sorted, with their vertices.
    Sorted(Vec<(u64, u32)>),
}

/// No node has this tag.
const NONE: u32 = u32::MAX;

impl NodeIndex {
    /// Node `tags[v]` is vertex `v`. The error is a tag that occurs twice.
    pub fn new(tags: &[u64]) -> Result<Self, u64> {
        let largest = tags.iter().copied().max().unwrap_or(0);
        if largest <= 4 * tags.len() as u64 + 1024 { Self::table(tags, largest as usize) } else { Self::sorted(tags) }
    }

    fn table(tags: &[u64], largest: usize) -> Result<Self, u64> {
        let mut table = vec![NONE; largest + 1];
        for (v, &tag) in (0u32..).zip(tags) {
            if std::mem::replace(&mut table[tag as usize], v) != NONE {
                return Err(tag);
            }
        }
        Ok(NodeIndex::Table(table))
    }

    fn sorted(tags: &[u64]) -> Result<Self, u64> {
        let mut sorted: Vec<(u64, u32)> = tags.iter().copied().zip(0..).collect();
        sorted.sort_unstable();
        match sorted.windows(2).find(|w| w[0].0 == w[1].0) {
            Some(twice) => Err(twice[0].0),
            None => Ok(NodeIndex::Sorted(sorted)),
        }
    }

    /// The vertex of a node.
    #[inline]
    pub fn vertex(&self, tag: u64) -> Option<u32> {
        match self {
            NodeIndex::Table(table) => table.get(usize::try_from(tag).ok()?).copied().filter(|&v| v != NONE),
            NodeIndex::Sorted(sorted) => {
                let found = sorted.binary_search_by_key(&tag, |&(t, _)| t);
                found.ok().map(|k| sorted[k].1)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn finds_what_a_search_finds(mut tags: Vec<u64>, small: Vec<u8>, probe: u64) {
            tags.extend(small.iter().map(|&t| u64::from(t)));
            tags.sort_unstable();
            tags.dedup();
            tags.reverse();
            let index = NodeIndex::new(&tags).unwrap();
            for tag in tags.iter().copied().chain([0, 7, 300, probe]) {
                prop_assert_eq!(index.vertex(tag), tags.iter().position(|&t| t == tag).map(|v| v as u32));
            }
        }

        #[test]
        fn names_a_tag_that_occurs_twice(tags in prop::collection::vec(any::<u64>(), 1..9), which: prop::sample::Index) {
            let twice = tags[which.index(tags.len())];
            let doubled = [tags.as_slice(), &[twice]].concat();
            prop_assert!(NodeIndex::new(&doubled).is_err());
        }
    }
}
