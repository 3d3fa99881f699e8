//! What a run says on stderr while it goes on, and the clock that listens to its stages.

use crate::common::Common;
use crate::timings::Timings;
use std::io::IsTerminal;
use tracing::Subscriber;
use tracing_subscriber::filter::LevelFilter;
use tracing_subscriber::layer::SubscriberExt;
use tracing_subscriber::{Layer, fmt as log};

/// Who listens to a run: the clock, and stderr as loud as was asked for.
pub fn listener(common: &Common, timings: &Timings) -> impl Subscriber + Send + Sync {
    let level = match (common.quiet, common.verbose) {
        // A program that calls is handed the warnings with the record.
        (_, 0) if common.host.is_some() => LevelFilter::OFF,
        (true, _) => LevelFilter::ERROR,
        (_, 0) => LevelFilter::WARN,
        (_, 1) => LevelFilter::INFO,
        _ => LevelFilter::DEBUG,
    };
    let spans = if common.verbose > 0 { log::format::FmtSpan::CLOSE } else { log::format::FmtSpan::NONE };
    let stderr = log::layer()
        .with_writer(std::io::stderr)
        .with_ansi(std::io::stderr().is_terminal())
        .without_time()
        .with_target(false)
        .with_span_events(spans);
    tracing_subscriber::registry().with(timings.clone()).with(stderr.with_filter(level))
}
