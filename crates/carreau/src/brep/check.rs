//! Proof that a model's parts fit together: the least that writers and measures rely on.

use super::{Brep, Curve, Surface};
use crate::error::{Error, Result};

/// How far the end of a curve may be from its vertex beyond the tolerances: rounding, as a share of the coordinates.
const END_ROUNDING: f64 = 1e-12;

impl Brep {
    /// Proves that the model is consistent: references exist, numbers are in range, loops close, curves begin and end at
    /// their vertices, no edge is used twice in the same sense, closed shells have no free edge, solids consist of closed
    /// shells. Fails with [`Error::Bug`].
    ///
    /// # Errors
    /// [`Error::Bug`] with the first part that does not fit.
    pub fn check(&self) -> Result<()> {
        self.check_references()?;
        self.check_curves()?;
        self.check_surfaces()?;
        self.check_loops()?;
        self.check_shells()
    }

    fn check_references(&self) -> Result<()> {
        let uses = || self.faces.iter().flat_map(|f| f.loops.iter().flatten());
        let solid_shells = self.solids.iter().flat_map(|s| s.voids.iter().chain([&s.outer]).copied());
        if below(self.edges.iter().flat_map(|e| e.ends), self.vertices.len())
            && below(uses().map(|u| u.edge), self.edges.len())
            && below(self.faces.iter().map(|f| f.surface), self.surfaces.len())
            && below(self.faces.iter().flat_map(|f| f.poles.iter().copied()), self.vertices.len())
            && below(self.shells.iter().flat_map(|s| s.faces.iter().copied()), self.faces.len())
            && below(solid_shells, self.shells.len())
        {
            return Ok(());
        }
        defect("an index is out of range", 0)
    }

    fn check_curves(&self) -> Result<()> {
        for (k, edge) in self.edges.iter().enumerate() {
            let [a, b] = edge.range;
            // Only a line may have no length: sides of triangles without area.
            let forward = a < b || (a == b && matches!(edge.curve, Curve::Line { .. }));
            if !edge.curve.is_sound() || !a.is_finite() || !b.is_finite() || !forward || !(edge.tolerance >= 0.0) {
                return defect("a number is out of range on edge", k);
            }
            for (end, t) in edge.ends.iter().zip(edge.range) {
                let vertex = self.vertices[*end as usize];
                let off = edge.curve.point(t).distance(vertex.point);
                let allowed = vertex.tolerance + END_ROUNDING * (vertex.point.abs().max_element() + (b - a).abs());
                if !(off <= allowed) {
                    return defect("the curve does not end at the vertices of edge", k);
                }
            }
        }
        Ok(())
    }

    fn check_surfaces(&self) -> Result<()> {
        for (k, surface) in self.surfaces.iter().enumerate() {
            if !surface.is_sound() || !has_plane_profile(surface) {
                return defect("a number is out of range, or the profile is elsewhere, on surface", k);
            }
        }
        Ok(())
    }

    fn check_loops(&self) -> Result<()> {
        for (k, face) in self.faces.iter().enumerate() {
            if face.loops.is_empty() && face.poles.is_empty() {
                return defect("there is no loop on face", k);
            }
            for uses in &face.loops {
                let next = uses.iter().cycle().skip(1);
                if uses.is_empty() || uses.iter().zip(next).any(|(a, b)| self.end(a) != self.start(b)) {
                    return defect("a loop is not closed on face", k);
                }
            }
        }
        Ok(())
    }

    fn check_shells(&self) -> Result<()> {
        let mut shell_of = vec![u32::MAX; self.faces.len()];
        // Per edge: the shell that uses it, and how often in either sense.
        let mut used = vec![(u32::MAX, [0u32; 2]); self.edges.len()];
        for (s, shell) in self.shells.iter().enumerate() {
            for &f in &shell.faces {
                if std::mem::replace(&mut shell_of[f as usize], s as u32) != u32::MAX {
                    return defect("two shells have face", f as usize);
                }
                for of in self.faces[f as usize].uses() {
                    let (owner, count) = &mut used[of.edge as usize];
                    count[usize::from(of.reversed)] += 1;
                    if *owner != u32::MAX && *owner != s as u32 || count[usize::from(of.reversed)] > 1 {
                        return defect("two shells, or two loops in the same sense, have edge", of.edge as usize);
                    }
                    *owner = s as u32;
                }
            }
        }
        if let Some(f) = shell_of.iter().position(|&s| s == u32::MAX) {
            return defect("no shell has face", f);
        }
        let open = |owner: u32| self.shells.get(owner as usize).is_none_or(|s| !s.closed);
        if let Some(e) = used.iter().position(|&(owner, count)| count != [1, 1] && !open(owner)) {
            return defect("a closed shell is open at edge", e);
        }
        let mut solid_shells = self.solids.iter().flat_map(|s| s.voids.iter().chain([&s.outer]));
        if solid_shells.any(|&s| !self.shells[s as usize].closed) {
            return defect("an open shell bounds a solid", 0);
        }
        Ok(())
    }
}

/// Whether the profile of a swept surface lies where projection and files need it: across the direction of an extrusion, in
/// the half plane of a revolution.
fn has_plane_profile(surface: &Surface) -> bool {
    let samples = |profile: &Curve| {
        let [low, high] = profile.domain().map(|t| t.clamp(-1.0, 1.0e300));
        let high = if high < 1e300 { high } else { 1.0 };
        (0..=8).map(|k| profile.point(low + (high - low) * f64::from(k) / 8.0)).collect::<Vec<_>>()
    };
    match surface {
        Surface::Extrusion { profile, direction } => {
            let points = samples(profile);
            let level = points[0].dot(*direction);
            let size = points.iter().map(|p| p.abs().max_element()).fold(0.0, f64::max);
            points.iter().all(|p| (p.dot(*direction) - level).abs() <= 1e-9 * size)
        }
        Surface::Revolution { profile, frame } => {
            let points = samples(profile);
            let size = points.iter().map(|p| p.distance(frame.origin)).fold(frame.origin.length(), f64::max);
            points.iter().map(|p| frame.local(*p)).all(|l| l.y.abs() <= 1e-9 * size && l.x >= -1e-9 * size)
        }
        _ => true,
    }
}

fn below(mut ids: impl Iterator<Item = u32>, limit: usize) -> bool {
    ids.all(|k| (k as usize) < limit)
}

fn defect(what: &str, id: usize) -> Result<()> {
    Err(Error::Bug(format!("boundary representation: {what} {id}")))
}
