//! Profiles of swept surfaces: vertices of the mesh, moved into the profile's plane, lie at a few places in a row.
//!
//! ```text
//!      d ↑  │╲│╲│╲│         seen along d:   ●──●──●──●
//!           │ ╲ ╲ ╲│
//! ```
//!
//! Sides of triangles join places that follow each other, and others. Places that are near to each other for how much the curve bends
//! are in the order of their minimum spanning tree, which is a path then (Figueiredo and Gomes, *Computational morphology of curves*,
//! The Visual Computer 11, 1994).

use super::regions::vertex_ids;
use super::trace::interpolate;
use crate::brep::Curve;
use crate::geometry::bspline::BSplineCurve;
use crate::mesh::Triangles;
use glam::DVec3;

/// A count: most places, because time grows with their square.
const PROFILE_PLACES: usize = 1500;
/// A count: rounds in which spans are divided, because a smooth curve needs fewer.
const SPAN_ROUNDS: usize = 16;
/// A factor: where two rounds bring the curve nearer by less, there is no smooth one, because a jump of the curvature
/// still leaves four of a halved span.
const PROFILE_GAIN: f64 = 2.0;

/// Places in their order.
#[derive(Debug, Clone)]
pub struct Profile {
    /// One after the other; the first one is not repeated.
    pub points: Vec<DVec3>,
    /// Whether the first one follows the last.
    pub closed: bool,
    /// Whether a closed one is smooth but for its first place.
    pub jointed: bool,
    /// Vertices of the mesh, ascending, and the numbers of their places.
    place_of: Vec<(u32, u32)>,
}

impl Profile {
    /// The places of the vertices of triangles, which `flat` moves into the plane of the profile; those that are nearer to each other
    /// than `apart` are one, which is where one of them is. `None` where they are not in a row, or not as many as `bounds` say.
    pub fn of(
        t: Triangles<'_>,
        triangles: &[u32],
        flat: impl Fn(DVec3) -> DVec3,
        across: DVec3,
        apart: f64,
        bounds: [usize; 2],
    ) -> Option<Self> {
        let vertices = vertex_ids(t, triangles);
        let place = |v: u32| flat(t.points()[v as usize]);
        let mut order: Vec<(f64, u32)> = vertices.iter().map(|&v| (place(v).dot(across), v)).collect();
        order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let [least, most] = [bounds[0], bounds[1].min(PROFILE_PLACES)];
        let mut places: Vec<DVec3> = Vec::new();
        let mut of: Vec<(u32, u32)> = Vec::with_capacity(order.len());
        let mut recent: Vec<(f64, u32)> = Vec::new();
        for (x, v) in order {
            recent.retain(|r| x - r.0 <= apart);
            let p = place(v);
            let known = recent.iter().find(|r| places[r.1 as usize].distance(p) <= apart).map(|r| r.1);
            of.push((v, known.unwrap_or(places.len() as u32)));
            if known.is_none() {
                recent.push((x, places.len() as u32));
                places.push(p);
            }
            if places.len() > most {
                return None;
            }
        }
        if places.len() < least {
            return None;
        }
        of.sort_unstable();
        let joined = joined(t, triangles, &of, places.len());
        let row = path(&places)?;
        let mut number = vec![0; row.len()];
        row.iter().zip(0u32..).for_each(|(&p, k)| number[p as usize] = k);
        let step = |a: u32, b: u32| places[a as usize].distance(places[b as usize]);
        let longest = row.windows(2).map(|w| step(w[0], w[1])).fold(0.0, f64::max);
        let (first, last) = (row[0], row[row.len() - 1]);
        let closed =
            row.len() > 3 && joined[first as usize].binary_search(&last).is_ok() && step(first, last) <= 1.5 * longest;
        Some(Profile {
            points: row.iter().map(|&p| places[p as usize]).collect(),
            closed,
            jointed: false,
            place_of: of.into_iter().map(|(v, p)| (v, number[p as usize])).collect(),
        })
    }

    /// Moves the ends of an open profile to the outermost of their vertices.
    pub fn reach_out(&mut self, t: Triangles<'_>, flat: impl Fn(DVec3) -> DVec3) {
        let n = self.points.len();
        if self.closed || n < 2 {
            return;
        }
        for (end, next) in [(0, 1), (n - 1, n - 2)] {
            let from = self.points[next];
            let of = self.place_of.iter().filter(|o| o.1 as usize == end).map(|o| flat(t.points()[o.0 as usize]));
            let far = of.max_by(|a, b| a.distance(from).total_cmp(&b.distance(from)));
            self.points[end] = far.unwrap_or(self.points[end]);
        }
    }

    /// The spline through all places, and its parameters there.
    pub fn curve(&self) -> Option<(BSplineCurve, Vec<f64>)> {
        let mut points = self.points.clone();
        points.extend(self.closed.then(|| points[0]));
        interpolate(&points, self.closed && !self.jointed)
    }

    /// Makes places of those vertices in the plane that are farthest from the curve, until all are `near` it; false where that does not
    /// help. Places stay `apart`.
    pub fn refine(&mut self, vertices: &[DVec3], near: f64, apart: f64) -> bool {
        let mut before = [f64::INFINITY; 2];
        for _ in 0..SPAN_ROUNDS {
            let Some((curve, times)) = self.curve() else { return false };
            let curve = Curve::Spline(curve);
            let mut worst: Vec<(f64, f64, DVec3)> = vec![(near, 0.0, DVec3::ZERO); times.len() - 1];
            for &p in vertices {
                let t = curve.project(p);
                let span = times.partition_point(|&x| x <= t).clamp(1, times.len() - 1) - 1;
                let off = curve.point(t).distance(p);
                if off > worst[span].0 {
                    worst[span] = (off, t, p);
                }
            }
            let Some((span, far)) = (0..worst.len())
                .map(|k| (k, worst[k].0))
                .filter(|w| w.1 > near)
                .max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)))
            else {
                return true;
            };
            if PROFILE_GAIN * far > before[0] {
                // A closed curve that was drawn from a point to the same point is often smooth everywhere else.
                if !self.closed || self.jointed {
                    return false;
                }
                let past = 2.0 * worst[span].1 > times[span] + times[span + 1];
                self.begin_at((span + usize::from(past)) % self.points.len());
                (self.jointed, before) = (true, [f64::INFINITY; 2]);
                continue;
            }
            before = [before[1], far];
            let count = self.points.len();
            for (k, (_, _, p)) in worst.iter().enumerate().filter(|(_, w)| w.0 > near).rev() {
                let ends = [self.points[k], self.points[(k + 1) % count]];
                if ends.iter().all(|e| e.distance(*p) > apart) {
                    self.points.insert(k + 1, *p);
                }
            }
            if self.points.len() == count || self.points.len() > vertices.len() / 2 {
                return false;
            }
        }
        false
    }

    /// The number of the place of a vertex.
    pub fn place(&self, v: u32) -> usize {
        self.place_of.binary_search_by_key(&v, |o| o.0).map_or(0, |k| self.place_of[k].1 as usize)
    }

    /// Puts another place first, of a closed profile.
    pub fn begin_at(&mut self, first: usize) {
        let n = self.points.len();
        self.points.rotate_left(first);
        self.place_of.iter_mut().for_each(|o| o.1 = ((o.1 as usize + n - first) % n) as u32);
    }
}

/// The places that sides of triangles join, of every place, ascending.
fn joined(t: Triangles<'_>, triangles: &[u32], of: &[(u32, u32)], count: usize) -> Vec<Vec<u32>> {
    let place = |v: u32| of.binary_search_by_key(&v, |o| o.0).map_or(0, |k| of[k].1);
    let mut next: Vec<Vec<u32>> = vec![Vec::new(); count];
    for &k in triangles {
        let c = t.triangle(k).map(place);
        for (a, b) in [(c[0], c[1]), (c[1], c[2]), (c[2], c[0])] {
            if a != b {
                next[a as usize].push(b);
                next[b as usize].push(a);
            }
        }
    }
    for list in &mut next {
        list.sort_unstable();
        list.dedup();
    }
    next
}

/// The minimum spanning tree, by Prim's algorithm, from one end to the other; `None` where it branches.
fn path(places: &[DVec3]) -> Option<Vec<u32>> {
    let n = places.len();
    let mut beside: Vec<Vec<u32>> = vec![Vec::new(); n];
    let mut best: Vec<(f64, u32)> = vec![(f64::INFINITY, 0); n];
    let mut done = vec![false; n];
    let mut at = 0;
    for _ in 1..n {
        done[at] = true;
        for k in (0..n).filter(|&k| !done[k]) {
            let far = places[at].distance(places[k]);
            if far < best[k].0 {
                best[k] = (far, at as u32);
            }
        }
        at = (0..n).filter(|&k| !done[k]).min_by(|&a, &b| best[a].0.total_cmp(&best[b].0))?;
        let from = best[at].1;
        beside[at].push(from);
        beside[from as usize].push(at as u32);
        if beside[from as usize].len() > 2 {
            return None;
        }
    }
    let start = beside.iter().position(|b| b.len() == 1)?;
    let mut row = vec![start as u32];
    let mut before = u32::MAX;
    while let Some(&to) = beside[row[row.len() - 1] as usize].iter().find(|&&b| b != before) {
        before = row[row.len() - 1];
        row.push(to);
    }
    Some(row)
}
