//! Which rigid motions of the bodies what is left of the interfaces does not hold.

use nalgebra::{DMatrix, SymmetricEigen};

use crate::assembly::Discretization;
use crate::case::Case;
use crate::comm::Comm;
use crate::law::Branch;
use crate::mesh::MeshFacts;
use crate::solve::model::interfaces::{InterfaceState, NodeResponse};
use crate::solve::{PlatenSystem, Problem};

/// A motion is free where what resists it is less than this part of what would if everything held.
const FREE: f64 = 1e-12;
/// Part of a motion in those that are free with which it is named; a translation is named only
/// where it is free by itself.
const NAMED: [f64; 2] = [1e-6, 1.0 - 1e-6];

/// Bodies take part in a motion that is more than this part of the most that it moves one by.
const MOVED: f64 = 1e-3;

/// Cohesion is gone where the damage differs from 1 by less: what is left of it is below the usual
/// tolerance of forces.
const LEFT: f64 = 1e-9;

/// Whether nothing but contact is left at a secondary node. Local.
pub fn is_separated(
    interfaces: &InterfaceState,
    interface: usize,
    response: &NodeResponse,
) -> bool {
    let law = interfaces.laws[interface].spec.law();
    response.branch.is_separated()
        || response.branch != Branch::Held && law.damage(response.history) >= 1.0 - LEFT
}

/// The displacement of a point in a rigid motion: three translations, then three rotations about
/// the axes through `centre`.
fn motion(number: usize, point: [f64; 3], centre: [f64; 3]) -> [f64; 3] {
    let mut u = [0.0; 3];
    if number < 3 {
        u[number] = 1.0;
        return u;
    }
    let (a, b) = ((number - 2) % 3, (number - 1) % 3);
    u[a] = -(point[b] - centre[b]);
    u[b] = point[a] - centre[a];
    u
}

/// The motions that nothing holds in the state that was evaluated last, a sentence for each body:
/// neither prescribed displacements, nor the points of interfaces at which any cohesion is left;
/// points in contact hold the normal displacement, and platens that may move go along. Collective.
pub fn free_motions(problem: &Problem<'_>, case: &Case) -> Vec<String> {
    let (comm, mesh) = (problem.comm, &problem.mesh);
    let bodies = Bodies::new(problem);
    let (width, size) = (bodies.motions.len(), bodies.motions.len() * mesh.bodies);
    let Resistance { held, full } = bodies.resistance(comm, &problem.interfaces);
    let whole = full.len();
    let scale = |i: usize| if full[i] > 0.0 { full[i].sqrt().recip() } else { 0.0 };
    let held = DMatrix::from_fn(whole, whole, |i, j| scale(i) * held[i * whole + j] * scale(j));
    let SymmetricEigen { eigenvectors, eigenvalues } = SymmetricEigen::new(of_bodies(&held, size));
    let free: Vec<usize> = (0..size).filter(|i| eigenvalues[*i] <= FREE).collect();
    let mut sentences: Vec<String> = Vec::new();
    for body in 0..mesh.bodies {
        let named = bodies.motions.iter().enumerate().filter(|(i, number)| {
            let share: f64 =
                free.iter().map(|f| eigenvectors[(body * width + i, *f)].powi(2)).sum();
            share.sqrt() > NAMED[usize::from(**number < 3)]
        });
        let names: Vec<String> = named.map(|(_, number)| name(*number)).collect();
        if !names.is_empty() {
            sentences.push(format!(
                "body {} ({}) can move freely: {}",
                body + 1,
                case.place_of_body(body),
                names.join(", ")
            ));
        }
    }
    if let ([first, ..], true) = (&free[..], sentences.is_empty()) {
        // Bodies that hold each other, but are not held: none has a free motion by itself.
        sentences.push(together(
            case,
            mesh,
            bodies.motions,
            eigenvectors.column(*first).as_slice(),
        ));
    }
    sentences
}

/// What resists the first `size` motions, those of bodies, where the others, those of platens, go
/// along as far as they can.
fn of_bodies(held: &DMatrix<f64>, size: usize) -> DMatrix<f64> {
    let count = held.nrows() - size;
    let own = held.view((0, 0), (size, size)).into_owned();
    if count == 0 {
        return own;
    }
    let SymmetricEigen { eigenvectors, eigenvalues } =
        SymmetricEigen::new(held.view((size, size), (count, count)).into_owned());
    let across = held.view((0, size), (size, count)) * eigenvectors;
    let kept = (0..count).filter(|k| eigenvalues[*k] > FREE);
    kept.fold(own, |own, k| {
        let column = across.column(k);
        own - column * column.transpose() / eigenvalues[k]
    })
}

/// A motion that bodies can only make together, in words: by the one that it moves most.
fn together(case: &Case, mesh: &MeshFacts, motions: &[usize], motion: &[f64]) -> String {
    let of_body = |body: usize| &motion[body * motions.len()..][..motions.len()];
    let size = |body: usize| of_body(body).iter().map(|m| m * m).sum::<f64>().sqrt();
    let most = (0..mesh.bodies).max_by(|i, j| size(*i).total_cmp(&size(*j))).unwrap_or_default();
    let moved: Vec<usize> =
        (0..mesh.bodies).filter(|body| size(*body) > MOVED * size(most)).collect();
    let part = of_body(most).iter().zip(motions);
    let part = part.max_by(|(a, _), (b, _)| a.abs().total_cmp(&b.abs()));
    let numbers: Vec<String> = moved.iter().map(|body| (body + 1).to_string()).collect();
    let by = part.map_or_else(String::new, |(_, number)| name(*number));
    let first = format!("body {} ({})", most + 1, case.place_of_body(most));
    if moved.len() == 1 {
        return format!("{first} can move freely by a {by}");
    }
    format!("bodies {} can move freely together: {first} by a {by}", numbers.join(", "))
}

/// Whether a point of an interface holds a component of the displacement.
fn holds(
    interfaces: &InterfaceState,
    interface: usize,
    at: &NodeResponse,
    is_normal: bool,
) -> bool {
    !is_separated(interfaces, interface, at) || is_normal && at.branch.is_closed()
}

/// The bodies of a mesh as rigid ones.
struct Bodies<'a> {
    mesh: &'a MeshFacts,
    all: &'a Discretization,
    /// Numbers of the motions of each body.
    motions: &'static [usize],
    /// Rotations are about the middle of the points of each body that hold it.
    centres: Vec<[f64; 3]>,
    /// The owned unknowns of each motion of a platen that is free.
    platens: Vec<Vec<f64>>,
}

/// What resists the motions of all bodies.
struct Resistance {
    /// A matrix over the motions, those of platens last.
    held: Vec<f64>,
    /// What its diagonal would be if everything held.
    full: Vec<f64>,
}

impl Resistance {
    /// Takes a component of a displacement or a jump into account, `row` by motions.
    fn see(&mut self, row: &[f64], holds: bool) {
        for (i, a) in row.iter().enumerate().filter(|(_, a)| **a != 0.0) {
            self.full[i] += a * a;
            if holds {
                let held = self.held[i * row.len()..].iter_mut();
                held.zip(row).for_each(|(held, b)| *held += a * b);
            }
        }
    }
}

impl<'a> Bodies<'a> {
    /// With the points that hold at the state that was evaluated last. Collective.
    fn new(problem: &'a Problem<'_>) -> Self {
        let (mesh, all, interfaces) = (&problem.mesh, &*problem.all, &problem.interfaces);
        let motions = match mesh.axes {
            [0, 1] => &[0, 1, 5][..],
            [0, 2] => &[0, 2, 4],
            _ => &[0, 1, 2, 3, 4, 5],
        };
        let unknowns = all.nodes.owned * all.dim;
        let platens =
            problem.platens.as_ref().map_or_else(Vec::new, |PlatenSystem { platens, .. }| {
                platens.free.iter().map(|k| platens.column(*k, unknowns)).collect()
            });
        let mut bodies = Self { mesh, all, motions, centres: Vec::new(), platens };
        let mut middle = vec![0.0; 4 * mesh.bodies];
        let mut count = |node: usize| {
            let (point, body) = bodies.place(node);
            let sums = &mut middle[4 * body..][..4];
            sums.iter_mut().zip(point.into_iter().chain([1.0])).for_each(|(sum, x)| *sum += x);
        };
        bodies.prescribed().for_each(&mut count);
        for (rows, response) in all.secondary.iter().zip(&interfaces.response) {
            let holds = |c| holds(interfaces, rows.interface, response, c + 1 == all.dim);
            if (0..all.dim).any(|c| rows.rows[c].is_some() && holds(c)) {
                rows.nodes().into_iter().for_each(|node| count(node as usize));
            }
        }
        problem.comm.sum(&mut middle);
        let centre = |sums: &[f64]| -> [f64; 3] {
            let alone = |i: usize| 0.5 * mesh.size[i];
            std::array::from_fn(|i| if sums[3] > 0.0 { sums[i] / sums[3] } else { alone(i) })
        };
        bodies.centres = middle.chunks_exact(4).map(centre).collect();
        bodies
    }

    /// Motions of all bodies, then those of platens that are free.
    fn size(&self) -> usize {
        self.motions.len() * self.mesh.bodies + self.platens.len()
    }

    /// Position (m) and body of a local node.
    fn place(&self, node: usize) -> ([f64; 3], usize) {
        let nodes = &self.all.nodes;
        (nodes.points[node], nodes.marks[node].body as usize)
    }

    /// Owned nodes with a prescribed component.
    fn prescribed(&self) -> impl Iterator<Item = usize> {
        (0..self.all.nodes.owned).filter(|node| self.all.prescribed[*node] != [false; 3])
    }

    /// The sum of unknowns times their coefficients, by motions.
    fn row(&self, coefficients: impl Iterator<Item = (u32, f64)>) -> Vec<f64> {
        let (dim, width) = (self.all.dim, self.motions.len());
        let mut row = vec![0.0; self.size()];
        for (unknown, a) in coefficients {
            let (node, component) = (unknown / dim as u32, unknown as usize % dim);
            let body = self.place(node as usize).1;
            for (value, number) in row[body * width..].iter_mut().zip(self.motions) {
                let moved = |node: u32| {
                    let u = motion(*number, self.place(node as usize).0, self.centres[body]);
                    std::array::from_fn(|c| self.mesh.axes.get(c).map_or(0.0, |axis| u[*axis]))
                };
                *value += a * self.all.frames.unknowns(node, moved)[component];
            }
        }
        row
    }

    /// What resists the motions at the state that was evaluated last. Collective.
    fn resistance(&self, comm: &Comm, interfaces: &InterfaceState) -> Resistance {
        let (all, dim, size) = (self.all, self.all.dim, self.size());
        let mut sums = Resistance { held: vec![0.0; size * size], full: vec![0.0; size] };
        for node in self.prescribed() {
            for c in (0..dim).filter(|c| all.prescribed[node][*c]) {
                let unknown = node * dim + c;
                let mut row = self.row([(unknown as u32, 1.0)].into_iter());
                let of_platens = row[size - self.platens.len()..].iter_mut();
                of_platens.zip(&self.platens).for_each(|(q, platen)| *q = -platen[unknown]);
                sums.see(&row, true);
            }
        }
        for (rows, response) in all.secondary.iter().zip(&interfaces.response) {
            for c in 0..dim {
                let Some(row) = &rows.rows[c] else { continue };
                let holds = holds(interfaces, rows.interface, response, c + 1 == dim);
                sums.see(&self.row(row.coefficients(rows.own(c))), holds);
            }
        }
        comm.sum(&mut sums.held);
        comm.sum(&mut sums.full);
        sums
    }
}

fn name(number: usize) -> String {
    let kind = if number < 3 { "translation along" } else { "rotation about" };
    format!("{kind} {}", ["x", "y", "z"][number % 3])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rotations_leave_their_axis_at_rest() {
        let centre = [1.0, 2.0, 3.0];
        for axis in 0..3 {
            let mut point = centre;
            point[axis] += 5.0;
            assert_eq!(motion(3 + axis, point, centre), [0.0; 3]);
            point[(axis + 1) % 3] += 2.0;
            let mut u = [0.0; 3];
            u[(axis + 2) % 3] = 2.0;
            assert_eq!(motion(3 + axis, point, centre), u);
        }
    }
}
