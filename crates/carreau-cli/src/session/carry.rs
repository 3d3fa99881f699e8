//! What the input carries (properties, tags) and the result has a place for, or not.

use super::run::Session;
use carreau::Error;
use carreau::geometry::transfer::transfer;
use carreau::mesh::{Column, RawMesh, SurfaceMesh};

impl Session {
    /// Carries what the source has over to the mesh that a method made of it; what cannot be carried is said.
    pub fn carry(&mut self, source: &SurfaceMesh, mesh: &mut RawMesh) -> Result<(), Error> {
        let context = self.context.clone();
        let said = context.install(|| {
            let _stage = context.stage("attributes");
            transfer(source, mesh, &context)
        })?;
        said.into_iter().for_each(|what| self.warn(what));
        if !matches!(self.record.verb(), "simplify" | "enrich") {
            // Columns that the methods make themselves.
            for name in
                ["region", "patch", "u", "v"].into_iter().filter(|name| source.attributes.face.contains_key(*name))
            {
                self.warn(format!(
                    "the method: the face property '{name}' of the input is replaced by that of the result"
                ));
            }
        }
        Ok(())
    }

    /// Says what of a surface the result of this method has no place for.
    pub fn leave_behind(&mut self, source: &SurfaceMesh, result: &str, kept: impl Fn(&Column) -> bool) {
        let a = &source.attributes;
        let columns = a.vertex.iter().chain(&a.corner).chain(a.face.iter().filter(|(_, column)| !kept(column)));
        let names: Vec<String> = columns.map(|(name, _)| format!("'{name}'")).collect();
        if !names.is_empty() {
            self.warn(format!(
                "the method: {result} has no place for what the surface carries: left out {}",
                names.join(", ")
            ));
        }
        if !source.tagged_edges.is_empty() {
            let count = source.tagged_edges.len();
            self.warn(format!(
                "the method: {result} has no place for the tagged edges of the surface: left out all {count}"
            ));
        }
    }
}
