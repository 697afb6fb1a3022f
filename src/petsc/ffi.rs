//! The generated bindings; `wrapper.h` holds the list of what is bound.

#![allow(unsafe_code, missing_docs, dead_code)]
#![allow(non_camel_case_types, non_snake_case, non_upper_case_globals)]
#![allow(clippy::all, clippy::pedantic, clippy::undocumented_unsafe_blocks)]

include!(concat!(env!("OUT_DIR"), "/petsc.rs"));
