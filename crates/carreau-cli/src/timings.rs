//! Seconds per stage: a tracing layer that listens to the spans of `Context::stage`.

use serde_json::{Map, Value, json};
use std::sync::{Arc, Mutex};
use std::time::Instant;
use tracing::field::{Field, Visit};
use tracing::span::{Attributes, Id};
use tracing_subscriber::Layer;
use tracing_subscriber::layer::Context;
use tracing_subscriber::registry::LookupSpan;

/// Collects the time spent in each stage, in the order in which stages first appear.
#[derive(Clone)]
pub struct Timings {
    start: Instant,
    stages: Arc<Mutex<Vec<(String, f64)>>>,
}

/// When a stage's span began.
struct Begun {
    name: String,
    at: Instant,
}

struct StageName(Option<String>);

impl Visit for StageName {
    fn record_str(&mut self, field: &Field, value: &str) {
        if field.name() == "name" {
            self.0 = Some(value.to_string());
        }
    }

    fn record_debug(&mut self, _: &Field, _: &dyn std::fmt::Debug) {}
}

impl Timings {
    /// The clock of a run starts.
    pub fn new() -> Self {
        Timings { start: Instant::now(), stages: Arc::default() }
    }

    /// `{"total": …, stage: …}`, rounded to microseconds.
    pub fn to_json(&self) -> Value {
        let seconds = |s: f64| json!((s * 1e6).round() / 1e6);
        let mut all = Map::new();
        all.insert("total".into(), seconds(self.start.elapsed().as_secs_f64()));
        if let Ok(stages) = self.stages.lock() {
            all.extend(stages.iter().map(|(name, s)| (name.clone(), seconds(*s))));
        }
        Value::Object(all)
    }
}

impl<S: tracing::Subscriber + for<'a> LookupSpan<'a>> Layer<S> for Timings {
    fn on_new_span(&self, attributes: &Attributes<'_>, id: &Id, context: Context<'_, S>) {
        let mut name = StageName(None);
        if attributes.metadata().target() == "carreau::stage" {
            attributes.record(&mut name);
        }
        if let (Some(name), Some(span)) = (name.0, context.span(id)) {
            span.extensions_mut().insert(Begun { name, at: Instant::now() });
        }
    }

    fn on_close(&self, id: Id, context: Context<'_, S>) {
        let Some(span) = context.span(&id) else { return };
        let extensions = span.extensions();
        let (Some(begun), Ok(mut stages)) = (extensions.get::<Begun>(), self.stages.lock()) else { return };
        let seconds = begun.at.elapsed().as_secs_f64();
        match stages.iter_mut().find(|(name, _)| *name == begun.name) {
            Some((_, sum)) => *sum += seconds,
            None => stages.push((begun.name.clone(), seconds)),
        }
    }
}
