//! Numerical methods that the rooms share. They know no geometry.
//!
//! | module | method |
//! |---|---|
//! | `banded` | symmetric banded systems |
//! | `dense` | dense symmetric matrices: factors and inverses |
//! | `eigen3` | eigenvalues and eigenvectors of symmetric 3 × 3 matrices |
//! | `flow` | minimum cut of an undirected graph |
//! | `gauss` | Gauss–Legendre quadrature |
//! | `hopcroft_karp` | bipartite graphs: largest matching, smallest vertex cover, largest independent set |
//! | `lbfgs` | limited-memory BFGS over points in space, restricted to an admissible set |
//! | `levenberg` | Levenberg–Marquardt least squares for few parameters |
//! | `matching` | minimum-cost matching of a sparse graph, with a certificate of optimality |
//! | `sparse` | sparse positive definite systems, real and complex |

pub mod banded;
pub(crate) mod dense;
pub mod eigen3;
pub mod flow;
pub mod gauss;
pub(crate) mod hopcroft_karp;
pub mod lbfgs;
pub mod levenberg;
pub mod matching;
pub mod sparse;
