//! The films of fluid in the interfaces of one rank: what they store, how they flow, how they push.
//!
//! The opening is the normal jump at the secondary nodes, with the width that is there before
//! anything moves (gaps, and what closed joints conduct), the pressure that of the lips, linear on
//! the corners of the secondary facets. What a node stores counts by the weight of its jump row,
//! which is also what the pressure there pushes on: the two are adjoint, so that the work of the
//! film is exactly what fills it.

use super::Discretization;
use crate::bulk::{BalanceSums, FlowStep, PoroState};
use crate::interface::{Film, FilmState, Fluid};

/// The film at an owned secondary node.
#[derive(Debug, Clone)]
pub struct FilmNode {
    /// Index into `Discretization::secondary`.
    pub secondary: u32,
    /// Opening before anything moves (m).
    pub width: f64,
    /// Local pressure nodes and their parts of the pressure there.
    pub corners: Vec<(u32, f64)>,
}

/// A part of the opening at a node of a facet.
#[derive(Debug, Clone, Copy)]
pub struct Opening {
    /// The place of the node in the facet.
    pub node: u8,
    /// Index into `Discretization::secondary` of the opening.
    pub secondary: u32,
    /// Its part.
    pub part: f64,
}

/// The film in a secondary facet of one of the rank's cells.
#[derive(Debug, Clone)]
pub struct FilmFacet {
    /// Index among the prototypes.
    pub prototype: u32,
    /// What makes up the openings at its nodes; where nothing does they are those before anything
    /// moves.
    pub openings: Vec<Opening>,
    /// Openings at its nodes before anything moves (m).
    pub widths: Vec<f64>,
    /// Local pressure nodes of its corners.
    pub corners: Vec<u32>,
}

/// The films of one rank; empty where fluid flows along no interface.
#[derive(Debug, Clone, Default)]
pub struct Films {
    /// The fluid, of which there is one; on all ranks, also those without a part of a film; none
    /// where fluid flows along no interface.
    pub fluid: Option<Fluid>,
    /// What like facets have in common.
    pub prototypes: Vec<Film>,
    /// Where the films store and push.
    pub nodes: Vec<FilmNode>,
    /// Where they flow.
    pub facets: Vec<FilmFacet>,
}

/// A matrix over local pressure nodes that one cell or facet has.
#[derive(Debug, Clone)]
pub struct PressureBlock {
    /// The nodes.
    pub nodes: Vec<u32>,
    /// Row by row (m3/Pa).
    pub values: Vec<f64>,
}

/// How the balance of the films depends on openings and pressures, at one state and step.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FilmTangent {
    /// By facet: derivatives by its pressures (m3/Pa) and by its openings (m2).
    facets: Vec<[Vec<f64>; 2]>,
    /// By node: derivative by the pressure there (m3/Pa).
    nodes: Vec<f64>,
}

impl Films {
    /// Whether fluid flows along any interface. Local: the same on all ranks.
    pub fn are_there(&self) -> bool {
        self.fluid.is_some()
    }

    /// What displacements open at an entry of `Discretization::secondary` (m).
    fn opening(all: &Discretization, secondary: u32, u: &[f64]) -> f64 {
        all.jump(secondary as usize, all.dim - 1, u)
    }

    /// Weight of its jump row (m2; 2D: m).
    fn weight(all: &Discretization, secondary: u32) -> f64 {
        all.secondary[secondary as usize].rows[all.dim - 1].as_ref().map_or(0.0, |row| row.weight)
    }

    /// The volume between the lips at a node (m3).
    fn held_by(all: &Discretization, node: &FilmNode, u: &[f64]) -> f64 {
        let opening = Self::opening(all, node.secondary, u);
        Self::weight(all, node.secondary) * (opening + node.width)
    }

    /// Value at a node of what stands at the corners.
    fn at(node: &FilmNode, p: &[f64]) -> f64 {
        node.corners.iter().map(|(corner, part)| part * p[*corner as usize]).sum()
    }

    /// Pressure at the films' nodes (Pa), with their indices into `Discretization::secondary`; `p`
    /// is that of all local nodes. Local.
    pub fn pressures<'a>(&'a self, p: &'a [f64]) -> impl Iterator<Item = (u32, f64)> {
        self.nodes.iter().map(|node| (node.secondary, Self::at(node, p)))
    }

    /// Adds the forces of pressures `p` of all local nodes (Pa) on the lips at the local
    /// displacement nodes, not summed (N); above the reference where `absolute`. Local.
    pub fn add_forces(&self, all: &Discretization, p: &[f64], absolute: bool, force: &mut [f64]) {
        let Some(fluid) = &self.fluid else { return };
        let (dim, reference) = (all.dim, if absolute { fluid.reference } else { 0.0 });
        for node in &self.nodes {
            let rows = &all.secondary[node.secondary as usize];
            let Some(row) = &rows.rows[dim - 1] else { continue };
            let push = row.weight * (Self::at(node, p) - reference);
            row.spread(rows.own(dim - 1), push, |unknown, f| force[unknown as usize] += f);
        }
    }

    /// Adds the volume that displacements `u` of all local nodes open at the shares of the local
    /// pressure nodes (m3): the transpose of [`Films::add_forces`]. Local.
    pub fn add_volumes(&self, all: &Discretization, u: &[f64], volume: &mut [f64]) {
        for node in &self.nodes {
            let opened = Self::weight(all, node.secondary) * Self::opening(all, node.secondary, u);
            for (corner, part) in &node.corners {
                volume[*corner as usize] += part * opened;
            }
        }
    }

    /// Adds what the films hold at every local pressure node, and the magnitudes to `sizes` (m3).
    /// Local.
    pub fn add_stored(&self, all: &Discretization, state: PoroState<'_>, sums: BalanceSums<'_>) {
        let Some(fluid) = &self.fluid else { return };
        let PoroState { displacement: u, pressure: p } = state;
        let BalanceSums { rows, sizes } = sums;
        for node in &self.nodes {
            let opened = Self::held_by(all, node, u);
            let held = opened * fluid.density_ratio(Self::at(node, p) - fluid.reference);
            for (corner, part) in &node.corners {
                rows[*corner as usize] += part * held;
                sizes[*corner as usize] += (part * held).abs();
            }
        }
    }

    /// Calls `act` with every facet, its prototype and its state.
    fn each_facet(
        &self,
        all: &Discretization,
        state: PoroState<'_>,
        gravity: &[f64; 3],
        mut act: impl FnMut(&FilmFacet, &Film, &Fluid, FilmState<'_>),
    ) {
        let Some(fluid) = &self.fluid else { return };
        let PoroState { displacement: u, pressure: p } = state;
        let (mut opening, mut pressure) = (Vec::new(), Vec::new());
        for facet in &self.facets {
            let film = &self.prototypes[facet.prototype as usize];
            facet.set_openings(all, u, film.nodes(), &mut opening);
            opening.iter_mut().zip(&facet.widths).for_each(|(w, width)| *w += width);
            pressure.clear();
            pressure.extend(facet.corners.iter().map(|c| p[*c as usize] - fluid.reference));
            let state = FilmState { opening: &opening, pressure: &pressure, gravity: *gravity };
            act(facet, film, fluid, state);
        }
    }

    /// Adds what flows off every local pressure node along the interfaces in the time `length`, and
    /// the magnitudes to `sizes` (m3). Local.
    pub fn add_flow(
        &self,
        all: &Discretization,
        state: PoroState<'_>,
        gravity: &[f64; 3],
        length: f64,
        sums: BalanceSums<'_>,
    ) {
        let BalanceSums { rows, sizes } = sums;
        let (mut own, mut size) = (Vec::new(), Vec::new());
        self.each_facet(all, state, gravity, |facet, film, fluid, state| {
            for of in [&mut own, &mut size] {
                of.clear();
                of.resize(film.corners(), 0.0);
            }
            film.add_flow(fluid, state, length, &mut own, &mut size);
            for (corner, (own, size)) in facet.corners.iter().zip(own.iter().zip(&size)) {
                rows[*corner as usize] += own;
                sizes[*corner as usize] += size;
            }
        });
    }

    /// The derivatives of the balance at the end of a step, but for those by the openings of what
    /// is stored, which [`Films::add_volumes`] has. Local.
    pub fn linearise(
        &self,
        all: &Discretization,
        state: PoroState<'_>,
        step: &FlowStep,
    ) -> FilmTangent {
        let Some(fluid) = &self.fluid else { return FilmTangent::default() };
        let PoroState { displacement: u, pressure: p } = state;
        let stored = |node: &FilmNode| {
            let opened = Self::held_by(all, node, u);
            let ratio = fluid.density_ratio(Self::at(node, p) - fluid.reference);
            (opened * ratio * fluid.compressibility).max(0.0)
        };
        let mut tangent =
            FilmTangent { facets: Vec::new(), nodes: self.nodes.iter().map(stored).collect() };
        let length = step.theta * step.length;
        self.each_facet(all, state, &step.gravity, |_, film, fluid, state| {
            tangent.facets.push(film.derivatives(fluid, state, length));
        });
        tangent
    }
}

impl FilmFacet {
    /// What displacements `u` of all local nodes open at its `count` nodes (m).
    fn set_openings(&self, all: &Discretization, u: &[f64], count: usize, out: &mut Vec<f64>) {
        out.clear();
        out.resize(count, 0.0);
        for Opening { node, secondary, part } in &self.openings {
            out[*node as usize] += part * Films::opening(all, *secondary, u);
        }
    }
}

impl FilmTangent {
    /// Adds the products with changes of displacements and pressures, `change` of all local nodes,
    /// at all local pressure nodes (m3). Local.
    pub fn add_product(
        &self,
        films: &Films,
        all: &Discretization,
        change: PoroState<'_>,
        rows: &mut [f64],
    ) {
        let PoroState { displacement: u, pressure: p } = change;
        let mut opened = Vec::new();
        for (facet, [by_pressure, by_opening]) in films.facets.iter().zip(&self.facets) {
            let corners = facet.corners.len();
            let nodes = films.prototypes[facet.prototype as usize].nodes();
            facet.set_openings(all, u, nodes, &mut opened);
            for (a, corner) in facet.corners.iter().enumerate() {
                let of_p = by_pressure[a * corners..][..corners].iter().zip(&facet.corners);
                let of_u = by_opening[a * nodes..][..nodes].iter().zip(&opened);
                rows[*corner as usize] += of_p.map(|(k, n)| k * p[*n as usize]).sum::<f64>()
                    + of_u.map(|(k, w)| k * w).sum::<f64>();
            }
        }
        for (node, stored) in films.nodes.iter().zip(&self.nodes) {
            let more = stored * Films::at(node, p);
            for (corner, part) in &node.corners {
                rows[*corner as usize] += part * more;
            }
        }
    }

    /// The part by the pressures; `yielding` adds to what is stored at an entry of
    /// `Discretization::secondary`. Local.
    pub fn blocks(&self, films: &Films, yielding: impl Fn(u32) -> f64) -> Vec<PressureBlock> {
        let facets = films.facets.iter().zip(&self.facets);
        let of_facet = |(facet, [by_pressure, _]): (&FilmFacet, &[Vec<f64>; 2])| PressureBlock {
            nodes: facet.corners.clone(),
            values: by_pressure.clone(),
        };
        let mut blocks: Vec<PressureBlock> = facets.map(of_facet).collect();
        for (node, stored) in films.nodes.iter().zip(&self.nodes) {
            let entry = stored + yielding(node.secondary);
            let parts = || node.corners.iter().map(|(_, part)| *part);
            let values = parts().flat_map(|a| parts().map(move |b| a * entry * b)).collect();
            let nodes = node.corners.iter().map(|(corner, _)| *corner).collect();
            blocks.push(PressureBlock { nodes, values });
        }
        blocks
    }
}
