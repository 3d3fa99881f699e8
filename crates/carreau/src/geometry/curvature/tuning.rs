//! Constants of curvatures.

/// Areas below this, of models scaled by [`scale`], are none: quotients by larger ones, and their squares, stay in range.
pub const NO_AREA: f64 = 1e-100;

/// Mean edge lengths in the radius of a ball.
pub const DEFAULT_RADIUS: f64 = 3.0;
