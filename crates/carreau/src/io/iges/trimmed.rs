//! Faces one by one: 128 whole, or 144 trimmed surfaces with 142 boundaries.

use super::records::{Entity, Head, Writer};
use super::words::{DEPENDENT, INDEPENDENT, PARAMETRIC};
use crate::brep::{Brep, EdgeUse, Face, Surface};
use crate::io::cad::needs_parameter_curves;

impl Writer {
    /// Every face as a surface.
    pub(super) fn trimmed_faces(&mut self, brep: &Brep) {
        let extents = brep.extents();
        for (face, &extent) in brep.faces.iter().zip(&extents) {
            self.trimmed_face(brep, face, extent);
        }
    }

    fn trimmed_face(&mut self, brep: &Brep, face: &Face, extent: [[f64; 2]; 2]) {
        if let Surface::Spline(spline) = brep.surface(face)
            && !needs_parameter_curves(brep, face)
        {
            self.spline_surface(spline, INDEPENDENT);
            return;
        }
        let surface = self.swept(brep.surface(face), extent);
        let loops: Vec<Entity> = face.loops.iter().map(|uses| self.boundary(brep, surface, uses)).collect();
        let color = self.color(face.color);
        let name = self.name(&face.name);
        // Without a loop the surface is its own border.
        let outer = u32::from(!loops.is_empty());
        self.record(&Head { kind: 144, status: INDEPENDENT, color, ..Head::default() }, |w| {
            // Surface, "the first loop is the outer one", number of holes, loops.
            w.integers([surface, outer, loops.len().saturating_sub(1) as u32]);
            w.integers(if loops.is_empty() { vec![0] } else { loops });
            w.property(name);
        });
    }

    /// 142: a loop on a surface, as a curve in its parameter plane where there is one, and as a curve in space.
    fn boundary(&mut self, brep: &Brep, surface: Entity, uses: &[EdgeUse]) -> Entity {
        let flat: Vec<Entity> = uses.iter().filter_map(|of| self.parameter_curve(brep, of)).collect();
        let flat = if flat.is_empty() { 0 } else { self.composite(&flat, PARAMETRIC) };
        let space: Vec<Entity> =
            uses.iter().map(|of| self.edge_curve(&brep.edges[of.edge as usize], of.reversed, brep)).collect();
        let space = self.composite(&space, DEPENDENT);
        // Created in an unspecified way; the curve in space is preferred where there is no other, else both are equal.
        let preferred = if flat == 0 { 2 } else { 3 };
        self.entity(142, DEPENDENT, |w| w.integers([0, surface, flat, space, preferred]))
    }

    /// 314, in per cent of red, green and blue; 0 for none.
    pub(super) fn color(&mut self, color: Option<[u8; 3]>) -> Entity {
        let Some(color) = color else { return 0 };
        if let Some(&known) = self.colors.get(&color) {
            return known;
        }
        let percent = color.map(|x| f64::from(x) / 2.55);
        // Definitions: the use of these entities is 02.
        let head = Head { kind: 314, status: "00000200", ..Head::default() };
        let entity = self.record(&head, |w| w.reals(percent));
        self.colors.insert(color, entity);
        entity
    }

    /// 406 form 15, a name; 0 for none.
    pub(super) fn name(&mut self, name: &str) -> Entity {
        if name.is_empty() {
            return 0;
        }
        self.record(&Head { kind: 406, form: 15, ..Head::default() }, |w| {
            w.integer(1);
            w.string(name);
        })
    }

    /// The end of an entity's parameters: no associativities, one property.
    pub(super) fn property(&mut self, name: Entity) {
        if name != 0 {
            self.integers([0, 1, name]);
        }
    }

    fn string(&mut self, text: &str) {
        self.field.extend_from_slice(super::global::hollerith(text).as_bytes());
        self.push_field();
    }
}
