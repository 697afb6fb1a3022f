//! The proof that the states of a smaller model are those of the model asked for.

use super::bound::{size_over_strain, size_over_values, stiffness_over_strain};
use super::forces::add_forces;
use super::lips::Lips;
use super::refusal::loads_at;
use super::{Prolongation, Snapshot};
use crate::case::{Case, SurfaceBit};
use crate::comm::Comm;
use crate::error::{Error, Result};
use crate::solve::{BoundaryValueProblem, reactions};

/// Differences of this size, over the largest value, are rounding.
const ROUNDING: f64 = 1e-12;
/// Likewise of states of linear problems, which are combined from each other.
const SAME: f64 = 64.0 * f64::EPSILON;

/// So many states are looked at for what others have in common with them.
const MOST_DIRECTIONS: usize = 32;

/// What was shown.
#[derive(Debug, Clone, PartialEq)]
pub struct Proof {
    /// Bound of the error in the energy norm, over the largest energy norm.
    pub error_bound: f64,
    /// What the softening takes of the stiffness against it, at most.
    pub softening: f64,
    /// Evaluations of the residual.
    pub residuals: usize,
    /// Of each state the forces of the supports of the model asked for, as `solve::reactions` has
    /// them.
    pub reactions: Vec<Vec<[f64; 3]>>,
}

/// Shows how far the prolonged states of a smaller model are from those of the model of
/// `asked`. Collective.
///
/// # Errors
/// `Numerics` with what stands in the way; as the loads and prescribed displacements of the case.
pub fn prove(
    comm: &Comm,
    case: &Case,
    asked: &BoundaryValueProblem,
    prolongation: &Prolongation,
    states: &[Snapshot],
) -> Result<Proof> {
    let surfaces = case.supported_bits();
    let proof = Prover { comm, case, asked, prolongation, states, surfaces };
    let lips = Lips { case, asked, prolongation, states };
    let strain = size_over_strain(case, prolongation.wide(), &lips.joints());
    let (softening, strain) = comm.agree_alike(
        lips.softening().and_then(|share| Ok((share, strain?))).map_err(Error::Numerics),
    )?;
    if let Some(why) = proof.differing_supports()? {
        return Err(Error::Numerics(why));
    }
    let defect = proof.jump_defect();
    let Residuals { count: residuals, norm, energy, reactions } = proof.residuals()?;
    if energy == 0.0 {
        return Err(Error::Numerics("nothing is deformed".into()));
    }
    // A lattice has boxes only.
    let boxes = asked.mesh.prototypes.iter();
    let cells = boxes.filter_map(|p| Some((p.geometry.size()?, p.shape.order())));
    let mut least = [size_over_values(case.dim, cells)];
    comm.min(&mut least);
    // |e|^2 <= R.e / (1 - softening) and |e_j| <= sqrt(strain / (stiffness mass)) |e|.
    let amplified = norm * (strain / (stiffness_over_strain(case) * least[0])).sqrt();
    let error_bound = (amplified / ((1.0 - softening) * energy)).max(defect);
    let in_space = |sums: &Vec<f64>| sums.chunks_exact(3).map(|s| [s[0], s[1], s[2]]).collect();
    let reactions = reactions.iter().map(in_space).collect();
    Ok(Proof { error_bound, softening, residuals, reactions })
}

/// What the residuals of all states show.
struct Residuals {
    /// How many were evaluated.
    count: usize,
    /// The largest 2-norm (N).
    norm: f64,
    /// The largest energy norm (J^1/2).
    energy: f64,
    /// Of each state, the sums of the forces of the supports (N).
    reactions: Vec<Vec<f64>>,
}

/// The residual of one state.
struct Residual {
    /// 2-norm where nothing is prescribed (N).
    norm: f64,
    /// Energy norm of the state (J^1/2).
    energy: f64,
    /// Sums of the forces of the supports (N).
    reactions: Vec<f64>,
}

struct Prover<'p> {
    comm: &'p Comm,
    case: &'p Case,
    asked: &'p BoundaryValueProblem,
    prolongation: &'p Prolongation,
    states: &'p [Snapshot],
    /// Those that prescribe a displacement.
    surfaces: Vec<SurfaceBit>,
}

impl Prover<'_> {
    /// What is prescribed and not met by the prolonged states, in words. Collective.
    fn differing_supports(&self) -> Result<Option<String>> {
        let found = self.comm.agree(self.first_not_met())?;
        let differs = self.comm.any(found.is_some());
        let elsewhere = || "a prescribed displacement is not met".to_owned();
        Ok(differs.then(|| found.unwrap_or_else(elsewhere)))
    }

    /// The first displacement of this rank's that is prescribed and not met, in words. Local.
    fn first_not_met(&self) -> Result<Option<String>> {
        let BoundaryValueProblem { all, supports, .. } = self.asked;
        let prescribed = &supports.prescribed;
        let held = || (0..all.nodes.owned).filter(|node| all.prescribed[*node] != [false; 3]);
        let names: Vec<u64> = held().map(|node| all.nodes.names[node]).collect();
        let places: Vec<_> = held().map(|node| all.nodes.points[node]).collect();
        let entries: Vec<_> =
            held().map(|node| prescribed.entries_of(&all.nodes.marks[node])).collect();
        for state in self.states {
            let largest = largest(&state.displacement);
            let u = self.prolongation.apply(&names, &state.displacement);
            for (component, u) in u.iter().enumerate() {
                let (node, c) = (component / all.dim, component % all.dim);
                let Some(entry) = entries[node][c] else { continue };
                let value = prescribed.value(entry, c, places[node], state.time)?;
                if (value - u).abs() > ROUNDING * largest {
                    let (surface, time) = (prescribed.surface(entry), state.time);
                    return Ok(Some(format!(
                        "at time {time} {value:e} m are prescribed on {surface} where the smaller \
                         model has {u:e} m"
                    )));
                }
            }
        }
        Ok(None)
    }

    /// The largest difference of the jump, and of the tractions that are interpolated, from those
    /// that the law has answered with, over their scales. Collective.
    fn jump_defect(&self) -> f64 {
        let all = &self.asked.all;
        let dim = all.dim;
        let secondary = &all.secondary[..all.owned_secondary()];
        let mut nodes: Vec<u32> = secondary.iter().flat_map(|rows| rows.nodes()).collect();
        nodes.sort_unstable();
        nodes.dedup();
        let names: Vec<u64> = nodes.iter().map(|n| all.nodes.names[*n as usize]).collect();
        let scale = self.states.iter().map(|s| largest(&s.displacement)).fold(0.0, f64::max);
        let stress = self.largest_traction();
        let mut u = vec![0.0; all.nodes.len() * dim];
        let mut defect = 0.0_f64;
        for state in self.states {
            let values = self.prolongation.apply(&names, &state.displacement);
            for (node, value) in nodes.iter().zip(values.chunks_exact(dim)) {
                u[*node as usize * dim..][..dim].copy_from_slice(value);
            }
            for (index, rows) in secondary.iter().enumerate() {
                let law = self.case.interfaces[rows.interface].law.law();
                let length = law.typical_jump().unwrap_or(scale);
                let name = all.nodes.names[rows.node as usize];
                self.prolongation.parents(name, |parent, _| {
                    let Some(parent) = &state.interface[parent] else { return };
                    for c in (0..dim).filter(|c| rows.rows[*c].is_some()) {
                        let jump = all.jump(index, c, &u) - parent.response.jump[c];
                        defect = defect.max(jump.abs() / length);
                    }
                });
                let traction = self.traction(state, name);
                self.prolongation.parents(name, |parent, _| {
                    let Some(parent) = &state.interface[parent] else { return };
                    for (c, traction) in traction.iter().enumerate().take(dim) {
                        let off = (parent.response.law_traction[c] - traction).abs();
                        defect =
                            defect.max(if off > ROUNDING * stress { off / stress } else { 0.0 });
                    }
                });
            }
        }
        let mut defect = [defect];
        self.comm.max(&mut defect);
        defect[0]
    }

    /// The traction that the states give a node (Pa). Local.
    fn traction(&self, state: &Snapshot, name: u64) -> [f64; 3] {
        let mut sum = [0.0; 3];
        self.prolongation.parents(name, |parent, weight| {
            if let Some(parent) = &state.interface[parent] {
                (0..3).for_each(|c| sum[c] += weight * parent.response.law_traction[c]);
            }
        });
        sum
    }

    fn largest_traction(&self) -> f64 {
        let nodes = self.states.iter().flat_map(|s| s.interface.iter().flatten());
        nodes.map(|n| largest(&[n.response.law_traction])).fold(0.0, f64::max)
    }

    /// The residuals of all states. Collective.
    ///
    /// A residual is linear in displacements, tractions and loads, and does not feel translations
    /// of a body: states that are combinations of others need no evaluation.
    fn residuals(&self) -> Result<Residuals> {
        let mut rest: Vec<Vec<f64>> = self.states.iter().map(|s| self.stacked(s)).collect();
        // Of each state: the bound of its residual by its parts along the directions so far.
        let mut parts = vec![0.0; rest.len()];
        // And the forces of the supports by the same parts.
        let mut reactions = vec![vec![0.0; 3 * (self.surfaces.len() + 1)]; rest.len()];
        let (mut count, mut norm, mut energy) = (0, 0.0_f64, 0.0_f64);
        let size = |v: &[f64]| dot(v, v).sqrt();
        let largest = rest.iter().map(|v| size(v)).fold(0.0, f64::max);
        loop {
            let sizes: Vec<f64> = rest.iter().map(|v| size(v)).collect();
            let pick = (0..rest.len()).max_by(|a, b| sizes[*a].total_cmp(&sizes[*b]));
            let pick = pick.filter(|p| sizes[*p] > SAME * largest);
            // Rounding on other machines must not send ranks different ways.
            let mine = pick.filter(|_| self.comm.is_root()).map_or(0, |p| p as u64 + 1);
            let Some(pick) = self.comm.max_u64(mine).checked_sub(1) else { break };
            let pick = pick as usize;
            let Residual { norm: found, energy: own, reactions: of_supports } =
                self.residual(&self.states[pick])?;
            (count, norm, energy) = (count + 1, norm.max(found), energy.max(own));
            if count > MOST_DIRECTIONS {
                // States without much in common.
                rest[pick].fill(0.0);
                (parts[pick], reactions[pick]) = (found, of_supports);
                continue;
            }
            // The direction is the state less its parts along the others.
            let length = size(&rest[pick]);
            let of_direction = (found + parts[pick]) / length;
            let direction: Vec<f64> = rest[pick].iter().map(|x| x / length).collect();
            let known = &reactions[pick];
            let supports: Vec<f64> =
                of_supports.iter().zip(known).map(|(own, known)| (own - known) / length).collect();
            for ((rest, parts), sums) in rest.iter_mut().zip(&mut parts).zip(&mut reactions) {
                let along = dot(rest, &direction);
                *parts += along.abs() * of_direction;
                sums.iter_mut().zip(&supports).for_each(|(sum, force)| *sum += along * force);
                rest.iter_mut().zip(&direction).for_each(|(r, d)| *r -= along * d);
            }
            rest[pick].fill(0.0);
            (parts[pick], reactions[pick]) = (found, of_supports);
        }
        let norm = parts.into_iter().fold(norm, f64::max);
        Ok(Residuals { count, norm, energy, reactions })
    }

    /// Displacements less the translation of each body, tractions and loads of a state, all in Pa.
    /// Local.
    fn stacked(&self, state: &Snapshot) -> Vec<f64> {
        let modulus = self.case.materials.iter().map(|m| m.young_modulus).fold(0.0, f64::max);
        let scale = modulus / self.asked.mesh.facts.size[2];
        let displacement = self.without_translations(state);
        let tractions = state.interface.iter().flatten().flat_map(|n| n.response.law_traction);
        let strains = displacement.into_iter().flatten().map(|u| scale * u);
        strains.chain(tractions).chain(loads_at(self.case, state.time)).collect()
    }

    /// The displacements of a state less those of one node of each body (m). Local.
    fn without_translations(&self, state: &Snapshot) -> Vec<[f64; 3]> {
        let mut displacement = state.displacement.clone();
        let mut first = 0;
        for (node, own) in displacement.iter_mut().enumerate() {
            if self.prolongation.body_of(node) != self.prolongation.body_of(first) {
                first = node;
            }
            own.iter_mut().zip(state.displacement[first]).for_each(|(u, of_first)| *u -= of_first);
        }
        displacement
    }

    /// The residual of a prolonged state. Collective.
    fn residual(&self, state: &Snapshot) -> Result<Residual> {
        let BoundaryValueProblem { all, loads, .. } = self.asked;
        let dim = all.dim;
        let mut force = vec![0.0; all.nodes.len() * dim];
        let displacement = self.without_translations(state);
        let energy = add_forces(self.asked, self.prolongation, &displacement, &mut force);
        let added = loads.add(state.time, |name, component, load| {
            let node = all.nodes.local(name).expect("loads act on the rank's own cells") as usize;
            force[node * dim + component] -= load;
        });
        self.comm.agree(added)?;
        all.nodes.add_to_owners(&mut force, dim);
        let traction = |index: usize, c: usize| {
            self.traction(state, all.nodes.names[all.secondary[index].node as usize])[c]
        };
        let mut on_lips = vec![0.0; force.len()];
        all.add_tractions(traction, &mut on_lips);
        force.iter_mut().zip(&on_lips).for_each(|(force, on_lips)| *force += on_lips);
        let at = |node: usize, c: usize| force[node * dim + c];
        let of_support = |node: usize, c: usize| all.prescribed[node][c].then(|| at(node, c));
        let supports = reactions(all, &self.surfaces, of_support);
        let mut sums = [vec![0.0, energy], supports.into_flattened()].concat();
        for node in 0..all.nodes.owned {
            let free = (0..dim).filter(|c| !all.prescribed[node][*c]);
            sums[0] += free.map(|c| at(node, c).powi(2)).sum::<f64>();
        }
        self.comm.sum(&mut sums);
        let reactions = sums.split_off(2);
        Ok(Residual { norm: sums[0].sqrt(), energy: sums[1].max(0.0).sqrt(), reactions })
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn largest(values: &[[f64; 3]]) -> f64 {
    values.iter().flatten().fold(0.0, |m, v| m.max(v.abs()))
}
