//! The text of a file, of bounded size.

use std::io::Read;
use std::path::Path;

use crate::error::{Error, Result};

/// Largest file that is read, in bytes.
pub(crate) const LARGEST: u64 = 1 << 20;

/// Reads the text of a file; `kind` is what messages call it.
///
/// # Errors
/// [`Error::Input`] when it is missing, unreadable, a directory, too large or not UTF-8.
pub(crate) fn read_text_of(kind: &str, path: &Path) -> Result<String> {
    let refuse = |reason: String| Error::Input(format!("{}: {reason}", path.display()));
    let unreadable = |error: std::io::Error| match error.kind() {
        std::io::ErrorKind::NotFound => refuse(format!("there is no such {kind}")),
        _ => refuse(format!("the {kind} cannot be read: {error}")),
    };
    let about = std::fs::metadata(path).map_err(unreadable)?;
    if about.is_dir() {
        return Err(refuse(format!("is a directory; name the {kind} in it")));
    }
    // The limit holds for pipes too, whose length is not known beforehand.
    let mut bytes = Vec::new();
    let file = std::fs::File::open(path).map_err(unreadable)?;
    file.take(LARGEST + 1).read_to_end(&mut bytes).map_err(unreadable)?;
    if bytes.len() as u64 > LARGEST {
        return Err(refuse(format!("the {kind} is larger than {LARGEST} bytes")));
    }
    String::from_utf8(bytes).map_err(|_| refuse(format!("the {kind} is not UTF-8 text")))
}
