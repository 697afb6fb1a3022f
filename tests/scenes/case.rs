//! A case as the relations change it, and its text.

use std::fmt::Write;

/// x, y, z.
pub const AXES: [&str; 3] = ["x", "y", "z"];

/// A face of the column: its axis, and whether it is the upper one.
pub type Face = (usize, bool);

pub fn face_name((axis, upper): Face) -> &'static str {
    [["left", "right"], ["front", "back"], ["bottom", "top"]][axis][usize::from(upper)]
}

/// A value over time, linear between its points, times `1 + tilt . (x - centre)`.
#[derive(Clone, PartialEq)]
pub struct Field {
    /// Times and values; one point is a constant.
    pub path: Vec<[f64; 2]>,
    pub tilt: [f64; 3],
    pub centre: [f64; 3],
}

impl Field {
    pub fn constant(value: f64) -> Self {
        Self { path: vec![[0.0, value]], tilt: [0.0; 3], centre: [0.0; 3] }
    }

    /// Straight from 0 through `values` at 1, 2, ...
    pub fn ramps(values: &[f64]) -> Self {
        let later = values.iter().enumerate().map(|(i, v)| [(i + 1) as f64, *v]);
        let path = std::iter::once([0.0, 0.0]).chain(later).collect();
        Self { path, ..Self::constant(0.0) }
    }

    pub fn scaled(&self, factor: f64) -> Self {
        let path = self.path.iter().map(|[t, v]| [*t, v * factor]).collect();
        Self { path, ..self.clone() }
    }

    fn yaml(&self) -> String {
        if self.tilt == [0.0; 3] {
            if let Some(value) = self.number() {
                return format!("{value:e}");
            }
            let points = self.path.iter().map(|[t, v]| format!("[{t:e}, {v:e}]"));
            return format!("{{table: [{}]}}", points.collect::<Vec<_>>().join(", "));
        }
        let mut value = String::new();
        let mut slope = 0.0;
        for ends in self.path.windows(2) {
            let next = (ends[1][1] - ends[0][1]) / (ends[1][0] - ends[0][0]);
            let _ = write!(value, " + ({:e})*max(t - {:e}, 0)", next - slope, ends[0][0]);
            slope = next;
        }
        let mut place = String::from("1");
        for axis in (0..3).filter(|a| self.tilt[*a] != 0.0) {
            let (slope, centre) = (self.tilt[axis], self.centre[axis]);
            let _ = write!(place, " + ({slope:e})*({} - {centre:e})", AXES[axis]);
        }
        format!("{{formula: \"({:e}{value})*({place})\"}}", self.path[0][1])
    }

    /// Its value, where it has no other.
    pub fn number(&self) -> Option<f64> {
        match self.path[..] {
            [[_, value]] if self.tilt == [0.0; 3] => Some(value),
            _ => None,
        }
    }

    /// As a part of 1, cut off below 0 and above 1.
    fn part(&self) -> String {
        let yaml = self.yaml();
        match yaml.strip_prefix("{formula: \"").and_then(|rest| rest.strip_suffix("\"}")) {
            Some(formula) => format!("{{formula: \"min(max({formula}, 0), 1)\"}}"),
            None => yaml,
        }
    }
}

#[derive(Clone, PartialEq)]
pub struct Porous {
    pub biot: f64,
    pub permeability: f64,
    pub viscosity: f64,
    pub compressibility: f64,
    pub fluid_density: f64,
    pub density: f64,
}

#[derive(Clone, PartialEq)]
pub struct Material {
    pub z: [f64; 2],
    pub young: f64,
    pub poisson: f64,
    pub porous: Option<Porous>,
}

#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Law {
    Linear {
        strength: f64,
        energy: f64,
    },
    Exponential {
        strength: f64,
        energy: f64,
    },
    Bilinear {
        strength: f64,
        energy: f64,
        stiffness: f64,
    },
    /// Strengths, energies, exponent.
    Modes {
        strength: [f64; 2],
        energy: [f64; 2],
        exponent: f64,
    },
    Tied,
    Contact,
}

impl Law {
    fn yaml(&self) -> String {
        match self {
            Law::Linear { strength, energy } => {
                format!(
                    "{{linear_softening: {{strength: {strength:e}, fracture_energy: {energy:e}}}}}"
                )
            }
            Law::Exponential { strength, energy } => format!(
                "{{exponential_softening: {{strength: {strength:e}, fracture_energy: {energy:e}}}}}"
            ),
            Law::Bilinear { strength, energy, stiffness } => format!(
                "{{bilinear: {{strength: {strength:e}, fracture_energy: {energy:e}, \
                 stiffness: {stiffness:e}}}}}"
            ),
            Law::Modes { strength: [s, shear], energy: [g, of_shear], exponent } => format!(
                "{{benzeggagh_kenane: {{strength: {s:e}, shear_strength: {shear:e}, \
                 fracture_energy: {g:e}, shear_fracture_energy: {of_shear:e}, exponent: {exponent:e}}}}}"
            ),
            Law::Tied => "{tied: {}}".into(),
            Law::Contact => "{contact: {}}".into(),
        }
    }

    /// The least stress at which it gives way.
    pub fn strength(&self) -> f64 {
        match self {
            Law::Linear { strength, .. }
            | Law::Exponential { strength, .. }
            | Law::Bilinear { strength, .. } => *strength,
            Law::Modes { strength: [s, shear], .. } => s.min(*shear),
            Law::Tied => f64::INFINITY,
            Law::Contact => 0.0,
        }
    }
}

#[derive(Clone, PartialEq)]
pub struct Joint {
    pub name: String,
    pub z: f64,
    pub law: Law,
    /// Whether the upper side carries the multipliers.
    pub secondary: Option<bool>,
    pub fluid: Option<Fluid>,
    /// Factor of strength and energy.
    pub imperfection: Option<Field>,
    /// At the start, cut off below 0 and above 1.
    pub damage: Option<Field>,
    /// At the start.
    pub gap: Option<Field>,
}

impl Joint {
    /// Of its state at the start.
    fn initial(&self) -> String {
        let damage = self.damage.iter().map(|of| format!("damage: {}", of.part()));
        let gap = self.gap.iter().map(|of| format!("gap: {}", of.yaml()));
        let all = damage.chain(gap).collect::<Vec<_>>().join(", ");
        if all.is_empty() { all } else { format!(", initial: {{{all}}}") }
    }
}

/// What a path is followed by, at an interface.
#[derive(Clone, PartialEq)]
pub enum Control {
    Opening(String, Field),
    Dissipation(String),
}

impl Control {
    fn yaml(&self) -> String {
        match self {
            Self::Opening(of, jump) => {
                format!("{{opening: {{of: {of}, equals: {}}}}}", jump.yaml())
            }
            Self::Dissipation(of) => format!("{{dissipation: {{of: {of}, step: 0.125}}}}"),
        }
    }
}

/// What fills an interface.
#[derive(Clone, PartialEq)]
pub enum Fluid {
    /// Of a known pressure, which the pores at the lips may have too.
    Known { pressure: Field, connected: bool },
    /// Of a pressure of its own; with what is injected per area and time.
    Flows { injection: f64 },
}

impl Fluid {
    fn yaml(&self) -> String {
        match self {
            Self::Known { pressure, connected: false } => {
                format!("{{pressure: {}}}", pressure.yaml())
            }
            Self::Known { pressure, connected: true } => {
                format!("{{pressure: {}, connected: true}}", pressure.yaml())
            }
            Self::Flows { injection: 0.0 } => "{flow: true}".into(),
            Self::Flows { injection } => format!("{{injection: {injection:e}}}"),
        }
    }
}

#[derive(Clone, PartialEq, Default)]
pub struct Entry {
    pub on: Option<Face>,
    pub displacement: [Option<Field>; 3],
    pub traction: [Option<Field>; 3],
    pub pressure: Option<f64>,
}

/// A column with everything that is said about it. In 2D the second axis stays empty.
#[derive(Clone, PartialEq)]
pub struct Case {
    pub flat: bool,
    pub size: [f64; 3],
    /// Of each body, bottom to top.
    pub cells: Vec<[usize; 3]>,
    /// Cells are told body by body.
    pub by_body: bool,
    pub order: usize,
    pub refine: usize,
    pub materials: Vec<Material>,
    pub joints: Vec<Joint>,
    pub boundary: Vec<Entry>,
    pub body_force: [f64; 3],
    pub initial_pressure: f64,
    pub instants: Vec<f64>,
    pub probe: [f64; 3],
    pub control: Option<Control>,
    /// Other keys at the top of the file.
    pub more: Vec<String>,
    pub tolerance: f64,
}

impl Case {
    pub fn axes(&self) -> Vec<usize> {
        if self.flat { vec![0, 2] } else { vec![0, 1, 2] }
    }

    fn list<T: Copy, S: std::fmt::Display>(&self, of: [T; 3], show: impl Fn(T) -> S) -> String {
        let shown = self.axes().into_iter().map(|a| show(of[a]).to_string());
        format!("[{}]", shown.collect::<Vec<_>>().join(", "))
    }

    fn components(&self, of: &[Option<Field>; 3]) -> String {
        let given = self.axes().into_iter().filter_map(|a| Some((a, of[a].as_ref()?)));
        let shown = given.map(|(a, field)| format!("{}: {}", AXES[a], field.yaml()));
        shown.collect::<Vec<_>>().join(", ")
    }

    pub fn yaml(&self) -> String {
        let mut out = String::new();
        let cells = if self.by_body {
            let bodies = self.cells.iter().map(|c| format!("{{cells: {}}}", self.list(*c, |n| n)));
            format!("bodies: [{}]", bodies.collect::<Vec<_>>().join(", "))
        } else {
            let [x, y, _] = self.cells[0];
            let z = self.cells.iter().map(|c| c[2]).sum();
            format!("cells: {}", self.list([x, y, z], |n: usize| n))
        };
        let size = self.list(self.size, |v| format!("{v:e}"));
        let _ = writeln!(
            out,
            "mesh: {{column: {{size: {size}, {cells}}}, order: {}, refine: {}}}\nmaterials:",
            self.order, self.refine
        );
        for (index, material) in self.materials.iter().enumerate() {
            let Material { z, young, poisson, porous } = material;
            let range = match self.materials.len() {
                1 => String::new(),
                _ => format!("z: [{:e}, {:e}], ", z[0], z[1]),
            };
            let porous = porous.as_ref().map_or(String::new(), |p| {
                format!(
                    ", porous: {{biot: {:e}, porosity: 0.2, permeability: {:e}, viscosity: {:e}, \
                     fluid_compressibility: {:e}, fluid_density: {:e}, density: {:e}}}",
                    p.biot,
                    p.permeability,
                    p.viscosity,
                    p.compressibility,
                    p.fluid_density,
                    p.density
                )
            });
            let elastic = format!("{{young_modulus: {young:e}, poisson_ratio: {poisson:e}}}");
            let _ = writeln!(out, "  m{index}: {{{range}elastic: {elastic}{porous}}}");
        }
        if !self.joints.is_empty() {
            out.push_str("interfaces:\n");
        }
        for joint @ Joint { name, z, law, secondary, fluid, .. } in &self.joints {
            let side = secondary.map_or(String::new(), |upper| {
                format!(", secondary: {}", if upper { "upper" } else { "lower" })
            });
            let fluid = fluid.as_ref().map_or(String::new(), |f| format!(", fluid: {}", f.yaml()));
            let (law, initial) = (law.yaml(), joint.initial());
            let _ =
                writeln!(out, "  - {{name: {name}, z: {z:e}, law: {law}{side}{fluid}{initial}}}");
        }
        out.push_str("boundary:\n");
        for entry in &self.boundary {
            let mut words = vec![format!("on: {}", entry.on.map_or("all", face_name))];
            for (key, of) in [("displacement", &entry.displacement), ("traction", &entry.traction)]
            {
                let shown = self.components(of);
                if !shown.is_empty() {
                    words.push(format!("{key}: {{{shown}}}"));
                }
            }
            words.extend(entry.pressure.map(|p| format!("pressure: {p:e}")));
            let _ = writeln!(out, "  - {{{}}}", words.join(", "));
        }
        if self.body_force != [0.0; 3] {
            let force =
                self.axes().into_iter().map(|a| format!("{}: {:e}", AXES[a], self.body_force[a]));
            let _ = writeln!(out, "body_force: {{{}}}", force.collect::<Vec<_>>().join(", "));
        }
        let mut initial = Vec::new();
        if self.initial_pressure != 0.0 {
            initial.push(format!("pressure: {:e}", self.initial_pressure));
        }
        let factors = self.joints.iter().filter_map(|joint| {
            let factor = joint.imperfection.as_ref()?.yaml();
            Some(format!("{{interface: {}, factor: {factor}}}", joint.name))
        });
        let factors = factors.collect::<Vec<_>>().join(", ");
        if !factors.is_empty() {
            initial.push(format!("imperfection: [{factors}]"));
        }
        if !initial.is_empty() {
            let _ = writeln!(out, "initial: {{{}}}", initial.join(", "));
        }
        let instants =
            self.instants.iter().map(|t| format!("{t:e}")).collect::<Vec<_>>().join(", ");
        let probe = self.list(self.probe, |v| format!("{v:e}"));
        let _ = writeln!(
            out,
            "time: {{instants: [{instants}]}}\nprobes: [{{name: probe, at: {probe}}}]\n\
             solver: {{tolerance: {:e}}}",
            self.tolerance
        );
        if let Some(control) = &self.control {
            let _ = writeln!(out, "control: {}", control.yaml());
        }
        for line in &self.more {
            let _ = writeln!(out, "{line}");
        }
        out
    }
}
