//! Checks of platens: surfaces that move as rigid bodies.

use super::checker::Checker;
use crate::case::Case;
use crate::case::sections::file::{BoundarySection, CaseFile, Components};
use crate::case::sections::quantity::Quantity;
use crate::case::sections::{
    BoundarySpec, Motion, MotionSection, MotionWord, RigidSection, RigidSpec, RotationSection,
    Surface,
};
use crate::input::Value;

const AXES: [&str; 3] = ["x", "y", "z"];

/// What a platen is asked for that it does not bind.
const UNBOUND: &str = "a platen moves only the components it names";

impl Case {
    /// The surfaces that are platens in some stage, in the order of their first entry.
    pub fn rigid_surfaces(&self) -> Vec<&Surface> {
        let mut surfaces: Vec<&Surface> = self.supported[1].iter().collect();
        for entry in self.boundary.iter().filter(|entry| entry.rigid.is_some()) {
            if !surfaces.contains(&&entry.on) {
                surfaces.push(&entry.on);
            }
        }
        surfaces
    }

    /// The axes that bodies of the mesh turn about.
    pub fn turning_axes(&self) -> impl Iterator<Item = usize> {
        let dim = self.dim;
        let axes = self.axes;
        (0..3).filter(move |axis| dim == 3 || !axes.contains(axis))
    }

    /// The columns of the platens in `history.csv`: of each the motion of its centroid, its
    /// rotation, and the moment of it on the body.
    pub(super) fn columns_of_platens(&self) -> Vec<String> {
        let mut columns = Vec::new();
        for surface in self.rigid_surfaces() {
            let name = surface.name();
            columns.extend(self.axis_names().map(|axis| format!("{name}.displacement_{axis}")));
            for of in ["rotation", "moment"] {
                let axes = self.turning_axes().map(|axis| AXES[axis]);
                columns.extend(axes.map(|axis| format!("{name}.{of}_{axis}")));
            }
        }
        columns
    }
}

impl Checker<'_> {
    /// The platen of an entry.
    pub(super) fn rigid(&mut self, path: &str, section: &BoundarySection) -> Option<RigidSpec> {
        let rigid = section.rigid.as_ref()?;
        let path = format!("{path}.rigid");
        let mut spec = RigidSpec::default();
        for (axis, motion) in [&rigid.x, &rigid.y, &rigid.z].into_iter().enumerate() {
            let Some(motion) = motion else { continue };
            let path = format!("{path}.{}", AXES[axis]);
            if self.lacks(axis) {
                let lack = self.lack();
                self.add(&path, lack);
            }
            spec.along[axis] = Some(self.motion(&path, motion));
        }
        if spec.along == [const { None }; 3] {
            self.add(&path, "binds no component; give x, y or z: free, fixed or a value");
            return None;
        }
        self.rotations(&path, rigid, &mut spec);
        spec.force = self.load_of(&path, "force", &rigid.force, &spec.along);
        spec.moment = self.load_of(&path, "moment", &rigid.moment, &spec.about);
        Some(spec)
    }

    fn motion(&mut self, path: &str, section: &MotionSection) -> Motion {
        match section {
            MotionSection::Word(MotionWord::Free) => Motion::Free,
            MotionSection::Word(MotionWord::Fixed) => Motion::Fixed,
            _ => {
                let quantity = section.quantity();
                let value = quantity.map_or(Value::Constant(0.0), |q| self.value_in_time(path, &q));
                Motion::Given(value)
            }
        }
    }

    fn value_in_time(&mut self, path: &str, quantity: &Quantity) -> Value {
        let value = self.value(path, quantity);
        if value.varies_in_space() {
            self.add(path, "varies in space; a platen has one value of it at a time: use t alone");
        }
        value
    }

    /// The rotations that turn a component which the platen binds.
    fn rotations(&mut self, path: &str, section: &RigidSection, spec: &mut RigidSpec) {
        let exists =
            |checker: &Self, about: usize| (0..3).all(|axis| axis == about || !checker.lacks(axis));
        let binds = |about: usize| (0..3).any(|axis| axis != about && spec.along[axis].is_some());
        let turns = [0, 1, 2].map(|about| exists(self, about) && binds(about));
        let mut about = turns.map(|turns| turns.then_some(Motion::Fixed));
        match &section.rotation {
            None | Some(RotationSection::Word(MotionWord::Fixed)) => {}
            Some(RotationSection::Word(MotionWord::Free)) => {
                about = turns.map(|turns| turns.then_some(Motion::Free));
            }
            Some(RotationSection::Axes(axes)) => {
                for (axis, motion) in [&axes.x, &axes.y, &axes.z].into_iter().enumerate() {
                    let Some(motion) = motion else { continue };
                    let path = format!("{path}.rotation.{}", AXES[axis]);
                    let motion = self.motion(&path, motion);
                    if turns[axis] {
                        about[axis] = Some(motion);
                    } else if !exists(self, axis) {
                        self.add(&path, "does not exist: bodies in 2D turn in their plane alone");
                    } else {
                        self.add(&path, format!("turns nothing that the platen binds: {UNBOUND}"));
                    }
                }
            }
        }
        spec.about = about;
    }

    /// Forces or moments, each on a motion that is free.
    fn load_of(
        &mut self,
        path: &str,
        key: &str,
        section: &Components,
        motions: &[Option<Motion>; 3],
    ) -> [Option<Value>; 3] {
        if section.normal.is_some() {
            let reason = "has no meaning for a platen; give it along x, y or z";
            self.add(&format!("{path}.{key}.normal"), reason);
        }
        let parts = [&section.x, &section.y, &section.z];
        std::array::from_fn(|axis| {
            let (part, name) = (parts[axis].as_ref()?, AXES[axis]);
            let path = format!("{path}.{key}.{name}");
            let motion = if key == "force" { name.to_owned() } else { format!("rotation.{name}") };
            match &motions[axis] {
                Some(Motion::Free) => {}
                Some(_) => self.add(
                    &path,
                    format!("acts on a motion that is prescribed: give {motion}: free, or leave the {key} out"),
                ),
                None => self.add(&path, format!("acts on what is not bound ({UNBOUND}): give {motion}: free")),
            }
            Some(self.value_in_time(&path, part))
        })
    }

    /// The displacements of an entry that is a platen: the value of a component that has one for
    /// the whole surface, 0 as a placeholder of the others.
    pub(super) fn displacement_of_platen(
        &mut self,
        path: &str,
        rigid: &RigidSpec,
        mut displacement: [Option<Value>; 3],
    ) -> [Option<Value>; 3] {
        for (axis, motion) in rigid.along.iter().enumerate() {
            let Some(motion) = motion else { continue };
            if displacement[axis].is_some() {
                let name = AXES[axis];
                let reason = format!("is given beside displacement.{name}; leave one of them out");
                self.add(&format!("{path}.rigid.{name}"), reason);
            }
            let value = match motion {
                Motion::Given(value) if !rigid.carries(axis) => value.clone(),
                _ => Value::Constant(0.0),
            };
            displacement[axis] = Some(value);
        }
        displacement
    }

    /// A platen that meets what gives the displacement of its nodes too.
    pub(super) fn beside_platen(
        &mut self,
        index: usize,
        (earlier, other): (usize, &BoundarySpec),
        axis: &str,
    ) {
        let reason = format!(
            "gives the displacement along {axis} of nodes that it shares with boundary.{earlier} \
             ({}), which gives it too; a platen moves all nodes of its surface: leave {axis} out of \
             one of them",
            other.on.name(),
        );
        self.add(&format!("boundary.{index}"), reason);
    }

    /// Two platens on one surface, and a probe of the name of one.
    pub(super) fn platens(&mut self, file: &CaseFile, boundary: &[BoundarySpec]) {
        let of_stages = self.surfaces_of_stages.iter().filter(|(_, kinds)| kinds[1]);
        let mut names: Vec<String> = of_stages.map(|(name, _)| name.clone()).collect();
        let now = boundary.iter().filter(|entry| entry.rigid.is_some());
        names.extend(now.map(|entry| entry.on.name().to_owned()));
        for (index, probe) in file.probes.iter().enumerate() {
            if names.contains(&probe.name) {
                let reason = "is the name of a platen, whose displacements are told under it too";
                self.add(&format!("probes.{index}.name"), reason);
            }
        }
        for (index, entry) in boundary.iter().enumerate() {
            let path = format!("boundary.{index}.rigid");
            let is_second = |other: &&BoundarySpec| other.on == entry.on && other.rigid.is_some();
            if entry.rigid.is_some() && boundary[..index].iter().any(|other| is_second(&other)) {
                self.add(&path, "is the second one on its surface; make them one");
            }
        }
    }
}
