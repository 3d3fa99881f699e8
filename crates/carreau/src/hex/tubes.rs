//! The driver of skeletons: clean-up, cells, and other attempts where nodes are lost or cells are poor.

use super::assemble::BaseMesh;
use super::cells::{least_scaled_jacobian, refined, valid_base};
use super::choices::Stage;
use super::options::{HexOptions, check_size, check_steps};
use super::refine::TubeMesh;
use super::result::HexResult;
use super::size::resized;
use super::{coverage, deliver, fork_trunks, resample, ring_room, u_turns};
use crate::context::Context;
use crate::error::{Error, Result};
use crate::geometry::hexes::uncertified;
use crate::mesh::{CurveNet, RepairedNet, UnitScale};
use rustc_hash::FxHashSet;

/// Branchings closer than this share of the smaller radius become one.
const MERGE: f64 = 0.3;
/// Angles in degrees: directions closer than the first get a trunk, up to where they are as far apart as the second.
const FORKS: [f64; 2] = [fork_trunks::CLOSE_DEGREES, fork_trunks::APART_DEGREES];
/// The same angles where the least scaled Jacobian is below [`POOR_NET`] and cells are not more than [`FEW_HEXES`]:
/// trunks from more branches have forks with wider angles, but depart farther from what was drawn.
const OTHER_FORKS: [[f64; 2]; 2] = [[42.0, 55.0], [36.0, 48.0]];
/// Least scaled Jacobian of a net below which other forks are tried.
const POOR_NET: f64 = 0.3;
/// Number of cells up to which other forks are tried: each of them is meshed from the beginning.
const FEW_HEXES: usize = 50_000;
/// Vertices at nodes this near to one that lies outside are held, in its radii.
const HELD_REACH: f64 = 2.0;

/// The mesh, not yet judged.
pub(super) fn meshed(net: &CurveNet, options: &HexOptions, context: &Context) -> Result<HexResult> {
    let scale = UnitScale::of_net(net);
    if let Some(net) = scale.net(net) {
        return Ok(meshed(&net, &options.in_scale(scale), context)?.in_scale(scale.back()));
    }
    let mut best = Meshed::new(net, FORKS, options, context)?;
    let incidence = net.incidence();
    let has_forks = (0..net.points.len() as u32).any(|v| incidence.valence(v) > 2);
    for forks in OTHER_FORKS {
        let may_gain = has_forks && best.least < POOR_NET && best.tube.hexes.len() <= FEW_HEXES;
        if !may_gain || options.stage == Stage::Base {
            break;
        }
        let other = match Meshed::new(net, forks, options, context) {
            Err(Error::Numeric(_)) => continue,
            other => other?,
        };
        if (other.lacking, -other.least) < (best.lacking, -best.least) {
            best = other;
        }
    }
    let Meshed { lacking: [_, outside], tube, base, net, mut warnings, .. } = best;
    warn_of_poor(&base, &mut warnings);
    if outside > 0 {
        warnings.push(format!("{outside} nodes of the skeleton lie outside of the cells"));
    }
    let mut result = deliver::with_boundary(tube, net, warnings, options, context)?;
    deliver::certify(&mut result, options)?;
    deliver::finish(&mut result, options, None, context)?;
    Ok(result)
}

/// The mesh of a skeleton that was made ready in one of several ways.
struct Meshed {
    /// Cells without a certificate, and nodes outside of the cells.
    lacking: [usize; 2],
    /// The least scaled Jacobian.
    least: f64,
    tube: TubeMesh,
    base: BaseMesh,
    /// The skeleton made ready.
    net: CurveNet,
    warnings: Vec<String>,
}

impl Meshed {
    fn new(net: &CurveNet, forks: [f64; 2], options: &HexOptions, context: &Context) -> Result<Meshed> {
        let (given, net, warnings) = clean_up(net, forks, options, context)?;
        let mut best: Option<([usize; 2], TubeMesh, BaseMesh)> = None;
        let mut held = Vec::new();
        for _ in 0..2 {
            let base = valid_base(&net, options.stage == Stage::Full, &held, context)?;
            let tube = refined(&net, &base, &held, options, context)?;
            let outside = coverage::outside_cells(&given, &tube);
            let lacking = [uncertified(&tube.points, &tube.hexes).len(), outside.len()];
            if best.as_ref().is_none_or(|b| lacking < b.0) {
                best = Some((lacking, tube, base));
            }
            if outside.is_empty() {
                break;
            }
            held = outside.iter().map(|&v| (given.points[v as usize], HELD_REACH * given.radii[v as usize])).collect();
        }
        let Some((lacking, tube, base)) = best else { return Err(Error::Numeric("no mesh was made".into())) };
        let least = least_scaled_jacobian(&tube.points, &tube.hexes);
        Ok(Meshed { lacking, least, tube, base, net, warnings })
    }
}

/// Repair, and the skeleton made ready for cells. Clean-up is taken back where it drops what the user has drawn: stubs
/// whose nodes would lie outside of the tubes stay, then branchings are not merged either.
///
/// Returns the repaired net, the one to be meshed, and what the user should know.
fn clean_up(
    net: &CurveNet,
    forks: [f64; 2],
    options: &HexOptions,
    context: &Context,
) -> Result<(CurveNet, CurveNet, Vec<String>)> {
    let _stage = context.stage("skeleton");
    let RepairedNet { mut net, mut warnings } = net.repaired(options.radius)?;
    if options.stage == Stage::Full {
        let dropped = u_turns::drop_turns(&mut net);
        if dropped > 0 {
            warnings.push(format!("{dropped} nodes were dropped, because a branch turns back there within its radius"));
        }
    }
    check_steps(&net, options)?;
    let mut stay = FxHashSet::default();
    let mut best: Option<(usize, CurveNet, Vec<String>)> = None;
    for merge in [MERGE, MERGE, 0.0] {
        context.check()?;
        let (ready, notes) = shaped(&net, forks, options, &stay, merge);
        let outside = coverage::outside(&net, &ready);
        if best.as_ref().is_none_or(|b| outside.len() < b.0) {
            best = Some((outside.len(), ready, notes));
        }
        if outside.is_empty() || options.stage == Stage::Base {
            break;
        }
        stay.extend(outside.iter().map(|&v| net.ids[v as usize]));
    }
    let ready = best.filter(|(_, ready, _)| !ready.edges.is_empty());
    let Some((_, ready, notes)) = ready else {
        return Err(Error::input("the skeleton has no segment", "", "give one"));
    };
    warnings.extend(notes);
    check_size(&ready, options)?;
    Ok((net, ready, warnings))
}

/// Zipping, and for the full stage clean-up and resampling; notes say what was done.
fn shaped(
    net: &CurveNet,
    forks: [f64; 2],
    options: &HexOptions,
    stay: &FxHashSet<i64>,
    merge: f64,
) -> (CurveNet, Vec<String>) {
    let mut net = net.clone();
    let mut notes = Vec::new();
    if options.stage == Stage::Full {
        let pruned = resample::prune(&mut net, stay);
        if pruned > 0 {
            notes.push(format!("{pruned} branches end inside the ball of their branching and were dropped"));
        }
        let merged = net.merge_branchings(|[a, b]| merge * a.min(b));
        if merged > 0 {
            notes.push(format!("{merged} branchings lie inside others and were merged with them"));
        }
    }
    let [narrow, apart] =
        if options.stage == Stage::Full { forks } else { [fork_trunks::NARROW_DEGREES, fork_trunks::APART_DEGREES] };
    let zipped = fork_trunks::zip(&mut net, narrow, apart);
    if zipped > 0 {
        notes.push(format!("{zipped} pairs of directions are closer than {narrow}° and got a common trunk"));
    }
    if options.stage == Stage::Full {
        net = resized(&net, options);
    }
    let reduced = ring_room::limit_radii(&mut net);
    if reduced > 0 {
        notes.push(format!("{reduced} radii leave no room for cells beside a short segment and were reduced"));
    }
    (net, notes)
}

pub(super) fn warn_of_poor(base: &BaseMesh, warnings: &mut Vec<String>) {
    if let Some(first) = base.poor.first() {
        let count = base.poor.len();
        warnings.push(format!("{count} branchings have no partition that includes all directions, first {first}"));
    }
}
