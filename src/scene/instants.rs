//! The instants that say most of a run.

use crate::output::history::Table;

/// An instant at which fields were written, and why it is drawn.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Instant {
    /// In s.
    pub time: f64,
    /// None where nothing sets it apart.
    pub why: Vec<&'static str>,
}

/// Most instants of a drawing, and fewest where there are as many.
pub(crate) const MOST: usize = 4;
const FEWEST: usize = 3;

/// Up to four of the instants at which fields were written, rising: where damage begins, where the
/// largest reaction is, where an interface is widest open, and the last; where these are the same,
/// others far from them.
pub(crate) fn chosen(written: &[f64], history: &Table) -> Vec<Instant> {
    let mut found: Vec<Instant> = Vec::new();
    let mut add = |time: Option<f64>, why: &'static str| {
        let nearest = |time: f64| {
            let off = |other: &f64| (other - time).abs();
            written.iter().copied().min_by(|a, b| off(a).total_cmp(&off(b)))
        };
        let Some(time) = time.filter(|time| written.contains(time)).or(time.and_then(nearest))
        else {
            return;
        };
        match found.iter_mut().find(|instant| instant.time == time) {
            Some(instant) => instant.why.push(why),
            None => found.push(Instant { time, why: vec![why] }),
        }
    };
    add(first(history, ".damage.max"), "first damage");
    add(largest(history, ".reaction_"), "largest reaction");
    add(largest(history, ".normal_jump.max"), "widest opening");
    add(written.last().copied(), "last");
    found.truncate(MOST);
    while let Some(time) = between(written, &found).filter(|_| found.len() < FEWEST) {
        found.push(Instant { time, why: Vec::new() });
    }
    found.sort_by(|a, b| a.time.total_cmp(&b.time));
    found
}

/// The instant that is farthest from those that are drawn, in the order of the instants; none where
/// all are.
fn between(written: &[f64], drawn: &[Instant]) -> Option<f64> {
    let is_drawn = |i: &usize| drawn.iter().any(|instant| instant.time == written[*i]);
    let away = |i: &usize| (0..written.len()).filter(is_drawn).map(|j| j.abs_diff(*i)).min();
    let others = (0..written.len()).filter(|i| !is_drawn(i));
    // The last of the farthest, whatever their number.
    others.max_by_key(away).map(|i| written[i])
}

/// Values less than this part of the largest are rounding.
const ROUNDING: f64 = 1e-9;

/// Times and values of all columns with these letters in their names.
fn values<'a>(
    history: &'a Table,
    letters: &'a str,
) -> impl Iterator<Item = (f64, f64)> + Clone + 'a {
    let time = history.column("time");
    let columns = history.columns.iter().enumerate();
    let columns = columns.filter(move |(_, name)| name.contains(letters));
    columns.flat_map(move |(column, _)| {
        history.rows.iter().filter_map(move |row| {
            let value = row[column].filter(|value| value.is_finite())?;
            Some((row[time?]?, value))
        })
    })
}

/// When a quantity was largest for the first time; none where it is nothing throughout.
fn largest(history: &Table, letters: &str) -> Option<f64> {
    let most = values(history, letters).map(|(_, v)| v.abs()).fold(0.0, f64::max);
    let reached = |(_, v): &(f64, f64)| v.abs() >= most * (1.0 - ROUNDING);
    let times = values(history, letters).filter(reached).map(|(time, _)| time);
    times.min_by(f64::total_cmp).filter(|_| most > 0.0)
}

/// When a quantity from 0 to 1 is above 0 for the first time.
fn first(history: &Table, letters: &str) -> Option<f64> {
    let above = values(history, letters).filter(|(_, v)| *v > ROUNDING).map(|(time, _)| time);
    above.min_by(f64::total_cmp)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn history() -> Table {
        let columns = ["time", "joint.damage.max", "joint.normal_jump.max", "top.reaction_z"];
        let rows = [
            [1.0, 0.0, 0.0, 3.0],
            [2.0, 0.1, 1e-4, -9.0],
            [3.0, 0.8, 5e-4, 2.0],
            [4.0, 1.0, 5e-4, 0.0],
        ];
        let rows = rows.iter().map(|row| row.iter().map(|v| Some(*v)).collect()).collect();
        Table { columns: columns.map(str::to_owned).to_vec(), rows }
    }

    #[test]
    fn the_instants_of_most_interest_are_drawn() {
        let told = |written: &[f64]| -> Vec<(f64, String)> {
            let found = chosen(written, &history()).into_iter();
            found.map(|instant| (instant.time, instant.why.join(", "))).collect()
        };
        let all = [
            (2.0, "first damage, largest reaction".to_owned()),
            (3.0, "widest opening".to_owned()),
            (4.0, "last".to_owned()),
        ];
        assert_eq!(told(&[1.0, 2.0, 3.0, 4.0]), all);
        // Those nearby stand for those that were not written.
        assert_eq!(told(&[3.0]).len(), 1);
        assert_eq!(told(&[]), []);
        assert_eq!(chosen(&[5.0], &Table::default())[0].why, ["last"]);
        // Without a history there are some all the same.
        let times = chosen(&[1.0, 2.0, 3.0, 4.0, 5.0], &Table::default());
        assert_eq!(times.iter().map(|t| t.time).collect::<Vec<_>>(), [1.0, 3.0, 5.0]);
    }
}
