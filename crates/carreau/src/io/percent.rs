//! Percent encoding of names and addresses: `%20` for a blank.

/// The text with its `%xx` replaced by the bytes they stand for; bytes that are no UTF-8 are replaced.
pub fn decode(text: &[u8]) -> String {
    let mut bytes = Vec::with_capacity(text.len());
    let mut rest = text;
    while let [first, after @ ..] = rest {
        let hex = |k: usize| after.get(k).and_then(|&b| char::from(b).to_digit(16));
        match (first, hex(0), hex(1)) {
            (b'%', Some(high), Some(low)) => {
                bytes.push((16 * high + low) as u8);
                rest = &after[2..];
            }
            _ => {
                bytes.push(*first);
                rest = after;
            }
        }
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

/// The text as one printable ASCII word without `%` and quotes; [`decode`] gives it back.
pub fn encode(text: &str) -> String {
    let mut word = String::with_capacity(text.len());
    for b in text.bytes() {
        if b.is_ascii_graphic() && b != b'%' && b != b'"' {
            word.push(char::from(b));
        } else {
            word.push_str(&format!("%{b:02X}"));
        }
    }
    word
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn decoding_undoes_encoding(text in any::<String>()) {
            let word = encode(&text);
            prop_assert!(word.bytes().all(|b| b.is_ascii_graphic()));
            prop_assert_eq!(decode(word.as_bytes()), text);
        }
    }

    #[test]
    fn what_is_no_code_stays() {
        assert_eq!(decode(b"100%"), "100%");
        assert_eq!(decode(b"%zz%4"), "%zz%4");
        assert_eq!(decode(b"a%20b%2f"), "a b/");
    }
}
