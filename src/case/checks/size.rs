//! How large a case may be: refused before memory is asked for.

use super::checker::Checker;
use crate::case::{Case, Cells, ColumnSpec, InterfaceSpec, Material};

/// The largest number of unknowns that 32-bit indices can number.
const MOST_UNKNOWNS: u128 = i32::MAX as u128;
/// Most planes between cells, of all bodies along all axes: what every rank holds of the mesh.
const MOST_PLANES: u128 = 4_000_000;
/// Most values in `history.csv`, all of which stay in memory and in every checkpoint.
const MOST_VALUES: usize = 4_000_000;

impl Checker<'_> {
    /// Refuses a mesh that cannot be numbered, before memory is asked for.
    pub(super) fn cells(
        &mut self,
        column: &ColumnSpec,
        refine: u32,
        materials: &[Material],
        interfaces: &[InterfaceSpec],
        flow: bool,
    ) {
        if let Cells::Bodies(bodies) = &column.cells
            && bodies.len() != interfaces.len() + 1
        {
            let (found, wanted) = (bodies.len(), interfaces.len() + 1);
            let reason =
                format!("has {found} bodies, but {} interface(s) make {wanted}", interfaces.len());
            self.add("mesh.column.bodies", reason);
            return;
        }
        self.thickness(column, interfaces);
        let count = |number: Option<u128>| match number {
            None => "more than 1e38".to_owned(),
            Some(n) if n < 1_000_000_000_000 => n.to_string(),
            Some(n) => format!("{:.1e}", n as f64),
        };
        let cuts = interfaces.len() + materials.iter().filter(|m| m.z.is_some()).count();
        let unknowns = column.displacement_unknowns(refine, interfaces.len(), cuts);
        // At most one pressure for each node.
        let pressures = |n: u128| if flow { n / self.dim as u128 } else { 0 };
        let unknowns = unknowns.and_then(|n| n.checked_add(pressures(n)));
        let planes = column.planes(refine, interfaces.len(), cuts);
        let what = if unknowns.is_none_or(|n| n > MOST_UNKNOWNS) {
            format!(
                "unknowns: {} have up to {} displacement components{}; at most {MOST_UNKNOWNS} can \
                 be numbered",
                column.cell_words(refine),
                count(unknowns),
                if flow { " and pressures" } else { "" }
            )
        } else if planes.is_none_or(|n| n > MOST_PLANES) {
            format!(
                "planes: {} have up to {} planes between them, of all bodies along all axes; at \
                 most {MOST_PLANES} are held",
                column.cell_words(refine),
                count(planes)
            )
        } else {
            return;
        };
        let key = if matches!(column.cells, Cells::Uniform(_)) { "cells" } else { "bodies" };
        self.add(&format!("mesh.column.{key}"), format!("make too many {what}"));
    }

    /// Refuses a history that is too long.
    pub(super) fn history(&mut self, case: &Case) {
        let (instants, columns) = (case.time.len(), case.columns().len());
        if instants * columns > MOST_VALUES {
            let path =
                if case.control.is_some() { "control.dissipation.step" } else { "time.instants" };
            let reason = format!(
                "make history.csv too long: {instants} instants of {columns} columns; at most \
                 {MOST_VALUES} values are held"
            );
            self.add(path, reason);
        }
    }
}

impl ColumnSpec {
    /// The cells before refinement, in words.
    fn cell_words(&self, refine: u32) -> String {
        let grids = match &self.cells {
            Cells::Uniform(cells) => std::slice::from_ref(cells),
            Cells::Bodies(bodies) => bodies,
        };
        // A few bodies are listed, many are not.
        let mut words: Vec<String> =
            grids.iter().take(4).map(|[x, y, z]| format!("{x} x {y} x {z}")).collect();
        if grids.len() > words.len() {
            words.push("...".to_owned());
        }
        format!("{} cells, refined {refine} times,", words.join(" + "))
    }

    /// An upper bound of the number of planes between cells, of all bodies along all axes.
    fn planes(&self, refine: u32, interfaces: usize, cuts: usize) -> Option<u128> {
        let factor = 1_u128.checked_shl(refine)?;
        let of = |cells: &[usize; 3], bodies: usize| -> Option<u128> {
            let along =
                cells.iter().try_fold(cuts as u128 + 3, |sum, n| sum.checked_add(*n as u128));
            along?.checked_mul(factor)?.checked_mul(bodies as u128)
        };
        match &self.cells {
            Cells::Uniform(cells) => of(cells, interfaces + 1),
            Cells::Bodies(bodies) => {
                bodies.iter().try_fold(0_u128, |sum, cells| sum.checked_add(of(cells, 1)?))
            }
        }
    }
}
