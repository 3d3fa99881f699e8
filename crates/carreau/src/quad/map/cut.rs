//! The surface is cut to a disc on which frames turn across no edge: a tree of triangles that reaches all, then leaves of the
//! cut are sewn until they end at singularities and borders.

use super::framed::{Framed, next};
use crate::mesh::{DisjointSets, NONE};
use std::collections::VecDeque;

/// The disc.
pub struct Cut {
    /// Branches by which the frame of every triangle was turned.
    pub comb: Vec<i32>,
    /// Turns across half-edges between the frames as they are now.
    pub turn: Vec<i32>,
    /// Inner half-edges along the cut, one for each edge.
    pub seams: Vec<u32>,
    /// Point of the disc at every corner.
    pub node: Vec<u32>,
    pub nodes: usize,
    /// A node of every component of the surface.
    pub anchors: Vec<u32>,
}

/// Cuts the surface open; or says why it can't be.
pub fn cut(framed: &Framed) -> Result<Cut, String> {
    let mut is_sewn = vec![false; framed.opposite.len()];
    let (comb, firsts) = combed(framed, &mut is_sewn);
    let turn: Vec<i32> = (0..framed.opposite.len())
        .map(|h| match framed.opposite[h] {
            NONE => 0,
            o => (framed.turn[h] - comb[o as usize / 3] + comb[h / 3]).rem_euclid(4),
        })
        .collect();
    sew_leaves(framed, &turn, &mut is_sewn)?;
    let mut sets = DisjointSets::new(framed.opposite.len());
    for h in (0..framed.opposite.len() as u32).filter(|&h| is_sewn[h as usize]) {
        let o = framed.opposite[h as usize];
        sets.union(h, next(o));
        sets.union(next(h), o);
    }
    let (node, nodes) = sets.labels();
    let is_seam = |h: &u32| {
        let o = framed.opposite[*h as usize];
        o != NONE && *h < o && !is_sewn[*h as usize]
    };
    let seams = (0..framed.opposite.len() as u32).filter(is_seam).collect();
    let anchors = firsts.into_iter().map(|t| node[3 * t as usize]).collect();
    Ok(Cut { comb, turn, seams, node, nodes, anchors })
}

/// Turns of all frames so that they agree along a tree of triangles, and the first triangle of every component.
fn combed(framed: &Framed, is_sewn: &mut [bool]) -> (Vec<i32>, Vec<u32>) {
    let n = framed.triangles.len();
    let (mut comb, mut known, mut firsts) = (vec![0; n], vec![false; n], Vec::new());
    for first in 0..n {
        if std::mem::replace(&mut known[first], true) {
            continue;
        }
        firsts.push(first as u32);
        let mut queue = VecDeque::from([first]);
        while let Some(t) = queue.pop_front() {
            for h in 3 * t..3 * t + 3 {
                let o = framed.opposite[h];
                if o == NONE || std::mem::replace(&mut known[o as usize / 3], true) {
                    continue;
                }
                comb[o as usize / 3] = (comb[t] + framed.turn[h]).rem_euclid(4);
                (is_sewn[h], is_sewn[o as usize]) = (true, true);
                queue.push_back(o as usize / 3);
            }
        }
    }
    (comb, firsts)
}

/// Sews edges of the cut that end at regular vertices.
fn sew_leaves(framed: &Framed, turn: &[i32], is_sewn: &mut [bool]) -> Result<(), String> {
    let n = framed.points.len();
    let (mut at, mut stays) = (vec![Vec::new(); n], vec![false; n]);
    for h in 0..framed.opposite.len() as u32 {
        let (o, ends) = (framed.opposite[h as usize], [framed.tail(h), framed.tail(next(h))]);
        if o == NONE {
            ends.iter().for_each(|&v| stays[v as usize] = true);
        } else if h < o && !is_sewn[h as usize] {
            ends.iter().for_each(|&v| at[v as usize].push(h));
        }
    }
    (0..n).for_each(|v| stays[v] |= framed.quads[v] != 4);
    let mut leaves: Vec<u32> = (0..n as u32).filter(|&v| at[v as usize].len() == 1 && !stays[v as usize]).collect();
    while let Some(v) = leaves.pop() {
        let [h] = at[v as usize][..] else { continue };
        if turn[h as usize] != 0 {
            return Err("the field turns around a regular vertex".into());
        }
        let o = framed.opposite[h as usize];
        (is_sewn[h as usize], is_sewn[o as usize]) = (true, true);
        for w in [framed.tail(h), framed.tail(next(h))] {
            at[w as usize].retain(|&other| other != h);
            if at[w as usize].len() == 1 && !stays[w as usize] {
                leaves.push(w);
            }
        }
    }
    Ok(())
}
