//! Numerical methods that know no mesh.

pub mod banded;
