//! The simplest kind that will do: rounded borders bend a cylinder into a cone and a cone into a torus, so the triangles away from
//! the border decide.

use super::expand::Energy;
use super::merge::WAVE_PRICE;
use super::model::{Fitter, Model};
use super::settle::rings;
use crate::geometry::primitive::Kind;
use crate::mesh::NONE;
use crate::segment::regions::Groups;

/// A count: rings of triangles beside the border that have no say, where enough is left, because rounded borders bend
/// surfaces.
const SILENT_RINGS: u32 = 2;
/// A share of the triangles: so many are enough, because fewer say too little about the surface.
const INNER_SHARE: f64 = 0.3;
/// A price that a simpler kind may cost more per triangle than the dearer one, because the dearer one fits noise as
/// well.
const SIMPLER_PRICE: f64 = 0.15;
/// A factor by which a simpler kind may cost more besides, for the same reason.
const SIMPLER_FACTOR: f64 = 1.25;

/// Gives every surface that is not held the simplest kind that explains its inner triangles as well.
pub fn simplify(energy: &mut Energy<'_>, fitter: &mut Fitter<'_>, label: &[u32], held: u32) {
    let own: Vec<u32> = label.iter().map(|&l| if (l as usize) < energy.models.len() { l } else { NONE }).collect();
    let groups = Groups::new(&own, energy.models.len());
    let ring = rings(energy, label);
    for l in held..groups.len() as u32 {
        let all = groups.of(l);
        let inner: Vec<u32> = all.iter().copied().filter(|&k| ring[k as usize] >= SILENT_RINGS).collect();
        let members = if inner.len() as f64 >= INNER_SHARE * all.len() as f64 { &inner } else { all };
        let old = energy.models[l as usize];
        let price = |model: &Model| members.iter().map(|&k| model.price(energy.surface, energy.noise, k)).sum::<f64>();
        let most = SIMPLER_FACTOR * price(&old) + SIMPLER_PRICE * members.len() as f64;
        let most = if energy.noise.has_waves() { most.max(WAVE_PRICE * members.len() as f64) } else { most };
        let simpler = Kind::ALL.into_iter().take_while(|&kind| kind != old.primitive.kind()).find_map(|kind| {
            let fit = fitter.fit(kind, members, None)?;
            let model = Model::of(fit.primitive, energy.surface, members);
            (price(&model) <= most).then_some(model)
        });
        // The same kind, fitted to what has a say.
        let again = || {
            let fit = fitter.fit(old.primitive.kind(), members, Some(old.primitive))?;
            let model = Model::of(fit.primitive, energy.surface, members);
            (price(&model) <= most).then_some(model)
        };
        if let Some(model) = simpler.or_else(again) {
            energy.models[l as usize] = model;
        }
    }
}
