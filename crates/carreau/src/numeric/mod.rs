//! Numerical methods that the rooms share; they know no mesh.
//!
//! | module | method |
//! |---|---|
//! | `banded` | symmetric banded systems |
//! | `hopcroft_karp` | largest matching of a bipartite graph, smallest cover, largest independent set |
//! | `matching` | minimum-cost matching of a sparse graph, with a certificate |

pub mod banded;
pub(crate) mod hopcroft_karp;
pub mod matching;
