//! Format of a block on disk: a line that describes the content, then the content.

use std::fmt::Write;

use sha2::{Digest, Sha256};

/// The first word of every block.
const MARKER: &str = "stickslip-block";

/// Result of reading a block.
#[derive(Debug, PartialEq)]
pub(super) enum Decoded {
    /// A complete block, with its content.
    Complete(Vec<u8>),
    /// A block of another sweep.
    OtherSweep,
    /// A damaged block, and what is wrong with it.
    Damaged(&'static str),
}

/// SHA-256 in hexadecimal.
pub(crate) fn digest(bytes: &[u8]) -> String {
    let mut text = String::with_capacity(64);
    for byte in Sha256::digest(bytes) {
        // Writing to a string cannot fail.
        let _ = write!(text, "{byte:02x}");
    }
    text
}

/// Bytes on disk of block `index` of the sweep with this fingerprint.
pub(super) fn encode(fingerprint: &str, index: usize, content: &[u8]) -> Vec<u8> {
    let (length, checksum) = (content.len(), digest(content));
    let mut bytes = format!("{MARKER} {fingerprint} {index} {length} {checksum}\n").into_bytes();
    bytes.extend_from_slice(content);
    bytes
}

/// Decodes `bytes` as block `index` of the sweep with this fingerprint.
pub(super) fn decode(fingerprint: &str, index: usize, bytes: &[u8]) -> Decoded {
    let Some((content, words)) = split(bytes) else {
        return Decoded::Damaged("cut short or no block");
    };
    let [marker, sweep, number, length, checksum] = words[..] else {
        return Decoded::Damaged("no block");
    };
    if marker != MARKER {
        return Decoded::Damaged("no block");
    }
    if number.parse() != Ok(index) {
        return Decoded::Damaged("another block under its name");
    }
    match length.parse::<usize>() {
        Ok(length) if content.len() < length => return Decoded::Damaged("cut short"),
        Ok(length) if content.len() == length => {}
        _ => return Decoded::Damaged("of another length than it says"),
    }
    if digest(content) != checksum {
        return Decoded::Damaged("changed since it was written");
    }
    // This check comes last, because a damaged block may have any fingerprint.
    if sweep != fingerprint {
        return Decoded::OtherSweep;
    }
    Decoded::Complete(content.to_vec())
}

/// Splits the content from the words of the first line.
fn split(bytes: &[u8]) -> Option<(&[u8], Vec<&str>)> {
    let end = bytes.iter().position(|byte| *byte == b'\n')?;
    let line = std::str::from_utf8(&bytes[..end]).ok()?;
    Some((&bytes[end + 1..], line.split(' ').collect()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_written_is_read() {
        for content in [&b""[..], b"1,2\n3,4\n", b"\n\0\xff"] {
            let found = decode("f", 7, &encode("f", 7, content));
            assert_eq!(found, Decoded::Complete(content.to_vec()));
        }
    }

    #[test]
    fn every_cut_and_every_changed_byte_is_noticed() {
        let whole = encode("fingerprint", 7, b"1.25,-3\n");
        for cut in 0..whole.len() {
            let found = decode("fingerprint", 7, &whole[..cut]);
            assert!(
                matches!(found, Decoded::Damaged(_)),
                "cut at {cut}: {found:?}"
            );
        }
        for place in 0..whole.len() {
            let mut changed = whole.clone();
            changed[place] ^= 1;
            let found = decode("fingerprint", 7, &changed);
            assert!(!matches!(found, Decoded::Complete(_)), "changed at {place}");
        }
    }

    #[test]
    fn a_renamed_block_and_one_of_another_sweep_are_told_apart() {
        let block = encode("ours", 7, b"x");
        assert!(matches!(decode("ours", 8, &block), Decoded::Damaged(_)));
        assert_eq!(decode("theirs", 7, &block), Decoded::OtherSweep);
    }

    #[test]
    fn the_digest_is_the_published_one() {
        // FIPS 180-2, appendix B.1.
        let published = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!(digest(b"abc"), published);
    }
}
