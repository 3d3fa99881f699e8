//! Singularities of opposite sign that are nearer to each other than quads can show are cancelled in the field: frames turn once
//! less across the edges of the path between them.
//!
//! ```text
//!   3 ────── · ────── 5      →      4 ────── · ────── 4
//!       +1       +1
//! ```

use super::framed::{Framed, next};
use super::tuning::FRAME_HOLD;
use crate::context::Context;
use crate::error::Result;
use crate::mesh::NONE;
use crate::numeric::sparse::LeastSquares;
use glam::{DMat2, DVec2};
use rustc_hash::FxHashMap;
use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Cancels the pairs within a distance, the nearest first; returns their number.
pub fn cancel(framed: &mut Framed, reach: f64, context: &Context) -> Result<usize> {
    let mut count = 0;
    loop {
        let mut pairs: Vec<(u64, Vec<u32>)> = Vec::new();
        let out = leaving(framed);
        for v in (0..framed.points.len() as u32).filter(|&v| is_inner(framed, v) && framed.quads[v as usize] == 3) {
            context.check_every(v as usize)?;
            if let Some((distance, path)) = nearest(framed, &out, v, reach) {
                pairs.push((distance.to_bits(), path));
            }
        }
        // Distances are not negative: their bits are ordered as they are.
        pairs.sort();
        let before = count;
        for (_, path) in pairs {
            let ends = [framed.tail(path[0]), framed.tail(next(path[path.len() - 1]))].map(|v| v as usize);
            if ends.map(|v| framed.quads[v]) != [3, 5] {
                continue;
            }
            for h in path {
                let o = framed.opposite[h as usize];
                framed.turn[h as usize] += 1;
                framed.turn[o as usize] -= 1;
            }
            for v in ends {
                framed.quads[v] = 4;
                framed.is_kept[v] = false;
            }
            count += 1;
        }
        if count == before {
            break;
        }
    }
    if count > 0 {
        straighten(framed)?;
    }
    Ok(count)
}

/// Whether a vertex is on no feature.
fn is_inner(framed: &Framed, v: u32) -> bool {
    framed.place[v as usize].is_none()
}

/// A half-edge that leaves every vertex.
fn leaving(framed: &Framed) -> Vec<u32> {
    let mut out = vec![NONE; framed.points.len()];
    (0..framed.opposite.len() as u32).rev().for_each(|h| out[framed.tail(h) as usize] = h);
    out
}

/// The way to the nearest vertex with five quads.
fn nearest(framed: &Framed, out: &[u32], from: u32, reach: f64) -> Option<(f64, Vec<u32>)> {
    let mut known: FxHashMap<u32, (f64, u32)> = FxHashMap::default();
    let mut queue = BinaryHeap::from([Reverse((0u64, from))]);
    known.insert(from, (0.0, NONE));
    while let Some(Reverse((bits, v))) = queue.pop() {
        let distance = f64::from_bits(bits);
        if distance > known.get(&v)?.0 {
            continue;
        }
        if framed.quads[v as usize] == 5 {
            let (mut path, mut at) = (Vec::new(), v);
            while let Some(&(_, h)) = known.get(&at).filter(|k| k.1 != NONE) {
                path.push(h);
                at = framed.tail(h);
            }
            path.reverse();
            return Some((distance, path));
        }
        for h in framed.fan(out[v as usize]).0 {
            let w = framed.tail(next(h));
            let far = distance + framed.along(h).length();
            if far <= reach && is_inner(framed, w) && known.get(&w).is_none_or(|k| far < k.0) {
                known.insert(w, (far, h));
                queue.push(Reverse((far.to_bits(), w)));
            }
        }
    }
    None
}

/// Turns the frames to be as smooth as the turns across edges allow; those along features stay.
fn straighten(framed: &mut Framed) -> Result<()> {
    let mut unknown = vec![NONE; framed.triangles.len()];
    let mut count = 0;
    for (t, unknown) in unknown.iter_mut().enumerate() {
        if framed.curve[3 * t..3 * t + 3].iter().all(|&c| c == NONE) {
            *unknown = count;
            count += 1;
        }
    }
    // Of the first branch, from a half-edge.
    let angle = |h: u32, along: DVec2| along.angle_to(framed.frame[h as usize / 3].x_axis);
    let mut system = LeastSquares::new(count as usize);
    for h in 0..framed.opposite.len() as u32 {
        let o = framed.opposite[h as usize];
        if o == NONE || o < h || framed.curve[h as usize] != NONE {
            continue;
        }
        let off = angle(o, -framed.along(o)) + f64::from(framed.turn[h as usize].rem_euclid(4)) * FRAC_PI_2
            - angle(h, framed.along(h));
        let off = off - TAU * ((off - PI) / TAU).ceil();
        let height = |h: u32| 2.0 * framed.area[h as usize / 3] / framed.along(h).length();
        let weight = (framed.along(h).length() / (height(h) + height(o))).clamp(0.1, 10.0);
        let terms: Vec<(u32, f64)> = [(h, -1.0), (o, 1.0)]
            .into_iter()
            .map(|(h, sign)| (unknown[h as usize / 3], sign))
            .filter(|term| term.0 != NONE)
            .collect();
        if terms.len() < 2 || terms[0].0 != terms[1].0 {
            system.add(weight, &terms, off);
        }
    }
    (0..count).for_each(|k| system.add(FRAME_HOLD, &[(k, 1.0)], 0.0));
    let by = system.solve(&mut None)?;
    for (frame, &k) in framed.frame.iter_mut().zip(&unknown).filter(|(_, k)| **k != NONE) {
        *frame = DMat2::from_angle(by[k as usize]) * *frame;
    }
    Ok(())
}
