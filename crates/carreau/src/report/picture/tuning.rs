//! Constants of pictures.

/// Samples along the side of a pixel.
pub const SAMPLES: usize = 3;
/// Rows of pixels in a band.
pub const BAND: usize = 24;
