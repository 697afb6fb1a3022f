//! How cells are shared out.

/// How the cells are shared out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// By METIS, least surface between the ranks.
    Metis,
    /// Every cell to the rank that a hash of its name gives: the worst that can happen to the
    /// parallel code, for tests.
    Scattered,
}

impl Method {
    /// The method asked for by the environment: tests set `COLUMN_HPC_PARTITION=scattered`.
    pub fn from_environment() -> Self {
        match std::env::var("COLUMN_HPC_PARTITION").as_deref() {
            Ok("scattered") => Self::Scattered,
            _ => Self::Metis,
        }
    }
}

/// How the mesh of a file is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Import {
    /// In slabs on all ranks where it is large.
    Auto,
    /// In slabs whatever its size, for tests.
    Slabs,
    /// Whole on one rank whatever its size.
    Whole,
}

impl Import {
    /// What is asked for by the environment: `COLUMN_HPC_IMPORT=slabs` or `whole`.
    pub fn from_environment() -> Self {
        match std::env::var("COLUMN_HPC_IMPORT").as_deref() {
            Ok("slabs") => Self::Slabs,
            Ok("whole") => Self::Whole,
            _ => Self::Auto,
        }
    }
}
