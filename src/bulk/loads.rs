//! Body force, gravity, surface tractions and fluid pressure on the lips of the interfaces; fluxes.

use super::RulePoint;
use super::load_points::{LoadPoint, load_points};
use crate::case::{Case, SurfaceBit, Value};
use crate::element::{Shape, quadrature};
use crate::error::Result;
use crate::mesh::{Facet, Geometry, Lip, LocalMesh};

/// The loads of one rank's cells, ready to be evaluated at any time.
#[derive(Debug, Clone, Default)]
pub struct Loads {
    patches: Vec<Patch>,
    sources: Vec<Source>,
    /// The rule of each shape that occurs.
    rules: Vec<(Shape, Vec<RulePoint>)>,
    /// The axes of the components; a flux has only one.
    axes: &'static [usize],
}

/// A load of the case: one vector field.
#[derive(Debug, Clone)]
struct Source {
    /// Where it stands in the case, for messages.
    name: String,
    field: Field,
}

#[derive(Debug, Clone)]
enum Field {
    /// By axis.
    Components([Option<Value>; 3]),
    /// `sign` times the value along the normal that points out of the cell.
    Normal { value: Value, sign: f64 },
}

/// A cell or a facet under one load.
#[derive(Debug, Clone)]
struct Patch {
    source: usize,
    /// Index into `Loads::rules`.
    shape: usize,
    nodes: Vec<u64>,
    points: Vec<LoadPoint>,
}

impl Loads {
    /// Finds the loaded cells and facets of this rank. Local.
    pub fn new(case: &Case, mesh: &LocalMesh) -> Self {
        let mut loads = Self { axes: case.axes, ..Self::default() };
        let body = case.body_force.clone().map(|v| (!v.is_zero()).then_some(v));
        if body.iter().any(Option::is_some) {
            let source = loads.source("body_force".into(), Field::Components(body));
            (0..mesh.cells.len()).for_each(|cell| loads.cell(mesh, source, cell));
        }
        if case.gravity != [0.0; 3] {
            for (index, material) in case.materials.iter().enumerate() {
                let density = material.density.unwrap_or(0.0);
                let weight = case.gravity.map(|g| Some(Value::Constant(density * g)));
                let source = loads.source("gravity".into(), Field::Components(weight));
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
                let source = loads.source(name, Field::Components(traction));
                loads.facets(mesh, source, mesh.on_surface(case.surface_bit(&entry.on)), |_| true);
            }
        }
        for (number, entry) in case.boundary.iter().enumerate() {
            let normal = entry.normal_traction.clone().filter(|value| !value.is_zero());
            if let Some(value) = normal {
                let name = format!("boundary.{number} ({}): traction.normal", entry.on.name());
                let source = loads.source(name, Field::Normal { value, sign: 1.0 });
                loads.facets(mesh, source, mesh.on_surface(case.surface_bit(&entry.on)), |_| true);
            }
        }
        for (index, interface) in case.interfaces.iter().enumerate() {
            let pressure = interface.fluid_pressure.clone().filter(|v| !v.is_zero());
            if let Some(pressure) = pressure {
                let name = format!("interfaces.{}: fluid.pressure", interface.name);
                let source = loads.source(name, Field::Normal { value: pressure, sign: -1.0 });
                for lip in [Lip::Upper, Lip::Lower] {
                    loads.facets(mesh, source, mesh.on_lip(index, lip), |_| true);
                }
            }
        }
        loads
    }

    /// The mass fluxes of the fluid into the porous cells at the surfaces, as component 0 (kg/s at
    /// nodes). `mesh` is the one of the pressure. Local.
    pub fn inflow(case: &Case, mesh: &LocalMesh) -> Self {
        let mut loads = Self { axes: &[0], ..Self::default() };
        for (number, entry) in case.boundary.iter().enumerate() {
            let flux = entry.flux.clone().filter(|flux| !flux.is_zero());
            if flux.is_some() {
                let name = format!("boundary.{number} ({}): flux", entry.on.name());
                let source = loads.source(name, Field::Components([flux, None, None]));
                let is_porous = |facet: &Facet| {
                    let material = mesh.prototype(facet.cell as usize).material;
                    case.materials[material].porous.is_some()
                };
                loads.facets(mesh, source, mesh.on_surface(case.surface_bit(&entry.on)), is_porous);
            }
        }
        loads
    }

    /// The mass that is injected into interfaces, as component 0 (kg/s at nodes of the lower lip).
    /// `mesh` is the one of the pressure. Local.
    pub fn injection(case: &Case, mesh: &LocalMesh) -> Self {
        let mut loads = Self { axes: &[0], ..Self::default() };
        for (index, interface) in case.interfaces.iter().enumerate() {
            let rate = interface.film.as_ref().and_then(|film| film.injection.clone());
            if let Some(rate) = rate.filter(|rate| !rate.is_zero()) {
                let name = format!("interfaces.{}: fluid.injection", interface.name);
                let source = loads.source(name, Field::Components([Some(rate), None, None]));
                loads.facets(mesh, source, mesh.on_lip(index, Lip::Lower), |_| true);
            }
        }
        loads
    }

    /// The area of a surface, as component 0 (m2 at nodes; 2D: m). Local.
    pub fn area(mesh: &LocalMesh, surface: SurfaceBit) -> Self {
        let mut loads = Self { axes: &[0], ..Self::default() };
        let one = Field::Components([Some(Value::Constant(1.0)), None, None]);
        let source = loads.source("the area of a surface".into(), one);
        loads.facets(mesh, source, mesh.on_surface(surface), |_| true);
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
            let Source { name, field } = &self.sources[patch.source];
            for (point, of_rule) in patch.points.iter().zip(&self.rules[patch.shape].1) {
                let along_normal = match field {
                    Field::Normal { value, sign } => {
                        sign * point.value(value, time, || name.clone())?
                    }
                    Field::Components(_) => 0.0,
                };
                for (component, axis) in self.axes.iter().enumerate() {
                    let density = match field {
                        Field::Components(values) => {
                            let Some(value) = &values[*axis] else { continue };
                            let name = || format!("{name}.{}", ["x", "y", "z"][*axis]);
                            point.value(value, time, name)?
                        }
                        Field::Normal { .. } => along_normal * point.normal[*axis],
                    };
                    let force = density * point.weight;
                    for (node, n) in patch.nodes.iter().zip(&of_rule.values) {
                        add(*node, component, force * n);
                    }
                }
            }
        }
        Ok(())
    }

    fn source(&mut self, name: String, field: Field) -> usize {
        self.sources.push(Source { name, field });
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
            let index = self.rule(shape);
            self.patch(mesh, source, index, facet.cell as usize, &nodes);
        }
    }

    fn cell(&mut self, mesh: &LocalMesh, source: usize, cell: usize) {
        let index = self.rule(mesh.shape(cell));
        self.patch(mesh, source, index, cell, mesh.cell_nodes(cell));
    }

    /// Index into `rules` of a shape. On the cubes it is the Gauss rule of one point more per
    /// direction than the order.
    fn rule(&mut self, shape: Shape) -> usize {
        self.rules.iter().position(|(of, _)| *of == shape).unwrap_or_else(|| {
            let rule = quadrature(shape, 2 * shape.order() + 1);
            self.rules.push((shape, RulePoint::all(shape, rule)));
            self.rules.len() - 1
        })
    }

    /// A cell, or a facet of it, under a load; `shape` is the index into `rules`.
    fn patch(&mut self, mesh: &LocalMesh, source: usize, shape: usize, cell: usize, nodes: &[u32]) {
        let points: Vec<[f64; 3]> =
            nodes.iter().map(|node| mesh.nodes.points[*node as usize]).collect();
        let nodes = nodes.iter().map(|node| mesh.nodes.names[*node as usize]).collect();
        let is_box = matches!(mesh.prototype(cell).geometry, Geometry::Box(_));
        let (of, rule) = &self.rules[shape];
        let points = load_points(*of, rule, &points, mesh.facts.axes, is_box);
        self.patches.push(Patch { source, shape, nodes, points });
    }
}
