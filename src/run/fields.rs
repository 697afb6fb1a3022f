//! Field files: the bulk, and the secondary side of each interface.

use std::path::Path;

use super::interface_values::{InterfaceGrid, NodalValues};
use crate::assembly::Discretization;
use crate::bulk::PoroState;
use crate::case::{BULK, Case, Surface};
use crate::comm::Comm;
use crate::element::Shape;
use crate::error::Result;
use crate::fault;
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
        let values = NodalValues::new(model, grids);
        for (index, (series, side)) in self.interfaces.iter_mut().zip(&*grids).enumerate() {
            let points: Vec<[f64; 3]> = side.nodes.iter().map(|n| point(model, *n)).collect();
            let grid =
                Grid { points: &points, connectivity: &side.connectivity, shapes: &side.shapes };
            let state = &problem.interfaces;
            let in_space = |vectors: Vec<[f64; 3]>| -> Vec<f64> {
                vectors.into_iter().flat_map(|v| in_space(v, case.axes)).collect()
            };
            let nodes = side.nodes.iter().copied();
            let traction = in_space(nodes.clone().map(|n| values.traction(model, n)).collect());
            let jump = in_space(nodes.clone().map(|n| values.jump(model, n)).collect());
            let law = state.laws[index].spec.law();
            let response = |n: u32| values.response(model, n);
            let damage = |n: u32| response(n).map_or(0.0, |of| law.damage(of.history));
            let damage: Vec<f64> = nodes.clone().map(damage).collect();
            let branch = |n: u32| response(n).map_or(0, |of| of.branch as i32);
            let branch: Vec<i32> = nodes.map(branch).collect();
            let mut data = vec![
                Array { name: "traction", components: 3, values: Values::F64(&traction) },
                Array { name: "jump", components: 3, values: Values::F64(&jump) },
                Array { name: "damage", components: 1, values: Values::F64(&damage) },
                Array { name: "state", components: 1, values: Values::I32(&branch) },
            ];
            let slip = case.interfaces[index]
                .has_friction()
                .then(|| side.nodes.iter().map(|n| values.slip(model, *n)).collect::<Vec<f64>>());
            data.extend(slip.iter().map(|slip| {
                let values = Values::F64(slip);
                Array { name: "slip", components: 1, values }
            }));
            let film = case.interfaces[index].film.as_ref();
            let pressure = film.map(|_| film_pressure(model, &side.nodes));
            data.extend(pressure.iter().map(|pressure| {
                let values = Values::F64(pressure);
                Array { name: "pressure", components: 1, values }
            }));
            let known = InterfacePoints::new(case, model, &values, index, &side.nodes);
            let known = &known.arrays();
            let fixed = Fixed { grid: &grid, data: Data { points: known, cells: &[] } };
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
        let (all, axes, dim) = (&problem.all, case.axes, case.dim);
        let mesh = self.mesh.get_or_insert_with(|| BulkMesh::new(comm, case, model));
        let mut displacement = vec![0.0; 3 * all.nodes.owned];
        let all_displacements = all.frames.displacements(&problem.displacement);
        let since_start = problem.displacement_since_start();
        let since_start = all.frames.displacements(&since_start);
        let nodal = since_start.chunks_exact(dim);
        for (out, u) in displacement.chunks_exact_mut(3).zip(nodal) {
            axes.iter().zip(u).for_each(|(axis, u)| out[*axis] = *u);
        }
        fault::strike_values(comm, "fields", &mut displacement)?;
        let stress = stresses(problem, &all_displacements);
        let grid =
            Grid { points: &mesh.points, connectivity: &mesh.connectivity, shapes: &mesh.shapes };
        let array = |name, components, values| Array { name, components, values };
        let mut of_points = vec![array("global_node_id", 1, Values::I64(&mesh.nodes))];
        for (name, is_on) in &mesh.surfaces {
            of_points.push(array(name.as_str(), 1, Values::I32(is_on)));
        }
        let known = Data {
            points: &of_points,
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

/// The stress at the centre of each cell (Pa) under displacements along the axes (m), with that of
/// the start and those that stay from earlier stages. Local.
fn stresses(problem: &Problem<'_>, displacements: &[f64]) -> Vec<f64> {
    let (all, dim) = (&problem.all, problem.all.dim);
    let mut stress = Vec::with_capacity(6 * all.cells.len());
    let mut u = Vec::new();
    for cell in 0..all.cells.len() {
        u.clear();
        for node in all.cells.nodes(cell) {
            u.extend_from_slice(&displacements[*node as usize * dim..][..dim]);
        }
        stress.extend(all.cells.stress(cell, &u));
    }
    let of_start = problem.initial_stress.iter().map(|stress| &stress.at_centres);
    let of_stages = problem.prestress.iter().map(|prestress| &prestress.stress);
    for before in of_start.chain(of_stages) {
        stress.iter_mut().zip(before.as_flattened()).for_each(|(sum, before)| *sum += before);
    }
    stress
}

/// What the points of an interface have at all times.
struct InterfacePoints {
    names: Vec<i64>,
    /// In the mesh of a file.
    normals: Option<Vec<f64>>,
    /// Where the sides may lie apart (m).
    gaps: Option<Vec<f64>>,
}

impl InterfacePoints {
    fn new(
        case: &Case,
        model: &Model<'_>,
        values: &NodalValues,
        interface: usize,
        nodes: &[u32],
    ) -> Self {
        let all = &model.stepper.problem.all;
        let normal = |n: &u32| in_space(values.normal(model, *n), case.axes);
        let is_of_file = case.mesh.file().is_some();
        let of = &case.interfaces[interface];
        let has_gap = of.has_gap || of.initial.gap.is_some();
        Self {
            names: nodes.iter().map(|n| all.nodes.names[*n as usize] as i64).collect(),
            normals: is_of_file.then(|| nodes.iter().flat_map(normal).collect()),
            gaps: has_gap.then(|| nodes.iter().map(|n| values.gap(model, *n)).collect()),
        }
    }

    fn arrays(&self) -> Vec<Array<'_>> {
        let array = |name, components, values| Array { name, components, values };
        let mut arrays = vec![array("global_node_id", 1, Values::I64(&self.names))];
        arrays.extend(self.normals.iter().map(|of| array("normal", 3, Values::F64(of))));
        arrays.extend(self.gaps.iter().map(|of| array("initial_gap", 1, Values::F64(of))));
        arrays
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
        let displacement = all.frames.displacements(&problem.displacement);
        for pores in &space.cells {
            let state = PoroState { displacement: &displacement, pressure };
            let (flux, pressure, porosity) =
                space.at_centre(all, pores, state, &gravity.unwrap_or_default());
            let cell = pores.cell as usize;
            let biot = space.prototypes[pores.prototype as usize].medium.biot;
            for normal in &mut fields.total_stress[6 * cell..][..3] {
                *normal -= biot * pressure;
            }
            fields.flux[3 * cell..][..3].copy_from_slice(&in_space(flux, model.mesh.facts.axes));
            fields.porosity[cell] = porosity;
        }
        Some(fields)
    }
}

/// Pressure of the film at owned nodes of the secondary lip (Pa), that of the pores where
/// interfaces meet or end. Collective.
fn film_pressure(model: &Model<'_>, nodes: &[u32]) -> Vec<f64> {
    let all = &model.stepper.problem.all;
    let mut pressure = vec![0.0; all.secondary.len()];
    let flow = model.stepper.coupling.as_ref().map(|coupling| &coupling.flow);
    for (index, value) in flow.iter().flat_map(|f| f.space.films.pressures(&f.pressure)) {
        pressure[index as usize] = value;
    }
    let of_pores = flow.filter(|_| model.mesh.is_of_file());
    let of_pores = of_pores.map(|flow| flow.space.at_nodes(all, &flow.pressure));
    let at = |node: &u32| match all.secondary_of[*node as usize] {
        Some(index) => pressure[index as usize],
        None => of_pores.as_ref().map_or(0.0, |of_pores| of_pores[*node as usize]),
    };
    nodes.iter().map(at).collect()
}

fn point(model: &Model<'_>, node: u32) -> [f64; 3] {
    model.stepper.problem.all.nodes.points[node as usize]
}

/// Components to x, y, z.
fn in_space(v: [f64; 3], axes: &[usize]) -> [f64; 3] {
    let mut out = [0.0; 3];
    axes.iter().enumerate().for_each(|(c, axis)| out[*axis] = v[c]);
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
    /// Of the mesh of a file: by surface whether a point lies on it.
    surfaces: Vec<(String, Vec<i32>)>,
}

impl BulkMesh {
    fn new(comm: &Comm, case: &Case, model: &Model<'_>) -> Self {
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
            surfaces: surfaces(case, all),
        }
    }
}

/// The surfaces of the mesh of a file, by name of the array, with whether each owned node lies
/// there. Of a column they are where they look like.
fn surfaces(case: &Case, all: &Discretization) -> Vec<(String, Vec<i32>)> {
    if case.mesh.file().is_none() {
        return Vec::new();
    }
    let is_on = |surface: &Surface| {
        let (bit, owned) = (case.surface_bit(surface), &all.nodes.marks[..all.nodes.owned]);
        let is_on = owned.iter().map(|marks| i32::from(marks.is_on(bit)));
        (format!("surface_{}", surface.name()), is_on.collect())
    };
    case.surfaces().iter().map(is_on).collect()
}
