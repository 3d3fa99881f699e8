//! Decimation of the flat metric to its cones: edges at a vertex are flipped until three faces are left, which become one, or four,
//! which become two.
//! Vertices in the middle of a straight feature keep two faces a side, which become one each. Then Delaunay flips.
//!
//! ```text
//!       c                 c                  c                   c
//!      ╱│╲               ╱ ╲                ╱│╲                 ╱ ╲
//!     ╱ v ╲      →      ╱   ╲              a━v━b        →      a━━━b
//!    ╱╱   ╲╲           ╱     ╲              ╲│╱                 ╲ ╱
//!   a───────b         a───────b              d                   d
//! ```

use super::flat::{Flat, Side};
use super::framed::{next, previous};
use super::tuning::{DELAUNAY_FLIPS, LEAST_AREA, REMOVAL_FLIPS, REMOVAL_PASSES};
use crate::context::Context;
use crate::error::Result;
use crate::mesh::NONE;
use std::f64::consts::PI;

/// Removes all vertices that need not stay, as far as that goes; returns the number of those that stay all the same.
pub fn decimate(flat: &mut Flat, is_kept: &[bool], context: &Context) -> Result<usize> {
    let mut left: Vec<u32> =
        (0..is_kept.len() as u32).filter(|&v| !is_kept[v as usize] && flat.at[v as usize] != NONE).collect();
    for pass in 0..REMOVAL_PASSES {
        context.check()?;
        let before = left.len();
        left.retain(|&v| !remove(flat, v));
        if left.is_empty() || left.len() == before && pass > 0 {
            break;
        }
        if left.len() * 4 < before || left.len() == before {
            delaunay(flat);
        }
    }
    delaunay(flat);
    Ok(left.len())
}

fn remove(flat: &mut Flat, v: u32) -> bool {
    let Some((star, is_closed)) = flat.star(v) else { return false };
    match is_closed && star.iter().all(|&h| flat.side(h).curve == NONE) {
        true => remove_inner(flat, v),
        false => remove_on_curve(flat, v),
    }
}

/// Flips one of the edges that leave a vertex, the longest first.
fn flip_any(flat: &mut Flat, v: u32, edges: &[u32]) -> bool {
    let mut all: Vec<(f64, u32)> = edges.iter().map(|&h| (flat.side(h).vector.length_squared(), h)).collect();
    all.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    all.iter().any(|&(_, h)| flat.side(next(h)).vertex != v && flat.flip(h, LEAST_AREA))
}

fn remove_inner(flat: &mut Flat, v: u32) -> bool {
    for _ in 0..REMOVAL_FLIPS {
        let Some((star, true)) = flat.star(v) else { return false };
        let faces = [0, 1, 2].map(|k| star.get(k).map_or(NONE, |h| h / 3));
        if star.len() < 3 {
            return false;
        }
        if star.len() == 3 && faces[0] != faces[1] && faces[1] != faces[2] && faces[0] != faces[2] {
            return close_three(flat, v, &star);
        }
        // In the middle of a strip no flip is left: two of the four are in line with it.
        if let [a, b, c, d] = star[..]
            && [[a, b, c, d], [b, c, d, a]]
                .iter()
                .any(|&[a, b, c, d]| is_straight(flat, a, b, c) && close_halves(flat, v, &[vec![a, b], vec![c, d]]))
        {
            return true;
        }
        if !flip_any(flat, v, &star) {
            return false;
        }
    }
    false
}

/// Whether the first and the third of edges that leave a vertex one after the other are in line.
fn is_straight(flat: &Flat, a: u32, b: u32, c: u32) -> bool {
    let [from, to] = [a, c].map(|h| flat.side(h).vector.length());
    let off = flat.corner_angle(a) + flat.corner_angle(b) - PI;
    (from * to * off).abs() <= LEAST_AREA
}

/// Makes one face of the three around a vertex.
fn close_three(flat: &mut Flat, v: u32, star: &[u32]) -> bool {
    let mut moved = Vec::new();
    let mut sides: Vec<Side> = Vec::new();
    let (target, mut turn) = (star[0] / 3 * 3, 0);
    for (k, &h) in star.iter().enumerate() {
        sides.push(flat.side(next(h)).turned(-turn));
        moved.push((next(h), target + k as u32, -turn));
        turn += flat.side(previous(h)).turn;
    }
    if sides.iter().any(|s| s.vertex == v) {
        return false;
    }
    replace(flat, v, &moved, &sides, &[star[1] / 3, star[2] / 3]);
    true
}

/// Puts sides where they go, and drops faces and the vertex.
fn replace(flat: &mut Flat, v: u32, moved: &[(u32, u32, i32)], sides: &[Side], dropped: &[u32]) {
    for (&(_, h, _), &side) in moved.iter().zip(sides) {
        flat.sides[h as usize] = side;
    }
    dropped.iter().for_each(|&f| flat.is_alive[f as usize] = false);
    flat.relink(moved);
    for (&(_, h, _), side) in moved.iter().zip(sides) {
        flat.at[side.vertex as usize] = h;
    }
    flat.at[v as usize] = NONE;
}

/// A vertex in the middle of a straight feature or border.
fn remove_on_curve(flat: &mut Flat, v: u32) -> bool {
    for _ in 0..REMOVAL_FLIPS {
        let Some((star, is_closed)) = flat.star(v) else { return false };
        let Some(fans) = sides_of_curve(flat, &star, is_closed) else { return false };
        if fans.iter().all(|fan| fan.len() == 2) {
            return close_halves(flat, v, &fans);
        }
        // The first edge of a fan is on the curve.
        let mut wide = fans.iter().filter(|fan| fan.len() > 2);
        if fans.iter().any(|fan| fan.len() < 2) || !wide.any(|fan| flip_any(flat, v, &fan[1..])) {
            return false;
        }
    }
    false
}

/// The half-edges on each side of a curve through a vertex, one of it first; `None` where there is not one curve.
fn sides_of_curve(flat: &Flat, star: &[u32], is_closed: bool) -> Option<Vec<Vec<u32>>> {
    let on: Vec<usize> = (0..star.len()).filter(|&k| flat.side(star[k]).curve != NONE).collect();
    let curve = |k: usize| flat.side(star[k]).curve;
    match (is_closed, &on[..]) {
        (true, &[a, b]) if curve(a) == curve(b) => {
            let rest = star[b..].iter().chain(&star[..a]).copied().collect();
            Some(vec![star[a..b].to_vec(), rest])
        }
        (false, &[0]) if flat.side(previous(star[star.len() - 1])).curve == curve(0) => Some(vec![star.to_vec()]),
        _ => None,
    }
}

/// Makes one face of two on each side of a curve, or of the line between two of the four vertices around one.
fn close_halves(flat: &mut Flat, v: u32, fans: &[Vec<u32>]) -> bool {
    let faces: Vec<u32> = fans.iter().flatten().map(|h| h / 3).collect();
    let mut unique = faces.clone();
    unique.sort_unstable();
    unique.dedup();
    if unique.len() < faces.len() {
        return false;
    }
    let (mut moved, mut sides, mut dropped, mut closing) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for fan in fans {
        let [h, g] = fan[..] else { return false };
        let (target, turn) = (h / 3 * 3, flat.side(previous(h)).turn);
        let (first, second) = (*flat.side(next(h)), flat.side(next(g)).turned(-turn));
        // Back to the first vertex, along the curve: what was the edge from the last one to v.
        let last = flat.side(previous(g)).turned(-turn);
        let back = Side { vector: -(first.vector + second.vector), cells: -(first.cells + second.cells), ..last };
        if first.vector.perp_dot(second.vector) <= LEAST_AREA || [first, second, back].iter().any(|s| s.vertex == v) {
            return false;
        }
        moved.extend([(next(h), target, 0), (next(g), target + 1, -turn)]);
        sides.extend([first, second]);
        closing.push((target + 2, back, flat.side(h).turn, turn));
        dropped.push(g / 3);
    }
    if let [(_, _, own, _), (.., other)] = closing[..] {
        // From the first face across its old edge from v into the last face of the other fan, then back to that fan's frame.
        let turn = own - other;
        (closing[0].2, closing[1].2) = (turn, -turn);
    }
    replace(flat, v, &moved, &sides, &dropped);
    for (k, &(h, back, turn, _)) in closing.iter().enumerate() {
        let opposite = if closing.len() == 2 { closing[1 - k].0 } else { NONE };
        flat.sides[h as usize] = Side { opposite, turn: turn.rem_euclid(4), ..back };
        flat.at[back.vertex as usize] = h;
    }
    true
}

/// Flips edges until the triangulation is Delaunay.
pub fn delaunay(flat: &mut Flat) {
    let mut stack: Vec<u32> = flat.faces().flat_map(|f| [3 * f, 3 * f + 1, 3 * f + 2]).collect();
    let mut flips = DELAUNAY_FLIPS * stack.len();
    let cotangent = |flat: &Flat, h: u32| {
        let (u, w) = (flat.side(previous(h)).vector, -flat.side(next(h)).vector);
        u.dot(w) / u.perp_dot(w).abs()
    };
    while let Some(h) = stack.pop() {
        let o = flat.side(h).opposite;
        if o == NONE || cotangent(flat, h) + cotangent(flat, o) >= -1e-9 {
            continue;
        }
        if flips > 0 && flat.flip(h, LEAST_AREA) {
            flips -= 1;
            let (f, g) = (h / 3 * 3, o / 3 * 3);
            stack.extend([f, f + 1, f + 2, g, g + 1, g + 2]);
        }
    }
}
