//! A queue in buckets: what has the smallest key comes first, but for the order within a bucket.
//!
//! Keys are positive; every octave below a limit has as many buckets, of the same width: the leading bits of a number tell
//! which. An entry that is added once more moves to its new bucket; what it leaves behind is passed over.

/// Bits of a number behind its exponent.
const MANTISSA: u32 = 52;
/// The bucket of what is in none.
const NOWHERE: u16 = u16::MAX;

/// Ids in buckets of nearly equal ratio of their keys.
pub struct Buckets {
    buckets: Vec<Vec<u32>>,
    /// The bucket of every id.
    of: Vec<u16>,
    lowest: usize,
    limit: f64,
    shift: u32,
}

impl Buckets {
    /// A queue of ids below `ids` for keys below a limit, with 2^`bits` buckets for an octave; keys that are more than
    /// `octaves` octaves below it share a bucket.
    pub fn new(ids: u32, limit: f64, bits: u32, octaves: u16) -> Self {
        let buckets = vec![Vec::new(); usize::from(octaves) << bits];
        Buckets { lowest: buckets.len(), buckets, of: vec![NOWHERE; ids as usize], limit, shift: MANTISSA - bits }
    }

    /// The bucket of a key; [`NOWHERE`] where it is not below the limit.
    #[inline]
    fn bucket(&self, key: f64) -> u16 {
        if key >= self.limit {
            return NOWHERE;
        }
        let below = self.limit.to_bits().saturating_sub(key.to_bits()) >> self.shift;
        (self.buckets.len() - 1).saturating_sub(below as usize) as u16
    }

    /// Adds an entry, or moves it, if its key is below the limit; else takes it out.
    #[inline]
    pub fn push(&mut self, id: u32, key: f64) {
        let bucket = self.bucket(key);
        if std::mem::replace(&mut self.of[id as usize], bucket) != bucket && bucket != NOWHERE {
            self.buckets[usize::from(bucket)].push(id);
            self.lowest = self.lowest.min(usize::from(bucket));
        }
    }

    /// Takes an entry of the lowest bucket.
    pub fn pop(&mut self) -> Option<u32> {
        while self.lowest < self.buckets.len() {
            let Some(id) = self.buckets[self.lowest].pop() else {
                self.lowest += 1;
                continue;
            };
            if usize::from(self.of[id as usize]) == self.lowest {
                self.of[id as usize] = NOWHERE;
                return Some(id);
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_smallest_comes_first_and_what_moves_comes_once() {
        let mut queue = Buckets::new(6, 1.0, 3, 16);
        for (id, key) in [(0, 0.9), (1, 0.1), (2, 1.5), (3, 1e-9), (4, 0.5), (5, 0.4)] {
            queue.push(id, key);
        }
        queue.push(0, 0.2);
        queue.push(4, 0.5);
        queue.push(5, 2.0);
        let order: Vec<u32> = std::iter::from_fn(|| queue.pop()).collect();
        assert_eq!(order, [3, 1, 0, 4]);
        queue.push(3, 0.3);
        assert_eq!((queue.pop(), queue.pop()), (Some(3), None));
    }
}
