//! Work beside Python: on a thread of its own, without the interpreter's lock, while this thread looks after interrupts
//! and progress.

use crate::raise;
use carreau::Error;
use carreau::context::Progress;
use pyo3::prelude::*;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// How often interrupts are looked for.
const POLL: Duration = Duration::from_millis(50);
/// The methods run on it, or start from it.
const STACK: usize = 16 << 20;

/// Progress as it was last told; who wants it looks here.
#[derive(Default)]
struct Board {
    stage: Mutex<&'static str>,
    share: AtomicU64,
}

impl Board {
    fn read(&self) -> (&'static str, f64) {
        let stage = *self.stage.lock().unwrap_or_else(PoisonError::into_inner);
        (stage, f64::from_bits(self.share.load(Ordering::Relaxed)))
    }
}

impl Progress for Board {
    fn stage(&self, name: &'static str) {
        *self.stage.lock().unwrap_or_else(PoisonError::into_inner) = name;
        self.share(0.0);
    }

    fn share(&self, done: f64) {
        self.share.store(done.clamp(0.0, 1.0).to_bits(), Ordering::Relaxed);
    }
}

/// Runs `work` with a flag that stops it and a place for its progress. `watch`, if any, is called with a stage's name
/// and the share of it that is done, from time to time. An exception, of a signal's handler or of `watch`, stops the
/// work and is raised once it has stopped.
pub fn beside<T: Send>(
    py: Python<'_>,
    watch: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(Arc<AtomicBool>, Arc<dyn Progress>) -> Result<T, Error> + Send,
) -> PyResult<T> {
    let cancel = Arc::new(AtomicBool::new(false));
    let board = Arc::new(Board::default());
    std::thread::scope(|scope| {
        let (send, mut receive) = channel();
        let (flag, sink) = (Arc::clone(&cancel), Arc::clone(&board));
        let guarded = move || {
            let result = catch_unwind(AssertUnwindSafe(|| work(flag, sink)));
            // The receiver stays until this has arrived.
            let _ = send.send(result);
        };
        std::thread::Builder::new().name("carreau".into()).stack_size(STACK).spawn_scoped(scope, guarded)?;
        let mut raised = None;
        let result = loop {
            let waiting = &mut receive;
            match py.detach(move || waiting.recv_timeout(POLL)) {
                Ok(result) => break result,
                Err(RecvTimeoutError::Disconnected) => {
                    break Ok(Err(Error::Bug("the work ended without a result".into())));
                }
                Err(RecvTimeoutError::Timeout) => {}
            }
            let told = py.check_signals().and_then(|()| match watch {
                Some(watch) if raised.is_none() => watch.call1(board.read()).map(drop),
                _ => Ok(()),
            });
            if let Err(exception) = told {
                cancel.store(true, Ordering::Relaxed);
                raised = Some(exception);
            }
        };
        match (raised, result) {
            (Some(exception), _) => Err(exception),
            (None, Ok(Ok(value))) => Ok(value),
            (None, Ok(Err(error))) => Err(raise::exception(py, &error)),
            (None, Err(payload)) => Err(raise::panic(py, &*payload)),
        }
    })
}
