//! Whether supports hold the bodies of the mesh of a file, before anything is solved.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use super::BoundaryValueProblem;
use super::initial::joins;
use crate::assembly::Discretization;
use crate::case::{BoundarySpec, Case, SurfaceBit};
use crate::comm::Comm;
use crate::error::{Error, Result};
use crate::graph::groups;
use crate::mesh::{HingeNode, Hinges, MeshFacts};

/// A motion is free where what resists it is less than this part of the most that any meets.
const FREE: f64 = 1e-12;
/// More motions of parts that hang on nodes than this are not looked at.
const MOST_MOTIONS: usize = 1200;
/// More bodies than this are taken to be held: what resists them is not gathered.
const MOST_GROUPS: usize = 10_000;

/// Refuses a case in which bodies can move without resistance at the start: neither supports nor
/// interfaces that hold stop them. Of a column this is known beforehand, unless it is said place by
/// place what holds. Collective.
///
/// # Errors
/// `Input` that names the body and the motion, or a formula that gives what cannot be.
pub fn check(comm: &Comm, case: &Case, problem: &BoundaryValueProblem) -> Result<()> {
    let BoundaryValueProblem { mesh, all, .. } = problem;
    let joins = joins(comm, case, all)?;
    if !mesh.is_of_file() {
        let depends = case.interfaces.iter().any(|i| i.joins_at_start().is_none());
        // What does not join presses.
        let presses: Vec<bool> = joins.iter().map(|joins| !joins).collect();
        let free = if depends { case.free_motions(&joins, &presses) } else { Vec::new() };
        return match free.first() {
            Some(reason) => Err(Error::Input(format!("boundary leaves a body free: {reason}"))),
            None => Ok(()),
        };
    }
    let bodies = Bodies::new(&joins, &mesh.facts);
    if bodies.count > MOST_GROUPS {
        return Ok(());
    }
    let (resistance, middles) = bodies.sums(comm, all);
    if let Some((group, number)) = bodies.first_free(comm, &joins, all, &resistance) {
        let [x, y, z] = middles[group];
        return Err(Error::Input(format!(
            "nothing holds the body around ({x:.4}, {y:.4}, {z:.4}) m against a {}: neither the \
             prescribed displacements nor an interface that holds (a contact without friction holds \
             what is pressed on it along its normal alone); prescribe a displacement on one of its \
             surfaces, join it to another body, or give the contact friction",
            bodies.name(number),
        )));
    }
    hinges(case, &bodies)
}

/// The first free motion and the part of it, by its place, that is most of it.
fn free_motion(matrix: DMatrix<f64>) -> Option<usize> {
    let size = matrix.nrows();
    let eigen = SymmetricEigen::new(matrix);
    let least = FREE * eigen.eigenvalues.amax().max(f64::MIN_POSITIVE);
    let free = (0..size).find(|i| eigen.eigenvalues[*i] <= least)?;
    let motion = eigen.eigenvectors.column(free);
    (0..size).max_by(|i, j| motion[*i].abs().total_cmp(&motion[*j].abs()))
}

/// Refuses parts of bodies that hang on the others by nodes alone and can turn about them. Local;
/// the same on every rank.
fn hinges(case: &Case, bodies: &Bodies<'_>) -> Result<()> {
    let Hinges { parts, nodes } = &bodies.mesh.hinges;
    let prescribes = |surfaces: &[usize]| {
        let of = |entry: &&BoundarySpec| match case.surface_bit(&entry.on) {
            SurfaceBit::All => true,
            SurfaceBit::Place(place) => surfaces.contains(&place),
        };
        case.boundary.iter().filter(|entry| entry.prescribes_displacement()).any(|e| of(&e))
    };
    // A part with a support is taken to be held by it.
    let mut places = vec![None; parts.len()];
    let mut free = Vec::new();
    for (part, place) in parts.iter().zip(&mut places).filter(|(p, _)| !prescribes(&p.surfaces)) {
        *place = Some(free.len());
        free.push(part);
    }
    let motions = bodies.motions();
    let size = motions * free.len();
    if size == 0 || size > MOST_MOTIONS {
        return Ok(());
    }
    let held = |node: &HingeNode| prescribes(&node.surfaces);
    let resistance = resistance_of_nodes(bodies, nodes, &places, size, held);
    let eigen = SymmetricEigen::new(resistance);
    let most = eigen.eigenvalues.amax();
    let Some(loose) = (0..size).find(|i| eigen.eigenvalues[*i] <= FREE * most) else {
        return Ok(());
    };
    let motion = eigen.eigenvectors.column(loose);
    let moves = |place: usize| -> f64 { motion.rows(place * motions, motions).norm() };
    let place = (0..free.len()).max_by(|i, j| moves(*i).total_cmp(&moves(*j))).unwrap_or_default();
    let hangs = |node: &&HingeNode| node.parts.iter().any(|part| places[*part] == Some(place));
    let on: Vec<&HingeNode> = nodes.iter().filter(hangs).collect();
    let [x, y, z] = free[place].middle;
    let at = on.first().map_or([x, y, z], |node| node.point);
    Err(Error::Input(format!(
        "{} around ({x:.4}, {y:.4}, {z:.4}) m can turn: {} with the rest of the mesh no facet, only \
         {}, the first at ({:.4}, {:.4}, {:.4}) m; join them by facets, hold them by supports, or \
         leave them out",
        cells(free[place].cells),
        if free[place].cells == 1 { "it shares" } else { "they share" },
        if on.len() == 1 { "1 node".into() } else { format!("{} nodes", on.len()) },
        at[0],
        at[1],
        at[2],
    )))
}

/// What the nodes that parts share, and supports of these, resist the motions of the free parts
/// with, whose numbers are `places`.
fn resistance_of_nodes(
    bodies: &Bodies<'_>,
    nodes: &[HingeNode],
    places: &[Option<usize>],
    size: usize,
    is_held: impl Fn(&HingeNode) -> bool,
) -> DMatrix<f64> {
    let motions = bodies.motions();
    let mut resistance = DMatrix::<f64>::zeros(size, size);
    for node in nodes {
        let ends = if is_held(node) {
            // Held itself: it holds both.
            vec![vec![places[node.parts[0]]], vec![places[node.parts[1]]]]
        } else {
            vec![node.parts.map(|part| places[part]).to_vec()]
        };
        for ends in ends {
            for axis in bodies.mesh.axes {
                let mut row = DVector::<f64>::zeros(size);
                for (end, sign) in ends.iter().zip([1.0, -1.0]) {
                    let Some(place) = end else { continue };
                    for number in 0..motions {
                        let moved = bodies.moved(number, node.point)[*axis];
                        row[place * motions + number] += sign * moved;
                    }
                }
                resistance += &row * row.transpose();
            }
        }
    }
    resistance
}

fn cells(number: u64) -> String {
    if number == 1 { "the cell".into() } else { format!("the {number} cells") }
}

/// Bodies that interfaces hold together, as one.
struct Bodies<'m> {
    mesh: &'m MeshFacts,
    group: Vec<usize>,
    count: usize,
}

impl<'m> Bodies<'m> {
    /// Those that the interfaces which are marked in `joins` make of the bodies of a mesh.
    fn new(joins: &[bool], mesh: &'m MeshFacts) -> Self {
        let joints = mesh.joints.iter().filter(|joint| joins[joint.interface]);
        let group = groups(mesh.bodies, joints.map(|joint| joint.bodies));
        let count = group.iter().max().map_or(0, |last| last + 1);
        Self { mesh, group, count }
    }

    /// A group of bodies that can move, and the number of its motion. What is pressed on a contact
    /// counts as held along the normal. Collective.
    fn first_free(
        &self,
        comm: &Comm,
        joins: &[bool],
        all: &Discretization,
        resistance: &[f64],
    ) -> Option<(usize, usize)> {
        let motions = self.motions();
        let groups = resistance.chunks_exact(motions * motions);
        let alone = groups.enumerate().find_map(|(group, sums)| {
            let number = free_motion(DMatrix::from_row_slice(motions, motions, sums))?;
            Some((group, number))
        })?;
        let size = self.count * motions;
        if size > MOST_MOTIONS {
            return Some(alone);
        }
        let mut whole = DMatrix::<f64>::zeros(size, size);
        for (group, sums) in resistance.chunks_exact(motions * motions).enumerate() {
            let own = DMatrix::from_row_slice(motions, motions, sums);
            whole.view_mut((group * motions, group * motions), own.shape()).copy_from(&own);
        }
        let mut pressed = vec![0.0; size * size];
        let normal = all.dim - 1;
        for rows in &all.secondary[..all.owned_secondary()] {
            let Some(row) = &rows.rows[normal] else { continue };
            if joins[rows.interface] {
                continue;
            }
            let mut jump = DVector::<f64>::zeros(size);
            for (unknown, a) in row.coefficients(rows.own(normal)) {
                let (node, c) = (unknown as usize / all.dim, unknown as usize % all.dim);
                let group = self.group[all.nodes.marks[node].body as usize];
                for number in 0..motions {
                    let moved = |node: u32| self.moved(number, all.nodes.points[node as usize]);
                    let moved = all.frames.unknowns(node as u32, moved)[c];
                    jump[group * motions + number] += a * moved;
                }
            }
            let of_node = &jump * jump.transpose();
            pressed.iter_mut().zip(of_node.iter()).for_each(|(sum, v)| *sum += v);
        }
        comm.sum(&mut pressed);
        whole += DMatrix::from_column_slice(size, size, &pressed);
        free_motion(whole).map(|place| (place / motions, place % motions))
    }

    fn motions(&self) -> usize {
        if self.mesh.dim == 2 { 3 } else { 6 }
    }

    /// What resists the motions of each group, and its middle (m). Collective.
    fn sums(&self, comm: &Comm, all: &Discretization) -> (Vec<f64>, Vec<[f64; 3]>) {
        let (motions, dim) = (self.motions(), all.dim);
        let mut sums = vec![0.0; self.count * motions * motions];
        let mut middles = vec![[0.0; 4]; self.count];
        for node in 0..all.nodes.owned {
            let group = self.group[all.nodes.marks[node].body as usize];
            let point = all.nodes.points[node];
            let middle = &mut middles[group];
            (0..3).for_each(|i| middle[i] += point[i]);
            middle[3] += 1.0;
            if !all.prescribed[node][..dim].contains(&true) {
                continue;
            }
            let moved: Vec<[f64; 3]> = (0..motions)
                .map(|number| {
                    let moved = |node: u32| self.moved(number, all.nodes.points[node as usize]);
                    all.frames.unknowns(node as u32, moved)
                })
                .collect();
            let of_group = &mut sums[group * motions * motions..][..motions * motions];
            for c in (0..dim).filter(|c| all.prescribed[node][*c]) {
                for (i, j) in (0..motions).flat_map(|i| (0..motions).map(move |j| (i, j))) {
                    of_group[i * motions + j] += moved[i][c] * moved[j][c];
                }
            }
        }
        comm.sum(&mut sums);
        comm.sum(middles.as_flattened_mut());
        let middle = |[x, y, z, n]: [f64; 4]| [x, y, z].map(|sum| sum / n);
        (sums, middles.into_iter().map(middle).collect())
    }

    /// The displacement of a point in a motion: translations, then rotations about the middle of
    /// the mesh, over its size.
    fn moved(&self, number: usize, point: [f64; 3]) -> [f64; 3] {
        let (axes, mut u) = (self.mesh.axes, [0.0; 3]);
        if number < axes.len() {
            u[number] = 1.0;
            return u;
        }
        let largest = self.mesh.size.iter().fold(0.0_f64, |m, x| m.max(*x));
        let lever = |c: usize| {
            let axis = axes[c];
            (point[axis] - self.mesh.origin[axis] - 0.5 * self.mesh.size[axis]) / largest
        };
        let [a, b] = Self::turned(axes.len(), number);
        (u[a], u[b]) = (-lever(b), lever(a));
        u
    }

    /// The components that a rotation exchanges.
    fn turned(dim: usize, number: usize) -> [usize; 2] {
        [[0, 1], [1, 2], [2, 0]][number - dim]
    }

    fn name(&self, number: usize) -> String {
        const AXES: [&str; 3] = ["x", "y", "z"];
        let (axes, dim) = (self.mesh.axes, self.mesh.axes.len());
        if number < dim {
            return format!("translation along {}", AXES[axes[number]]);
        }
        let [a, b] = Self::turned(dim, number).map(|c| axes[c]);
        format!("rotation about {}", AXES[3 - a - b])
    }
}
