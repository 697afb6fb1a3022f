//! Results on disk: the output directory, field files and the history table.
//!
//! Every file is complete or absent under its name, also when the run is killed: it is written
//! under a temporary name beside its place, flushed to the disk and renamed. Only the history table
//! grows in its place, row by row.

pub mod atomic;
pub mod checkpoint;
pub mod directory;
pub mod finite;
pub mod hdf5;
pub mod history;
pub mod lock;
pub mod publisher;
pub mod series;
pub mod vtkhdf;
pub mod atomic_hdf5;
