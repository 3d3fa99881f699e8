//! Half-edges grouped by their undirected edge: the one place where adjacency is computed.

use super::polygons::Polygons;

/// All half-edges of a polygon list, those of one undirected edge side by side.
///
/// A half-edge is named by the corner it leaves from. Groups are ordered by (smaller vertex, larger vertex), half-edges
/// in a group by corner, so the order depends on nothing but the faces.
pub struct HalfEdges {
    /// `larger vertex << 32 | corner`, grouped.
    sorted: Vec<u64>,
    /// Start of the groups of each smaller vertex.
    bucket: Vec<u32>,
}

/// One undirected edge and the half-edges on it.
pub struct EdgeGroup<'a> {
    /// The vertices, smaller first; equal for a degenerate edge.
    pub ends: [u32; 2],
    half_edges: &'a [u64],
}

impl EdgeGroup<'_> {
    /// Number of half-edges, that is of face sides on this edge.
    pub fn len(&self) -> usize {
        self.half_edges.len()
    }

    /// Never true: an edge exists because a face has it.
    pub fn is_empty(&self) -> bool {
        self.half_edges.is_empty()
    }

    /// The corners that the half-edges leave from.
    pub fn corners(&self) -> impl ExactSizeIterator<Item = u32> + '_ {
        self.half_edges.iter().map(|&key| key as u32)
    }
}

/// Index of the next corner in the same face, for every corner.
fn next_corners(faces: &Polygons) -> impl Iterator<Item = (u32, u32)> + '_ {
    faces.offsets().windows(2).flat_map(|w| (w[0]..w[1]).map(move |c| (c, if c + 1 == w[1] { w[0] } else { c + 1 })))
}

impl HalfEdges {
    /// Groups the half-edges of these faces over `vertices` vertices.
    pub fn new(faces: &Polygons, vertices: usize) -> Self {
        let v = faces.corners();
        let mut bucket = vec![0u32; vertices + 1];
        for (c, n) in next_corners(faces) {
            bucket[v[c as usize].min(v[n as usize]) as usize + 1] += 1;
        }
        for k in 1..bucket.len() {
            bucket[k] += bucket[k - 1];
        }
        let mut fill = bucket.clone();
        let mut sorted = vec![0u64; v.len()];
        for (c, n) in next_corners(faces) {
            let (a, b) = (v[c as usize], v[n as usize]);
            let at = &mut fill[a.min(b) as usize];
            sorted[*at as usize] = u64::from(a.max(b)) << 32 | u64::from(c);
            *at += 1;
        }
        for w in bucket.windows(2) {
            sorted[w[0] as usize..w[1] as usize].sort_unstable();
        }
        HalfEdges { sorted, bucket }
    }

    /// The edge between two vertices, if some face has it.
    pub fn find(&self, a: u32, b: u32) -> Option<EdgeGroup<'_>> {
        let (small, large) = (a.min(b), a.max(b));
        let start = *self.bucket.get(small as usize)? as usize;
        let end = *self.bucket.get(small as usize + 1)? as usize;
        let bucket = &self.sorted[start..end];
        let from = bucket.partition_point(|key| key >> 32 < u64::from(large));
        let to = bucket.partition_point(|key| key >> 32 <= u64::from(large));
        (from < to).then(|| EdgeGroup { ends: [small, large], half_edges: &bucket[from..to] })
    }

    /// All undirected edges in order.
    pub fn groups(&self) -> impl Iterator<Item = EdgeGroup<'_>> {
        self.bucket.windows(2).enumerate().flat_map(move |(small, w)| {
            self.sorted[w[0] as usize..w[1] as usize]
                .chunk_by(|a, b| a >> 32 == b >> 32)
                .map(move |half_edges| EdgeGroup { ends: [small as u32, (half_edges[0] >> 32) as u32], half_edges })
        })
    }
}
