//! IGES 5.3 files of boundary representations, as surfaces: the format's common subset has no shells.
//!
//! A whole patch is an untrimmed 128 (rational B-spline surface with unit weights). Trimmed faces are 144 → 142 → 102 of
//! 110 and 126, plane faces 144 on 108. Systems that need a closed body sew the faces, which agree on their borders.
//!
//! Records have 80 columns; the last eight are the section's letter and the number of the record:
//!
//! ```text
//! S text                                                                  S      1
//! G delimiters, names, precision, unit, date, resolution                  G      1
//! D      128       1       0 …two records of ten fields of eight columns  D      1
//! P 128,3,2,1,1,0,0,1,0,0,0.,…;                           (65–72: D no.) 1P      1
//! T S      1G      3D      2P      7                                      T      1
//! ```

use super::cad::{CadOptions, Unit, needs_parameter_curves, push_real, resolution};
use super::text::push_integer;
use crate::brep::{Brep, Curve, Edge, EdgeUse, Face, Surface};
use crate::error::{Error, Result};
use crate::geometry::bspline::{BSplineSurface, Knots};
use glam::DVec3;

/// Appends the file's bytes.
pub fn write(brep: &Brep, options: &CadOptions, out: &mut Vec<u8>) -> Result<()> {
    options.check()?;
    let mut writer = Writer::default();
    for face in &brep.faces {
        writer.face(brep, face)?;
    }
    if writer.directory_lines > MAX_LINES || writer.parameter_lines > MAX_LINES {
        return Err(Error::input(
            format!("the model needs more than {MAX_LINES} records, which IGES cannot number"),
            "",
            "write STEP instead",
        ));
    }
    let start = push_lines(out, b'S', &[format!("{} written by carreau {}", ascii(&options.name), VERSION)]);
    let global = push_lines(out, b'G', &global_fields(brep, options));
    out.extend_from_slice(&writer.directory);
    out.extend_from_slice(&writer.parameters);
    let counts = format!("S{start:>7}G{global:>7}D{:>7}P{:>7}", writer.directory_lines, writer.parameter_lines);
    out.extend_from_slice(format!("{counts:<72}T{:>7}\n", 1).as_bytes());
    Ok(())
}

const VERSION: &str = env!("CARGO_PKG_VERSION");
/// Sequence numbers have seven digits.
const MAX_LINES: u32 = 9_999_999;
/// Columns of data in a record of the parameter section.
const WIDTH: usize = 64;

/// Status numbers: blank, subordinate, use, hierarchy; two digits each.
const INDEPENDENT: &str = "00000000";
const DEPENDENT: &str = "00010000";
const PARAMETRIC: &str = "00010500";

// Start and global section -----------------------------------------------------------------------------------------

fn ascii(text: &str) -> String {
    text.chars().map(|c| if (' '..='~').contains(&c) { c } else { '?' }).take(60).collect()
}

/// `4Htext`
fn hollerith(text: &str) -> String {
    let text = ascii(text);
    format!("{}H{text}", text.len())
}

fn real(x: f64) -> String {
    let mut text = Vec::new();
    push_real(&mut text, x, b'D');
    String::from_utf8_lossy(&text).into_owned()
}

/// The 26 fields of the global section, each with its delimiter (section 2.2.4.3).
fn global_fields(brep: &Brep, options: &CadOptions) -> Vec<String> {
    let (flag, unit) = match options.unit {
        Unit::Inch => (1, "IN"),
        Unit::Millimetre => (2, "MM"),
        Unit::Metre => (6, "M"),
        Unit::Centimetre => (10, "CM"),
    };
    let digits: String = options.date.chars().filter(char::is_ascii_digit).collect();
    let date = hollerith(&format!("{}.{}", &digits[..8.min(digits.len())], &digits[8.min(digits.len())..]));
    let [low, high] = brep.bounds();
    let name = hollerith(&options.name);
    let system = hollerith(&format!("carreau {VERSION}"));
    let mut fields: Vec<String> = vec!["1H,".into(), "1H;".into(), name.clone(), name.clone(), system.clone(), system];
    fields.extend(["32", "38", "6", "308", "15"].map(String::from));
    fields.extend([name, "1.".into(), flag.to_string(), hollerith(unit), "1".into(), "0.".into(), date.clone()]);
    fields.extend([real(resolution(brep)), real(low.abs().max(high.abs()).max_element())]);
    fields.extend(["", "", "11", "0"].map(String::from));
    fields.extend([date, String::new()]);
    let last = fields.len() - 1;
    fields.iter_mut().enumerate().for_each(|(k, f)| f.push(if k == last { ';' } else { ',' }));
    fields
}

/// Records of 72 columns of free text; fields are kept whole where they fit a record. Returns the number of records.
fn push_lines(out: &mut Vec<u8>, section: u8, fields: &[String]) -> u32 {
    let mut lines: Vec<String> = vec![String::new()];
    for field in fields {
        let mut rest = field.as_str();
        let last = lines.len() - 1;
        if lines[last].len() + rest.len() > 72 && !lines[last].is_empty() {
            lines.push(String::new());
        }
        while rest.len() > 72 {
            let (head, tail) = rest.split_at(72);
            lines.insert(lines.len() - 1, head.into());
            rest = tail;
        }
        let last = lines.len() - 1;
        lines[last].push_str(rest);
    }
    for (k, line) in lines.iter().enumerate() {
        out.extend_from_slice(format!("{line:<72}{}{:>7}\n", char::from(section), k + 1).as_bytes());
    }
    lines.len() as u32
}

// Directory and parameter section ------------------------------------------------------------------------------------

/// The directory and the parameter section under construction. An entity is named by its first directory record.
#[derive(Default)]
struct Writer {
    directory: Vec<u8>,
    directory_lines: u32,
    parameters: Vec<u8>,
    parameter_lines: u32,
    /// Columns used in the current parameter record.
    column: usize,
    field: Vec<u8>,
}

type Entity = u32;

impl Writer {
    /// Writes one entity whose parameters are pushed by `fill`.
    fn entity(&mut self, kind: u32, status: &str, fill: impl FnOnce(&mut Self)) -> Entity {
        let first = self.parameter_lines;
        let id = self.directory_lines + 1;
        self.column = 0;
        self.integer(kind);
        fill(self);
        // The delimiter after the last parameter ends the entity.
        if let Some(last) = self.parameters.last_mut() {
            *last = b';';
        }
        self.end_record();
        let lines = self.parameter_lines - first;
        let record = format!(
            "{kind:>8}{:>8}{:>8}{:>8}{:>8}{:>8}{:>8}{:>8}{status}D{id:>7}\n\
             {kind:>8}{:>8}{:>8}{lines:>8}{:>8}{:>8}{:>8}{:>8}{:>8}D{:>7}\n",
            first + 1,
            0,
            0,
            0,
            0,
            0,
            0,
            0,
            0,
            0,
            "",
            "",
            "",
            0,
            id + 1
        );
        self.directory.extend_from_slice(record.as_bytes());
        self.directory_lines += 2;
        id
    }

    /// Pads the record and writes its number and that of its entity.
    fn end_record(&mut self) {
        let blanks = WIDTH - self.column;
        self.parameters.extend(std::iter::repeat_n(b' ', blanks));
        self.parameter_lines += 1;
        let tail = format!("{:>8}P{:>7}\n", self.directory_lines + 1, self.parameter_lines);
        self.parameters.extend_from_slice(tail.as_bytes());
        self.column = 0;
    }

    /// Moves the field that was prepared, with its delimiter, into the parameters; fields are never broken.
    fn push_field(&mut self) {
        self.field.push(b',');
        if self.column + self.field.len() > WIDTH {
            self.end_record();
        }
        self.parameters.extend_from_slice(&self.field);
        self.column += self.field.len();
        self.field.clear();
    }

    fn integer(&mut self, k: u32) {
        push_integer(&mut self.field, k);
        self.push_field();
    }

    fn integers(&mut self, list: impl IntoIterator<Item = u32>) {
        list.into_iter().for_each(|k| self.integer(k));
    }

    fn real(&mut self, x: f64) {
        push_real(&mut self.field, x, b'D');
        self.push_field();
    }

    fn reals(&mut self, list: impl IntoIterator<Item = f64>) {
        list.into_iter().for_each(|x| self.real(x));
    }

    fn point(&mut self, p: DVec3) {
        self.reals(p.to_array());
    }
}

// Entities ---------------------------------------------------------------------------------------------------------

impl Writer {
    fn face(&mut self, brep: &Brep, face: &Face) -> Result<()> {
        let surface = match brep.surface(face) {
            Surface::Spline(spline) if !needs_parameter_curves(brep, face) => {
                self.spline_surface(spline, INDEPENDENT);
                return Ok(());
            }
            Surface::Spline(spline) => self.spline_surface(spline, DEPENDENT),
            Surface::Plane { frame } => self.plane(frame.origin, frame.z),
            other => return Err(Error::Bug(format!("IGES: a {}", other.kind().name()))),
        };
        let loops: Vec<Entity> = face.loops.iter().map(|uses| self.boundary(brep, surface, uses)).collect();
        self.entity(144, INDEPENDENT, |w| {
            // Surface, "the first loop is the outer one", number of holes, loops.
            w.integers([surface, 1, loops.len().saturating_sub(1) as u32]);
            w.integers(loops);
        });
        Ok(())
    }

    /// 108: A x + B y + C z = D, unbounded.
    fn plane(&mut self, origin: DVec3, normal: DVec3) -> Entity {
        self.entity(108, DEPENDENT, |w| {
            w.point(normal);
            w.real(normal.dot(origin));
            w.integer(0);
            w.point(origin);
            w.real(0.0);
        })
    }

    /// 128, control points with u fastest.
    fn spline_surface(&mut self, surface: &BSplineSurface, status: &str) -> Entity {
        let [u, v] = surface.knots();
        self.entity(128, status, |w| {
            w.integers([u.count() - 1, v.count() - 1, u.degree(), v.degree()].map(|k| k as u32));
            w.integers([0, 0, 1, 0, 0]);
            w.reals(u.values().iter().chain(v.values()).copied());
            w.reals(std::iter::repeat_n(1.0, surface.points().len()));
            surface.points().iter().for_each(|&p| w.point(p));
            w.reals([u, v].into_iter().flat_map(Knots::domain));
        })
    }

    /// 142: a loop on a surface, as a curve in its parameter plane where there is one, and as a curve in space.
    fn boundary(&mut self, brep: &Brep, surface: Entity, uses: &[EdgeUse]) -> Entity {
        let flat: Vec<Entity> = uses.iter().filter_map(|of| self.parameter_curve(brep, of)).collect();
        let flat = if flat.is_empty() { 0 } else { self.composite(&flat, PARAMETRIC) };
        let space: Vec<Entity> =
            uses.iter().map(|of| self.curve(&brep.edges[of.edge as usize], of.reversed, brep)).collect();
        let space = self.composite(&space, DEPENDENT);
        // Created in an unspecified way; the curve in space is preferred where there is no other, else both are equal.
        let preferred = if flat == 0 { 2 } else { 3 };
        self.entity(142, DEPENDENT, |w| w.integers([0, surface, flat, space, preferred]))
    }

    /// 102: curves end to end.
    fn composite(&mut self, curves: &[Entity], status: &str) -> Entity {
        self.entity(102, status, |w| {
            w.integer(curves.len() as u32);
            w.integers(curves.iter().copied());
        })
    }

    fn curve(&mut self, edge: &Edge, reversed: bool, brep: &Brep) -> Entity {
        match &edge.curve {
            Curve::Line { .. } => {
                let [a, b] = edge.ends.map(|v| brep.point(v));
                self.line(if reversed { [b, a] } else { [a, b] }, DEPENDENT)
            }
            Curve::Spline(spline) if reversed => {
                let back = spline.reversed();
                self.spline_curve(back.knots(), back.points(), DEPENDENT)
            }
            Curve::Spline(spline) => self.spline_curve(spline.knots(), spline.points(), DEPENDENT),
            _ => 0,
        }
    }

    fn parameter_curve(&mut self, brep: &Brep, of: &EdgeUse) -> Option<Entity> {
        let mut points: Vec<DVec3> = of.parameters.iter().map(|&[u, v]| DVec3::new(u, v, 0.0)).collect();
        if of.reversed {
            points.reverse();
        }
        match (&points[..], &brep.edges[of.edge as usize].curve) {
            ([], _) => None,
            (&[a, b], _) => Some(self.line([a, b], PARAMETRIC)),
            // A point at every knot of the edge.
            (_, Curve::Spline(c)) => {
                let breaks = if of.reversed { c.reversed().knots().breaks() } else { c.knots().breaks() };
                let knots = Knots::from_breaks(1, &breaks, 1).ok()?;
                Some(self.spline_curve(&knots, &points, PARAMETRIC))
            }
            _ => None,
        }
    }

    /// 110
    fn line(&mut self, ends: [DVec3; 2], status: &str) -> Entity {
        self.entity(110, status, |w| ends.into_iter().for_each(|p| w.point(p)))
    }

    /// 126
    fn spline_curve(&mut self, knots: &Knots, points: &[DVec3], status: &str) -> Entity {
        let flat = u32::from(status == PARAMETRIC);
        self.entity(126, status, |w| {
            w.integers([points.len() as u32 - 1, knots.degree() as u32, flat, 0, 1, 0]);
            w.reals(knots.values().iter().copied());
            w.reals(std::iter::repeat_n(1.0, points.len()));
            points.iter().for_each(|&p| w.point(p));
            w.reals(knots.domain());
            w.reals([0.0, 0.0, f64::from(flat)]);
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::context::Context;
    use crate::patch::cad::models::{self, Model};
    use crate::patch::cad::{BrepOptions, Fit, QuadCell, QuadPolygon, to_brep, to_trimmed_brep};
    use std::collections::BTreeMap;

    /// An entity as read back: type, status, parameters.
    struct Read {
        kind: u32,
        status: String,
        parameters: Vec<String>,
    }

    /// Checks every record's columns and numbers, and reads the entities by their first directory record.
    fn parse(file: &[u8]) -> (String, BTreeMap<u32, Read>) {
        let text = std::str::from_utf8(file).unwrap();
        assert!(text.is_ascii() && text.ends_with('\n'));
        let mut sections: BTreeMap<char, Vec<&str>> = BTreeMap::new();
        let mut order = String::new();
        for line in text.lines() {
            assert_eq!(line.len(), 80, "{line}");
            let section = line.as_bytes()[72] as char;
            if !order.ends_with(section) {
                order.push(section);
            }
            let lines = sections.entry(section).or_default();
            lines.push(&line[..72]);
            assert_eq!(line[73..].trim().parse::<usize>().unwrap(), lines.len(), "{line}");
        }
        assert!(["SGDPT", "SGT"].contains(&order.as_str()), "{order}");
        let none = Vec::new();
        let lines = |c: char| sections.get(&c).unwrap_or(&none);
        let counts: String = "SGDP".chars().map(|c| format!("{c}{:>7}", lines(c).len())).collect();
        assert_eq!(sections[&'T'], [format!("{counts:<72}")]);
        let mut out = BTreeMap::new();
        let mut expected = 1;
        for (k, pair) in lines('D').chunks(2).enumerate() {
            let field = |line: usize, f: usize| pair[line][8 * f..8 * f + 8].trim().to_string();
            let number = |line: usize, f: usize| field(line, f).parse::<usize>().unwrap();
            assert_eq!(field(0, 0), field(1, 0));
            let (first, count) = (number(0, 1), number(1, 3));
            assert_eq!(first, expected);
            expected += count;
            let id = 2 * k as u32 + 1;
            let mut data = String::new();
            for line in &lines('P')[first - 1..first - 1 + count] {
                assert_eq!(line[64..].trim().parse::<u32>().unwrap(), id);
                data.push_str(line[..64].trim_end());
            }
            let data = data.strip_suffix(';').unwrap();
            assert!(!data.contains(';'));
            let mut parameters: Vec<String> = data.split(',').map(String::from).collect();
            assert_eq!(parameters.remove(0), field(0, 0));
            let kind = field(0, 0).parse().unwrap();
            out.insert(id, Read { kind, status: pair[0][64..72].to_string(), parameters });
        }
        assert_eq!(expected, lines('P').len() + 1);
        (lines('G').iter().map(|l| l.trim_end()).collect(), out)
    }

    fn real(text: &str) -> f64 {
        assert!(text.contains('.'), "{text} has no decimal point");
        text.replace('D', "e").parse().unwrap()
    }

    fn integer(text: &str) -> u32 {
        text.parse().unwrap()
    }

    /// The entities that an entity points to.
    fn pointers(e: &Read) -> Vec<u32> {
        let p: Vec<u32> = e.parameters.iter().take_while(|p| !p.contains('.')).map(|p| integer(p)).collect();
        match e.kind {
            144 => [p[0]].into_iter().chain(p[3..].iter().copied()).collect(),
            142 => p[1..4].iter().copied().filter(|&k| k != 0).collect(),
            102 => p[1..].to_vec(),
            _ => Vec::new(),
        }
    }

    fn assert_file(brep: &Brep) -> BTreeMap<u32, Read> {
        let mut file = Vec::new();
        write(brep, &CadOptions::default(), &mut file).unwrap();
        let (_, entities) = parse(&file);
        let dependents: Vec<u32> = entities.values().flat_map(pointers).collect();
        for (id, e) in &entities {
            let used = dependents.iter().filter(|d| *d == id).count();
            assert_eq!(used > 0, &e.status[2..4] == "01", "status of {} {id}", e.kind);
            assert!(used <= 1 || e.kind == 108 || e.kind == 128, "{} {id} used {used} times", e.kind);
        }
        assert!(dependents.iter().all(|d| entities.contains_key(d)));
        // Curves in the parameter plane, and only those, say so.
        for e in entities.values().filter(|e| e.kind == 142) {
            let flat = integer(&e.parameters[2]);
            let marked = |k: u32| {
                &entities[&k].status[4..6] == "05"
                    && pointers(&entities[&k]).iter().all(|c| &entities[c].status[4..6] == "05")
            };
            assert!(flat == 0 || marked(flat));
            assert!(!marked(integer(&e.parameters[3])));
        }
        assert_surfaces(brep, &entities);
        entities
    }

    fn assert_surfaces(brep: &Brep, entities: &BTreeMap<u32, Read>) {
        let written: Vec<&Read> = entities.values().filter(|e| e.kind == 128).collect();
        let splines: Vec<&BSplineSurface> = brep
            .faces
            .iter()
            .filter_map(|f| if let Surface::Spline(s) = brep.surface(f) { Some(s) } else { None })
            .collect();
        assert_eq!(written.len(), splines.len());
        for (e, s) in written.into_iter().zip(splines) {
            let [u, v] = s.knots();
            let head: Vec<u32> = e.parameters[..9].iter().map(|p| integer(p)).collect();
            let sizes = [u.count() - 1, v.count() - 1, u.degree(), v.degree()].map(|k| k as u32);
            assert_eq!(head, [&sizes[..], &[0, 0, 1, 0, 0]].concat());
            let reals: Vec<f64> = e.parameters[9..].iter().map(|p| real(p)).collect();
            let (knots, rest) = reals.split_at(u.values().len() + v.values().len());
            assert_eq!(knots, [u.values(), v.values()].concat());
            let (weights, rest) = rest.split_at(s.points().len());
            assert!(weights.iter().all(|&w| w == 1.0));
            let (points, domain) = rest.split_at(3 * s.points().len());
            let want: Vec<u64> = s.points().iter().flat_map(|p| p.to_array()).map(f64::to_bits).collect();
            assert_eq!(points.iter().map(|x| x.to_bits()).collect::<Vec<_>>(), want);
            assert_eq!(domain, [u.domain(), v.domain()].concat());
        }
    }

    fn brep(model: &Model, fit: Fit) -> Brep {
        let options = BrepOptions { fit, ..Default::default() };
        to_brep(&model.mesh(), &model.patches, &model.leftover, &options, &Context::new()).unwrap().brep
    }

    #[test]
    fn files_are_well_formed_and_have_every_surface_bit_for_bit() {
        for (name, model) in models::all() {
            for fit in [Fit::Bilinear, Fit::Bicubic] {
                let brep = brep(&model, fit);
                let entities = assert_file(&brep);
                let faces = entities.values().filter(|e| &e.status[2..4] == "00").count();
                assert_eq!(faces, brep.faces.len(), "{name}");
            }
        }
    }

    #[test]
    fn trimmed_faces_have_their_loops_in_both_spaces() {
        // A square ring of eight cells.
        let mut model = Model::default();
        let places: Vec<(i32, i32)> =
            (0..3).flat_map(|r| (0..3).map(move |c| (r, c))).filter(|p| *p != (1, 1)).collect();
        let id = |r, c| places.iter().position(|&p| p == (r, c)).map_or(u32::MAX, |k| k as u32);
        let mut polygon = QuadPolygon::default();
        for &(r, c) in &places {
            model.grid(1, 1, |i, j| DVec3::new(f64::from(c + j as i32), f64::from(r + i as i32), 0.25));
            let corners = model.patches[model.patches.len() - 1].cell(0, 0);
            polygon.cells.push(QuadCell {
                row: r,
                col: c,
                corners,
                next: [id(r - 1, c), id(r, c + 1), id(r + 1, c), id(r, c - 1)],
            });
        }
        let brep = to_trimmed_brep(&model.mesh(), &[polygon], &[], &Context::new()).unwrap().brep;
        let entities = assert_file(&brep);
        let of = |kind: u32| entities.values().filter(|e| e.kind == kind).collect::<Vec<_>>();
        assert_eq!((of(144).len(), of(142).len(), of(102).len()), (1, 2, 4));
        assert_eq!(of(144)[0].parameters[1..3], ["1", "1"]);
        // Composite curves run on from piece to piece.
        let ends = |id: u32| {
            let e = &entities[&id];
            let reals: Vec<f64> = e.parameters.iter().filter(|p| p.contains('.')).map(|p| real(p)).collect();
            match e.kind {
                110 => [reals[..3].to_vec(), reals[3..6].to_vec()],
                _ => {
                    let n = integer(&e.parameters[0]) as usize + 1;
                    let points = &reals[2 * n + 2..][..3 * n];
                    [points[..3].to_vec(), points[3 * n - 3..].to_vec()]
                }
            }
        };
        for composite in of(102) {
            let curves = pointers(composite);
            for (k, &c) in curves.iter().enumerate() {
                assert_eq!(ends(c)[1], ends(curves[(k + 1) % curves.len()])[0]);
            }
        }
    }

    #[test]
    fn global_section_says_unit_and_size() {
        let (_, model) = models::all().swap_remove(0);
        let brep = brep(&model, Fit::Bilinear);
        for (unit, text) in [
            (Unit::Millimetre, ",2,2HMM,"),
            (Unit::Inch, ",1,2HIN,"),
            (Unit::Metre, ",6,1HM,"),
            (Unit::Centimetre, ",10,2HCM,"),
        ] {
            let options =
                CadOptions { unit, name: format!("part, with; signs {}", "é".repeat(80)), ..Default::default() };
            let mut file = Vec::new();
            write(&brep, &options, &mut file).unwrap();
            let (global, _) = parse(&file);
            assert!(global.contains(text), "{global}");
            assert!(global.contains("15H19700101.000000"));
            assert!(global.starts_with("1H,,1H;,60Hpart, with; signs ????"));
            // The largest coordinate of the unit cube.
            assert!(global.contains(",1.,,,11,0,"));
        }
    }

    #[test]
    fn an_empty_model_is_a_valid_file() {
        let mut file = Vec::new();
        write(&Brep::default(), &CadOptions::default(), &mut file).unwrap();
        parse(&file);
    }
}
