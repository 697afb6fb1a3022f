//! Prescribed pore pressures: of which nodes, and their values in time.

use super::AtNode;
use crate::case::{Case, SurfaceBit, Value};
use crate::error::{Error, Result};
use crate::mesh::{Lip, Marks};

/// Where an entry prescribes the pressure.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Place {
    /// The nodes of a surface, or all.
    Surface(SurfaceBit),
    /// Both lips of an interface of a column, by its index.
    Lips(usize),
}

/// The prescribed pore pressures of a case: those in interfaces that are connected with the pores,
/// then those of the boundary.
#[derive(Debug, Clone)]
pub struct PrescribedPressure {
    entries: Vec<(String, Place, Value)>,
    /// Interfaces from which fluid flows into the pores.
    feeding: Vec<usize>,
}

impl PrescribedPressure {
    /// From the case.
    pub fn new(case: &Case) -> Self {
        let mut entries = Vec::new();
        for (index, interface) in case.interfaces.iter().enumerate().filter(|(_, i)| i.connected) {
            if let Some(pressure) = &interface.fluid_pressure {
                let name = format!("interfaces.{}: fluid.pressure", interface.name);
                let place = match case.lips_bit(index) {
                    Some(bit) => Place::Surface(bit),
                    None => Place::Lips(index),
                };
                entries.push((name, place, pressure.clone()));
            }
        }
        for (number, entry) in case.boundary.iter().enumerate() {
            if let Some(pressure) = &entry.pressure {
                let name = format!("boundary.{number} ({}): pressure", entry.on.name());
                let place = Place::Surface(case.surface_bit(&entry.on));
                entries.push((name, place, pressure.clone()));
            }
        }
        let feeding = (0..case.interfaces.len()).filter(|i| case.has_flux(&case.interfaces[*i]));
        Self { entries, feeding: feeding.collect() }
    }

    /// The entry that prescribes the pressure of a node: the first of those that do.
    pub fn entry_of(&self, node: &Marks) -> Option<usize> {
        self.entries_of(node).next()
    }

    fn entries_of(&self, node: &Marks) -> impl Iterator<Item = usize> {
        let is_on = move |place: &Place| match *place {
            Place::Surface(surface) => node.is_on(surface),
            Place::Lips(index) => node.lip().is_some_and(|(interface, _)| interface == index),
        };
        let entries = self.entries.iter().enumerate();
        entries.filter(move |(_, entry)| is_on(&entry.1)).map(|(index, _)| index)
    }

    /// The interface on whose lip a node lies, and which lip that is; only of interfaces from which
    /// fluid flows into the pores.
    pub fn lip_of(&self, node: &Marks) -> Option<(usize, Lip)> {
        node.lip().filter(|(interface, _)| self.feeding.contains(interface))
    }

    /// The pressure that an entry prescribes at a point (Pa).
    ///
    /// # Errors
    /// `Input` when a formula gives no finite number there.
    pub fn value(&self, entry: usize, [x, y, z]: [f64; 3], time: f64) -> Result<f64> {
        let (name, _, value) = &self.entries[entry];
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
    /// agree, at every instant to 1e-12 of the largest of the two. Local.
    ///
    /// # Errors
    /// At the first node where they do not, naming the entries, the place and the values.
    pub fn check<'n>(
        &self,
        nodes: impl Iterator<Item = (u64, [f64; 3], &'n Marks)>,
        instants: &[f64],
    ) -> std::result::Result<(), AtNode> {
        for (node, point, marks) in nodes {
            let mut entries = self.entries_of(marks);
            let Some(first) = entries.next() else { continue };
            for time in instants {
                let value = |entry| {
                    let value = self.value(entry, point, *time);
                    value.map_err(|error| AtNode(node, error))
                };
                let one = value(first)?;
                for other in self.entries_of(marks).skip(1) {
                    let two = value(other)?;
                    if (one - two).abs() > 1e-12 * one.abs().max(two.abs()) {
                        let [x, y, z] = point;
                        let (a, b) = (&self.entries[first].0, &self.entries[other].0);
                        return Err(AtNode(
                            node,
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
