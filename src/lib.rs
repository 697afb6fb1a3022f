//! Distributed nonlinear finite elements for columns and blocks crossed by cohesive interfaces.
//!
//! The modules stand in the order in which data flows; a module uses only those above it.
//!
//! A program that runs cases needs four of them: [`case`] to read or build one
//! ([`case::sections`]), [`law`] for its interfaces, [`run`] to run it ([`run::program`],
//! [`run::Run`]), [`results`] to read what came of it. The rest is the solver itself.

pub mod error;
pub mod comm;
pub mod fault;
pub mod signals;
pub mod timers;
pub mod hash;
pub mod graph;
pub mod simd;
pub mod petsc;
pub mod runtime;
pub mod sparse;
pub mod aggregation;
pub mod law;
pub mod input;
pub mod case;
pub mod element;
pub mod mesh;
pub mod partition;
pub mod space;
pub mod bulk;
pub mod interface;
pub mod assembly;
pub mod multigrid;
pub mod solve;
pub mod reduce;
pub mod output;
pub mod report;
pub mod results;
pub mod chart;
pub mod html;
pub mod scene;
pub mod study;
pub mod page;
pub mod cli;
pub mod run;

/// The example of the page is compiled.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
mod readme {}
