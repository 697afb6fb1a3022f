//! Field files: the bulk, and the secondary side of each interface.

use std::path::Path;

use crate::bulk::PoroState;
use crate::case::{BULK, Case};
use crate::comm::Comm;
use crate::element::Shape;
use crate::error::Result;
use crate::fault;
use crate::mesh::axes;
use crate::output::publisher::Publisher;
use crate::output::series::{Fixed, Instant, Series};
use crate::output::vtkhdf::{Array, Data, Grid, Values};
use crate::solve::{Model, Problem};

/// Writes the fields of every wanted instant.
pub struct FieldWriter {
    /// What every bulk file repeats, once it is known.
    mesh: Option<BulkMesh>,
    bulk: Series,
    interfaces: Vec<Series>,
    /// The facets of each interface, once they are known.
    grids: Option<Vec<InterfaceGrid>>,
    /// The instants so far.
    pub written: Vec<Instant>,
}

impl FieldWriter {
    /// Series in the directory `fields` that go on from the instants that an earlier run has
    /// written.
    pub fn new(case: &Case, fields: &Path, written: Vec<Instant>) -> Self {
        let series = |name: &str| Series::resume(fields.to_path_buf(), name, &written);
        Self {
            mesh: None,
            bulk: series(BULK),
            interfaces: case.interfaces.iter().map(|i| series(&i.name)).collect(),
            grids: None,
            written,
        }
    }

    /// Writes the state that `model` has reached as that of an instant. Collective.
    ///
    /// # Errors
    /// `System` when a file cannot be written.
    pub fn write(
        &mut self,
        comm: &Comm,
        publisher: &mut Publisher,
        case: &Case,
        model: &Model<'_>,
        instant: Instant,
    ) -> Result<()> {
        self.written.push(instant);
        self.write_bulk(comm, publisher, case, model, instant)?;
        let problem = &model.stepper.problem;
        let grids = self.grids.get_or_insert_with(|| {
            (0..case.interfaces.len()).map(|i| InterfaceGrid::new(comm, model, i)).collect()
        });
        let tractions = NodalTractions::new(model, grids);
        for (index, (series, side)) in self.interfaces.iter_mut().zip(&*grids).enumerate() {
            let points: Vec<[f64; 3]> =
                side.nodes.iter().map(|i| point(model, problem.all.secondary[*i].node)).collect();
            let grid = Grid {
                points: &points,
                connectivity: &side.connectivity,
                shapes: &vec![side.shape; side.connectivity.len() / side.shape.nodes()],
            };
            let state = &problem.interfaces;
            let vectors = |of: &dyn Fn(usize) -> [f64; 3]| -> Vec<f64> {
                side.nodes.iter().flat_map(|i| in_space(of(*i), case.dim)).collect()
            };
            let traction = vectors(&|i| tractions.at(problem.all.secondary[i].node));
            let jump = vectors(&|i| state.response[i].jump);
            let law = state.laws[index].spec.law();
            let damage: Vec<f64> =
                side.nodes.iter().map(|i| law.damage(state.response[*i].history)).collect();
            let branch: Vec<i32> =
                side.nodes.iter().map(|i| state.response[*i].branch as i32).collect();
            let names: Vec<i64> = side
                .nodes
                .iter()
                .map(|i| problem.all.nodes.names[problem.all.secondary[*i].node as usize] as i64)
                .collect();
            let mut data = vec![
                Array { name: "traction", components: 3, values: Values::F64(&traction) },
                Array { name: "jump", components: 3, values: Values::F64(&jump) },
                Array { name: "damage", components: 1, values: Values::F64(&damage) },
                Array { name: "state", components: 1, values: Values::I32(&branch) },
            ];
            let film = case.interfaces[index].film.as_ref();
            let pressure = film.map(|_| film_pressure(model, &side.nodes));
            data.extend(pressure.iter().map(|pressure| {
                let values = Values::F64(pressure);
                Array { name: "pressure", components: 1, values }
            }));
            let known =
                [Array { name: "global_node_id", components: 1, values: Values::I64(&names) }];
            let fixed = Fixed { grid: &grid, data: Data { points: &known, cells: &[] } };
            let data = Data { points: &data, cells: &[] };
            series.write(comm, publisher, instant, fixed, data)?;
        }
        Ok(())
    }

    fn write_bulk(
        &mut self,
        comm: &Comm,
        publisher: &mut Publisher,
        case: &Case,
        model: &Model<'_>,
        instant: Instant,
    ) -> Result<()> {
        let problem = &model.stepper.problem;
        let (all, dim) = (&problem.all, case.dim);
        let mesh = self.mesh.get_or_insert_with(|| BulkMesh::new(comm, model));
        let mut displacement = vec![0.0; 3 * all.nodes.owned];
        let nodal = problem.displacement.chunks_exact(dim);
        for (out, u) in displacement.chunks_exact_mut(3).zip(nodal) {
            axes(dim).iter().zip(u).for_each(|(axis, u)| out[*axis] = *u);
        }
        fault::strike_values(comm, "fields", &mut displacement)?;
        let mut stress = Vec::with_capacity(6 * all.cells.len());
        let mut u = Vec::new();
        for cell in 0..all.cells.len() {
            u.clear();
            for node in all.cells.nodes(cell) {
                u.extend_from_slice(&problem.displacement[*node as usize * dim..][..dim]);
            }
            stress.extend(all.cells.stiffness(cell).stress(&u));
        }
        let grid =
            Grid { points: &mesh.points, connectivity: &mesh.connectivity, shapes: &mesh.shapes };
        let array = |name, components, values| Array { name, components, values };
        let known = Data {
            points: &[array("global_node_id", 1, Values::I64(&mesh.nodes))],
            cells: &[
                array("material", 1, Values::I32(&mesh.material)),
                array("rank", 1, Values::I32(&mesh.rank)),
                array("global_cell_id", 1, Values::I64(&mesh.cells)),
            ],
        };
        let mut points = vec![array("displacement", 3, Values::F64(&displacement))];
        let mut cells = vec![array("stress", 6, Values::F64(&stress))];
        let pores = PoreFields::new(model, &stress);
        if let Some(pores) = &pores {
            points.push(array("pressure", 1, Values::F64(&pores.pressure)));
            cells = vec![
                array("stress", 6, Values::F64(&pores.total_stress)),
                array("effective_stress", 6, Values::F64(&stress)),
            ];
            if case.flow.is_some() {
                cells.push(array("fluid_flux", 3, Values::F64(&pores.flux)));
                cells.push(array("porosity", 1, Values::F64(&pores.porosity)));
            }
        }
        let data = Data { points: &points, cells: &cells };
        let fixed = Fixed { grid: &grid, data: known };
        self.bulk.write(comm, publisher, instant, fixed, data)
    }
}

/// What a pore pressure adds to the bulk; values of cells without pores are 0, their stress has no
/// part in it.
struct PoreFields {
    /// At owned nodes (Pa).
    pressure: Vec<f64>,
    /// At the centres of cells: stress of skeleton and fluid together (Pa).
    total_stress: Vec<f64>,
    /// Mass flux (kg/m2/s).
    flux: Vec<f64>,
    porosity: Vec<f64>,
}

impl PoreFields {
    /// None without a pressure. Collective.
    fn new(model: &Model<'_>, effective_stress: &[f64]) -> Option<Self> {
        let (space, pressure) = model.stepper.pores()?;
        let gravity = model.stepper.coupling.as_ref().map(|coupling| coupling.flow.step.gravity);
        let problem = &model.stepper.problem;
        let (all, cells) = (&problem.all, problem.all.cells.len());
        let mut fields = Self {
            pressure: space.at_nodes(all, pressure),
            total_stress: effective_stress.to_vec(),
            flux: vec![0.0; 3 * cells],
            porosity: vec![0.0; cells],
        };
        for pores in &space.cells {
            let state = PoroState { displacement: &problem.displacement, pressure };
            let (flux, pressure, porosity) =
                space.at_centre(all, pores, state, &gravity.unwrap_or_default());
            let cell = pores.cell as usize;
            let biot = space.prototypes[pores.prototype as usize].medium.biot;
            for normal in &mut fields.total_stress[6 * cell..][..3] {
                *normal -= biot * pressure;
            }
            fields.flux[3 * cell..][..3].copy_from_slice(&in_space(flux, all.dim));
            fields.porosity[cell] = porosity;
        }
        Some(fields)
    }
}

/// Pressure of the film at entries of `Discretization::secondary` (Pa), 0 where there is none.
fn film_pressure(model: &Model<'_>, nodes: &[usize]) -> Vec<f64> {
    let mut pressure = vec![0.0; model.stepper.problem.all.secondary.len()];
    let flow = model.stepper.coupling.as_ref().map(|coupling| &coupling.flow);
    for (index, value) in flow.iter().flat_map(|f| f.space.films.pressures(&f.pressure)) {
        pressure[index as usize] = value;
    }
    nodes.iter().map(|index| pressure[*index]).collect()
}

fn point(model: &Model<'_>, node: u32) -> [f64; 3] {
    model.stepper.problem.all.nodes.points[node as usize]
}

/// Components to x, y, z.
fn in_space(v: [f64; 3], dim: usize) -> [f64; 3] {
    let mut out = [0.0; 3];
    axes(dim).iter().enumerate().for_each(|(c, axis)| out[*axis] = v[c]);
    out
}

/// The bulk mesh of one rank as the files hold it.
struct BulkMesh {
    points: Vec<[f64; 3]>,
    shapes: Vec<Shape>,
    connectivity: Vec<i64>,
    nodes: Vec<i64>,
    cells: Vec<i64>,
    material: Vec<i32>,
    rank: Vec<i32>,
}

impl BulkMesh {
    fn new(comm: &Comm, model: &Model<'_>) -> Self {
        let all = &model.stepper.problem.all;
        let number = |n: &u32| i64::from(all.nodes.numbers[*n as usize]);
        let shape = |p: &u32| model.mesh.prototypes[*p as usize].shape;
        let material = |p: &u32| model.mesh.prototypes[*p as usize].material as i32;
        Self {
            points: (0..all.nodes.owned as u32).map(|n| point(model, n)).collect(),
            shapes: model.mesh.cell_prototype.iter().map(shape).collect(),
            connectivity: all.cells.connectivity().iter().map(number).collect(),
            nodes: all.nodes.names[..all.nodes.owned].iter().map(|n| *n as i64).collect(),
            cells: model.mesh.cells.iter().map(|c| *c as i64).collect(),
            material: model.mesh.cell_prototype.iter().map(material).collect(),
            rank: vec![comm.rank(); all.cells.len()],
        }
    }
}

/// The facets of one interface: owned secondary nodes as points, facets of the rank's own cells.
struct InterfaceGrid {
    /// Indices into `Discretization::secondary`.
    nodes: Vec<usize>,
    /// Local nodes of each facet.
    facets: Vec<Vec<u32>>,
    connectivity: Vec<i64>,
    shape: Shape,
}

impl InterfaceGrid {
    fn new(comm: &Comm, model: &Model<'_>, interface: usize) -> Self {
        let all = &model.stepper.problem.all;
        let nodes: Vec<usize> = (0..all.owned_secondary())
            .filter(|i| all.secondary[*i].interface == interface)
            .collect();
        let first = comm.exscan_u64(nodes.len() as u64);
        // Rows are whole numbers far below 2^53.
        let mut row = vec![0.0; all.nodes.len()];
        for (i, index) in nodes.iter().enumerate() {
            row[all.secondary[*index].node as usize] = (first + i as u64) as f64;
        }
        all.nodes.update_ghosts(&mut row, 1);
        let facets = facets(model, interface);
        let connectivity = facets.iter().flatten().map(|n| row[*n as usize] as i64).collect();
        let order = model.sides[interface].secondary_facts(&model.mesh.facts).order;
        let shape = Shape::of(all.dim - 1, order);
        Self { nodes, facets, connectivity, shape }
    }
}

/// Local nodes of the secondary facets of this rank's cells.
fn facets(model: &Model<'_>, interface: usize) -> Vec<Vec<u32>> {
    let (mesh, lip) = (&model.mesh, model.sides[interface].secondary);
    let nodes = &model.stepper.problem.all.nodes;
    let local = |node: u32| {
        let name = mesh.nodes.names[node as usize];
        nodes.local(name).expect("a node of the rank's own cell")
    };
    let facets = mesh.on_lip(interface, lip).iter().map(|facet| mesh.lip_nodes(lip, *facet).1);
    facets.map(|nodes| nodes.into_iter().map(local).collect()).collect()
}

/// Tractions at nodes (Pa); where a component has no multiplier, the mean over its facets of the
/// multipliers it was joined to.
struct NodalTractions {
    dim: usize,
    /// Of the multipliers, at all local nodes.
    traction: Vec<f64>,
    /// Sums and counts over the facets of nodes without a multiplier.
    joined: Vec<f64>,
}

impl NodalTractions {
    /// Collective.
    fn new(model: &Model<'_>, grids: &[InterfaceGrid]) -> Self {
        let problem: &Problem<'_> = &model.stepper.problem;
        let (all, dim) = (&problem.all, problem.all.dim);
        let mut traction = vec![0.0; all.nodes.len() * dim];
        for (rows, response) in all.secondary.iter().zip(&problem.interfaces.response) {
            traction[rows.node as usize * dim..][..dim]
                .copy_from_slice(&response.bulk_traction[..dim]);
        }
        all.nodes.update_ghosts(&mut traction, dim);
        let has_row = |node: u32, c: usize| {
            let index = all.secondary_of[node as usize];
            index.is_some_and(|i| all.secondary[i as usize].rows[c].is_some())
        };
        let mut joined = vec![0.0; all.nodes.len() * 2 * dim];
        for facet in grids.iter().flat_map(|grid| &grid.facets) {
            for c in 0..dim {
                let kept: Vec<f64> = facet
                    .iter()
                    .filter(|n| has_row(**n, c))
                    .map(|n| traction[*n as usize * dim + c])
                    .collect();
                if kept.is_empty() {
                    continue;
                }
                let mean = kept.iter().sum::<f64>() / kept.len() as f64;
                for node in facet.iter().filter(|n| !has_row(**n, c)) {
                    joined[*node as usize * 2 * dim + c] += mean;
                    joined[*node as usize * 2 * dim + dim + c] += 1.0;
                }
            }
        }
        all.nodes.add_to_owners(&mut joined, 2 * dim);
        Self { dim, traction, joined }
    }

    /// Local; complete at owned nodes.
    fn at(&self, node: u32) -> [f64; 3] {
        let (node, dim) = (node as usize, self.dim);
        let value = |c: usize| {
            let [sum, count] = [0, dim].map(|offset| self.joined[node * 2 * dim + offset + c]);
            if count > 0.0 { sum / count } else { self.traction[node * dim + c] }
        };
        std::array::from_fn(|c| if c < dim { value(c) } else { 0.0 })
    }
}
