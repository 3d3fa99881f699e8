//! Freeform surfaces in pieces: a surface of the part ends where it turns or bends otherwise, and holds little of what is beyond. A
//! piece of a freeform one ends where the tolerance does; its neighbours hold much of it, and it much of theirs.
//!
//! ```text
//!      plane ────────╮                    ╭──────╮
//!                     ╲  fillet        ╭──╯ 1  2 ╰──╮        1 and 2 hold the middle both
//!                      │             ──╯            ╰──
//! ```

use super::expand::Energy;
use crate::mesh::NONE;
use crate::segment::regions::Groups;

/// A share of the area of a surface: it is ambiguous where neighbours hold as much of it too, because a face of a part
/// has one surface.
const COMMON_SHARE: f64 = 0.35;
/// The same where pieces that a wave may part were merged before, because they have less in common then.
const SHARE_WITHIN_WAVES: f64 = 0.25;
/// A share of the area of a chain: it is freeform where more is on ambiguous surfaces, because the fillets of a part are
/// ambiguous, the faces between them are not.
const AMBIGUOUS_SHARE: f64 = 0.5;
/// A count: fewer surfaces are no chain of pieces, because a blend and the faces beside it have something in common
/// too.
const CHAIN_SURFACES: usize = 4;

/// Takes the surfaces away that are pieces of freeform ones. The first `held` models stay.
pub fn free(energy: &Energy<'_>, label: &mut [u32], held: u32) {
    let t = energy.surface.triangles;
    let groups = Groups::new(label, energy.models.len());
    let mut shared = vec![false; label.len()];
    let mut home: Vec<u32> = (0..groups.len() as u32).collect();
    for l in held..groups.len() as u32 {
        let mut contacts: Vec<(u32, u32)> = Vec::new();
        for c in groups.of(l).iter().flat_map(|&k| 3 * k..3 * k + 3) {
            let o = t.opposite(c);
            if o != NONE
                && !energy.noise.crease[c as usize]
                && label[o as usize / 3] != NONE
                && label[o as usize / 3] != l
            {
                contacts.push((label[o as usize / 3], c / 3));
            }
        }
        contacts.sort_unstable();
        contacts.dedup();
        for of in contacts.chunk_by(|a, b| a.0 == b.0) {
            let other = of[0].0;
            let model = &energy.models[other as usize];
            let mut seen = vec![false; label.len()];
            let mut stack: Vec<u32> = of.iter().map(|x| x.1).collect();
            stack.iter().for_each(|&k| seen[k as usize] = true);
            while let Some(k) = stack.pop() {
                if !model.holds(energy.surface, energy.noise, k) {
                    continue;
                }
                shared[k as usize] = true;
                for o in (3 * k..3 * k + 3).map(|c| t.opposite(c)).filter(|&o| o != NONE) {
                    if label[o as usize / 3] == l && !std::mem::replace(&mut seen[o as usize / 3], true) {
                        stack.push(o / 3);
                    }
                }
            }
            if other >= held {
                let (a, b) = (root(&home, l), root(&home, other));
                home[a.max(b) as usize] = a.min(b);
            }
        }
    }
    let share = if energy.noise.has_waves() { SHARE_WITHIN_WAVES } else { COMMON_SHARE };
    let (mut area, mut ambiguous) = (vec![0.0; groups.len()], vec![0.0; groups.len()]);
    let mut size = vec![0; groups.len()];
    for l in held..groups.len() as u32 {
        let r = root(&home, l) as usize;
        let (mut own, mut common) = (0.0, 0.0);
        for &k in groups.of(l) {
            own += energy.surface.areas[k as usize];
            common += if shared[k as usize] { energy.surface.areas[k as usize] } else { 0.0 };
        }
        size[r] += usize::from(!groups.of(l).is_empty());
        area[r] += own;
        ambiguous[r] += if common > share * own { own } else { 0.0 };
    }
    for l in held..groups.len() as u32 {
        let r = root(&home, l) as usize;
        if size[r] >= CHAIN_SURFACES && ambiguous[r] > AMBIGUOUS_SHARE * area[r] {
            groups.of(l).iter().for_each(|&k| label[k as usize] = NONE);
        }
    }
}

fn root(home: &[u32], mut l: u32) -> u32 {
    while home[l as usize] != l {
        l = home[l as usize];
    }
    l
}
