//! Body force, gravity, surface tractions and fluid pressure on the lips of the interfaces; fluxes.

use crate::case::{Case, Value};
use crate::element::{QuadraturePoint, Shape, gauss};
use crate::error::{Error, Result};
use crate::mesh::{Facet, Lip, LocalMesh, axes};

/// The loads of one rank's cells, ready to be evaluated at any time.
#[derive(Debug, Clone, Default)]
pub struct Loads {
    patches: Vec<Patch>,
    sources: Vec<Source>,
    /// Values of the shape functions at the quadrature points of each shape that occurs.
    values: Vec<(Shape, Vec<Vec<f64>>)>,
    dim: usize,
}

/// A load of the case: one vector field, by axis.
#[derive(Debug, Clone)]
struct Source {
    /// Where it stands in the case, for messages.
    name: String,
    components: [Option<Value>; 3],
    sign: f64,
}

/// A cell or a facet under one load.
#[derive(Debug, Clone)]
struct Patch {
    source: usize,
    /// Index into `Loads::values`.
    shape: usize,
    nodes: Vec<u64>,
    points: Vec<LoadPoint>,
}

#[derive(Debug, Clone)]
struct LoadPoint {
    position: [f64; 3],
    /// Weight times measure (m3 or m2).
    weight: f64,
}

impl Loads {
    /// Finds the loaded cells and facets of this rank. Local.
    pub fn new(case: &Case, mesh: &LocalMesh) -> Self {
        let mut loads = Self { dim: case.dim, ..Self::default() };
        let body = case.body_force.clone().map(|v| (!v.is_zero()).then_some(v));
        if body.iter().any(Option::is_some) {
            let source = loads.source("body_force".into(), body, 1.0);
            (0..mesh.cells.len()).for_each(|cell| loads.cell(mesh, source, cell));
        }
        if case.gravity != [0.0; 3] {
            for (index, material) in case.materials.iter().enumerate() {
                let density = material.porous.as_ref().map_or(0.0, |porous| porous.density);
                let weight = case.gravity.map(|g| Some(Value::Constant(density * g)));
                let source = loads.source("gravity".into(), weight, 1.0);
                for cell in 0..mesh.cells.len() {
                    if mesh.prototype(cell).material == index {
                        loads.cell(mesh, source, cell);
                    }
                }
            }
        }
        for (number, entry) in case.boundary.iter().enumerate() {
            let traction = entry.traction.clone().map(|v| v.filter(|v| !v.is_zero()));
            if traction.iter().any(Option::is_some) {
                let name = format!("boundary.{number} ({}): traction", entry.on.name());
                let source = loads.source(name, traction, 1.0);
                loads.facets(mesh, source, mesh.on_surface(entry.on), |_| true);
            }
        }
        for (index, interface) in case.interfaces.iter().enumerate() {
            let pressure = interface.fluid_pressure.clone().filter(|v| !v.is_zero());
            if pressure.is_some() {
                let name = format!("interfaces.{}: fluid.pressure", interface.name);
                for (sign, lip) in [(1.0, Lip::Upper), (-1.0, Lip::Lower)] {
                    let source = loads.source(name.clone(), [None, None, pressure.clone()], sign);
                    loads.facets(mesh, source, mesh.on_lip(index, lip), |_| true);
                }
            }
        }
        loads
    }

    /// The mass fluxes of the fluid into the porous cells at the surfaces, as component 0 (kg/s at
    /// nodes). `mesh` is the one of the pressure. Local.
    pub fn inflow(case: &Case, mesh: &LocalMesh) -> Self {
        let mut loads = Self { dim: 1, ..Self::default() };
        for (number, entry) in case.boundary.iter().enumerate() {
            let flux = entry.flux.clone().filter(|flux| !flux.is_zero());
            if flux.is_some() {
                let name = format!("boundary.{number} ({}): flux", entry.on.name());
                let source = loads.source(name, [flux, None, None], 1.0);
                let is_porous = |facet: &Facet| {
                    let material = mesh.prototype(facet.cell as usize).material;
                    case.materials[material].porous.is_some()
                };
                loads.facets(mesh, source, mesh.on_surface(entry.on), is_porous);
            }
        }
        loads
    }

    /// The mass that is injected into interfaces, as component 0 (kg/s at nodes of the lower lip).
    /// `mesh` is the one of the pressure. Local.
    pub fn injection(case: &Case, mesh: &LocalMesh) -> Self {
        let mut loads = Self { dim: 1, ..Self::default() };
        for (index, interface) in case.interfaces.iter().enumerate() {
            let rate = interface.film.as_ref().and_then(|film| film.injection.clone());
            if let Some(rate) = rate.filter(|rate| !rate.is_zero()) {
                let name = format!("interfaces.{}: fluid.injection", interface.name);
                let source = loads.source(name, [Some(rate), None, None], 1.0);
                loads.facets(mesh, source, mesh.on_lip(index, Lip::Lower), |_| true);
            }
        }
        loads
    }

    /// Whether this rank has no load.
    pub fn is_empty(&self) -> bool {
        self.patches.is_empty()
    }

    /// Checks that every load is finite at the instants. Local.
    ///
    /// # Errors
    /// `Input` when a formula gives no finite number at a quadrature point.
    pub fn check(&self, instants: &[f64]) -> Result<()> {
        instants.iter().try_for_each(|time| self.add(*time, |_, _, _| {}))
    }

    /// Adds the nodal forces at `time` (N): `add(name of the node, component, force)`. Local.
    ///
    /// # Errors
    /// `Input` when a formula gives no finite number at a quadrature point.
    pub fn add(&self, time: f64, mut add: impl FnMut(u64, usize, f64)) -> Result<()> {
        for patch in &self.patches {
            let source = &self.sources[patch.source];
            for (point, values) in patch.points.iter().zip(&self.values[patch.shape].1) {
                for (component, axis) in self.axes().iter().enumerate() {
                    let Some(value) = &source.components[*axis] else { continue };
                    let density = value.at(point.position, time);
                    if !density.is_finite() {
                        return Err(Error::Input(format!(
                            "{}.{} is {density} at ({}, {}, {}) m at time {time}; the formula \
                             must give finite numbers wherever the load acts, at every instant",
                            source.name,
                            ["x", "y", "z"][*axis],
                            point.position[0],
                            point.position[1],
                            point.position[2],
                        )));
                    }
                    let force = source.sign * density * point.weight;
                    for (node, n) in patch.nodes.iter().zip(values) {
                        add(*node, component, force * n);
                    }
                }
            }
        }
        Ok(())
    }

    /// The axes of the components; a flux has only one.
    fn axes(&self) -> &'static [usize] {
        if self.dim == 1 { &[0] } else { axes(self.dim) }
    }

    fn source(&mut self, name: String, components: [Option<Value>; 3], sign: f64) -> usize {
        self.sources.push(Source { name, components, sign });
        self.sources.len() - 1
    }

    fn facets(
        &mut self,
        mesh: &LocalMesh,
        source: usize,
        facets: &[Facet],
        acts_on: impl Fn(&Facet) -> bool,
    ) {
        for facet in facets.iter().filter(|facet| acts_on(facet)) {
            let (shape, nodes) = mesh.facet_nodes(*facet);
            self.patch(mesh, source, shape, &nodes);
        }
    }

    fn cell(&mut self, mesh: &LocalMesh, source: usize, cell: usize) {
        self.patch(mesh, source, mesh.shape(cell), mesh.cell_nodes(cell));
    }

    fn patch(&mut self, mesh: &LocalMesh, source: usize, shape: Shape, nodes: &[u32]) {
        let corners: Vec<[f64; 3]> =
            nodes.iter().map(|node| mesh.nodes.points[*node as usize]).collect();
        let nodes = nodes.iter().map(|node| mesh.nodes.names[*node as usize]).collect();
        // Cells are boxes: the measure is the product of the non-zero edge lengths.
        let far = corners.iter().fold(corners[0], |far, c| {
            std::array::from_fn(|i| {
                if (c[i] - corners[0][i]).abs() > (far[i] - corners[0][i]).abs() {
                    c[i]
                } else {
                    far[i]
                }
            })
        });
        let measure: f64 =
            (0..3).map(|i| (far[i] - corners[0][i]).abs()).filter(|l| *l > 0.0).product();
        let rule = gauss(shape, shape.order() + 1);
        let index = self.values.iter().position(|(of, _)| *of == shape).unwrap_or_else(|| {
            let values = |q: &QuadraturePoint| {
                let mut values = vec![0.0; shape.nodes()];
                shape.values(q.xi, &mut values);
                values
            };
            self.values.push((shape, rule.iter().map(values).collect()));
            self.values.len() - 1
        });
        let point = |(q, values): (&QuadraturePoint, &Vec<f64>)| {
            let position =
                std::array::from_fn(|i| corners.iter().zip(values).map(|(c, n)| c[i] * n).sum());
            LoadPoint { position, weight: q.weight * measure / f64::from(1 << shape.dim()) }
        };
        let points = rule.iter().zip(&self.values[index].1).map(point).collect();
        self.patches.push(Patch { source, shape: index, nodes, points });
    }
}
