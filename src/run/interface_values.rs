//! An interface as its field files show it: the facets of the secondary side, and values at their
//! nodes.

use crate::comm::Comm;
use crate::element::Shape;
use crate::solve::{Model, NodeResponse, Problem};

/// The facets of one interface: owned nodes of the secondary side as points, facets of the rank's
/// own cells.
pub struct InterfaceGrid {
    /// Local numbers of the points.
    pub nodes: Vec<u32>,
    /// Local nodes of each facet.
    facets: Vec<Vec<u32>>,
    /// Rows of the points of all facets, facet by facet.
    pub connectivity: Vec<i64>,
    /// Shapes of the facets.
    pub shapes: Vec<Shape>,
}

impl InterfaceGrid {
    /// Collective.
    pub fn new(comm: &Comm, model: &Model<'_>, interface: usize) -> Self {
        let all = &model.stepper.problem.all;
        let (shapes, facets) = facets(model, interface);
        // Also nodes that carry no multiplier.
        let mut is_point = vec![0.0; all.nodes.len()];
        facets.iter().flatten().for_each(|node| is_point[*node as usize] = 1.0);
        all.nodes.add_to_owners(&mut is_point, 1);
        let owned = 0..all.nodes.owned as u32;
        let nodes: Vec<u32> = owned.filter(|node| is_point[*node as usize] > 0.0).collect();
        let first = comm.exscan_u64(nodes.len() as u64);
        // Rows are whole numbers far below 2^53.
        let mut row = vec![0.0; all.nodes.len()];
        for (i, node) in nodes.iter().enumerate() {
            row[*node as usize] = (first + i as u64) as f64;
        }
        all.nodes.update_ghosts(&mut row, 1);
        let connectivity = facets.iter().flatten().map(|n| row[*n as usize] as i64).collect();
        Self { nodes, facets, connectivity, shapes }
    }
}

/// Shapes and local nodes of the secondary facets of this rank's cells.
fn facets(model: &Model<'_>, interface: usize) -> (Vec<Shape>, Vec<Vec<u32>>) {
    let (mesh, lip) = (&model.mesh, model.sides[interface].secondary);
    let nodes = &model.stepper.problem.all.nodes;
    let local = |node: u32| {
        let name = mesh.nodes.names[node as usize];
        nodes.local(name).expect("a node of the rank's own cell")
    };
    let facets = mesh.on_lip(interface, lip).iter().map(|facet| mesh.lip_nodes(lip, *facet));
    facets.map(|(shape, nodes)| (shape, nodes.into_iter().map(local).collect())).unzip()
}

/// Values at the nodes of interfaces; where a component has no multiplier, the traction is the mean
/// over its facets of the multipliers it was joined to, of a surface that bends turned with its
/// normal.
pub struct NodalValues {
    dim: usize,
    /// Of the multipliers, at all local nodes (Pa).
    traction: Vec<f64>,
    /// Sums and counts over the facets of nodes without a multiplier.
    joined: Vec<f64>,
    /// Whether nodes have frames of their own, so that what is joined lies along the axes.
    is_framed: bool,
}

impl NodalValues {
    /// Collective.
    pub fn new(model: &Model<'_>, grids: &[InterfaceGrid]) -> Self {
        let problem: &Problem<'_> = &model.stepper.problem;
        let (all, dim) = (&problem.all, problem.all.dim);
        let is_framed = model.mesh.is_of_file();
        let mut traction = vec![0.0; all.nodes.len() * dim];
        for (rows, response) in all.secondary.iter().zip(&problem.interfaces.response) {
            let own = &mut traction[rows.node as usize * dim..][..dim];
            own.copy_from_slice(&response.bulk_traction[..dim]);
        }
        all.nodes.update_ghosts(&mut traction, dim);
        let mut values = Self { dim, traction, joined: Vec::new(), is_framed };
        let mut joined = vec![0.0; all.nodes.len() * 2 * dim];
        for (interface, grid) in grids.iter().enumerate() {
            for facet in &grid.facets {
                for c in 0..dim {
                    values.join(model, interface, facet, c, &mut joined);
                }
            }
        }
        all.nodes.add_to_owners(&mut joined, 2 * dim);
        values.joined = joined;
        values
    }

    /// Adds component c of the mean over the multipliers of a facet to the nodes that have none.
    fn join(
        &self,
        model: &Model<'_>,
        interface: usize,
        facet: &[u32],
        c: usize,
        joined: &mut [f64],
    ) {
        let problem = &model.stepper.problem;
        let kept: Vec<(u32, [f64; 3])> =
            facet.iter().filter_map(|n| Some((*n, self.kept(problem, *n, c)?))).collect();
        if kept.is_empty() {
            return;
        }
        let normal = |node: u32| self.normal_of(model, interface, node);
        for node in facet.iter().filter(|n| self.kept(problem, **n, c).is_none()) {
            let of = |(other, v): &(u32, [f64; 3])| match self.is_framed {
                true => turned(*v, normal(*other), normal(*node))[c],
                false => v[c],
            };
            let mean = kept.iter().map(of).sum::<f64>() / kept.len() as f64;
            joined[*node as usize * 2 * self.dim + c] += mean;
            joined[*node as usize * 2 * self.dim + self.dim + c] += 1.0;
        }
    }

    /// The multiplier at a local node, along the axes where nodes have frames; none where component
    /// c has none, in frames not all of them.
    fn kept(&self, problem: &Problem<'_>, node: u32, c: usize) -> Option<[f64; 3]> {
        let (all, dim) = (&problem.all, self.dim);
        let rows = &all.secondary[all.secondary_of[node as usize]? as usize].rows;
        let own = &self.traction[node as usize * dim..][..dim];
        if !self.is_framed {
            let padded = std::array::from_fn(|c| own.get(c).copied().unwrap_or(0.0));
            return rows[c].as_ref().map(|_| padded);
        }
        if rows[..dim].iter().any(Option::is_none) {
            return None;
        }
        Some(along_axes(problem, node, own))
    }

    /// Traction at an owned node by component (Pa). Local.
    pub fn traction(&self, model: &Model<'_>, node: u32) -> [f64; 3] {
        let (place, dim) = (node as usize, self.dim);
        let mean = |c: usize| {
            let [sum, count] = [0, dim].map(|offset| self.joined[place * 2 * dim + offset + c]);
            (count > 0.0).then(|| sum / count)
        };
        let own = &self.traction[place * dim..][..dim];
        if !self.is_framed {
            return std::array::from_fn(|c| if c < dim { mean(c).unwrap_or(own[c]) } else { 0.0 });
        }
        let problem = &model.stepper.problem;
        let (all, mut own) = (&problem.all, own.to_vec());
        let mean = std::array::from_fn(|c| if c < dim { mean(c).unwrap_or(0.0) } else { 0.0 });
        let mean = all.frames.turned(&all.frames.rotation(node), mean);
        let rows = all.secondary_of[place].map(|index| &all.secondary[index as usize].rows);
        for c in (0..dim).filter(|c| rows.is_none_or(|rows| rows[*c].is_none())) {
            own[c] = mean[c];
        }
        along_axes(problem, node, &own)
    }

    /// The jump at an owned node by component (m), 0 where there is no multiplier. Local.
    pub fn jump(&self, model: &Model<'_>, node: u32) -> [f64; 3] {
        let problem = &model.stepper.problem;
        let index = problem.all.secondary_of[node as usize].map(|index| index as usize);
        let index = index.filter(|index| *index < problem.interfaces.response.len());
        let jump = index.map_or([0.0; 3], |index| problem.interfaces.jump_since_start(index));
        if !self.is_framed {
            return jump;
        }
        along_axes(&model.stepper.problem, node, &jump[..self.dim])
    }

    /// The gap at an owned node before anything moves (m), 0 where there is no multiplier. Local.
    pub fn gap(&self, model: &Model<'_>, node: u32) -> f64 {
        let problem = &model.stepper.problem;
        let index = problem.all.secondary_of[node as usize];
        index.and_then(|i| problem.interfaces.gaps.get(i as usize).copied()).unwrap_or(0.0)
    }

    /// How far an owned node has slid in contact (m), 0 where there is no multiplier. Local.
    pub fn slip(&self, model: &Model<'_>, node: u32) -> f64 {
        let problem = &model.stepper.problem;
        let index = problem.all.secondary_of[node as usize];
        let of = |i: u32| problem.interfaces.sliding.get(i as usize).map(|sliding| sliding.path);
        index.and_then(of).unwrap_or(0.0)
    }

    /// The normal of the interface at an owned node by component, from the lower to the upper side.
    /// Local.
    pub fn normal(&self, model: &Model<'_>, node: u32) -> [f64; 3] {
        let name = model.stepper.problem.all.nodes.names[node as usize];
        let place = model.mesh.nodes.number(name);
        let lip = place.and_then(|place| model.mesh.nodes.marks[place].lip());
        self.normal_of(model, lip.map_or(usize::MAX, |(interface, _)| interface), node)
    }

    /// The normal of one of the interfaces at a node of this rank's own cells.
    fn normal_of(&self, model: &Model<'_>, interface: usize, node: u32) -> [f64; 3] {
        let problem = &model.stepper.problem;
        let place = model.mesh.nodes.number(problem.all.nodes.names[node as usize]);
        let told = place.and_then(|p| model.mesh.directions.of_lip(p as u32, interface));
        told.unwrap_or_else(|| problem.all.frames.rotation(node)[self.dim - 1])
    }

    /// The answer of the law at an owned node; none where there is no multiplier. Local.
    pub fn response<'m>(&self, model: &'m Model<'_>, node: u32) -> Option<&'m NodeResponse> {
        let problem = &model.stepper.problem;
        let index = problem.all.secondary_of[node as usize]?;
        problem.interfaces.response.get(index as usize)
    }
}

/// A vector turned as the normal `to` is from the normal `from`, about the axis across both.
fn turned(v: [f64; 3], from: [f64; 3], to: [f64; 3]) -> [f64; 3] {
    let dot = |a: [f64; 3], b: [f64; 3]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
    let whole = 1.0 + dot(from, to);
    if whole < OPPOSITE {
        return v;
    }
    let sum: [f64; 3] = std::array::from_fn(|i| from[i] + to[i]);
    let (part, along) = (dot(sum, v) / whole, dot(from, v));
    std::array::from_fn(|i| v[i] - part * sum[i] + 2.0 * along * to[i])
}

/// Normals that look against each other say nothing of a turn: 1 and the cosine between them.
const OPPOSITE: f64 = 1e-6;

/// The components along the axes of a vector in the frame of a node.
fn along_axes(problem: &Problem<'_>, node: u32, v: &[f64]) -> [f64; 3] {
    let padded = std::array::from_fn(|c| v.get(c).copied().unwrap_or(0.0));
    let frames = &problem.all.frames;
    frames.turned_back(&frames.rotation(node), padded)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_along_one_normal_is_turned_to_be_along_the_other() {
        let (from, to) = ([0.0, 0.6, 0.8], [0.48, 0.6, 0.64]);
        let v = turned(from.map(|x| 3.0 * x), from, to);
        assert!((0..3).all(|i| (v[i] - 3.0 * to[i]).abs() < 1e-15), "{v:?}");
        // Across both it stays; lengths stay too.
        let across = [-0.096, 0.384, -0.288];
        let v = turned(across, from, to);
        assert!((0..3).all(|i| (v[i] - across[i]).abs() < 1e-15), "{v:?}");
        let v = turned([1.0, 2.0, 3.0], from, to);
        assert!((v.iter().map(|x| x * x).sum::<f64>() - 14.0).abs() < 1e-13, "{v:?}");
        assert_eq!(turned([1.0, 2.0, 0.0], [1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]), [1.0, 2.0, 0.0]);
    }
}
