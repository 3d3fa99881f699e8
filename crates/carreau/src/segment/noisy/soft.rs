//! Surfaces that the tolerance made possible. Where the surface of a part ends, the next one leaves it at once: at an angle, or as
//! a fillet leaves a plane. A piece of a freeform surface ends where its distance happens to exceed the tolerance, and two rings
//! further on it is hardly larger.

use super::expand::Energy;
use super::model::MODEL_REACH;
use crate::mesh::NONE;
use crate::segment::recognise::MOST_SOFT;
use crate::segment::regions::Groups;

/// Multiple of the tolerance: a border is hard where vertices two rings beyond are farther away, because a freeform surface
/// leaves its piece of some edges by a few tolerances there.
const HARD_BEYOND: f64 = 10.0;

/// The area on surfaces whose border is soft for the most part, without the first `held` ones.
pub fn area(energy: &Energy<'_>, label: &[u32], held: u32) -> f64 {
    let groups = Groups::new(label, energy.models.len());
    let is_soft = |l: &u32| softness(energy, label, groups.of(*l), *l) > MOST_SOFT;
    let area = |l: u32| groups.of(l).iter().map(|&k| energy.surface.areas[k as usize]).sum::<f64>();
    (held..groups.len() as u32).filter(is_soft).map(area).sum()
}

/// Share of the border of a surface that is soft.
fn softness(energy: &Energy<'_>, label: &[u32], triangles: &[u32], l: u32) -> f64 {
    let t = energy.surface.triangles;
    let (mut soft, mut all) = (0.0, 0.0);
    for c in triangles.iter().flat_map(|&k| 3 * k..3 * k + 3) {
        let o = t.opposite(c);
        if o == NONE || label[o as usize / 3] == l {
            continue;
        }
        let length = energy.surface.edge_length(c);
        all += length;
        if !energy.noise.crease[c as usize] && beyond(energy, o, l) < HARD_BEYOND * MODEL_REACH * energy.noise.sigma {
            soft += length;
        }
    }
    if all > 0.0 { soft / all } else { 0.0 }
}

/// The largest distance from a surface of the vertices of two rings beyond the half-edge of a neighbour.
fn beyond(energy: &Energy<'_>, o: u32, l: u32) -> f64 {
    let t = energy.surface.triangles;
    let primitive = &energy.models[l as usize].primitive;
    let next = [t.next(o), t.previous(o)].map(|c| t.opposite(c));
    let apexes = std::iter::once(o).chain(next.into_iter().filter(|&n| n != NONE)).map(|c| t.apex(c));
    apexes.map(|v| primitive.distance(t.points()[v as usize]).abs()).fold(0.0, f64::max)
}
