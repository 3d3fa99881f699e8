//! Every format: round trips, and what is refused and noted.

use super::*;
use glam::DVec3;

fn file(name: &str, text: &str) -> std::path::PathBuf {
    let folder = std::env::temp_dir().join(format!("carreau-skeleton-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join(name);
    std::fs::write(&path, text).unwrap();
    path
}

fn tree() -> CurveNet {
    let points = vec![DVec3::ZERO, DVec3::new(0.1, 1e-9, 2.0), DVec3::new(1.0, 2.0, 3.0), DVec3::new(-1.0, 2.5, 3.0)];
    CurveNet::new(points, vec![0.5, 0.25, 0.125, 0.3], vec![[0, 1], [1, 2], [1, 3]])
}

#[test]
fn round_trips() {
    for extension in ["cgr", "cg", "skel", "swc", "tgf", "vtp", "vtk", "obj"] {
        let path = file(&format!("tree.{extension}"), "");
        let warnings = write_skeleton(&path, &tree()).unwrap();
        assert!(warnings.is_empty(), "{extension}: {warnings:?}");
        let back = read_skeleton(&path).unwrap();
        assert_eq!(back.points, tree().points, "{extension}");
        let sorted = |mut net: CurveNet| {
            net.edges.iter_mut().for_each(|e| e.sort_unstable());
            net.edges.sort_unstable();
            net.edges
        };
        assert_eq!(sorted(back.clone()), sorted(tree()), "{extension}");
        match extension {
            "tgf" | "obj" => assert!(back.radii.iter().all(|r| r.is_nan())),
            _ => assert_eq!(back.radii, tree().radii, "{extension}"),
        }
        assert!(back.notes.is_empty(), "{extension}: {:?}", back.notes);
    }
}

#[test]
fn what_no_skeleton_can_mean_is_refused() {
    let head = "v 0 0 0 1\nv 1 0 0 1\n";
    for (name, text, code, says) in [
        ("nan.cgr", format!("{head}v nan 0 0 1\ne 0 1"), 3, "not a finite number; at line 3, node 2"),
        ("index.cgr", format!("{head}e 0 2\ne 0 1"), 3, "no node 2 (2 nodes); at line 3, edge 0-2"),
        ("self.cgr", format!("{head}e 1 1\ne 0 1"), 3, "joins a node with itself; at line 3"),
        ("radius.cgr", format!("{head}v 2 0 0 -1\ne 0 1"), 3, "negative: -1; at line 3, node 2"),
        ("empty.cgr", "# D:3 NV:0 NE:0\n".into(), 3, "the skeleton is empty"),
        ("edgeless.cgr", head.into(), 3, "the skeleton is empty: 2 nodes, 0 edges"),
        ("word.cgr", format!("{head}v 2 0 x\ne 0 1"), 5, "line 3: a number is expected, found 'x'"),
        ("short.cgr", format!("{head}v 2 0\ne 0 1"), 5, "line 3: a node needs 4 fields, there are 3"),
        ("letter.cgr", format!("{head}f 0 1 2"), 5, "'v' or 'e' is expected, found 'f'"),
        ("twice.swc", "1 0 0 0 0 1 -1\n2 0 1 0 0 1 1\n2 0 2 0 0 1 1".into(), 3, "id 2 is used twice, first on line 2"),
        ("orphan.swc", "1 0 0 0 0 1 -1\n2 0 1 0 0 1 7".into(), 3, "no node 7"),
        ("fields.swc", "1 0 0 0 0 1".into(), 5, "needs 7 fields"),
        ("head.skel", "ID".into(), 5, "the number of nodes"),
        ("gone.skel", "ID\n1\n0 0 0 0 1 1 5".into(), 3, "no node 5"),
    ] {
        let error = read_skeleton(&file(name, &text)).unwrap_err();
        assert_eq!(error.exit_code(), code, "{name}: {error}");
        assert!(error.to_string().contains(says), "{name}: {error}");
    }
}

#[test]
fn what_can_be_mended_is_noted() {
    for (name, text, says) in [
        ("count.cgr", "# D:3 NV:3 NE: 1\nv 0 0 0 1\nv 1 0 0 1\ne 0 1", "the header says NV:3, the file has 2"),
        ("double.cgr", "v 0 0 0 1\nv 1 0 0 1\ne 0 1\ne 1 0", "1 edges are listed twice"),
        ("one.cg", "v 0 0 0\nv 1 0 0\nv 2 0 0\ne 1 2\ne 2 3", "count nodes from 1"),
        ("gaps.skel", "ID\n2\n0 0 0 0 1 1 7\n7 1 0 0 1 1 0", "ids have gaps: 2 nodes from 0 to 7"),
        ("one.skel", "ID\n2\n0 0 0 0 1 1 1\n1 1 0 0 1 0", "0 lists 1, but 1 does not list 0"),
        ("less.skel", "ID\n3\n0 0 0 0 1 2 1\n1 1 0 0 1 1 0", "promises 2 neighbours, 1 follow"),
        ("ring.swc", "1 0 0 0 0 1 3\n2 0 1 0 0 1 1\n3 0 1 1 0 1 2", "the parents form a ring"),
    ] {
        let net = read_skeleton(&file(name, text)).unwrap();
        assert!(net.notes.iter().any(|n| n.contains(says)), "{name}: {:?}", net.notes);
        assert!(!net.edges.is_empty());
    }
}

#[test]
fn line_ends_comments_and_blanks() {
    let net = read_skeleton(&file("crlf.swc", "# a\r\n1 1 0 0 0 1 -1 # root\r\n\r\n 2 1 1 0 0 .5 1\r\n")).unwrap();
    assert_eq!((net.ids, net.radii, net.edges), (vec![1, 2], vec![1.0, 0.5], vec![[1, 0]]));
}
