//! Numerical and combinatorial algorithms that know nothing of meshes.
//!
//! | file | holds |
//! |---|---|
//! | `hopcroft_karp` | maximum matching, minimum vertex cover and maximum independent set of bipartite graphs |

pub mod hopcroft_karp;
