use super::*;
use crate::brep::{Curve, CurveKind, Face, Surface, SurfaceKind, models as solids};
use crate::context::Context;
use crate::io::cad::{StepSchema, Unit, needs_parameter_curves};
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
                matches!(brep.surface(f), Surface::Spline(_)) && (parameter_curves || needs_parameter_curves(&brep, f))
            };
            assert_eq!(count("PCURVE") > 0, brep.faces.iter().any(wanted));
            assert_surfaces(&brep, &entities);
        }
    }
}

fn assert_surfaces(brep: &Brep, entities: &Entities) {
    let splines = brep.surfaces.iter().filter_map(|s| if let Surface::Spline(s) = s { Some(s) } else { None });
    let written = of_kind(entities, "B_SPLINE_SURFACE_WITH_KNOTS");
    assert_eq!(splines.clone().count(), written.len());
    for (s, args) in splines.zip(written) {
        let [u, v] = s.knots();
        assert_eq!(args[1..3], [u.degree(), v.degree()].map(|d| Value::Number(d as f64)));
        let Value::List(columns) = &args[3] else { panic!() };
        for (i, column) in columns.iter().enumerate() {
            let Value::List(column) = column else { panic!() };
            for (j, id) in column.iter().enumerate() {
                let same =
                    point(entities, id).iter().zip(s.control(i, j).to_array()).all(|(a, b)| a.to_bits() == b.to_bits());
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

/// The entity that a kind of surface or curve is written as.
fn surface_entity(kind: SurfaceKind) -> &'static str {
    match kind {
        SurfaceKind::Plane => "PLANE",
        SurfaceKind::Cylinder => "CYLINDRICAL_SURFACE",
        SurfaceKind::Cone => "CONICAL_SURFACE",
        SurfaceKind::Sphere => "SPHERICAL_SURFACE",
        SurfaceKind::Torus => "TOROIDAL_SURFACE",
        SurfaceKind::Extrusion => "SURFACE_OF_LINEAR_EXTRUSION",
        SurfaceKind::Revolution => "SURFACE_OF_REVOLUTION",
        SurfaceKind::Spline => "B_SPLINE_SURFACE_WITH_KNOTS",
    }
}

fn curve_entity(kind: CurveKind) -> &'static str {
    match kind {
        CurveKind::Line => "LINE",
        CurveKind::Circle => "CIRCLE",
        CurveKind::Ellipse => "ELLIPSE",
        CurveKind::Parabola => "PARABOLA",
        CurveKind::Hyperbola => "HYPERBOLA",
        CurveKind::Spline => "B_SPLINE_CURVE_WITH_KNOTS",
    }
}

#[test]
fn every_kind_of_surface_and_curve_is_written_with_its_numbers() {
    for (name, brep, volume) in solids::all() {
        let bytes = file(&brep, &CadOptions { schema: StepSchema::Ap242, ..Default::default() });
        if let Some(folder) = std::env::var_os("CARREAU_WRITE_MODELS") {
            // For other programs to read.
            let folder = std::path::PathBuf::from(folder);
            std::fs::write(folder.join(format!("{name}.step")), &bytes).unwrap();
            let volumes = folder.join("volumes.txt");
            let before = std::fs::read_to_string(&volumes).unwrap_or_default();
            std::fs::write(volumes, format!("{before}{name} {volume}\n")).unwrap();
        }
        let entities = parse(&bytes);
        let mut used = Vec::new();
        entities.values().for_each(|parts| references(parts, &mut used));
        assert!(used.iter().all(|id| entities.contains_key(id)), "{name}: an entity is missing");
        for kind in SurfaceKind::ALL {
            let of = brep.surfaces.iter().filter(|s| s.kind() == kind).count();
            assert_eq!(of_kind(&entities, surface_entity(kind)).len(), of, "{name} {}", kind.name());
        }
        for edge in &brep.edges {
            let kind = edge.curve.kind();
            let of = brep.edges.iter().filter(|e| e.curve.kind() == kind).count();
            let profiles = brep.surfaces.iter().filter(|s| {
                matches!(s, Surface::Extrusion { profile, .. } | Surface::Revolution { profile, .. } if profile.kind() == kind)
            });
            assert_eq!(of_kind(&entities, curve_entity(kind)).len(), of + profiles.count(), "{name} {}", kind.name());
            if let Curve::Circle { radius, .. } = edge.curve {
                let radii = of_kind(&entities, "CIRCLE").iter().map(|args| args[2].clone()).collect::<Vec<_>>();
                assert!(radii.contains(&Value::Number(radius)));
            }
        }
        for face in &brep.faces {
            let named = |args: &&[Value]| args[0] == Value::Text(face.name.clone());
            assert!(of_kind(&entities, "ADVANCED_FACE").iter().any(named), "{name}: {}", face.name);
        }
        assert_eq!(of_kind(&entities, "STYLED_ITEM").len(), brep.faces.len());
        assert_eq!(of_kind(&entities, "COLOUR_RGB").len(), 1);
        let poles = brep.faces.iter().map(|f| f.poles.len()).sum::<usize>();
        assert_eq!(of_kind(&entities, "VERTEX_LOOP").len(), poles);
    }
}
