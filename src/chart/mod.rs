//! Charts as SVG and PNG, drawn without any font of the machine.

mod canvas;
mod labels;
mod map;
mod panel;
mod scale;
mod strokes;

pub(crate) use canvas::{png, svg};
pub(crate) use map::{Entry, Map};
pub(crate) use panel::{Line, Panel, Panels};
pub(crate) use scale::Scale;
pub(crate) use strokes::Look;

#[cfg(test)]
mod tests;
