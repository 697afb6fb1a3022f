//! Prescribed pore pressures: of which nodes, and their values in time.

use super::AtNode;
use crate::case::{Case, Surface, Value};
use crate::error::{Error, Result};
use crate::mesh::{Column, Facets};

/// Where an entry prescribes the pressure.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Place {
    /// The nodes of a surface, or all.
    Surface(Surface),
    /// Both lips of an interface, by its index.
    Lips(usize),
}

/// The prescribed pore pressures of a case: those in interfaces that are connected with the pores,
/// then those of the boundary.
#[derive(Debug, Clone)]
pub struct PrescribedPressure {
    /// The column of the pressure nodes.
    column: Column,
    entries: Vec<(String, Place, Value)>,
    /// Interfaces from which fluid flows into the pores.
    feeding: Vec<usize>,
}

/// The face of a body that is a lip of an interface.
fn lip(interface: usize, upper: bool) -> Facets {
    if upper {
        Facets { body: interface + 1, upper: false }
    } else {
        Facets { body: interface, upper: true }
    }
}

impl PrescribedPressure {
    /// From the case; `column` is the one with cells of first order.
    pub fn new(case: &Case, column: &Column) -> Self {
        let mut entries = Vec::new();
        for (index, interface) in case.interfaces.iter().enumerate().filter(|(_, i)| i.connected) {
            if let Some(pressure) = &interface.fluid_pressure {
                let name = format!("interfaces.{}: fluid.pressure", interface.name);
                entries.push((name, Place::Lips(index), pressure.clone()));
            }
        }
        for (number, entry) in case.boundary.iter().enumerate() {
            if let Some(pressure) = &entry.pressure {
                let name = format!("boundary.{number} ({}): pressure", entry.on.name());
                entries.push((name, Place::Surface(entry.on), pressure.clone()));
            }
        }
        let feeding = (0..case.interfaces.len()).filter(|i| case.has_flux(&case.interfaces[*i]));
        Self { column: column.clone(), entries, feeding: feeding.collect() }
    }

    /// The entry that prescribes the pressure of a node: the first of those that do.
    pub fn entry_of(&self, node: u64) -> Option<usize> {
        self.entries_of(node).next()
    }

    fn entries_of(&self, node: u64) -> impl Iterator<Item = usize> {
        let surfaces = self.column.surfaces(node);
        let is_on = move |place: &Place| match *place {
            Place::Surface(surface) => surfaces.contains(surface),
            Place::Lips(index) => self.is_lip(index, node),
        };
        let entries = self.entries.iter().enumerate();
        entries.filter(move |(_, entry)| is_on(&entry.1)).map(|(index, _)| index)
    }

    /// Whether a node lies on a lip of an interface.
    fn is_lip(&self, index: usize, node: u64) -> bool {
        [false, true].iter().any(|upper| self.column.is_on(lip(index, *upper), node))
    }

    /// The interface on whose lip a node lies, and whether that is the upper lip; only of
    /// interfaces from which fluid flows into the pores.
    pub fn lip_of(&self, node: u64) -> Option<(usize, bool)> {
        let lips = self.feeding.iter().flat_map(|index| [(*index, false), (*index, true)]);
        lips.into_iter().find(|(index, upper)| self.column.is_on(lip(*index, *upper), node))
    }

    /// The pressure that an entry prescribes at a node (Pa).
    ///
    /// # Errors
    /// `Input` when a formula gives no finite number there.
    pub fn value(&self, entry: usize, node: u64, time: f64) -> Result<f64> {
        let (name, _, value) = &self.entries[entry];
        let [x, y, z] = self.column.point(node);
        let pressure = value.at([x, y, z], time);
        if pressure.is_finite() {
            return Ok(pressure);
        }
        Err(Error::Input(format!(
            "{name} is {pressure} at ({x}, {y}, {z}) m at time {time}; the formula must give finite \
             numbers wherever it acts at every instant"
        )))
    }

    /// Checks that values are finite and that entries which prescribe the pressure of the same node
    /// agree, at every instant to 1e-12 of the largest of the two. Local: `nodes` are names.
    ///
    /// # Errors
    /// At the first node where they do not, naming the entries, the place and the values.
    pub fn check(&self, nodes: &[u64], instants: &[f64]) -> std::result::Result<(), AtNode> {
        for node in nodes {
            let mut entries = self.entries_of(*node);
            let Some(first) = entries.next() else { continue };
            for time in instants {
                let value = |entry| {
                    let value = self.value(entry, *node, *time);
                    value.map_err(|error| AtNode(*node, error))
                };
                let one = value(first)?;
                for other in self.entries_of(*node).skip(1) {
                    let two = value(other)?;
                    if (one - two).abs() > 1e-12 * one.abs().max(two.abs()) {
                        let [x, y, z] = self.column.point(*node);
                        let (a, b) = (&self.entries[first].0, &self.entries[other].0);
                        return Err(AtNode(
                            *node,
                            Error::Input(format!(
                                "{a} and {b} prescribe {one} and {two} Pa at ({x}, {y}, {z}) m at \
                                 time {time}; where they meet they must agree"
                            )),
                        ));
                    }
                }
            }
        }
        Ok(())
    }
}
