//! Constants of modules: each is described, and has a name of its own in its room.

use crate::source::Module;

/// A constant of a module: its name, and whether it has a comment of its own.
pub struct Constant {
    pub name: String,
    pub described: bool,
}

/// The constants of a module.
pub fn constants(module: &Module) -> Vec<Constant> {
    let lines: Vec<&str> = module.text.lines().collect();
    let named = |(k, code): (usize, &str)| {
        let name = constant_of(code)?;
        let above = lines[..k].iter().rev().find(|line| !line.starts_with("#["));
        Some(Constant { name: name.into(), described: above.is_some_and(|line| line.starts_with("///")) })
    };
    module.code.lines().enumerate().filter_map(named).collect()
}

/// The name that a line declares as a constant of its module.
fn constant_of(line: &str) -> Option<&str> {
    let rest = match line.strip_prefix("pub") {
        // `pub `, `pub(crate) ` and the like.
        Some(rest) => {
            rest.trim_start_matches(|c: char| c == '(' || c == ')' || c == ':' || c.is_alphanumeric()).trim_start()
        }
        None => line,
    };
    let name = rest.strip_prefix("const ")?.split(':').next()?.trim();
    name.chars().all(|c| c.is_ascii_uppercase() || c.is_ascii_digit() || c == '_').then_some(name)
}

#[test]
fn what_is_a_constant() {
    assert_eq!(constant_of("const NEAR: f64 = 0.3;"), Some("NEAR"));
    assert_eq!(constant_of("pub(super) const NEAR_2: f64 = 0.3;"), Some("NEAR_2"));
    assert_eq!(constant_of("pub const fn new() -> Self {"), None);
    assert_eq!(constant_of("    const INSIDE: f64 = 1.0;"), None);
}

#[test]
fn constants_have_a_comment_of_their_own() {
    let text = "/// Lines.\n#[rustfmt::skip]\nconst A: u8 = 1;\nconst B: u8 = 2;\n// C.\nconst C: u8 = 3;\n\
        #[cfg(test)]\nmod tests {\nconst D: u8 = 4;\n}\n";
    let modules = crate::source::modules_in(&[("lib.rs", text)]);
    let found: Vec<(String, bool)> = constants(&modules[0]).into_iter().map(|c| (c.name, c.described)).collect();
    assert_eq!(found, [("A", true), ("B", false), ("C", false)].map(|(name, is)| (name.to_string(), is)));
}
