//! The result record: one JSON object per run (contract §3).

use crate::timings::Timings;
use serde::Serialize;
use serde_json::{Map, Value, json};

/// Collects what a run has to tell.
#[derive(Default)]
pub struct Record {
    verb: &'static str,
    parts: Map<String, Value>,
    /// What the user should know: repairs on reading, losses on writing, fallbacks.
    pub warnings: Vec<String>,
}

impl Record {
    /// An empty record of a verb.
    pub fn new(verb: &'static str) -> Self {
        Record { verb, ..Record::default() }
    }

    /// Sets a part of the record.
    pub fn set(&mut self, name: &str, value: impl Serialize) {
        let value = serde_json::to_value(value).unwrap_or(Value::Null);
        self.parts.insert(name.into(), value);
    }

    /// Sets every field of a serialised struct as a part of its own.
    pub fn set_all(&mut self, fields: impl Serialize) {
        if let Ok(Value::Object(fields)) = serde_json::to_value(fields) {
            self.parts.extend(fields);
        }
    }

    /// The whole record.
    pub fn to_json(&self, timings: &Timings) -> String {
        let mut all = Map::new();
        all.insert("carreau".into(), json!(env!("CARGO_PKG_VERSION")));
        all.insert("verb".into(), json!(self.verb));
        all.extend(self.parts.clone());
        all.insert("seconds".into(), timings.to_json());
        all.insert("warnings".into(), json!(self.warnings));
        let mut text = serde_json::to_string_pretty(&Value::Object(all)).unwrap_or_default();
        text.push('\n');
        text
    }
}
