//! Fuzzing: files that are broken in all ways, and meshes that nobody would make, through every reader and every room.
//!
//! A reader or a room gives a result that holds, or an error that says why; it neither panics nor reports a bug of its own.
//! The tests of every day try a few inputs. A long run is asked for by the environment, and a finding is done again alone:
//!
//! ```sh
//! CARREAU_FUZZ_READERS=1000000 cargo test --release -p carreau --test fuzz -- readers --nocapture
//! CARREAU_FUZZ_ROOMS=100000 CARREAU_FUZZ_SEED=7 cargo test --release -p carreau --test fuzz -- rooms --nocapture
//! CARREAU_FUZZ_ONLY=4711 CARREAU_FUZZ_SEED=7 cargo test --release -p carreau --test fuzz -- rooms --nocapture
//! ```
//!
//! `CARREAU_FUZZ_SECONDS` ends a run earlier; the number of inputs is told. With `CARREAU_SHARED` the broken files of the corpus
//! are starting points too. `CARREAU_FUZZ_KEEP` names a folder for the files of the findings.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::print_stderr)] // a test fails by panicking

mod bytes;
mod models;
mod random;
mod readers;
mod rooms;
mod run;

use run::Run;

#[test]
fn readers() {
    let run = Run::new("readers", "CARREAU_FUZZ_READERS", 4000);
    let files = readers::Files::new();
    run.all(|k, rng| files.one(k, rng, run.keep()));
}

#[test]
fn rooms() {
    let run = Run::new("rooms", "CARREAU_FUZZ_ROOMS", 200);
    let rooms = rooms::Rooms::new();
    run.all(|k, rng| rooms.one(k, rng, run.keep()));
}
