//! Faces on the same vertices.

use super::polygons::Polygons;

/// For every face the first one on the same set of vertices, in whatever order and sense; itself if there is none.
///
/// Faces marked in `ignore` are their own.
pub(crate) fn first_on_same_vertices(faces: &Polygons, ignore: &[bool]) -> Vec<u32> {
    let mut by_hash: Vec<(u64, u32)> =
        (0..faces.len()).filter(|&f| !ignore[f]).map(|f| (order_free_hash(faces.face(f)), f as u32)).collect();
    by_hash.sort_unstable();
    let mut first: Vec<u32> = (0..faces.len() as u32).collect();
    let mut leaders: Vec<(Vec<u32>, u32)> = Vec::new();
    for run in by_hash.chunk_by(|a, b| a.0 == b.0).filter(|run| run.len() > 1) {
        leaders.clear();
        for &(_, f) in run {
            let mut vertices = faces.face(f as usize).to_vec();
            vertices.sort_unstable();
            match leaders.iter().find(|(known, _)| *known == vertices) {
                Some(&(_, leader)) => first[f as usize] = leader,
                None => leaders.push((vertices, f)),
            }
        }
    }
    first
}

/// A hash that does not depend on the order of the vertices: the sum of their mixed ids (the finaliser of SplitMix64).
fn order_free_hash(face: &[u32]) -> u64 {
    face.iter().fold(0u64, |sum, &v| {
        let mut x = u64::from(v).wrapping_add(0x9e37_79b9_7f4a_7c15);
        x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        sum.wrapping_add(x ^ (x >> 31))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rotated_reversed_and_permuted_faces_are_found() {
        let faces: Polygons =
            [&[0, 1, 2][..], &[3, 1, 2], &[2, 0, 1], &[2, 1, 0], &[0, 1, 2, 3], &[0, 2, 1, 3]].into_iter().collect();
        assert_eq!(first_on_same_vertices(&faces, &[false; 6]), [0, 1, 0, 0, 4, 4]);
        assert_eq!(first_on_same_vertices(&faces, &[true; 6]), [0, 1, 2, 3, 4, 5]);
    }
}
