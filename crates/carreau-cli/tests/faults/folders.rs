//! Faults of what writes folders, `demo` and `man`, and of what writes to stdout.

use super::*;
use std::fs::OpenOptions;

/// Files of a folder that `demo` writes early, a picture, and the index that it writes in the end.
const EARLY: &str = "cube-cylinders.ply";
const PICTURE: &str = "cube-cylinders-regions.png";
const INDEX: &str = "index.html";

/// The verbs that write a folder, each with a page of it that must be longer than the smallest disk.
const FOLDERS: &[(&str, &str)] = &[("demo -o", EARLY), ("man -o", "carreau.1")];

fn run(desk: &Desk, line: &str, output: &Path) -> std::process::Output {
    Command::new(executable()).args(desk.words(line, output)).output().unwrap()
}

/// No file of the folder is half written, none is left beside; `whole` says what a whole file is.
fn assert_whole(folder: &Path, whole: impl Fn(&Path) -> bool, what: &str) {
    for name in entries(folder) {
        let file = folder.join(&name);
        assert!(!name.to_string_lossy().ends_with(".part"), "{what}: {name:?} was left behind");
        assert!(fs::read(&file).unwrap() == OLD || whole(&file), "{what}: {name:?} is half written");
    }
}

/// Whether a file of the first models of `demo` can be read to its end.
fn reads(file: &Path) -> bool {
    let bytes = fs::read(file).unwrap();
    match file.extension().and_then(|e| e.to_str()) {
        Some("ply") => carreau().args(["info", text(file), "-q"]).ok().is_ok(),
        Some("png") => bytes.ends_with(b"IEND\xaeB`\x82"),
        Some("html") => bytes.ends_with(b"</html>\n"),
        Some("json") => serde_json::from_slice::<serde_json::Value>(&bytes).is_ok(),
        Some("step") => bytes.ends_with(b"END-ISO-10303-21;\n"),
        other => panic!("what is {other:?}?"),
    }
}

#[test]
fn folders_that_cannot_be_made() {
    let desk = Desk::new();
    let file = desk.path("file");
    fs::write(&file, OLD).unwrap();
    for (line, _) in FOLDERS {
        for output in [file.clone(), file.join("within"), PathBuf::from("/proc/self/made")] {
            assert_write_error(&run(&desk, line, &output), &output, line);
            assert_eq!(fs::read(&file).unwrap(), OLD, "{line}");
        }
    }
}

#[test]
fn a_disk_that_fills_up_under_a_folder() {
    let desk = Desk::new();
    for (line, page) in FOLDERS {
        let folder = desk.fresh("full");
        fs::write(folder.join(page), OLD).unwrap();
        let script = "trap '' XFSZ; ulimit -f 1 || exit 99; exec \"$@\"";
        let mut command = Command::new("sh");
        command.args(["-c", script, "sh"]).arg(executable()).args(desk.words(line, &folder));
        let out = command.output().unwrap();
        assert_write_error(&out, &folder.join(page), line);
        assert_untouched(&folder.join(page), line);
    }
}

#[test]
fn a_full_device_behind_one_of_many_files() {
    if !Path::new("/dev/full").exists() {
        eprintln!("SKIPPED: there is no /dev/full");
        return;
    }
    let desk = Desk::new();
    for (line, page) in [("demo -o", PICTURE), ("man -o", "carreau-hex.1")] {
        let folder = desk.fresh("device");
        std::os::unix::fs::symlink("/dev/full", folder.join(page)).unwrap();
        assert_write_error(&run(&desk, line, &folder), &folder.join(page), line);
        assert_eq!(fs::read_link(folder.join(page)).unwrap(), Path::new("/dev/full"), "{line}");
        fs::remove_file(folder.join(page)).unwrap();
        // What was finished before stays, whole.
        let first = if line.starts_with("demo") { EARLY } else { "carreau.1" };
        assert!(folder.join(first).is_file(), "{line}");
        assert_whole(&folder, |file| file.extension().is_some_and(|e| e == "1") || reads(file), line);
    }
}

#[test]
fn a_late_or_cancelled_demo_leaves_the_old_index() {
    let desk = Desk::new();
    let folder = desk.fresh("late");
    fs::write(folder.join(INDEX), OLD).unwrap();
    let words = desk.words("demo --deadline 0.000001 -o", &folder);
    let out = Command::new(executable()).args(words).output().unwrap();
    assert_eq!(out.status.code(), Some(DEADLINE), "{}", String::from_utf8_lossy(&out.stderr));
    assert_untouched(&folder.join(INDEX), "demo");

    let mut child = start(&desk.words("demo -o", &folder));
    let mut stages = BufReader::new(child.stderr.take().unwrap()).lines().map_while(Result::ok);
    // The first line on stderr: a stage has ended, the method begins.
    assert!(stages.next().is_some(), "demo tells no stage");
    signal(&child, "INT");
    let drain = std::thread::spawn(move || stages.collect::<Vec<_>>());
    let status = finish(child, "demo");
    let told = drain.join().unwrap();
    assert_eq!(status.code(), Some(CANCELLED), "{status} {told:?}");
    assert!(told.iter().any(|line| line.contains("cancelled")), "{told:?}");
    assert_eq!(fs::read(folder.join(INDEX)).unwrap(), OLD);
    assert_whole(&folder, reads, "demo");
}

/// Killed after so many stages are told: no file that has its name is half written, and the index, which is written in the
/// end, is the old one.
#[test]
fn a_killed_demo_leaves_whole_files() {
    let desk = Desk::new();
    for stages in [1, 4, 8, 16] {
        let output = desk.fresh("killed");
        fs::write(output.join(INDEX), OLD).unwrap();
        let mut child = start(&desk.words("demo -o", &output));
        let told = BufReader::new(child.stderr.take().unwrap()).lines().map_while(Result::ok);
        let told: Vec<_> = told.take(stages).collect();
        child.kill().unwrap();
        let status = child.wait().unwrap();
        // A machine that is slow to tell may have ended before the later ones.
        if status.signal().is_some() {
            assert_eq!(fs::read(output.join(INDEX)).unwrap(), OLD);
        } else {
            assert!(stages > 1, "demo ended before it was killed: {status} {told:?}");
        }
        for name in entries(&output) {
            // A killed run cannot take its unfinished file away.
            if name.to_string_lossy().ends_with(".part") {
                fs::remove_file(output.join(name)).unwrap();
            }
        }
        assert_whole(&output, reads, "demo");
    }
}

#[test]
fn killed_manual_pages_are_whole() {
    let desk = Desk::new();
    let whole = desk.fresh("whole");
    let words = |folder: &Path| desk.words("man -o", folder);
    let usual = {
        let begin = Instant::now();
        assert!(Command::new(executable()).args(words(&whole)).status().unwrap().success());
        begin.elapsed()
    };
    let pages = entries(&whole);
    assert!(pages.len() > 15, "{pages:?}");
    let output = desk.fresh("killed");
    let (mut killed, rounds) = (0, 40);
    for round in 0..rounds {
        pages.iter().for_each(|page| fs::write(output.join(page), OLD).unwrap());
        let mut child = Command::new(executable()).args(words(&output)).spawn().unwrap();
        std::thread::sleep(usual * round / rounds);
        child.kill().unwrap();
        killed += u32::from(child.wait().unwrap().signal().is_some());
        for page in &pages {
            let found = fs::read(output.join(page)).unwrap();
            assert!(found == OLD || found == fs::read(whole.join(page)).unwrap(), "round {round}: {page:?}");
        }
    }
    assert!(killed > 0, "no run was killed");
}

#[test]
fn a_full_stdout_is_told_and_a_closed_one_is_not() {
    let desk = Desk::new();
    let model = desk.path("m.ply");
    let model = text(&model);
    for line in ["completions bash", "completions zsh", "man", "--help", "--version", "sample --list"] {
        let words: Vec<&str> = line.split(' ').collect();
        refused_by_full_stdout(&words);
        survives_closed_stdout(&words);
    }
    refused_by_full_stdout(&["info", model, "--json", "-", "-q"]);
    survives_closed_stdout(&["info", model, "--json", "-", "-q"]);
    refused_by_full_stdout(&["compare", model, model]);
    survives_closed_stdout(&["compare", model, model]);
}

fn refused_by_full_stdout(words: &[&str]) {
    let Ok(full) = OpenOptions::new().write(true).open("/dev/full") else {
        eprintln!("SKIPPED: there is no /dev/full");
        return;
    };
    let out = Command::new(executable()).args(words).stdout(full).output().unwrap();
    let errors = String::from_utf8_lossy(&out.stderr);
    assert_eq!(out.status.code(), Some(READ_OR_WRITE), "{words:?}: {errors}");
    assert!(errors.contains("stdout") && !errors.contains("panicked"), "{words:?}: {errors}");
}

/// A reader that has enough, like `head`, is no failure.
fn survives_closed_stdout(words: &[&str]) {
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    let out = Command::new(executable()).args(words).stdout(writer).output().unwrap();
    assert!(out.status.success(), "{words:?}: {:?} {}", out.status, String::from_utf8_lossy(&out.stderr));
}
