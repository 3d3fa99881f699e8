//! Colours for labels and numbers, told apart by people with and without colour blindness.

use super::color::{Linear, Rgb, encode, from_lch, from_oklab, linear, to_oklab};
use crate::mesh::{HalfEdges, Polygons};

/// Faces without any other colour.
pub(super) const PLAIN: Rgb = [178, 196, 216];
/// Faces whose label or number is missing.
pub(super) const MISSING: Rgb = [190, 190, 190];

/// Number of colours that labels are given.
const COLORS: u32 = 24;
/// Two colours at least this far apart (in OKLab, where black and white are 1 apart) are taken as clearly different.
const CLEAR: f32 = 0.17;

/// The colour of the `k`-th label where nothing is known about who its neighbours are. Consecutive ones differ much:
/// hues are the golden angle apart, and lightness alternates. Yellow, which turns brown in the shade, is the lightest,
/// as in the rainbow.
pub fn label_color(k: u32) -> Rgb {
    let k = k % COLORS;
    let hue = 250.0 + 137.508 * k as f32;
    let lightness = 0.82 + 0.06 * (hue - 100.0).to_radians().cos() + if k.is_multiple_of(2) { -0.04 } else { 0.04 };
    encode(from_lch(lightness, 0.11, hue))
}

/// A colour for every label, one per face, such that regions that meet at an edge get clearly different ones; grey for
/// negative labels.
///
/// Labels take the first colour, from their own on, that is clear of those their neighbours have taken; if there is
/// none, the farthest.
pub fn label_colors(faces: &Polygons, labels: &[i32]) -> Vec<Rgb> {
    let mut distinct: Vec<i32> = labels.iter().copied().filter(|&l| l >= 0).collect();
    distinct.sort_unstable();
    distinct.dedup();
    let ranks: Vec<Option<u32>> = labels.iter().map(|l| distinct.binary_search(l).ok().map(|r| r as u32)).collect();
    let palette: Vec<Rgb> = (0..COLORS).map(label_color).collect();
    let distance = distances(&palette);
    let mut chosen: Vec<usize> = Vec::with_capacity(distinct.len());
    let mut pairs = neighbours(faces, &ranks).into_iter().peekable();
    for rank in 0..distinct.len() {
        let mut taken = Vec::new();
        while let Some((_, earlier)) = pairs.next_if(|p| p.0 as usize == rank) {
            taken.push(chosen[earlier as usize]);
        }
        let clearance = |c: usize| taken.iter().map(|&t| distance[c][t]).fold(f32::INFINITY, f32::min);
        let own_first = || (0..palette.len()).map(|k| (rank + k) % palette.len());
        let clear = own_first().find(|&c| clearance(c) >= CLEAR);
        let farthest = || own_first().max_by(|&a, &b| clearance(a).total_cmp(&clearance(b)));
        chosen.push(clear.or_else(farthest).unwrap_or(0));
    }
    ranks.iter().map(|rank| rank.map_or(MISSING, |r| palette[chosen[r as usize]])).collect()
}

/// Pairs (label, smaller label) of regions that meet at an edge, sorted.
fn neighbours(faces: &Polygons, ranks: &[Option<u32>]) -> Vec<(u32, u32)> {
    let rank_of: Vec<Option<u32>> = faces
        .iter()
        .enumerate()
        .flat_map(|(f, face)| std::iter::repeat_n(ranks.get(f).copied().flatten(), face.len()))
        .collect();
    let vertices = faces.corners().iter().max().map_or(0, |&v| v as usize + 1);
    let mut pairs = Vec::new();
    for edge in HalfEdges::new(faces, vertices).groups() {
        let around: Vec<u32> = edge.corners().filter_map(|c| rank_of[c as usize]).collect();
        for pair in around.windows(2).filter(|p| p[0] != p[1]) {
            pairs.push((pair[0].max(pair[1]), pair[0].min(pair[1])));
        }
    }
    pairs.sort_unstable();
    pairs.dedup();
    pairs
}

/// How different every two colours look to the one who sees least of it.
fn distances(palette: &[Rgb]) -> Vec<Vec<f32>> {
    let lab = |f: fn(Linear) -> Linear| palette.iter().map(|&c| to_oklab(f(linear(c)))).collect::<Vec<_>>();
    let views = [lab(|c| c), lab(deuteranope)];
    let apart = |v: &[[f32; 3]], a: usize, b: usize| (0..3).map(|k| (v[a][k] - v[b][k]).powi(2)).sum::<f32>().sqrt();
    let every = 0..palette.len();
    // Few colours are far apart without red and green: ask for less there.
    let least = |a: usize, b: usize| apart(&views[0], a, b).min(2.0 * apart(&views[1], a, b));
    every.clone().map(|a| every.clone().map(|b| least(a, b)).collect()).collect()
}

/// A colour as seen without the green-sensitive cones (Machado, Oliveira, Fernandes 2009).
fn deuteranope([r, g, b]: Linear) -> Linear {
    [
        0.367_322 * r + 0.860_646 * g - 0.227_968 * b,
        0.280_085 * r + 0.672_501 * g + 0.047_413 * b,
        -0.011_820 * r + 0.042_940 * g + 0.968_881 * b,
    ]
    .map(|c| c.clamp(0.0, 1.0))
}

/// How numbers become colours.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Scale {
    /// From dark blue over green to yellow. The range is that of the numbers unless it is given.
    Sequential(Option<[f64; 2]>),
    /// From blue over near-white at zero to red-brown: for signed numbers. The bound is the largest magnitude of the
    /// numbers unless it is given.
    Diverging(Option<f64>),
}

/// Viridis (van der Walt, Smith 2015) at equal steps.
const SEQUENTIAL: [Rgb; 9] = [
    [68, 1, 84],
    [71, 44, 122],
    [59, 81, 139],
    [44, 113, 142],
    [33, 144, 141],
    [39, 173, 129],
    [92, 200, 99],
    [170, 220, 50],
    [253, 231, 37],
];
/// Colours of diverging scales, blue to white to red.
const DIVERGING: [Rgb; 7] =
    [[22, 63, 128], [55, 120, 190], [146, 190, 224], [242, 241, 238], [240, 178, 124], [205, 101, 52], [125, 45, 20]];

impl Scale {
    /// The places of numbers on the ramp, 0 to 1; NaN stays NaN.
    pub(super) fn places(&self, values: &[f64]) -> Vec<f32> {
        let finite = || values.iter().copied().filter(|v| v.is_finite());
        let [low, high] = match *self {
            Scale::Sequential(Some(range)) => range,
            Scale::Sequential(None) => {
                [finite().fold(f64::INFINITY, f64::min), finite().fold(f64::NEG_INFINITY, f64::max)]
            }
            Scale::Diverging(bound) => {
                let bound = bound.unwrap_or_else(|| finite().map(f64::abs).fold(0.0, f64::max));
                [-bound, bound]
            }
        };
        // Halved, so that a range from −1e308 to 1e308 does not overflow.
        let half = high / 2.0 - low / 2.0;
        let place = |v: f64| if half > 0.0 { (v / 2.0 - low / 2.0) / half } else { 0.5 + 0.0 * v };
        values.iter().map(|&v| place(v).clamp(0.0, 1.0) as f32).collect()
    }
}

/// The colours of a scale at equal steps from low to high.
pub fn ramp_colors(scale: Scale, steps: usize) -> Vec<Rgb> {
    let ramp = Ramp::new(scale);
    (0..steps).map(|k| encode(ramp.at(k as f32 / steps.saturating_sub(1).max(1) as f32))).collect()
}

/// A ramp of colours, tabulated.
pub(super) struct Ramp(Vec<Linear>);

impl Ramp {
    const STEPS: usize = 512;

    pub(super) fn new(scale: Scale) -> Self {
        let stops: Vec<[f32; 3]> = match scale {
            Scale::Sequential(_) => SEQUENTIAL.iter().map(|&c| to_oklab(linear(c))).collect(),
            Scale::Diverging(_) => DIVERGING.iter().map(|&c| to_oklab(linear(c))).collect(),
        };
        let at = |k: usize| {
            let place = k as f32 / Self::STEPS as f32 * (stops.len() - 1) as f32;
            let low = (place as usize).min(stops.len() - 2);
            from_oklab([0, 1, 2].map(|i| stops[low][i] + (stops[low + 1][i] - stops[low][i]) * (place - low as f32)))
        };
        Ramp((0..=Self::STEPS).map(at).collect())
    }

    /// The colour at a place in 0..=1; grey for NaN.
    pub(super) fn at(&self, place: f32) -> Linear {
        if place.is_nan() {
            linear(MISSING)
        } else {
            self.0[((place * Self::STEPS as f32).round() as usize).min(Self::STEPS)]
        }
    }
}
