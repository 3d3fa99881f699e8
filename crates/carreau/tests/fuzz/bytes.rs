//! Files broken at random: bytes, numbers, words and lines.

use crate::random::Random;

/// Larger files are cut.
const LARGEST: usize = 1 << 16;

/// Texts in the place of a number.
const NUMBERS: &[&str] = &[
    "-1",
    "0",
    "1",
    "2147483647",
    "2147483648",
    "4294967295",
    "4294967296",
    "18446744073709551615",
    "99999999999999999999",
    "1e308",
    "-1e999",
    "1e-320",
    "nan",
    "-inf",
    "0x10",
    "-",
    ".",
    "1e",
    "+5",
    "007",
    "1.5",
    "1,5",
    "",
];

/// Bytes in the place of binary numbers, lowest byte first; written in both orders.
const BINARY: &[[u8; 8]] = &[
    [0xff; 8],
    [0; 8],
    [1, 0, 0, 0, 0, 0, 0, 0],
    [0xff, 0xff, 0xff, 0x7f, 0, 0, 0, 0],
    [0, 0, 0, 0x80, 0, 0, 0, 0],
    [0, 0, 0, 0, 0, 0, 0xf0, 0x7f],
    [0, 0, 0, 0, 0, 0, 0xf8, 0x7f],
    [0, 0, 0x80, 0x7f, 0, 0, 0x80, 0x7f],
    [0, 0, 0, 0x40, 0, 0, 0, 0x40],
];

/// Breaks a file in one to three ways; `other` is one of the same format.
pub fn mangle(bytes: &mut Vec<u8>, other: &[u8], rng: &mut Random) {
    for _ in 0..1 + rng.below(3) {
        once(bytes, other, rng);
        bytes.truncate(LARGEST);
    }
}

fn once(bytes: &mut Vec<u8>, other: &[u8], rng: &mut Random) {
    match rng.below(11) {
        0 => flip(bytes, rng),
        1 => bytes.truncate(rng.below(bytes.len() + 1)),
        2 => {
            let block = bytes[rng.range(bytes.len())].to_vec();
            insert(bytes, &block, rng);
        }
        3 => {
            let range = rng.range(bytes.len());
            bytes.drain(range);
        }
        4 => {
            bytes.truncate(rng.below(bytes.len() + 1));
            bytes.extend_from_slice(&other[rng.below(other.len() + 1)..]);
        }
        5 | 6 => replace_number(bytes, rng),
        7 => replace_binary(bytes, rng),
        8 => swap_lines(bytes, rng),
        9 => {
            let block: Vec<u8> = (0..1 + rng.below(16)).map(|_| rng.next() as u8).collect();
            insert(bytes, &block, rng);
        }
        _ => shuffle_words(bytes, other, rng),
    }
}

fn insert(bytes: &mut Vec<u8>, block: &[u8], rng: &mut Random) {
    let at = rng.below(bytes.len() + 1);
    bytes.splice(at..at, block.iter().copied());
}

/// Up to eight bits, half of the time near the beginning, where headers are.
fn flip(bytes: &mut [u8], rng: &mut Random) {
    for _ in 0..1 + rng.below(8) {
        let within = if rng.one_in(2) { bytes.len().min(256) } else { bytes.len() };
        if let Some(byte) = bytes.get_mut(rng.below(within)) {
            *byte ^= 1 << rng.below(8);
        }
    }
}

/// The run of characters of a number around or behind a place.
fn number_at(bytes: &[u8], start: usize) -> Option<std::ops::Range<usize>> {
    let first = start + bytes.get(start..)?.iter().position(u8::is_ascii_digit)?;
    let is_part = |b: &u8| b.is_ascii_digit() || matches!(b, b'.' | b'-' | b'+' | b'e' | b'E');
    let length = bytes[first..].iter().take_while(|b| is_part(b)).count();
    Some(first..first + length)
}

fn replace_number(bytes: &mut Vec<u8>, rng: &mut Random) {
    let within = if rng.one_in(2) { bytes.len().min(512) } else { bytes.len() };
    if let Some(range) = number_at(bytes, rng.below(within)) {
        bytes.splice(range, rng.pick(NUMBERS).bytes());
    }
}

fn replace_binary(bytes: &mut [u8], rng: &mut Random) {
    let mut number = *rng.pick(BINARY);
    if rng.one_in(3) {
        number.reverse();
    }
    let width = *rng.pick(&[1, 2, 4, 8]);
    let within = if rng.one_in(2) { bytes.len().min(256) } else { bytes.len() };
    let at = rng.below(within);
    bytes.iter_mut().skip(at).zip(&number[..width]).for_each(|(byte, new)| *byte = *new);
}

fn swap_lines(bytes: &mut Vec<u8>, rng: &mut Random) {
    let mut lines: Vec<&[u8]> = bytes.split(|&b| b == b'\n').collect();
    let (a, b) = (rng.below(lines.len()), rng.below(lines.len()));
    lines.swap(a, b);
    *bytes = lines.join(&b'\n');
}

/// The head of the file, then words of it and of another one in any order.
fn shuffle_words(bytes: &mut Vec<u8>, other: &[u8], rng: &mut Random) {
    let is_blank = |b: &u8| b.is_ascii_whitespace();
    let words: Vec<&[u8]> = bytes.split(is_blank).chain(other.split(is_blank)).take(4000).collect();
    let soup: Vec<&[u8]> = (0..rng.below(60)).map(|_| words[rng.below(words.len())]).collect();
    let mut new = bytes[..rng.below(bytes.len().min(400) + 1)].to_vec();
    let gap = if rng.one_in(3) { b'\n' } else { b' ' };
    new.extend(soup.join(&gap));
    *bytes = new;
}
