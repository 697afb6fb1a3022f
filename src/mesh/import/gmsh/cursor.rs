//! A place in the bytes of a file that moves over numbers, in text or in binary.

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};

/// What to do with a file that ends or breaks off where it must not.
pub(super) const DAMAGED: &str = "the file is cut off or damaged; write or copy it again";

/// What to do with a file whose contents Gmsh would not write.
pub(super) const REWRITE: &str =
    "open it in Gmsh, which repairs or explains it, and write it again";

/// No section has a longer name; lines without an end may be long.
const LONGEST_NAME: usize = 80;

/// How the numbers of a section are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum Encoding {
    Ascii,
    Binary {
        is_big_endian: bool,
        /// Sizes have 8 bytes, else 4.
        is_wide: bool,
    },
}

/// Reads a file from its beginning to its end; errors say the section and where in it.
pub(super) struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
    /// Where what was read last begins: the place of errors.
    mark: usize,
    /// `$Nodes`, say.
    section: String,
    encoding: Encoding,
}

impl<'a> Cursor<'a> {
    pub fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0, mark: 0, section: String::new(), encoding: Encoding::Ascii }
    }

    /// In the middle of a section, of which the bytes are a part.
    pub fn within(bytes: &'a [u8], section: &str, encoding: Encoding) -> Self {
        Self { bytes, at: 0, mark: 0, section: section.to_owned(), encoding }
    }

    /// Bytes that were read.
    pub fn position(&self) -> usize {
        self.at
    }

    /// How numbers are written.
    pub fn encoding(&self) -> Encoding {
        self.encoding
    }

    pub fn set_encoding(&mut self, encoding: Encoding) {
        self.encoding = encoding;
    }

    pub fn is_ascii(&self) -> bool {
        self.encoding == Encoding::Ascii
    }

    /// An error at what was read last.
    pub fn error(&self, what: impl std::fmt::Display, remedy: &str) -> Error {
        let place = if self.is_ascii() {
            let before = &self.bytes[..self.mark.min(self.bytes.len())];
            format!("line {}", 1 + before.iter().filter(|b| **b == b'\n').count())
        } else {
            format!("byte {}", self.mark)
        };
        let section = &self.section;
        let gap = if section.is_empty() { "" } else { ", " };
        Error::Input(format!("{section}{gap}{place}: {what}; {remedy}"))
    }

    fn rest(&self) -> &'a [u8] {
        self.bytes.get(self.at..).unwrap_or_default()
    }

    fn skip(&mut self, is_skipped: fn(&u8) -> bool) {
        self.at += self.rest().iter().take_while(|b| is_skipped(b)).count();
        self.mark = self.at;
    }

    /// The next line that is not blank, without the blanks around it; none at the end of the file.
    fn line(&mut self) -> Option<&'a [u8]> {
        self.skip(u8::is_ascii_whitespace);
        let rest = self.rest();
        let length = rest.iter().position(|b| *b == b'\n').unwrap_or(rest.len());
        self.at += length + usize::from(length < rest.len());
        (length > 0).then(|| rest[..length].trim_ascii())
    }

    /// A line of text, also in binary files.
    pub fn text(&mut self) -> Result<&'a str> {
        let line = self.line().ok_or_else(|| self.error("the file ends here", DAMAGED))?;
        std::str::from_utf8(line)
            .map_err(|_| self.error(format!("{} is no UTF-8", shown(line)), "save names in UTF-8"))
    }

    /// A count that stands alone in a line of text, also in binary files.
    pub fn text_count(&mut self) -> Result<u64> {
        let line = self.text()?;
        line.parse().map_err(|_| {
            self.error(format!("expected a count, found {}", shown(line.as_bytes())), DAMAGED)
        })
    }

    /// Moves into the next section; its name without the `$`, none at the end of the file.
    pub fn next_section(&mut self) -> Result<Option<&'a str>> {
        self.section.clear();
        let Some(line) = self.line() else { return Ok(None) };
        let name = line.strip_prefix(b"$").and_then(|name| std::str::from_utf8(name).ok());
        let is_name = |name: &&str| !name.starts_with("End") && name.len() <= LONGEST_NAME;
        let name = name.filter(is_name).ok_or_else(|| {
            let what = format!("expected the beginning of a section, found {}", shown(line));
            self.error(what, "a mesh file of Gmsh consists of sections, the first $MeshFormat")
        })?;
        self.section = format!("${name}");
        Ok(Some(name))
    }

    /// Moves behind the end of the section, which must come next.
    pub fn end_section(&mut self) -> Result<()> {
        let end = self.section.replacen('$', "$End", 1);
        match self.line() {
            None => Err(self.error(format!("the file ends before {end}"), DAMAGED)),
            Some(line) if line == end.as_bytes() => Ok(()),
            Some(line) => {
                let what = format!("expected {end}, found {}", shown(line));
                Err(self.error(what, "the counts and the contents of the section differ"))
            }
        }
    }

    /// Moves behind the end of the section, whatever comes before.
    pub fn skip_section(&mut self) -> Result<()> {
        let end = self.section.replacen('$', "$End", 1);
        let rest = self.rest();
        let is_end = |at: &usize| {
            let behind = rest.get(at + end.len());
            rest[*at..].starts_with(end.as_bytes()) && behind.is_none_or(u8::is_ascii_whitespace)
        };
        let dollars = rest.iter().enumerate().filter(|(_, b)| **b == b'$').map(|(at, _)| at);
        let Some(at) = dollars.into_iter().find(is_end) else {
            return Err(self.error(format!("the section has no {end}"), DAMAGED));
        };
        self.at += at + end.len();
        Ok(())
    }

    /// Moves to where a record begins: over blank lines, where it is text.
    pub fn begin(&mut self) {
        if self.is_ascii() {
            self.skip(u8::is_ascii_whitespace);
        }
    }

    /// Checks that a record ends here: with its line, where it is text.
    pub fn end(&mut self) -> Result<()> {
        if !self.is_ascii() {
            return Ok(());
        }
        self.skip(is_blank);
        match self.rest().first() {
            None | Some(b'\n') => Ok(()),
            Some(_) => {
                let token = self.token()?;
                let what = format!("expected the end of the line, found {}", shown(token));
                Err(self.error(what, DAMAGED))
            }
        }
    }

    /// Moves to the end of the line.
    pub fn skip_line(&mut self) {
        self.skip(|b| *b != b'\n');
    }

    /// The next word of the line.
    fn token(&mut self) -> Result<&'a [u8]> {
        self.skip(is_blank);
        let rest = self.rest();
        let length = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        if length == 0 {
            let end = if rest.is_empty() { "file" } else { "line" };
            return Err(
                self.error(format!("expected a number, found the end of the {end}"), DAMAGED)
            );
        }
        self.at += length;
        Ok(&rest[..length])
    }

    fn word<T: std::str::FromStr>(&mut self, what: &str) -> Result<T> {
        let token = self.token()?;
        let value = std::str::from_utf8(token).ok().and_then(|text| text.parse().ok());
        value.ok_or_else(|| self.error(format!("expected {what}, found {}", shown(token)), DAMAGED))
    }

    /// `N` bytes, the least significant first.
    fn binary<const N: usize>(&mut self, is_big_endian: bool) -> Result<[u8; N]> {
        self.mark = self.at;
        let Some((bytes, _)) = self.rest().split_first_chunk::<N>() else {
            let what = format!("expected {N} bytes, {} are left", self.rest().len());
            return Err(self.error(what, DAMAGED));
        };
        self.at += N;
        let mut bytes = *bytes;
        if is_big_endian {
            bytes.reverse();
        }
        Ok(bytes)
    }

    /// An `int` of the format.
    pub fn int(&mut self) -> Result<i64> {
        match self.encoding {
            Encoding::Ascii => self.word("an integer"),
            Encoding::Binary { is_big_endian, .. } => {
                Ok(i64::from(i32::from_le_bytes(self.binary(is_big_endian)?)))
            }
        }
    }

    /// A number or a count: a `size_t` of MSH 4.1, an `int` of MSH 2.2.
    pub fn size(&mut self) -> Result<u64> {
        match self.encoding {
            Encoding::Ascii => self.word("a number that is not negative"),
            Encoding::Binary { is_big_endian, is_wide: true } => {
                Ok(u64::from_le_bytes(self.binary(is_big_endian)?))
            }
            Encoding::Binary { is_big_endian, is_wide: false } => {
                Ok(u64::from(u32::from_le_bytes(self.binary(is_big_endian)?)))
            }
        }
    }

    /// A `double`, which must be finite.
    pub fn real(&mut self) -> Result<f64> {
        let value = match self.encoding {
            Encoding::Ascii => self.word("a coordinate")?,
            Encoding::Binary { is_big_endian, .. } => {
                f64::from_le_bytes(self.binary(is_big_endian)?)
            }
        };
        if value.is_finite() {
            Ok(value)
        } else {
            Err(self.error(format!("a coordinate is {value}"), REWRITE))
        }
    }

    /// A point of three coordinates.
    pub fn point(&mut self) -> Result<[f64; 3]> {
        Ok([self.real()?, self.real()?, self.real()?])
    }

    /// Checks that `count` things can be left in the file, each of at least so many bytes, before
    /// memory is asked for.
    pub fn check_room(&self, count: u64, ascii: usize, binary: usize, what: &str) -> Result<usize> {
        let each = if self.is_ascii() { ascii } else { binary };
        // The last line may lack its end.
        let room = (self.rest().len() + 1) / each.max(1);
        usize::try_from(count).ok().filter(|count| *count <= room).ok_or_else(|| {
            let left = self.rest().len();
            let what = format!("{count} {what} cannot stand in the {left} bytes that are left");
            self.error(what, DAMAGED)
        })
    }
}

fn is_blank(byte: &u8) -> bool {
    matches!(byte, b' ' | b'\t' | b'\r')
}

/// Text of a file as it is shown in messages: no more than its beginning, and only what prints.
pub(super) fn shown(text: &[u8]) -> String {
    const LONGEST: usize = 40;
    let text = String::from_utf8_lossy(&text[..text.len().min(4 * LONGEST)]);
    let printed: String = text.chars().map(|c| if c.is_control() { '?' } else { c }).collect();
    let short: String = printed.chars().take(LONGEST).collect();
    let dots = if printed.chars().count() > LONGEST { "..." } else { "" };
    format!("`{short}{dots}`")
}
