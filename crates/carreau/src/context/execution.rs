//! The context itself.

use crate::error::{Error, Result};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// Most threads of a run: starting more takes longer than they can save, and none of them could be stopped meanwhile.
pub const MOST_THREADS: usize = 512;

/// Receives the progress of a run. Called from worker threads.
pub trait Progress: Send + Sync {
    /// A stage of the method begins.
    fn stage(&self, name: &'static str);
    /// The share of the current stage that is done, in 0..=1.
    fn share(&self, done: f64);
}

/// How a run is to be done; says nothing about what is computed.
#[derive(Clone, Default)]
pub struct Context {
    /// Seed of every pseudo-random choice.
    pub seed: u64,
    pub(super) deadline: Option<Instant>,
    pub(super) cancel: Arc<AtomicBool>,
    /// Set once this part of the run is not needed any more; see [`Context::in_order`].
    pub(super) needless: Vec<Arc<AtomicBool>>,
    pub(super) progress: Option<Arc<dyn Progress>>,
    pub(super) pool: Option<Arc<rayon::ThreadPool>>,
}

impl Context {
    /// A context with all processors, no deadline and no progress.
    pub fn new() -> Self {
        Self::default()
    }

    /// Uses this many threads, at most [`MOST_THREADS`] (0: all processors). Results do not depend on it.
    ///
    /// # Errors
    /// [`Error::Options`] where the system gives no threads.
    pub fn with_threads(mut self, threads: usize) -> Result<Self> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.min(MOST_THREADS)).build();
        self.pool = Some(Arc::new(pool.map_err(|e| Error::Options(format!("{threads} threads: {e}")))?));
        Ok(self)
    }

    /// Gives up with [`Error::Deadline`] once this instant has passed.
    pub fn with_deadline(mut self, deadline: Instant) -> Self {
        self.deadline = Some(deadline);
        self
    }

    /// Gives up with [`Error::Cancelled`] once the flag is set.
    pub fn with_cancel(mut self, cancel: Arc<AtomicBool>) -> Self {
        self.cancel = cancel;
        self
    }

    /// Reports progress to this sink.
    pub fn with_progress(mut self, progress: Arc<dyn Progress>) -> Self {
        self.progress = Some(progress);
        self
    }

    /// Fails when the run was cancelled or its deadline has passed.
    ///
    /// # Errors
    /// [`Error::Cancelled`], [`Error::Deadline`].
    pub fn check(&self) -> Result<()> {
        if self.cancel.load(Ordering::Relaxed) || self.needless.iter().any(|n| n.load(Ordering::Relaxed)) {
            return Err(Error::Cancelled);
        }
        match self.deadline {
            Some(deadline) if Instant::now() >= deadline => Err(Error::Deadline),
            _ => Ok(()),
        }
    }

    /// [`Context::check`] for tight loops: looks only when `step` is a multiple of 1024.
    ///
    /// # Errors
    /// [`Error::Cancelled`], [`Error::Deadline`].
    pub fn check_every(&self, step: usize) -> Result<()> {
        if step.is_multiple_of(1024) { self.check() } else { Ok(()) }
    }

    /// Begins a stage of the method; it ends when the returned guard is dropped.
    pub fn stage(&self, name: &'static str) -> Stage<'_> {
        if let Some(progress) = &self.progress {
            progress.stage(name);
        }
        Stage { context: self, _span: tracing::info_span!(target: "carreau::stage", "stage", name).entered() }
    }

    /// Runs `work` in this context's thread pool.
    pub fn install<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        match &self.pool {
            Some(pool) => {
                // The subscriber is thread-local in tests and embedders: carry it, and the current span, along.
                let dispatch = tracing::dispatcher::get_default(Clone::clone);
                let span = tracing::Span::current();
                pool.install(|| tracing::dispatcher::with_default(&dispatch, || span.in_scope(work)))
            }
            None => work(),
        }
    }
}

/// A running stage; see [`Context::stage`].
pub struct Stage<'a> {
    pub(super) context: &'a Context,
    pub(super) _span: tracing::span::EnteredSpan,
}

impl Stage<'_> {
    /// Reports `done` of `total` steps and checks deadline and cancellation.
    ///
    /// # Errors
    /// [`Error::Cancelled`], [`Error::Deadline`].
    pub fn step(&self, done: usize, total: usize) -> Result<()> {
        if let Some(progress) = &self.context.progress {
            progress.share(done as f64 / total.max(1) as f64);
        }
        self.context.check()
    }
}
