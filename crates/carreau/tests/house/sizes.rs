//! How long files and functions are.

use crate::source::{Module, end_of_item};

/// A function, its first line and its length in lines, from its signature to its closing brace.
#[derive(Debug, PartialEq)]
pub struct Function {
    pub name: String,
    pub line: usize,
    pub length: usize,
}

/// The functions of a formatted code.
pub fn functions(module: &Module) -> Vec<Function> {
    functions_in(&module.code)
}

fn functions_in(code: &str) -> Vec<Function> {
    let lines: Vec<&str> = code.lines().map(str::trim_end).collect();
    let named = |(k, line): (usize, &&str)| {
        let name = name_of_function(line)?;
        Some(Function { name: name.into(), line: k + 1, length: end_of_item(&lines, k) + 1 - k })
    };
    lines.iter().enumerate().filter_map(named).collect()
}

/// The name of the function that begins on a line.
fn name_of_function(line: &str) -> Option<&str> {
    let mut words = line.trim_start();
    loop {
        let (word, rest) = words.split_once(' ')?;
        match word {
            "fn" => return rest.split(['(', '<']).next(),
            "const" | "async" | "extern" | "unsafe" | "in" => words = rest,
            _ if word.starts_with("pub") => words = rest,
            _ => return None,
        }
    }
}

#[test]
fn functions_are_measured_to_their_closing_brace() {
    let code = "pub fn one() -> u8 { 1 }\npub(crate) const fn two(\n    a: u8,\n) -> u8 {\n    if a {\n        a\n    }\n    fn three() {\n        4\n    }\n}\n\
        trait T {\n    fn four(&self);\n    fn five(\n        &self,\n    );\n}\nimpl<F: Fn()> T for F {\n    fn six<A>(&self)\n    where\n        A: B,\n    {\n        7\n    }\n}\n\
        const EIGHT: fn() = nine;\n";
    let found: Vec<(String, usize, usize)> =
        functions_in(code).into_iter().map(|f| (f.name, f.line, f.length)).collect();
    let expected = [("one", 1, 1), ("two", 2, 10), ("three", 8, 3), ("four", 13, 1), ("five", 14, 3), ("six", 19, 6)];
    assert_eq!(found, expected.map(|(name, line, length)| (name.to_string(), line, length)));
}
