//! Words that readers and writers share: units and colours.

use crate::mesh::LengthUnit;

/// The names of units.
pub const UNITS: [(&str, LengthUnit); 6] = [
    ("micron", LengthUnit::Micron),
    ("millimeter", LengthUnit::Millimeter),
    ("centimeter", LengthUnit::Centimeter),
    ("inch", LengthUnit::Inch),
    ("foot", LengthUnit::Foot),
    ("meter", LengthUnit::Meter),
];

/// `#RRGGBB` or `#RRGGBBAA`.
pub fn color_of(text: &str) -> Option<[u8; 4]> {
    let digits = text.trim().strip_prefix('#')?;
    let byte = |k: usize| u8::from_str_radix(digits.get(2 * k..2 * k + 2)?, 16).ok();
    match digits.len() {
        6 => Some([byte(0)?, byte(1)?, byte(2)?, u8::MAX]),
        8 => Some([byte(0)?, byte(1)?, byte(2)?, byte(3)?]),
        _ => None,
    }
}

pub fn text_of([r, g, b, a]: [u8; 4]) -> String {
    format!("#{r:02X}{g:02X}{b:02X}{a:02X}")
}
