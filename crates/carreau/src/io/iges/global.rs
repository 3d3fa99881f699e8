//! Start and global section.

use super::words::VERSION;
use crate::brep::Brep;
use crate::io::cad::{CadOptions, Unit, push_real, resolution};

pub(super) fn ascii(text: &str) -> String {
    text.chars().map(|c| if (' '..='~').contains(&c) { c } else { '?' }).take(60).collect()
}

/// `4Htext`
pub(super) fn hollerith(text: &str) -> String {
    let text = ascii(text);
    format!("{}H{text}", text.len())
}

fn real(x: f64) -> String {
    let mut text = Vec::new();
    push_real(&mut text, x, b'D');
    String::from_utf8_lossy(&text).into_owned()
}

/// The 26 fields of the global section, each with its delimiter (section 2.2.4.3).
pub(super) fn global_fields(brep: &Brep, options: &CadOptions) -> Vec<String> {
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
pub(super) fn push_lines(out: &mut Vec<u8>, section: u8, fields: &[String]) -> u32 {
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
