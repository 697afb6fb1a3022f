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
/// over its facets of the multipliers it was joined to.
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
        for facet in grids.iter().flat_map(|grid| &grid.facets) {
            for c in 0..dim {
                let kept: Vec<f64> =
                    facet.iter().filter_map(|n| values.kept(problem, *n, c)).collect();
                if kept.is_empty() {
                    continue;
                }
                let mean = kept.iter().sum::<f64>() / kept.len() as f64;
                for node in facet.iter().filter(|n| values.kept(problem, **n, c).is_none()) {
                    joined[*node as usize * 2 * dim + c] += mean;
                    joined[*node as usize * 2 * dim + dim + c] += 1.0;
                }
            }
        }
        all.nodes.add_to_owners(&mut joined, 2 * dim);
        values.joined = joined;
        values
    }

    /// Component c of the multiplier at a local node, along an axis where nodes have frames; none
    /// where it has none, in frames not all of them.
    fn kept(&self, problem: &Problem<'_>, node: u32, c: usize) -> Option<f64> {
        let (all, dim) = (&problem.all, self.dim);
        let rows = &all.secondary[all.secondary_of[node as usize]? as usize].rows;
        let own = &self.traction[node as usize * dim..][..dim];
        if !self.is_framed {
            return rows[c].as_ref().map(|_| own[c]);
        }
        if rows[..dim].iter().any(Option::is_none) {
            return None;
        }
        Some(along_axes(problem, node, own)[c])
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
        let jump = self.response(model, node).map_or([0.0; 3], |response| response.jump);
        if !self.is_framed {
            return jump;
        }
        along_axes(&model.stepper.problem, node, &jump[..self.dim])
    }

    /// The normal of the interface at an owned node by component, from the lower to the upper side.
    /// Local.
    pub fn normal(&self, model: &Model<'_>, node: u32) -> [f64; 3] {
        let name = model.stepper.problem.all.nodes.names[node as usize];
        let place = model.mesh.nodes.number(name);
        let told = place.and_then(|place| {
            let (interface, _) = model.mesh.nodes.marks[place].lip()?;
            model.mesh.directions.of_lip(place as u32, interface)
        });
        let frames = &model.stepper.problem.all.frames;
        told.unwrap_or_else(|| frames.rotation(node)[self.dim - 1])
    }

    /// The answer of the law at an owned node; none where there is no multiplier. Local.
    pub fn response<'m>(&self, model: &'m Model<'_>, node: u32) -> Option<&'m NodeResponse> {
        let problem = &model.stepper.problem;
        let index = problem.all.secondary_of[node as usize]?;
        problem.interfaces.response.get(index as usize)
    }
}

/// The components along the axes of a vector in the frame of a node.
fn along_axes(problem: &Problem<'_>, node: u32, v: &[f64]) -> [f64; 3] {
    let padded = std::array::from_fn(|c| v.get(c).copied().unwrap_or(0.0));
    let frames = &problem.all.frames;
    frames.turned_back(&frames.rotation(node), padded)
}
