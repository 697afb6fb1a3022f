//! Materials: what they consist of, and which part of the mesh consists of them.

use super::LATER;
use super::checker::Checker;
use crate::case::sections::file::{CaseFile, Groups, MaterialSection};
use crate::case::{Material, MeshSpec};
use crate::error::number_text;

impl Checker<'_> {
    pub(super) fn materials(&mut self, file: &CaseFile, mesh: &MeshSpec) -> Vec<Material> {
        for (name, section) in &file.materials {
            let path = format!("materials.{name}");
            self.name(&path, name);
            self.material(&path, name, section);
        }
        let is_only = file.materials.len() == 1;
        let mut materials: Vec<Material> = file
            .materials
            .iter()
            .map(|(name, section)| Material {
                name: name.clone(),
                z: section.z,
                groups: self.groups(name, section, is_only),
                young_modulus: section.elastic.young_modulus,
                poisson_ratio: section.elastic.poisson_ratio,
                density: section.porous.as_ref().map(|p| p.density).or(section.elastic.density),
                porous: section.porous.clone(),
            })
            .collect();
        let bottom = |material: &Material| material.z.map_or(f64::NEG_INFINITY, |z| z[0]);
        materials.sort_by(|a, b| bottom(a).total_cmp(&bottom(b)));
        if !self.sound(&["mesh", "materials"]) {
            return materials;
        }
        match mesh.column() {
            Some(column) => self.layers(&materials, column.height()),
            None => self.groups_once(&materials),
        }
        materials
    }

    fn material(&mut self, path: &str, name: &str, section: &MaterialSection) {
        match section.elastic.thermal_expansion {
            Some(expansion) if expansion != 0.0 => self.add(
                &format!("{path}.elastic.thermal_expansion"),
                format!("must be 0 (thermal strain {LATER}), got {}", number_text(expansion)),
            ),
            Some(_) => self
                .left_out
                .push(format!("Thermal strain is left out: the thermal expansion of {name} is 0.")),
            None => {}
        }
        if self.sound(&["mesh"]) {
            if self.is_of_file && section.z.is_some() {
                let reason = "is for columns; with a mesh file give on, its groups of cells";
                self.add(&format!("{path}.z"), reason);
            }
            if !self.is_of_file && section.on.is_some() {
                let reason = "is for meshes from files; in a column give z, its heights";
                self.add(&format!("{path}.on"), reason);
            }
        }
        let Some(porous) = &section.porous else { return };
        if section.elastic.density.is_some() {
            let reason = "is for dry materials; that of the saturated medium stands in porous";
            self.add(&format!("{path}.elastic.density"), reason);
        }
        if porous.biot < porous.porosity {
            let reason =
                format!("must be at least the porosity {}, got {}", porous.porosity, porous.biot);
            self.add(&format!("{path}.porous.biot"), reason);
        }
    }

    /// The groups of cells of a material: those given, or that of its name where there are several
    /// materials; none for a single one.
    fn groups(&self, name: &str, section: &MaterialSection, is_only: bool) -> Vec<String> {
        match &section.on {
            _ if !self.is_of_file => Vec::new(),
            Some(Groups::One(group)) => vec![group.clone()],
            Some(Groups::Many(groups)) => groups.clone(),
            None if is_only => Vec::new(),
            None => vec![name.to_owned()],
        }
    }

    /// Every group is named once.
    fn groups_once(&mut self, materials: &[Material]) {
        let mut seen: Vec<(&str, &str)> = Vec::new();
        for material in materials {
            let path = format!("materials.{}.on", material.name);
            for group in &material.groups {
                if group.is_empty() {
                    self.add(&path, "names a group without a name");
                } else if let Some((_, other)) = seen.iter().find(|(g, _)| g == group) {
                    let reason = if *other == material.name {
                        format!("names `{group}` twice")
                    } else {
                        format!("names `{group}`, which consists of {other} already")
                    };
                    self.add(&path, reason);
                }
                seen.push((group, &material.name));
            }
        }
    }
}
