//! What pressures push and displacements open: one is the transpose of the other.

use super::PoreSpace;
use crate::assembly::Discretization;
use crate::bulk::{MAX_CORNERS, PorousCell};
use crate::simd::{Kernel, widest};

/// [`PoreSpace::add_cell_forces`].
struct CellForces<'a> {
    pores: &'a PoreSpace,
    all: &'a Discretization,
    p: &'a [f64],
    absolute: bool,
    force: &'a mut [f64],
}

impl Kernel for CellForces<'_> {
    #[inline(always)]
    fn run(self) {
        self.pores.add_cell_forces(self.all, self.p, self.absolute, self.force);
    }
}

/// [`PoreSpace::add_cell_volumes`].
struct CellVolumes<'a> {
    pores: &'a PoreSpace,
    all: &'a Discretization,
    u: &'a [f64],
    volume: &'a mut [f64],
}

impl Kernel for CellVolumes<'_> {
    #[inline(always)]
    fn run(self) {
        self.pores.add_cell_volumes(self.all, self.u, self.volume);
    }
}

impl PoreSpace {
    /// Adds the forces of the pressures `p` of all local nodes (Pa) on the unknowns of the local
    /// displacement nodes (N), in the pores and on the lips; above the references where `absolute`.
    /// Local.
    pub fn add_forces(&self, all: &Discretization, p: &[f64], absolute: bool, force: &mut [f64]) {
        self.films.add_forces(all, p, absolute, force);
        if all.frames.is_empty() {
            return widest(CellForces { pores: self, all, p, absolute, force });
        }
        let mut of_cells = vec![0.0; force.len()];
        widest(CellForces { pores: self, all, p, absolute, force: &mut of_cells });
        all.frames.fold(&mut of_cells);
        force.iter_mut().zip(of_cells).for_each(|(f, of_cells)| *f += of_cells);
    }

    #[inline(always)]
    fn add_cell_forces(&self, all: &Discretization, p: &[f64], absolute: bool, force: &mut [f64]) {
        let mut of_cell = Vec::new();
        for cell in &self.cells {
            let np = cell.corners().len();
            let like = &self.prototypes[cell.prototype as usize];
            let reference = if absolute { like.medium.reference } else { 0.0 };
            let p = self.pressures(cell, p, reference);
            if p[..np].iter().all(|p| *p == 0.0) {
                continue;
            }
            let nodes = all.cells.nodes(cell.cell as usize);
            of_cell.clear();
            of_cell.resize(nodes.len() * self.dim, 0.0);
            like.add_force(&p[..np], &mut of_cell);
            for (node, f) in nodes.iter().zip(of_cell.chunks_exact(self.dim)) {
                let target = &mut force[*node as usize * self.dim..][..self.dim];
                target.iter_mut().zip(f).for_each(|(t, f)| *t += f);
            }
        }
    }

    /// The largest sum of the magnitudes of what displacements of 1 m add to the balance at a node
    /// of this rank's cells (m3/m). Local.
    pub fn largest_coupling(&self) -> f64 {
        let at = |cell: &PorousCell, corner: usize| {
            let corners = cell.corners();
            cell.coupling().iter().skip(corner).step_by(corners).map(|k| k.abs()).sum::<f64>()
        };
        let all = |cell: &PorousCell| {
            (0..cell.corners()).map(|corner| at(cell, corner)).fold(0.0, f64::max)
        };
        // As many boxes meet at a node; of other cells it may be more.
        let mut meeting = vec![0_u32; self.nodes.len()];
        for node in self.cells.iter().flat_map(|cell| cell.corners()) {
            meeting[*node as usize] += 1;
        }
        let most = meeting.into_iter().fold(1 << self.dim, u32::max);
        f64::from(most) * self.prototypes.iter().map(all).fold(0.0, f64::max)
    }

    /// Adds b times the volume that the unknowns `u` of all local nodes make in cells, and the
    /// volume that opens between lips, at the shares of the local pressure nodes (m3): the
    /// transpose of [`PoreSpace::add_forces`]. Local.
    pub fn add_volumes(&self, all: &Discretization, u: &[f64], volume: &mut [f64]) {
        self.films.add_volumes(all, u, volume);
        let u = &*all.frames.displacements(u);
        widest(CellVolumes { pores: self, all, u, volume });
    }

    #[inline(always)]
    fn add_cell_volumes(&self, all: &Discretization, u: &[f64], volume: &mut [f64]) {
        let mut of_cell = Vec::new();
        for cell in self.cells.iter().filter(|cell| self.is_free(cell)) {
            self.gather(all, cell, u, &mut of_cell);
            let mut own = [0.0; MAX_CORNERS];
            let like = &self.prototypes[cell.prototype as usize];
            like.add_volume(&of_cell, &mut own);
            for (node, v) in cell.corners().iter().zip(&own) {
                volume[*node as usize] += v;
            }
        }
    }
}
