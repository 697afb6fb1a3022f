//! The first section: the version, and how numbers are written.

use serde::{Deserialize, Serialize};

use super::cursor::{Cursor, Encoding, shown};
use crate::error::Result;

/// The versions that are read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum Version {
    /// 2.2
    V2,
    /// 4.1
    V4,
}

const VERSIONS: &str = "2.2 and 4.1 are read: write the file with Mesh.MshFileVersion = 4.1";

/// Reads `$MeshFormat` up to its end, and sets the encoding of what follows.
pub(super) fn read(cursor: &mut Cursor) -> Result<Version> {
    let line = cursor.text()?;
    let words: Vec<_> = line.split_whitespace().collect();
    let &[version, kind, size] = words.as_slice() else {
        let what =
            format!("expected version, file type and size, found {}", shown(line.as_bytes()));
        return Err(cursor.error(what, VERSIONS));
    };
    let version = match version {
        "2.2" => Version::V2,
        "4.1" => Version::V4,
        other => {
            let what = format!("the version is {}", shown(other.as_bytes()));
            return Err(cursor.error(what, VERSIONS));
        }
    };
    match kind {
        "0" => {}
        "1" => {
            let is_wide = match (version, size) {
                (Version::V4, "8") => true,
                // The size of a `double`, where counts have the four bytes of an `int`.
                (Version::V2, "8") | (Version::V4, "4") => false,
                _ => {
                    let what = format!("numbers have {} bytes", shown(size.as_bytes()));
                    return Err(cursor.error(what, "write the file with a Gmsh of 64 bits"));
                }
            };
            let encoding = byte_order(cursor, is_wide)?;
            cursor.set_encoding(encoding);
        }
        other => {
            let what = format!("the file type is {}", shown(other.as_bytes()));
            return Err(cursor.error(what, "it is 0 for text and 1 for binary files"));
        }
    }
    Ok(version)
}

/// The encoding in which the next four bytes are a 1.
fn byte_order(cursor: &mut Cursor, is_wide: bool) -> Result<Encoding> {
    cursor.set_encoding(Encoding::Binary { is_big_endian: false, is_wide });
    match cursor.int()? {
        0x0000_0001 => Ok(Encoding::Binary { is_big_endian: false, is_wide }),
        0x0100_0000 => Ok(Encoding::Binary { is_big_endian: true, is_wide }),
        other => {
            let what = format!("the 1 that tells the order of bytes is {other}");
            Err(cursor.error(what, "copy the file in binary mode, or write it as text"))
        }
    }
}
