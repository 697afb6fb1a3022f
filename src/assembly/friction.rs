//! What friction adds to the tangent of the condensed form, which it makes unsymmetric.
//!
//! Where lips are closed the force on the normal component of the secondary node, divided by its
//! weight, is the normal traction. Where they slide, the tangential tractions follow it by the
//! derivative in [`NodeState::friction`]: to the rows of the tangential jumps comes a multiple of
//! the row of the normal component, which is in no equation of its own.

use super::NodeState;
use crate::interface::JumpRows;

/// The forces on the tangential jumps of a node that follow from a force on its normal component,
/// which `at` gives by unknown; none where there is no friction. Local.
pub fn friction_on_jump(
    rows: &JumpRows<u32>,
    state: &NodeState,
    at: impl FnOnce(u32) -> f64,
) -> Option<[f64; 3]> {
    if state.friction == [0.0; 3] {
        return None;
    }
    let normal = rows.components - 1;
    let row = rows.rows[normal].as_ref().filter(|_| state.stuck[normal])?;
    let traction = -at(rows.own(normal)) / (row.weight * row.own);
    Some(std::array::from_fn(|c| match &rows.rows[c] {
        Some(row) if !state.stuck[c] => row.weight * state.friction[c] * traction,
        _ => 0.0,
    }))
}

/// Gives the forces on the jumps of a node to `add`, unknown by unknown. Local.
pub fn spread_friction(
    rows: &JumpRows<u32>,
    state: &NodeState,
    force: [f64; 3],
    mut add: impl FnMut(u32, f64),
) {
    for (c, force) in force.into_iter().enumerate().filter(|(_, force)| *force != 0.0) {
        let Some(row) = &rows.rows[c] else { continue };
        if state.jump[c] {
            add(rows.own(c), row.own * force);
        } else {
            row.spread(rows.own(c), force, &mut add);
        }
    }
}
