//! The tangent matrix of the condensed form.
//!
//! Unknowns of the linear system are the displacements of all nodes; at a component whose jump is
//! known ("stuck") the secondary displacement is eliminated through its jump row, and its own row
//! becomes the identity. Prescribed components have identity rows and columns too. Only rows near
//! an interface depend on the state; they alone are set anew when it changes.

use super::friction::{friction_on_jump, spread_friction};
use super::{Discretization, NodeState, Pattern, TangentMatrix};
use crate::comm::Comm;
use crate::error::Result;

/// Sets the values of the tangent.
pub struct Tangent {
    pattern: Pattern,
    /// Cells with a node in an interface row.
    zone: Vec<u32>,
    /// Diagonal entry of identity rows (N/m): of the size of the others.
    pub diagonal: f64,
    assembled: bool,
}

/// How one component of one node appears in the unknowns of the coupled nodes, which are counted
/// node by node.
type Expansion = Vec<(usize, f64)>;

impl Tangent {
    /// `diagonal` must be the same on all ranks.
    pub fn new(all: &Discretization, mut pattern: Pattern, diagonal: f64) -> Self {
        pattern.forget_columns();
        let near = |cell: &u32| {
            all.cells.nodes(*cell as usize).iter().any(|n| pattern.is_interface_row[*n as usize])
        };
        let zone = (0..all.cells.len() as u32).filter(near).collect();
        Self { pattern, zone, diagonal, assembled: false }
    }

    /// Sets all values the first time, those of the interface rows later. `state` gives the state
    /// of every entry of `all.secondary`. Collective.
    ///
    /// # Errors
    /// `System` when PETSc refuses a value, for instance one outside the graph; on all ranks.
    pub fn assemble(
        &mut self,
        comm: &Comm,
        all: &Discretization,
        state: &[NodeState],
        matrix: &mut impl TangentMatrix,
    ) -> Result<()> {
        let first_time = !self.assembled;
        if first_time {
            matrix.clear()?;
        } else {
            matrix.clear_rows(&self.pattern.interface_rows, &all.nodes.numbers)?;
        }
        let filled = self.fill(all, state, first_time, matrix);
        comm.agree(filled)?;
        let assembled = matrix.finish(comm);
        comm.agree(assembled)?;
        self.assembled = true;
        Ok(())
    }

    /// Adds all values, or those of the interface rows. Local.
    fn fill(
        &self,
        all: &Discretization,
        state: &[NodeState],
        every_row: bool,
        matrix: &mut impl TangentMatrix,
    ) -> Result<()> {
        let mut work = Work::default();
        if every_row {
            for cell in 0..all.cells.len() {
                self.add_cell(all, state, cell, true, &mut work, matrix)?;
            }
        } else {
            for cell in &self.zone {
                self.add_cell(all, state, *cell as usize, false, &mut work, matrix)?;
            }
        }
        let owned = all.owned_secondary();
        for (rows, state) in all.secondary[..owned].iter().zip(state) {
            add_law(all, rows, state, matrix)?;
        }
        self.add_identity_rows(all, state, every_row, matrix)
    }

    fn add_cell(
        &self,
        all: &Discretization,
        state: &[NodeState],
        cell: usize,
        every_row: bool,
        work: &mut Work,
        matrix: &mut impl TangentMatrix,
    ) -> Result<()> {
        let nodes = all.cells.nodes(cell);
        let dim = all.dim;
        let stiffness = all.cell_matrix(cell, &mut work.cell);
        let near_interface = nodes.iter().any(|n| all.secondary_of[*n as usize].is_some());
        if near_interface {
            all.coupled_nodes(cell, &mut work.coupled);
        } else {
            work.coupled.clear();
            work.coupled.extend_from_slice(nodes);
        }
        let number = |n: &u32| all.nodes.numbers[*n as usize];
        work.columns.clear();
        work.columns.extend(work.coupled.iter().map(number));
        work.rows.clear();
        work.rows.extend(work.coupled.iter().map(|n| {
            if every_row || self.pattern.is_interface_row[*n as usize] { number(n) } else { -1 }
        }));
        let plain =
            !near_interface && nodes.iter().all(|n| all.prescribed[*n as usize] == [false; 3]);
        if plain {
            return matrix.add(&work.rows, &work.columns, stiffness);
        }
        let columns = expand_cell(all, state, cell, &work.coupled);
        let rows = rows_of_friction(all, state, cell, &work.coupled, &columns);
        let rows = rows.as_ref().unwrap_or(&columns);
        transform(stiffness, [rows, &columns], work.coupled.len() * dim, &mut work.values);
        matrix.add(&work.rows, &work.columns, &work.values)
    }

    /// The identity rows of prescribed and stuck components of owned nodes.
    fn add_identity_rows(
        &self,
        all: &Discretization,
        state: &[NodeState],
        every_row: bool,
        matrix: &mut impl TangentMatrix,
    ) -> Result<()> {
        let dim = all.dim;
        let mut block = vec![0.0; dim * dim];
        for node in 0..all.nodes.owned {
            if !every_row && !self.pattern.is_interface_row[node] {
                continue;
            }
            let identity = all.identity_components(state, node);
            if identity[..dim].contains(&true) {
                for c in 0..dim {
                    block[c * dim + c] = if identity[c] { self.diagonal } else { 0.0 };
                }
                let number = [all.nodes.numbers[node]];
                matrix.add(&number, &number, &block)?;
            }
        }
        Ok(())
    }
}

#[derive(Default)]
struct Work {
    /// Stiffness of the cell.
    cell: Vec<f64>,
    coupled: Vec<u32>,
    rows: Vec<i32>,
    columns: Vec<i32>,
    values: Vec<f64>,
}

/// The components of the nodes of a cell, one after the other, over the unknowns of `coupled`.
pub(super) fn expand_cell(
    all: &Discretization,
    state: &[NodeState],
    cell: usize,
    coupled: &[u32],
) -> Vec<Expansion> {
    let expand_node = |node: u32| (0..all.dim).map(move |c| expand(all, state, node, c, coupled));
    all.cells.nodes(cell).iter().flat_map(|node| expand_node(*node)).collect()
}

/// A component of a node over the unknowns of `coupled`: empty where prescribed, the jump row where
/// stuck, else itself, with the jump row where the jump is the unknown.
fn expand(
    all: &Discretization,
    state: &[NodeState],
    node: u32,
    component: usize,
    coupled: &[u32],
) -> Expansion {
    let dim = all.dim;
    let place = |node: u32, component: usize| {
        let place = coupled.iter().position(|c| *c == node).expect("a coupled node");
        place * dim + component
    };
    let own = |a: f64| (place(node, component), a);
    if all.prescribed[node as usize][component] {
        return Vec::new();
    }
    let Some(index) = all.secondary_of[node as usize] else { return vec![own(1.0)] };
    let NodeState { stuck, jump, .. } = &state[index as usize];
    let (stuck, jump) = (stuck[component], jump[component]);
    let row = all.secondary[index as usize].rows[component].as_ref();
    let follows = row.filter(|_| stuck || jump);
    let mut expansion: Expansion = follows
        .iter()
        .flat_map(|row| row.others.iter().map(|(n, a)| (*n, -a / row.own)))
        .map(|(unknown, a)| (unknown / dim as u32, unknown as usize % dim, a))
        .filter(|(node, component, _)| !all.prescribed[*node as usize][*component])
        .map(|(node, component, a)| (place(node, component), a))
        .collect();
    if row.is_none() || !stuck {
        expansion.push(own(1.0));
    }
    expansion
}

/// The rows of equations that the forces of a cell go to, where friction sends some to others than
/// the columns; none without it.
pub(super) fn rows_of_friction(
    all: &Discretization,
    state: &[NodeState],
    cell: usize,
    coupled: &[u32],
    columns: &[Expansion],
) -> Option<Vec<Expansion>> {
    let (dim, nodes) = (all.dim, all.cells.nodes(cell));
    let of = |node: &u32| all.secondary_of[*node as usize].map(|index| index as usize);
    if !nodes.iter().filter_map(of).any(|index| state[index].friction != [0.0; 3]) {
        return None;
    }
    let mut rows = columns.to_vec();
    for (place, index) in nodes.iter().enumerate().filter_map(|(i, n)| Some((i, of(n)?))) {
        let (jump, state) = (&all.secondary[index], &state[index]);
        let Some(unit) = friction_on_jump(jump, state, |_| 1.0) else { continue };
        spread_friction(jump, state, unit, |unknown, f| {
            let (node, component) = (unknown / dim as u32, unknown as usize % dim);
            if !all.prescribed[node as usize][component] {
                let at = coupled.iter().position(|c| *c == node).expect("a coupled node");
                rows[place * dim + dim - 1].push((at * dim + component, f));
            }
        });
    }
    Some(rows)
}

/// R^T K T, R = T without friction, over `width` unknowns.
fn transform(
    stiffness: &[f64],
    [rows, columns]: [&[Expansion]; 2],
    width: usize,
    values: &mut Vec<f64>,
) {
    values.clear();
    values.resize(width * width, 0.0);
    let mut row_of_kt = vec![0.0; width];
    for (k, rows) in stiffness.chunks_exact(columns.len()).zip(rows) {
        row_of_kt.fill(0.0);
        for (k, columns) in k.iter().zip(columns) {
            for (column, b) in columns {
                row_of_kt[*column] += k * b;
            }
        }
        for (row, a) in rows {
            let target = &mut values[row * width..][..width];
            target.iter_mut().zip(&row_of_kt).for_each(|(t, kt)| *t += a * kt);
        }
    }
}

/// Adds to `diagonal`, at all local nodes, what the tangent's has beyond that of the cells'
/// stiffness; entries of ghosts are to be added to the owners afterwards, those of identity rows
/// mean nothing. `state` gives the state of every entry of `all.secondary`. Local.
pub(super) fn transform_diagonal(all: &Discretization, state: &[NodeState], diagonal: &mut [f64]) {
    let dim = all.dim;
    let (mut coupled, mut buffer) = (Vec::new(), Vec::new());
    for cell in all.cells.layer() {
        let nodes = all.cells.nodes(*cell as usize);
        let stiffness = all.cell_matrix(*cell as usize, &mut buffer);
        all.coupled_nodes(*cell as usize, &mut coupled);
        let expansions = expand_cell(all, state, *cell as usize, &coupled);
        let n = expansions.len();
        // What each unknown moves: components of the cell's nodes, with their coefficients.
        let mut moved: Vec<Vec<(usize, f64)>> = vec![Vec::new(); coupled.len() * dim];
        for (i, rows) in expansions.iter().enumerate() {
            let own = nodes[i / dim] as usize * dim + i % dim;
            diagonal[own] -= stiffness[i * n + i];
            for (row, a) in rows {
                moved[*row].push((i, *a));
            }
        }
        for (unknown, moved) in moved.iter().enumerate() {
            let target = coupled[unknown / dim] as usize * dim + unknown % dim;
            for (i, a) in moved {
                let row = &stiffness[i * n..][..n];
                diagonal[target] += a * moved.iter().map(|(j, b)| row[*j] * b).sum::<f64>();
            }
        }
    }
    for (rows, state) in all.secondary[..all.owned_secondary()].iter().zip(state) {
        for c in (0..dim).filter(|c| !state.stuck[*c]) {
            let Some(row) = &rows.rows[c] else { continue };
            let stiffness = row.weight * state.tangent[c][c];
            let own = rows.own(c);
            let moves = |unknown: u32| unknown == own || !state.jump[c];
            for (unknown, a) in row.coefficients(own).filter(|(unknown, _)| moves(*unknown)) {
                diagonal[unknown as usize] += a * a * stiffness;
            }
        }
    }
}

/// Adds the law's tangent at an owned secondary node: sum of weight a_k C a_l over its rows, and
/// explicit zeros where the state may put a value later. Beside prescribed components the weights
/// of a node's components differ; their geometric mean keeps the matrix symmetric. What it leaves
/// out is added to the corrections.
fn add_law(
    all: &Discretization,
    rows: &crate::interface::JumpRows<u32>,
    state: &NodeState,
    matrix: &mut impl TangentMatrix,
) -> Result<()> {
    let dim = all.dim;
    let nodes = rows.nodes();
    let width = nodes.len() * dim;
    // a[c]: places among the components of the nodes and their coefficients in the jump of
    // component c; none where they are no unknowns.
    let mut a = vec![Vec::new(); dim];
    let mut weight = [0.0; 3];
    for c in (0..dim).filter(|c| !state.stuck[*c]) {
        let Some(row) = &rows.rows[c] else { continue };
        weight[c] = row.weight;
        let acts = |unknown: u32| unknown == rows.own(c) || !state.jump[c];
        for (unknown, coefficient) in row.coefficients(rows.own(c)).filter(|(n, _)| acts(*n)) {
            let (node, component) = (unknown / dim as u32, unknown as usize % dim);
            if !all.prescribed[node as usize][component] {
                let place = nodes.iter().position(|n| *n == node).expect("a node of the rows");
                a[c].push((place * dim + component, coefficient));
            }
        }
    }
    let mut values = vec![0.0; width * width];
    for c in 0..dim {
        for d in 0..dim {
            let factor = (weight[c] * weight[d]).sqrt() * state.tangent[c][d];
            if factor == 0.0 {
                continue;
            }
            for (k, left) in &a[c] {
                for (l, right) in &a[d] {
                    values[k * width + l] += factor * left * right;
                }
            }
        }
    }
    let numbers: Vec<i32> = nodes.iter().map(|n| all.nodes.numbers[*n as usize]).collect();
    matrix.add(&numbers, &numbers, &values)
}
