//! Numerical methods that know nothing of meshes.

pub mod matching;
