//! STEP (ISO 10303-21) files of boundary representations, for the protocols AP214 and AP242.
//!
//! Solids are MANIFOLD_SOLID_BREP or BREP_WITH_VOIDS, shells without a solid are in a SHELL_BASED_SURFACE_MODEL. Points
//! are written once per position and referenced wherever they occur, in control nets too: neighbours then agree exactly,
//! and files are about a third smaller.

use super::cad::{CadOptions, StepSchema, Unit, needs_parameter_curves, push_real, resolution};
use super::text::push_integer;
use crate::brep::{Brep, Curve, Edge, EdgeUse, Face, Frame, Shell, Surface};
use crate::error::Result;
use crate::geometry::bspline::{BSplineCurve, BSplineSurface, Knots};
use glam::DVec3;
use rustc_hash::FxHashMap;

/// Appends the file's bytes.
pub fn write(brep: &Brep, options: &CadOptions, out: &mut Vec<u8>) -> Result<()> {
    options.check()?;
    let mut writer = Writer { out, last: 0, points: FxHashMap::default(), points_2d: FxHashMap::default() };
    writer.header(options);
    let context = writer.context(brep, options.unit);
    let shells = writer.topology(brep, options.parameter_curves);
    writer.product(brep, options, context, &shells);
    writer.text("ENDSEC;\nEND-ISO-10303-21;\n");
    Ok(())
}

/// Number of an entity, as in `#17`.
type Id = u32;

struct Writer<'a> {
    out: &'a mut Vec<u8>,
    last: Id,
    points: FxHashMap<[u64; 3], Id>,
    points_2d: FxHashMap<[u64; 2], Id>,
}

// Pieces of text ---------------------------------------------------------------------------------------------------

impl Writer<'_> {
    fn text(&mut self, text: &str) {
        self.out.extend_from_slice(text.as_bytes());
    }

    fn id(&mut self, id: Id) {
        self.out.push(b'#');
        push_integer(self.out, id);
    }

    fn real(&mut self, x: f64) {
        push_real(self.out, x, b'E');
    }

    /// `(a,b,c)`
    fn list<T>(&mut self, items: impl IntoIterator<Item = T>, mut item: impl FnMut(&mut Self, T)) {
        self.out.push(b'(');
        for (k, x) in items.into_iter().enumerate() {
            if k > 0 {
                self.out.push(b',');
            }
            item(self, x);
        }
        self.out.push(b')');
    }

    fn ids(&mut self, ids: impl IntoIterator<Item = Id>) {
        self.list(ids, |w, id| w.id(id));
    }

    /// `'text'` with quotes doubled and everything outside printable ASCII as `\X2\…\X0\` (part 21, 6.4.3).
    fn string(&mut self, text: &str) {
        self.out.push(b'\'');
        for c in text.chars() {
            match c {
                '\'' => self.text("''"),
                '\\' => self.text("\\\\"),
                ' '..='~' => self.out.push(c as u8),
                _ if u32::from(c) < 0x1_0000 => self.text(&format!("\\X2\\{:04X}\\X0\\", u32::from(c))),
                _ => self.text(&format!("\\X4\\{:08X}\\X0\\", u32::from(c))),
            }
        }
        self.out.push(b'\'');
    }

    /// Begins `#n=`; to be closed with [`Self::end`].
    fn begin(&mut self) -> Id {
        self.last += 1;
        let id = self.last;
        self.id(id);
        self.out.push(b'=');
        id
    }

    fn end(&mut self) {
        self.text(";\n");
    }

    /// A whole entity whose `#` stand for the given ids, in order.
    fn entity(&mut self, template: &str, ids: &[Id]) -> Id {
        let number = self.begin();
        let mut ids = ids.iter();
        for part in template.split_inclusive('#') {
            match (part.strip_suffix('#'), ids.next()) {
                (Some(before), Some(&id)) => {
                    self.text(before);
                    self.id(id);
                }
                _ => self.text(part),
            }
        }
        self.end();
        number
    }
}

// Header, context, product -----------------------------------------------------------------------------------------

impl Writer<'_> {
    fn header(&mut self, options: &CadOptions) {
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
    fn context(&mut self, brep: &Brep, unit: Unit) -> Id {
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
    fn product(&mut self, brep: &Brep, options: &CadOptions, context: Id, shells: &[Id]) {
        let origin = self.point(DVec3::ZERO);
        let (z, x) = (self.direction(DVec3::Z), self.direction(DVec3::X));
        let axes = self.entity("AXIS2_PLACEMENT_3D('',#,#,#)", &[origin, z, x]);
        let solids: Vec<Id> = brep.solids.iter().map(|s| self.solid(s.outer, &s.voids, shells)).collect();
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

    fn representation(&mut self, kind: &str, items: &[Id], axes: Id, context: Id) -> Id {
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

    fn product_definition(&mut self, options: &CadOptions, shape: Id) {
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
    fn solid(&mut self, outer: u32, voids: &[u32], shells: &[Id]) -> Id {
        let outer = shells[outer as usize];
        if voids.is_empty() {
            return self.entity("MANIFOLD_SOLID_BREP('',#)", &[outer]);
        }
        let turned: Vec<Id> =
            voids.iter().map(|&v| self.entity("ORIENTED_CLOSED_SHELL('',*,#,.F.)", &[shells[v as usize]])).collect();
        let id = self.begin();
        self.text("BREP_WITH_VOIDS('',");
        self.id(outer);
        self.out.push(b',');
        self.ids(turned);
        self.out.push(b')');
        self.end();
        id
    }
}

// Topology ---------------------------------------------------------------------------------------------------------

impl Writer<'_> {
    /// Writes everything up to the shells; returns their ids.
    fn topology(&mut self, brep: &Brep, parameter_curves: bool) -> Vec<Id> {
        let surfaces: Vec<Id> = brep.surfaces.iter().map(|s| self.surface(s)).collect();
        let vertices: Vec<Id> = brep.vertices.iter().map(|v| self.vertex(v.point)).collect();
        let on_faces = self.curves_on_faces(brep, &surfaces, parameter_curves);
        let edges: Vec<Id> =
            brep.edges.iter().zip(&on_faces).map(|(edge, curves)| self.edge(edge, &vertices, curves)).collect();
        let mut void = vec![false; brep.shells.len()];
        brep.solids.iter().flat_map(|s| &s.voids).for_each(|&s| void[s as usize] = true);
        let shell = |(shell, turned): (&Shell, bool)| {
            let faces: Vec<Id> = shell
                .faces
                .iter()
                .map(|&f| self.face(&brep.faces[f as usize], &surfaces, &vertices, &edges, turned))
                .collect();
            let id = self.begin();
            self.text(if shell.closed { "CLOSED_SHELL(''," } else { "OPEN_SHELL(''," });
            self.ids(faces);
            self.out.push(b')');
            self.end();
            id
        };
        brep.shells.iter().zip(void).map(shell).collect()
    }

    fn vertex(&mut self, p: DVec3) -> Id {
        let point = self.point(p);
        self.entity("VERTEX_POINT('',#)", &[point])
    }

    /// The PCURVEs of every edge.
    fn curves_on_faces(&mut self, brep: &Brep, surfaces: &[Id], all: bool) -> Vec<Vec<Id>> {
        let mut out = vec![Vec::new(); brep.edges.len()];
        let wanted = |f: &Face| all || needs_parameter_curves(brep, f);
        if !brep.faces.iter().any(wanted) {
            return out;
        }
        let plane = self.entity(
            "(GEOMETRIC_REPRESENTATION_CONTEXT(2)PARAMETRIC_REPRESENTATION_CONTEXT()REPRESENTATION_CONTEXT('',''))",
            &[],
        );
        for face in brep.faces.iter().filter(|f| wanted(f)) {
            let surface = surfaces[face.surface as usize];
            for of in face.loops.iter().flatten().filter(|u| !u.parameters.is_empty()) {
                let curve = self.parameter_curve(brep, of);
                let representation = self.entity("DEFINITIONAL_REPRESENTATION('',(#),#)", &[curve, plane]);
                let on_face = self.entity("PCURVE('',#,#)", &[surface, representation]);
                out[of.edge as usize].push(on_face);
            }
        }
        out
    }

    /// A polyline in the parameter plane, with the same parameter as the edge's curve in space.
    fn parameter_curve(&mut self, brep: &Brep, of: &EdgeUse) -> Id {
        let points: Vec<Id> = of.parameters.iter().map(|&p| self.point_2d(p)).collect();
        let edge = &brep.edges[of.edge as usize];
        let breaks = match &edge.curve {
            Curve::Spline(c) if points.len() > 2 => c.knots().breaks(),
            _ => edge.range.to_vec(),
        };
        let id = self.begin();
        self.text("B_SPLINE_CURVE_WITH_KNOTS('',1,");
        self.ids(points);
        self.text(",.POLYLINE_FORM.,.F.,.F.,");
        let last = breaks.len() - 1;
        self.list(0..=last, |w, k| w.text(if k == 0 || k == last { "2" } else { "1" }));
        self.out.push(b',');
        self.list(&breaks, |w, &t| w.real(t));
        self.text(",.UNSPECIFIED.)");
        self.end();
        id
    }

    fn edge(&mut self, edge: &Edge, vertices: &[Id], on_faces: &[Id]) -> Id {
        let mut curve = self.curve(&edge.curve);
        if !on_faces.is_empty() {
            let id = self.begin();
            self.text("SURFACE_CURVE('',");
            self.id(curve);
            self.out.push(b',');
            self.ids(on_faces.iter().copied());
            self.text(",.CURVE_3D.)");
            self.end();
            curve = id;
        }
        let [a, b] = edge.ends.map(|v| vertices[v as usize]);
        self.entity("EDGE_CURVE('',#,#,#,.T.)", &[a, b, curve])
    }

    /// `turned` writes the face with the opposite normal: its loops, too, then run the other way round.
    fn face(&mut self, face: &Face, surfaces: &[Id], vertices: &[Id], edges: &[Id], turned: bool) -> Id {
        let sense = if turned { ".F.)" } else { ".T.)" };
        let mut bounds = Vec::with_capacity(face.loops.len());
        for (k, uses) in face.loops.iter().enumerate() {
            let oriented: Vec<Id> = uses
                .iter()
                .map(|of| {
                    let sense = if of.reversed { "ORIENTED_EDGE('',*,*,#,.F.)" } else { "ORIENTED_EDGE('',*,*,#,.T.)" };
                    self.entity(sense, &[edges[of.edge as usize]])
                })
                .collect();
            let border = self.begin();
            self.text("EDGE_LOOP('',");
            self.ids(oriented);
            self.out.push(b')');
            self.end();
            let kind = if k == 0 { "FACE_OUTER_BOUND('',#," } else { "FACE_BOUND('',#," };
            bounds.push(self.entity(&format!("{kind}{sense}"), &[border]));
        }
        for &pole in &face.poles {
            let border = self.entity("VERTEX_LOOP('',#)", &[vertices[pole as usize]]);
            bounds.push(self.entity(&format!("FACE_BOUND('',#,{sense}"), &[border]));
        }
        let id = self.begin();
        self.text("ADVANCED_FACE(");
        self.string(&face.name);
        self.out.push(b',');
        self.ids(bounds);
        self.out.push(b',');
        self.id(surfaces[face.surface as usize]);
        self.out.push(b',');
        self.text(if face.same_sense != turned { ".T.)" } else { ".F.)" });
        self.end();
        id
    }
}

// Geometry ---------------------------------------------------------------------------------------------------------

impl Writer<'_> {
    fn coordinates(&mut self, kind: &str, x: &[f64]) -> Id {
        let id = self.begin();
        self.text(kind);
        self.text("('',");
        self.list(x, |w, &x| w.real(x));
        self.out.push(b')');
        self.end();
        id
    }

    /// The entity of a position; the same one wherever that position occurs.
    fn point(&mut self, p: DVec3) -> Id {
        let key = p.to_array().map(f64::to_bits);
        if let Some(&id) = self.points.get(&key) {
            return id;
        }
        let id = self.coordinates("CARTESIAN_POINT", &p.to_array());
        self.points.insert(key, id);
        id
    }

    fn point_2d(&mut self, p: [f64; 2]) -> Id {
        let key = p.map(f64::to_bits);
        if let Some(&id) = self.points_2d.get(&key) {
            return id;
        }
        let id = self.coordinates("CARTESIAN_POINT", &p);
        self.points_2d.insert(key, id);
        id
    }

    fn direction(&mut self, d: DVec3) -> Id {
        self.coordinates("DIRECTION", &d.to_array())
    }

    fn placement(&mut self, frame: &Frame) -> Id {
        let origin = self.point(frame.origin);
        let (z, x) = (self.direction(frame.z), self.direction(frame.x));
        self.entity("AXIS2_PLACEMENT_3D('',#,#,#)", &[origin, z, x])
    }

    /// `KIND('',#placement,number,…)`
    fn placed(&mut self, kind: &str, frame: &Frame, numbers: &[f64]) -> Id {
        let placement = self.placement(frame);
        let id = self.begin();
        self.text(kind);
        self.text("('',");
        self.id(placement);
        for &x in numbers {
            self.out.push(b',');
            self.real(x);
        }
        self.out.push(b')');
        self.end();
        id
    }

    fn curve(&mut self, curve: &Curve) -> Id {
        match curve {
            Curve::Line { origin, direction } => {
                let origin = self.point(*origin);
                let vector = self.vector(*direction);
                self.entity("LINE('',#,#)", &[origin, vector])
            }
            Curve::Circle { frame, radius } => self.placed("CIRCLE", frame, &[*radius]),
            Curve::Ellipse { frame, radii } => self.placed("ELLIPSE", frame, radii),
            Curve::Parabola { frame, focal } => self.placed("PARABOLA", frame, &[*focal]),
            Curve::Hyperbola { frame, radii } => self.placed("HYPERBOLA", frame, radii),
            Curve::Spline(spline) => self.spline_curve(spline),
        }
    }

    fn vector(&mut self, direction: DVec3) -> Id {
        let direction = self.direction(direction);
        self.entity("VECTOR('',#,1.)", &[direction])
    }

    fn spline_curve(&mut self, curve: &BSplineCurve) -> Id {
        let points: Vec<Id> = curve.points().iter().map(|&p| self.point(p)).collect();
        let id = self.begin();
        self.text("B_SPLINE_CURVE_WITH_KNOTS('',");
        push_integer(self.out, curve.knots().degree());
        self.out.push(b',');
        self.ids(points);
        self.text(if curve.knots().degree() == 1 { ",.POLYLINE_FORM." } else { ",.UNSPECIFIED." });
        self.text(",.F.,.F.,");
        self.multiplicities(curve.knots());
        self.out.push(b',');
        self.breaks(curve.knots());
        self.text(",.UNSPECIFIED.)");
        self.end();
        id
    }

    fn surface(&mut self, surface: &Surface) -> Id {
        match surface {
            Surface::Spline(spline) => self.spline_surface(spline),
            Surface::Plane { frame } => self.placed("PLANE", frame, &[]),
            Surface::Cylinder { frame, radius } => self.placed("CYLINDRICAL_SURFACE", frame, &[*radius]),
            Surface::Cone { frame, radius, half_angle } => {
                self.placed("CONICAL_SURFACE", frame, &[*radius, *half_angle])
            }
            Surface::Sphere { frame, radius } => self.placed("SPHERICAL_SURFACE", frame, &[*radius]),
            Surface::Torus { frame, major_radius, minor_radius } => {
                self.placed("TOROIDAL_SURFACE", frame, &[*major_radius, *minor_radius])
            }
            Surface::Extrusion { profile, direction } => {
                let profile = self.curve(profile);
                let vector = self.vector(*direction);
                self.entity("SURFACE_OF_LINEAR_EXTRUSION('',#,#)", &[profile, vector])
            }
            Surface::Revolution { profile, frame } => {
                let profile = self.curve(profile);
                let (origin, z) = (self.point(frame.origin), self.direction(frame.z));
                let axis = self.entity("AXIS1_PLACEMENT('',#,#)", &[origin, z]);
                self.entity("SURFACE_OF_REVOLUTION('',#,#)", &[profile, axis])
            }
        }
    }

    /// The list of control points has u as its outer index.
    fn spline_surface(&mut self, surface: &BSplineSurface) -> Id {
        let [u, v] = surface.knots();
        let points: Vec<Id> = surface.points().iter().map(|&p| self.point(p)).collect();
        let id = self.begin();
        self.text("B_SPLINE_SURFACE_WITH_KNOTS('',");
        push_integer(self.out, u.degree());
        self.out.push(b',');
        push_integer(self.out, v.degree());
        self.out.push(b',');
        self.list(0..u.count(), |w, i| {
            w.text("\n");
            w.ids((0..v.count()).map(|j| points[j * u.count() + i]));
        });
        self.text(",.UNSPECIFIED.,.F.,.F.,.F.,\n");
        self.multiplicities(u);
        self.out.push(b',');
        self.multiplicities(v);
        self.out.push(b',');
        self.breaks(u);
        self.out.push(b',');
        self.breaks(v);
        self.text(",.UNSPECIFIED.)");
        self.end();
        id
    }

    fn multiplicities(&mut self, knots: &Knots) {
        self.list(knots.distinct(), |w, (_, m)| push_integer(w.out, m));
    }

    fn breaks(&mut self, knots: &Knots) {
        self.list(knots.distinct(), |w, (t, _)| w.real(t));
    }
}

#[cfg(test)]
mod tests;
