//! The result record: one JSON object per run (contract §3).

use crate::timings::Timings;
use serde::Serialize;
use serde_json::{Map, Value, json};

/// Bytes of the longest part of a record that a page shows.
const LONGEST: usize = 4000;

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

    /// The verb.
    pub fn verb(&self) -> &'static str {
        self.verb
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

    /// The whole record as text.
    pub fn to_json(&self, timings: &Timings) -> String {
        let mut text = serde_json::to_string_pretty(&self.to_value(timings)).unwrap_or_default();
        text.push('\n');
        text
    }

    /// The record without its long parts (lists of regions, boundaries …): what a page shows.
    pub fn brief(&self, timings: &Timings) -> Value {
        let mut all = self.to_value(timings);
        if let Value::Object(parts) = &mut all {
            let is_short = |name: &str, part: &Value| name == "warnings" || part.to_string().len() <= LONGEST;
            parts.retain(|name, part| is_short(name, part));
        }
        all
    }

    fn to_value(&self, timings: &Timings) -> Value {
        let mut all = Map::new();
        all.insert("carreau".into(), json!(env!("CARGO_PKG_VERSION")));
        all.insert("verb".into(), json!(self.verb));
        all.extend(self.parts.clone());
        all.insert("seconds".into(), timings.to_json());
        all.insert("warnings".into(), json!(self.warnings));
        Value::Object(all)
    }
}
