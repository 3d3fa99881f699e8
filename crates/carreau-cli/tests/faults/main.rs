//! What can go wrong around a run: a folder that cannot be written to, a full disk, a deadline, Ctrl-C, a kill in the midst
//! of writing. In each case: the exit code of the contract, a message that names the file, the old output as it was, and
//! nothing half done beside it.

#![cfg(unix)]
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::print_stderr)] // a test fails by panicking

#[path = "../common/mod.rs"]
mod common;
mod folders;

use common::{carreau, text};
use std::collections::BTreeSet;
use std::ffi::OsString;
use std::fs;
use std::io::{BufRead, BufReader};
use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// What stands where the output goes before a run.
const OLD: &[u8] = b"the old content";
const READ_OR_WRITE: i32 = 5;
const DEADLINE: i32 = 124;
const CANCELLED: i32 = 130;

/// A command line that writes `output`; `{m}` is a part, `{w}` a small one, `{t}` a forked tube, `{g}` a skeleton.
struct Writer {
    line: &'static str,
    output: &'static str,
}

const fn writer(line: &'static str, output: &'static str) -> Writer {
    Writer { line, output }
}

/// Every verb that writes a file, and every option that does.
const WRITERS: &[Writer] = &[
    writer("sample torus -o", "o.ply"),
    writer("info {m} --json", "o.json"),
    writer("convert {m} -o", "o.vtu"),
    writer("repair {m} -o", "o.ply"),
    writer("curvature {m} -o", "o.ply"),
    writer("segment {m} -o", "o.ply"),
    writer("enrich {m} --deviation 6 -o", "o.ply"),
    writer("simplify {m} --deviation 14 -o", "o.obj"),
    writer("patch {m} -o", "o.step"),
    writer("patch {m} -o", "o.igs"),
    writer("patch {m} --layout", "o.json"),
    writer("field {m} -o", "o.vtu"),
    writer("field {m} --layout", "o.json"),
    writer("quad {w} --quads 100 -o", "o.obj"),
    writer("skeleton {t} -o", "o.cgr"),
    writer("hex {g} -o", "o.mesh"),
    writer("compare {m} {t} --json", "o.json"),
    writer("view {m} -o", "o.html"),
    writer("segment {w} --picture", "o.png"),
    writer("curvature {m} --report", "o.html"),
];

/// The models, and folders to write to.
struct Desk(TempDir);

impl Desk {
    fn new() -> Self {
        let folder = TempDir::new().unwrap();
        let desk = Desk(folder);
        for (name, file, resolution) in
            [("bracket", "m.ply", "20"), ("wedge", "w.ply", "8"), ("tube-tree", "t.ply", "50")]
        {
            let path = desk.path(file);
            carreau().args(["sample", name, "--resolution", resolution, "-o", text(&path), "-q"]).assert().success();
        }
        fs::write(desk.path("g.cgr"), "# D:3 NV:2 NE:1\nv 0 0 0 0.2\nv 2 0 0 0.3\ne 0 1\n").unwrap();
        desk
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// An empty folder.
    fn fresh(&self, name: &str) -> PathBuf {
        let folder = self.path(name);
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir(&folder).unwrap();
        folder
    }

    /// The words of a command line that writes to `output`.
    fn words(&self, line: &str, output: &Path) -> Vec<OsString> {
        let models = [("{m}", "m.ply"), ("{w}", "w.ply"), ("{t}", "t.ply"), ("{g}", "g.cgr")];
        let word = |w: &str| models.iter().find(|m| m.0 == w).map_or_else(|| w.into(), |m| self.path(m.1).into());
        line.split(' ').map(word).chain([output.into()]).collect()
    }
}

fn executable() -> PathBuf {
    assert_cmd::cargo::cargo_bin("carreau")
}

fn entries(folder: &Path) -> BTreeSet<OsString> {
    fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name()).collect()
}

/// The old output stands as it was, alone in its folder.
fn assert_untouched(output: &Path, what: &str) {
    assert_eq!(fs::read(output).unwrap(), OLD, "{what}: the old output was touched");
    let expected = BTreeSet::from([output.file_name().unwrap().to_os_string()]);
    assert_eq!(entries(output.parent().unwrap()), expected, "{what}: something was left behind");
}

/// Fails with exit code 5 and a message that names the file; no panic.
fn assert_write_error(out: &std::process::Output, output: &Path, what: &str) {
    let errors = String::from_utf8_lossy(&out.stderr);
    assert_eq!(out.status.code(), Some(READ_OR_WRITE), "{what}: {errors}");
    assert!(errors.contains(text(output)), "{what} does not name the file: {errors}");
    assert!(!errors.contains("panicked"), "{what}: {errors}");
}

#[test]
fn places_that_cannot_be_written_to() {
    let desk = Desk::new();
    fs::write(desk.path("file"), b"").unwrap();
    let folder = desk.fresh("is-a-folder");
    for w in WRITERS {
        // A folder that is not there, one that is a file, one of the kernel's, and an output that is itself a folder.
        for place in [desk.path("missing"), desk.path("file"), PathBuf::from("/proc/self")] {
            let output = place.join(w.output);
            let out = Command::new(executable()).args(desk.words(w.line, &output)).output().unwrap();
            assert_write_error(&out, &output, w.line);
        }
        let output = folder.join(w.output);
        fs::create_dir(&output).unwrap();
        let out = Command::new(executable()).args(desk.words(w.line, &output)).output().unwrap();
        assert_write_error(&out, &output, w.line);
        assert!(entries(&output).is_empty());
        fs::remove_dir(&output).unwrap();
        assert!(entries(&folder).is_empty(), "{}: something was left behind", w.line);
    }
}

/// The shell's limit for the size of files, with its signal ignored, makes a write fail midway as a full disk does.
#[test]
fn a_disk_that_fills_up_in_the_midst() {
    let desk = Desk::new();
    for w in WRITERS {
        let output = desk.fresh("full").join(w.output);
        fs::write(&output, OLD).unwrap();
        let script = "trap '' XFSZ; ulimit -f 1 || exit 99; exec \"$@\"";
        let mut command = Command::new("sh");
        command.args(["-c", script, "sh"]).arg(executable()).args(desk.words(w.line, &output));
        let out = command.output().unwrap();
        assert_ne!(out.status.code(), Some(99), "the shell has no ulimit");
        if out.status.success() {
            // The limit is in blocks of 512 or 1024 bytes; what is shorter fits.
            assert!(fs::metadata(&output).unwrap().len() <= 1024, "{}: larger than the disk", w.line);
            continue;
        }
        assert_write_error(&out, &output, w.line);
        assert_untouched(&output, w.line);
    }
}

/// A link to the device that is always full: it is written through, not replaced.
#[test]
fn a_full_device_behind_a_link() {
    if !Path::new("/dev/full").exists() {
        eprintln!("SKIPPED: there is no /dev/full");
        return;
    }
    let desk = Desk::new();
    for w in WRITERS {
        let output = desk.fresh("device").join(w.output);
        std::os::unix::fs::symlink("/dev/full", &output).unwrap();
        let out = Command::new(executable()).args(desk.words(w.line, &output)).output().unwrap();
        assert_write_error(&out, &output, w.line);
        assert_eq!(fs::read_link(&output).unwrap(), Path::new("/dev/full"), "{}: the link was replaced", w.line);
        assert_eq!(entries(output.parent().unwrap()).len(), 1, "{}: something was left behind", w.line);
    }
}

#[test]
fn a_deadline_leaves_the_old_output() {
    let desk = Desk::new();
    for w in WRITERS {
        let output = desk.fresh("late").join(w.output);
        fs::write(&output, OLD).unwrap();
        let mut command = Command::new(executable());
        let out = command.args(desk.words(w.line, &output)).args(["--deadline", "0.000001"]).output().unwrap();
        let errors = String::from_utf8_lossy(&out.stderr);
        assert_eq!(out.status.code(), Some(DEADLINE), "{}: {errors}", w.line);
        assert!(errors.contains("deadline"), "{}: {errors}", w.line);
        assert_untouched(&output, w.line);
    }
}

/// Starts a run that tells its stages.
fn start(words: &[OsString]) -> Child {
    let mut command = Command::new(executable());
    command.args(words).arg("-v").stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap()
}

fn signal(child: &Child, name: &str) {
    let sent = Command::new("kill").args([format!("-{name}"), child.id().to_string()]).status();
    assert!(sent.is_ok_and(|s| s.success()), "kill is not at hand");
}

/// Waits for the end of a run; a run that does not end is a failure, not a hang of the tests.
fn finish(mut child: Child, what: &str) -> std::process::ExitStatus {
    let start = Instant::now();
    loop {
        if let Some(status) = child.try_wait().unwrap() {
            return status;
        }
        if start.elapsed() > Duration::from_secs(60) {
            let _ = child.kill();
            panic!("{what} does not end");
        }
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// Ctrl-C once the input is read: the runs are long enough not to be over by then.
#[test]
fn a_cancelled_run_leaves_the_old_output() {
    let desk = Desk::new();
    let fine = desk.path("fine.ply");
    carreau().args(["sample", "tube-tree", "--resolution", "150", "-o", text(&fine), "-q"]).assert().success();
    let long = [
        writer("enrich {f} --deviation 2 -o", "o.ply"),
        writer("simplify {f} --deviation 14 -o", "o.obj"),
        writer("quad {f} -o", "o.obj"),
        writer("skeleton {f} -o", "o.cgr"),
        writer("hex {f} -o", "o.mesh"),
        writer("compare {f} {m} --json", "o.json"),
    ];
    for w in &long {
        let output = desk.fresh("cancelled").join(w.output);
        fs::write(&output, OLD).unwrap();
        let line = w.line.replace("{f}", text(&fine));
        let mut child = start(&desk.words(&line, &output));
        // The first line on stderr: a stage has ended, so the handler stands and the method begins.
        let mut stages = BufReader::new(child.stderr.take().unwrap());
        let mut first = String::new();
        stages.read_line(&mut first).unwrap();
        signal(&child, "INT");
        let drain = std::thread::spawn(move || stages.lines().map_while(Result::ok).collect::<Vec<_>>());
        let status = finish(child, w.line);
        let told = drain.join().unwrap();
        assert_eq!(status.code(), Some(CANCELLED), "{}: {status} {first} {told:?}", w.line);
        assert!(told.iter().any(|line| line.contains("cancelled")), "{}: {told:?}", w.line);
        assert_untouched(&output, w.line);
    }
}

/// Kills at many moments around the writing of a large file: there is the old file or the new one, never a part of it, and
/// what a killed run leaves beside it keeps no later run from its work.
#[test]
fn a_killed_run_leaves_the_old_output_or_the_new() {
    let desk = Desk::new();
    let source = desk.path("large.ply");
    carreau().args(["sample", "torus", "--resolution", "300", "-o", text(&source), "-q"]).assert().success();
    let output = desk.fresh("killed").join("o.vtu");
    let words = desk.words(&format!("convert {} --ascii -o", text(&source)), &output);
    let whole = {
        assert!(finish(start(&words), "convert").success());
        fs::read(&output).unwrap()
    };
    assert!(whole.len() > 1_000_000, "{} bytes are written too fast to be killed in the midst", whole.len());
    let usual = {
        let begin = Instant::now();
        assert!(finish(start(&words), "convert").success());
        begin.elapsed()
    };
    let (mut killed, rounds) = (0, 24);
    for round in 0..rounds {
        fs::write(&output, OLD).unwrap();
        let mut child = start(&words);
        std::thread::sleep(usual * round / rounds);
        child.kill().unwrap();
        killed += u32::from(child.wait().unwrap().signal().is_some());
        let found = fs::read(&output).unwrap();
        assert!(found == OLD || found == whole, "round {round}: {} of {} bytes", found.len(), whole.len());
    }
    assert!(killed > 0, "no run was killed");
    assert!(finish(start(&words), "convert").success());
    assert_eq!(fs::read(&output).unwrap(), whole);
}

/// The unfinished file of a killed run may have the name that a later run with the same process id would take.
#[test]
fn leftovers_of_an_earlier_run_are_no_obstacle() {
    let desk = Desk::new();
    let output = desk.fresh("again").join("o.ply");
    // The process id of the command is that of the shell, which leaves such files before it becomes the command.
    let script = "for f in \"$OUT\"/.o.ply.$$.part \"$OUT\"/.o.ply.$$.1.part; do echo old > \"$f\"; done; exec \"$@\"";
    let mut command = Command::new("sh");
    command.env("OUT", output.parent().unwrap()).args(["-c", script, "sh"]).arg(executable());
    let out = command.args(desk.words("sample torus -q -o", &output)).output().unwrap();
    assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
    assert!(fs::metadata(&output).unwrap().len() > 1000);
    // A name as long as names may be leaves no room for anything behind it.
    let long = output.with_file_name(format!("{}.ply", "n".repeat(251)));
    carreau().args(["sample", "torus", "-q", "-o", text(&long)]).assert().success();
}
