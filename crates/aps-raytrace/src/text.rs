//! Text of files from elsewhere: its encoding, and errors for text that is not JSON.

use std::borrow::Cow;

/// The text of a JSON file: without its byte order mark, and with blanks for the record separators of RFC 8142, which no
/// JSON text can hold.
///
/// # Errors
/// A description of the fault and its remedy: no text at all, UTF-16, other bytes that are not UTF-8.
pub(crate) fn of_json(bytes: &[u8]) -> Result<Cow<'_, str>, String> {
    if bytes.starts_with(&[0x1f, 0x8b]) {
        return Err("it is compressed; unpack it: gunzip".into());
    }
    let is_wide = bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]);
    // The other half of a wide first character is what JSON can begin with.
    let is_start = |b: u8| b.is_ascii_whitespace() || b"{[".contains(&b);
    let is_half = matches!(bytes, [0, b, ..] | [b, 0, ..] if is_start(*b));
    if is_wide || is_half {
        return Err("it is in UTF-16; convert it: iconv -f UTF-16 -t UTF-8 OLD > NEW".into());
    }
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let text = std::str::from_utf8(bytes).map_err(|e| {
        let byte = e.valid_up_to();
        format!("it is not UTF-8 from byte {byte} on; convert it with iconv")
    })?;
    let is_blank = |c: char| c.is_ascii_whitespace() || c == '\u{1e}';
    if text.trim_matches(is_blank).is_empty() {
        return Err("the file is empty".into());
    }
    Ok(match text.contains('\u{1e}') {
        true => text.replace('\u{1e}', " ").into(),
        false => text.into(),
    })
}

/// The parser's words, or the name of a number that JSON does not have.
pub(crate) fn json_error(text: &str, error: &serde_json::Error) -> String {
    not_a_number(text, error).unwrap_or_else(|| error.to_string())
}

fn not_a_number(text: &str, error: &serde_json::Error) -> Option<String> {
    let mut lines = text.as_bytes().split(|&b| b == b'\n');
    let line = lines.nth(error.line().checked_sub(1)?)?;
    let at = error.column().checked_sub(1)?.min(line.len());
    let is_word = |b: &u8| b.is_ascii_alphabetic() || matches!(b, b'-' | b'+');
    let start = at - line[..at].iter().rev().take_while(|b| is_word(b)).count();
    let end = at + line[at..].iter().take_while(|b| is_word(b)).count();
    let word = std::str::from_utf8(&line[start..end]).ok()?;
    let name = word.trim_start_matches(['-', '+']).to_ascii_lowercase();
    matches!(name.as_str(), "nan" | "inf" | "infinity").then(|| {
        let (line, column) = (error.line(), start + 1);
        format!("{word} at line {line} column {column}: JSON has no such number; leave it out")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_and_separators_are_taken_off() {
        assert_eq!(of_json(b"\xef\xbb\xbf[1]").unwrap(), "[1]");
        assert_eq!(of_json(b"\x1e{}\n\x1e{}\n").unwrap(), " {}\n {}\n");
    }

    #[test]
    fn other_encodings_are_named() {
        let wide = |unit: fn(u16) -> [u8; 2]| "[1]".encode_utf16().flat_map(unit).collect();
        let (little, big): (Vec<u8>, Vec<u8>) = (wide(u16::to_le_bytes), wide(u16::to_be_bytes));
        let marked = [&[0xff, 0xfe], &little[..]].concat();
        for bytes in [&little, &big, &marked] {
            let error = of_json(bytes).unwrap_err();
            assert!(
                error.contains("UTF-16") && error.contains("iconv"),
                "{error}"
            );
        }
        let error = of_json(b"[\"K\xf6ln\"]").unwrap_err();
        assert!(error.contains("byte 3"), "{error}");
        for bytes in [&b""[..], b" \r\n", b"\xef\xbb\xbf", b"\x1e\n"] {
            assert!(of_json(bytes).unwrap_err().contains("empty"));
        }
    }

    #[test]
    fn numbers_that_json_lacks_are_named_with_their_place() {
        for (text, expected) in [
            ("{\"a\": NaN}", "NaN at line 1 column 7"),
            ("[1,\n nan]", "nan at line 2 column 2"),
            ("[-Infinity]", "-Infinity at line 1 column 2"),
            ("[Infinity", "Infinity at line 1 column 2"),
        ] {
            let error = serde_json::from_str::<serde_json::Value>(text).unwrap_err();
            let words = json_error(text, &error);
            assert!(words.contains(expected), "{text}: {words}");
        }
        for text in ["[nul]", "", "[", "{\"NaN\" 1}", "[1}"] {
            let error = serde_json::from_str::<serde_json::Value>(text).unwrap_err();
            assert_eq!(json_error(text, &error), error.to_string());
        }
    }
}
