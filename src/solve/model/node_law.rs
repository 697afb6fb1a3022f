//! The law of an interface at one of its nodes.

use crate::law::{Friction, InterfaceLaw, LawSpec, Local, Past, Response};

/// One interface's law with its augmentation.
pub struct JointLaw {
    /// The law.
    pub spec: LawSpec,
    /// Augmentation r (Pa/m).
    pub augmentation: f64,
}

/// The law at a node: strength, fracture energy and augmentation are those of its interface times
/// the factor of its imperfection, and the critical jump is the same. With the factor f, its
/// traction at a jump w is f t(w), so that the traction p = t + f r w is f times that of the
/// interface's law.
#[derive(Clone, Copy)]
pub struct NodeLaw<'a> {
    law: &'a dyn InterfaceLaw,
    /// r of the interface (Pa/m).
    interface_augmentation: f64,
    factor: f64,
}

impl<'a> NodeLaw<'a> {
    /// The law of an interface with its augmentation, times the factor of a node.
    pub fn new(law: &'a dyn InterfaceLaw, interface_augmentation: f64, factor: f64) -> Self {
        Self { law, interface_augmentation, factor }
    }

    /// Augmentation r (Pa/m).
    pub fn augmentation(&self) -> f64 {
        self.factor * self.interface_augmentation
    }

    /// As [`crate::law::Friction::respond`], `p` with the augmentation of the node and that of the
    /// `damping` (Pa/m), which adds to the tangent.
    pub(in crate::solve) fn respond(
        &self,
        p: Local,
        damping: f64,
        past: Past,
        dim: usize,
    ) -> Response {
        let f = self.factor;
        let friction = self.friction();
        let augmentation = self.interface_augmentation + damping / f;
        let answer = friction.respond(self.law, p.map(|p| p / f), augmentation, past, dim);
        let mut tangent = answer.tangent.map(|row| row.map(|c| f * c));
        for i in (0..dim).filter(|i| !answer.stuck[*i]) {
            tangent[i][i] += damping;
        }
        Response {
            traction: answer.traction.map(|t| f * t),
            compliance: answer.compliance.map(|row| row.map(|a| a / f)),
            tangent,
            ..answer
        }
    }

    /// As [`InterfaceLaw::friction`], of the law without the factor: friction has none.
    fn friction(&self) -> Friction {
        let of = self.law.friction();
        Friction { cohesion: of.cohesion / self.factor, ..of }
    }

    /// Whether there is friction. Local.
    pub fn rubs(&self) -> bool {
        !self.law.friction().is_none()
    }

    /// What friction bears on a point with this history under a `normal` traction (Pa).
    pub fn bearable(&self, history: f64, normal: f64) -> f64 {
        let Friction { coefficient, cohesion } = self.law.friction();
        self.broken_part(history) * (cohesion - coefficient * normal)
    }

    /// The tangential traction of the cohesive part of a point that has slid (Pa).
    pub fn cohesive_shear(&self, history: f64, sliding: [f64; 2]) -> [f64; 2] {
        sliding
            .map(|w| if w == 0.0 { 0.0 } else { self.factor * self.law.shear_secant(history) * w })
    }

    /// The augmented traction, made with the `damping` too, at which friction holds without acting,
    /// under the normal one `normal`.
    pub fn at_rest(&self, normal: f64, damping: f64, past: Past) -> Local {
        let Past { history, sliding } = past;
        let cohesive = self.cohesive_shear(history, sliding);
        let shear = |c: usize| (self.augmentation() + damping) * sliding[c] + cohesive[c];
        [normal, shear(0), shear(1)]
    }

    /// As [`InterfaceLaw::broken_part`].
    pub fn broken_part(&self, history: f64) -> f64 {
        self.law.broken_part(history)
    }

    /// As [`InterfaceLaw::strength`].
    pub fn strength(&self) -> Option<f64> {
        self.law.strength().map(|strength| self.factor * strength)
    }

    /// As [`InterfaceLaw::part_of_reach`].
    pub fn part_of_reach(&self, jump: Local, history: f64) -> Option<f64> {
        self.law.part_of_reach(jump, history)
    }

    /// As [`InterfaceLaw::dissipated`].
    pub fn dissipated(&self, history: f64) -> f64 {
        self.factor * self.law.dissipated(history)
    }

    /// As [`InterfaceLaw::dissipated_after`], from what was dissipated before and the history then.
    pub fn dissipated_after(&self, before: f64, from: f64, to: f64, jump: Local) -> f64 {
        let f = self.factor;
        f * self.law.dissipated_after(before / f, from, to, jump)
    }

    /// As [`InterfaceLaw::recoverable`].
    pub fn recoverable(&self, jump: Local, history: f64) -> f64 {
        self.factor * self.law.recoverable(jump, history)
    }
}
