//! Random scenes: small whole numbers, of which a case is made. The smaller they are the simpler
//! the case, so that shrinking them makes it simpler.

use proptest::prelude::*;

#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Support {
    /// The bottom held in all directions.
    Clamped,
    /// Bottom, left and front held along their normals.
    Rollers,
    /// As `Rollers`, right and back too.
    Oedometric,
    /// Sides as `Oedometric`, bottom and top held in all directions.
    Boxed,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Pores {
    None,
    /// Known beforehand, in quarters of the strength.
    Known(i32),
    /// At the start, in quarters of the strength; the top is drained.
    Flow(i32),
}

/// What the path is followed by.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Control {
    Loads,
    Opening,
    Dissipation,
}

/// How fluids in interfaces act beside pores in which they flow.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Film {
    Apart,
    Connected,
    /// Of its own pressure, with quarters of what opens the interface as far as the load in a unit
    /// of time.
    Flows(i32),
}

#[derive(Debug, Clone)]
pub struct Body {
    /// Layers of cells.
    pub layers: usize,
    pub young: usize,
    pub poisson: usize,
    /// Interface below it; of the lowest body none.
    pub law: usize,
    pub rank: usize,
    pub toughness: usize,
    /// Quarters of the strength; 0 is none.
    pub fluid: i32,
    pub more_cells: usize,
}

#[derive(Debug, Clone)]
pub struct Scene {
    pub solid: bool,
    pub second_order: bool,
    pub length: i32,
    pub modulus: i32,
    pub cells: [usize; 2],
    pub width: [usize; 2],
    pub bodies: Vec<Body>,
    pub support: Support,
    /// The top is loaded, not moved.
    pub loaded: bool,
    /// Quarters of what breaks the weakest interface, at 1, 2, ...
    pub path: Vec<i32>,
    pub constant: bool,
    /// Pulled or pressed little.
    pub gentle: bool,
    /// Below 0 to and fro.
    pub shear: [i32; 2],
    pub tilt: [i32; 2],
    pub aside: i32,
    pub weight: i32,
    pub pores: Pores,
    /// Without Poisson's effect.
    pub upright: bool,
    /// Nothing is done to keep it stable.
    pub wild: bool,
    pub default_tolerance: bool,
    /// Pressures in interfaces grow from nothing.
    pub rising: bool,
    pub film: Film,
    /// Twentieths by which the first interface is weaker, the same everywhere or along x.
    pub imperfection: [i32; 2],
    pub control: Control,
    /// Eighths of the damage at the start of the first interface that has a strength, how steeply
    /// it varies along x, and quarters of the load's displacement between the lips of contacts.
    pub crack: [i32; 3],
}

/// Mostly 0, so that most of the scenes are of few parts.
fn seldom(range: std::ops::RangeInclusive<i32>) -> impl Strategy<Value = i32> {
    prop_oneof![3 => Just(0), 1 => range]
}

fn bodies() -> impl Strategy<Value = Vec<Body>> {
    let rock = (1..=3_usize, 0..6_usize, 0..4_usize);
    let joint = (
        0..8_usize,
        0..3_usize,
        0..4_usize,
        seldom(1..=8),
        prop_oneof![3 => Just(0_usize), 1 => 1..=2_usize],
    );
    let body = (rock, joint).prop_map(
        |((layers, young, poisson), (law, rank, toughness, fluid, more_cells))| Body {
            layers,
            young,
            poisson,
            law,
            rank,
            toughness,
            fluid,
            more_cells,
        },
    );
    proptest::collection::vec(body, 1..=4)
}

pub fn scenes() -> impl Strategy<Value = Scene> {
    let shape = (any::<bool>(), any::<bool>(), -3..=3_i32, -3..=3_i32);
    let across = ([1..=4_usize, 1..=4_usize], [1..=4_usize, 1..=4_usize]);
    let support = prop_oneof![2 => Just(Support::Clamped), 1 => Just(Support::Rollers), 1 => Just(Support::Oedometric), 1 => Just(Support::Boxed)];
    let loaded = prop_oneof![3 => Just(false), 1 => Just(true)];
    let path = proptest::collection::vec(-4..=12_i32, 1..=4);
    let further = proptest::collection::vec(1..=12_i32, 1..=4).prop_map(|mut path| {
        path.sort_unstable();
        path.dedup();
        path
    });
    let path = prop_oneof![path, further];
    let drive = (
        loaded,
        path,
        prop_oneof![4 => Just(false), 1 => Just(true)],
        prop_oneof![3 => Just(false), 1 => Just(true)],
    );
    let uneven = (
        [seldom(-8..=8), seldom(-8..=8)],
        [seldom(-4..=4), seldom(-4..=4)],
        seldom(-4..=4),
        seldom(-4..=4),
    );
    let uneven = prop_oneof![
        2 => Just(([0, 0], [0, 0], 0, 0)),
        1 => seldom(-4..=4).prop_map(|w| ([0, 0], [0, 0], 0, w)),
        4 => uneven
    ];
    let pores = prop_oneof![
        8 => Just(Pores::None),
        1 => (-4..=4_i32).prop_map(Pores::Known),
        1 => (0..=4_i32).prop_map(Pores::Flow)
    ];
    let last =
        (pores, any::<bool>(), prop_oneof![11 => Just(false), 1 => Just(true)], any::<bool>());
    let film = prop_oneof![
        2 => Just(Film::Apart),
        1 => Just(Film::Connected),
        1 => (0..=4_i32).prop_map(Film::Flows)
    ];
    let control = prop_oneof![
        14 => Just(Control::Loads),
        1 => Just(Control::Opening),
        1 => Just(Control::Dissipation)
    ];
    let rare = |range: std::ops::RangeInclusive<i32>| prop_oneof![7 => Just(0), 1 => range];
    // What came later is drawn last: the seeds keep their scenes.
    let crack = prop_oneof![
        6 => Just([0, 0, 0]),
        1 => (1..=8_i32, seldom(-2..=2), seldom(1..=2)).prop_map(<[i32; 3]>::from)
    ];
    let more = (any::<bool>(), film, [rare(1..=4), rare(-2..=2)], control, crack);
    (shape, across, bodies(), support, drive, uneven, last, more).prop_map(
        |(shape, (cells, width), bodies, support, drive, uneven, last, more)| {
            let (solid, second_order, length, modulus) = shape;
            let (loaded, path, constant, gentle) = drive;
            let (shear, tilt, aside, weight) = uneven;
            let (pores, upright, wild, default_tolerance) = last;
            let (rising, film, imperfection, control, crack) = more;
            Scene {
                solid,
                second_order,
                length,
                modulus,
                cells,
                width,
                bodies,
                support,
                loaded,
                path,
                constant,
                gentle,
                shear,
                tilt,
                aside,
                weight,
                pores,
                upright,
                wild,
                default_tolerance,
                rising,
                film,
                imperfection,
                control,
                crack,
            }
        },
    )
}

impl Scene {
    /// One line about it.
    pub fn words(&self) -> String {
        let mut words = vec![
            format!(
                "{}D order {}",
                if self.solid { 3 } else { 2 },
                1 + usize::from(self.second_order)
            ),
            format!("{:?}", self.support).to_lowercase(),
            format!("{} bodies", self.bodies.len()),
            format!("{} {:?}", if self.loaded { "loaded" } else { "moved" }, self.path),
        ];
        let uneven = (self.shear, self.tilt, self.aside, self.weight);
        if uneven != ([0, 0], [0, 0], 0, 0) {
            words.push(format!("shear, tilt, side, weight {uneven:?}"));
        }
        if self.pores != Pores::None {
            words.push(format!("{:?}", self.pores).to_lowercase());
        }
        if matches!(self.pores, Pores::Flow(_)) && self.film != Film::Apart {
            words.push(format!("{:?}", self.film).to_lowercase());
        }
        if self.imperfection != [0, 0] {
            words.push(format!("imperfection {:?}", self.imperfection));
        }
        if self.crack != [0; 3] {
            words.push(format!("crack {:?}", self.crack));
        }
        if self.control != Control::Loads {
            words.push(format!("{:?}", self.control).to_lowercase());
        }
        words.extend(
            [(self.constant, "constant"), (self.gentle, "gentle"), (self.wild, "wild")]
                .into_iter()
                .filter(|w| w.0)
                .map(|w| w.1.into()),
        );
        words.join(", ")
    }
}
