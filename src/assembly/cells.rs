//! The cells of one rank and their internal forces.

use std::cell::OnceCell;

use super::boxes::Boxes;
use super::general::{Field, GeneralSweep};
use super::second_order::SecondOrderSweep;
use super::sweep::Sweep;
use crate::bulk::{CellStiffness, General, Modal, Parity, SplitForm};
use crate::element::MAX_NODES;

const SORTED: &str = "cells are sorted by the form of their stiffness";

/// Which cells a loop runs over.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CellSet {
    /// All cells of the rank.
    All,
    /// The cells that touch a secondary node.
    Layer,
}

/// Connectivity by local node, and the stiffness of each cell.
pub struct Cells {
    dim: usize,
    /// First entry of each cell in `nodes`, and the end.
    start: Vec<u32>,
    nodes: Vec<u32>,
    prototype: Vec<u32>,
    stiffness: Vec<CellStiffness>,
    /// Positions of local nodes by displacement component (m); none where all cells are boxes.
    points: Vec<[f64; 3]>,
    layer: Vec<u32>,
    all: Sweeps,
    near: Sweeps,
}

/// The cells of a set by the form of their stiffness.
#[derive(Default)]
struct Sweeps {
    first: Sweep,
    /// Of the cells of `first` those in boxes, and a sweep over the rest.
    boxes: Option<(Boxes<f64>, Sweep)>,
    /// Those boxes in single precision, once they are asked for.
    single: OnceCell<Option<Boxes<f32>>>,
    /// By prototype, in single precision once they are asked for; none of other forms.
    parities: OnceCell<Vec<Option<Parity<f32>>>>,
    second: SecondOrderSweep,
    general: GeneralSweep,
}

impl Cells {
    /// `nodes` gives the local nodes of a cell in the order of its shape, `prototype` the index of
    /// each cell's stiffness, `points` the positions of the local nodes (m), whose displacement
    /// components lie along `axes`.
    pub fn new<'n>(
        axes: &[usize],
        nodes: impl Iterator<Item = Vec<u32>> + 'n,
        prototype: Vec<u32>,
        stiffness: Vec<CellStiffness>,
        points: &[[f64; 3]],
    ) -> Self {
        let (mut start, mut list) = (vec![0], Vec::new());
        for nodes in nodes {
            list.extend(nodes);
            start.push(list.len() as u32);
        }
        let mut cells = Self {
            dim: axes.len(),
            start,
            nodes: list,
            prototype,
            stiffness,
            points: Vec::new(),
            layer: Vec::new(),
            all: Sweeps::default(),
            near: Sweeps::default(),
        };
        if cells.stiffness.iter().any(|s| matches!(s, CellStiffness::General(_))) {
            let along = |point: &[f64; 3]| {
                let mut out = [0.0; 3];
                axes.iter().enumerate().for_each(|(c, axis)| out[c] = point[*axis]);
                out
            };
            cells.points = points.iter().map(along).collect();
        }
        cells.all = cells.sweeps(0..cells.len());
        cells.all.boxes = cells.boxes();
        cells
    }

    /// The boxes of cells of first order, where there are any, and a sweep over the rest.
    fn boxes(&self) -> Option<(Boxes<f64>, Sweep)> {
        if self.dim < 3 {
            return None;
        }
        let of = |cell: usize| (self.nodes(cell), self.prototype[cell]);
        let all = || (0..self.len()).map(of).filter(|(_, prototype)| self.is_first(*prototype));
        let modal = |prototype: u32| modal(&self.stiffness[prototype as usize]).expect(SORTED);
        let (boxes, is_in_box) = Boxes::new(all(), modal);
        let rest = all().zip(&is_in_box).filter(|(_, is_in_box)| !**is_in_box);
        (!boxes.is_empty()).then(|| (boxes, Sweep::new(self.dim, rest.map(|(cell, _)| cell))))
    }

    /// Whether the cells of a prototype are boxes of first order.
    fn is_first(&self, prototype: u32) -> bool {
        modal(&self.stiffness[prototype as usize]).is_some()
    }

    fn sweeps(&self, cells: impl Iterator<Item = usize> + Clone) -> Sweeps {
        let with = |is: fn(&CellStiffness) -> bool| {
            let of = move |c: &usize| is(&self.stiffness[self.prototype[*c] as usize]);
            let chosen = cells.clone().filter(of);
            chosen.map(|c| (self.nodes(c), self.prototype[c]))
        };
        Sweeps {
            first: Sweep::new(self.dim, with(|s| modal(s).is_some())),
            boxes: None,
            single: OnceCell::new(),
            parities: OnceCell::new(),
            second: SecondOrderSweep::new(self.dim, with(|s| parity(s).is_some())),
            general: GeneralSweep::new(
                |prototype| self.general(prototype),
                &self.points,
                with(|s| general(s).is_some()),
            ),
        }
    }

    /// The stiffness of a prototype of cells that are no boxes.
    fn general(&self, prototype: u32) -> &General {
        general(&self.stiffness[prototype as usize]).expect(SORTED)
    }

    /// Number of cells.
    pub fn len(&self) -> usize {
        self.prototype.len()
    }

    /// Whether this rank has no cell.
    pub fn is_empty(&self) -> bool {
        self.prototype.is_empty()
    }

    /// Local nodes of a cell.
    pub fn nodes(&self, cell: usize) -> &[u32] {
        &self.nodes[self.start[cell] as usize..self.start[cell + 1] as usize]
    }

    /// Local nodes of all cells, cell by cell.
    pub fn connectivity(&self) -> &[u32] {
        &self.nodes
    }

    /// K of a cell, row by row: (n dim) x (n dim), N/m (2D: per metre of thickness). The `buffer`
    /// holds it where the cell shares it with no other.
    pub fn matrix<'a>(&'a self, cell: usize, buffer: &'a mut Vec<f64>) -> &'a [f64] {
        match &self.stiffness[self.prototype[cell] as usize] {
            CellStiffness::Box(stiffness) => &stiffness.matrix,
            CellStiffness::General(general) => {
                let size = self.nodes(cell).len() * self.dim;
                buffer.resize(size * size, 0.0);
                general.matrix(self.points_of(cell, &mut [[0.0; 3]; MAX_NODES]), buffer);
                buffer
            }
        }
    }

    /// Stress at the centre of a cell under the displacements `u` of its nodes (Pa): xx, yy, zz,
    /// xy, yz, xz, in 2D too (plane strain).
    pub fn stress(&self, cell: usize, u: &[f64]) -> [f64; 6] {
        match &self.stiffness[self.prototype[cell] as usize] {
            CellStiffness::Box(stiffness) => stiffness.stress(u),
            CellStiffness::General(general) => {
                general.stress(self.points_of(cell, &mut [[0.0; 3]; MAX_NODES]), u)
            }
        }
    }

    /// Positions of the nodes of a general cell by displacement component (m).
    fn points_of<'b>(&self, cell: usize, buffer: &'b mut [[f64; 3]; MAX_NODES]) -> &'b [[f64; 3]] {
        let nodes = self.nodes(cell);
        for (out, node) in buffer.iter_mut().zip(nodes) {
            *out = self.points[*node as usize];
        }
        &buffer[..nodes.len()]
    }

    /// Calls `act` with the diagonal of the stiffness of a cell (N/m), by node and component.
    fn with_diagonal<T>(&self, cell: usize, act: impl FnOnce(&[f64]) -> T) -> T {
        let mut diagonal = [0.0; 3 * MAX_NODES];
        let n = self.nodes(cell).len() * self.dim;
        let diagonal = &mut diagonal[..n];
        match &self.stiffness[self.prototype[cell] as usize] {
            CellStiffness::Box(stiffness) => {
                let entries = stiffness.matrix.iter().step_by(n + 1);
                diagonal.iter_mut().zip(entries).for_each(|(out, k)| *out = *k);
            }
            CellStiffness::General(general) => {
                general.diagonal(self.points_of(cell, &mut [[0.0; 3]; MAX_NODES]), diagonal);
            }
        }
        act(diagonal)
    }

    /// The largest diagonal entry of any stiffness (N/m), 0 without cells.
    pub fn largest_diagonal(&self) -> f64 {
        let largest = |d: &[f64]| d.iter().fold(0.0, |m: f64, k| m.max(*k));
        (0..self.len()).map(|cell| self.with_diagonal(cell, largest)).fold(0.0, f64::max)
    }

    /// The cells that touch a secondary node.
    pub fn layer(&self) -> &[u32] {
        &self.layer
    }

    pub(super) fn set_layer(&mut self, layer: Vec<u32>) {
        self.near = self.sweeps(layer.iter().map(|cell| *cell as usize));
        self.layer = layer;
    }

    /// Adds the forces K u of the cells in `set` to `force` (N), both `dim` numbers per local node.
    /// `magnitude` gets the sum of the lengths of the cells' nodal forces, one per local node: a
    /// scale that does not cancel. Local.
    pub fn add_forces(
        &self,
        set: CellSet,
        u: &[f64],
        force: &mut [f64],
        magnitude: Option<&mut [f64]>,
    ) {
        let sweeps = if set == CellSet::All { &self.all } else { &self.near };
        sweeps.add_forces(self, u, [force, &mut []], magnitude);
    }

    /// As [`Cells::add_forces`] of all cells, with the forces at owned nodes apart from those at
    /// ghosts. Local.
    pub fn add_forces_apart(&self, u: &[f64], owned: &mut [f64], ghosts: &mut [f64]) {
        self.all.add_forces(self, u, [owned, ghosts], None);
    }

    /// Whether a cell is a box.
    pub fn is_box(&self, cell: usize) -> bool {
        matches!(self.stiffness[self.prototype[cell] as usize], CellStiffness::Box(_))
    }

    /// As [`Cells::add_forces_apart`] of the boxes in single precision. Local.
    pub fn add_single_forces_apart(&self, u: &[f32], owned: &mut [f32], ghosts: &mut [f32]) {
        let modal = |prototype: u32| modal(&self.stiffness[prototype as usize]).expect(SORTED);
        let boxes = self.all.boxes.as_ref();
        let single = self.all.single.get_or_init(|| boxes.map(|(boxes, _)| boxes.to_single()));
        match (single, boxes) {
            (Some(single), Some((_, rest))) => {
                single.add_forces(u, [&mut *owned, &mut *ghosts]);
                rest.add_forces(modal, u, [&mut *owned, &mut *ghosts], None);
            }
            _ => self.all.first.add_forces(modal, u, [&mut *owned, &mut *ghosts], None),
        }
        let single = |of: &CellStiffness| parity(of).map(Parity::to_single);
        let parities = || self.stiffness.iter().map(single).collect();
        let parities = self.all.parities.get_or_init(parities);
        let parity = |prototype: u32| parities[prototype as usize].as_ref().expect(SORTED);
        self.all.second.add_forces(parity, u, [owned, ghosts], None);
    }

    /// Adds the diagonal of the stiffness (N/m), `dim` numbers per local node. Local.
    pub fn add_diagonal(&self, diagonal: &mut [f64]) {
        let dim = self.dim;
        for cell in 0..self.len() {
            self.with_diagonal(cell, |of_cell| {
                for (node, entries) in self.nodes(cell).iter().zip(of_cell.chunks_exact(dim)) {
                    let at = &mut diagonal[*node as usize * dim..][..dim];
                    at.iter_mut().zip(entries).for_each(|(at, k)| *at += k);
                }
            });
        }
    }
}

fn modal(stiffness: &CellStiffness) -> Option<&Modal> {
    match stiffness {
        CellStiffness::Box(stiffness) => match &stiffness.form {
            SplitForm::First(modal) => Some(modal),
            SplitForm::Second(_) => None,
        },
        CellStiffness::General(_) => None,
    }
}

fn parity(stiffness: &CellStiffness) -> Option<&Parity> {
    match stiffness {
        CellStiffness::Box(stiffness) => match &stiffness.form {
            SplitForm::First(_) => None,
            SplitForm::Second(parity) => Some(parity),
        },
        CellStiffness::General(_) => None,
    }
}

fn general(stiffness: &CellStiffness) -> Option<&General> {
    match stiffness {
        CellStiffness::Box(_) => None,
        CellStiffness::General(general) => Some(general),
    }
}

impl Sweeps {
    /// As [`Cells::add_forces`], the forces at the first nodes apart from those at the others.
    fn add_forces(
        &self,
        cells: &Cells,
        u: &[f64],
        [first, others]: [&mut [f64]; 2],
        mut magnitude: Option<&mut [f64]>,
    ) {
        let of = |prototype: u32| &cells.stiffness[prototype as usize];
        let sizes = magnitude.as_deref_mut();
        let modal = |prototype| modal(of(prototype)).expect(SORTED);
        match &self.boxes {
            // Only cell by cell the forces have sizes that do not cancel.
            Some((boxes, rest)) if sizes.is_none() => {
                boxes.add_forces(u, [&mut *first, &mut *others]);
                rest.add_forces(modal, u, [&mut *first, &mut *others], None);
            }
            _ => self.first.add_forces(modal, u, [&mut *first, &mut *others], sizes),
        }
        let sizes = magnitude.as_deref_mut();
        let parity = |prototype| parity(of(prototype)).expect(SORTED);
        self.second.add_forces(parity, u, [&mut *first, &mut *others], sizes);
        let general = |prototype| cells.general(prototype);
        let field = Field { points: &cells.points, u };
        self.general.add_forces(general, field, [first, others], magnitude);
    }
}
