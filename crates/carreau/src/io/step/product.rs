//! Header, units, and the product with its representations.

use super::writer::{Id, Writer};
use crate::brep::{Brep, Frame, Solid};
use crate::io::cad::{CadOptions, StepSchema, Unit, resolution};
use glam::DVec3;

impl Writer<'_> {
    pub(super) fn header(&mut self, options: &CadOptions) {
        self.text("ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\nFILE_NAME(");
        self.string(&options.name);
        self.out.push(b',');
        self.string(&options.date);
        self.text(",(''),(''),'carreau ");
        self.text(env!("CARGO_PKG_VERSION"));
        self.text("','carreau','');\nFILE_SCHEMA(('");
        self.text(match options.schema {
            StepSchema::Ap214 => "AUTOMOTIVE_DESIGN { 1 0 10303 214 1 1 1 1 }",
            StepSchema::Ap242 => "AP242_MANAGED_MODEL_BASED_3D_ENGINEERING_MIM_LF { 1 0 10303 442 1 1 4 }",
        });
        self.text("'));\nENDSEC;\nDATA;\n");
    }

    /// Units and uncertainty.
    pub(super) fn context(&mut self, brep: &Brep, unit: Unit) -> Id {
        let si = |w: &mut Self, prefix: &str| {
            w.entity(&format!("(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT({prefix},.METRE.))"), &[])
        };
        let length = match unit {
            Unit::Millimetre => si(self, ".MILLI."),
            Unit::Centimetre => si(self, ".CENTI."),
            Unit::Metre => si(self, "$"),
            Unit::Inch => {
                let base = si(self, ".MILLI.");
                let dimensions = self.entity("DIMENSIONAL_EXPONENTS(1.,0.,0.,0.,0.,0.,0.)", &[]);
                let factor = self.entity("LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(25.4),#)", &[base]);
                self.entity("(CONVERSION_BASED_UNIT('INCH',#)LENGTH_UNIT()NAMED_UNIT(#))", &[factor, dimensions])
            }
        };
        let angle = self.entity("(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.))", &[]);
        let solid_angle = self.entity("(NAMED_UNIT(*)SI_UNIT($,.STERADIAN.)SOLID_ANGLE_UNIT())", &[]);
        let uncertainty = self.begin();
        self.text("UNCERTAINTY_MEASURE_WITH_UNIT(LENGTH_MEASURE(");
        self.real(resolution(brep));
        self.text("),");
        self.id(length);
        self.text(",'distance_accuracy_value','')");
        self.end();
        self.entity(
            "(GEOMETRIC_REPRESENTATION_CONTEXT(3)GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT((#))\
             GLOBAL_UNIT_ASSIGNED_CONTEXT((#,#,#))REPRESENTATION_CONTEXT('',''))",
            &[uncertainty, length, angle, solid_angle],
        )
    }

    /// Solids and surfaces, and the product they are the shape of.
    pub(super) fn product(&mut self, brep: &Brep, options: &CadOptions, context: Id, shells: &[Id]) {
        let axes = self.placement(&Frame { origin: DVec3::ZERO, z: DVec3::Z, x: DVec3::X });
        let solids: Vec<Id> = brep.solids.iter().map(|s| self.solid(s, shells)).collect();
        let free: Vec<Id> = brep.free_shells().into_iter().map(|s| shells[s as usize]).collect();
        let mut parts = Vec::new();
        if !solids.is_empty() {
            parts.push(self.representation("ADVANCED_BREP_SHAPE_REPRESENTATION", &solids, axes, context));
        }
        if !free.is_empty() {
            let model = self.begin();
            self.text("SHELL_BASED_SURFACE_MODEL('',");
            self.ids(free);
            self.out.push(b')');
            self.end();
            parts.push(self.representation("MANIFOLD_SURFACE_SHAPE_REPRESENTATION", &[model], axes, context));
        }
        let shape = match parts[..] {
            [single] => single,
            _ => {
                let whole = self.representation("SHAPE_REPRESENTATION", &[], axes, context);
                for part in parts {
                    self.entity("SHAPE_REPRESENTATION_RELATIONSHIP('','',#,#)", &[whole, part]);
                }
                whole
            }
        };
        self.product_definition(options, shape);
    }

    pub(super) fn representation(&mut self, kind: &str, items: &[Id], axes: Id, context: Id) -> Id {
        let id = self.begin();
        self.text(kind);
        self.text("('',");
        self.ids([axes].into_iter().chain(items.iter().copied()));
        self.out.push(b',');
        self.id(context);
        self.out.push(b')');
        self.end();
        id
    }

    pub(super) fn product_definition(&mut self, options: &CadOptions, shape: Id) {
        let (application, protocol) = match options.schema {
            StepSchema::Ap214 => ("core data for automotive mechanical design processes", "automotive_design',2000"),
            StepSchema::Ap242 => {
                ("managed model based 3d engineering", "ap242_managed_model_based_3d_engineering',2020")
            }
        };
        let application = self.entity(&format!("APPLICATION_CONTEXT('{application}')"), &[]);
        let status = format!("APPLICATION_PROTOCOL_DEFINITION('international standard','{protocol},#)");
        self.entity(&status, &[application]);
        let product_context = self.entity("PRODUCT_CONTEXT('',#,'mechanical')", &[application]);
        let product = self.begin();
        self.text("PRODUCT(");
        self.string(&options.name);
        self.out.push(b',');
        self.string(&options.name);
        self.text(",'',(");
        self.id(product_context);
        self.text("))");
        self.end();
        self.entity("PRODUCT_RELATED_PRODUCT_CATEGORY('part',$,(#))", &[product]);
        let formation = self.entity("PRODUCT_DEFINITION_FORMATION('','',#)", &[product]);
        let view = self.entity("PRODUCT_DEFINITION_CONTEXT('part definition',#,'design')", &[application]);
        let definition = self.entity("PRODUCT_DEFINITION('design','',#,#)", &[formation, view]);
        let of = self.entity("PRODUCT_DEFINITION_SHAPE('','',#)", &[definition]);
        self.entity("SHAPE_DEFINITION_REPRESENTATION(#,#)", &[of, shape]);
    }

    /// A CLOSED_SHELL's normals point to infinity (ISO 10303-42), so voids are written turned and then turned back.
    pub(super) fn solid(&mut self, solid: &Solid, shells: &[Id]) -> Id {
        let outer = shells[solid.outer as usize];
        let voids = &solid.voids;
        let turned: Vec<Id> =
            voids.iter().map(|&v| self.entity("ORIENTED_CLOSED_SHELL('',*,#,.F.)", &[shells[v as usize]])).collect();
        let id = self.begin();
        self.text(if voids.is_empty() { "MANIFOLD_SOLID_BREP(" } else { "BREP_WITH_VOIDS(" });
        self.string(&solid.name);
        self.out.push(b',');
        self.id(outer);
        if !voids.is_empty() {
            self.out.push(b',');
            self.ids(turned);
        }
        self.out.push(b')');
        self.end();
        id
    }
}
