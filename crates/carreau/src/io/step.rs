//! STEP (ISO 10303-21) files of boundary representations, for the protocols AP214 and AP242.
//!
//! Solids are MANIFOLD_SOLID_BREP or BREP_WITH_VOIDS, shells without a solid are in a SHELL_BASED_SURFACE_MODEL. Points
//! are written once per position and referenced wherever they occur, in control nets too: neighbours then agree exactly,
//! and files are about a third smaller.

use super::cad::{CadOptions, StepSchema, Unit, needs_parameter_curves, push_real, resolution};
use super::text::push_integer;
use crate::error::Result;
use crate::geometry::brep::{Brep, Curve, Edge, EdgeUse, Face, Shell, Surface};
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
        let surfaces: Vec<Id> = brep.faces.iter().map(|f| self.surface(&f.surface)).collect();
        let vertices: Vec<Id> = brep.vertices.iter().map(|&p| self.vertex(p)).collect();
        let on_faces = self.curves_on_faces(brep, &surfaces, parameter_curves);
        let edges: Vec<Id> =
            brep.edges.iter().zip(&on_faces).map(|(edge, curves)| self.edge(brep, edge, &vertices, curves)).collect();
        let mut void = vec![false; brep.shells.len()];
        brep.solids.iter().flat_map(|s| &s.voids).for_each(|&s| void[s as usize] = true);
        let shell = |(shell, turned): (&Shell, bool)| {
            let faces: Vec<Id> = shell
                .faces
                .iter()
                .map(|&f| self.face(&brep.faces[f as usize], surfaces[f as usize], &edges, turned))
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
        let wanted = |f: &Face| all || needs_parameter_curves(f);
        if !brep.faces.iter().any(wanted) {
            return out;
        }
        let plane = self.entity(
            "(GEOMETRIC_REPRESENTATION_CONTEXT(2)PARAMETRIC_REPRESENTATION_CONTEXT()REPRESENTATION_CONTEXT('',''))",
            &[],
        );
        for (face, &surface) in brep.faces.iter().zip(surfaces).filter(|(f, _)| wanted(f)) {
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
            Curve::Spline(c) => c.knots().domain().to_vec(),
            Curve::Line => vec![0.0, length(brep, edge)],
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

    fn edge(&mut self, brep: &Brep, edge: &Edge, vertices: &[Id], on_faces: &[Id]) -> Id {
        let mut curve = match &edge.curve {
            Curve::Line => self.line(brep, edge),
            Curve::Spline(spline) => self.spline_curve(spline),
        };
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
    fn face(&mut self, face: &Face, surface: Id, edges: &[Id], turned: bool) -> Id {
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
        let id = self.begin();
        self.text("ADVANCED_FACE('',");
        self.ids(bounds);
        self.out.push(b',');
        self.id(surface);
        self.out.push(b',');
        self.text(sense);
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

    fn line(&mut self, brep: &Brep, edge: &Edge) -> Id {
        let [a, b] = edge.ends.map(|v| brep.vertices[v as usize]);
        let origin = self.point(a);
        let direction = self.direction((b - a).normalize_or(DVec3::X));
        let vector = self.begin();
        self.text("VECTOR('',");
        self.id(direction);
        self.text(",1.)");
        self.end();
        self.entity("LINE('',#,#)", &[origin, vector])
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
            Surface::Plane { origin, normal, axis } => {
                let origin = self.point(*origin);
                let (z, x) = (self.direction(*normal), self.direction(*axis));
                let axes = self.entity("AXIS2_PLACEMENT_3D('',#,#,#)", &[origin, z, x]);
                self.entity("PLANE('',#)", &[axes])
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

fn length(brep: &Brep, edge: &Edge) -> f64 {
    let [a, b] = edge.ends.map(|v| brep.vertices[v as usize]);
    a.distance(b)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::context::Context;
    use crate::patch::cad::models::{self, Model};
    use crate::patch::cad::{BrepOptions, Fit, to_brep};
    use std::collections::BTreeMap;

    /// A value of a part 21 file.
    #[derive(Debug, Clone, PartialEq)]
    enum Value {
        Reference(u32),
        Number(f64),
        Text(String),
        /// `.T.`, `$`, `*`
        Word(String),
        List(Vec<Value>),
        /// `NAME(…)`
        Typed(String, Vec<Value>),
    }

    /// Reads the small part of the syntax that there is.
    struct Parser<'a>(&'a [u8]);

    impl Parser<'_> {
        fn next(&mut self) -> u8 {
            while self.0[0].is_ascii_whitespace() {
                self.0 = &self.0[1..];
            }
            self.0[0]
        }

        fn take(&mut self, c: u8) {
            assert_eq!(self.next() as char, c as char);
            self.0 = &self.0[1..];
        }

        fn word(&mut self) -> String {
            let end = self.0.iter().position(|b| b",();=".contains(b) || b.is_ascii_whitespace()).unwrap();
            let (word, rest) = self.0.split_at(end);
            self.0 = rest;
            String::from_utf8(word.to_vec()).unwrap()
        }

        fn list(&mut self) -> Vec<Value> {
            let mut out = Vec::new();
            self.take(b'(');
            while self.next() != b')' {
                out.push(self.value());
                if self.next() == b',' {
                    self.take(b',');
                }
            }
            self.take(b')');
            out
        }

        fn value(&mut self) -> Value {
            match self.next() {
                b'#' => {
                    self.take(b'#');
                    Value::Reference(self.word().parse().unwrap())
                }
                b'\'' => {
                    let mut end = 1;
                    while self.0[end] != b'\'' || self.0[end + 1] == b'\'' {
                        end += if self.0[end] == b'\'' { 2 } else { 1 };
                    }
                    let text = String::from_utf8(self.0[1..end].to_vec()).unwrap();
                    self.0 = &self.0[end + 1..];
                    Value::Text(text)
                }
                b'(' => Value::List(self.list()),
                b'-' | b'0'..=b'9' => {
                    let word = self.word();
                    let number = word.parse().unwrap();
                    // Integers have no point, reals must have one.
                    assert!(word.contains('.') || word.parse::<u32>().is_ok(), "{word}");
                    Value::Number(number)
                }
                _ => {
                    let word = self.word();
                    if self.0[0] == b'(' { Value::Typed(word, self.list()) } else { Value::Word(word) }
                }
            }
        }
    }

    type Entities = BTreeMap<u32, Vec<Value>>;

    /// All entities by number, each a list of `Typed` (several for a complex one).
    fn parse(file: &[u8]) -> Entities {
        let text = std::str::from_utf8(file).unwrap();
        assert!(text.is_ascii() && text.starts_with("ISO-10303-21;\nHEADER;"));
        let (_, data) = text.split_once("DATA;\n").unwrap();
        let data = data.strip_suffix("ENDSEC;\nEND-ISO-10303-21;\n").unwrap();
        let mut parser = Parser(data.as_bytes());
        let mut out = Entities::new();
        while !parser.0.is_empty() {
            parser.take(b'#');
            let id: u32 = parser.word().parse().unwrap();
            parser.take(b'=');
            let parts = if parser.next() == b'(' {
                // `(A()B())`: no commas between.
                parser.take(b'(');
                let mut parts = Vec::new();
                while parser.next() != b')' {
                    parts.push(parser.value());
                }
                parser.take(b')');
                parts
            } else {
                vec![parser.value()]
            };
            parser.take(b';');
            assert!(parts.iter().all(|p| matches!(p, Value::Typed(..))));
            assert!(out.insert(id, parts).is_none(), "#{id} twice");
            parser.0 = parser.0.trim_ascii_start();
        }
        out
    }

    fn references(values: &[Value], out: &mut Vec<u32>) {
        for v in values {
            match v {
                Value::Reference(id) => out.push(*id),
                Value::List(list) | Value::Typed(_, list) => references(list, out),
                _ => {}
            }
        }
    }

    fn of_kind<'a>(entities: &'a Entities, kind: &str) -> Vec<&'a [Value]> {
        let only = |parts: &'a Vec<Value>| match &parts[..] {
            [Value::Typed(name, args)] if name == kind => Some(&args[..]),
            _ => None,
        };
        entities.values().filter_map(only).collect()
    }

    fn point(entities: &Entities, id: &Value) -> Vec<f64> {
        let Value::Reference(id) = id else { panic!("{id:?}") };
        let [Value::Typed(kind, args)] = &entities[id][..] else { panic!() };
        assert_eq!(kind, "CARTESIAN_POINT");
        numbers(&args[1])
    }

    fn numbers(list: &Value) -> Vec<f64> {
        let Value::List(list) = list else { panic!("{list:?}") };
        list.iter().map(|v| if let Value::Number(x) = v { *x } else { panic!("{v:?}") }).collect()
    }

    fn expanded(multiplicities: &Value, breaks: &Value) -> Vec<f64> {
        let pairs = numbers(multiplicities).into_iter().zip(numbers(breaks));
        pairs.flat_map(|(m, t)| std::iter::repeat_n(t, m as usize)).collect()
    }

    fn brep(model: &Model, fit: Fit) -> Brep {
        let options = BrepOptions { fit, ..Default::default() };
        to_brep(&model.mesh(), &model.patches, &model.leftover, &options, &Context::new()).unwrap().brep
    }

    fn file(brep: &Brep, options: &CadOptions) -> Vec<u8> {
        let mut out = Vec::new();
        write(brep, options, &mut out).unwrap();
        out
    }

    #[test]
    fn files_are_well_formed_and_have_every_surface_bit_for_bit() {
        for (name, model) in models::all() {
            for (fit, parameter_curves) in [(Fit::Bilinear, false), (Fit::Bilinear, true), (Fit::Bicubic, true)] {
                let brep = brep(&model, fit);
                let options = CadOptions { parameter_curves, ..Default::default() };
                let entities = parse(&file(&brep, &options));
                let mut used = Vec::new();
                entities.values().for_each(|parts| references(parts, &mut used));
                assert!(used.iter().all(|id| entities.contains_key(id)), "{name}: an entity is missing");
                let count = |kind: &str| of_kind(&entities, kind).len();
                assert_eq!(count("ADVANCED_FACE"), brep.faces.len());
                assert_eq!(count("EDGE_CURVE"), brep.edges.len());
                assert_eq!(count("VERTEX_POINT"), brep.vertices.len());
                assert_eq!(count("CLOSED_SHELL") + count("OPEN_SHELL"), brep.shells.len());
                assert_eq!(count("MANIFOLD_SOLID_BREP") + count("BREP_WITH_VOIDS"), brep.solids.len());
                let voids = brep.solids.iter().map(|s| s.voids.len()).sum::<usize>();
                assert_eq!(count("ORIENTED_CLOSED_SHELL"), voids);
                // A plane has no parameters that its edges could need.
                let wanted = |f: &Face| {
                    matches!(f.surface, Surface::Spline(_)) && (parameter_curves || needs_parameter_curves(f))
                };
                assert_eq!(count("PCURVE") > 0, brep.faces.iter().any(wanted));
                assert_surfaces(&brep, &entities);
            }
        }
    }

    fn assert_surfaces(brep: &Brep, entities: &Entities) {
        let splines =
            brep.faces.iter().filter_map(|f| if let Surface::Spline(s) = &f.surface { Some(s) } else { None });
        let written = of_kind(entities, "B_SPLINE_SURFACE_WITH_KNOTS");
        assert_eq!(splines.clone().count(), written.len());
        for (s, args) in splines.zip(written) {
            let [u, v] = s.knots();
            assert_eq!(args[1..3], [u.degree(), v.degree()].map(|d| Value::Number(d as f64)));
            let Value::List(columns) = &args[3] else { panic!() };
            for (i, column) in columns.iter().enumerate() {
                let Value::List(column) = column else { panic!() };
                for (j, id) in column.iter().enumerate() {
                    let same = point(entities, id)
                        .iter()
                        .zip(s.control(i, j).to_array())
                        .all(|(a, b)| a.to_bits() == b.to_bits());
                    assert!(same);
                }
            }
            assert_eq!(expanded(&args[8], &args[10]), u.values());
            assert_eq!(expanded(&args[9], &args[11]), v.values());
        }
    }

    #[test]
    fn faces_of_voids_are_turned() {
        let hollow = models::all().into_iter().find(|(n, _)| *n == "hollow").unwrap().1;
        let entities = parse(&file(&brep(&hollow, Fit::Bilinear), &CadOptions::default()));
        let turned = |args: &&&[Value]| args[3] == Value::Word(".F.".into());
        assert_eq!(of_kind(&entities, "ADVANCED_FACE").iter().filter(turned).count(), 6);
        assert_eq!(of_kind(&entities, "ORIENTED_CLOSED_SHELL")[0][3], Value::Word(".F.".into()));
    }

    #[test]
    fn units_schemas_and_names() {
        let (_, model) = models::all().swap_remove(0);
        let brep = brep(&model, Fit::Bilinear);
        let with = |change: &dyn Fn(&mut CadOptions)| {
            let mut options = CadOptions::default();
            change(&mut options);
            String::from_utf8(file(&brep, &options)).unwrap()
        };
        assert!(with(&|_| {}).contains("SI_UNIT(.MILLI.,.METRE.)"));
        assert!(with(&|o| o.unit = Unit::Metre).contains("SI_UNIT($,.METRE.)"));
        assert!(with(&|o| o.unit = Unit::Centimetre).contains("SI_UNIT(.CENTI.,.METRE.)"));
        assert!(with(&|o| o.unit = Unit::Inch).contains("CONVERSION_BASED_UNIT('INCH'"));
        assert!(with(&|o| o.schema = StepSchema::Ap214).contains("AUTOMOTIVE_DESIGN"));
        assert!(with(&|o| o.schema = StepSchema::Ap242).contains("AP242_MANAGED_MODEL_BASED_3D_ENGINEERING_MIM_LF"));
        let named = with(&|o| o.name = "O'Neil \\ é 🦀\n".into());
        parse(named.as_bytes());
        assert!(named.contains("PRODUCT('O''Neil \\\\ \\X2\\00E9\\X0\\ \\X4\\0001F980\\X0\\\\X2\\000A\\X0\\'"));
        assert!(write(&brep, &CadOptions { date: "yesterday".into(), ..Default::default() }, &mut Vec::new()).is_err());
    }

    #[test]
    fn an_empty_model_is_a_valid_file() {
        parse(&file(&Brep::default(), &CadOptions::default()));
    }
}
