//! Turns closed components outward and cavities inward.

use super::soup::Soup;
use crate::mesh::connectivity::Connectivity;
use crate::mesh::nesting::Shells;

/// Turns closed components that look inward, and cavities that look outward; what has a name of its own is no cavity. Returns a
/// face of each component that was turned.
pub fn outward(soup: &mut Soup, names: Option<&[i32]>) -> Vec<u32> {
    let repeats = soup.faces_with_repeats();
    let parts = Connectivity::of(&soup.faces, &soup.half_edges(), &repeats);
    let mut shells = Shells::of(&soup.points, &soup.faces, &parts, &repeats);
    let name = |f: u32| names.map(|names| names[soup.face_source[f as usize] as usize]);
    shells.tell_apart(|inner, outer| name(inner) != name(outer));
    let inverted: Vec<bool> = (0..parts.components as u32).map(|c| shells.is_inverted(c)).collect();
    soup.turn_faces(|f| inverted[parts.component[f] as usize]);
    let mut told = vec![false; parts.components];
    let firsts = (0u32..).zip(&parts.component).filter(|&(_, &c)| {
        let first = inverted[c as usize] && !told[c as usize];
        told[c as usize] |= first;
        first
    });
    firsts.map(|(f, _)| f).collect()
}
