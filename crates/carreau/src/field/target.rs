//! The target rotation ω of equation 3: nothing far from trouble; around a fan that would get no quad, the rotation that
//! gives it one, spread over a length ℓ.
//!
//! ½ Σ w ω² + ½ ℓ² Σ_v (dω)_v² / A_v over the vertices on no feature, where dω is the sum around a vertex; the sum around a
//! pinned fan is what it needs, around every other sector zero. One ω of each such fan follows from the others.

use super::dual::{Dual, Fan, Spoke};
use crate::error::Result;
use crate::mesh::NONE;
use crate::numeric::sparse::LeastSquares;
use rustc_hash::FxHashMap;
use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::f64::consts::FRAC_PI_2;

/// Multiple of ℓ: ω is zero farther from the pinned fans, because it fades over ℓ and next to nothing of it is left
/// there.
const REACH_LENGTHS: f64 = 5.0;

/// How far the rotation spreads.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Spread {
    /// Only over the edges of the fans themselves.
    None,
    /// Over this length.
    Length(f64),
    /// Over the whole surface.
    All,
}

/// ω of every edge. `pins`: fans and the number of quads that they get.
pub fn target(dual: &Dual<'_>, pins: &[(u32, i32)], spread: Spread) -> Result<Vec<f64>> {
    let mut omega = vec![0.0; dual.edges.len()];
    if pins.is_empty() {
        return Ok(omega);
    }
    let quads: FxHashMap<u32, i32> = pins.iter().copied().collect();
    let near = near(dual, pins, spread);
    // The edges that turn, and the fans with a sum to hold that have some.
    let within = |e: u32| {
        let c = dual.edges[e as usize];
        near[dual.triangles.vertex(c) as usize] || near[dual.triangles.vertex(dual.triangles.next(c)) as usize]
    };
    let wanted = |f: u32, fan: &Fan| match quads.get(&f) {
        Some(&k) => Some(fan.angle - f64::from(k) * FRAC_PI_2),
        None => (!fan.closed).then_some(0.0),
    };
    // A fan's dependent edge ends where nothing is held.
    let mut held = vec![false; dual.triangles.points().len()];
    let fans = || (0u32..).zip(&dual.fans);
    fans()
        .filter(|(f, fan)| !fan.closed || quads.contains_key(f))
        .for_each(|(_, fan)| held[fan.vertex as usize] = true);
    let mut dependent: FxHashMap<u32, (u32, f64)> = FxHashMap::default();
    for (f, fan) in fans() {
        let Some(sum) = wanted(f, fan) else { continue };
        let spokes: Vec<Spoke> =
            dual.spokes(fan).filter(|s| within(s.edge) && !dependent.contains_key(&s.edge)).collect();
        let middle = |ends_free: bool| {
            let may = |s: &&Spoke| !ends_free || !held[s.far as usize];
            let all: Vec<&Spoke> = spokes.iter().filter(may).collect();
            all.get(all.len() / 2).map(|&&s| s)
        };
        // A sector whose edges all end at pinned vertices takes one of those.
        let spoke = middle(true).or_else(|| if fan.closed { None } else { middle(false) });
        if let Some(spoke) = spoke {
            dependent.insert(spoke.edge, (f, sum));
        }
    }
    let mut unknown = vec![NONE; dual.edges.len()];
    let mut count = 0;
    for e in (0..dual.edges.len() as u32).filter(|&e| within(e) && !dependent.contains_key(&e)) {
        unknown[e as usize] = count;
        count += 1;
    }
    let forms = Forms { dual, unknown: &unknown, dependent: &dependent };
    let mut system = LeastSquares::new(count as usize);
    let mut add = |weight: f64, form: (Vec<(u32, f64)>, f64)| system.add(weight, &merged(form.0), form.1);
    for e in (0..dual.edges.len() as u32).filter(|&e| within(e)) {
        add(dual.weight[e as usize], forms.edge(e, 0));
    }
    let length = match spread {
        Spread::None => 0.0,
        Spread::Length(length) => length,
        Spread::All => 1e3 * dual.areas.iter().sum::<f64>().sqrt(),
    };
    for (_, fan) in fans().filter(|(f, fan)| fan.closed && !quads.contains_key(f)) {
        if length > 0.0 && dual.spokes(fan).any(|s| within(s.edge)) {
            let area: f64 = dual.corners(fan).iter().map(|&c| dual.areas[c as usize / 3]).sum::<f64>() / 3.0;
            add(length * length / area.max(f64::MIN_POSITIVE), forms.around(fan, 0));
        }
    }
    let y = system.solve(&mut None)?;
    for e in (0..dual.edges.len() as u32).filter(|&e| within(e)) {
        let (terms, constant) = forms.edge(e, 0);
        omega[e as usize] = constant + terms.iter().map(|&(i, a)| a * y[i as usize]).sum::<f64>();
    }
    Ok(omega)
}

/// The ω of edges as affine forms in the unknown ones.
struct Forms<'a> {
    dual: &'a Dual<'a>,
    unknown: &'a [u32],
    /// Fan and sum that a dependent edge follows from.
    dependent: &'a FxHashMap<u32, (u32, f64)>,
}

impl Forms<'_> {
    /// Dependent edges of dependent edges end this soon.
    const DEPTH: usize = 8;

    fn edge(&self, e: u32, depth: usize) -> (Vec<(u32, f64)>, f64) {
        if self.unknown[e as usize] != NONE {
            return (vec![(self.unknown[e as usize], 1.0)], 0.0);
        }
        let Some(&(f, sum)) = self.dependent.get(&e).filter(|_| depth < Self::DEPTH) else { return (Vec::new(), 0.0) };
        let fan = &self.dual.fans[f as usize];
        let own = self.dual.spokes(fan).find(|s| s.edge == e).map_or(1.0, |s| s.sign);
        let (mut terms, mut constant) = (Vec::new(), own * sum);
        for s in self.dual.spokes(fan).filter(|s| s.edge != e) {
            let (others, b) = self.edge(s.edge, depth + 1);
            terms.extend(others.into_iter().map(|(i, a)| (i, -own * s.sign * a)));
            constant -= own * s.sign * b;
        }
        (terms, constant)
    }

    fn around(&self, fan: &Fan, depth: usize) -> (Vec<(u32, f64)>, f64) {
        let (mut terms, mut constant) = (Vec::new(), 0.0);
        for s in self.dual.spokes(fan) {
            let (others, b) = self.edge(s.edge, depth);
            terms.extend(others.into_iter().map(|(i, a)| (i, s.sign * a)));
            constant += s.sign * b;
        }
        (terms, constant)
    }
}

/// Terms with every unknown once.
fn merged(mut terms: Vec<(u32, f64)>) -> Vec<(u32, f64)> {
    terms.sort_by_key(|t| t.0);
    let mut all: Vec<(u32, f64)> = Vec::with_capacity(terms.len());
    for (i, a) in terms {
        match all.last_mut().filter(|last| last.0 == i) {
            Some(last) => last.1 += a,
            None => all.push((i, a)),
        }
    }
    all
}

/// The vertices whose edges may turn: by paths along edges.
fn near(dual: &Dual<'_>, pins: &[(u32, i32)], spread: Spread) -> Vec<bool> {
    let t = dual.triangles;
    let reach = match spread {
        Spread::None => 0.0,
        Spread::Length(length) => REACH_LENGTHS * length,
        Spread::All => return vec![true; t.points().len()],
    };
    let mut star = vec![Vec::new(); t.points().len()];
    for c in 0..3 * t.len() as u32 {
        star[t.vertex(c) as usize].push(t.vertex(t.next(c)));
        star[t.vertex(t.next(c)) as usize].push(t.vertex(c));
    }
    let mut distance = vec![f64::INFINITY; t.points().len()];
    let mut queue = BinaryHeap::new();
    for &(f, _) in pins {
        let v = dual.fans[f as usize].vertex;
        distance[v as usize] = 0.0;
        queue.push(Reverse((0u64, v)));
    }
    // Distances are not negative: their bits are ordered as they are.
    while let Some(Reverse((bits, v))) = queue.pop() {
        let d = f64::from_bits(bits);
        if d > distance[v as usize] {
            continue;
        }
        for &w in &star[v as usize] {
            let far = d + t.points()[v as usize].distance(t.points()[w as usize]);
            if far < distance[w as usize] && far <= reach {
                distance[w as usize] = far;
                queue.push(Reverse((far.to_bits(), w)));
            }
        }
    }
    distance.into_iter().map(|d| d <= reach).collect()
}
