//! A queue in buckets: what has the smallest key comes first, but for the order within a bucket.
//!
//! Keys are positive; a bucket holds those between two steps of a geometric ladder below a limit. Entries are never taken
//! out when they become stale: who takes one checks it against the bucket that it came from.

/// Ids in buckets of equal ratio of their keys.
pub struct Buckets {
    buckets: Vec<Vec<u32>>,
    lowest: usize,
    limit: f64,
    per_octave: f64,
}

impl Buckets {
    /// A queue for keys below a limit; those that are more than `octaves` octaves below it share a bucket.
    pub fn new(limit: f64, per_octave: usize, octaves: usize) -> Self {
        let buckets = vec![Vec::new(); per_octave * octaves];
        Buckets { lowest: buckets.len(), buckets, limit, per_octave: per_octave as f64 }
    }

    /// The bucket of a key; `None` where it is not below the limit.
    pub fn bucket(&self, key: f64) -> Option<usize> {
        if key >= self.limit {
            return None;
        }
        let count = self.buckets.len() as f64;
        Some((count + self.per_octave * (key / self.limit).log2()).clamp(0.0, count - 1.0) as usize)
    }

    /// Adds an entry, if its key is below the limit.
    pub fn push(&mut self, id: u32, key: f64) {
        if let Some(k) = self.bucket(key) {
            self.buckets[k].push(id);
            self.lowest = self.lowest.min(k);
        }
    }

    /// Takes an entry of the lowest bucket, with the number of that.
    pub fn pop(&mut self) -> Option<(u32, usize)> {
        while self.lowest < self.buckets.len() {
            if let Some(id) = self.buckets[self.lowest].pop() {
                return Some((id, self.lowest));
            }
            self.lowest += 1;
        }
        None
    }
}
