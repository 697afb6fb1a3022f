//! The charts of a study, from its rows.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use super::file::Kind;
use super::measure::Row;
use super::plan::Plan;
use super::record::Ended;
use super::spec::{Chart, Quantity, Study};
use super::stats::{pareto, power_law};
use crate::chart::{Entry, Line, Look, Map, Panel, Panels, Scale, png, svg};
use crate::error::Result;
use crate::output::atomic;

/// A chart that was drawn.
pub(super) struct Drawn {
    pub svg: String,
    /// What is to be said beside it, in words.
    pub remarks: Vec<String>,
    /// Runs on its Pareto front: positions in the plan.
    pub front: Vec<usize>,
}

/// Draws a chart and writes it as `NAME.svg` and `NAME.png`.
///
/// # Errors
/// `System` with the path and the reason.
pub(super) fn draw(
    study: &Study,
    plan: &Plan,
    rows: &[Row],
    chart: &Chart,
    directory: &Path,
) -> Result<Drawn> {
    let rows = Rows { study, plan, chart, rows: chosen(plan, rows, chart) };
    let (svg, png, remarks, front) = match chart.kind {
        Kind::Map => {
            let figure = rows.map();
            (svg(&figure)?, png(&figure)?, Vec::new(), Vec::new())
        }
        Kind::Lines => {
            let (figure, front) = rows.lines();
            (svg(&figure)?, png(&figure)?, rows.left_out(), front)
        }
        Kind::StrongScaling | Kind::WeakScaling => {
            let (figure, remarks) = rows.scaling();
            (svg(&figure)?, png(&figure)?, remarks, Vec::new())
        }
    };
    atomic::write_text(&directory.join(format!("{}.svg", chart.name)), &svg)?;
    atomic::write_bytes(&directory.join(format!("{}.png", chart.name)), &png)?;
    Ok(Drawn { svg, remarks, front })
}

/// The rows that a chart is of; references are none of them.
fn chosen<'a>(plan: &Plan, rows: &'a [Row], chart: &Chart) -> Vec<&'a Row> {
    rows.iter()
        .filter(|row| row.run >= plan.references)
        .filter(|row| {
            let choices = &plan.runs[row.run].choices;
            chart.filter.iter().all(|(axis, choice)| choices[*axis] == *choice)
        })
        .collect()
}

struct Rows<'a> {
    study: &'a Study,
    plan: &'a Plan,
    chart: &'a Chart,
    rows: Vec<&'a Row>,
}

/// What is drawn over the number of ranks.
#[derive(Default)]
struct Scaling {
    times: Vec<Line>,
    efficiencies: Vec<Line>,
    /// The times that each series would have ideally.
    guides: Vec<Line>,
    /// Numbers of ranks that share cores.
    beyond: BTreeSet<usize>,
}

impl Rows<'_> {
    /// Rows by their labels on the axes of the series, in the order of the axes' values.
    fn series(&self) -> BTreeMap<Vec<usize>, Vec<&Row>> {
        let mut series: BTreeMap<Vec<usize>, Vec<&Row>> = BTreeMap::new();
        for row in &self.rows {
            let choices = &self.plan.runs[row.run].choices;
            let key = self.chart.series.iter().map(|axis| choices[*axis]).collect();
            series.entry(key).or_default().push(row);
        }
        series
    }

    /// What a line is called: `multigrid, order 2`.
    fn name(&self, key: &[usize]) -> String {
        let label = |(axis, choice): (&usize, &usize)| {
            let axis = &self.study.axes[*axis];
            let label = &axis.choices[*choice].label;
            // A bare number says nothing.
            let bare = label.starts_with(|c: char| c.is_ascii_digit());
            if bare { format!("{} {label}", axis.name) } else { label.clone() }
        };
        let labels: Vec<String> = self.chart.series.iter().zip(key).map(label).collect();
        labels.join(", ")
    }

    /// Whether an axis has numbers for all its labels.
    fn is_numbered(&self, quantity: &Quantity) -> bool {
        match quantity {
            Quantity::Axis(axis) => {
                self.study.axes[*axis].choices.iter().all(|choice| choice.number.is_some())
            }
            Quantity::Measure(_) => true,
        }
    }

    fn value(&self, row: &Row, quantity: &Quantity) -> Option<f64> {
        let run = &self.plan.runs[row.run];
        match quantity {
            Quantity::Axis(axis) if self.is_numbered(quantity) => {
                self.study.axes[*axis].choices[run.choices[*axis]].number
            }
            Quantity::Axis(axis) => Some(run.choices[*axis] as f64),
            Quantity::Measure(name) if name == "ranks" => Some(run.ranks as f64),
            Quantity::Measure(name) => row.value(name),
        }
    }

    fn scale(&self, quantity: &Quantity, numbers: &[f64], log: bool) -> Scale {
        match quantity {
            Quantity::Axis(axis) if !self.is_numbered(quantity) => {
                let choices = &self.study.axes[*axis].choices;
                Scale::Names(choices.iter().map(|choice| choice.label.clone()).collect())
            }
            // Ranks are few and whole.
            Quantity::Measure(name) if log && name == "ranks" => Scale::marked(numbers.to_vec()),
            Quantity::Axis(axis) if log && self.study.axes[*axis].name == "ranks" => {
                Scale::marked(numbers.to_vec())
            }
            _ => Scale::over(numbers.iter().copied(), log),
        }
    }

    fn lines(&self) -> (Panels, Vec<usize>) {
        let (x, y) = (&self.chart.x, &self.chart.y);
        let mut lines = Vec::new();
        let mut points: Vec<(usize, (f64, f64))> = Vec::new();
        for (style, (key, rows)) in self.series().into_iter().enumerate() {
            let mut line = Line::new(&self.name(&key), Vec::new(), Some(style), Look::Marked);
            for row in rows {
                let place = self.value(row, x);
                if row.has_results() {
                    let Some(point) = place.zip(self.value(row, y)) else { continue };
                    line.points.push(point);
                    points.push((row.run, point));
                    if let Quantity::Measure(name) = y
                        && let Some([low, _, high]) = row.values.get(name)
                        && low < high
                    {
                        line.spreads.push((point.0, *low, *high));
                    }
                } else if row.status.is_some() {
                    line.failed.extend(place);
                }
            }
            // What is measured need not rise with refinement: those points stay in the order of the
            // runs.
            if matches!(x, Quantity::Axis(_)) {
                line.points.sort_by(|a, b| a.0.total_cmp(&b.0));
            }
            if self.chart.fit
                && let Some((exponent, _)) = power_law(&line.points)
            {
                line.name = format!("{}: exponent {exponent:.2}", line.name);
            }
            lines.push(line);
        }
        let mut front: Vec<(usize, (f64, f64))> = Vec::new();
        if self.chart.pareto {
            // What differs by less than a millionth is no better.
            let rounded = |y: f64| if y > 0.0 { (y.ln() * 1e6).round() } else { f64::MIN };
            let all: Vec<(f64, f64)> = points.iter().map(|(_, (x, y))| (*x, rounded(*y))).collect();
            let on = pareto(&all);
            front = points.into_iter().zip(on).filter(|(_, on)| *on).map(|(p, _)| p).collect();
            front.sort_by(|a, b| a.1.0.total_cmp(&b.1.0));
        }
        let of = |pick: fn(&(f64, f64)) -> f64| -> Vec<f64> {
            lines.iter().flat_map(|line| &line.points).map(pick).collect()
        };
        let (mut xs, ys) = (of(|p| p.0), of(|p| p.1));
        xs.extend(lines.iter().flat_map(|line| &line.failed));
        let panel = Panel {
            x: self.scale(x, &xs, self.chart.log[0]),
            y: self.scale(y, &ys, self.chart.log[1]),
            x_label: self.chart.x_label.clone(),
            y_label: self.chart.y_label.clone(),
            lines,
            front: front.iter().map(|(_, point)| *point).collect(),
        };
        let runs = front.into_iter().map(|(run, _)| run).collect();
        (Panels { title: self.chart.title.clone(), panels: vec![panel], below: false }, runs)
    }

    /// What a logarithmic scale has no place for, in words.
    fn left_out(&self) -> Vec<String> {
        let axes = [(&self.chart.x, self.chart.log[0]), (&self.chart.y, self.chart.log[1])];
        let zero = |row: &&&Row| {
            let none = |(of, log): &(&Quantity, bool)| {
                *log && self.is_numbered(of) && self.value(row, of).is_some_and(|v| v <= 0.0)
            };
            row.has_results() && axes.iter().any(none)
        };
        let names: Vec<&str> =
            self.rows.iter().filter(zero).map(|row| &*self.plan.runs[row.run].name).collect();
        if names.is_empty() {
            return Vec::new();
        }
        vec![format!("Not shown, since 0 or less has no place on the scale: {}.", names.join("; "))]
    }

    /// Time on the left, efficiency on the right; the first number of ranks is what others are
    /// measured by.
    fn scaling(&self) -> (Panels, Vec<String>) {
        let Scaling { mut times, efficiencies, guides, beyond } = self.scaled();
        times.extend(guides);
        let of = |lines: &[Line], pick: fn(&(f64, f64)) -> f64| -> Vec<f64> {
            lines.iter().flat_map(|line| &line.points).map(pick).collect()
        };
        let x = Scale::marked(of(&times, |p| p.0));
        let y = Scale::over(of(&times, |p| p.1).into_iter(), true);
        let most = of(&efficiencies, |p| p.1).into_iter().fold(1.0, f64::max);
        let panel = |y: Scale, y_label: &str, lines: Vec<Line>| Panel {
            x: x.clone(),
            y,
            x_label: "ranks".to_owned(),
            y_label: y_label.to_owned(),
            lines,
            front: Vec::new(),
        };
        let panels = vec![
            panel(y, &self.chart.y_label, times),
            panel(Scale::Linear(0.0, 1.08 * most), "efficiency", efficiencies),
        ];
        let remarks = if beyond.is_empty() {
            Vec::new()
        } else {
            let ranks: Vec<String> = beyond.iter().map(usize::to_string).collect();
            let ranks = ranks.join(", ");
            vec![format!("Not shown: {ranks} ranks, which share the cores of the machine.")]
        };
        (Panels { title: self.chart.title.clone(), panels, below: false }, remarks)
    }

    /// The lines of both panels, series by series.
    fn scaled(&self) -> Scaling {
        let strong = self.chart.kind == Kind::StrongScaling;
        let mut scaling = Scaling::default();
        for (style, (key, rows)) in self.series().into_iter().enumerate() {
            let mut points: Vec<(f64, f64)> = Vec::new();
            let mut failed = Vec::new();
            for row in rows {
                let ranks = self.plan.runs[row.run].ranks;
                // Ranks that share cores say nothing of speed.
                if ranks > row.cores {
                    scaling.beyond.insert(ranks);
                } else if let Some(time) =
                    self.value(row, &self.chart.y).filter(|_| row.has_results())
                {
                    points.push((ranks as f64, time));
                } else if row.status.is_some() {
                    failed.push(ranks as f64);
                }
            }
            points.sort_by(|a, b| a.0.total_cmp(&b.0));
            let line = |points, failed| Line {
                failed,
                ..Line::new(&self.name(&key), points, Some(style), Look::Marked)
            };
            let efficiency = efficiencies_of(&points, strong);
            if let (Some(first), Some(last)) = (points.first(), points.last()) {
                let ideal = |ranks: f64| if strong { first.1 * first.0 / ranks } else { first.1 };
                let points = vec![*first, (last.0, ideal(last.0))];
                scaling.guides.push(Line::new("ideal", points, None, Look::Joined));
            }
            scaling.times.push(line(points, failed));
            scaling.efficiencies.push(line(efficiency, Vec::new()));
        }
        scaling
    }

    fn map(&self) -> Map {
        let axis = |quantity: &Quantity| match quantity {
            Quantity::Axis(axis) => *axis,
            // Only axes pass the check of a map.
            Quantity::Measure(_) => 0,
        };
        let (x, y) = (axis(&self.chart.x), axis(&self.chart.y));
        let labels = |axis: usize| -> Vec<String> {
            self.study.axes[axis].choices.iter().map(|choice| choice.label.clone()).collect()
        };
        let (columns, names) = (labels(x), labels(y));
        let cell = |i: usize, j: usize| -> Vec<Entry> {
            let here = |row: &&&Row| {
                let choices = &self.plan.runs[row.run].choices;
                choices[x] == i && choices[y] == j
            };
            let count = |status: Ended| {
                self.rows.iter().filter(here).filter(|row| row.status == Some(status)).count()
            };
            let entry = |status: Ended| Entry {
                word: status.words(),
                color: status.color(),
                count: count(status),
            };
            Ended::ALL.into_iter().map(entry).filter(|entry| entry.count > 0).collect()
        };
        let cells =
            (0..names.len()).map(|j| (0..columns.len()).map(|i| cell(i, j)).collect()).collect();
        Map {
            title: self.chart.title.clone(),
            x_label: self.chart.x_label.clone(),
            y_label: self.chart.y_label.clone(),
            columns,
            rows: names,
            cells,
        }
    }
}

/// The efficiency at every number of ranks, of pairs of ranks and time with rising ranks: the first
/// is 1. With `strong` the problem is the same for all, else it grows with the ranks.
fn efficiencies_of(points: &[(f64, f64)], strong: bool) -> Vec<(f64, f64)> {
    let Some((first, time)) = points.first().copied() else { return Vec::new() };
    let of = |(ranks, t): &(f64, f64)| {
        let ideal = if strong { time * first / ranks } else { time };
        (*ranks, ideal / t)
    };
    points.iter().map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn efficiency_is_by_the_first_number_of_ranks() {
        let close = |found: Vec<(f64, f64)>, exact: &[(f64, f64)]| {
            found.iter().zip(exact).all(|(f, e)| f.0 == e.0 && (f.1 - e.1).abs() < 1e-12)
        };
        let points = [(1.0, 8.0), (2.0, 5.0), (4.0, 4.0)];
        assert!(close(efficiencies_of(&points, true), &[(1.0, 1.0), (2.0, 0.8), (4.0, 0.5)]));
        assert!(close(efficiencies_of(&points, false), &[(1.0, 1.0), (2.0, 1.6), (4.0, 2.0)]));
        assert!(efficiencies_of(&[], true).is_empty());
    }
}
