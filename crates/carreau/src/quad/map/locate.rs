//! From a place in a face of the decimated metric back to the surface: the direction from the nearest corner, by its signpost, and
//! a straight line from there across the triangles of the working mesh. Places on features are found along them.

use super::flat::Flat;
use super::framed::{Framed, next, previous, turned};
use super::seamless::Map;
use super::tuning::MOST_CROSSED;
use crate::mesh::NONE;
use glam::{DVec2, DVec3};
use std::f64::consts::TAU;

/// The way back.
pub struct Locator<'a> {
    framed: &'a Framed,
    map: &'a Map,
    /// Map lengths are so many times those of the working mesh.
    scale: f64,
    /// Half-edges that leave every vertex, with their angles, and the whole angle.
    stars: Vec<Star>,
}

#[derive(Default, Clone)]
struct Star {
    edges: Vec<(f64, u32)>,
    whole: f64,
    is_closed: bool,
}

impl<'a> Locator<'a> {
    pub fn new(framed: &'a Framed, map: &'a Map, scale: f64) -> Self {
        let mut stars: Vec<Star> = vec![Star::default(); framed.points.len()];
        for h in 0..framed.opposite.len() as u32 {
            let star = &mut stars[framed.tail(h) as usize];
            if !star.edges.is_empty() {
                continue;
            }
            let (fan, is_closed) = framed.fan(h);
            star.is_closed = is_closed;
            for h in fan {
                star.edges.push((star.whole, h));
                star.whole += map.along(h).angle_to(-map.along(previous(h)));
            }
        }
        Locator { framed, map, scale, stars }
    }

    /// The point of a face at so much of its first and second edges from its first corner.
    pub fn in_face(&self, flat: &Flat, f: u32, share: [f64; 3]) -> DVec3 {
        let k = (0..3).fold(0, |best, k| if share[k] > share[best] { k } else { best });
        let h = 3 * f + k as u32;
        let (side, last) = (flat.side(h), flat.side(previous(h)));
        let way = side.vector * share[(k + 1) % 3] - last.vector * share[(k + 2) % 3];
        if way.length() < 1e-9 {
            return self.framed.points[side.vertex as usize];
        }
        self.walked_from(side.vertex, side.post + side.vector.angle_to(way), way.length() / self.scale)
    }

    /// The point at a length along the feature that a half-edge lies on.
    pub fn on_curve(&self, flat: &Flat, h: u32, share: f64) -> DVec3 {
        let side = flat.side(h);
        let star = &self.stars[side.vertex as usize];
        let off = |angle: f64| {
            let off = (angle - side.post).rem_euclid(if star.is_closed { star.whole } else { TAU });
            off.min(if star.is_closed { star.whole - off } else { TAU - off })
        };
        let on = star.edges.iter().filter(|e| self.framed.curve[e.1 as usize] != NONE);
        let Some(&(_, mut at)) = on.min_by(|a, b| off(a.0).total_cmp(&off(b.0)).then(a.1.cmp(&b.1))) else {
            return self.in_face(flat, h / 3, share_of_edge(h, share));
        };
        let mut left = share * side.vector.length() / self.scale;
        for _ in 0..MOST_CROSSED {
            let length = self.map.along(at).length();
            if left <= length {
                break;
            }
            let Some(further) = self.further(at) else {
                left = length;
                break;
            };
            left -= length;
            at = further;
        }
        let share = (left / self.map.along(at).length()).clamp(0.0, 1.0);
        let [a, b] = [at, next(at)].map(|h| self.framed.points[self.framed.tail(h) as usize]);
        a.lerp(b, share)
    }

    /// The next half-edge of a feature.
    fn further(&self, h: u32) -> Option<u32> {
        let mut at = next(h);
        for _ in 0..MOST_CROSSED {
            if self.framed.curve[at as usize] != NONE {
                return Some(at);
            }
            at = next(self.framed.opposite[at as usize]);
        }
        None
    }

    fn walked_from(&self, v: u32, angle: f64, length: f64) -> DVec3 {
        let star = &self.stars[v as usize];
        let angle = if star.is_closed { angle.rem_euclid(star.whole) } else { angle.clamp(0.0, star.whole) };
        let Some(&(from, h)) = star.edges.iter().rev().find(|e| e.0 <= angle).or(star.edges.first()) else {
            return self.framed.points[v as usize];
        };
        let along = self.map.along(h).normalize_or_zero();
        self.straight(h, DVec2::from_angle(angle - from).rotate(along) * length)
    }

    /// From the corner that a half-edge leaves.
    fn straight(&self, h: u32, mut way: DVec2) -> DVec3 {
        let (mut t, mut at, mut entered) = (h / 3, self.map.uv[h as usize], None);
        // At a corner only the side across can be left through.
        let mut only = Some(next(h));
        for _ in 0..MOST_CROSSED {
            let sides = [3 * t, 3 * t + 1, 3 * t + 2];
            let mut exit = (1.0, None);
            for h in sides.into_iter().filter(|&h| Some(h) != entered && only.is_none_or(|o| o == h)) {
                let along = self.map.along(h);
                // Left of the side is inside.
                let (inside, towards) = (along.perp_dot(at - self.map.uv[h as usize]), along.perp_dot(way));
                if towards < 0.0 {
                    let share = (inside / -towards).max(0.0);
                    if share < exit.0 {
                        exit = (share, Some(h));
                    }
                }
            }
            at += way * exit.0;
            way *= 1.0 - exit.0;
            let Some(h) = exit.1 else { break };
            let o = self.framed.opposite[h as usize];
            if o == NONE {
                break;
            }
            let turn = self.map.turn[h as usize];
            at = turned(at - self.map.uv[h as usize], turn) + self.map.uv[next(o) as usize];
            way = turned(way, turn);
            (t, entered, only) = (o / 3, Some(o), None);
        }
        self.at(t, at)
    }

    /// The point of a triangle at a place of the map.
    fn at(&self, t: u32, at: DVec2) -> DVec3 {
        let [a, b, c] = [0, 1, 2].map(|k| self.map.uv[3 * t as usize + k]);
        let whole = (b - a).perp_dot(c - a);
        let shares = [(b, c), (c, a), (a, b)].map(|(p, q)| ((p - at).perp_dot(q - at) / whole).max(0.0));
        let sum: f64 = shares.iter().sum();
        let points = self.framed.triangles[t as usize].map(|v| self.framed.points[v as usize]);
        points.iter().zip(shares).map(|(p, share)| *p * (share / sum)).sum()
    }
}

/// Barycentric shares of a point on an edge.
pub fn share_of_edge(h: u32, share: f64) -> [f64; 3] {
    let mut shares = [0.0; 3];
    shares[h as usize % 3] = 1.0 - share;
    shares[next(h) as usize % 3] = share;
    shares
}
