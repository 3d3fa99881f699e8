//! A tokeniser over bytes that knows its line, and the writing of numbers.

use super::source::Source;
use crate::error::{Error, Place, Result};

/// Walks through a text file word by word or line by line. Lines end with LF, CR LF or CR alone.
#[derive(Clone)]
pub struct Scanner<'a> {
    source: &'a Source<'a>,
    /// Byte offset of the next character.
    pub position: usize,
    line: u64,
    comment: Option<u8>,
    continued: bool,
    /// The bytes that end a word: blanks, line ends, the comment character.
    ends_word: [bool; 256],
}

#[allow(dead_code)] // one scanner for all text formats
impl<'a> Scanner<'a> {
    /// Starts at the first byte (a UTF-8 byte order mark is skipped). Where `comment` is given, that character and the
    /// rest of its line are blank.
    pub fn new(source: &'a Source<'a>, comment: Option<u8>) -> Self {
        let position = if source.bytes.starts_with(b"\xef\xbb\xbf") { 3 } else { 0 };
        let ends_word = std::array::from_fn(|b| is_blank(b as u8) || comment == Some(b as u8));
        Scanner { source, position, line: 1, comment, continued: false, ends_word }
    }

    /// A backslash at the end of a line joins the next line to it.
    pub fn with_continuation(mut self) -> Self {
        self.continued = true;
        self
    }

    /// An error at the current line.
    pub fn error(&self, what: impl Into<String>) -> Error {
        self.source.error(Place::Line(self.line), what)
    }

    /// Number of the current line, from 1.
    pub fn line_number(&self) -> u64 {
        self.line
    }

    /// Number of bytes left.
    pub fn remaining(&self) -> usize {
        self.source.bytes.len().saturating_sub(self.position)
    }

    /// Moves past blanks and comments, over line ends too when `across_lines`.
    #[inline]
    fn skip_blank(&mut self, across_lines: bool) {
        let bytes = self.source.bytes;
        while let Some(&b) = bytes.get(self.position) {
            match b {
                b'\n' | b'\r' => {
                    if !across_lines {
                        return;
                    }
                    self.end_line(b);
                }
                b' ' | b'\t' | 0x0b | 0x0c => self.position += 1,
                b'\\' if self.continued => match bytes.get(self.position + 1) {
                    Some(&end @ (b'\n' | b'\r')) => {
                        self.position += 1;
                        self.end_line(end);
                    }
                    _ => return,
                },
                _ if Some(b) == self.comment => {
                    let rest = &bytes[self.position..];
                    self.position += rest.iter().position(|&c| c == b'\n' || c == b'\r').unwrap_or(rest.len());
                }
                _ => return,
            }
        }
    }

    fn end_line(&mut self, b: u8) {
        self.position += 1;
        self.line += 1;
        if b == b'\r' && self.source.bytes.get(self.position) == Some(&b'\n') {
            self.position += 1;
        }
    }

    #[inline]
    fn bare_word(&mut self) -> Option<&'a [u8]> {
        let rest = &self.source.bytes[self.position..];
        let mut end = rest.iter().position(|&b| self.ends_word[usize::from(b)]).unwrap_or(rest.len());
        let line_ends = matches!(rest.get(end), Some(b'\n' | b'\r'));
        if self.continued && line_ends && rest[..end].ends_with(b"\\") {
            end -= 1;
        }
        self.position += end;
        (end > 0).then(|| &rest[..end])
    }

    /// The next word, on this line or a later one; `None` at the end of the file.
    pub fn word(&mut self) -> Option<&'a [u8]> {
        self.skip_blank(true);
        self.bare_word()
    }

    /// The next word of the current line; `None` at its end.
    pub fn word_on_line(&mut self) -> Option<&'a [u8]> {
        self.skip_blank(false);
        self.bare_word()
    }

    /// The rest of the line without blanks at its ends: a name that may contain blanks. A comment begins only behind a
    /// blank here, since `Material#25` is a name.
    pub fn rest_of_line(&mut self) -> &'a [u8] {
        self.skip_blank(false);
        let rest = &self.source.bytes[self.position..];
        let end = rest.iter().position(|&b| b == b'\n' || b == b'\r').unwrap_or(rest.len());
        self.position += end;
        let comment = rest[..end].windows(2).position(|w| is_blank(w[0]) && Some(w[1]) == self.comment);
        let mut name = &rest[..comment.unwrap_or(end)];
        while let [start @ .., last] = name
            && is_blank(*last)
        {
            name = start;
        }
        name
    }

    /// The numbers on the rest of the line, into `out`; returns how many there are (those beyond `out` are not read).
    pub fn floats_on_line(&mut self, out: &mut [f64], what: &str) -> Result<usize> {
        for (k, value) in out.iter_mut().enumerate() {
            let Some(word) = self.word_on_line() else { return Ok(k) };
            match parse_float(word) {
                Some(x) => *value = x,
                None => return Err(self.error(format!("{what} is expected, found '{}'", shown(word)))),
            }
        }
        Ok(out.len())
    }

    /// The next word without moving on.
    pub fn peek(&mut self) -> Option<&'a [u8]> {
        let (position, line) = (self.position, self.line);
        let word = self.word();
        (self.position, self.line) = (position, line);
        word
    }

    /// Moves to the start of the next line; `false` at the end of the file.
    pub fn next_line(&mut self) -> bool {
        let rest = &self.source.bytes[self.position..];
        match rest.iter().position(|&b| b == b'\n' || b == b'\r') {
            Some(end) => {
                self.position += end;
                self.end_line(rest[end]);
                true
            }
            None => {
                self.position = self.source.bytes.len();
                false
            }
        }
    }

    /// The next word, which must exist.
    pub fn expect_word(&mut self, what: &str) -> Result<&'a [u8]> {
        match self.word() {
            Some(word) => Ok(word),
            None => Err(self.error(format!("the file ends where {what} is expected"))),
        }
    }

    /// The next word as a number; Fortran exponents (1D5) are understood.
    pub fn float(&mut self, what: &str) -> Result<f64> {
        let word = self.expect_word(what)?;
        parse_float(word).ok_or_else(|| self.error(format!("{what} is expected, found '{}'", shown(word))))
    }

    /// The next word as an integer.
    pub fn integer(&mut self, what: &str) -> Result<i64> {
        let word = self.expect_word(what)?;
        parse_integer(word).ok_or_else(|| self.error(format!("{what} is expected, found '{}'", shown(word))))
    }

    /// The next word as a count of records that take at least `size` bytes each: checked against the rest of the file.
    pub fn count(&mut self, size: usize, what: &str) -> Result<usize> {
        let n = self.integer(what)?;
        // The last record needs no separator after it.
        if n >= 0 && (n as u64) <= (self.remaining() as u64 + 1) / size.max(1) as u64 {
            return Ok(n as usize);
        }
        Err(self.error(format!("{what} is {n}, the rest of the file is {} bytes", self.remaining())))
    }

    /// The next word as the index of one of `limit` elements, counted from `base`.
    pub fn index(&mut self, base: i64, limit: usize, what: &str) -> Result<u32> {
        let k = self.integer(what)?;
        match k.checked_sub(base) {
            Some(k) if k >= 0 && (k as u64) < limit as u64 && k < i64::from(u32::MAX) => Ok(k as u32),
            _ => Err(self.error(format!("{what} {k} does not exist, there are {limit} (counted from {base})"))),
        }
    }
}

/// Blanks and line ends: everything that separates words.
#[inline]
fn is_blank(b: u8) -> bool {
    matches!(b, b' ' | b'\t'..=b'\r')
}

/// A word as it may be shown in a message: short, printable.
pub fn shown(word: &[u8]) -> String {
    let text: String = String::from_utf8_lossy(word).chars().filter(|c| !c.is_control()).take(40).collect();
    if word.len() > 40 { text + "…" } else { text }
}

/// A number in any common notation, exactly rounded to the nearest double.
#[inline]
pub fn parse_float(word: &[u8]) -> Option<f64> {
    let digits = word.strip_prefix(b"+").unwrap_or(word);
    match fast_float2::parse::<f64, _>(digits) {
        Ok(x) => Some(x),
        Err(_) if digits.iter().any(|b| matches!(b, b'd' | b'D')) => {
            let plain: Vec<u8> = digits.iter().map(|b| if matches!(b, b'd' | b'D') { b'e' } else { *b }).collect();
            fast_float2::parse(&plain).ok()
        }
        Err(_) => None,
    }
}

/// A decimal integer that fits 64 bits.
#[inline]
pub fn parse_integer(word: &[u8]) -> Option<i64> {
    let (negative, digits) = match word {
        [b'-', rest @ ..] => (true, rest),
        [b'+', rest @ ..] => (false, rest),
        _ => (false, word),
    };
    if digits.is_empty() {
        return None;
    }
    let mut value: i64 = 0;
    for &d in digits {
        if !d.is_ascii_digit() {
            return None;
        }
        value = value.checked_mul(10)?.checked_sub(i64::from(d - b'0'))?;
    }
    if negative { Some(value) } else { value.checked_neg() }
}

/// Appends the shortest text that reads back to the same double.
pub fn push_float(out: &mut Vec<u8>, x: f64) {
    out.extend_from_slice(short_float(&mut ryu::Buffer::new(), x).as_bytes());
}

fn short_float(buffer: &mut ryu::Buffer, x: f64) -> &str {
    let text = buffer.format(x);
    text.strip_suffix(".0").unwrap_or(text)
}

/// Appends an integer.
pub fn push_integer(out: &mut Vec<u8>, k: impl itoa::Integer) {
    out.extend_from_slice(itoa::Buffer::new().format(k).as_bytes());
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn words_and_lines_with_all_line_ends() {
        let source = Source { path: Path::new("t"), bytes: b"\xef\xbb\xbfa b # x\r\nc\rd\n\n e" };
        let mut s = Scanner::new(&source, Some(b'#'));
        let mut seen = Vec::new();
        while let Some(w) = s.word() {
            seen.push((shown(w), s.line_number()));
        }
        let want = [("a", 1), ("b", 1), ("c", 2), ("d", 3), ("e", 5)].map(|(w, l)| (w.to_string(), l));
        assert_eq!(seen, want);
    }

    #[test]
    fn a_backslash_joins_lines() {
        let source = Source { path: Path::new("t"), bytes: b"a b\\\n \\\r\nc\\d\ne" };
        let mut s = Scanner::new(&source, None).with_continuation();
        let mut line = Vec::new();
        while let Some(w) = s.word_on_line() {
            line.push(shown(w));
        }
        assert_eq!(line, ["a", "b", "c\\d"]);
        assert_eq!(s.line_number(), 3);
        assert!(s.next_line());
        assert_eq!(s.word(), Some(&b"e"[..]));
    }

    #[test]
    fn names_keep_blanks_and_inner_comment_marks() {
        let source = Source { path: Path::new("t"), bytes: b"g  a b#1 \t# x\ng\ng #c" };
        let mut s = Scanner::new(&source, Some(b'#'));
        let mut names = Vec::new();
        while s.word_on_line().is_some() {
            names.push(shown(s.rest_of_line()));
            s.next_line();
        }
        assert_eq!(names, ["a b#1", "", ""]);
    }

    #[test]
    fn numbers() {
        assert_eq!(parse_float(b"+1.5D2"), Some(150.0));
        assert_eq!(parse_float(b"1.e-0"), Some(1.0));
        assert_eq!(parse_float(b"1,5"), None);
        assert_eq!(parse_integer(b"-9223372036854775808"), Some(i64::MIN));
        assert_eq!(parse_integer(b"9223372036854775808"), None);
        assert_eq!(parse_integer(b"1.0"), None);
        for x in [0.1, -0.0, 1e300, 5e-324, 1.0, f64::MAX] {
            let mut text = Vec::new();
            push_float(&mut text, x);
            assert_eq!(parse_float(&text).map(f64::to_bits), Some(x.to_bits()));
        }
    }

    #[test]
    fn counts_are_checked_against_the_file() {
        let source = Source { path: Path::new("t"), bytes: b"1000000000 1 2 3" };
        assert!(Scanner::new(&source, None).count(6, "number of vertices").is_err());
    }
}
