//! How a run is done: threads, seed, deadline, cancellation, progress.
//!
//! Algorithms receive a `&Context`, call [`Context::check`] at least every 50 ms, and open a [`Stage`] for each step of
//! the method. A stage is a tracing span, so that log, progress bar and the timings of the record come from one source.

mod execution;
mod in_order;

pub use execution::{Context, MOST_THREADS, Progress, Stage};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Error;
    use std::sync::Arc;
    use std::sync::atomic::AtomicBool;
    use std::time::Duration;
    use std::time::Instant;

    #[test]
    fn deadline_and_cancel_stop_the_run() {
        assert!(Context::new().check().is_ok());
        let late = Context::new().with_deadline(Instant::now() - Duration::from_secs(1));
        assert!(matches!(late.check(), Err(Error::Deadline)));
        let flag = Arc::new(AtomicBool::new(true));
        assert!(matches!(Context::new().with_cancel(flag).check(), Err(Error::Cancelled)));
    }
}
