//! Colours as screens have them, and as light adds up.

/// Component of an sRGB colour (0 to 255) as a share of the linear intensity (IEC 61966-2-1).
pub fn linear_of_srgb(component: u8) -> f64 {
    let c = f64::from(component) / 255.0;
    if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
}

/// The inverse of [`linear_of_srgb`], rounded.
pub fn srgb_of_linear(linear: f64) -> u8 {
    let c = if linear <= 0.0031308 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 };
    (255.0 * c).round() as u8
}
