//! What stays the same from one attempt to the next: curves between pieces that did not change, and surfaces between curves that
//! did not.

use super::curves::Track;
use super::regions::{Map, Piece};
use super::spline::{Fitted, MOST_EFFORT};
use super::topology::Chain;
use crate::mesh::NONE;
use glam::DVec3;
use std::collections::BTreeMap;

/// Pieces on both sides, first half-edge, number of half-edges, ends.
type TrackKey = ([u64; 2], u32, usize, [u64; 6]);

/// Results of earlier attempts.
#[derive(Default)]
pub struct Memory {
    tracks: BTreeMap<TrackKey, Option<Track>>,
    splines: BTreeMap<(u64, u64), Option<Fitted>>,
    /// What was spent on spline surfaces so far.
    pub effort: u64,
}

impl Memory {
    /// What the track of a chain between these ends depends on.
    pub fn key(map: &Map<'_>, chain: &Chain, ends: [DVec3; 2]) -> TrackKey {
        let of = |s: u32| if s == NONE { u64::MAX } else { map.pieces[s as usize].id };
        let [a, b] = ends.map(|p| p.to_array().map(f64::to_bits));
        (chain.sides.map(of), chain.half_edges[0], chain.half_edges.len(), [a[0], a[1], a[2], b[0], b[1], b[2]])
    }

    /// Whether no more is spent on spline surfaces.
    pub fn is_spent(&self) -> bool {
        self.effort >= MOST_EFFORT
    }

    /// An earlier track.
    pub fn track(&self, key: &TrackKey) -> Option<&Option<Track>> {
        self.tracks.get(key)
    }

    /// Keeps a track.
    pub fn keep_track(&mut self, key: TrackKey, track: &Option<Track>) {
        self.tracks.entry(key).or_insert_with(|| track.clone());
    }

    /// What the surface of a piece depends on: the piece and the curves around it.
    pub fn surface_key(piece: &Piece, chains: &[u32], tracks: &[Track]) -> (u64, u64) {
        // FNV-1a over the bits of the curves' ends and middles.
        let mut hash = 0xcbf2_9ce4_8422_2325_u64;
        let mut add = |x: u64| hash = (hash ^ x).wrapping_mul(0x0100_0000_01b3);
        for &k in chains {
            let Track { curve, range, .. } = &tracks[k as usize];
            for t in [range[0], 0.3 * range[0] + 0.7 * range[1], range[1]] {
                curve.point(t).to_array().into_iter().for_each(|x| add(x.to_bits()));
            }
        }
        (piece.id, hash)
    }

    /// An earlier surface.
    pub fn surface(&self, key: &(u64, u64)) -> Option<&Option<Fitted>> {
        self.splines.get(key)
    }

    /// Keeps a surface.
    pub fn keep_surface(&mut self, key: (u64, u64), fitted: &Option<Fitted>) {
        self.splines.entry(key).or_insert_with(|| fitted.clone());
    }
}
