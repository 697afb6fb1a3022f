//! Charts as SVG and PNG, drawn without any font of the machine.

mod canvas;
mod labels;
mod map;
mod panel;
mod scale;
mod strokes;
mod units;

pub(crate) use canvas::{Anchor, Canvas, Drawn, Figure, png, svg, width};
pub(crate) use map::{Entry, Map};
pub(crate) use panel::{Line, Panel, Panels};
pub(crate) use scale::Scale;
pub(crate) use strokes::Look;
pub(crate) use units::{Unit, number};

#[cfg(test)]
mod tests;
