//! Speculative execution: runs jobs ahead on idle threads and delivers their results in order, so that the outcome is the same
//! as if they ran one by one.

use super::execution::Context;
use crate::error::Result;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

impl Context {
    /// Runs independent jobs and hands their results to `take` in order, until `take` breaks. Idle threads start later jobs
    /// ahead of time and abandon them once `take` breaks, so that the results taken are the same for any number of threads.
    ///
    /// # Errors
    /// The error of the first job that failed, if its result was needed.
    pub fn in_order<R: Send>(
        &self,
        jobs: usize,
        work: impl Fn(usize, &Context) -> Result<R> + Sync,
        take: impl FnMut(R) -> ControlFlow<()> + Send,
    ) -> Result<()> {
        self.install(|| {
            let needless = Arc::new(AtomicBool::new(false));
            let mut inside = self.clone();
            inside.needless.push(needless.clone());
            let queue = Mutex::new(Queue { found: (0..jobs).map(|_| None).collect(), taken: 0, take, ended: Ok(()) });
            let next = AtomicUsize::new(0);
            let runner = || {
                while !needless.load(Ordering::Relaxed) {
                    let job = next.fetch_add(1, Ordering::Relaxed);
                    if job >= jobs {
                        return;
                    }
                    let found = work(job, &inside);
                    let mut queue = queue.lock().unwrap_or_else(PoisonError::into_inner);
                    needless.fetch_or(queue.put(job, found).is_break(), Ordering::Relaxed);
                }
            };
            // No more runners than threads: one that waits for parts of its job never begins another job.
            let runners = rayon::current_num_threads().min(jobs);
            let (dispatch, span) = (tracing::dispatcher::get_default(Clone::clone), tracing::Span::current());
            let elsewhere = || tracing::dispatcher::with_default(&dispatch, || span.in_scope(runner));
            rayon::scope(|scope| {
                (1..runners).for_each(|_| scope.spawn(|_| elsewhere()));
                runner();
            });
            queue.into_inner().unwrap_or_else(PoisonError::into_inner).ended
        })
    }
}

/// Results that wait for their turn, and the function that takes them.
struct Queue<R, T> {
    found: Vec<Option<Result<R>>>,
    taken: usize,
    take: T,
    ended: Result<()>,
}

impl<R, T: FnMut(R) -> ControlFlow<()>> Queue<R, T> {
    /// Hands on the results that are complete up to the first gap; breaks if no more are needed.
    fn put(&mut self, job: usize, found: Result<R>) -> ControlFlow<()> {
        self.found[job] = Some(found);
        while let Some(found) = self.found.get_mut(self.taken).and_then(Option::take) {
            self.taken += 1;
            let is_last = match found {
                Ok(found) => (self.take)(found).is_break(),
                Err(error) => {
                    self.ended = Err(error);
                    true
                }
            };
            if is_last {
                // What is still under way finds a gap that nobody fills.
                self.taken = usize::MAX;
                return ControlFlow::Break(());
            }
        }
        ControlFlow::Continue(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Error;
    use std::time::{Duration, Instant};

    fn taken(threads: usize, fails: Option<usize>, most: usize) -> (Vec<usize>, Result<()>) {
        let context = Context::new().with_threads(threads).unwrap();
        let mut taken = Vec::new();
        let work = |job: usize, _: &Context| {
            // The first ones take longest.
            std::thread::sleep(Duration::from_millis(10 - job as u64));
            if Some(job) == fails { Err(Error::Numeric(format!("job {job}"))) } else { Ok(job) }
        };
        let ended = context.in_order(10, work, |job| {
            taken.push(job);
            if taken.len() == most { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        (taken, ended)
    }

    #[test]
    fn what_is_taken_does_not_depend_on_threads() {
        for threads in [1, 2, 3] {
            assert_eq!(taken(threads, None, usize::MAX).0, (0..10).collect::<Vec<_>>());
            let (found, ended) = taken(threads, None, 4);
            assert_eq!(found, [0, 1, 2, 3]);
            assert!(ended.is_ok());
            let (found, ended) = taken(threads, Some(6), usize::MAX);
            assert_eq!(found, [0, 1, 2, 3, 4, 5]);
            assert!(matches!(ended, Err(Error::Numeric(what)) if what == "job 6"));
            // A job that fails is of no interest behind the one at which it ends.
            assert!(taken(threads, Some(5), 5).1.is_ok());
        }
    }

    #[test]
    fn jobs_that_are_not_needed_are_given_up_with_those_within_them() {
        let context = Context::new().with_threads(2).unwrap();
        let late = Instant::now() + Duration::from_secs(60);
        let work = |job: usize, context: &Context| {
            if job == 0 {
                return Ok(());
            }
            context.in_order(2, |_, context| until_cancelled(context, late), |()| ControlFlow::Continue(()))
        };
        context.in_order(2, work, |()| ControlFlow::Break(())).unwrap();
        assert!(Instant::now() < late, "nobody told it");
    }

    fn until_cancelled(context: &Context, late: Instant) -> Result<()> {
        while Instant::now() < late {
            context.check()?;
        }
        Ok(())
    }

    #[test]
    fn a_run_that_is_cancelled_ends() {
        let context = Context::new().with_threads(2).unwrap().with_cancel(Arc::new(AtomicBool::new(true)));
        let ended = context.in_order(5, |_, context| context.check(), |()| ControlFlow::Continue(()));
        assert!(matches!(ended, Err(Error::Cancelled)));
        assert!(context.in_order(0, |_, context| context.check(), |()| ControlFlow::Continue(())).is_ok());
    }
}
