//! Random stars in great number: too long for every change, run by
//! `cargo test --release -p carreau --lib -- --ignored --nocapture stars`; `CARREAU_STARS=100` tries fewer,
//! `CARREAU_STARS=100..300` these.

use super::connection::PartitionSearch;
use super::tests::{flaw, star_net};
use super::*;
use crate::sample::random::Random;
use glam::DVec3;
use rayon::prelude::*;
use std::ops::Range;

const STARS: usize = 5000;
const LEAST_DEGREES: f64 = 15.0;

/// The star of a number: valences 3 to 12 in turn, directions uniform over the sphere but for those too close to another.
fn star_of(seed: usize) -> Vec<DVec3> {
    let mut random = Random::new(seed as u64);
    let valence = 3 + seed % 10;
    let mut directions: Vec<DVec3> = Vec::new();
    while directions.len() < valence {
        let d = DVec3::from_array(std::array::from_fn(|_| random.symmetric()));
        let inside = (0.01..1.0).contains(&d.length_squared());
        if inside && directions.iter().all(|e| e.angle_between(d) > LEAST_DEGREES.to_radians()) {
            directions.push(d.normalize());
        }
    }
    directions
}

/// What became of a star.
struct Outcome {
    seed: usize,
    /// Whether the quads of its connection surface have its directions in them.
    included: bool,
    /// `None` where no mesh was made.
    quality: Option<HexQuality>,
    /// Why the mesh is none.
    flaw: Option<String>,
}

fn outcome(seed: usize) -> Outcome {
    let directions = star_of(seed);
    let included = PartitionSearch::default().partition(&directions).least_determinant(&directions) > 0.0;
    let options = HexOptions { refine_across: Some(1), allow_invalid: true, ..HexOptions::default() };
    let result = from_net(&star_net(&directions, 0.2), &options, &Context::new());
    let flaw = result.as_ref().ok().and_then(|r| flaw(&r.mesh.hexes, &r.mesh.points, &[0]));
    Outcome { seed, included, flaw, quality: result.ok().map(|r| r.figures.quality) }
}

/// Which stars are asked for.
fn asked() -> Range<usize> {
    let Ok(asked) = std::env::var("CARREAU_STARS") else { return 0..STARS };
    let (from, to) = asked.split_once("..").unwrap_or(("0", &asked));
    from.parse().unwrap()..to.parse().unwrap()
}

/// Every star is meshed, conforms and is included; 99 % are certified; no scaled Jacobian of those is below .2.
#[test]
#[ignore = "takes hours"]
#[allow(clippy::print_stdout)]
fn random_stars_by_the_thousand() {
    let outcomes: Vec<Outcome> = asked().into_par_iter().map(outcome).collect();
    let stars = outcomes.len();
    let failed: Vec<usize> = outcomes.iter().filter(|o| o.quality.is_none()).map(|o| o.seed).collect();
    let left_out: Vec<usize> = outcomes.iter().filter(|o| !o.included).map(|o| o.seed).collect();
    let made = || outcomes.iter().filter_map(|o| Some((o.seed, o.quality.as_ref()?)));
    let certified = made().filter(|(_, q)| q.certified).count();
    let mut worst: Vec<(f64, usize)> =
        made().filter(|(_, q)| q.certified).map(|(seed, q)| (q.scaled_jacobian_min, seed)).collect();
    worst.sort_by(|a, b| a.0.total_cmp(&b.0));
    let share = |of: f64| worst[((worst.len() - 1) as f64 * of) as usize].0;
    println!(
        "{certified} of {stars} certified; least scaled Jacobian {:.3}, 1 % {:.3}, median {:.3}",
        share(0.0),
        share(0.01),
        share(0.5)
    );
    println!("worst {:?}", &worst[..worst.len().min(20)]);
    println!("uncertified {:?}", made().filter(|(_, q)| !q.certified).map(|(s, _)| s).collect::<Vec<_>>());
    let flaws: Vec<_> = outcomes.iter().filter_map(|o| Some((o.seed, o.flaw.as_ref()?))).collect();
    assert!(flaws.is_empty(), "not conforming: {flaws:?}");
    assert!(failed.is_empty(), "not meshed: {failed:?}");
    assert!(left_out.is_empty(), "not included: {left_out:?}");
    assert!(certified as f64 >= 0.99 * stars as f64, "{certified} certified");
    assert!(worst[0].0 >= 0.2, "{worst:?}");
}
