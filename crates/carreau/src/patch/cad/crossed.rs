//! Bicubic faces beside planes: the curves that they share with a plane must leave its border simple.

use super::chain::{ChainUse, Chains};
use super::fit::Shape;
use super::piece::{Flat, Piece, Source};
use super::runs::{Curves, beside};
use super::scene::Scene;
use super::simple::are_simple;
use crate::context::Context;
use glam::{DVec2, DVec3};
use rayon::prelude::*;

/// Points by which a curve is seen between two vertices.
const SAMPLES: u32 = 4;

/// Candidates beside a plane whose border, with their curves, crosses or touches itself.
pub fn crossed(
    scene: &Scene,
    pieces: &[Piece],
    chains: &Chains,
    curves: &Curves,
    candidates: usize,
    ctx: &Context,
) -> Vec<bool> {
    let crossed = |k: usize| {
        let Source::Flat(Flat { normal, .. }) = pieces[k].source else { return Vec::new() };
        let near: Vec<u32> = chains.loops[k]
            .iter()
            .flatten()
            .flat_map(|of| beside(chains, of.chain, candidates))
            .map(|k| k as u32)
            .collect();
        if near.is_empty() {
            return near;
        }
        let (x, y) = normal.any_orthonormal_pair();
        let border = |uses: &Vec<ChainUse>| -> Vec<DVec2> {
            let points = uses.iter().flat_map(|of| samples(scene, of, chains, curves));
            points.map(|p| DVec2::new(p.dot(x), p.dot(y))).collect()
        };
        let borders: Vec<Vec<DVec2>> = chains.loops[k].iter().map(border).collect();
        if are_simple(&borders) { Vec::new() } else { near }
    };
    let found: Vec<Vec<u32>> = ctx.install(|| (candidates..pieces.len()).into_par_iter().map(crossed).collect());
    let mut out = vec![false; candidates];
    found.iter().flatten().for_each(|&k| out[k as usize] = true);
    out
}

/// Points of a chain as it is used, without the last one.
fn samples(scene: &Scene, of: &ChainUse, chains: &Chains, curves: &Curves) -> Vec<DVec3> {
    let path = &chains.paths[of.chain as usize];
    let last = path.len() as u32 - 1;
    let mut points: Vec<DVec3> = match curves.of(path).shape {
        Shape::Spline(spline) => {
            (0..=last * SAMPLES).map(|k| spline.point(f64::from(k) / f64::from(last * SAMPLES))).collect()
        }
        Shape::Polyline(_) => [0, last].map(|k| scene.point(path[k as usize])).to_vec(),
    };
    if of.reversed {
        points.reverse();
    }
    points.pop();
    points
}
