//! Lists of polygons in two flat arrays.

/// Polygons as vertex indices: face `f` has the corners `corners[offsets[f]..offsets[f + 1]]`.
///
/// Corners have `u32` ids. A list that outgrows them keeps all corners, but its offsets stay at the largest id;
/// [`Polygons::fits`] tells, and [`RawMesh::check`](super::RawMesh::check) refuses it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Polygons {
    offsets: Vec<u32>,
    corners: Vec<u32>,
}

/// Ids from here up mark what is missing.
const CORNER_LIMIT: usize = super::marks::FIRST_MARK as usize;

fn fits(corners: usize) -> bool {
    corners <= CORNER_LIMIT
}

/// The offset after that many corners, saturated: offsets never decrease, whatever is pushed.
fn offset(corners: usize) -> u32 {
    u32::try_from(corners).unwrap_or(u32::MAX)
}

impl Default for Polygons {
    fn default() -> Self {
        Polygons { offsets: vec![0], corners: Vec::new() }
    }
}

impl Polygons {
    /// An empty list.
    pub fn new() -> Self {
        Self::default()
    }

    /// Triangles as polygons.
    pub fn from_triangles(triangles: &[[u32; 3]]) -> Self {
        Polygons {
            offsets: (0..=triangles.len()).map(|k| offset(3 * k)).collect(),
            corners: triangles.as_flattened().to_vec(),
        }
    }

    /// Room for that many more faces and corners. Pass only numbers already checked against the size of the data.
    pub fn reserve(&mut self, faces: usize, corners: usize) {
        self.offsets.reserve(faces);
        self.corners.reserve(corners);
    }

    /// Appends one face.
    #[inline]
    pub fn push(&mut self, face: &[u32]) {
        self.corners.extend_from_slice(face);
        self.offsets.push(offset(self.corners.len()));
    }

    /// Appends one face given by an iterator.
    #[inline]
    pub fn push_iter(&mut self, face: impl IntoIterator<Item = u32>) {
        self.corners.extend(face);
        self.offsets.push(offset(self.corners.len()));
    }

    /// Whether every corner has an id.
    pub fn fits(&self) -> bool {
        fits(self.corners.len())
    }

    /// Number of faces.
    pub fn len(&self) -> usize {
        self.offsets.len() - 1
    }

    /// Whether there is no face.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The corners of face `f`.
    #[inline]
    pub fn face(&self, f: usize) -> &[u32] {
        &self.corners[self.offsets[f] as usize..self.offsets[f + 1] as usize]
    }

    /// All faces in order.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &[u32]> + Clone {
        self.offsets.windows(2).map(|w| &self.corners[w[0] as usize..w[1] as usize])
    }

    /// Start of every face in [`Polygons::corners`], and the end of the last.
    pub fn offsets(&self) -> &[u32] {
        &self.offsets
    }

    /// The vertex indices of all faces, one after the other.
    pub fn corners(&self) -> &[u32] {
        &self.corners
    }

    /// The same, for renumbering vertices; faces keep their sizes.
    pub fn corners_mut(&mut self) -> &mut [u32] {
        &mut self.corners
    }

    /// The face of every corner.
    pub fn face_of_corners(&self) -> Vec<u32> {
        let mut face_of = vec![0; self.corners.len()];
        for (f, w) in self.offsets.windows(2).enumerate() {
            face_of[w[0] as usize..w[1] as usize].fill(f as u32);
        }
        face_of
    }

    /// The next corner of the same face, for every corner.
    pub fn next_corners(&self) -> Vec<u32> {
        let mut next: Vec<u32> = (1..=self.corners.len() as u32).collect();
        for w in self.offsets.windows(2).filter(|w| w[0] < w[1]) {
            next[w[1] as usize - 1] = w[0];
        }
        next
    }

    /// Whether every face is a triangle.
    pub fn all_triangles(&self) -> bool {
        self.corners.len() == 3 * self.len() && self.iter().all(|f| f.len() == 3)
    }

    /// Triangles of all faces, each fanned from its first corner, and the face each comes from.
    ///
    /// ```text
    /// 3───2        3───2
    /// │   │   →    │ ╱ │    (0,1,2) (0,2,3)
    /// 0───1        0───1
    /// ```
    pub fn fan(&self) -> (Vec<[u32; 3]>, Vec<u32>) {
        let count = self.corners.len() - 2 * self.len().min(self.corners.len() / 2);
        let (mut triangles, mut parent) = (Vec::with_capacity(count), Vec::with_capacity(count));
        for (f, face) in self.iter().enumerate() {
            for k in 1..face.len().saturating_sub(1) {
                triangles.push([face[0], face[k], face[k + 1]]);
                parent.push(f as u32);
            }
        }
        (triangles, parent)
    }
}

impl<'a> FromIterator<&'a [u32]> for Polygons {
    fn from_iter<I: IntoIterator<Item = &'a [u32]>>(faces: I) -> Self {
        let mut out = Polygons::new();
        faces.into_iter().for_each(|f| out.push(f));
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn offsets_beyond_the_ids_saturate_and_do_not_fit() {
        let most = CORNER_LIMIT;
        assert!(fits(0) && fits(most) && !fits(most + 1) && !fits(1 << 32) && !fits((1 << 32) + 3));
        assert_eq!([most, 1 << 32, (1 << 32) + 3].map(offset), [CORNER_LIMIT as u32, u32::MAX, u32::MAX]);
    }
}
