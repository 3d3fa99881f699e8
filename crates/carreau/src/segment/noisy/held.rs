//! Which of the surfaces that were found exactly stay as they are. The others are facets that happen to be flat: of chords, of
//! edges that were rounded, of strips that were cut up; they are hypotheses like all others.

use super::level::LEAST_CREASE;
use super::model::Model;
use crate::geometry::primitive::Kind;
use crate::mesh::NONE;
use crate::segment::surface::{Lies, Surface, quantile};
use crate::segment::surfaces::{NORMAL_NOISE, Surfaces};

/// A count: a surface with so many vertices inside is no chance, if it is as exact as careful files are; strips of
/// chords have none because all their vertices are on borders.
const CERTAIN_INNER: usize = 4;
/// A count: the same where it is less exact, more because smooth waves are nearly flat in places.
const MANY_INNER: usize = 24;
/// A share of its border at creases with which a surface is no chance either, because pieces of smooth shapes do not
/// end there.
const CREASED_BORDER: f64 = 0.8;
/// Multiple of the area of the triangle of the middle size that such a surface has at least, because a single triangle
/// lies on any plane.
const CREASED_AREA: f64 = 1.5;
/// A share of the area: curved surfaces are what they seem where no more is free or on planes that may be chance,
/// because beside exact surfaces they are no chance.
const DOUBTFUL_SHARE: f64 = 0.1;
/// Multiple of the tolerance to which two pieces of one surface agree, because each may be off by it, and farther off
/// where it does not reach.
pub const TWIN_FACTOR: f64 = 4.0;

/// How sure it is that an exact surface is no chance.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Hold {
    /// It may be: its triangles are divided like all others.
    None,
    /// It is held.
    Sure,
    /// It is held, and as exact as careful files are: no waves are that flat, or that round.
    Exact,
}

/// Number of vertices inside of every exact surface.
pub fn inner(surface: &Surface<'_>, exact: &Surfaces) -> Vec<usize> {
    let t = surface.triangles;
    // The only surface around every vertex.
    let mut around = vec![None; t.points().len()];
    for c in 0..3 * surface.len() as u32 {
        let l = exact.label[c as usize / 3];
        let own = around[t.vertex(c) as usize].get_or_insert(l);
        if *own != l || t.opposite(c) == NONE || t.opposite(t.previous(c)) == NONE {
            *own = NONE;
        }
    }
    let mut inner = vec![0; exact.primitives.len()];
    around.into_iter().flatten().filter(|&l| l != NONE).for_each(|l| inner[l as usize] += 1);
    inner
}

/// Which of the exact surfaces of a mesh are held, per surface; `inner` counts the vertices inside of them.
pub fn held(surface: &Surface<'_>, exact: &Surfaces, inner: &[usize]) -> Vec<Hold> {
    let t = surface.triangles;
    let count = exact.primitives.len();
    let mut off = vec![0f64; count];
    let (mut area, mut creased, mut border) = (vec![0.0; count], vec![0.0; count], vec![0.0; count]);
    for (k, &l) in exact.label.iter().enumerate().filter(|(_, l)| **l != NONE) {
        let l = l as usize;
        area[l] += surface.areas[k];
        let far = |v: u32| exact.primitives[l].distance(t.points()[v as usize]).abs();
        off[l] = t.triangle(k as u32).into_iter().map(far).fold(off[l], f64::max);
        for c in 3 * k as u32..3 * k as u32 + 3 {
            let o = t.opposite(c);
            if o != NONE && exact.label[o as usize / 3] == l as u32 {
                continue;
            }
            let length = surface.edge_length(c);
            border[l] += length;
            creased[l] += if f64::from(surface.bend[c as usize]) > LEAST_CREASE { length } else { 0.0 };
        }
    }
    let middle = quantile(&mut surface.areas.clone(), 0.5, f64::total_cmp).unwrap_or_default();
    let is_plane = |l: usize| exact.primitives[l].kind() == Kind::Plane;
    let enough = |l: usize| if off[l] <= exact.close { CERTAIN_INNER } else { MANY_INNER };
    let sure = |l: usize| {
        inner[l] >= enough(l) || creased[l] >= CREASED_BORDER * border[l] && area[l] >= CREASED_AREA * middle
    };
    let free: f64 = surface.total_area - area.iter().sum::<f64>();
    let doubtful: f64 = free + (0..count).filter(|&l| is_plane(l) && !sure(l)).map(|l| area[l]).sum::<f64>();
    // The strips of a coarse tessellation have no vertex inside either: beside other exact surfaces they are no chance.
    let clean = doubtful <= DOUBTFUL_SHARE * surface.total_area;
    let hold = |l: usize| match sure(l) || clean && !is_plane(l) {
        true if off[l] <= exact.close => Hold::Exact,
        true => Hold::Sure,
        false => Hold::None,
    };
    (0..count).map(hold).collect()
}

/// For every held surface the first, larger one that is the same: pieces of one face that what lies between has parted.
pub fn same(surface: &Surface<'_>, models: &[Model], groups: &[&[u32]], distance: f64) -> Vec<u32> {
    let mut order: Vec<usize> = (0..models.len()).collect();
    order.sort_by_key(|&l| std::cmp::Reverse(groups[l].len()));
    let mut home: Vec<u32> = (0..models.len() as u32).collect();
    for (k, &l) in order.iter().enumerate() {
        let lies = |other: &Model| {
            let demand = Lies { distance, turn: NORMAL_NOISE, spread: f64::INFINITY };
            groups[l].iter().all(|&k| surface.lies_on(k, &other.primitive, other.sign, &demand))
        };
        let kind = models[l].primitive.kind();
        let twin =
            order[..k].iter().find(|&&o| home[o] == o as u32 && models[o].primitive.kind() == kind && lies(&models[o]));
        if let Some(&twin) = twin {
            home[l] = twin as u32;
        }
    }
    home
}
