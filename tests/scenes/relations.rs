//! The relations that scenes are held against.

use crate::build::Built;
use crate::case::{self, Case, Entry, Field, Joint, Law};
use crate::change::Change;
use crate::launch::Setting;
use crate::scene::{Control, Pores, Scene};

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Relation {
    Exact,
    BelowStrength,
    Exchanged,
    MirroredX,
    MirroredY,
    UpsideDown,
    Units,
    SecondaryUpper,
    SecondaryLower,
    Bodies,
    Refined,
    Reduced,
    TwoRanks,
    ThreeRanks,
    Gamg,
    Hypre,
    Multigrid,
    SaddlePoint,
    Halves,
    Restarted,
    Opening,
    KnownPressure,
    Layers,
    Slice,
    EqualModes,
}

impl Relation {
    pub const ALL: [Self; 25] = [
        Self::Exact,
        Self::BelowStrength,
        Self::Exchanged,
        Self::MirroredX,
        Self::MirroredY,
        Self::UpsideDown,
        Self::Units,
        Self::SecondaryUpper,
        Self::SecondaryLower,
        Self::Bodies,
        Self::Refined,
        Self::Reduced,
        Self::TwoRanks,
        Self::ThreeRanks,
        Self::Gamg,
        Self::Hypre,
        Self::Multigrid,
        Self::SaddlePoint,
        Self::Halves,
        Self::Restarted,
        Self::Opening,
        Self::KnownPressure,
        Self::Layers,
        Self::Slice,
        Self::EqualModes,
    ];

    /// Whether it is worth the time where the scene itself is not solved.
    pub fn may_mend(self) -> bool {
        use Relation as R;
        let few = [
            R::Exchanged,
            R::UpsideDown,
            R::Units,
            R::SecondaryUpper,
            R::SecondaryLower,
            R::TwoRanks,
            R::Multigrid,
            R::SaddlePoint,
        ];
        few.contains(&self)
    }

    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|r| r.name() == name)
    }

    /// As it is called on the command line and in reports.
    pub fn name(self) -> String {
        let mut name = String::new();
        for letter in format!("{self:?}").chars() {
            if letter.is_uppercase() && !name.is_empty() {
                name.push('_');
            }
            name.extend(letter.to_lowercase());
        }
        name
    }

    pub fn words(self) -> &'static str {
        match self {
            Self::Exact => "springs and interfaces in series have exact values",
            Self::BelowStrength => {
                "what stays below every strength is as if all interfaces were tied"
            }
            Self::Exchanged => "x and y exchanged",
            Self::MirroredX => "left and right exchanged",
            Self::MirroredY => "front and back exchanged",
            Self::UpsideDown => "bottom and top exchanged",
            Self::Units => "the same in other units",
            Self::SecondaryUpper => "multipliers on the upper sides",
            Self::SecondaryLower => "multipliers on the lower sides",
            Self::Bodies => "the same cells told body by body",
            Self::Refined => "refined once, and the fine mesh at once",
            Self::Reduced => "a smaller model in place of the one asked for",
            Self::TwoRanks => "on 2 ranks",
            Self::ThreeRanks => "on 3 ranks",
            Self::Gamg => "by gamg",
            Self::Hypre => "by hypre",
            Self::Multigrid => "by multigrid",
            Self::SaddlePoint => "the saddle point in place of the condensed form",
            Self::Halves => "two steps in place of one",
            Self::Restarted => "stopped and restarted",
            Self::Opening => "by the opening of an interface in place of the displacement",
            Self::KnownPressure => "a known pressure as an unknown",
            Self::Layers => "a material cut into layers",
            Self::Slice => "a slice of one cell held in front and behind in place of plane strain",
            Self::EqualModes => "benzeggagh_kenane of equal modes in place of linear_softening",
        }
    }
}

/// Two runs that must agree, or one and exact values.
pub struct Pair {
    pub base: Case,
    pub base_setting: Setting,
    pub other: Case,
    pub setting: Setting,
    pub change: Change,
    /// Columns that both have are compared, not all.
    pub common_only: bool,
}

impl Pair {
    fn of(base: &Case) -> Self {
        Self {
            base: base.clone(),
            base_setting: Setting::PLAIN,
            other: base.clone(),
            setting: Setting::PLAIN,
            change: Change::NONE,
            common_only: false,
        }
    }

    fn set(base: &Case, set: &str) -> Self {
        Self { setting: Setting::with(set), ..Self::of(base) }
    }

    fn case(base: &Case, other: Case) -> Self {
        Self { other, ..Self::of(base) }
    }

    fn changed(base: &Case, change: Change) -> Self {
        Self { other: change.apply(base), change, ..Self::of(base) }
    }
}

/// The pair of a relation, where it applies.
pub fn pair(relation: Relation, scene: &Scene, built: &Built) -> Option<Pair> {
    let case = &built.case;
    let solid = !case.flat;
    let flow = matches!(scene.pores, Pores::Flow(_));
    let changed = |to, turned| Some(Pair::changed(case, Change { to, turned, ..Change::NONE }));
    match relation {
        Relation::Exact => built.bars.as_ref().map(|_| Pair::of(case)),
        Relation::BelowStrength => {
            let mut tied = case.clone();
            let plain = |law: Law| !matches!(law, Law::Contact | Law::Tied | Law::Bilinear { .. });
            let any = case.joints.iter().any(|j| plain(j.law));
            let holds = |j: &Joint| plain(j.law) && j.damage.is_none();
            let all = case.joints.iter().all(|j| holds(j) || j.law == Law::Tied);
            let tie = |joint: &mut Joint| (joint.law, joint.imperfection) = (Law::Tied, None);
            tied.joints.iter_mut().for_each(tie);
            (any && all && case.control.is_none()).then(|| Pair::case(case, tied))
        }
        Relation::Exchanged => solid.then(|| changed([1, 0, 2], [false; 3]))?,
        Relation::MirroredX => changed([0, 1, 2], [true, false, false]),
        Relation::MirroredY => solid.then(|| changed([0, 1, 2], [false, true, false]))?,
        Relation::UpsideDown => changed([0, 1, 2], [false, false, true]),
        Relation::Units => {
            // Millimetres and MPa, or other decades, by the scene.
            let decades = scene.bodies.len() as i32 + scene.length;
            let length = if decades % 2 == 0 { 1e3 } else { 10.0_f64.powi(-2 - decades) };
            let stress = if decades % 2 == 0 { 1e-6 } else { 10.0_f64.powi(decades) };
            Some(Pair::changed(case, Change { length, stress, ..Change::NONE }))
        }
        Relation::SecondaryUpper | Relation::SecondaryLower => {
            let mut other = case.clone();
            // Where the cells differ the sides give different discrete spaces.
            let matching = !case.by_body && !case.joints.is_empty();
            let upper = relation == Relation::SecondaryUpper;
            other.joints.iter_mut().for_each(|j| j.secondary = Some(upper));
            matching.then(|| Pair::case(case, other))
        }
        Relation::Bodies => {
            let other = Case { by_body: true, ..case.clone() };
            (!case.by_body && !case.joints.is_empty()).then(|| Pair::case(case, other))
        }
        Relation::Refined => {
            let small = case.flat || case.cells.iter().all(|c| c[0] * c[1] <= 4);
            let mut fine = case.clone();
            let axes = case.axes();
            for cells in &mut fine.cells {
                axes.iter().for_each(|a| cells[*a] *= 2);
            }
            let coarse = Case { refine: 1, ..case.clone() };
            (small && !(solid && scene.second_order && scene.bodies.len() > 1))
                .then(|| Pair::case(&fine, coarse))
        }
        Relation::Reduced => {
            // Nothing is tried below 3000 unknowns.
            let mut large = case.clone();
            let across = match (solid, scene.second_order) {
                (true, false) => 8,
                (true, true) => 4,
                (false, false) => 40,
                (false, true) => 20,
            };
            let layers: usize = case.cells.iter().map(|c| c[2]).sum();
            let along = (if scene.second_order { 8_usize } else { 14 } * if solid { 1 } else { 3 })
                .div_ceil(layers);
            for cells in &mut large.cells {
                *cells = [across, if solid { across } else { 1 }, along * cells[2]];
            }
            large.by_body = false;
            // What rounding leaves of the forces grows with the cells.
            large.tolerance = large.tolerance.max(1e-10);
            let mut pair = Pair::set(&large, "reduce=auto");
            pair.base_setting = Setting::with("reduce=never");
            pair.base_setting.fields = true;
            pair.setting.fields = true;
            built.bars.is_some().then_some(pair)
        }
        Relation::TwoRanks | Relation::ThreeRanks => {
            let ranks = if relation == Relation::TwoRanks { 2 } else { 3 };
            Some(Pair { setting: Setting { ranks, ..Setting::PLAIN }, ..Pair::of(case) })
        }
        Relation::Gamg => Some(Pair::set(case, "solver.linear=gamg")),
        Relation::Hypre => Some(Pair::set(case, "solver.linear=hypre")),
        Relation::Multigrid => Some(Pair::set(case, "solver.linear=multigrid")),
        Relation::SaddlePoint => {
            (!flow && case.control.is_none()).then(|| Pair::set(case, "solver.form=saddle_point"))
        }
        Relation::Halves => halves(built),
        Relation::Restarted => {
            let fields = Setting { fields: true, ..Setting::PLAIN };
            // A path has increments in the place of instants.
            let stop = if case.control.is_none() { case.instants.len() / 2 } else { 0 };
            let setting = Setting { stop: Some(stop), ..fields.clone() };
            (stop > 0).then(|| Pair { base_setting: fields, setting, ..Pair::of(case) })
        }
        Relation::Opening => opening(scene, built),
        Relation::KnownPressure => matches!(scene.pores, Pores::Known(_))
            .then(|| Pair { common_only: true, ..Pair::set(case, "physics=hydro_mechanics") }),
        Relation::Layers => {
            let mut cut = case.clone();
            let [z, top] = case.materials[0].z;
            let layers = if case.materials.len() == 1 {
                case.cells.iter().map(|c| c[2]).sum()
            } else {
                case.cells[0][2]
            };
            // Where a layer of cells ends, so that the mesh stays.
            let middle = z + (top - z) * (layers / 2) as f64 / layers as f64;
            cut.materials[0].z[1] = middle;
            let mut rest = case.materials[0].clone();
            rest.z[0] = middle;
            cut.materials.insert(1, rest);
            (layers > 1 && case.refine == 0).then(|| Pair::case(case, cut))
        }
        Relation::Slice => (case.flat && !flow && scene.pores == Pores::None).then(|| {
            let depth = 0.5 * case.size[0];
            let mut slice = case.clone();
            slice.flat = false;
            slice.size[1] = depth;
            slice.cells.iter_mut().for_each(|c| c[1] = 1);
            slice.probe[1] = 0.3 * depth;
            let held = [None, Some(Field::constant(0.0)), None];
            for upper in [false, true] {
                slice.boundary.push(Entry {
                    on: Some((1, upper)),
                    displacement: held.clone(),
                    ..Entry::default()
                });
            }
            let clear = |e: &mut Entry| {
                if e.on.is_none_or(|f| f.0 != 1) {
                    e.displacement[1] = None;
                    e.traction[1] = None;
                }
            };
            slice.boundary.iter_mut().for_each(clear);
            let change = Change { depth, ..Change::NONE };
            Pair { common_only: true, change, ..Pair::case(case, slice) }
        }),
        Relation::EqualModes => {
            let mut other = case.clone();
            let mut any = false;
            for joint in &mut other.joints {
                let dissipation = scene.control == Control::Dissipation;
                if let Law::Linear { strength, energy } = joint.law
                    && !dissipation
                {
                    any = true;
                    joint.law =
                        Law::Modes { strength: [strength; 2], energy: [energy; 2], exponent: 1.7 };
                }
            }
            any.then(|| Pair::case(case, other))
        }
    }
}

/// The states of an even column depend on the turns of its loads alone; where some act from the
/// start, and what grows relieves them, on the first step too.
fn halves(built: &Built) -> Option<Pair> {
    let bars = built.bars.as_ref()?;
    if bars.pressures.iter().any(|p| *p != 0.0) || bars.force != 0.0 {
        return None;
    }
    let mut finer = built.case.clone();
    let starts = std::iter::once(0.0).chain(built.case.instants.iter().copied());
    let pairs = starts.zip(&built.case.instants);
    finer.instants = pairs.flat_map(|(start, end)| [0.5 * (start + end), *end]).collect();
    Some(Pair::case(&built.case, finer))
}

/// An even column that opens ever further, by its opening.
fn opening(scene: &Scene, built: &Built) -> Option<Pair> {
    let bars = built.bars.as_ref()?;
    if bars.loaded
        || scene.constant
        || bars.pressures.iter().any(|p| *p != 0.0)
        || scene.weight != 0
    {
        return None;
    }
    let (states, whole) = bars.states();
    let last = states.last().filter(|_| whole)?;
    let opened =
        last.jump.iter().zip(&bars.laws).position(|(j, l)| *j > 0.0 && *l != Law::Contact)?;
    let jumps: Vec<f64> = states.iter().map(|s| s.jump[opened]).collect();
    let grows = jumps.iter().zip(std::iter::once(&0.0).chain(&jumps)).all(|(b, a)| b > a);
    if !grows {
        return None;
    }
    // The displacements at an instant are the values there times 1: the factor scales the last
    // ones.
    let mut other = built.case.clone();
    for entry in &mut other.boundary {
        for field in entry.displacement.iter_mut().flatten() {
            *field = Field::constant(field.path[field.path.len() - 1][1]);
        }
    }
    let points = built.case.instants.iter().zip(&jumps).map(|(t, j)| [*t, *j]);
    let path = std::iter::once([0.0, 0.0]).chain(points).collect();
    let jump = Field { path, ..Field::constant(0.0) };
    other.control = Some(case::Control::Opening(built.case.joints[opened].name.clone(), jump));
    Some(Pair::case(&built.case, other))
}
