//! Laws of an interface point in augmented form, and the list of those that exist.
//!
//! In: the augmented traction p = t + r w (w the jump, t the traction, r the augmentation, Pa/m)
//! and the committed history. Out: the jump, the traction, their derivatives and the trial history.
//! Components are in the local frame (n, t1, t2), n from lower to upper, tension and opening
//! positive. The converged answer does not depend on r. Everything here is local.
//!
//! A new law is one file in this directory and one word in the list below: the list declares the
//! module, the case-file entry and the conformance tests.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

mod friction;
mod softening;
#[cfg(test)]
mod testkit;

pub use friction::{Friction, Past};

/// A vector in the local frame (n, t1, t2); in 2D the third component is zero.
pub type Local = [f64; 3];

/// An operator in the local frame.
pub type LocalMatrix = [[f64; 3]; 3];

/// The regime of an interface point. `Closed`: the normal is in contact and transmits compression.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(u8)]
pub enum Branch {
    /// Perfect adhesion in tension, nothing has moved yet.
    Stick = 0,
    /// Perfect adhesion under compression.
    StickClosed = 1,
    /// Below the largest opening so far: elastic towards the origin.
    Unloading = 2,
    /// Elastic sliding towards the origin, in contact.
    UnloadingClosed = 3,
    /// The largest equivalent jump grows.
    Softening = 4,
    /// The largest sliding grows, in contact.
    SofteningClosed = 5,
    /// No cohesion left, open.
    Broken = 6,
    /// No cohesion left, in contact.
    BrokenClosed = 7,
    /// Without cohesion from the start, open.
    Open = 8,
    /// Without cohesion from the start, in contact.
    Closed = 9,
    /// Bonded for good.
    Tied = 10,
    /// In contact, and held by friction.
    Held = 11,
    /// No cohesion left or none from the start, in contact, and sliding against friction.
    Sliding = 12,
}

impl Branch {
    /// Every regime.
    pub const ALL: [Branch; 13] = [
        Branch::Stick,
        Branch::StickClosed,
        Branch::Unloading,
        Branch::UnloadingClosed,
        Branch::Softening,
        Branch::SofteningClosed,
        Branch::Broken,
        Branch::BrokenClosed,
        Branch::Open,
        Branch::Closed,
        Branch::Tied,
        Branch::Held,
        Branch::Sliding,
    ];

    /// The regime in words.
    pub fn words(self) -> &'static str {
        match self {
            Branch::Stick => "adhesion",
            Branch::StickClosed => "adhesion under compression",
            Branch::Unloading => "unloading",
            Branch::UnloadingClosed => "unloading in contact",
            Branch::Softening => "softening",
            Branch::SofteningClosed => "softening in contact",
            Branch::Broken => "broken",
            Branch::BrokenClosed => "broken, in contact",
            Branch::Open => "open",
            Branch::Closed => "in contact",
            Branch::Tied => "tied",
            Branch::Held => "held by friction",
            Branch::Sliding => "sliding with friction",
        }
    }

    /// Whether the point carries no more tension or shear than it does: it softens, is broken, or
    /// never held.
    pub fn gives_way(self) -> bool {
        self.is_separated() || matches!(self, Branch::Softening | Branch::SofteningClosed)
    }

    /// Whether nothing but contact is left, which lets go: no tension, no more shear than there is.
    pub fn is_separated(self) -> bool {
        use Branch::{Broken, BrokenClosed, Closed, Open, Sliding};
        matches!(self, Broken | BrokenClosed | Open | Closed | Sliding)
    }

    /// Whether the normal is in contact (its jump is prescribed as zero by compression).
    pub fn is_closed(self) -> bool {
        use Branch::{BrokenClosed, Closed, Held, Sliding};
        use Branch::{SofteningClosed, StickClosed, UnloadingClosed};
        matches!(self, StickClosed | UnloadingClosed | SofteningClosed | BrokenClosed | Closed)
            || matches!(self, Held | Sliding)
    }
}

/// What a law answers to an augmented traction. Components beyond `dim` are zero and not stuck.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Response {
    /// Jump w(p), m.
    pub jump: Local,
    /// Traction t = p - r w, Pa.
    pub traction: Local,
    /// A = dw/dp, m/Pa: zero rows where stuck. Without friction it is symmetric and positive
    /// semi-definite; sliding against friction adds the column of the normal, and what turns.
    pub compliance: LocalMatrix,
    /// Components whose jump is prescribed (as zero): stick, tie or closed contact.
    pub stuck: [bool; 3],
    /// C = A^-1 - r I on the components that are not stuck, zero elsewhere, Pa/m: the tangent
    /// dt/dw; symmetric without friction, negative along the jump while it softens.
    pub tangent: LocalMatrix,
    /// Derivative of the tangential tractions by the normal one where the jump stays: of friction,
    /// against the sliding; zero elsewhere.
    pub friction: Local,
    /// The regime.
    pub branch: Branch,
    /// Trial history kappa, m: the largest equivalent jump up to and including this state.
    pub history: f64,
}

impl Response {
    /// Every one of the first `dim` components holds: w = 0, t = p.
    fn held(p: Local, dim: usize, branch: Branch, history: f64) -> Self {
        Response {
            jump: [0.0; 3],
            traction: p,
            compliance: [[0.0; 3]; 3],
            stuck: std::array::from_fn(|i| i < dim),
            tangent: [[0.0; 3]; 3],
            friction: [0.0; 3],
            branch,
            history,
        }
    }
}

/// A law of an interface point. Object-safe; no state of its own: the history is the caller's.
pub trait InterfaceLaw {
    /// Jump, traction, derivatives and trial history at the augmented traction `p`, without
    /// friction, which [`Friction::respond`] adds.
    ///
    /// # Arguments
    /// * `p` = t + r w, Pa; components beyond `dim` are ignored
    /// * `augmentation` r > 0, Pa/m: the one `p` was made with, from [`InterfaceLaw::augmentation`]
    /// * `history` committed kappa, m; never modified: commit `Response::history` when the
    ///   instant is accepted
    /// * `dim` 2 or 3
    ///
    /// # Parallel
    /// Local.
    fn respond(&self, p: Local, augmentation: f64, history: f64, dim: usize) -> Response;

    /// The augmentation r to use, Pa/m, where the bodies have the stiffness E / (cell height)
    /// `stiffness`, Pa/m. Never zero.
    fn augmentation(&self, stiffness: f64) -> f64;

    /// The jump at which nothing is transmitted any more, delta_c, m; none if there is no such.
    fn jump_scale(&self) -> Option<f64>;

    /// The jump by which errors of jumps are measured, m; none if there is no such.
    fn typical_jump(&self) -> Option<f64> {
        self.jump_scale()
    }

    /// The largest tensile traction, Pa; none if there is no such.
    fn strength(&self) -> Option<f64>;

    /// The steepest fall of the traction along a growing jump, whatever the history (Pa/m); none if
    /// that is not known.
    fn steepest_softening(&self) -> Option<f64> {
        None
    }

    /// Damage in [0, 1] at this history.
    fn damage(&self, history: f64) -> f64;

    /// The history at which [`InterfaceLaw::damage`] is this much, of [0, 1], m; none where the law
    /// knows no damage.
    fn history_of_damage(&self, _damage: f64) -> Option<f64> {
        None
    }

    /// How much of the jump up to which a damaged point unloads to the origin this jump is, 0 where
    /// nothing is left to give way; none where nothing is damaged and the strength is what counts.
    fn part_of_reach(&self, _jump: Local, _history: f64) -> Option<f64> {
        None
    }

    /// Energy dissipated per area up to this history, J/m2.
    fn dissipated(&self, history: f64) -> f64;

    /// Energy dissipated per area, J/m2, once a step has led from history `from` to `to` and ends
    /// at `jump`, where it was `before`; the history alone says it unless the law says otherwise.
    fn dissipated_after(&self, _before: f64, _from: f64, to: f64, _jump: Local) -> f64 {
        self.dissipated(to)
    }

    /// Whether the history is the Euclidean size of the largest jump and alone says what is
    /// dissipated, which path following by dissipation relies on.
    fn history_is_size_of_jump(&self) -> bool {
        true
    }

    /// Energy per area that unloading gives back, J/m2.
    fn recoverable(&self, jump: Local, history: f64) -> f64;

    /// Whether an interface with this history holds a body against opening.
    fn holds_opening(&self, history: f64) -> bool;

    /// Whether an interface with this history holds a body against sliding.
    fn holds_sliding(&self, history: f64) -> bool;

    /// Friction where the lips are closed; none unless the law says otherwise.
    fn friction(&self) -> Friction {
        Friction::NONE
    }

    /// The broken part of the area of a point with this history, on which friction acts.
    fn broken_part(&self, history: f64) -> f64 {
        self.damage(history)
    }

    /// Tangential traction over jump of closed lips with this history that slide less than before,
    /// Pa/m.
    fn shear_secant(&self, _history: f64) -> f64 {
        0.0
    }

    /// How far closed lips have slid where that alone has left the history, m.
    fn sliding_of(&self, history: f64) -> f64 {
        history
    }

    /// The history of closed lips that have slid so far for the first time, m, and the derivative
    /// of the broken part by the sliding, 1/m.
    fn slid_to(&self, sliding: f64) -> (f64, f64) {
        (sliding, 0.0)
    }

    /// The problems of the parameters, in words, each beginning with its parameter; empty if none.
    fn check(&self) -> Vec<String>;
}

macro_rules! laws {
    ($($module:ident::$name:ident),+ $(,)?) => {
        $(mod $module; pub use $module::$name;)+

        /// The law of an interface and its parameters, as the case file gives them.
        #[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
        #[serde(rename_all = "snake_case")]
        pub enum LawSpec {
            $(
                #[doc = concat!("See [`", stringify!($name), "`].")]
                $name($name),
            )+
        }

        $(
            impl From<$name> for LawSpec {
                fn from(law: $name) -> Self {
                    LawSpec::$name(law)
                }
            }
        )+

        impl LawSpec {
            /// The names of all laws, as the case file writes them.
            pub const NAMES: &'static [&'static str] = &[$(stringify!($module)),+];

            /// The law itself.
            pub fn law(&self) -> &dyn InterfaceLaw {
                match self {
                    $(LawSpec::$name(law) => law,)+
                }
            }

            /// The name of the law, as the case file writes it.
            pub fn name(&self) -> &'static str {
                match self {
                    $(LawSpec::$name(_) => stringify!($module),)+
                }
            }
        }

        #[cfg(test)]
        mod conformance {
            $(
                mod $module {
                    use crate::law::testkit::conformance;
                    conformance!(crate::law::$name);
                }
            )+

            #[test]
            fn names_are_those_of_the_case_file() {
                use super::testkit::Samples;
                let specs = [$(super::LawSpec::$name(
                    <super::$name as Samples>::samples().swap_remove(0),
                )),+];
                for (spec, name) in specs.iter().zip(super::LawSpec::NAMES) {
                    let text = serde_json::to_value(spec).unwrap();
                    assert!(text.get(name).is_some(), "{name}: {text}");
                    assert_eq!(spec.name(), *name);
                    assert_eq!(&serde_json::from_value::<super::LawSpec>(text).unwrap(), spec);
                }
            }
        }
    };
}

laws! {
    linear_softening::LinearSoftening,
    exponential_softening::ExponentialSoftening,
    bilinear::Bilinear,
    benzeggagh_kenane::BenzeggaghKenane,
    contact::Contact,
    tied::Tied,
}

#[cfg(test)]
mod tests {
    use super::LawSpec;

    #[test]
    fn unknown_names_are_refused() {
        for text in [
            r#"{"tied": {"strength": 1.0}}"#,
            r#"{"contact": {"fricton": 0.3}}"#,
            r#"{"linear_softening": {"strength": 1, "fracture_energy": 1, "augmentatoin": 1}}"#,
            r#"{"glued": {}}"#,
        ] {
            assert!(serde_json::from_str::<LawSpec>(text).is_err(), "{text}");
        }
    }

    #[test]
    fn the_augmentation_has_a_default() {
        let text = r#"{"linear_softening": {"strength": 1.0e6, "fracture_energy": 900.0}}"#;
        let LawSpec::LinearSoftening(law) = serde_json::from_str(text).unwrap() else {
            panic!("another law");
        };
        assert_eq!(law.augmentation, 10.0);
    }
}
