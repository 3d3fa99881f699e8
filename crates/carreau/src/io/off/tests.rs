use super::super::surface_tests::{error_of, faces_of, read_as};
use crate::mesh::{Column, RawMesh};
use glam::DVec3;

const SQUARE: &str = "OFF\n4 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 2 3\n";

fn read(text: impl AsRef<[u8]>) -> RawMesh {
    read_as("a.off", text).unwrap()
}

#[test]
fn layout_does_not_matter() {
    let plain = read(SQUARE);
    assert_eq!(faces_of(&plain), [[0, 1, 2], [0, 2, 3]]);
    let body = &SQUARE[SQUARE.find("0 0 0").unwrap()..];
    for text in [
        SQUARE.replace('\n', "\r\n"),
        SQUARE.replace('\n', "\r"),
        SQUARE.replace('\n', " # comment\n\n"),
        SQUARE.replace(['\n', ' '], "\n"),
        SQUARE.replace('\n', " "),
        format!("\u{feff}off 4 2 0\n{body}"),
        format!("OFF4 2 0\n{body}"),
        format!("4 2 0\n{body}"),
        format!("OFF\n4 2\n{body}"),
        format!("OFF\n4\n2\n0\n{body}"),
        format!("OFF\n4 2\n7\n{body}"),
        "OFF\n4 2 0\n0 0 0 1 0 0\n1 1 0 0 1 0\n3 0 1\n2 3\n0 2 3".into(),
    ] {
        let mesh = read(&text);
        assert_eq!((&mesh.points, &mesh.faces), (&plain.points, &plain.faces), "{text:?}");
        assert!(mesh.notes.is_empty(), "{text:?}: {:?}", mesh.notes);
    }
}

#[test]
fn the_keyword_tells_what_vertices_have() {
    let vertices = |keyword: &str, rest: &str| read(format!("{keyword}\n1 0 0\n1 2 3 {rest}\n")).attributes.vertex;
    let normal = Column::Vector3(vec![[0.0, 0.0, 1.0]]);
    let color = Column::Color(vec![[255, 0, 51, 255]]);
    let uv = Column::Vector2(vec![[0.25, 0.75]]);
    assert_eq!(vertices("NOFF", "0 0 1")["normal"], normal);
    assert_eq!(vertices("noff", "0 0 1")["normal"], normal);
    for values in ["1 0 0.2", "1.0 0.0 0.2 1.0", "255 0 51", "255 0 51 255"] {
        assert_eq!(vertices("COFF", values)["color"], color, "{values}");
        let all = vertices("STCNOFF", &format!("0 0 1 {values} .25 .75"));
        assert_eq!((&all["normal"], &all["color"], &all["uv"]), (&normal, &color, &uv));
    }
    assert_eq!(vertices("STOFF", ".25 .75")["uv"], uv);
    assert!(vertices("OFF", "1 0 0").is_empty());
}

#[test]
fn columns_need_all_elements() {
    let mesh = read("CNOFF\n2 0 0\n0 0 0 0 0 1 1 0 0\n1 0 0\n");
    assert!(mesh.attributes.vertex.is_empty());
    assert_eq!(mesh.notes.len(), 2, "{:?}", mesh.notes);
    assert_eq!(read("OFF\n1 0 0\n0 0 0 1 2 3\n").notes.len(), 1);
}

#[test]
fn colours_of_faces_in_shares_of_one_or_of_255() {
    let colors = |a: &str, b: &str| {
        let file =
            SQUARE.replace("3 0 1 2\n", &format!("3 0 1 2 {a}\n")).replace("3 0 2 3\n", &format!("3 0 2 3 {b}\n"));
        read(file).attributes.face.remove("color")
    };
    assert_eq!(colors("1 0 0", "0 .2 0 0"), Some(Column::Color(vec![[255, 0, 0, 255], [0, 51, 0, 0]])));
    assert_eq!(colors("1 0 0", "0 255 0 7"), Some(Column::Color(vec![[1, 0, 0, 255], [0, 255, 0, 7]])));
    assert_eq!(colors("0.2 0 0", "0 255 0"), Some(Column::Color(vec![[51, 0, 0, 255], [0, 255, 0, 255]])));
    for (a, b) in [("", "1 0 0"), ("7", "1 0 0"), ("red", "1 0 0"), ("", "")] {
        assert_eq!(colors(a, b), None);
    }
}

#[test]
fn binary_files_with_colours() {
    let mut file = b"COFF BINARY\n".to_vec();
    let int = |file: &mut Vec<u8>, values: &[i32]| values.iter().for_each(|k| file.extend(k.to_be_bytes()));
    let float = |file: &mut Vec<u8>, values: &[f32]| values.iter().for_each(|x| file.extend(x.to_be_bytes()));
    int(&mut file, &[3, 2, 0]);
    for k in 0..3 {
        float(&mut file, &[k as f32, 0.1, 0.0, 1.0, 0.0, 0.0, 1.0]);
    }
    int(&mut file, &[3, 0, 1, 2, 3]);
    float(&mut file, &[0.0, 1.0, 0.0]);
    int(&mut file, &[3, 2, 1, 0, 4]);
    float(&mut file, &[0.0, 1.0, 0.0, 0.0]);
    let mesh = read(&file);
    assert_eq!(mesh.points[2], DVec3::new(2.0, f64::from(0.1f32), 0.0));
    assert_eq!(faces_of(&mesh), [[0, 1, 2], [2, 1, 0]]);
    assert_eq!(mesh.attributes.face["color"], Column::Color(vec![[0, 255, 0, 255], [0, 255, 0, 0]]));
    assert!(error_of("a.off", &file[..file.len() - 1]).contains("byte"));
    file[15] = 255;
    assert!(error_of("a.off", &file).contains("vertices are announced"));
}

#[test]
fn short_faces_and_what_follows_are_left_out_and_noted() {
    let mesh = read("OFF\n3 3 0\n0 0 0\n1 0 0\n0 1 0\n2 0 1 1 0 0\n3 0 1 2 0 1 0\n0 1 0 0\n3 0 1 2\n");
    assert_eq!(faces_of(&mesh), [[0, 1, 2]]);
    assert_eq!(mesh.attributes.face["color"], Column::Color(vec![[0, 255, 0, 255]]));
    assert_eq!(mesh.notes.len(), 2, "{:?}", mesh.notes);
    assert!(mesh.notes.iter().any(|n| n.contains("line 9")), "{:?}", mesh.notes);
}

#[test]
fn what_is_wrong_is_told_with_its_line() {
    for (text, what) in [
        ("#\n".to_string(), "only comments"),
        ("ply\n".into(), "does not look like OFF"),
        ("OFFICE 1 2\n".into(), "does not look like OFF"),
        ("4OFF\n".into(), "'4OFF' has points with another number of coordinates"),
        ("nOFF\n3\n".into(), "'nOFF' has points"),
        (SQUARE.replace("4 2 0", "1000000000 2 0"), "line 2: the number of vertices is 1000000000"),
        (SQUARE.replace("4 2 0", "4 1000000000 0"), "line 2: the number of faces is 1000000000"),
        (SQUARE.replace("4 2 0", "4 -2 0"), "line 2: the number of faces is -2"),
        (SQUARE.replace("3 0 2 3", "3 0 2 4"), "line 8: vertex '4' does not exist"),
        (SQUARE.replace("3 0 2 3", "3 0 2 -1"), "line 8: vertex '-1' does not exist"),
        (SQUARE.replace("3 0 2 3", "3 0 2"), "line 8: a face with 3 corners ends after 2"),
        (SQUARE.replace("3 0 2 3", "999 0 2 3"), "line 8: the number of corners is 999"),
        (SQUARE.replace("1 1 0", "1 1"), "line 5: a vertex has only 2 of 3 coordinates"),
        (SQUARE.replace("1 1 0", "1 0,5 0"), "line 5: a number is expected, found '0,5'"),
        (SQUARE.replace("1 1 0", "1 1 inf"), "not finite"),
        (SQUARE[..SQUARE.len() - 8].into(), "the file ends"),
    ] {
        let message = error_of("a.off", &text);
        assert!(message.contains(what), "{text}: {message}");
    }
}
