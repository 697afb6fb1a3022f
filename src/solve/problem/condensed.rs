//! Between displacements and the unknowns of the condensed form (docs/theory.md, section 4).

use crate::assembly::{CellSet, Discretization};
use crate::comm::Comm;
use crate::interface::JumpRows;
use crate::solve::model::interfaces::InterfaceState;

/// The force of jumps that are known before the linear solve: K v, where v moves the secondary
/// nodes so that stuck components take the jump their law asks for. Returns v and K v.
pub fn known_jumps(all: &Discretization, interfaces: &InterfaceState) -> (Vec<f64>, Vec<f64>) {
    let dim = all.dim;
    let mut v = vec![0.0; all.nodes.len() * dim];
    for (rows, response) in all.secondary.iter().zip(&interfaces.response) {
        for c in 0..dim {
            if let Some(row) = &rows.rows[c]
                && response.state.stuck[c]
            {
                v[rows.node as usize * dim + c] = response.defect[c] / row.own;
            }
        }
    }
    all.nodes.update_ghosts(&mut v, dim);
    let mut force = vec![0.0; v.len()];
    all.add_forces(CellSet::Layer, &v, &mut force, None);
    all.nodes.add_to_owners(&mut force, dim);
    (v, force)
}

/// Gives the primary side the forces of the secondary components that follow it though they are
/// not stuck. Collective.
pub fn fold(comm: &Comm, all: &Discretization, interfaces: &InterfaceState, f: &mut [f64]) {
    let dim = all.dim;
    let jumps = interfaces.response.iter().any(|r| r.state.jump.contains(&true));
    if !comm.any(jumps) {
        return;
    }
    let mut carried = vec![0.0; all.nodes.len() * dim];
    for (rows, response) in all.secondary.iter().zip(&interfaces.response) {
        for c in (0..dim).filter(|c| response.state.jump[*c]) {
            let Some(row) = &rows.rows[c] else { continue };
            let force = -f[rows.own(c) as usize] / row.own;
            row.spread_to_others(force, |unknown, f| carried[unknown as usize] += f);
        }
    }
    all.nodes.add_to_owners(&mut carried, dim);
    f.iter_mut().zip(carried).for_each(|(f, carried)| *f += carried);
}

/// Makes a correction of the unknowns one of the displacements: components that follow the
/// primary side do. Collective.
pub fn follow(all: &Discretization, interfaces: &InterfaceState, correction: &mut [f64]) {
    let dim = all.dim;
    let mut y = vec![0.0; all.nodes.len() * dim];
    y[..correction.len()].copy_from_slice(correction);
    all.nodes.update_ghosts(&mut y, dim);
    for (rows, response) in all.secondary.iter().zip(&interfaces.response) {
        for c in 0..dim {
            if let Some(row) = &rows.rows[c]
                && (response.state.stuck[c] || response.state.jump[c])
            {
                let followed = row.trace_of_others(|unknown| y[unknown as usize]);
                correction[rows.own(c) as usize] -= followed / row.own;
            }
        }
    }
}

/// The reverse of [`follow`], for a correction of which nothing is known in advance: 0 at stuck and
/// prescribed components. Collective.
pub fn to_unknowns(all: &Discretization, interfaces: &InterfaceState, correction: &mut [f64]) {
    let dim = all.dim;
    let mut y = vec![0.0; all.nodes.len() * dim];
    y[..correction.len()].copy_from_slice(correction);
    all.nodes.update_ghosts(&mut y, dim);
    for (rows, response) in all.secondary.iter().zip(&interfaces.response) {
        for c in (0..dim).filter(|c| response.state.jump[*c]) {
            let Some(row) = &rows.rows[c] else { continue };
            let followed = row.trace_of_others(|unknown| y[unknown as usize]);
            correction[rows.own(c) as usize] += followed / row.own;
        }
    }
    let free = free_components(all, interfaces);
    correction.iter_mut().zip(free).filter(|(_, free)| !free).for_each(|(c, _)| *c = 0.0);
}

/// The change of the forces on owned components with the owned unknowns `u`, where the state is
/// linearised: prescribed ones move as they do in `u`, and stuck ones follow. `beside` adds what
/// else changes with the displacements of local nodes, which it is given, to the forces on them.
/// Collective.
pub fn linear_forces(
    comm: &Comm,
    all: &Discretization,
    state: &InterfaceState,
    mut u: Vec<f64>,
    beside: impl FnOnce(&[f64], &mut [f64]),
) -> Vec<f64> {
    let dim = all.dim;
    follow(all, state, &mut u);
    u.resize(all.nodes.len() * dim, 0.0);
    all.nodes.update_ghosts(&mut u, dim);
    let mut force = vec![0.0; u.len()];
    all.add_forces(CellSet::All, &u, &mut force, None);
    beside(&u, &mut force);
    all.nodes.add_to_owners(&mut force, dim);
    let bulk = force.clone();
    let of_stuck = |rows: &JumpRows<u32>, c: usize| {
        let row = rows.rows[c].as_ref();
        row.map_or(0.0, |row| -bulk[rows.own(c) as usize] / (row.weight * row.own))
    };
    let traction = |index: usize, c: usize| {
        let (rows, state) = (&all.secondary[index], &state.response[index].state);
        if state.stuck[c] {
            return of_stuck(rows, c);
        }
        let free = (0..dim).filter(|d| !state.stuck[*d] && rows.rows[*d].is_some());
        let own: f64 = free.map(|d| state.tangent[c][d] * all.jump(index, d, &u)).sum();
        match state.friction[c] {
            0.0 => own,
            friction => own + friction * of_stuck(rows, dim - 1),
        }
    };
    all.add_tractions(traction, &mut force);
    force.truncate(all.nodes.owned * dim);
    fold(comm, all, state, &mut force);
    force
}

/// Marks the owned components whose row is not the identity.
pub fn free_components(all: &Discretization, interfaces: &InterfaceState) -> Vec<bool> {
    let dim = all.dim;
    let prescribed = &all.prescribed[..all.nodes.owned];
    let mut free: Vec<bool> = prescribed.iter().flat_map(|p| &p[..dim]).map(|p| !p).collect();
    for (rows, response) in all.secondary.iter().zip(&interfaces.response) {
        for c in (0..dim).filter(|c| rows.rows[*c].is_some() && response.state.stuck[*c]) {
            free[rows.node as usize * dim + c] = false;
        }
    }
    free
}
