//! Step 3: of several faces on the same vertices one stays.

use super::soup::Soup;
use crate::mesh::duplicates::first_on_same_vertices;

/// Drops every face on the same vertices as an earlier one, whatever its sense. Returns how many.
///
/// Of two opposite faces one stays as well: dropping both would tear a hole wherever a file repeats a face the wrong way
/// round. The price is that two bodies glued along common faces keep a wall there, which the next steps cut off.
pub fn drop(soup: &mut Soup) -> usize {
    let first = first_on_same_vertices(&soup.faces, &soup.faces_with_repeats());
    soup.keep_faces(|f| first[f] as usize == f)
}
