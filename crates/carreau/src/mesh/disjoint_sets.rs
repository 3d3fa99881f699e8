//! Disjoint sets (union-find), plain and with a sign between the members.

/// Disjoint sets of the ids `0..n`; the smallest member names a set, whatever the order of the unions.
pub(crate) struct DisjointSets {
    parent: Vec<u32>,
}

impl DisjointSets {
    /// Every id in a set of its own.
    pub fn new(n: usize) -> Self {
        DisjointSets { parent: (0..n as u32).collect() }
    }

    /// The smallest member of the set of `x`.
    pub fn find(&mut self, mut x: u32) -> u32 {
        while self.parent[x as usize] != x {
            let grandparent = self.parent[self.parent[x as usize] as usize];
            self.parent[x as usize] = grandparent;
            x = grandparent;
        }
        x
    }

    /// Makes one set of the sets of `a` and `b`.
    pub fn union(&mut self, a: u32, b: u32) {
        let (a, b) = (self.find(a), self.find(b));
        self.parent[a.max(b) as usize] = a.min(b);
    }

    /// The smallest member of the set of every id.
    pub fn leaders(mut self) -> Vec<u32> {
        (0..self.parent.len() as u32).map(|x| self.find(x)).collect()
    }

    /// The set of every id, numbered by first appearance, and the number of sets.
    pub fn labels(self) -> (Vec<u32>, usize) {
        let mut labels = self.leaders();
        let mut count = 0;
        for x in 0..labels.len() {
            // A set's smallest member comes first, so its label is already there for all others.
            let leader = labels[x] as usize;
            labels[x] = if leader == x { count } else { labels[leader] };
            count += u32::from(leader == x);
        }
        (labels, count as usize)
    }
}

/// Disjoint sets whose members carry a sign relative to the smallest: which faces to turn so that all agree.
///
/// At most 2³¹ ids: the sign takes one bit of the link.
pub(crate) struct SignedSets {
    /// `parent << 1 | differs from the parent`.
    link: Vec<u32>,
}

impl SignedSets {
    /// Every id in a set of its own.
    pub fn new(n: usize) -> Self {
        SignedSets { link: (0..n as u32).map(|x| x << 1).collect() }
    }

    /// The smallest member of the set of `x`, and whether `x` differs from it.
    pub fn find(&mut self, mut x: u32) -> (u32, bool) {
        let mut sign = 0;
        loop {
            let up = self.link[x as usize];
            if up >> 1 == x {
                return (x, sign == 1);
            }
            let above = self.link[(up >> 1) as usize];
            let halved = above ^ (up & 1);
            self.link[x as usize] = halved;
            sign ^= halved & 1;
            x = halved >> 1;
        }
    }

    /// States that `a` and `b` differ, or do not. False when that contradicts what was stated before.
    pub fn relate(&mut self, a: u32, b: u32, differ: bool) -> bool {
        let ((a, sign_a), (b, sign_b)) = (self.find(a), self.find(b));
        if a == b {
            return (sign_a != sign_b) == differ;
        }
        let sign = u32::from((sign_a != sign_b) != differ);
        self.link[a.max(b) as usize] = a.min(b) << 1 | sign;
        true
    }

    /// Marks, in every set, the smaller of the two parts that differ; of two equal parts, the one without the smallest member.
    pub fn smaller_parts(&mut self) -> Vec<bool> {
        let n = self.link.len();
        let (mut differing, mut size) = (vec![0u32; n], vec![0u32; n]);
        for x in 0..n as u32 {
            let (leader, differs) = self.find(x);
            size[leader as usize] += 1;
            differing[leader as usize] += u32::from(differs);
        }
        let is_smaller = |x| {
            let (leader, differs) = self.find(x);
            let most_differ = 2 * u64::from(differing[leader as usize]) > u64::from(size[leader as usize]);
            differs != most_differ
        };
        (0..n as u32).map(is_smaller).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_count_sets_by_first_appearance() {
        let mut sets = DisjointSets::new(6);
        sets.union(5, 1);
        sets.union(3, 5);
        sets.union(4, 2);
        assert_eq!(sets.labels(), (vec![0, 1, 2, 1, 2, 1], 3));
    }

    #[test]
    fn a_cycle_with_an_odd_number_of_differences_contradicts_itself() {
        for n in 3..40u32 {
            let mut sets = SignedSets::new(n as usize);
            assert!((1..n).all(|k| sets.relate(k - 1, k, true)));
            assert!((0..n).all(|k| sets.find(k) == (0, k % 2 == 1)));
            assert_eq!(sets.relate(n - 1, 0, true), n % 2 == 0);
        }
    }
}
