//! What charts of a run have in common.

use super::Figure;
use super::words::Unit;
use crate::chart::{Line, Look, Panel, Panels, Scale};

/// Points that have markers of their own.
const MOST_MARKED: usize = 60;
/// Points that have numbers of their own.
const MOST_LABELLED: usize = 16;
/// The style of what was computed.
pub(super) const COMPUTED: usize = 0;

/// Points that can be told apart are marked, and joined where `join` says so.
pub(super) fn look(count: usize, join: bool) -> Look {
    match (count <= MOST_MARKED, join) {
        (false, _) => Look::Joined,
        (true, true) => Look::Marked,
        (true, false) => Look::Points,
    }
}

/// What is laid along an axis.
pub(super) struct Axis<'a> {
    pub words: &'a str,
    pub unit: &'a Unit,
}

impl Axis<'_> {
    fn label(&self) -> String {
        self.unit.label(self.words)
    }
}

/// Numbers of all lines, scaled by units, in one pair of axes.
pub(super) fn panel(lines: Vec<Line>, x_axis: Axis<'_>, y_axis: Axis<'_>) -> Panel {
    let scaled = |(x, y): &(f64, f64)| (x_axis.unit.number(*x), y_axis.unit.number(*y));
    let lines: Vec<Line> = lines
        .into_iter()
        .map(|line| Line { points: line.points.iter().map(scaled).collect(), ..line })
        .collect();
    let points = || lines.iter().flat_map(|line| &line.points);
    Panel {
        x: Scale::over(points().map(|p| p.0), false),
        y: Scale::over(points().map(|p| p.1), false),
        x_label: x_axis.label(),
        y_label: y_axis.label(),
        lines,
        front: Vec::new(),
    }
}

/// The numbers of instants, from `first` on; none where there are too many to read.
pub(super) fn numbers(first: usize, count: usize) -> Vec<String> {
    let few = if count <= MOST_LABELLED { count } else { 0 };
    (first..first + few).map(|number| number.to_string()).collect()
}

/// Two panels to a figure.
pub(super) fn in_pairs(id: &str, title: &str, panels: Vec<Panel>) -> Vec<Figure> {
    let mut panels = panels.into_iter().peekable();
    let mut figures: Vec<Figure> = Vec::new();
    while panels.peek().is_some() {
        let id = match figures.len() {
            0 => id.to_owned(),
            number => format!("{id}-{}", number + 1),
        };
        let panels = panels.by_ref().take(2).collect();
        let panels = Panels { title: title.to_owned(), panels, below: true };
        figures.push(Figure { id, panels, caption: String::new() });
    }
    figures
}
