//! Whether the cells beside interfaces resolved the zones in which they softened.

use crate::case::Case;
use crate::comm::Comm;
use crate::interface::{FEWEST, zone_length};
use crate::output::history::Table;
use crate::solve::Model;

/// Damage that differs by less along an interface is even, and needs no resolution.
const UNEVEN: f64 = 0.02;

/// What is to be said of interfaces that have softened unevenly on cells that do not resolve their
/// cohesive zones. Collective; rank 0 has the history.
pub fn unresolved(
    comm: &Comm,
    case: &Case,
    model: &Model<'_>,
    history: Option<&Table>,
) -> Vec<String> {
    let names = case.interfaces.iter().map(|interface| interface.name.as_str());
    let mut spreads: Vec<f64> =
        names.map(|name| history.map_or(0.0, |table| spread(table, name))).collect();
    comm.max(&mut spreads);
    let spacings = spacings(comm, model);
    let words = |(number, interface): (usize, &crate::case::InterfaceSpec)| {
        let (zone, across) = (zone_length(case, &model.mesh.facts, number)?, spacings[number]);
        (spreads[number] > UNEVEN && zone < FEWEST * across).then(|| {
            format!(
                "interface {} softened unevenly, and its cohesive zone, E' G/strength^2 = {zone:.3e} \
                 m, is not resolved by nodes {across:.3e} m apart: its damage and its tractions \
                 depend on the mesh; have nodes at most {:.3e} m apart along the interface \
                 (mesh.column.cells, grading, or refine)",
                interface.name,
                zone / FEWEST
            )
        })
    };
    case.interfaces.iter().enumerate().filter_map(words).collect()
}

/// The most by which damage differs along an interface at an instant after which it has grown.
fn spread(table: &Table, name: &str) -> f64 {
    let column = |statistic: &str| table.column(&format!("{name}.damage.{statistic}"));
    let (Some(min), Some(max), Some(mean)) = (column("min"), column("max"), column("mean")) else {
        return 0.0;
    };
    let mut before = 0.0;
    let mut most = 0.0_f64;
    for row in &table.rows {
        let (Some(min), Some(max), Some(mean)) = (row[min], row[max], row[mean]) else { continue };
        if mean > before {
            most = most.max(max - min);
        }
        before = mean;
    }
    most
}

/// Of each interface, how far nodes are apart at most where it has softened (m). Collective.
fn spacings(comm: &Comm, model: &Model<'_>) -> Vec<f64> {
    let (problem, mesh) = (&model.stepper.problem, &model.mesh);
    let (all, state) = (&problem.all, &problem.interfaces);
    let mut grown = vec![0.0; all.nodes.len()];
    for (index, (history, start)) in state.committed.iter().zip(&state.initial).enumerate() {
        let rows = &all.secondary[index];
        let law = state.laws[rows.interface].spec.law();
        grown[rows.node as usize] = law.damage(*history) - law.damage(*start);
    }
    all.nodes.update_ghosts(&mut grown, 1);
    let mut spacings = vec![0.0_f64; model.sides.len()];
    for (spacing, sides) in spacings.iter_mut().zip(&model.sides) {
        for facet in mesh.on_lip(sides.interface, sides.secondary) {
            let (shape, nodes) = mesh.lip_nodes(sides.secondary, *facet);
            let is_softened = nodes.iter().any(|node| {
                let local = all.nodes.local(mesh.nodes.names[*node as usize]);
                local.is_some_and(|local| grown[local as usize] > 0.0)
            });
            if is_softened {
                let points = nodes.iter().map(|node| mesh.nodes.points[*node as usize]);
                *spacing = spacing.max(longest(points, shape.dim()) / shape.order() as f64);
            }
        }
    }
    comm.max(&mut spacings);
    spacings
}

/// The longest edge of a facet (m): exact where it lies along the axes, about so where not.
fn longest(points: impl Iterator<Item = [f64; 3]>, dim: usize) -> f64 {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for point in points {
        for axis in 0..3 {
            (low[axis], high[axis]) = (low[axis].min(point[axis]), high[axis].max(point[axis]));
        }
    }
    let along = [0, 1, 2].map(|axis| high[axis] - low[axis]);
    let diagonal = along.iter().map(|x| x * x).sum::<f64>().sqrt();
    along.into_iter().fold(diagonal / (dim as f64).sqrt(), f64::max)
}
