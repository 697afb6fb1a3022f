//! Interfaces: their names, laws and places.

use super::BULK;
use super::checker::Checker;
use crate::case::sections::InterfaceInitial;
use crate::case::sections::file::{CaseFile, InterfaceSection};
use crate::case::{Gap, InterfaceSpec, LawSpec, Location, MeshSpec};
use crate::error::number_text;

/// What lies below the next interface of a column: the height of the interface before (m), and
/// that of the column where it is known.
#[derive(Clone, Copy)]
struct Heights {
    below: Option<f64>,
    top: Option<f64>,
}

impl Checker<'_> {
    pub(super) fn interfaces(&mut self, file: &CaseFile, mesh: &MeshSpec) -> Vec<InterfaceSpec> {
        let column = mesh.column().filter(|_| self.sound(&["mesh"]));
        let mut heights = Heights { below: None, top: column.map(|column| column.height()) };
        let mut names: Vec<&str> = Vec::new();
        let mut interfaces = Vec::new();
        for (index, section) in file.interfaces.iter().enumerate() {
            let path = format!("interfaces.{index}");
            self.name(&format!("{path}.name"), &section.name);
            self.file_name(&format!("{path}.name"), &section.name, &mut names);
            let location = if self.is_of_file {
                self.location_in_file(&path, section)
            } else {
                self.location_in_column(&path, section, &mut heights)
            };
            self.law(&format!("{path}.law"), &section.law);
            let may_gape = self.may_gape(&path, section);
            let mut interface = InterfaceSpec {
                name: section.name.clone(),
                location,
                has_gap: may_gape && section.gap != Some(Gap::Closed) && !gives_gap(section),
                law: section.law.clone(),
                secondary: section.secondary,
                fluid_pressure: None,
                connected: false,
                film: None,
                initial: InterfaceInitial::default(),
            };
            if let Some(fluid) = &section.fluid {
                self.fluid(&format!("{path}.fluid"), fluid, &mut interface);
            }
            if let Some(initial) = &section.initial {
                self.interface_initial(&format!("{path}.initial"), initial, &mut interface);
            }
            interfaces.push(interface);
        }
        if self.is_of_file && self.sound(&["interfaces"]) {
            self.groups_of_interfaces(&interfaces);
        }
        interfaces
    }

    /// A height above the interface before and inside the column.
    fn location_in_column(
        &mut self,
        path: &str,
        section: &InterfaceSection,
        heights: &mut Heights,
    ) -> Location {
        // Of a mesh that is neither, nothing can be said.
        if self.sound(&["mesh"]) {
            for key in given_of_file(section) {
                let reason = "is for meshes from files; in a column give z, its height";
                self.add(&format!("{path}.{key}"), reason);
            }
        }
        let Some(z) = section.z else {
            if self.sound(&["mesh"]) && given_of_file(section).is_empty() {
                self.add(&format!("{path}.z"), "is missing");
            }
            self.broken.insert("interfaces".to_owned());
            return Location::Height(heights.below.unwrap_or(0.0));
        };
        if let Some(height) = heights.top.filter(|height| !(z > 0.0 && z < *height)) {
            let [height, z] = [height, z].map(number_text);
            let reason = format!("must lie inside the column, in (0, {height}), got {z}");
            self.add(&format!("{path}.z"), reason);
        }
        if let Some(below) = heights.below.filter(|below| z <= *below) {
            let reason = format!("must be above the interface before it at {below}, got {z}");
            self.add(&format!("{path}.z"), reason);
        }
        if let Some(height) = heights.top {
            self.distance(&format!("{path}.z"), z, heights.below, height);
        }
        heights.below = Some(z);
        Location::Height(z)
    }

    /// A group, or two.
    fn location_in_file(&mut self, path: &str, section: &InterfaceSection) -> Location {
        if section.z.is_some() {
            let reason = "is for columns; with a mesh file give on: GROUP, or between: [LOWER, \
                          UPPER]";
            self.add(&format!("{path}.z"), reason);
        }
        match (&section.on, &section.between) {
            (Some(_), Some(_)) => {
                self.add(&format!("{path}.between"), "cannot stand beside on; give one of them");
            }
            (None, None) if section.z.is_none() => {
                self.add(path, "needs on: GROUP, or between: [LOWER, UPPER]");
            }
            (None, Some(_)) if section.flip => {
                let reason = "turns the normal of a group that is given by on; of between the \
                              first group is the lower side";
                self.add(&format!("{path}.flip"), reason);
            }
            _ => {}
        }
        match (&section.on, &section.between) {
            (Some(name), _) => Location::Group { name: name.clone(), flip: section.flip },
            (None, Some(groups)) => Location::Between(groups.clone()),
            (None, None) => {
                self.broken.insert("interfaces".to_owned());
                Location::Group { name: String::new(), flip: section.flip }
            }
        }
    }

    /// Whether an initial gap can count: what is bonded is joined as it is drawn.
    fn may_gape(&mut self, path: &str, section: &InterfaceSection) -> bool {
        let may_gape = section.between.is_some() && matches!(section.law, LawSpec::Contact(_));
        if section.gap.is_some() && !may_gape {
            let reason = "is for contact between two groups of a mesh file; other laws join sides \
                          that lie on each other";
            self.add(&format!("{path}.gap"), reason);
        }
        if section.gap == Some(Gap::AsDrawn) && gives_gap(section) {
            let reason = "cannot stand beside initial.gap, which takes its place";
            self.add(&format!("{path}.gap"), reason);
        }
        may_gape
    }

    /// A group of facets belongs to one side of one interface.
    fn groups_of_interfaces(&mut self, interfaces: &[InterfaceSpec]) {
        let mut seen: Vec<(&str, usize)> = Vec::new();
        for (index, interface) in interfaces.iter().enumerate() {
            let (key, groups) = match &interface.location {
                Location::Group { name, .. } => ("on", std::slice::from_ref(name)),
                Location::Between(groups) => ("between", &groups[..]),
                Location::Height(_) => continue,
            };
            for group in groups {
                let path = format!("interfaces.{index}.{key}");
                if group.is_empty() {
                    self.add(&path, "names a group without a name");
                } else if let Some((_, other)) = seen.iter().find(|(g, _)| g == group) {
                    let reason = if *other == index {
                        format!("names `{group}` twice; the sides need a group each")
                    } else {
                        format!("names `{group}`, on which {} is", interfaces[*other].name)
                    };
                    self.add(&path, reason);
                }
                seen.push((group, index));
            }
        }
    }

    fn law(&mut self, path: &str, law: &LawSpec) {
        for problem in law.law().check() {
            let (key, reason) = problem.split_once(' ').unwrap_or((problem.as_str(), ""));
            self.add(&format!("{path}.{}.{key}", law.name()), reason);
        }
    }

    /// The name of an interface, which its field files bear beside those of the `others`.
    fn file_name<'n>(&mut self, path: &str, name: &'n str, others: &mut Vec<&'n str>) {
        let same = |other: &&&str| other.eq_ignore_ascii_case(name);
        if BULK.eq_ignore_ascii_case(name) {
            self.add(path, format!("cannot be `{name}`: {BULK} is the name of the field files"));
        } else if let Some(other) = others.iter().find(same) {
            let reason = if *other == name {
                format!("`{name}` is taken")
            } else {
                format!(
                    "`{name}` is `{other}` but for capital letters, and their field files would be one \
                     where the file system does not tell them apart"
                )
            };
            self.add(path, reason);
        }
        others.push(name);
    }
}

/// Whether the gap at the start is given, whatever the mesh has.
fn gives_gap(section: &InterfaceSection) -> bool {
    section.initial.as_ref().is_some_and(|initial| initial.gap.is_some())
}

/// The keys of a section that say where in a mesh file it is.
fn given_of_file(section: &InterfaceSection) -> Vec<&'static str> {
    let keys = [
        ("on", section.on.is_some()),
        ("between", section.between.is_some()),
        ("flip", section.flip),
    ];
    keys.into_iter().filter(|(_, given)| *given).map(|(key, _)| key).collect()
}
