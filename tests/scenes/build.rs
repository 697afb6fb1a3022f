//! The case that a scene stands for.

use crate::case::{self, Case, Entry, Field, Fluid, Joint, Law, Material, Porous};
use crate::closed::Bars;
use crate::scene::{Body, Control, Film, Pores, Scene, Support};

const YOUNG: [f64; 6] = [1.0, 1.0, 2.0, 5.0, 10.0, 50.0];
const POISSON: [f64; 4] = [0.0, 0.0, 0.2, 0.35];
const TOUGHNESS: [f64; 4] = [3.0, 2.0, 1.5, 8.0];

/// The case and what is known of it.
#[derive(Clone)]
pub struct Built {
    pub case: Case,
    /// Strength of the weakest interface, and the displacement that calls it up in an even pull.
    pub stress: f64,
    pub length: f64,
    /// Where the column is a row of springs.
    pub bars: Option<Bars>,
}

impl Scene {
    fn at_top(&self, component: usize) -> bool {
        component == 2 || self.support == Support::Clamped
    }

    fn poisson(&self, body: &Body) -> f64 {
        if self.upright { 0.0 } else { POISSON[body.poisson] }
    }

    /// Something differs across the column.
    pub fn uneven(&self) -> bool {
        let same =
            |of: &dyn Fn(&Body) -> f64| self.bodies.iter().all(|b| of(b) == of(&self.bodies[0]));
        let poisson = |b: &Body| self.poisson(b);
        let strained = match self.support {
            Support::Oedometric | Support::Boxed => false,
            Support::Clamped => self.bodies.iter().any(|b| poisson(b) != 0.0),
            Support::Rollers => {
                let alike = same(&poisson) && same(&|b: &Body| YOUNG[b.young]) && self.weight == 0;
                !alike && self.bodies.iter().any(|b| poisson(b) != 0.0)
            }
        };
        let sheared = self.support == Support::Clamped && self.shear != [0, 0];
        let cracked = self.crack[0] != 0 && self.crack[1] != 0;
        strained || sheared || self.tilt != [0, 0] || self.aside != 0 || cracked
    }

    pub fn build(&self) -> Built {
        let unit = 10.0_f64.powi(self.length);
        let modulus = 1e9 * 10.0_f64.powi(self.modulus);
        let flat = !self.solid;
        let levels: Vec<f64> = std::iter::once(0.0)
            .chain(self.bodies.iter().scan(0, |z, b| {
                *z += b.layers;
                Some(*z as f64 * unit)
            }))
            .collect();
        let height = levels[levels.len() - 1];
        let size = [0.5 * self.width[0] as f64 * unit, 0.5 * self.width[1] as f64 * unit, height];
        let most = if self.second_order && self.solid { 2 } else { 4 };
        let cells: Vec<[usize; 3]> = self
            .bodies
            .iter()
            .map(|b| {
                [
                    self.cells[0].min(most) + b.more_cells,
                    self.cells[1].min(most) + b.more_cells,
                    b.layers,
                ]
            })
            .collect();
        let by_body = cells.iter().any(|c| c[..2] != cells[0][..2]);
        let porous = || Porous {
            biot: 0.8,
            permeability: 1e-4 * unit * unit,
            viscosity: 1e-3 * modulus,
            compressibility: 0.5 / modulus,
            fluid_density: 1e3,
            density: 2.5e3,
        };
        let rock = |(body, z): (&Body, &[f64])| {
            let young = modulus * YOUNG[body.young];
            let porous = (self.pores != Pores::None).then(porous);
            Material { z: [z[0], z[1]], young, poisson: self.poisson(body), porous }
        };
        let mut materials: Vec<Material> =
            self.bodies.iter().zip(levels.windows(2)).map(rock).collect();
        let stiffness = |m: &Material| match self.support {
            Support::Clamped => m.young,
            Support::Rollers if flat => m.young / (1.0 - m.poisson * m.poisson),
            Support::Rollers => m.young,
            Support::Oedometric | Support::Boxed => {
                m.young * (1.0 - m.poisson) / ((1.0 + m.poisson) * (1.0 - 2.0 * m.poisson))
            }
        };
        let compliance: f64 = materials.iter().map(|m| (m.z[1] - m.z[0]) / stiffness(m)).sum();
        let stress = 1e-4 * modulus;
        let length = stress * compliance;
        // Softening that stays below the stiffness of the column, which bends and shears too.
        let narrowest = if flat { size[0] } else { size[0].min(size[1]) };
        let spare = match (self.gentle && !self.loaded, self.wild, self.uneven()) {
            // Brittle, which does not matter to what is not called up.
            (true, ..) => 0.02,
            (_, true, _) => 0.3,
            (_, _, false) => 1.0,
            (_, _, true) => 1.0 + 3.0 * (height / narrowest).powi(2),
        };
        let mut contacts = 0;
        let (mut joints, mut pressures): (Vec<Joint>, Vec<f64>) = (Vec::new(), Vec::new());
        for (index, body) in self.bodies.iter().enumerate().skip(1) {
            let strength = stress * (1.0 + 0.1 * (4 * body.rank + index - 1) as f64);
            let energy = spare * TOUGHNESS[body.toughness] * strength * strength * compliance;
            let law = match body.law {
                0..=2 => Law::Linear { strength, energy },
                3 => Law::Exponential { strength, energy },
                4 => Law::Bilinear {
                    strength,
                    energy,
                    stiffness: 10.0 * strength * strength / energy,
                },
                5 => Law::Modes {
                    strength: [strength, 1.3 * strength],
                    energy: [energy, 1.5 * energy],
                    exponent: 1.5,
                },
                6 if !self.loaded && contacts == 0 => {
                    contacts += 1;
                    Law::Contact
                }
                _ => Law::Tied,
            };
            pressures.push(0.25 * f64::from(body.fluid) * stress);
            joints.push(Joint {
                name: format!("j{index}"),
                z: levels[index],
                law,
                secondary: None,
                fluid: None,
                imperfection: None,
                damage: None,
                gap: None,
            });
        }
        let (ends, path) = self.ends(stress, length);
        for (index, joint) in joints.iter_mut().enumerate().filter(|(i, _)| pressures[*i] != 0.0) {
            let fluid = self.fluid(pressures[index], &path, 1e3 * length);
            // Where lips are tied there is no room for a fluid of its own.
            let fits = joint.law != Law::Tied || !matches!(fluid, Fluid::Flows { .. });
            joint.fluid = fits.then_some(fluid);
        }
        self.weaken(&mut joints, size);
        self.crack(&mut joints, size, length);
        let boundary = self.boundary(flat, size, &path, length, stress);
        let initial_pressure = match self.pores {
            Pores::Flow(n) => 0.25 * f64::from(n) * stress,
            _ => 0.0,
        };
        let weight = f64::from(self.weight) * stress / (8.0 * height);
        let tolerance = if self.default_tolerance { 1e-9 } else { 1e-11 };
        let known = |j: &Joint| j.damage.as_ref().is_none_or(|d| d.number().is_some());
        let is_plain = self.control == Control::Loads
            && self.imperfection == [0, 0]
            && joints.iter().all(|j| known(j) && j.gap.is_none());
        let is_constant = !self.rising || pressures.iter().all(|p| *p == 0.0);
        let is_even = !self.uneven() && self.pores == Pores::None;
        let bars = (is_even && is_plain && is_constant).then(|| Bars {
            levels: levels.clone(),
            moduli: materials.iter().map(stiffness).collect(),
            laws: joints.iter().map(|j| j.law).collect(),
            damages: joints
                .iter()
                .map(|j| j.damage.as_ref().and_then(Field::number).unwrap_or(0.0))
                .collect(),
            pressures,
            force: weight,
            loaded: self.loaded,
            ends,
            aside: matches!(self.support, Support::Oedometric | Support::Boxed).then(|| {
                let share = |m: &Material| (m.z[1] - m.z[0]) * m.poisson / (1.0 - m.poisson);
                materials.iter().map(share).sum::<f64>() * if flat { 1.0 } else { size[1] }
            }),
            area: if flat { size[0] } else { size[0] * size[1] },
        });
        // One name for rock that is the same everywhere.
        if materials
            .iter()
            .all(|m| (m.young, m.poisson) == (materials[0].young, materials[0].poisson))
        {
            materials.truncate(1);
            materials[0].z[1] = height;
        }
        let case = Case {
            flat,
            size,
            cells,
            by_body,
            order: 1 + usize::from(self.second_order),
            refine: 0,
            materials,
            boundary,
            body_force: [0.0, 0.0, weight],
            initial_pressure,
            instants: (1..=path.path.len().max(2) - 1).map(|t| t as f64).collect(),
            probe: [0.3 * size[0], if flat { 0.0 } else { 0.4 * size[1] }, 0.45 * levels[1]],
            control: self.path_followed(&joints, length),
            more: Vec::new(),
            joints,
            tolerance,
        };
        Built { case, stress, length, bars }
    }

    /// What fills an interface; `mass` per area opens it as far as the load.
    fn fluid(&self, pressure: f64, path: &Field, mass: f64) -> Fluid {
        let flow = matches!(self.pores, Pores::Flow(_));
        if let (true, Film::Flows(quarters)) = (flow, self.film) {
            return Fluid::Flows { injection: 0.25 * f64::from(quarters) * mass };
        }
        let constant = Field::constant(pressure);
        let pressure = if self.rising { path.scaled(0.0).raised(pressure) } else { constant };
        Fluid::Known { pressure, connected: flow && self.film == Film::Connected }
    }

    /// Makes the first interface that has a strength weaker, by `imperfection`.
    fn weaken(&self, joints: &mut [Joint], size: [f64; 3]) {
        let [all, along] = self.imperfection.map(|n| 0.05 * f64::from(n));
        let first = joints.iter_mut().find(|j| !matches!(j.law, Law::Contact | Law::Tied));
        if let Some(joint) = first.filter(|_| (all, along) != (0.0, 0.0)) {
            let mut factor = Field::constant(1.0 - all);
            factor.tilt[0] = along / size[0];
            factor.centre = size.map(|s| 0.5 * s);
            joint.imperfection = Some(factor);
        }
    }

    /// Damages the first interface that has a strength, and draws the lips of contacts apart, by
    /// `crack`. One that is broken everywhere holds no body that is loaded, nor a second one.
    fn crack(&self, joints: &mut [Joint], size: [f64; 3], length: f64) {
        let [eighths, along, quarters] = self.crack;
        let holds = |j: &Joint| !matches!(j.law, Law::Contact | Law::Tied);
        let is_alone = !self.loaded && joints.iter().all(|j| j.law != Law::Contact);
        let is_first = joints.iter().find(|j| holds(j));
        let may_break =
            is_alone && is_first.is_some_and(|j| !matches!(j.law, Law::Exponential { .. }));
        if let Some(joint) = joints.iter_mut().find(|j| holds(j)).filter(|_| eighths != 0) {
            let most = if may_break && self.control == Control::Loads { 8 } else { 7 };
            let mut damage = Field::constant(f64::from(eighths.min(most)) / 8.0);
            // In the middle it is what it is: somewhere it holds, unless it may break.
            damage.tilt[0] = 3.0 * f64::from(along) / size[0];
            damage.centre = size.map(|s| 0.5 * s);
            joint.damage = Some(damage);
        }
        let contacts = joints.iter_mut().filter(|j| j.law == Law::Contact && quarters != 0);
        contacts.for_each(|j| j.gap = Some(Field::constant(0.25 * f64::from(quarters) * length)));
    }

    /// The control of a path along which the first interface that softens breaks.
    fn path_followed(&self, joints: &[Joint], length: f64) -> Option<case::Control> {
        let name = &joints.iter().find(|j| !matches!(j.law, Law::Contact | Law::Tied))?.name;
        match self.control {
            // The factor scales no pressures.
            _ if self.pores != Pores::None || joints.iter().any(|j| j.fluid.is_some()) => None,
            Control::Loads => None,
            Control::Dissipation => Some(case::Control::Dissipation(name.clone())),
            Control::Opening => {
                let path = vec![[0.0, 0.0], [self.path.len().max(1) as f64, length]];
                Some(case::Control::Opening(name.clone(), Field { path, ..Field::constant(0.0) }))
            }
        }
    }

    /// What the top is moved or loaded by: at the instants, and over time.
    fn ends(&self, stress: f64, length: f64) -> (Vec<f64>, Field) {
        let unit =
            0.25 * if self.loaded { stress } else { length } * if self.gentle { 0.1 } else { 1.0 };
        // Dead loads break what they overload.
        let most = if self.loaded && !self.wild { 3 } else { 12 };
        let ends: Vec<f64> = self.path.iter().map(|n| f64::from(*n.min(&most)) * unit).collect();
        if self.constant {
            let last = ends[0];
            return (vec![last], Field::constant(last));
        }
        (ends.clone(), Field::ramps(&ends))
    }

    fn boundary(
        &self,
        flat: bool,
        size: [f64; 3],
        path: &Field,
        length: f64,
        stress: f64,
    ) -> Vec<Entry> {
        let held = |face, components: &[usize]| {
            let given = |a| components.contains(&a).then(|| Field::constant(0.0));
            Entry { on: Some(face), displacement: [0, 1, 2].map(given), ..Entry::default() }
        };
        let sides: Vec<usize> = if flat { vec![0] } else { vec![0, 1] };
        let mut entries = Vec::new();
        if matches!(self.support, Support::Clamped | Support::Boxed) {
            entries.push(held((2, false), &[0, 1, 2]));
        } else {
            entries.push(held((2, false), &[2]));
        }
        if self.support != Support::Clamped {
            entries.extend(sides.iter().map(|a| held((*a, false), &[*a])));
        }
        if matches!(self.support, Support::Oedometric | Support::Boxed) {
            entries.extend(sides.iter().map(|a| held((*a, true), &[*a])));
        }
        let mut top = Entry { on: Some((2, true)), ..Entry::default() };
        let mut tilted = path.clone();
        tilted.centre = size.map(|s| 0.5 * s);
        for axis in &sides {
            tilted.tilt[*axis] = 0.25 * f64::from(self.tilt[*axis]) / size[*axis];
        }
        let along = |axis: usize| {
            if axis == 2 {
                return tilted.clone();
            }
            // Over the same times, by steps of one size.
            let unit =
                0.25 * if self.loaded { stress } else { length } * f64::from(self.shear[axis])
                    / 4.0;
            let count = path.path.len() as f64 - 1.0;
            let ramp = |p: &[f64; 2]| {
                let part = match (count > 0.0, unit > 0.0) {
                    (false, _) => 1.0,
                    (true, true) => p[0] / count,
                    (true, false) => p[0] % 2.0,
                };
                [p[0], unit * part]
            };
            Field { path: path.path.iter().map(ramp).collect(), ..Field::constant(0.0) }
        };
        let loads = if self.loaded { &mut top.traction } else { &mut top.displacement };
        for axis in sides.iter().copied().chain([2]).filter(|a| self.at_top(*a)) {
            loads[axis] = Some(along(axis));
        }
        if self.support == Support::Boxed && !self.loaded {
            sides.iter().for_each(|a| top.displacement[*a] = Some(Field::constant(0.0)));
        }
        if let Pores::Flow(_) = self.pores {
            top.pressure = Some(0.0);
        }
        entries.push(top);
        if self.aside != 0 && matches!(self.support, Support::Clamped | Support::Rollers) {
            let mut side = Entry { on: Some((0, true)), ..Entry::default() };
            side.traction[2] = Some(path.scaled(0.0).raised(0.1 * stress * f64::from(self.aside)));
            entries.push(side);
        }
        if let Pores::Known(n) = self.pores {
            entries
                .push(Entry { pressure: Some(0.25 * f64::from(n) * stress), ..Entry::default() });
        }
        entries
    }
}

impl Field {
    /// Straight from 0 at the start to `value` at the end of its times.
    fn raised(&self, value: f64) -> Self {
        let last = self.path[self.path.len() - 1][0];
        let path = if last == 0.0 { vec![[0.0, value]] } else { vec![[0.0, 0.0], [last, value]] };
        Self { path, ..self.clone() }
    }
}
