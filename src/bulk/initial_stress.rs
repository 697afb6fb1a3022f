//! Stresses that are there at the start: their values, and the forces of the cells that they make.

use super::RulePoint;
use crate::case::{AtRest, Case, StressSpec};
use crate::element::{QuadraturePoint, Shape, quadrature};
use crate::error::{Error, Result};
use crate::mesh::{LocalMesh, MeshFacts};

/// The stresses at the start of one rank's cells.
#[derive(Debug, Clone, PartialEq)]
pub struct InitialStress {
    /// At the centre of each cell (Pa): xx, yy, zz, xy, yz, xz.
    pub at_centres: Vec<[f64; 6]>,
    /// The forces of this rank's cells at the nodes of the mesh, by displacement component (N).
    pub forces: Vec<[f64; 3]>,
    /// The sum of the lengths of the cells' forces at each node (N).
    pub magnitudes: Vec<f64>,
    /// About how far the mesh would move without them: strain times size (m).
    pub displacement: f64,
    /// What is taken for granted, in words.
    pub assumed: Option<String>,
}

impl InitialStress {
    /// Of a case; none where it has none. Local.
    ///
    /// # Errors
    /// `Input` when a formula gives no finite number.
    pub fn new(case: &Case, mesh: &LocalMesh) -> Result<Option<Self>> {
        let Some(spec) = &case.initial_stress else { return Ok(None) };
        let field = Field { case, spec, facts: &mesh.facts };
        let (nodes, cells) = (mesh.nodes.points.len(), mesh.cells.len());
        let mut of_mesh = Self {
            at_centres: Vec::with_capacity(cells),
            forces: vec![[0.0; 3]; nodes],
            magnitudes: vec![0.0; nodes],
            displacement: 0.0,
            assumed: field.assumed(),
        };
        let mut rules: Vec<(Shape, Vec<RulePoint>, RulePoint)> = Vec::new();
        for cell in 0..cells {
            let shape = mesh.shape(cell);
            let known = rules.iter().position(|(of, _, _)| *of == shape);
            let index = known.unwrap_or_else(|| {
                let rule = quadrature(shape, 2 * shape.order() + 1);
                let centre = QuadraturePoint { xi: shape.centroid(), weight: 1.0 };
                rules.push((shape, RulePoint::all(shape, rule), RulePoint::new(shape, centre)));
                rules.len() - 1
            });
            let (_, rule, centre) = &rules[index];
            of_mesh.add_cell(mesh, cell, rule, &field)?;
            let nodes = mesh.cell_nodes(cell).iter();
            let points: Vec<[f64; 3]> = nodes.map(|n| mesh.nodes.points[*n as usize]).collect();
            let material = mesh.prototype(cell).material;
            of_mesh.at_centres.push(field.at(material, centre.position(&points))?);
        }
        Ok(Some(of_mesh))
    }

    /// Adds the forces of a cell: the integral of the stress times the gradients of the basis.
    fn add_cell(
        &mut self,
        mesh: &LocalMesh,
        cell: usize,
        rule: &[RulePoint],
        field: &Field<'_>,
    ) -> Result<()> {
        let (axes, nodes) = (mesh.facts.axes, mesh.cell_nodes(cell));
        let material = mesh.prototype(cell).material;
        let points: Vec<[f64; 3]> = nodes.iter().map(|n| mesh.nodes.points[*n as usize]).collect();
        let by_component = |x: &[f64; 3]| {
            let mut along = [0.0; 3];
            axes.iter().enumerate().for_each(|(c, axis)| along[c] = x[*axis]);
            along
        };
        let along: Vec<[f64; 3]> = points.iter().map(by_component).collect();
        let mut forces = vec![[0.0; 3]; nodes.len()];
        let size = mesh.facts.size.iter().fold(0.0_f64, |size, x| size.max(*x));
        let flexibility = size / field.case.materials[material].young_modulus;
        for point in rule {
            let stress = field.at(material, point.position(&points))?;
            let most = stress.iter().fold(0.0_f64, |most, s| most.max(s.abs()));
            self.displacement = self.displacement.max(most * flexibility);
            let physical = match axes.len() {
                2 => point.physical::<2>(&along),
                _ => point.physical::<3>(&along),
            };
            let volume = point.weight * physical.determinant;
            for (force, gradient) in forces.iter_mut().zip(&physical.gradients) {
                for (f, i) in force.iter_mut().zip(axes) {
                    let along_axis = axes.iter().zip(gradient);
                    *f += volume
                        * along_axis.map(|(j, g)| stress[component(*i, *j)] * g).sum::<f64>();
                }
            }
        }
        for (node, force) in nodes.iter().map(|n| *n as usize).zip(forces) {
            self.forces[node].iter_mut().zip(force).for_each(|(sum, f)| *sum += f);
            self.magnitudes[node] += force.iter().map(|f| f * f).sum::<f64>().sqrt();
        }
        Ok(())
    }
}

/// The place of a component among xx, yy, zz, xy, yz, xz.
fn component(i: usize, j: usize) -> usize {
    if i == j { i } else { [3, 5, 4][i + j - 1] }
}

/// The stress as the case gives it.
struct Field<'c> {
    case: &'c Case,
    spec: &'c StressSpec,
    facts: &'c MeshFacts,
}

impl Field<'_> {
    /// In a material at a point (m): xx, yy, zz, xy, yz, xz (Pa).
    fn at(&self, material: usize, point: [f64; 3]) -> Result<[f64; 6]> {
        let (given, start) = (&self.spec.components, self.spec.start);
        let mut stress = given.each_ref().map(|value| match value {
            Some(value) => value.at(point, start),
            None => 0.0,
        });
        if let Some(at_rest @ AtRest { ratio, vertical, .. }) = &self.spec.at_rest {
            if given[*vertical].is_none() {
                stress[*vertical] = self.under_weight(material, at_rest, point);
            }
            for axis in (0..3).filter(|axis| axis != vertical && given[*axis].is_none()) {
                stress[axis] = ratio.at(point, start) * stress[*vertical];
            }
        }
        match stress.iter().find(|value| !value.is_finite()) {
            None => Ok(stress),
            Some(value) => {
                let [x, y, z] = point;
                Err(Error::Input(format!(
                    "initial.stress is {value} at ({x}, {y}, {z}) m; formulas must give finite \
                     numbers in all cells"
                )))
            }
        }
    }

    /// Up to where the mesh of a file is taken to bear weight, in words.
    fn assumed(&self) -> Option<String> {
        let AtRest { vertical, .. } = self.spec.at_rest.as_ref()?;
        if self.case.mesh.column().is_some() || self.spec.components[*vertical].is_some() {
            return None;
        }
        let [low, high] = self.ends(*vertical);
        let top = if self.case.gravity[*vertical] < 0.0 { high } else { low };
        Some(format!(
            "initial.stress.k0: the weight above a point is that of ground up to the highest point \
             of the mesh, {} = {top} m",
            ["x", "y", "z"][*vertical]
        ))
    }

    /// The ends of the mesh along an axis (m).
    fn ends(&self, axis: usize) -> [f64; 2] {
        [self.facts.origin[axis], self.facts.origin[axis] + self.facts.size[axis]]
    }

    /// The vertical effective stress under the weight of all that lies above (Pa). The top is the
    /// highest point of the mesh.
    fn under_weight(&self, material: usize, at_rest: &AtRest, point: [f64; 3]) -> f64 {
        let AtRest { vertical, densities, .. } = at_rest;
        let (case, vertical) = (self.case, *vertical);
        let [low, high] = self.ends(vertical);
        let (gravity, here) = (case.gravity[vertical], point[vertical]);
        let above = if gravity < 0.0 { [here, high] } else { [low, here] };
        let is_layered = vertical == 2 && case.mesh.column().is_some();
        let mass: f64 = if is_layered {
            let of = |layer: usize| {
                let [from, to] = case.materials[layer].z.unwrap_or([low, high]);
                densities[layer] * (above[1].min(to) - above[0].max(from)).max(0.0)
            };
            (0..case.materials.len()).map(of).sum()
        } else {
            densities[material] * (above[1] - above[0])
        };
        let of_fluid = case.materials[material].porous.as_ref().and_then(|porous| {
            let pressure = case.pressure_at_start(point)?;
            Some(porous.biot * (pressure - porous.reference_pressure))
        });
        of_fluid.unwrap_or(0.0) - gravity.abs() * mass
    }
}

#[cfg(test)]
mod tests {
    use super::component;

    #[test]
    fn components_stand_in_the_order_of_field_files() {
        let pairs = [[0, 0], [1, 1], [2, 2], [0, 1], [1, 2], [2, 0]];
        for (place, [i, j]) in pairs.into_iter().enumerate() {
            assert_eq!((component(i, j), component(j, i)), (place, place));
        }
    }
}
