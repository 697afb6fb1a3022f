//! The numerical inf-sup constant of displacements and multipliers (Chapelle and Bathe, Comput.
//! Struct. 47, 1993): the square root of the least eigenvalue of B K^-1 B^T over h/E W, with W the
//! weights of the multipliers. Stable pairs keep it under refinement.

#![allow(clippy::print_stdout)] // the constants, with --nocapture

use nalgebra::{DMatrix, DVector, SymmetricEigen};
use std::path::Path;

use super::Sides;
use super::facet_terms::integrate;
use super::jump::sum;
use crate::bulk::{Elastic, Stiffness};
use crate::case::Case;
use crate::mesh::{LocalMesh, MeshFamily, Prototype, axes};
use crate::space::Prescribed;

/// Cells per edge of the base of each body and their order.
type Bodies = [(usize, usize); 2];

/// Bodies of half a metre in 2D; in 3D they are one cell high, which bounds the constant of taller
/// ones from below.
fn case(dim: usize, bodies: Bodies, secondary: &str, supports: &str) -> Case {
    let body = |(n, order): (usize, usize)| {
        let layers = n.div_ceil(2);
        let cells = if dim == 2 { format!("[{n}, {layers}]") } else { format!("[{n}, {n}, 1]") };
        format!("{{cells: {cells}, order: {order}}}")
    };
    let [lower, upper] = if dim == 2 { [0.5; 2] } else { bodies.map(|(n, _)| 1.0 / n as f64) };
    let top = lower + upper;
    let size = if dim == 2 { format!("[1.0, {top}]") } else { format!("[1.0, 1.0, {top}]") };
    let zero = if dim == 2 { "{x: 0, z: 0}" } else { "{x: 0, y: 0, z: 0}" };
    let boundary: Vec<String> =
        supports.split(' ').map(|on| format!("{{on: {on}, displacement: {zero}}}")).collect();
    let yaml = format!(
        "
mesh: {{column: {{size: {size}, bodies: [{}, {}]}}}}
materials: {{rock: {{elastic: {{young_modulus: 1.0, poisson_ratio: 0.3}}}}}}
interfaces: [{{name: joint, z: {lower}, law: {{tied: {{}}}}, secondary: {secondary}}}]
boundary: [{}]
time: {{instants: [1]}}
",
        body(bodies[0]),
        body(bodies[1]),
        boundary.join(", ")
    );
    Case::read(&yaml, Path::new("inf_sup.yaml"), &[]).expect("a case")
}

/// K over the free components, and their numbers by node and component.
fn stiffness(case: &Case, mesh: &LocalMesh, prescribed: &Prescribed) -> (DMatrix<f64>, Numbers) {
    let dim = case.dim;
    let mut numbers = Numbers { dim, of: vec![None; mesh.nodes.names.len() * dim], count: 0 };
    for (node, marks) in mesh.nodes.marks.iter().enumerate() {
        let fixed = prescribed.components_of(marks);
        for c in (0..dim).filter(|c| !fixed[*c]) {
            numbers.of[node * dim + c] = Some(numbers.count);
            numbers.count += 1;
        }
    }
    let elastic = Elastic::new(1.0, 0.3);
    let stiffness = |p: &Prototype| {
        let size = p.geometry.size().expect("a box");
        Stiffness::new(p.shape, size, elastic, axes(dim), false)
    };
    let cells: Vec<Stiffness> = mesh.prototypes.iter().map(stiffness).collect();
    let mut k = DMatrix::zeros(numbers.count, numbers.count);
    for (cell, prototype) in mesh.cell_prototype.iter().enumerate() {
        let unknowns: Vec<Option<usize>> = mesh
            .cell_nodes(cell)
            .iter()
            .flat_map(|n| (0..dim).map(|c| numbers.get(*n as usize, c)).collect::<Vec<_>>())
            .collect();
        let matrix = &cells[*prototype as usize].matrix;
        for (row, i) in matrix.chunks_exact(unknowns.len()).zip(&unknowns) {
            for (value, j) in row.iter().zip(&unknowns) {
                if let (Some(i), Some(j)) = (i, j) {
                    k[(*i, *j)] += value;
                }
            }
        }
    }
    (k, numbers)
}

struct Numbers {
    dim: usize,
    of: Vec<Option<usize>>,
    count: usize,
}

impl Numbers {
    fn get(&self, node: usize, component: usize) -> Option<usize> {
        self.of[node * self.dim + component]
    }
}

/// The multiplier spaces that are compared.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Multipliers {
    /// Ours.
    Dual,
    /// Ours, but also where displacements of the interface's edge are prescribed.
    DualOnPrescribed,
    /// One constant on each secondary facet, whose twin has the same nodes.
    ConstantOnFacets,
}

/// A row of B over nodes, its component and its weight.
type Row = (Vec<(usize, f64)>, usize, f64);

fn inf_sup(
    dim: usize,
    bodies: Bodies,
    secondary: &str,
    supports: &str,
    multipliers: Multipliers,
) -> f64 {
    eigenvalues(dim, bodies, secondary, supports, multipliers).min().max(0.0).sqrt()
}

/// The squares of the singular values of the jump.
fn eigenvalues(
    dim: usize,
    bodies: Bodies,
    secondary: &str,
    supports: &str,
    multipliers: Multipliers,
) -> DVector<f64> {
    let case = case(dim, bodies, secondary, supports);
    let mesh = MeshFamily::new(&case).expect("a mesh").whole().expect("a mesh");
    let prescribed = Prescribed::new(&case);
    let side = Sides::choose(&case, &mesh.facts)[0];
    let (k, numbers) = stiffness(&case, &mesh, &prescribed);
    let rows = match multipliers {
        Multipliers::Dual => dual_rows(&mesh, side, &prescribed),
        Multipliers::DualOnPrescribed => {
            let free = self::case(dim, bodies, secondary, "bottom top");
            dual_rows(&mesh, side, &Prescribed::new(&free))
        }
        Multipliers::ConstantOnFacets => constant_rows(&mesh, side),
    };
    let h = 1.0 / bodies.iter().map(|(n, order)| n * order).max().expect("two bodies") as f64;
    let mut b = DMatrix::zeros(numbers.count, rows.len());
    for (index, (row, c, weight)) in rows.iter().enumerate() {
        // Scaled so that h W becomes the identity.
        let scale = (h * weight).sqrt();
        for (node, value) in row {
            if let Some(unknown) = numbers.get(*node, *c) {
                b[(unknown, index)] += value / scale;
            }
        }
    }
    let cholesky = k.cholesky().expect("bodies that are held");
    let energy = b.transpose() * cholesky.solve(&b);
    SymmetricEigen::new(energy).eigenvalues
}

/// The rows of our multipliers, without those of prescribed components.
fn dual_rows(mesh: &LocalMesh, side: Sides, prescribed: &Prescribed) -> Vec<Row> {
    let number = |name: u64| mesh.nodes.number(name).expect("a node of the mesh");
    let fixed = |name: u64| prescribed.components_of(&mesh.nodes.marks[number(name)]);
    let terms = integrate(mesh, &[side], mesh.dim(), &fixed).expect("sides that cover").list;
    let own = mesh.nodes.iter().filter(|(_, _, marks)| side.is_secondary(marks));
    let nodes: Vec<(u64, usize)> = own.map(|(name, ..)| (name, 0)).collect();
    let mut rows: Vec<Row> = Vec::new();
    for jump in sum(terms, mesh.dim(), &nodes, &mesh.nodes.names) {
        for (c, row) in jump.rows.iter().enumerate() {
            let Some(row) = row else { continue };
            let dim = mesh.dim() as u64;
            let weighted = row.coefficients(jump.node * dim + c as u64);
            let weighted = weighted.map(|(name, a)| (number(name / dim), a * row.weight));
            rows.push((weighted.collect(), c, row.weight));
        }
    }
    rows
}

/// The rows of multipliers that are constant on facets; both sides have the same facets in the same
/// order.
fn constant_rows(mesh: &LocalMesh, side: Sides) -> Vec<Row> {
    let [secondary, primary] = [side.secondary, side.primary()].map(|lip| mesh.on_lip(0, lip));
    let area = 1.0 / secondary.len() as f64;
    let mut rows: Vec<Row> = Vec::new();
    for facets in secondary.iter().zip(primary) {
        let mut row = Vec::new();
        for (facet, sign) in [(facets.0, 1.0), (facets.1, -1.0)] {
            let nodes = mesh.facet_nodes(*facet).1;
            let part = sign * area / nodes.len() as f64;
            row.extend(nodes.into_iter().map(|node| (node as usize, part)));
        }
        rows.extend((0..mesh.dim()).map(|c| (row.clone(), c, area)));
    }
    rows
}

/// The constants over levels of refinement.
fn levels(
    dim: usize,
    levels: &[usize],
    bodies: impl Fn(usize) -> Bodies,
    secondary: &str,
    supports: &str,
    multipliers: Multipliers,
) -> Vec<f64> {
    let one = |n: &usize| inf_sup(dim, bodies(*n), secondary, supports, multipliers);
    levels.iter().map(one).collect()
}

/// It falls by less than a part in twenty from the first level on that is not all boundary.
fn assert_stable(label: &str, constants: &[f64]) {
    let (first, last) = (constants[1], constants[constants.len() - 1]);
    println!("inf-sup {label}: {constants:?}");
    assert!(last > 0.95 * first && last > 0.1, "{label}: {constants:?}");
}

#[test]
fn every_pair_of_spaces_in_2d() {
    for supports in ["bottom top", "bottom top left"] {
        for (lower, upper) in [(1, 1), (2, 2), (1, 2), (2, 1)] {
            for ratio in [[2, 2], [2, 3], [3, 2]] {
                for secondary in ["lower", "upper"] {
                    let bodies = |n: usize| [(n * ratio[0], lower), (n * ratio[1], upper)];
                    let label = format!(
                        "orders {lower} {upper}, {ratio:?}, {secondary} secondary, {supports}"
                    );
                    let dual = Multipliers::Dual;
                    let constants = levels(2, &[1, 2, 4, 6], bodies, secondary, supports, dual);
                    assert_stable(&label, &constants);
                }
            }
        }
    }
}

#[test]
fn every_pair_of_spaces_in_3d() {
    for (orders, ratio, sizes) in [
        ([1, 1], [1, 1], [2, 4, 6, 8]),
        ([1, 1], [2, 3], [1, 2, 3, 4]),
        ([1, 1], [3, 2], [1, 2, 3, 4]),
        ([2, 2], [1, 1], [1, 2, 3, 4]),
        ([2, 2], [1, 2], [1, 2, 3, 4]),
        ([1, 2], [2, 1], [1, 2, 3, 4]),
        ([2, 1], [1, 1], [1, 2, 3, 4]),
    ] {
        let bodies = |n: usize| [(n * ratio[0], orders[0]), (n * ratio[1], orders[1])];
        let label = format!("3D, orders {orders:?}, {ratio:?}");
        let dual = Multipliers::Dual;
        let constants = levels(3, &sizes, bodies, "upper", "bottom top", dual);
        assert_stable(&label, &constants);
    }
}

/// What the test is good for: a pair that is known to fail.
#[test]
fn constants_on_facets_lose_stability() {
    let constants = levels(
        2,
        &[2, 4, 8, 16],
        |n| [(n, 1), (n, 1)],
        "upper",
        "bottom top",
        Multipliers::ConstantOnFacets,
    );
    println!("inf-sup constants on facets: {constants:?}");
    assert!(constants[3] < 0.6 * constants[1], "{constants:?}");
}

/// Where an edge is prescribed, multipliers there are singular values that vanish: one for each
/// node and component of the edge.
#[test]
fn multipliers_on_a_prescribed_edge_are_null() {
    for (dim, bodies, edge) in
        [(2, [(4, 1), (4, 1)], 2), (2, [(4, 1), (6, 1)], 2), (3, [(3, 1); 2], 12)]
    {
        let null = |multipliers| {
            let all = eigenvalues(dim, bodies, "upper", "bottom top left", multipliers);
            let largest = all.max();
            all.iter().filter(|e| **e < 1e-10 * largest).count()
        };
        let (kept, dropped) = (null(Multipliers::DualOnPrescribed), null(Multipliers::Dual));
        println!("null {dim}D, {bodies:?}: {kept} kept, {dropped} dropped");
        assert_eq!([kept, dropped], [edge, 0], "{dim}D, {bodies:?}");
    }
}
