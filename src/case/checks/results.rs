//! Output, probes and expectations, and the columns of `history.csv` that they refer to.

use std::collections::BTreeSet;
use std::path::PathBuf;

use super::checker::Checker;
use crate::case::sections::file::{CaseFile, FieldsSection, FieldsWord};
use crate::case::sections::{Expectation, Fields, OutputSpec, Probe};
use crate::case::{Case, ColumnSpec, Every, InterfaceSpec, MeshSpec, Surface, SurfaceBit};
use crate::input::problems::suggestion;

const AXES: [&str; 3] = ["x", "y", "z"];

/// What stands in front of the reactions of all surfaces together.
pub(super) const TOTAL: &str = "total";

/// What of an interface has a smallest, a largest and a mean value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum InterfaceQuantity {
    /// A component of the traction; the normal one comes last of the components.
    Traction(usize),
    /// A component of the jump.
    Jump(usize),
    /// The damage.
    Damage,
    /// How far it has slid in contact.
    Slip,
    /// The pressure of a film.
    Pressure,
}

impl Case {
    /// The names of the axes of the components.
    pub fn axis_names(&self) -> impl Iterator<Item = &'static str> {
        self.axes.iter().map(|axis| AXES[*axis])
    }

    /// What of an interface has a smallest, a largest and a mean value, in the order of the
    /// columns: of traction and jump the normal component first, then those along x and y.
    pub fn interface_quantities(&self, interface: &InterfaceSpec) -> Vec<InterfaceQuantity> {
        use InterfaceQuantity::{Damage, Jump, Pressure, Slip, Traction};
        let components = || std::iter::once(self.dim - 1).chain(0..self.dim - 1);
        let of_joint = components().map(Traction).chain(components().map(Jump)).chain([Damage]);
        let of_joint = of_joint.chain(interface.has_friction().then_some(Slip));
        of_joint.chain(interface.film.is_some().then_some(Pressure)).collect()
    }

    /// The name of a quantity of an interface. Tangents are axes in a column and numbered in the
    /// frames of a mesh file.
    fn name_of(&self, quantity: InterfaceQuantity) -> String {
        let (normal, is_of_file) = (self.dim - 1, self.mesh.file().is_some());
        let tangent = |c: usize| if is_of_file { ["1", "2", "3"][c] } else { AXES[c] };
        match quantity {
            InterfaceQuantity::Traction(c) if c == normal => "normal_traction".to_owned(),
            InterfaceQuantity::Traction(c) => format!("shear_traction_{}", tangent(c)),
            InterfaceQuantity::Jump(c) if c == normal => "normal_jump".to_owned(),
            InterfaceQuantity::Jump(c) => format!("sliding_{}", tangent(c)),
            InterfaceQuantity::Damage => "damage".to_owned(),
            InterfaceQuantity::Slip => "slip".to_owned(),
            InterfaceQuantity::Pressure => "pressure".to_owned(),
        }
    }

    /// What an interface has one value of, in the order of the columns: the force of the upper side
    /// on the lower one along each axis (N; in 2D per metre), and the area (m2; in 2D m).
    pub fn interface_totals(&self) -> impl Iterator<Item = String> {
        let forces = self.axis_names().map(|axis| format!("force_{axis}"));
        forces.chain(["area".to_owned()])
    }

    /// The surfaces that prescribe a displacement, in the order of their first entry.
    pub fn supported_surfaces(&self) -> Vec<&Surface> {
        let mut surfaces: Vec<&Surface> = self.supported[0].iter().collect();
        for entry in &self.boundary {
            if entry.prescribes_displacement() && !surfaces.contains(&&entry.on) {
                surfaces.push(&entry.on);
            }
        }
        surfaces
    }

    /// The same, to be asked of nodes.
    pub fn supported_bits(&self) -> Vec<SurfaceBit> {
        self.supported_surfaces().into_iter().map(|surface| self.surface_bit(surface)).collect()
    }

    /// Whether fluid flows from an interface into the rock.
    pub fn has_flux(&self, interface: &InterfaceSpec) -> bool {
        self.flow.is_some() && (interface.connected || interface.film.is_some())
    }

    /// All columns of `history.csv`, in their order.
    pub fn columns(&self) -> Vec<String> {
        let mut columns: Vec<String> =
            ["time", "load_factor", "newton_iterations", "linear_iterations"]
                .map(str::to_owned)
                .to_vec();
        for interface in &self.interfaces {
            for quantity in self.interface_quantities(interface) {
                let name = self.name_of(quantity);
                for statistic in ["min", "max", "mean"] {
                    columns.push(format!("{}.{name}.{statistic}", interface.name));
                }
            }
            let totals = self.interface_totals();
            columns.extend(totals.map(|of| format!("{}.{of}", interface.name)));
            if self.has_flux(interface) {
                columns.extend(
                    ["flux_lower", "flux_upper"].map(|of| format!("{}.{of}", interface.name)),
                );
            }
        }
        let supported = self.supported_surfaces();
        let surfaces = supported.into_iter().map(Surface::name);
        for of in surfaces.chain([TOTAL]) {
            for axis in self.axis_names() {
                columns.push(format!("{of}.reaction_{axis}"));
            }
        }
        columns.extend(self.columns_of_platens());
        for probe in &self.probes {
            for axis in self.axis_names() {
                columns.push(format!("{}.displacement_{axis}", probe.name));
            }
            if self.has_pressure() {
                columns.push(format!("{}.pressure", probe.name));
            }
        }
        for energy in ["elastic", "dissipated", "external"] {
            columns.push(format!("energy.{energy}"));
        }
        if self.has_pressure() {
            columns.push("energy.fluid".to_owned());
        }
        if self.has_friction() {
            columns.push("energy.friction".to_owned());
        }
        if self.flow.is_some() {
            columns.extend(["mass.in", "mass.out", "mass.stored"].map(str::to_owned));
        }
        columns
    }

    /// What an expectation may name: every column, and the interface quantities without their
    /// statistic, which stand for `.min` and `.max` together.
    pub fn quantities(&self) -> Vec<String> {
        let mut quantities: Vec<String> = Vec::new();
        for column in self.columns() {
            if let Some(base) = column.strip_suffix(".min") {
                quantities.push(base.to_owned());
            }
            quantities.push(column);
        }
        quantities
    }
}

impl Checker<'_> {
    pub(super) fn output(
        &mut self,
        file: &CaseFile,
        time: &[f64],
        checkpoint: Every,
    ) -> OutputSpec {
        let directory = PathBuf::from(file.output.directory.clone().unwrap_or_default());
        if directory.as_os_str().is_empty() {
            self.add("output.directory", "is empty");
        }
        let fields = match &file.output.fields {
            FieldsSection::Word(FieldsWord::All) => Fields::All,
            FieldsSection::Word(FieldsWord::None) => Fields::None,
            FieldsSection::Times(times) => {
                for (index, instant) in times.iter().enumerate() {
                    self.instant(&format!("output.fields.{index}"), *instant, time);
                }
                let mut times = times.clone();
                times.sort_by(f64::total_cmp);
                times.dedup();
                Fields::Times(times)
            }
        };
        OutputSpec { directory, fields, checkpoint }
    }

    pub(super) fn instant(&mut self, path: &str, instant: f64, time: &[f64]) {
        if self.sound(&["time"]) && !time.contains(&instant) {
            let nearest = time
                .iter()
                .min_by(|a, b| (*a - instant).abs().total_cmp(&(*b - instant).abs()))
                .map_or(String::new(), |time| format!("; the nearest is {time}"));
            self.add(path, format!("must be one of time.instants{nearest}, got {instant}"));
        }
    }

    pub(super) fn probes(
        &mut self,
        file: &CaseFile,
        mesh: &MeshSpec,
        interfaces: &[InterfaceSpec],
    ) -> Vec<Probe> {
        let mut probes: Vec<Probe> = Vec::new();
        for (index, section) in file.probes.iter().enumerate() {
            let path = format!("probes.{index}");
            self.name(&format!("{path}.name"), &section.name);
            let taken = probes.iter().any(|probe| probe.name == section.name)
                || interfaces.iter().any(|interface| interface.name == section.name);
            if taken {
                self.add(&format!("{path}.name"), format!("`{}` is taken", section.name));
            }
            if self.sound(&["mesh"]) {
                self.probe_inside(&format!("{path}.at"), &section.at, mesh);
            }
            probes.push(Probe { name: section.name.clone(), at: self.by_axis(&section.at) });
        }
        probes
    }

    /// A point of the dimension of the mesh, and inside the column.
    fn probe_inside(&mut self, path: &str, at: &[f64], mesh: &MeshSpec) {
        if at.len() != self.dim && self.knows_dimension {
            self.add(path, format!("must have {} entries, got {}", self.dim, at.len()));
            return;
        }
        let Some(ColumnSpec { size, .. }) = mesh.column() else { return };
        if at.iter().zip(size).any(|(x, length)| !(0.0..=*length).contains(x)) {
            self.add(path, format!("must lie inside the column of size {size:?}, got {at:?}"));
        }
    }

    pub(super) fn expectations(&mut self, case: &Case) -> Vec<Expectation> {
        let known = case.quantities();
        let all: BTreeSet<&String> = known.iter().collect();
        let mut expectations = Vec::new();
        for (index, section) in case.file.expect.iter().enumerate() {
            if self.problems.is_full() {
                break;
            }
            let path = format!("expect.{index}");
            let quantity = &section.quantity;
            if self.sound(&["mesh", "interfaces", "boundary", "probes"]) && !all.contains(quantity)
            {
                let hint = suggestion(quantity, &known);
                self.add(&format!("{path}.quantity"), format!("cannot be `{quantity}`{hint}"));
            }
            // With stresses at the start there is a row of it.
            let is_start = case.initial_stress.is_some() && section.at == case.start;
            if !is_start {
                self.instant(&format!("{path}.at"), section.at, &case.time);
            }
            if section.relative.is_none() && section.absolute.is_none() {
                self.add(&path, "needs a tolerance: relative, absolute or both");
            }
            expectations.push(Expectation {
                quantity: quantity.clone(),
                at: section.at,
                equals: section.equals,
                relative: section.relative.unwrap_or(0.0),
                absolute: section.absolute.unwrap_or(0.0),
            });
        }
        expectations
    }
}
