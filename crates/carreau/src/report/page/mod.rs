//! Pages: models in one HTML file that needs neither network nor server.
//!
//! | file | holds |
//! |---|---|
//! | `scene` | [`Scene`]: a model and what can be shown on it |
//! | `layer` | columns, lines, nets and marks of a scene |
//! | `irregular` | vertices of quad meshes and edges of hex meshes with an unusual valence |
//! | `pack` | scenes as the viewer reads them |
//! | `container` | the binary part: arrays, deflated, as base64 |
//! | `viewer.js`, `viewer.css` | the viewer, built from `viewer/` at the root of the repository |
//!
//! ```
//! use carreau::report::page::{Page, Role, Scene};
//! use carreau::{Context, quad, sample};
//! let context = Context::new();
//! let mesh = sample::make("torus", Some(20), &context)?;
//! let result = quad::quads(&mesh, &quad::QuadOptions { quads: 200, ..Default::default() }, &context)?;
//! let html = Page::new("torus")
//!     .scene(Scene::of_surface("triangles", &mesh)?.role(Role::Before))
//!     .scene(Scene::of_surface("quads", &result.mesh)?.role(Role::After))
//!     .html()?;
//! assert!(html.starts_with("<!doctype html>"));
//! # Ok::<(), carreau::Error>(())
//! ```

mod container;
mod irregular;
mod layer;
mod pack;
mod scene;
#[cfg(test)]
mod tests;

pub use layer::{Layer, Lines, Markers, Net, On, Path, Range, Style};
pub use scene::{Role, Scene};

use crate::error::{Error, Result};
use container::Container;
use pack::{Packed, pack};
use serde::Serialize;
use serde_json::Value;

/// The bundled viewer.
const SCRIPT: &str = include_str!("viewer.js");
/// Its style sheet.
const STYLES: &str = include_str!("viewer.css");

/// Models, and the run that made them, for one HTML file.
#[derive(Debug, Clone, Default)]
pub struct Page {
    title: String,
    command: Option<String>,
    record: Option<Value>,
    scenes: Vec<Scene>,
}

/// What the script of a page reads.
#[derive(Serialize)]
struct Head<'a> {
    carreau: &'static str,
    title: &'a str,
    command: Option<&'a str>,
    record: Option<&'a Value>,
    #[serde(flatten)]
    packed: Packed,
}

impl Page {
    /// A page without scenes.
    pub fn new(title: impl Into<String>) -> Self {
        Page { title: title.into(), ..Page::default() }
    }

    /// The command line that made it.
    pub fn command(mut self, command: impl Into<String>) -> Self {
        self.command = Some(command.into());
        self
    }

    /// The record of the run: a JSON object with `options`, `seconds`, `warnings`, `quality`; the page shows what it has.
    pub fn record(mut self, record: Value) -> Self {
        self.record = Some(record);
        self
    }

    /// Adds a scene.
    pub fn scene(mut self, scene: Scene) -> Self {
        self.scenes.push(scene);
        self
    }

    /// Adds scenes.
    pub fn scenes(mut self, scenes: impl IntoIterator<Item = Scene>) -> Self {
        self.scenes.extend(scenes);
        self
    }

    /// The whole file.
    ///
    /// # Errors
    /// [`Error::Bug`]: what a page holds can always be written as JSON.
    pub fn html(&self) -> Result<String> {
        let mut arrays = Container::default();
        let head = Head {
            carreau: env!("CARGO_PKG_VERSION"),
            title: &self.title,
            command: self.command.as_deref(),
            record: self.record.as_ref(),
            packed: pack(&self.scenes, &mut arrays),
        };
        let head = serde_json::to_string(&head).map_err(|e| Error::Bug(format!("the page's head: {e}")))?;
        let (title, head, data) = (escaped(&self.title), inert(&head), arrays.finish()?);
        Ok(format!(
            "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             <title>{title}</title>\n<link rel=\"icon\" href=\"data:,\">\n<style>{STYLES}</style>\n</head>\n<body>\n\
             <noscript>This page draws its models with JavaScript, which is switched off.</noscript>\n\
             <script type=\"application/json\" id=\"carreau-head\">{head}</script>\n\
             <script type=\"text/plain\" id=\"carreau-data\">{data}</script>\n\
             <script>{SCRIPT}</script>\n</body>\n</html>\n"
        ))
    }
}

/// Text as it can stand in HTML.
pub fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            _ => out.push(c),
        }
    }
    out
}

/// JSON as it can stand in a script element: no character that could end the element or begin a comment.
fn inert(json: &str) -> String {
    json.replace('<', "\\u003c").replace('>', "\\u003e").replace('&', "\\u0026")
}
