//! What can go wrong, and the exit status that says so.

/// An error with the words a user needs: what was done, to what, with which numbers, what to try.
///
/// The variants are the ways a run ends before its end; each has its exit status.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Error {
    /// The command line, the case or the mesh is wrong.
    #[error("{0}")]
    Input(String),
    /// The numerics failed: no convergence at the smallest step, a bad element.
    #[error("{0}")]
    Numerics(String),
    /// A file, a library or the machine failed.
    #[error("{0}")]
    System(String),
    /// The run was asked to stop, and can go on from a checkpoint.
    #[error("{0}")]
    Stopped(String),
    /// An invariant of the program is broken.
    #[error("{0}\nThis is a bug in column-hpc: please report it with the case file.")]
    Bug(String),
}

/// The result of anything that can fail.
pub type Result<T> = std::result::Result<T, Error>;

impl Error {
    /// The exit status of a run that ends with this error.
    pub fn exit_status(&self) -> u8 {
        match self {
            Error::Input(_) => 2,
            Error::Numerics(_) => 3,
            Error::System(_) => 4,
            Error::Stopped(_) => 75,
            Error::Bug(_) => 101,
        }
    }

    /// The error of a failed operation on a file, with its path.
    pub fn file(what: &str, path: &std::path::Path, cause: impl std::fmt::Display) -> Self {
        Error::System(format!("{what} {}: {cause}", path.display()))
    }
}

/// A number as it is written in messages.
pub fn number_text(number: f64) -> String {
    let size = number.abs();
    if size != 0.0 && !(1e-3..1e6).contains(&size) {
        format!("{number:e}")
    } else {
        format!("{number}")
    }
}
