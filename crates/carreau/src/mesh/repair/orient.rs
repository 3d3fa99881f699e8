//! Steps 4 and 6: neighbours agree, and closed components look outward.

use super::soup::Soup;
use crate::mesh::connectivity::Connectivity;
use crate::mesh::nesting::Shells;

/// Turns faces so that the two faces of every regular edge run along it in opposite directions. In each connected part
/// the majority keeps its sense. Returns how many faces were turned.
///
/// A part with one side only (a Möbius strip, a Klein bottle) keeps a seam of inconsistent edges.
pub fn agree(soup: &mut Soup) -> usize {
    let parts = Connectivity::of(&soup.faces, &soup.half_edges(), &soup.faces_with_repeats());
    soup.turn_faces(|f| parts.turned[f])
}

/// Turns closed components that look inward, and cavities that look outward. Returns how many components.
pub fn outward(soup: &mut Soup) -> usize {
    let repeats = soup.faces_with_repeats();
    let parts = Connectivity::of(&soup.faces, &soup.half_edges(), &repeats);
    let shells = Shells::of(&soup.points, &soup.faces, &parts, &repeats);
    let inverted: Vec<bool> = (0..parts.components as u32).map(|c| shells.is_inverted(c)).collect();
    soup.turn_faces(|f| inverted[parts.component[f] as usize]);
    inverted.iter().filter(|&&i| i).count()
}
