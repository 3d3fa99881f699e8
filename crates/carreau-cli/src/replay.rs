//! Options files: a JSON object of options, or a result record, whose `options` are taken.

use carreau::{Error, Result};
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};
use std::path::Path;

/// Lays the options of a file, if there is one, over `base`; unknown names are refused.
pub fn options_from<T: Serialize + DeserializeOwned>(file: Option<&Path>, verb: &str, base: T) -> Result<T> {
    let Some(file) = file else { return Ok(base) };
    let wrong = |what: String| Error::Options(format!("{}: {what}", file.display()));
    let text = std::fs::read_to_string(file).map_err(|e| Error::read(file, carreau::Place::File, e.to_string()))?;
    let json: Value = serde_json::from_str(&text).map_err(|e| wrong(format!("this is not JSON: {e}")))?;
    let Value::Object(mut given) = json else { return Err(wrong("a JSON object of options is expected".into())) };
    if let Some(Value::Object(options)) = given.remove("options") {
        if let Some(other) = given.get("verb").and_then(Value::as_str).filter(|&v| v != verb) {
            return Err(wrong(format!("this is a record of `carreau {other}`, not of `carreau {verb}`")));
        }
        given = options;
    }
    let mut all = match serde_json::to_value(base) {
        Ok(Value::Object(all)) => all,
        _ => Map::new(),
    };
    for (name, value) in given {
        // Names as on the command line are understood, too.
        match all.get_mut(&name.replace('-', "_")) {
            Some(place) => *place = value,
            None => return Err(wrong(format!("there is no option '{name}'"))),
        }
    }
    serde_json::from_value(Value::Object(all)).map_err(|e| wrong(e.to_string()))
}
