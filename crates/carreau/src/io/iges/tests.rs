//! Files are parsed back, column by column.

use super::*;
use crate::brep::{Surface, models as solids};
use crate::context::Context;
use crate::geometry::bspline::BSplineSurface;
use crate::io::cad::Unit;
use crate::patch::cad::models::{self, Model};
use crate::patch::cad::{BrepOptions, Fit, QuadCell, QuadPolygon, to_brep, to_trimmed_brep};
use glam::DVec3;
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
    let places: Vec<(i32, i32)> = (0..3).flat_map(|r| (0..3).map(move |c| (r, c))).filter(|p| *p != (1, 1)).collect();
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
        let options = CadOptions { unit, name: format!("part, with; signs {}", "é".repeat(80)), ..Default::default() };
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

#[test]
fn solids_have_their_topology_names_and_colors() {
    for (name, brep, _) in solids::all() {
        for iges in [IgesForm::Solids, IgesForm::Surfaces] {
            let mut file = Vec::new();
            write(&brep, &CadOptions { iges, ..Default::default() }, &mut file).unwrap();
            if let Some(folder) = std::env::var_os("CARREAU_WRITE_MODELS") {
                // For other programs to read.
                let form = if iges == IgesForm::Solids { "" } else { "_trim" };
                std::fs::write(std::path::PathBuf::from(folder).join(format!("{name}{form}.igs")), &file).unwrap();
            }
            let (_, entities) = parse(&file);
            let count = |kind: u32| entities.values().filter(|e| e.kind == kind).count();
            let text = String::from_utf8(file.clone()).unwrap();
            assert_eq!(count(314), 1, "{name}");
            if iges == IgesForm::Surfaces {
                // A spline surface that its loop does not cut is a face by itself.
                assert_eq!(count(144) + count(128), brep.faces.len(), "{name}");
                continue;
            }
            assert_eq!((count(186), count(514), count(510)), (1, brep.shells.len(), brep.faces.len()), "{name}");
            let loops = brep.faces.iter().map(|f| f.loops.len() + f.poles.len()).sum::<usize>();
            assert_eq!((count(508), count(504), count(502)), (loops, 1, 1), "{name}");
            // A name for every face and the body.
            assert_eq!(count(406), brep.faces.len() + 1, "{name}");
            assert!(brep.faces.iter().all(|f| text.contains(&format!("{}H{}", f.name.len(), f.name))), "{name}");
        }
    }
}
