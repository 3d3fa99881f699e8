//! Smoothing: vertices move to the mean of their neighbours, back to their curve or region, and only as far as the worst
//! quad around them allows; then quads that are turned over and the worst ones are looked after one by one.

use super::apices;
use super::around::{Around, BAD_JACOBIAN, Moves, Ring};
use super::bends;
use super::fit::fit;
use super::source::Source;
use super::straighten::straighten;
use super::untangle::untangle;
use super::validate::keeps_feature;
use super::work::{Place, Work};
use crate::context::Context;
use crate::error::Result;
use crate::geometry::quality::scaled_jacobian;
use glam::DVec3;

/// A count: sweeps over the vertices at most, because later ones hardly move any of them.
const MOST_SWEEPS: usize = 20;
/// A scaled Jacobian over what it can be: a move may worsen quads down to it, because even quads are worth more than a
/// few that are perfect.
pub const GOOD_SHAPE: f64 = 0.75;
/// Shares of the way to a place, in the order in which they are tried, because quads may allow a part of it only.
pub const WAY_SHARES: [f64; 3] = [1.0, 0.5, 0.2];
/// A scaled Jacobian over what it can be: vertices with a worse quad are looked after one by one, because the mean of
/// their neighbours is no good place for them.
pub const POOR_SHAPE: f64 = 0.6;
/// A count: rounds in which these are looked after, because a vertex that moves makes room for others.
const CARE_ROUNDS: usize = 30;
/// Shares of the mean edge: steps of these rounds in turn, from long to short because what is found far off is refined
/// nearby.
const CARE_STEPS: [f64; 5] = [0.3, 0.15, 0.07, 0.03, 0.015];
/// A share of the mean edge: edges of these vertices become no shorter, because both ends would come to lie on each
/// other.
const SHORTEST_EDGE: f64 = 0.05;
/// A share of the mean edge: a vertex that slides along a curve leaves edges as long, because those beside it are to
/// stay alike.
const SLID_EDGE: f64 = 0.4;
/// A share of the distance and the angle within which a feature is kept: vertices on curves move no farther off,
/// because others beside them move, too.
pub const KEPT_SHARE: f64 = 0.7;
/// The same for vertices that are looked after one by one, as far as may be seen in a few places.
pub const LOOKED_AFTER_SHARE: f64 = 0.9;
/// A scaled Jacobian over what it can be: no vertex that is looked after leaves a worse one that was better.
const SOUND_SHAPE: f64 = 0.1;
/// A share of the quads: where more are turned over nothing is moved, because it would be of no use.
const HOPELESS_TURNED: f64 = 0.5;

/// Puts vertices on features to where these bend, smooths what may move, and fits it to the surface.
pub fn smooth(work: &mut Work, source: &Source, context: &Context) -> Result<()> {
    let mut smoothing = Smoothing::new(work, source);
    match smoothing.settle(work, source, context)? {
        Settled::Hopeless => Ok(()),
        Settled::Turned => smoothing.finish(work, source, context),
        Settled::Even => smoothing.fit(work, source, context),
    }
}

/// What has become of quads before poor ones are looked after.
enum Settled {
    /// Too many are turned over: none was moved.
    Hopeless,
    /// Some are turned over still.
    Turned,
    Even,
}

/// Smoothing whose features are done: vertices on them are where these bend, and others have not moved yet.
pub struct Smoothing {
    around: Around,
    held: Vec<(u32, Place)>,
    /// What was even, before poor quads were looked after: the vertices, and where they may go.
    even: Option<(Vec<DVec3>, Vec<Place>)>,
}

impl Smoothing {
    pub fn new(work: &mut Work, source: &Source) -> Self {
        let mut around = Around::new(work);
        if let Some(sizes) = &source.guidance.sizes {
            around.size = work.points.iter().map(|&p| sizes.at(p)).collect();
        }
        let held = bends::follow(work, &around, source);
        apices::follow(work, &mut around, source);
        Smoothing { around, held, even: None }
    }

    /// Makes quads even and none poor, as far as that can be.
    pub fn run(&mut self, work: &mut Work, source: &Source, context: &Context) -> Result<()> {
        match self.settle(work, source, context)? {
            Settled::Hopeless => Ok(()),
            Settled::Turned | Settled::Even => self.finish(work, source, context),
        }
    }

    fn settle(&mut self, work: &mut Work, source: &Source, context: &Context) -> Result<Settled> {
        let _stage = context.stage("smooth");
        let around = &self.around;
        if turned(work).len() as f64 > HOPELESS_TURNED * work.faces.len() as f64 {
            return Ok(Settled::Hopeless);
        }
        straighten(work, around, source, context)?;
        for _ in 0..MOST_SWEEPS {
            let mut moved = 0usize;
            for v in 0..work.points.len() as u32 {
                context.check_every(v as usize)?;
                let has_moved = even_out(work, around, source, v);
                moved += usize::from(has_moved);
            }
            if moved * 100 < work.points.len() {
                break;
            }
        }
        // What stays turned over is refused: how near it is to the surface does not matter.
        if !untangle(work, around, source, context)? {
            return Ok(Settled::Turned);
        }
        self.even = Some((work.points.clone(), work.place.clone()));
        Ok(Settled::Even)
    }

    /// Takes quads that have been smoothed nearer to the surface.
    pub fn fit(self, work: &mut Work, source: &Source, context: &Context) -> Result<()> {
        let Some((points, place)) = &self.even else { return Ok(()) };
        work.points.clone_from(points);
        work.place.clone_from(place);
        {
            let _stage = context.stage("smooth");
            fit(work, &self.around, source, |_| true, context)?;
        }
        self.finish(work, source, context)
    }

    /// Takes some of the vertices of quads that are done nearer to the surface.
    pub fn fit_some(&self, work: &mut Work, source: &Source, is_wanted: &[bool], context: &Context) -> Result<()> {
        {
            let _stage = context.stage("smooth");
            fit(work, &self.around, source, |v| is_wanted[v as usize], context)?;
        }
        self.finish(work, source, context)
    }

    fn finish(&self, work: &mut Work, source: &Source, context: &Context) -> Result<()> {
        let _stage = context.stage("smooth");
        look_after(work, &self.around, source, context)?;
        if bends::let_go(work, &self.around, &self.held) {
            look_after(work, &self.around, source, context)?;
        }
        Ok(())
    }
}

/// The same for some of the vertices: they become even, are turned over no more, and are looked after.
pub fn smooth_near(work: &mut Work, around: &Around, source: &Source, near: &[u32], context: &Context) -> Result<()> {
    for _ in 0..MOST_SWEEPS {
        let mut has_moved = false;
        for &v in near {
            context.check_every(v as usize)?;
            has_moved |= even_out(work, around, source, v);
        }
        if !has_moved {
            break;
        }
    }
    untangle(work, around, source, context)?;
    for round in 0..CARE_ROUNDS {
        for &v in near {
            improve(work, around, source, v, CARE_STEPS[round % CARE_STEPS.len()]);
        }
    }
    Ok(())
}

/// Looks for better places for all that have a poor quad.
fn look_after(work: &mut Work, around: &Around, source: &Source, context: &Context) -> Result<()> {
    let mut moves = Moves::new(work);
    for round in 0..CARE_ROUNDS {
        for v in 0..work.points.len() as u32 {
            context.check_every(v as usize)?;
            if moves.any_since(round, CARE_STEPS.len(), work, around, v) {
                let from = work.points[v as usize];
                improve(work, around, source, v, CARE_STEPS[round % CARE_STEPS.len()]);
                moves.note(round, v, work.points[v as usize] != from);
            }
        }
    }
    Ok(())
}

/// The scaled Jacobian of a quad.
pub fn jacobian(work: &Work, q: u32) -> f64 {
    let face = work.faces.face(q as usize);
    scaled_jacobian([0, 1, 2, 3].map(|k| work.points[face[k] as usize]))
}

/// Quads that are turned over, or all but.
pub fn turned(work: &Work) -> Vec<u32> {
    (0..work.faces.len() as u32).filter(|&q| jacobian(work, q) <= BAD_JACOBIAN).collect()
}

/// Moves a vertex towards its neighbours, in its region or along its curve.
fn even_out(work: &mut Work, around: &Around, source: &Source, v: u32) -> bool {
    match work.place[v as usize] {
        Place::Region(_) => relax(work, around, source, v),
        Place::Curve(_) => slide(work, around, source, v),
        Place::Fixed => false,
    }
}

/// Moves a vertex inside a region towards the mean of its neighbours.
fn relax(work: &mut Work, around: &Around, source: &Source, v: u32) -> bool {
    let neighbours = &around.neighbours[v as usize];
    if neighbours.is_empty() {
        return false;
    }
    let from = work.points[v as usize];
    let mean = around.mean(work, v);
    let ring = Ring::new(work, around, v);
    let least = ring.now.min(GOOD_SHAPE);
    let up = ring.up();
    // Along the surface alone: across it, vertices of a thin part would slip from its rim to its sides.
    let step = (mean - from).reject_from_normalized(up.normalize_or(DVec3::ZERO));
    let mut places = WAY_SHARES.iter().filter_map(|share| work.put_back_facing(source, v, from + step * share, up));
    let Some(to) = places.find(|&to| ring.holds(to, least)) else { return false };
    work.points[v as usize] = to;
    to.distance_squared(from) > 1e-4 * mean.distance_squared(work.points[neighbours[0] as usize])
}

/// Moves a vertex on a curve along it towards the mean of its neighbours, but only where the quads around are skewed: else it
/// is where its curve turns, and stays.
///
/// ```text
///  ━━━━━╾─v──╼━━━━        ━━━━━━━v━━━━
///    ╱   ╱   ╱       →      │    │    │
///   ╱   ╱   ╱               │    │    │
/// ```
fn slide(work: &mut Work, around: &Around, source: &Source, v: u32) -> bool {
    let from = work.points[v as usize];
    let ring = Ring::new(work, around, v);
    let before = ring.now;
    if before >= GOOD_SHAPE {
        return false;
    }
    let (mut sum, mut count) = (DVec3::ZERO, 0.0);
    for &q in &around.quads[v as usize] {
        let face = work.faces.face(q as usize);
        for k in (0..4).filter(|&k| face[(k + 1) % 4] == v || face[(k + 3) % 4] == v) {
            (sum, count) = (sum + work.points[face[k] as usize], count + 1.0);
        }
    }
    let (mean, length) = (sum / count, around.mean_edge(work, v));
    let least = around.shortest_edge(work, v, from).min(SLID_EDGE * length);
    let to = WAY_SHARES.iter().map(|share| work.put_back(source, v, from + (mean - from) * share)).find(|&to| {
        ring.holds(to, before)
            && around.shortest_edge(work, v, to) >= least
            && keeps_feature_at(work, around, source, v, to, KEPT_SHARE)
    });
    let Some(to) = to else { return false };
    work.points[v as usize] = to;
    to.distance_squared(from) > 1e-4 * length.powi(2)
}

/// Looks around a vertex with a poor quad for a better place.
fn improve(work: &mut Work, around: &Around, source: &Source, v: u32, step: f64) {
    if work.place[v as usize] == Place::Fixed || around.neighbours[v as usize].is_empty() {
        return;
    }
    let from = work.points[v as usize];
    let ring = Ring::new(work, around, v);
    if ring.now >= POOR_SHAPE {
        return;
    }
    let mut best = (ring.distress(from), from);
    let length = around.mean_edge(work, v);
    let least = around.shortest_edge(work, v, from).min(SHORTEST_EDGE * length);
    // A sum may fall although its worst part rises: no quad is turned over for that.
    let holds = ring.now.min(SOUND_SHAPE);
    let up = around.up(work, v);
    let (x, y) = up.any_orthonormal_pair();
    for k in 0..8 {
        let (sin, cos) = (std::f64::consts::FRAC_PI_4 * f64::from(k)).sin_cos();
        let to = from + (x * cos + y * sin) * step * length;
        let Some(to) = work.put_back_facing(source, v, to, up) else { continue };
        let found = ring.distress(to);
        if found < best.0 * (1.0 - 1e-6)
            && ring.holds(to, holds)
            && around.shortest_edge(work, v, to) >= least
            && keeps_feature_at(work, around, source, v, to, LOOKED_AFTER_SHARE)
        {
            best = (found, to);
        }
    }
    work.points[v as usize] = best.1;
}

/// Whether a vertex on a curve may be elsewhere on it: its edges must not come off it, by a share of what counts as off.
pub fn keeps_feature_at(work: &Work, around: &Around, source: &Source, v: u32, at: DVec3, share: f64) -> bool {
    let Place::Curve(curve) = work.place[v as usize] else { return true };
    let keeps = |w: u32, at: DVec3, share: f64| keeps_feature(source, curve, [work.points[w as usize], at], share);
    let neighbours = &around.neighbours[v as usize];
    neighbours.iter().all(|&w| keeps(w, at, share) || !keeps(w, work.points[v as usize], 1.0))
}

#[cfg(test)]
mod tests {
    use super::super::ceiling::worst_shape;
    use super::*;
    use crate::geometry::features::FeatureOptions;
    use crate::mesh::{Polygons, SurfaceMesh};
    use std::f64::consts::PI;

    /// A rectangle ten times as long as wide, in ten quads whose vertices on the upper side are where those of the lower are,
    /// and `skew` farther in the middle.
    fn strip(skew: f64) -> (Work, Source, Context) {
        let context = Context::new();
        let at = |x: f64, y: f64| DVec3::new(x, y, 0.0);
        let outline = vec![at(0.0, 0.0), at(10.0, 0.0), at(10.0, 1.0), at(0.0, 1.0)];
        let mut faces = Polygons::new();
        [[0, 1, 2], [0, 2, 3]].iter().for_each(|t| faces.push(t));
        let mesh = SurfaceMesh::new(outline, faces).unwrap();
        let source = Source::new(&mesh, &FeatureOptions::default(), &context).unwrap();
        let mut work = Work::default();
        for k in 0..=10u32 {
            let (x, y) = (f64::from(k), skew * (0.1 * PI * f64::from(k)).sin());
            work.points.extend([at(x, 0.0), at(x + y, 1.0)]);
        }
        let ends: Vec<[u32; 2]> =
            (0..10).flat_map(|k| [[2 * k, 2 * k + 2], [2 * k + 1, 2 * k + 3]]).chain([[0, 1], [20, 21]]).collect();
        let curve_of = |[a, b]: [u32; 2]| {
            let [p, q] = [a, b].map(|v| work.points[v as usize]);
            source.curve[source.feature_along(p.midpoint(q), (q - p).normalize(), 0.1, 0.9).unwrap() as usize]
        };
        work.features = ends.iter().map(|&e| (e, curve_of(e))).collect();
        work.place = vec![Place::Fixed; 22];
        work.features[..20].iter().for_each(|(ends, curve)| {
            ends.iter().filter(|&&v| (2..20).contains(&v)).for_each(|&v| work.place[v as usize] = Place::Curve(*curve));
        });
        (0..10).for_each(|k| work.faces.push(&[2 * k, 2 * k + 2, 2 * k + 3, 2 * k + 1]));
        work.region = vec![0; 10];
        (work, source, context)
    }

    #[test]
    fn vertices_slide_along_features_where_quads_are_skewed() {
        let (mut work, source, context) = strip(1.5);
        assert!(worst_shape(&work) < 0.6);
        smooth(&mut work, &source, &context).unwrap();
        assert!(worst_shape(&work) >= GOOD_SHAPE, "{}", worst_shape(&work));
        // On their curves still, in order.
        assert!((0..10).all(|k| (0..2).all(|j| work.points[2 * k + 2 + j].x - work.points[2 * k + j].x > 0.4)));
        assert!(work.points.iter().enumerate().all(|(v, p)| p.y == (v % 2) as f64));
    }

    #[test]
    fn the_rim_of_a_thin_part_stays_covered() {
        let context = Context::new();
        let ball = crate::sample::make("icosphere", Some(40), &context).unwrap();
        let lens = crate::mesh::test_models::moved(&ball, |p| p * DVec3::new(1.0, 1.0, 0.1));
        let options = crate::quad::QuadOptions { quads: 400, ..Default::default() };
        let made = crate::quad::quads(&lens, &options, &context).unwrap();
        // An edge is 4.5 % of the diagonal.
        assert!(made.quality.distance_found.unwrap() < 0.02, "{:?}", made.quality);
    }

    #[test]
    fn vertices_on_features_stay_where_quads_are_good() {
        let (mut work, source, context) = strip(0.3);
        let before = work.points.clone();
        smooth(&mut work, &source, &context).unwrap();
        assert_eq!(work.points, before);
    }
}
