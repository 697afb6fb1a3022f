//! Changes that must not matter: what becomes of a case, and of the names and values of its
//! results.

use crate::case::{AXES, Case, Control, Entry, Face, Field, Fluid, Law, face_name};

/// What a column of the history holds: values of a kind are comparable.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    Traction,
    Length,
    Damage,
    Force,
    Area,
    Energy,
    Mass,
    Flux,
    Time,
}

impl Kind {
    /// None for counts of iterations.
    pub fn of(column: &str) -> Option<Self> {
        let kinds = [
            ("_iterations", None),
            ("traction", Some(Self::Traction)),
            ("pressure", Some(Self::Traction)),
            ("jump", Some(Self::Length)),
            ("sliding", Some(Self::Length)),
            ("displacement", Some(Self::Length)),
            ("damage", Some(Self::Damage)),
            ("reaction", Some(Self::Force)),
            ("force", Some(Self::Force)),
            ("area", Some(Self::Area)),
            ("energy", Some(Self::Energy)),
            ("mass", Some(Self::Mass)),
            ("flux", Some(Self::Flux)),
            ("time", Some(Self::Time)),
            ("load_factor", Some(Self::Time)),
        ];
        let kind = kinds.iter().find(|(word, _)| column.contains(word));
        kind.unwrap_or_else(|| panic!("what does {column} hold?")).1
    }
}

/// Axes exchanged, then turned round, in other units.
#[derive(Clone)]
pub struct Change {
    /// Where an axis comes to lie.
    pub to: [usize; 3],
    /// Of the new axes.
    pub turned: [bool; 3],
    /// Units of length and stress that the former ones have.
    pub length: f64,
    pub stress: f64,
    /// Thickness of what was per metre.
    pub depth: f64,
}

impl Change {
    pub const NONE: Self =
        Self { to: [0, 1, 2], turned: [false; 3], length: 1.0, stress: 1.0, depth: 1.0 };

    fn vector<T: Clone>(&self, of: &[T; 3], turn: impl Fn(&T) -> T) -> [T; 3] {
        std::array::from_fn(|new| {
            let value = &of[self.from(new)];
            if self.turned[new] { turn(value) } else { value.clone() }
        })
    }

    fn from(&self, new: usize) -> usize {
        self.to.iter().position(|to| *to == new).expect("a permutation")
    }

    fn face(&self, (axis, upper): Face) -> Face {
        let axis = self.to[axis];
        (axis, upper != self.turned[axis])
    }

    /// A place in a column of that (old) size.
    fn place(&self, at: [f64; 3], size: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|new| {
            let old = self.from(new);
            self.length * if self.turned[new] { size[old] - at[old] } else { at[old] }
        })
    }

    fn field(&self, field: &Field, factor: f64, size: [f64; 3]) -> Field {
        Field {
            tilt: self.vector(&field.tilt, |t| -t).map(|t| t / self.length),
            centre: self.place(field.centre, size),
            ..field.scaled(factor)
        }
    }

    fn fields(&self, of: &[Option<Field>; 3], factor: f64, size: [f64; 3]) -> [Option<Field>; 3] {
        let inner = |field: &Option<Field>| field.as_ref().map(|f| self.field(f, factor, size));
        self.vector(&of.each_ref().map(inner), |f| f.as_ref().map(|f| f.scaled(-1.0)))
    }

    pub fn apply(&self, case: &Case) -> Case {
        let (length, stress) = (self.length, self.stress);
        let mut new = case.clone();
        new.size = self.vector(&case.size, |s| *s).map(|s| s * length);
        new.cells = case.cells.iter().map(|c| self.vector(c, |n| *n)).collect();
        let top = case.size[2];
        let level = |z: f64| length * if self.turned[2] { top - z } else { z };
        for (new, old) in new.materials.iter_mut().zip(&case.materials) {
            new.z = old.z.map(level);
            new.z.sort_by(f64::total_cmp);
            new.young *= stress;
            if let Some(p) = &mut new.porous {
                p.permeability *= length * length;
                p.viscosity *= stress;
                p.compressibility /= stress;
                p.fluid_density *= stress / (length * length);
                p.density *= stress / (length * length);
            }
        }
        let per_area = stress * length;
        for joint in &mut new.joints {
            joint.z = level(joint.z);
            joint.secondary = joint.secondary.map(|upper| upper != self.turned[2]);
            let field = |f: &Field, factor: f64| self.field(f, factor, case.size);
            joint.imperfection = joint.imperfection.as_ref().map(|f| field(f, 1.0));
            joint.damage = joint.damage.as_ref().map(|f| field(f, 1.0));
            joint.gap = joint.gap.as_ref().map(|f| field(f, length));
            joint.fluid = joint.fluid.as_ref().map(|fluid| match fluid {
                Fluid::Known { pressure, connected } => {
                    Fluid::Known { pressure: pressure.scaled(stress), connected: *connected }
                }
                Fluid::Flows { injection } => {
                    Fluid::Flows { injection: injection * stress / length }
                }
            });
            joint.law = match joint.law {
                Law::Linear { strength, energy } => {
                    Law::Linear { strength: strength * stress, energy: energy * per_area }
                }
                Law::Exponential { strength, energy } => {
                    Law::Exponential { strength: strength * stress, energy: energy * per_area }
                }
                Law::Bilinear { strength, energy, stiffness } => Law::Bilinear {
                    strength: strength * stress,
                    energy: energy * per_area,
                    stiffness: stiffness * stress / length,
                },
                Law::Modes { strength, energy, exponent } => Law::Modes {
                    strength: strength.map(|s| s * stress),
                    energy: energy.map(|g| g * per_area),
                    exponent,
                },
                other => other,
            };
        }
        if self.turned[2] {
            new.cells.reverse();
            new.joints.reverse();
            new.materials.reverse();
        }
        let entry = |entry: &Entry| Entry {
            on: entry.on.map(|f| self.face(f)),
            displacement: self.fields(&entry.displacement, length, case.size),
            traction: self.fields(&entry.traction, stress, case.size),
            pressure: entry.pressure.map(|p| p * stress),
        };
        new.boundary = case.boundary.iter().map(entry).collect();
        new.body_force = self.vector(&case.body_force, |f| -f).map(|f| f * stress / length);
        new.initial_pressure *= stress;
        if let Some(Control::Opening(_, jump)) = &mut new.control {
            *jump = jump.scaled(length);
        }
        new.probe = self.place(case.probe, case.size);
        new
    }

    /// What a column is called afterwards, and the factor of its values.
    pub fn column(&self, name: &str, flat: bool) -> (String, f64) {
        let mut parts: Vec<String> = name.split('.').map(str::to_owned).collect();
        let mut factor = self.unit(name, flat);
        if let Some(face) = faces().find(|f| face_name(*f) == parts[0]) {
            parts[0] = face_name(self.face(face)).into();
        }
        let Some(quantity) = parts.get(1).cloned() else { return (name.into(), factor) };
        let axis =
            AXES.iter().position(|a| quantity.strip_suffix(a).is_some_and(|q| q.ends_with('_')));
        if let Some(axis) = axis {
            let to = self.to[axis];
            parts[1] = format!("{}{}", &quantity[..quantity.len() - 1], AXES[to]);
            // Of the upper side against the lower one.
            let is_of_sides = |word: &&str| quantity.starts_with(word);
            let relative = ["shear", "sliding", "force"].iter().any(is_of_sides);
            if self.turned[to] != (relative && self.turned[2]) {
                factor = -factor;
            }
        }
        if self.turned[2] {
            parts[1] = match parts[1].as_str() {
                "flux_lower" => "flux_upper".into(),
                "flux_upper" => "flux_lower".into(),
                _ => parts[1].clone(),
            };
        }
        if factor < 0.0 && parts.len() == 3 {
            parts[2] = match parts[2].as_str() {
                "min" => "max".into(),
                "max" => "min".into(),
                _ => parts[2].clone(),
            };
        }
        (parts.join("."), factor)
    }

    fn unit(&self, name: &str, flat: bool) -> f64 {
        let (length, stress) = (self.length, self.stress);
        let across = if flat { length } else { length * length };
        match Kind::of(name) {
            Some(Kind::Traction) => stress,
            Some(Kind::Length) => length,
            Some(Kind::Damage | Kind::Time) | None => 1.0,
            Some(Kind::Force) => stress * across * self.depth,
            Some(Kind::Area) => across * self.depth,
            Some(Kind::Energy) => stress * across * length * self.depth,
            Some(Kind::Mass) => stress / length * across * self.depth,
            Some(Kind::Flux) => stress / length,
        }
    }
}

fn faces() -> impl Iterator<Item = Face> {
    (0..3).flat_map(|axis| [(axis, false), (axis, true)])
}
