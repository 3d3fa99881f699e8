//! One run of a verb.
//!
//! | file | does |
//! |---|---|
//! | `run` | start and end of a run: context, record, summary |
//! | `context` | threads, deadline, cancellation, progress |
//! | `log` | what is said on stderr, and the clock |
//! | `input` | reads meshes and skeletons, from files or from a host |
//! | `carry` | hands properties and tags on to the result |
//! | `output` | writes, draws and shows what the verb made |

mod carry;
mod context;
mod input;
mod log;
mod output;
mod run;

pub use run::Session;
