//! Rung 3, with the number of quads met as nearly as it goes: again with other lengths, and less close to a surface that bends so
//! much that following it takes too many.

use super::halve::{Middle, halve};
use super::judged::Judged;
use super::pair::paired;
use super::smooth::smooth;
use super::source::Source;
use super::work::Work;
use super::{NUMBER_WITHIN, QuadOptions, lifted, off, quality, take_back, validate};
use crate::context::Context;
use crate::error::{Error, Result};

/// A count: runs in search of a number of quads at most, because each takes as long as the first.
const MOST_RUNS: usize = 6;
/// A factor of the length for the next run where one is refused, because shorter edges keep more of the surface.
const SHORTER_FACTOR: f64 = 0.7;
/// A share of the number: no other run is made where the last one came no nearer by it, because the surface needs as
/// many.
const NUMBER_GAIN: f64 = 0.04;
/// A multiple of the quads that a length asks for: so many are smoothed in all runs, because a run makes far more where
/// a surface is rough.
const MOST_SETTLED: f64 = 64.0;
/// A count: so many quads are smoothed where that is fewer, because they take little time.
const LEAST_SETTLED: f64 = 64_000.0;
/// A share of the wanted length: no run has shorter edges, because its quads would be far too many.
const SHORTEST_LENGTH: f64 = 0.45;
/// A multiple of the number: where there are more quads the surface is followed less closely, because its bends are
/// what takes them.
const LOOSENED_RATIO: f64 = 1.2;
/// A factor by which the surface is followed less closely from run to run, because a larger one could give up too much
/// at once.
const LOOSER_FACTOR: f64 = 1.5;
/// A multiple of the closest deviation: the limit of that, because bends would be lost beyond it.
const LOOSEST_FOLLOW: f64 = 2.5;
/// A multiple of the number: more quads are not even made as long as the surface can be followed less closely, because
/// smoothing takes most of the time.
const PASSED_RATIO: f64 = 2.5;
/// A multiple of the number: where so many quads are refused more are not tried, because the next method makes fewer.
const HOPELESS_RATIO: f64 = 10.0;

/// A share of their edges: quads that are farther from the surface are for the next method, because they leave out a
/// part of it.
const PAIRED_STRAYING: f64 = 1.0;

/// The quads; `None` where the validator refuses.
pub fn quads(
    source: &Source,
    options: &QuadOptions,
    warnings: &mut Vec<String>,
    context: &Context,
) -> Result<Option<Judged>> {
    if options.rung > 3 {
        return Ok(None);
    }
    // A triangle of the coarse mesh becomes two quads, about.
    let triangles = options.quads as f64 / 2.0;
    let length = match options.edge_length {
        Some(length) => 2.0 * length,
        None => (source.area / triangles * 4.0 / 3f64.sqrt()).sqrt(),
    };
    // Borders that lie on each other get the same vertices.
    let held = source.held(length, context)?;
    let source = held.as_ref().unwrap_or(source);
    let (passed, refused) = (Vec::new(), String::new());
    let mut search = Search { source, options, length, passed, best: None, refused, context };
    // Features need what they need, and few quads along them are poor ones.
    search.run(options.edge_length.is_none() && source.edges.is_empty())?;
    // Where fewer quads are refused, the many are made.
    let most = search.passed.first().map(|coarse| coarse.faces.corners().len());
    if let (None, Some(most)) = (&search.best, most) {
        search.make_passed()?;
        if search.best.is_none() && most as f64 <= HOPELESS_RATIO * options.quads as f64 {
            search.length *= SHORTER_FACTOR;
            search.run(false)?;
        }
    }
    if search.best.is_none() {
        warnings.push(format!("rung 3 was refused: {}", search.refused));
    }
    let Some((work, gap)) = search.best else { return Ok(None) };
    let quads = options.edge_length.is_none().then_some(options.quads);
    Judged::new(work, source, gap, quads, context).map(Some)
}

/// One length after the other.
struct Search<'a> {
    source: &'a Source,
    options: &'a QuadOptions,
    /// Of the triangles at first.
    length: f64,
    /// Triangles and their pairs that would have been far too many quads, the most first.
    passed: Vec<Work>,
    best: Option<(Work, f64)>,
    /// Why the last one came to nothing.
    refused: String,
    context: &'a Context,
}

impl Search<'_> {
    /// Far too many quads are passed over, if they may be.
    fn run(&mut self, passes_over: bool) -> Result<()> {
        let (source, wanted) = (self.source, self.options.quads);
        let feature_deg = self.options.features.angle_deg.unwrap_or(180.0);
        let (mut length, mut loose) = (self.length, 1.0);
        let most = (MOST_SETTLED * 2.0 * source.area / length.powi(2)).max(LEAST_SETTLED);
        let mut settled = 0.0;
        for _ in 0..MOST_RUNS {
            if settled > most || length < SHORTEST_LENGTH * self.length {
                break;
            }
            let Some(coarse) = attempt(paired(source, length, loose, feature_deg, self.context))? else {
                length *= SHORTER_FACTOR;
                continue;
            };
            // Every corner becomes a quad.
            let count = coarse.faces.corners().len();
            let ratio = count as f64 / wanted as f64;
            if passes_over && ratio > PASSED_RATIO && loose < LOOSEST_FOLLOW {
                self.passed.push(coarse);
                (length, loose) = (length * ratio.sqrt(), looser(loose));
                continue;
            }
            settled += count as f64;
            let Some(made) = self.judged(&coarse)? else {
                // Rung 4 makes fewer, and is not refused.
                if ratio > HOPELESS_RATIO && count > source.surface.mesh.faces().corners().len() {
                    break;
                }
                length *= SHORTER_FACTOR;
                continue;
            };
            let missed = off(count, wanted);
            let gain = self.best.as_ref().map_or(f64::INFINITY, |b| off(b.0.faces.len(), wanted) - missed);
            if gain > 0.0 {
                self.best = Some(made);
            }
            if self.options.edge_length.is_some() || missed < 0.5 * NUMBER_WITHIN || gain < NUMBER_GAIN {
                break;
            }
            length *= ratio.sqrt();
            if ratio > LOOSENED_RATIO {
                loose = looser(loose);
            }
        }
        Ok(())
    }

    /// The fewest of those passed over that are accepted.
    fn make_passed(&mut self) -> Result<()> {
        while self.best.is_none()
            && let Some(coarse) = self.passed.pop()
        {
            self.best = self.judged(&coarse)?;
        }
        Ok(())
    }

    /// Triangles and their pairs halved and smoothed; `None` where the validator refuses.
    fn judged(&mut self, coarse: &Work) -> Result<Option<(Work, f64)>> {
        let (source, context) = (self.source, self.context);
        let mut work = halve(coarse, source, Middle::OnSurface);
        source.hold(&mut work);
        smooth(&mut work, source, context)?;
        take_back(&mut work, &halve(coarse, source, Middle::Straight).points, source);
        let gap = lifted(&mut work, source, context)?;
        let mut why = validate::refusal(&work, &work.to_mesh()?, source)?;
        if why.is_none() && quality::straying(&work, source, context)? > PAIRED_STRAYING {
            why = Some("it leaves part of the surface out".into());
        }
        let holds = why.is_none();
        self.refused = why.unwrap_or_default();
        tracing::debug!(target: "carreau::quad", count = work.faces.len(), refused = self.refused, "rung 3");
        Ok(holds.then_some((work, gap)))
    }
}

fn looser(loose: f64) -> f64 {
    (LOOSER_FACTOR * loose).min(LOOSEST_FOLLOW)
}

/// What a rung cannot do is for the next one; a deadline, a cancellation or a defect is not.
fn attempt<T>(result: Result<Option<T>>) -> Result<Option<T>> {
    match result {
        Err(Error::Numeric(_) | Error::Input { .. }) => Ok(None),
        other => other,
    }
}
