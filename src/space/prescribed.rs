//! Prescribed displacements: which components of a node, and their values in time.

use crate::case::{BoundarySpec, Case, SurfaceBit, Value};
use crate::comm::Comm;
use crate::error::{Error, Result};
use crate::mesh::{Marks, Places};

/// The prescribed displacements of a case.
#[derive(Debug, Clone)]
pub struct Prescribed {
    /// The axes of the components.
    axes: &'static [usize],
    entries: Vec<Entry>,
}

/// An entry of the case that prescribes a displacement.
#[derive(Debug, Clone)]
struct Entry {
    /// Its number in the case.
    number: usize,
    on: SurfaceBit,
    spec: BoundarySpec,
}

/// A displacement that an entry prescribes along a direction at a node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Given {
    /// The entry, by its index among those that prescribe displacements.
    pub entry: usize,
    /// The coordinate axis; none along the normal of the surface.
    pub axis: Option<usize>,
    /// The unit vector, by components of the displacement.
    pub direction: [f64; 3],
}

impl Prescribed {
    /// From the boundary entries that prescribe a displacement.
    pub fn new(case: &Case) -> Self {
        let entries = case.boundary.iter().enumerate();
        let entries = entries.filter(|(_, spec)| spec.prescribes_displacement());
        let entry = |(number, spec): (usize, &BoundarySpec)| Entry {
            number,
            on: case.surface_bit(&spec.on),
            spec: spec.clone(),
        };
        Self { axes: case.axes, entries: entries.map(entry).collect() }
    }

    /// The entry that prescribes each component of a node: the first of those that do, by its
    /// index among the entries that prescribe displacements.
    pub fn entries_of(&self, node: &Marks) -> [Option<usize>; 3] {
        let mut of = [None; 3];
        for (component, axis) in self.axes.iter().enumerate() {
            of[component] = self
                .entries
                .iter()
                .position(|e| e.spec.displacement[*axis].is_some() && node.is_on(e.on));
        }
        of
    }

    /// Whether anything is prescribed at a node, along an axis or the normal of a surface.
    pub fn acts_on(&self, node: &Marks) -> bool {
        self.entries.iter().any(|entry| node.is_on(entry.on))
    }

    /// Which components of a node are prescribed.
    pub fn components_of(&self, node: &Marks) -> [bool; 3] {
        self.entries_of(node).map(|e| e.is_some())
    }

    /// Everything that is prescribed at a node, in the order of the entries; `normals` gives those
    /// of a surface there, by its place in the list of the case.
    pub fn given_at(&self, node: &Marks, normals: impl Fn(usize) -> Vec<[f64; 3]>) -> Vec<Given> {
        let mut given = Vec::new();
        let entries = self.entries.iter().enumerate();
        for (entry, of) in entries.filter(|(_, of)| node.is_on(of.on)) {
            for (component, axis) in self.axes.iter().enumerate() {
                if of.spec.displacement[*axis].is_some() {
                    let along = |c: usize| f64::from(u8::from(c == component));
                    let direction = std::array::from_fn(along);
                    given.push(Given { entry, axis: Some(*axis), direction });
                }
            }
            if let (Some(_), SurfaceBit::Place(place)) = (&of.spec.normal_displacement, of.on) {
                let along = |direction| Given { entry, axis: None, direction };
                given.extend(normals(place).into_iter().map(along));
            }
        }
        given
    }

    /// Whether a node lies on the surface of an entry.
    pub fn is_on(&self, entry: usize, node: &Marks) -> bool {
        node.is_on(self.entries[entry].on)
    }

    /// The value of what is given at a point (m).
    ///
    /// # Errors
    /// `Input` when a formula gives no finite number there.
    pub fn value_of(&self, given: &Given, point: [f64; 3], time: f64) -> Result<f64> {
        let Some(axis) = given.axis else {
            let spec = &self.entries[given.entry].spec;
            return self.finite(
                given.entry,
                spec.normal_displacement.as_ref(),
                "normal",
                point,
                time,
            );
        };
        self.value_along(given.entry, axis, point, time)
    }

    /// The number in the case of an entry that is a platen, if that is what gives the displacement
    /// along an axis.
    pub fn platen(&self, entry: usize, axis: usize) -> Option<usize> {
        let Entry { number, spec, .. } = &self.entries[entry];
        let rigid = spec.rigid.as_ref()?;
        rigid.along[axis].is_some().then_some(*number)
    }

    /// Whether what is given is the displacement of a platen that [`Prescribed::value`] does not
    /// tell.
    pub fn is_carried(&self, entry: usize, axis: Option<usize>) -> bool {
        axis.is_some_and(|axis| self.entries[entry].spec.is_carried(axis))
    }

    /// Name of the surface of an entry.
    pub fn surface(&self, entry: usize) -> &str {
        self.entries[entry].spec.on.name()
    }

    /// The value of a prescribed component at a point (m).
    ///
    /// # Errors
    /// `Input` when a formula gives no finite number there.
    pub fn value(&self, entry: usize, component: usize, point: [f64; 3], time: f64) -> Result<f64> {
        self.value_along(entry, self.axes[component], point, time)
    }

    fn value_along(&self, entry: usize, axis: usize, point: [f64; 3], time: f64) -> Result<f64> {
        let displacement = self.entries[entry].spec.displacement[axis].as_ref();
        self.finite(entry, displacement, ["x", "y", "z"][axis], point, time)
    }

    /// The value of a displacement of an entry, along what is called `name`.
    fn finite(
        &self,
        entry: usize,
        displacement: Option<&Value>,
        name: &str,
        point: [f64; 3],
        time: f64,
    ) -> Result<f64> {
        let value = displacement.map_or(0.0, |v| v.at(point, time));
        if value.is_finite() {
            return Ok(value);
        }
        let [x, y, z] = point;
        Err(Error::Input(format!(
            "{}: displacement.{name} is {value} at ({x}, {y}, {z}) m at time {time}; the formula \
             must give finite numbers on the whole surface at every instant",
            self.name(entry),
        )))
    }

    /// The largest magnitude that is prescribed at the nodes at any instant (m). Local.
    ///
    /// # Errors
    /// At the first node where a formula gives no finite number, naming entry, place and time.
    pub fn largest_value(
        &self,
        nodes: &Places,
        instants: &[f64],
    ) -> std::result::Result<f64, AtNode> {
        let mut largest = 0.0_f64;
        for (node, marks) in nodes.marks.iter().enumerate() {
            for (entry, axis) in self.all_of(marks) {
                for time in instants {
                    let value = self.value_along(entry, axis, nodes.points[node], *time);
                    let value = value.map_err(|error| AtNode(nodes.names[node], error))?;
                    largest = largest.max(value.abs());
                }
            }
        }
        Ok(largest)
    }

    /// Checks that entries which prescribe the same component of a node agree at every instant, to
    /// 1e-12 of the `largest` value of the case. Local.
    ///
    /// # Errors
    /// At the first node where they do not, naming both entries, the place and the two values.
    pub fn check_agreement(
        &self,
        nodes: &Places,
        instants: &[f64],
        largest: f64,
    ) -> std::result::Result<(), AtNode> {
        for (node, marks) in nodes.marks.iter().enumerate() {
            let (name, point) = (nodes.names[node], nodes.points[node]);
            let all = self.all_of(marks);
            for (position, (other, axis)) in all.iter().enumerate() {
                let Some((first, _)) = all[..position].iter().find(|(_, a)| a == axis) else {
                    continue;
                };
                if [*first, *other].iter().any(|entry| self.is_carried(*entry, Some(*axis))) {
                    let along = format!("displacement.{}", ["x", "y", "z"][*axis]);
                    return Err(AtNode(name, self.held_twice([*first, *other], &along, point)));
                }
                for time in instants {
                    let value = |entry| {
                        let value = self.value_along(entry, *axis, point, *time);
                        value.map_err(|error| AtNode(name, error))
                    };
                    let (one, two) = (value(*first)?, value(*other)?);
                    if (one - two).abs() > 1e-12 * largest {
                        let error = self.disagreement([*first, *other], *axis, point, *time);
                        return Err(AtNode(name, error([one, two])));
                    }
                }
            }
        }
        Ok(())
    }

    /// Every entry and axis that prescribe something at a node.
    fn all_of(&self, node: &Marks) -> Vec<(usize, usize)> {
        let entries = self.entries.iter().enumerate().filter(|(_, e)| node.is_on(e.on));
        entries
            .flat_map(|(index, e)| {
                let given = self.axes.iter().filter(|a| e.spec.displacement[**a].is_some());
                given.map(move |axis| (index, *axis))
            })
            .collect()
    }

    /// That a platen meets what prescribes a displacement of its nodes too.
    pub(super) fn held_twice(
        &self,
        [first, second]: [usize; 2],
        along: &str,
        [x, y, z]: [f64; 3],
    ) -> Error {
        Error::Input(format!(
            "{} and {} both give {along} at their common point ({x}, {y}, {z}) m, and a platen \
             moves all nodes of its surface; leave it out of one of them, or end one of the \
             surfaces before the other begins",
            self.name(first),
            self.name(second),
        ))
    }

    fn disagreement(
        &self,
        entries: [usize; 2],
        axis: usize,
        [x, y, z]: [f64; 3],
        time: f64,
    ) -> impl Fn([f64; 2]) -> Error {
        let [first, second] = entries.map(|e| self.name(e));
        let axis = ["x", "y", "z"][axis];
        move |[one, two]| {
            Error::Input(format!(
                "{first} and {second} prescribe different values of displacement.{axis} at their \
                 common point ({x}, {y}, {z}) m at time {time}: {one:e} and {two:e} m; make them \
                 agree there, or leave the component out of one of them"
            ))
        }
    }

    /// An entry as the case file and the user call it.
    pub(super) fn name(&self, entry: usize) -> String {
        let Entry { number, spec, .. } = &self.entries[entry];
        format!("boundary.{number} ({})", spec.on.name())
    }
}

/// A mistake at a node, by its name: of several ranks' the one at the lowest node is told, which is
/// the same on any number of ranks.
#[derive(Debug, Clone, PartialEq)]
pub struct AtNode(pub u64, pub Error);

impl AtNode {
    /// Makes a mistake on some ranks one on all. Collective.
    ///
    /// # Errors
    /// The mistake at the lowest node.
    pub fn agree<T>(comm: &Comm, local: std::result::Result<T, AtNode>) -> Result<T> {
        let mine = local.as_ref().err().map_or(u64::MAX, |AtNode(node, _)| *node);
        let lowest = u64::MAX - comm.max_u64(u64::MAX - mine);
        let told = match local {
            Ok(value) => Ok(Some(value)),
            Err(AtNode(node, error)) if node == lowest => Err(error),
            Err(_) => Ok(None),
        };
        let value = comm.agree(told)?;
        value.ok_or_else(|| Error::Bug("a mistake at a node that no rank holds".into()))
    }
}
