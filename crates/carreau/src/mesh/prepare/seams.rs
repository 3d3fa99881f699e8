//! Corners by the file's own vertices, and the edges along which these do not agree.
//!
//! ```text
//!   b │ b'           a prepared edge a b whose two faces have vertices a, b and a', b' in the file: results that name vertices of
//!     │              the file by their faces cannot go across it
//!   a │ a'
//! ```

use super::super::id::VertexId;
use super::trace::Prepared;

impl Prepared {
    /// The file's vertex at every corner of a face: that of its own face there, where it still has it.
    pub fn corners(&self, f: u32) -> Vec<u32> {
        let now = self.mesh.faces().face(f as usize);
        if !self.is_changed() {
            return now.to_vec();
        }
        let before = self.input().faces().face(self.face(f) as usize);
        let own = |v: u32| {
            let stays = before.contains(&self.vertex(v)).then(|| self.vertex(v));
            stays.or_else(|| before.iter().copied().find(|&b| self.vertex_image(b) == Some(v)))
        };
        now.iter().map(|&v| own(v).unwrap_or_else(|| self.vertex(v))).collect()
    }

    /// The edges whose faces have different vertices or senses in the file, and those of faces that have other corners there.
    pub fn seams(&self) -> Vec<[VertexId; 2]> {
        if !self.is_changed() {
            return Vec::new();
        }
        let faces = self.mesh.faces();
        let (face_of, next) = (faces.face_of_corners(), faces.next_corners());
        let own: Vec<u32> = (0..faces.len() as u32).flat_map(|f| self.corners(f)).collect();
        let is_whole = |f: u32| {
            let before = self.input().faces().face(self.face(f) as usize);
            let offsets = faces.offsets();
            own[offsets[f as usize] as usize..offsets[f as usize + 1] as usize].iter().all(|v| before.contains(v))
        };
        let side = |c: u32| {
            let f = face_of[c as usize];
            let (a, b) = (own[c as usize], own[next[c as usize] as usize]);
            let is_forward = faces.corners()[c as usize] < faces.corners()[next[c as usize] as usize];
            (if is_forward { [a, b] } else { [b, a] }, self.is_turned(f), is_whole(f))
        };
        let half_edges = self.mesh.half_edges();
        let is_seam = |corners: &[u32]| {
            let first = side(corners[0]);
            !first.2 || corners[1..].iter().any(|&c| side(c) != first)
        };
        let edges = half_edges.groups().map(|edge| (edge.ends, edge.corners().collect::<Vec<u32>>()));
        edges.filter(|(_, corners)| is_seam(corners)).map(|(ends, _)| ends.map(VertexId)).collect()
    }
}
