//! The stiffness of cells of any form in single precision, assembled by blocks of nodes.
//!
//! A product with it takes a fraction of the time of a sweep that integrates over each cell. It is
//! symmetric: a block between two nodes stands once, and acts both ways.

use super::cells::Cells;
use crate::simd::{Kernel, is_fused, widest};

/// Assembled cells.
pub struct Blocks(Form);

enum Form {
    /// Nothing to assemble.
    None,
    /// In 2D.
    Plane(Rows<2>),
    /// In 3D.
    Space(Rows<3>),
}

/// Entries between the components of two nodes (N/m), row by row.
type Block<const DIM: usize> = [[f32; DIM]; DIM];

/// By local node.
struct Rows<const DIM: usize> {
    /// Of a node on itself.
    own: Vec<Block<DIM>>,
    /// First entry of each node in `others` and `beside`, and the end.
    start: Vec<u32>,
    /// Those nodes of larger number that share a cell with it.
    others: Vec<u32>,
    /// From those nodes to it.
    beside: Vec<Block<DIM>>,
}

/// Shows the stiffness of a cell between the unknowns of its nodes, row by row (N/m).
pub type Show<'s> = &'s dyn Fn(usize, &mut dyn FnMut(&[f64]));

impl Blocks {
    /// Of the cells that are no boxes, over so many local nodes with `dim` unknowns each. Local.
    pub fn new(dim: usize, nodes: usize, cells: &Cells, matrix: Show<'_>) -> Self {
        let list: Vec<usize> = (0..cells.len()).filter(|cell| !cells.is_box(*cell)).collect();
        if list.is_empty() {
            return Self(Form::None);
        }
        match dim {
            2 => Self(Form::Plane(Rows::new(nodes, cells, &list, matrix))),
            _ => Self(Form::Space(Rows::new(nodes, cells, &list, matrix))),
        }
    }

    /// Adds the forces K u (N) to those at owned nodes and at ghosts. Local.
    pub fn add_forces_apart(&self, u: &[f32], owned: &mut [f32], ghosts: &mut [f32]) {
        match &self.0 {
            Form::None => (),
            Form::Plane(rows) => rows.multiply(u, owned, ghosts),
            Form::Space(rows) => rows.multiply(u, owned, ghosts),
        }
    }
}

impl<const DIM: usize> Rows<DIM> {
    fn new(nodes: usize, cells: &Cells, of_list: &[usize], matrix: Show<'_>) -> Self {
        let (mut start, mut others) = (vec![0], Vec::new());
        let (first, cells_of) = incidence(nodes, cells, of_list);
        let mut list: Vec<u32> = Vec::new();
        for node in 0..nodes {
            list.clear();
            for cell in &cells_of[first[node] as usize..first[node + 1] as usize] {
                let nodes = cells.nodes(*cell as usize);
                list.extend(nodes.iter().filter(|other| **other as usize > node));
            }
            list.sort_unstable();
            list.dedup();
            others.extend_from_slice(&list);
            start.push(others.len() as u32);
        }
        drop((first, cells_of));
        let zero = [[0.0; DIM]; DIM];
        let (own, beside) = (vec![zero; nodes], vec![zero; others.len()]);
        let mut rows = Self { own, start, others, beside };
        for cell in of_list {
            matrix(*cell, &mut |matrix| rows.add(cells.nodes(*cell), matrix));
        }
        rows
    }

    fn multiply(&self, u: &[f32], owned: &mut [f32], ghosts: &mut [f32]) {
        if is_fused() {
            widest(Product::<DIM, true> { rows: self, u, owned, ghosts });
        } else {
            widest(Product::<DIM, false> { rows: self, u, owned, ghosts });
        }
    }

    /// Adds the stiffness of a cell.
    fn add(&mut self, nodes: &[u32], matrix: &[f64]) {
        let size = nodes.len() * DIM;
        for (a, node) in nodes.iter().enumerate() {
            let range =
                self.start[*node as usize] as usize..self.start[*node as usize + 1] as usize;
            for (b, other) in nodes.iter().enumerate() {
                let block = if other == node {
                    &mut self.own[*node as usize]
                } else if let Ok(place) = self.others[range.clone()].binary_search(other) {
                    &mut self.beside[range.start + place]
                } else {
                    continue;
                };
                for (c, row) in block.iter_mut().enumerate() {
                    for (d, entry) in row.iter_mut().enumerate() {
                        *entry += matrix[(a * DIM + c) * size + b * DIM + d] as f32;
                    }
                }
            }
        }
    }
}

/// First entry of each local node, and its cells.
fn incidence(nodes: usize, cells: &Cells, of_list: &[usize]) -> (Vec<u32>, Vec<u32>) {
    let mut first = vec![0_u32; nodes + 1];
    let of = |cell: &usize| cells.nodes(*cell);
    of_list.iter().flat_map(of).for_each(|node| first[*node as usize + 1] += 1);
    (0..nodes).for_each(|node| first[node + 1] += first[node]);
    let mut next = first.clone();
    let mut list = vec![0; first[nodes] as usize];
    for cell in of_list {
        for node in of(cell) {
            let place = &mut next[*node as usize];
            list[*place as usize] = *cell as u32;
            *place += 1;
        }
    }
    (first, list)
}

/// One product, with or without instructions that multiply and add.
struct Product<'a, const DIM: usize, const FUSED: bool> {
    rows: &'a Rows<DIM>,
    u: &'a [f32],
    owned: &'a mut [f32],
    ghosts: &'a mut [f32],
}

impl<const DIM: usize, const FUSED: bool> Kernel for Product<'_, DIM, FUSED> {
    #[inline(always)]
    fn run(self) {
        let Self { rows: Rows { own, start, others, beside }, u, owned, ghosts } = self;
        let u = u.as_chunks::<DIM>().0;
        let [owned, ghosts] = [owned, ghosts].map(|part| part.as_chunks_mut::<DIM>().0);
        for (node, ((x, own), range)) in u.iter().zip(own).zip(start.windows(2)).enumerate() {
            let mut sum = [0.0; DIM];
            add::<DIM, FUSED>(own, x, &mut sum);
            let range = range[0] as usize..range[1] as usize;
            let (others, beside) = (&others[range.clone()], &beside[range]);
            // Nodes of larger number, the owned ones first.
            let split = others.partition_point(|other| (*other as usize) < owned.len());
            for (other, block) in others[..split].iter().zip(beside) {
                add::<DIM, FUSED>(block, &u[*other as usize], &mut sum);
                add_transposed::<DIM, FUSED>(block, x, &mut owned[*other as usize]);
            }
            for (other, block) in others[split..].iter().zip(&beside[split..]) {
                add::<DIM, FUSED>(block, &u[*other as usize], &mut sum);
                add_transposed::<DIM, FUSED>(block, x, &mut ghosts[*other as usize - owned.len()]);
            }
            let to = match node.checked_sub(owned.len()) {
                None => &mut owned[node],
                Some(ghost) => &mut ghosts[ghost],
            };
            to.iter_mut().zip(sum).for_each(|(to, sum)| *to += sum);
        }
    }
}

/// Adds the product with a block.
#[inline(always)]
fn add<const DIM: usize, const FUSED: bool>(
    block: &Block<DIM>,
    x: &[f32; DIM],
    sum: &mut [f32; DIM],
) {
    for d in 0..DIM {
        for c in 0..DIM {
            sum[c] = plus::<FUSED>(sum[c], block[c][d], x[d]);
        }
    }
}

/// Adds the product with a block across the diagonal.
#[inline(always)]
fn add_transposed<const DIM: usize, const FUSED: bool>(
    block: &Block<DIM>,
    x: &[f32; DIM],
    sum: &mut [f32; DIM],
) {
    for c in 0..DIM {
        for d in 0..DIM {
            sum[d] = plus::<FUSED>(sum[d], block[c][d], x[c]);
        }
    }
}

#[inline(always)]
fn plus<const FUSED: bool>(sum: f32, factor: f32, value: f32) -> f32 {
    if FUSED { factor.mul_add(value, sum) } else { sum + factor * value }
}
