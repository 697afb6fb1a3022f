//! Bytes of a file by their places.

use std::fs::File;
use std::os::unix::fs::FileExt;

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};

/// Bytes that are looked through at once.
const CHUNK: usize = 1 << 20;

/// A place in a file.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Bytes {
    pub at: u64,
    pub length: u64,
}

/// Something with bytes, of which no more is read than is asked for.
pub trait Source {
    /// How many there are.
    fn length(&self) -> u64;

    /// Fills a buffer from a place on; all of it is there.
    ///
    /// # Errors
    /// `Input` when it cannot be read.
    fn fill(&self, at: u64, buffer: &mut [u8]) -> Result<()>;

    /// At most so many bytes from a place on: fewer at the end.
    ///
    /// # Errors
    /// As [`Source::fill`].
    fn read(&self, at: u64, most: usize) -> Result<Vec<u8>> {
        let left = self.length().saturating_sub(at);
        let mut buffer = vec![0; usize::try_from(left).unwrap_or(most).min(most)];
        self.fill(at, &mut buffer)?;
        Ok(buffer)
    }

    /// The place behind a text from a place on, where a blank or nothing follows it.
    ///
    /// # Errors
    /// As [`Source::fill`].
    fn find(&self, mut at: u64, text: &[u8]) -> Result<Option<u64>> {
        loop {
            let bytes = self.read(at, CHUNK + text.len())?;
            let is_here = |from: &usize| {
                let behind = bytes.get(from + text.len());
                bytes[*from..].starts_with(text) && behind.is_none_or(u8::is_ascii_whitespace)
            };
            let starts = (0..bytes.len()).filter(|from| bytes[*from] == text[0]);
            let is_last = bytes.len() < CHUNK + text.len();
            let whole = |from: &usize| is_last || from + text.len() < bytes.len();
            if let Some(from) = starts.into_iter().filter(whole).find(is_here) {
                return Ok(Some(at + (from + text.len()) as u64));
            }
            if is_last {
                return Ok(None);
            }
            at += CHUNK as u64;
        }
    }

    /// The place behind so many ends of lines; the last line may lack its own.
    ///
    /// # Errors
    /// `Input` when there are fewer.
    fn behind_lines(&self, mut at: u64, mut lines: u64) -> Result<u64> {
        while lines > 0 {
            let bytes = self.read(at, CHUNK)?;
            if bytes.is_empty() {
                return Err(Error::Input("the file ends within a block".into()));
            }
            let mut from = 0;
            while lines > 0 && from < bytes.len() {
                match bytes[from..].iter().position(|byte| *byte == b'\n') {
                    Some(length) => (from, lines) = (from + length + 1, lines - 1),
                    None => from = bytes.len(),
                }
            }
            at += from as u64;
        }
        Ok(at)
    }
}

impl Source for &[u8] {
    fn length(&self) -> u64 {
        (**self).len() as u64
    }

    fn fill(&self, at: u64, buffer: &mut [u8]) -> Result<()> {
        let from = usize::try_from(at).ok().and_then(|at| self.get(at..));
        let bytes = from.and_then(|bytes| bytes.get(..buffer.len()));
        let missing = || Error::Input("the file ends within a block".into());
        buffer.copy_from_slice(bytes.ok_or_else(missing)?);
        Ok(())
    }
}

/// A file that is open.
pub struct OpenFile {
    file: File,
    length: u64,
}

impl OpenFile {
    /// Opens a file.
    ///
    /// # Errors
    /// `Input` when it cannot be read.
    pub fn new(path: &std::path::Path) -> Result<Self> {
        let open = File::open(path).and_then(|file| Ok((file.metadata()?.len(), file)));
        let (length, file) = open.map_err(|cause| Error::Input(cause.to_string()))?;
        Ok(Self { file, length })
    }
}

impl Source for OpenFile {
    fn length(&self) -> u64 {
        self.length
    }

    fn fill(&self, at: u64, buffer: &mut [u8]) -> Result<()> {
        let read = self.file.read_exact_at(buffer, at);
        read.map_err(|cause| Error::Input(cause.to_string()))
    }
}
