//! The state of the secondary nodes: tractions, jumps, branches and history.

use super::gaps::NodeData;
pub use super::node_law::{JointLaw, NodeLaw};
use super::sliding::Sliding;
use crate::assembly::{Discretization, NodeState};
use crate::comm::Comm;
use crate::interface::{JumpRow, JumpRows};
use crate::law::{Branch, Past, Response};

/// What the law of one secondary node answers, by displacement component.
#[derive(Debug, Clone, Copy)]
pub struct NodeResponse {
    /// Traction that the bulk transmits (Pa); 0 where the component has no multiplier.
    pub bulk_traction: [f64; 3],
    /// Jump of the displacement, and of its normal component also the gap at the start (m).
    pub jump: [f64; 3],
    /// Jump that differs from the one the law asks for (m): zero at the solution.
    pub defect: [f64; 3],
    /// Traction with which the linearised law goes on from here (Pa).
    pub law_traction: [f64; 3],
    /// Augmented traction at which the law answered, less that of the state (Pa).
    pub shift: [f64; 3],
    /// What the tangent needs.
    pub state: NodeState,
    /// Derivative of the law's jump by the augmented traction (m/Pa).
    pub compliance: [[f64; 3]; 3],
    /// The regime.
    pub branch: Branch,
    /// Largest equivalent jump including this state (m).
    pub history: f64,
}

/// Tractions that hold jumps back: `stiffness` times what a jump is beyond the one of an earlier
/// state.
pub struct Damping {
    /// Pa/m.
    pub stiffness: f64,
    /// The earlier jumps at owned secondary nodes, by displacement component (m).
    pub from: Vec<[f64; 3]>,
}

/// What interfaces keep from accepted states.
pub(in crate::solve) struct History {
    largest: Vec<f64>,
    dissipated: Vec<f64>,
    accepted: Vec<[f64; 3]>,
    sliding: Vec<Sliding>,
}

/// State of the secondary nodes that this rank owns, in the order of `Discretization::secondary`.
pub struct InterfaceState {
    pub(super) dim: usize,
    /// The law of each interface.
    pub laws: Vec<JointLaw>,
    /// What strength and fracture energy of the interface are multiplied by at each node.
    pub factors: Vec<f64>,
    /// Gap at each node before anything moves, along the normal (m).
    pub gaps: Vec<f64>,
    /// What of the jump at each node its law does not see, as it was there when the stage began and
    /// its multipliers were shared out (m); empty in the first stage.
    pub(in crate::solve) misfit: Vec<[f64; 3]>,
    /// Largest equivalent jump that the damage at the start stands for (m).
    pub initial: Vec<f64>,
    /// Jump at each node from which results count (m); empty where it is 0.
    pub(in crate::solve) origin: Vec<[f64; 3]>,
    /// Largest equivalent jump at the last accepted state (m).
    pub committed: Vec<f64>,
    /// Energy per area dissipated up to the last accepted state (J/m2), without friction; with that
    /// of the damage at the start.
    pub dissipated: Vec<f64>,
    /// Sliding and friction at the last accepted state.
    pub sliding: Vec<Sliding>,
    /// Augmented traction at the last accepted state, by displacement component (Pa).
    pub accepted: Vec<[f64; 3]>,
    /// That from which laws answer linearly in the running step: the accepted one, or where the
    /// node has opened or closed on the way (Pa).
    pub(in crate::solve) base: Vec<[f64; 3]>,
    /// The answers at the last evaluated state.
    pub response: Vec<NodeResponse>,
    /// How much larger than they are augmented tractions are taken.
    pub overstress: f64,
    /// On the way from an unstable state to a stable one.
    pub damping: Option<Damping>,
    /// Whether what holds has to soften in one state of Newton's method before it breaks in
    /// another: where a volume of fluid opens an interface, the first correction from sticking
    /// overshoots without bound.
    pub is_gradual: bool,
}

impl InterfaceState {
    /// The unloaded state of the owned nodes, of which `nodes` tells.
    pub fn new(all: &Discretization, laws: Vec<JointLaw>, nodes: NodeData) -> Self {
        let NodeData { factors, gaps, damages } = nodes;
        let owned = factors.len();
        let rest = NodeResponse {
            bulk_traction: [0.0; 3],
            jump: [0.0; 3],
            defect: [0.0; 3],
            law_traction: [0.0; 3],
            shift: [0.0; 3],
            state: NodeState::STUCK,
            compliance: [[0.0; 3]; 3],
            branch: Branch::Stick,
            history: 0.0,
        };
        let mut state = Self {
            dim: all.dim,
            laws,
            factors,
            gaps,
            misfit: Vec::new(),
            initial: vec![0.0; owned],
            origin: Vec::new(),
            committed: vec![0.0; owned],
            dissipated: vec![0.0; owned],
            sliding: vec![Sliding::default(); owned],
            accepted: Vec::new(),
            base: Vec::new(),
            response: vec![rest; owned],
            overstress: 1.0,
            damping: None,
            is_gradual: false,
        };
        for (response, gap) in state.response.iter_mut().zip(&state.gaps) {
            response.jump[all.dim - 1] = *gap;
        }
        state.accepted = (0..owned).map(|index| state.augmented(all, index)).collect();
        state.base.clone_from(&state.accepted);
        state.damage(all, &damages);
        state
    }

    /// Gives the nodes the history of their damage at the start. Local.
    fn damage(&mut self, all: &Discretization, damages: &[f64]) {
        for index in (0..damages.len()).filter(|index| damages[*index] > 0.0) {
            let rows = &all.secondary[index];
            let law = self.laws[rows.interface].spec.law();
            let history = law.history_of_damage(damages[index]).unwrap_or(0.0);
            (self.initial[index], self.committed[index]) = (history, history);
            let (law, p) = (self.law_at(index, rows), to_local(self.accepted[index], self.dim));
            let dissipated = law.dissipated(history);
            let branch = law.respond(p, 0.0, self.past(index), self.dim).branch;
            self.dissipated[index] = dissipated;
            (self.response[index].branch, self.response[index].history) = (branch, history);
        }
    }

    /// The law at the secondary node of an index, which `rows` belong to. Local.
    pub fn law_at(&self, index: usize, rows: &JumpRows<u32>) -> NodeLaw<'_> {
        let JointLaw { spec, augmentation } = &self.laws[rows.interface];
        NodeLaw::new(spec.law(), *augmentation, self.factors[index])
    }

    /// What a node keeps from accepted states. Local.
    pub(in crate::solve) fn past(&self, index: usize) -> Past {
        Past { history: self.committed[index], sliding: self.sliding[index].at }
    }

    /// Evaluates the laws at the displacements `u`, `dim` numbers per local node; `given` is the
    /// traction of a row of the jump (Pa), by index of the secondary node and component. Local.
    pub fn evaluate(
        &mut self,
        all: &Discretization,
        u: &[f64],
        given: impl Fn(usize, usize, &JumpRow<u32>) -> f64,
    ) {
        let dim = self.dim;
        for index in 0..self.response.len() {
            let rows = &all.secondary[index];
            let law = self.law_at(index, rows);
            let augmentation = law.augmentation();
            let (mut traction, mut jump) = ([0.0; 3], [0.0; 3]);
            for c in 0..dim {
                if let Some(row) = &rows.rows[c] {
                    traction[c] = given(index, c, row);
                    jump[c] = row.trace(rows.own(c), |unknown| u[unknown as usize]);
                }
            }
            let beyond = self.beyond(index);
            (0..dim).for_each(|c| jump[c] += beyond[c]);
            let (damping, from) = match &self.damping {
                Some(damping) => (damping.stiffness, damping.from[index]),
                None => (0.0, [0.0; 3]),
            };
            // The law's own part of the traction is without d (w - from): its p, made with r + d,
            // is t + r w + d from.
            let p: [f64; 3] = std::array::from_fn(|c| {
                self.overstress * (traction[c] + augmentation * jump[c]) + damping * from[c]
            });
            let past = self.past(index);
            let respond =
                |part: f64| law.respond(to_local(p.map(|p| part * p), dim), damping, past, dim);
            let (mut part, mut answer) = (1.0, respond(1.0));
            if self.is_gradual && holds(self.response[index].branch) {
                while is_broken(answer.branch) && part > LEAST_PART {
                    part *= 0.5;
                    answer = respond(part);
                }
            }
            let mut shift = p.map(|p| (part - 1.0) * p);
            if self.turns_round(index, &answer) {
                let at_rest = law.at_rest(p[dim - 1], damping, past);
                answer = law.respond(at_rest, damping, past, dim);
                (0..dim).for_each(|c| shift[c] = at_rest[local_index(c, dim)] - p[c]);
            }
            let asked = Asked { traction, jump, shift };
            self.response[index] = combine(rows, &asked, &answer, augmentation, dim);
        }
    }

    /// Lets the laws of the nodes that are `marked`, or of all, answer linearly from their base, at
    /// the state that was evaluated last. Local.
    pub(in crate::solve) fn linearise_at_base(
        &mut self,
        all: &Discretization,
        marked: Option<&[bool]>,
    ) {
        for index in (0..self.response.len()).filter(|index| marked.is_none_or(|m| m[*index])) {
            let (rows, here) = (&all.secondary[index], self.augmented(all, index));
            let law = self.law_at(index, rows);
            let p = self.base[index].map(|p| self.overstress * p);
            let answer = law.respond(to_local(p, self.dim), 0.0, self.past(index), self.dim);
            let shift = std::array::from_fn(|c| p[c] - here[c]);
            let NodeResponse { bulk_traction: traction, jump, .. } = self.response[index];
            let asked = Asked { traction, jump, shift };
            self.response[index] = combine(rows, &asked, &answer, law.augmentation(), self.dim);
        }
    }

    /// The augmented traction of the last evaluated state, by displacement component (Pa). Local.
    pub(in crate::solve) fn augmented(&self, all: &Discretization, index: usize) -> [f64; 3] {
        let r = self.law_at(index, &all.secondary[index]).augmentation();
        let NodeResponse { bulk_traction, jump, .. } = &self.response[index];
        std::array::from_fn(|c| bulk_traction[c] + r * jump[c])
    }

    /// The largest part that is taken up of what a point bears before it gives way: of the
    /// strength, compression left out, and where it is damaged of its reach; 0 where it is no more
    /// than rounding beside the compression. Collective.
    pub fn share_of_strength(&self, comm: &Comm, all: &Discretization) -> f64 {
        let mut largest = [0.0_f64; 2];
        for (index, response) in self.response.iter().enumerate() {
            let law = self.law_at(index, &all.secondary[index]);
            let Some(strength) = law.strength() else { continue };
            let t = to_local(response.bulk_traction, self.dim);
            let jump = to_local(response.jump, self.dim);
            let [pulled, all] =
                [t[0].max(0.0), t[0]].map(|normal| normal.hypot(t[1]).hypot(t[2]) / strength);
            let reached = law.part_of_reach(jump, self.committed[index]);
            largest = [largest[0].max(reached.unwrap_or(pulled)), largest[1].max(all)];
        }
        comm.max(&mut largest);
        if largest[0] > 1e-8 * largest[1] { largest[0] } else { 0.0 }
    }

    /// Takes the tractions of the last evaluated state for those of the accepted one. Local.
    pub(in crate::solve) fn take_tractions(&mut self, all: &Discretization) {
        for index in 0..self.response.len() {
            self.accepted[index] = self.augmented(all, index);
            let law = self.law_at(index, &all.secondary[index]);
            self.sliding[index].traction = self.reached(index).friction(law);
        }
    }

    /// Whether lips with friction have slid up to the last accepted state. Local.
    pub(in crate::solve) fn have_slid(&self, all: &Discretization) -> bool {
        let rubs = |index: usize| self.law_at(index, &all.secondary[index]).rubs();
        let slid = self.sliding.iter().enumerate().filter(|(_, node)| node.at != [0.0; 2]);
        slid.map(|(index, _)| index).any(rubs)
    }

    /// Whether a point that slid in the state that was evaluated last slides the other way by this
    /// answer. It is then held: Newton's method would go to and fro between both ways. Local.
    fn turns_round(&self, index: usize, answer: &Response) -> bool {
        let before = &self.response[index].state.friction;
        let along = |c: usize| before[c] * answer.friction[local_index(c, self.dim)];
        (0..self.dim - 1).map(along).sum::<f64>() < 0.0
    }

    /// What is kept from accepted states. Local.
    pub(in crate::solve) fn history(&self) -> History {
        let (largest, dissipated) = (self.committed.clone(), self.dissipated.clone());
        let (accepted, sliding) = (self.accepted.clone(), self.sliding.clone());
        History { largest, dissipated, accepted, sliding }
    }

    /// Goes back to what was kept from an earlier state. Local.
    pub(in crate::solve) fn go_back_to(&mut self, history: History) {
        self.committed = history.largest;
        self.dissipated = history.dissipated;
        self.accepted = history.accepted;
        self.sliding = history.sliding;
    }

    /// Makes the last evaluated state the accepted one.
    pub fn commit(&mut self, all: &Discretization) {
        for index in 0..self.response.len() {
            let (jump, to) = (self.response[index].jump, self.response[index].history);
            let (before, from) = (self.dissipated[index], self.committed[index]);
            let (law, jump) = (self.law_at(index, &all.secondary[index]), to_local(jump, self.dim));
            self.dissipated[index] = law.dissipated_after(before, from, to, jump);
            self.committed[index] = to;
            let (rows, mut sliding) = (&all.secondary[index], self.sliding[index]);
            sliding.go_on(self.law_at(index, rows), rows, &self.reached(index));
            self.sliding[index] = sliding;
        }
        self.take_tractions(all);
    }
}

/// How much smaller an augmented traction is taken at least, so that it does not break.
const LEAST_PART: f64 = 1e-30;

fn holds(branch: Branch) -> bool {
    matches!(branch, Branch::Stick | Branch::StickClosed)
}

fn is_broken(branch: Branch) -> bool {
    matches!(branch, Branch::Broken | Branch::BrokenClosed)
}

/// What a law answered to, by displacement component.
struct Asked {
    /// Traction that the bulk transmits (Pa).
    traction: [f64; 3],
    /// Jump of the displacement (m).
    jump: [f64; 3],
    /// Augmented traction at which the law answered, less that of traction and jump (Pa).
    shift: [f64; 3],
}

/// Puts the law's answer into displacement components; components without a multiplier take no
/// part.
fn combine(
    rows: &JumpRows<u32>,
    asked: &Asked,
    answer: &Response,
    augmentation: f64,
    dim: usize,
) -> NodeResponse {
    let Asked { traction, jump, shift } = *asked;
    let (mut defect, mut law_traction) = ([0.0; 3], [0.0; 3]);
    let mut state = NodeState { stuck: [false; 3], ..NodeState::STUCK };
    let mut compliance = [[0.0; 3]; 3];
    let active = |c: usize| c < dim && rows.rows[c].is_some();
    for c in (0..dim).filter(|c| active(*c)) {
        let local = local_index(c, dim);
        state.stuck[c] = answer.stuck[local];
        defect[c] = jump[c] - answer.jump[local];
        state.friction[c] = if active(dim - 1) { answer.friction[local] } else { 0.0 };
        for d in (0..dim).filter(|d| active(*d)) {
            state.tangent[c][d] = answer.tangent[local][local_index(d, dim)];
            compliance[c][d] = answer.compliance[local][local_index(d, dim)];
        }
    }
    for c in (0..dim).filter(|c| active(*c)) {
        law_traction[c] = traction[c];
        if !state.stuck[c] {
            // A^-1 = C + r I on the components that are not stuck.
            let change: f64 = (0..dim)
                .filter(|d| !state.stuck[*d])
                .map(|d| state.tangent[c][d] * defect[d])
                .sum();
            // The normal jump that is wrong changes the normal part of the augmented traction.
            let normal = -state.friction[c] * (shift[dim - 1] + augmentation * defect[dim - 1]);
            law_traction[c] += shift[c] + change + augmentation * defect[c] + normal;
        }
    }
    NodeResponse {
        bulk_traction: traction,
        jump,
        defect,
        law_traction,
        shift,
        state,
        compliance,
        branch: answer.branch,
        history: answer.history,
    }
}

/// Components (x, y, z; x, z in 2D) to the frame (n, t1, t2) of a horizontal interface.
pub fn to_local(v: [f64; 3], dim: usize) -> [f64; 3] {
    if dim == 2 { [v[1], v[0], 0.0] } else { [v[2], v[0], v[1]] }
}

/// Place of a component in the frame (n, t1, t2).
fn local_index(component: usize, dim: usize) -> usize {
    if component + 1 == dim { 0 } else { component + 1 }
}
