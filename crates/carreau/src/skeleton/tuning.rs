//! Constants of the room.

/// Steps whose time grows faster than the number of vertices use about this many of them.
pub const MANY: usize = 100_000;

/// Factors on `detail`, tried in turn until the skeleton has as many cycles as the surface has handles.
pub const FINER: [f64; 3] = [1.0, 0.5, 0.25];

/// What is thinner than this share of the diagonal is a sheet, flat or folded onto itself, but for rounding to single precision.
pub const THINNEST: f64 = 1e-6;
/// Volumes below this share of the cube of the diagonal are rounding.
pub const EMPTY: f64 = 1e-14;
