//! Clean-up and resampling of the skeleton.
//!
//! Leaf branches shorter than the radius of their branching go, and every branch gets nodes at steps in proportion to its radius, by inverting ∫ ds / h(s).
//!
//! **First-ring rule** (not in the paper, and decisive): on a branch that leaves a branching with the angle θ to its
//! nearest neighbour, the first node lies at d ≥ max(1.5 r, 1.2 r / tan(θ/2) + 0.3 r), where the discs of the two
//! branches are apart.

use super::MOST_HEXES;
use crate::mesh::{Branch, CurveNet, Incidence, branches};
use glam::DVec3;
use rustc_hash::FxHashSet;

/// How long the steps are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Step {
    /// This many radii.
    Radii(f64),
    /// The same length everywhere.
    Length(f64),
    /// This many radii where the radius is the given one; less than in proportion to it elsewhere, so that thin branches
    /// do not take most of the nodes.
    Eased(f64, f64),
}

/// Nodes are at most this share of their radius away from the new segments.
const FARTHEST_NODE: f64 = 0.4;
/// A branch gets no more segments than this while lengths are tried that nobody has asked for.
const MOST_TRIED: f64 = 1e5;
/// A station closer than this, in radii, to a node that must become one moves there.
const CLOSE: f64 = 0.7;

/// Exponent of the radius in eased steps: below one, so that steps vary less than radii.
const EASE: f64 = 0.6;
/// Shortest and longest eased step, in radii.
const BOUNDS: [f64; 2] = [0.5, 2.5];

/// Leaf branches inside the ball of their branching go, but for those with a node of a given id; returns how many.
pub fn prune(net: &mut CurveNet, stay: &FxHashSet<i64>) -> usize {
    let mut pruned = 0;
    loop {
        let around = net.incidence();
        let mut left: Vec<usize> = (0..net.points.len() as u32).map(|v| around.valence(v)).collect();
        let mut keep = vec![true; net.points.len()];
        let before = pruned;
        for stub in branches(net, &around).into_iter().filter(|b| is_stub(net, &around, b)) {
            let from = stub.nodes[0] as usize;
            // What is left of a branching is none: whether its branches are stubs is another question.
            if left[from] > 2 && !stub.nodes[1..].iter().any(|&v| stay.contains(&net.ids[v as usize])) {
                left[from] -= 1;
                stub.nodes[1..].iter().for_each(|&v| keep[v as usize] = false);
                pruned += 1;
            }
        }
        if pruned == before {
            return pruned;
        }
        net.retain_nodes(&keep);
    }
}

/// Whether a branch from a branching to an extremity stays within the branching's ball.
fn is_stub(net: &CurveNet, around: &Incidence, branch: &Branch) -> bool {
    let from = branch.nodes[0] as usize;
    let is_inside = |&v: &u32| net.points[v as usize].distance(net.points[from]) < net.radii[from];
    branch.is_leaf(around) && branch.nodes.iter().all(is_inside)
}

/// The net with new articulations; branchings and extremities stay, and no node is farther from the new segments than
/// [`FARTHEST_NODE`] of its radius.
pub fn resample(net: &CurveNet, step: Step) -> CurveNet {
    let around = net.incidence();
    let all = branches(net, &around);
    let mut out = CurveNet::default();
    let mut new_id = vec![u32::MAX; net.points.len()];
    let kept = |v: &u32| around.valence(*v) != 2;
    for v in (0..net.points.len() as u32).filter(kept) {
        new_id[v as usize] = out.points.len() as u32;
        push(&mut out, net.points[v as usize], net.radii[v as usize], net.ids[v as usize]);
    }
    let mut pairs: FxHashSet<[u32; 2]> = FxHashSet::default();
    for branch in &all {
        let mut curve = Curve::new(net, &branch.nodes);
        let (from, to) = (branch.nodes[0], branch.nodes[branch.nodes.len() - 1]);
        // Two branches between the same nodes, and a branch back to its own, need nodes in between.
        let least = if branch.is_ring || from == to { 3 } else { 1 + usize::from(!pairs.insert(branch.ends())) };
        let ends = [
            first_ring(net, &around, branch.nodes[0], branch.edges[0], branch.nodes[1]),
            first_ring(net, &around, to, branch.edges[branch.edges.len() - 1], branch.nodes[branch.nodes.len() - 2]),
        ];
        let stations = curve.stations(step, ends, least);
        let stations = curve.follow(stations, ends, FARTHEST_NODE);
        let mut last = if branch.is_ring {
            push(&mut out, curve.points[0], curve.radii[0], net.ids[from as usize])
        } else {
            new_id[from as usize]
        };
        let first = last;
        for s in stations {
            let (point, radius) = curve.at(s);
            let node = push(&mut out, point, radius, -1);
            out.edges.push([last, node]);
            last = node;
        }
        out.edges.push([last, if branch.is_ring { first } else { new_id[to as usize] }]);
    }
    out
}

fn push(net: &mut CurveNet, point: DVec3, radius: f64, id: i64) -> u32 {
    net.points.push(point);
    net.radii.push(radius);
    net.ids.push(id);
    net.points.len() as u32 - 1
}

/// The least distance of the first node on a branch from its end, by the first-ring rule; zero where the end is no
/// branching.
fn first_ring(net: &CurveNet, around: &Incidence, node: u32, edge: u32, next: u32) -> f64 {
    if around.valence(node) < 3 {
        return 0.0;
    }
    let direction = |w: u32| (net.points[w as usize] - net.points[node as usize]).normalize_or_zero();
    let own = direction(next);
    let others = around.of(node).iter().filter(|s| s[0] != edge);
    let theta = others.map(|s| own.angle_between(direction(s[1]))).fold(std::f64::consts::PI, f64::min);
    let r = net.radii[node as usize].min(2.0 * net.radii[next as usize]);
    (1.5 * r).max(1.2 * r / (0.5 * theta).tan().max(0.13) + 0.3 * r)
}

/// A branch as a curve over its arc length.
pub struct Curve {
    points: Vec<DVec3>,
    radii: Vec<f64>,
    /// Arc length at every node.
    arc: Vec<f64>,
    /// Where `at` looked last: stations are asked for in ascending order.
    hint: usize,
}

impl Curve {
    pub fn new(net: &CurveNet, nodes: &[u32]) -> Curve {
        let points: Vec<DVec3> = nodes.iter().map(|&v| net.points[v as usize]).collect();
        let radii = nodes.iter().map(|&v| net.radii[v as usize]).collect();
        let mut arc = vec![0.0];
        points.windows(2).for_each(|w| arc.push(arc[arc.len() - 1] + w[0].distance(w[1])));
        Curve { points, radii, arc, hint: 0 }
    }

    pub fn length(&self) -> f64 {
        self.arc[self.arc.len() - 1]
    }

    /// Position and radius at an arc length.
    pub fn at(&mut self, s: f64) -> (DVec3, f64) {
        if s < self.arc[self.hint] {
            self.hint = 0;
        }
        while self.hint + 2 < self.arc.len() && s > self.arc[self.hint + 1] {
            self.hint += 1;
        }
        let k = self.hint;
        let t = ((s - self.arc[k]) / (self.arc[k + 1] - self.arc[k]).max(1e-300)).clamp(0.0, 1.0);
        (self.points[k].lerp(self.points[k + 1], t), self.radii[k] + t * (self.radii[k + 1] - self.radii[k]))
    }

    /// Arc lengths of the new nodes between the ends, at least `least − 1` of them. `ends` are the least distances of
    /// the first and last from the ends.
    fn stations(&mut self, step: Step, ends: [f64; 2], least: usize) -> Vec<f64> {
        let length = self.length();
        let marked = ends.iter().filter(|d| **d > 0.0).count();
        let room = [0.0, 0.6, 0.4][marked] * length;
        let [from, to] = [ends[0].min(room), length - ends[1].min(room)];
        // ∫ ds / h in many small steps.
        let parts = (8 * self.points.len()).clamp(64, 4096);
        let mut integral = vec![0.0];
        for k in 0..parts {
            let s = from + (to - from) * (k as f64 + 0.5) / parts as f64;
            let h = match step {
                Step::Radii(k) => k * self.at(s).1,
                Step::Length(h) => h,
                Step::Eased(k, usual) => {
                    let r = self.at(s).1;
                    k * (usual * (r / usual).powf(EASE)).clamp(BOUNDS[0] * r, BOUNDS[1] * r)
                }
            };
            integral.push(integral[k] + (to - from) / parts as f64 / h.max(1e-9 * length));
        }
        let total = integral[parts];
        // A length that is asked for has been checked; others are tried, and none of use is shorter than these.
        let most = if matches!(step, Step::Length(_)) { MOST_HEXES / 4.0 } else { MOST_TRIED };
        let count = (total.round().min(most) as usize).max(1).max(least.saturating_sub(marked));
        let mut stations = Vec::new();
        if ends[0] > 0.0 {
            stations.push(from);
        }
        let mut k = 0;
        for n in 1..count {
            let wanted = total * n as f64 / count as f64;
            while k + 1 < parts && integral[k + 1] < wanted {
                k += 1;
            }
            let t = (wanted - integral[k]) / (integral[k + 1] - integral[k]).max(1e-300);
            stations.push(from + (to - from) * (k as f64 + t.clamp(0.0, 1.0)) / parts as f64);
        }
        if ends[1] > 0.0 {
            stations.push(to);
        }
        stations
    }

    /// Stations such that no node of the curve is farther from the chords than a share of its radius: where one is, the
    /// nearest station goes there if it is no first ring and close, else the node becomes one.
    ///
    /// ```text
    ///          n                      n
    ///        ╱   ╲            →     ╱   ╲
    ///   s₀──────────s₁            s₀     s₁
    /// ```
    fn follow(&mut self, mut stations: Vec<f64>, ends: [f64; 2], share: f64) -> Vec<f64> {
        for _ in 0..self.points.len() {
            let Some(node) = self.farthest_off(&stations, share) else { break };
            let s = self.arc[node];
            let k = stations.partition_point(|&t| t < s);
            let fixed = |j: usize| j == 0 && ends[0] > 0.0 || j + 1 == stations.len() && ends[1] > 0.0;
            let close =
                |&j: &usize| j < stations.len() && !fixed(j) && (stations[j] - s).abs() < CLOSE * self.radii[node];
            let near = [k.wrapping_sub(1), k].into_iter().filter(close);
            match near.min_by(|&a, &b| (stations[a] - s).abs().total_cmp(&(stations[b] - s).abs())) {
                Some(j) => stations[j] = s,
                None => stations.insert(k, s),
            }
        }
        stations
    }

    /// The node that is farthest from the chords, in radii, where that is more than a share.
    fn farthest_off(&mut self, stations: &[f64], share: f64) -> Option<usize> {
        let mut worst = (share, None);
        let (mut node, mut from) = (1, self.at(0.0));
        for s in stations.iter().copied().chain([self.length()]) {
            let to = self.at(s);
            while node + 1 < self.points.len() && self.arc[node] < s {
                let radius = self.radii[node].max(1e-300);
                let off = distance_to_segment(self.points[node], from.0, to.0) / radius;
                if off > worst.0 {
                    worst = (off, Some(node));
                }
                node += 1;
            }
            if node + 1 < self.points.len() && self.arc[node] == s {
                node += 1;
            }
            from = to;
        }
        worst.1
    }
}

fn distance_to_segment(p: DVec3, a: DVec3, b: DVec3) -> f64 {
    let along = b - a;
    let t = ((p - a).dot(along) / along.length_squared().max(1e-300)).clamp(0.0, 1.0);
    p.distance(a + along * t)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fork() -> CurveNet {
        let points = vec![DVec3::ZERO, DVec3::X * 9.0, DVec3::new(-5.0, 5.0, 0.0), DVec3::new(-5.0, -5.0, 0.0)];
        CurveNet::new(points, vec![0.5, 0.25, 0.5, 0.5], vec![[0, 1], [0, 2], [0, 3]])
    }

    #[test]
    fn steps_follow_the_radius_and_the_first_ring_keeps_its_distance() {
        let net = fork();
        let fine = resample(&net, Step::Radii(1.0));
        assert_eq!(fine.cycles(), [0]);
        let around = fine.incidence();
        assert_eq!((0..fine.points.len() as u32).filter(|&v| around.valence(v) == 3).count(), 1);
        for (e, &[a, b]) in fine.edges.iter().enumerate() {
            let r = 0.5 * (fine.radii[a as usize] + fine.radii[b as usize]);
            let k = fine.length(e) / r;
            let at_fork = around.valence(a).max(around.valence(b)) == 3;
            assert!(if at_fork { k >= 1.5 } else { (0.7..1.4).contains(&k) }, "{k}");
        }
        assert!(resample(&net, Step::Length(0.1)).edges.len() > 150);
    }

    #[test]
    fn rings_and_handles_keep_their_cycles() {
        let points: Vec<DVec3> = (0..6).map(|k| DVec3::from((glam::DVec2::from_angle(f64::from(k)), 0.0))).collect();
        let mut edges: Vec<[u32; 2]> = (0..6).map(|k| [k, (k + 1) % 6]).collect();
        let ring = CurveNet::new(points.clone(), vec![0.1; 6], edges.clone());
        edges.push([0, 3]);
        let theta = CurveNet::new(points, vec![0.1; 6], edges);
        for (net, cycles) in [(ring, 1), (theta, 2)] {
            for k in [0.5, 2.0, 100.0] {
                let out = resample(&net, Step::Radii(k));
                assert_eq!(out.cycles(), [cycles]);
                assert_eq!(out.clone().drop_multiple_edges(), 0);
            }
        }
    }

    #[test]
    fn stubs_go_and_close_branchings_merge() {
        let mut net = fork();
        net.points.push(DVec3::new(0.0, 0.0, 0.3));
        net.radii.push(0.1);
        net.ids.push(4);
        net.edges.push([0, 4]);
        let stay = FxHashSet::from_iter([4]);
        assert_eq!(prune(&mut net, &stay), 0);
        assert_eq!(prune(&mut net, &FxHashSet::default()), 1);
        assert_eq!(net, fork());
    }
}
