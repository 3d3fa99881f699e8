//! A progress bar on stderr, where stderr is a terminal.

use carreau::context::Progress;
use indicatif::{ProgressBar, ProgressStyle};
use std::time::Duration;

/// One bar, renamed from stage to stage.
pub struct Bar(ProgressBar);

impl Bar {
    /// A bar that is drawn after a moment, so that short runs show none.
    pub fn new() -> Self {
        let bar = ProgressBar::new(1000);
        if let Ok(style) = ProgressStyle::with_template("{spinner} {msg:12} {wide_bar} {percent:>3} % {elapsed:>4}") {
            bar.set_style(style);
        }
        bar.enable_steady_tick(Duration::from_millis(200));
        Bar(bar)
    }
}

impl Progress for Bar {
    fn stage(&self, name: &'static str) {
        self.0.set_message(name);
        self.0.set_position(0);
    }

    fn share(&self, done: f64) {
        self.0.set_position((done.clamp(0.0, 1.0) * 1000.0) as u64);
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}
