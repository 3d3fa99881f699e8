//! How a run is carried out: threads, deadline, cancellation and progress, as the library takes them.

use crate::common::{Common, CommonValues};
use crate::progress::Bar;
use carreau::{Context, Error};
use std::io::IsTerminal;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// The context of a run with these options.
pub fn context(common: &Common, values: &CommonValues) -> Result<Context, Error> {
    values.validate()?;
    let host = common.host.as_ref();
    let cancel = host.map_or_else(cancel_flag, |host| Arc::clone(&host.cancel));
    let mut context = Context::new().with_threads(values.threads)?.with_cancel(cancel);
    context.seed = values.seed;
    if let Some(seconds) = values.deadline {
        context = context.with_deadline(Instant::now() + Duration::from_secs_f64(seconds));
    }
    match host {
        Some(host) => {
            if let Some(progress) = &host.progress {
                context = context.with_progress(Arc::clone(progress));
            }
        }
        None if std::io::stderr().is_terminal() && !common.quiet => {
            context = context.with_progress(Arc::new(Bar::new()));
        }
        None => {}
    }
    Ok(context)
}

/// Set by Ctrl-C; every context of the process listens to it.
fn cancel_flag() -> Arc<AtomicBool> {
    use std::sync::OnceLock;
    static FLAG: OnceLock<Arc<AtomicBool>> = OnceLock::new();
    Arc::clone(FLAG.get_or_init(|| {
        let flag = Arc::new(AtomicBool::new(false));
        let set = Arc::clone(&flag);
        // Where a handler exists already (embedding in Python), that one decides.
        let _ = ctrlc::set_handler(move || set.store(true, Ordering::Relaxed));
        flag
    }))
}
