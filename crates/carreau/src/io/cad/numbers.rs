//! Numbers in CAD files.

use crate::brep::Brep;

/// Appends the shortest number with a decimal point that reads back to the same double; `exponent` is the letter.
pub fn push_real(out: &mut Vec<u8>, x: f64, exponent: u8) {
    let mut buffer = ryu::Buffer::new();
    let text = buffer.format(x);
    let (mantissa, power) = text.split_once('e').map_or((text, None), |(m, p)| (m, Some(p)));
    out.extend_from_slice(mantissa.strip_suffix(".0").unwrap_or(mantissa).as_bytes());
    if mantissa.ends_with(".0") || !mantissa.contains('.') {
        out.push(b'.');
    }
    if let Some(power) = power {
        out.push(exponent);
        out.extend_from_slice(power.as_bytes());
    }
}

/// The distance below which points of this model may be taken as one: a power of ten, small against the model and
/// against its shortest edge.
pub fn resolution(brep: &Brep) -> f64 {
    let [low, high] = brep.bounds();
    let length = |[a, b]: [u32; 2]| brep.point(a).distance(brep.point(b));
    let shortest = brep.edges.iter().map(|e| length(e.ends)).filter(|&l| l > 0.0).fold(f64::INFINITY, f64::min);
    let wanted = (1e-7 * (high - low).length()).min(1e-2 * shortest).max(brep.tolerance());
    let least = 1e-12 * low.abs().max(high.abs()).max_element();
    let exponent = wanted.max(least).log10().floor();
    if exponent.is_finite() { format!("1e{}", exponent as i32).parse().unwrap_or(1e-7) } else { 1e-7 }
}
