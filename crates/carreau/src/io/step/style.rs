//! Colours of faces.

use super::writer::{Id, Writer};
use crate::brep::Brep;
use std::collections::BTreeMap;

impl Writer<'_> {
    /// A styled item for every face that has a colour; one style per colour.
    pub(super) fn colors(&mut self, brep: &Brep, context: Id, faces: &[Id]) {
        let mut styles: BTreeMap<[u8; 3], Id> = BTreeMap::new();
        let mut items = Vec::new();
        for (face, &id) in brep.faces.iter().zip(faces) {
            let Some(color) = face.color else { continue };
            let style = match styles.get(&color) {
                Some(&style) => style,
                None => {
                    let style = self.style(color);
                    styles.insert(color, style);
                    style
                }
            };
            items.push(self.entity("STYLED_ITEM('color',(#),#)", &[style, id]));
        }
        if items.is_empty() {
            return;
        }
        self.begin();
        self.text("MECHANICAL_DESIGN_GEOMETRIC_PRESENTATION_REPRESENTATION('',");
        self.ids(items);
        self.out.push(b',');
        self.id(context);
        self.out.push(b')');
        self.end();
    }

    fn style(&mut self, color: [u8; 3]) -> Id {
        let rgb = self.begin();
        self.text("COLOUR_RGB(''");
        for x in color {
            self.out.push(b',');
            self.real(f64::from(x) / 255.0);
        }
        self.out.push(b')');
        self.end();
        let fill = self.entity("FILL_AREA_STYLE_COLOUR('',#)", &[rgb]);
        let fill = self.entity("FILL_AREA_STYLE('',(#))", &[fill]);
        let fill = self.entity("SURFACE_STYLE_FILL_AREA(#)", &[fill]);
        let side = self.entity("SURFACE_SIDE_STYLE('',(#))", &[fill]);
        let usage = self.entity("SURFACE_STYLE_USAGE(.BOTH.,#)", &[side]);
        self.entity("PRESENTATION_STYLE_ASSIGNMENT((#))", &[usage])
    }
}
