//! Sources as the tests of the house read them: the modules of a crate, each with its code and nothing else.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// A module that is a file.
pub struct Module {
    /// Its names below the root of the crate; the root has none.
    pub path: Vec<String>,
    /// Its file below the folder of sources.
    pub file: PathBuf,
    /// The file as it is.
    pub text: String,
    /// The same lines without comments, the contents of strings, and items for tests.
    pub code: String,
}

impl Module {
    /// The part of the library that it belongs to; none for the root.
    pub fn part(&self) -> Option<&str> {
        self.path.first().map(String::as_str)
    }
}

/// The modules of the crate with this root file. Modules for tests are left out, since nothing but tests declares them.
pub fn modules_of(root: &Path) -> Vec<Module> {
    let folder = root.parent().unwrap();
    let read = |file: &Path| fs::read_to_string(folder.join(file)).ok();
    modules(Path::new(root.file_name().unwrap()), &read)
}

/// The modules of a crate whose files are texts in memory, by name; `lib.rs` is the root.
pub fn modules_in(files: &[(&str, &str)]) -> Vec<Module> {
    let files: BTreeMap<&Path, &str> = files.iter().map(|(name, text)| (Path::new(*name), *text)).collect();
    modules(Path::new("lib.rs"), &|file| files.get(file).map(|text| text.to_string()))
}

fn modules(root: &Path, read: &dyn Fn(&Path) -> Option<String>) -> Vec<Module> {
    let mut found = Vec::new();
    let mut open = vec![(Vec::new(), root.to_path_buf())];
    while let Some((path, file)) = open.pop() {
        let text = read(&file).unwrap_or_else(|| panic!("{} is declared, but not there", file.display()));
        let code = code_of(&text);
        for name in declared_modules(&code) {
            let below: PathBuf = path.iter().collect();
            let choices = [below.join(format!("{name}.rs")), below.join(&name).join("mod.rs")];
            let file = choices.iter().find(|file| read(file).is_some()).unwrap_or(&choices[0]).clone();
            open.push((path.iter().cloned().chain([name]).collect(), file));
        }
        found.push(Module { path, file, text, code });
    }
    found.sort_by(|a, b| a.path.cmp(&b.path));
    found
}

/// The modules that a code declares as files of their own.
fn declared_modules(code: &str) -> Vec<String> {
    let name = |line: &str| {
        let (before, after) = line.split_once("mod ")?;
        let is_visibility = before.is_empty() || before.starts_with("pub");
        is_visibility.then(|| after.strip_suffix(';').map(String::from)).flatten()
    };
    code.lines().filter_map(name).collect()
}

/// The lines of a text without comments, contents of strings and characters, and without items under `#[cfg(test)]`.
pub fn code_of(text: &str) -> String {
    without_tests(&without_words(text))
}

/// Blanks comments and the contents of strings and characters; lines stay lines.
fn without_words(text: &str) -> String {
    let all: Vec<char> = text.chars().collect();
    let at = |k: usize| all.get(k).copied().unwrap_or('\0');
    let is_name = |c: char| c.is_alphanumeric() || c == '_';
    let mut code = String::with_capacity(text.len());
    let mut k = 0;
    while k < all.len() {
        let begins_word = k == 0 || !is_name(all[k - 1]);
        let end = match all[k] {
            '/' if at(k + 1) == '/' => (k..all.len()).find(|&j| all[j] == '\n').unwrap_or(all.len()),
            '/' if at(k + 1) == '*' => end_of_comment(&all, k),
            '"' => end_of_string(&all, k + 1),
            'r' if begins_word && matches!(at(k + 1), '"' | '#') => end_of_raw_string(&all, k),
            'b' if begins_word && at(k + 1) == 'r' && matches!(at(k + 2), '"' | '#') => end_of_raw_string(&all, k + 1),
            '\'' if at(k + 1) == '\\' => (k + 3..all.len()).find(|&j| all[j] == '\'').map_or(all.len(), |j| j + 1),
            '\'' if at(k + 2) == '\'' => k + 3,
            _ => k,
        };
        if end == k {
            code.push(all[k]);
            k += 1;
        } else {
            if matches!(all[k], '"' | 'r' | 'b') {
                code.push_str("\"\"");
            }
            code.extend(all[k..end].iter().filter(|&&c| c == '\n'));
            k = end;
        }
    }
    code
}

fn end_of_comment(all: &[char], begin: usize) -> usize {
    let (mut depth, mut k) = (0_usize, begin);
    while k + 1 < all.len() {
        match (all[k], all[k + 1]) {
            ('/', '*') => (depth, k) = (depth + 1, k + 2),
            ('*', '/') if depth == 1 => return k + 2,
            ('*', '/') => (depth, k) = (depth - 1, k + 2),
            _ => k += 1,
        }
    }
    all.len()
}

fn end_of_string(all: &[char], begin: usize) -> usize {
    let mut k = begin;
    while k < all.len() {
        match all[k] {
            '\\' => k += 2,
            '"' => return k + 1,
            _ => k += 1,
        }
    }
    all.len()
}

/// Where a raw string ends whose `r` is here; the same place where there is none (`r#type`).
fn end_of_raw_string(all: &[char], begin: usize) -> usize {
    let hashes = all[begin + 1..].iter().take_while(|&&c| c == '#').count();
    let open = begin + 1 + hashes;
    if all.get(open) != Some(&'"') {
        return begin;
    }
    let closes = |j: usize| all[j] == '"' && all[j + 1..].iter().take_while(|&&c| c == '#').count() >= hashes;
    (open + 1..all.len()).find(|&j| closes(j)).map_or(all.len(), |j| j + 1 + hashes)
}

/// Blanks the items under `#[cfg(test)]` of a formatted code.
fn without_tests(code: &str) -> String {
    let lines: Vec<&str> = code.lines().collect();
    let mut kept = Vec::with_capacity(lines.len());
    let mut k = 0;
    while k < lines.len() {
        if lines[k].trim() != "#[cfg(test)]" {
            kept.push(lines[k]);
            k += 1;
            continue;
        }
        let item = (k + 1..lines.len()).find(|&j| !lines[j].trim_start().starts_with("#["));
        let end = item.map_or(lines.len(), |j| end_of_item(&lines, j) + 1);
        kept.resize(kept.len() + end - k, "");
        k = end;
    }
    kept.iter().map(|line| format!("{line}\n")).collect()
}

/// The last line of the item that begins at this one.
pub fn end_of_item(lines: &[&str], first: usize) -> usize {
    let indent = |line: &str| line.len() - line.trim_start().len();
    let depth = indent(lines[first]);
    let opens = |line: &str| line.ends_with(['{', '(', '[', ',', '=', '<', '>', '+']);
    if lines[first].ends_with([';', '}']) && !opens(lines[first]) {
        return first;
    }
    let ends = |line: &str| indent(line) == depth && (line.trim_start().starts_with('}') || line.ends_with([';', '}']));
    (first + 1..lines.len()).find(|&j| ends(lines[j])).unwrap_or(lines.len() - 1)
}

#[test]
fn code_is_what_is_neither_comment_nor_string_nor_test() {
    let text = "use a::B; // use c::D;\nlet s = \"x \\\" super::e\"; /* f /* g */ h */ let c = '\"';\n\
        let r = r#\"\n\"super::i\"#; let t: &'a str = j; let b = br\"k\";\n\
        #[cfg(test)]\n#[allow(x)]\nmod tests {\n    fn l() {\n    }\n}\n#[cfg(test)]\nuse m::N;\nfn o() {}\n";
    let code = code_of(text);
    assert_eq!(code.lines().count(), text.lines().count(), "lines stay lines: {code}");
    for gone in ["c::D", "super", "f", "g", "h", "i", "k", "l()", "m::N"] {
        let is_word = |word: &str| word == gone || (gone.len() > 1 && word.contains(gone));
        assert!(!code.split([' ', '\n']).any(is_word), "{gone} stays in {code}");
    }
    for kept in ["use a::B;", "let s = \"\";", "let c = ", "&'a str = j", "fn o() {}"] {
        assert!(code.contains(kept), "{kept} is gone from {code}");
    }
}

#[test]
fn modules_are_found_by_their_declarations() {
    let files = [
        ("lib.rs", "pub mod a;\nmod b;\n#[cfg(test)]\nmod tests;\n"),
        ("a/mod.rs", "mod c;\n"),
        ("a/c.rs", ""),
        ("b.rs", "pub(crate) mod d;\n"),
        ("b/d.rs", "// mod e;\n"),
        ("tests.rs", ""),
    ];
    let found: Vec<String> = modules_in(&files).iter().map(|module| module.path.join("::")).collect();
    assert_eq!(found, ["", "a", "a::c", "b", "b::d"]);
}
