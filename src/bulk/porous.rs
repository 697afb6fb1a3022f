//! Saturated porous media: the fluid that a volume stores.
//!
//! Pressures are those above the reference pressure of the material, at which the undeformed
//! skeleton carries nothing. Masses are divided by the reference density of the fluid: volumes in
//! m3 (2D: per metre of thickness).

use super::Elastic;
use crate::case::{Material, Porous};

/// exp(x) - 1, which beyond x = 1 goes on along its tangent: no fluid is pressed to its bulk
/// modulus, but an iterate of Newton's method may be, and has to stay finite.
pub fn exp_m1_on_its_tangent(x: f64) -> f64 {
    if x > 1.0 { std::f64::consts::E * x - 1.0 } else { x.exp_m1() }
}

/// The constants of one material.
#[derive(Debug, Clone, Copy)]
pub struct PorousMedium {
    /// Biot coefficient b.
    pub biot: f64,
    /// Porosity phi_0 of the undeformed state.
    pub porosity: f64,
    /// Compressibility 1/K_w of the fluid (1/Pa).
    pub fluid: f64,
    /// Compressibility 1/K_s of the grains (1/Pa).
    pub grains: f64,
    /// Permeability over viscosity k/mu (m2/(Pa s)).
    pub mobility: f64,
    /// Density of the fluid at the reference pressure (kg/m3).
    pub density: f64,
    /// Reference pressure (Pa).
    pub reference: f64,
    /// Oedometric modulus lambda + 2 mu of the skeleton (Pa).
    pub oedometric: f64,
    /// Drained bulk modulus of the skeleton (Pa), in 2D that of plane strain, lambda + mu.
    pub drained: f64,
}

impl PorousMedium {
    /// The constants of a material with porous data, in 2 or 3 dimensions.
    pub fn new(material: &Material, porous: &Porous, dim: usize) -> Self {
        let Elastic { lambda, mu } = Elastic::new(material.young_modulus, material.poisson_ratio);
        Self {
            biot: porous.biot,
            porosity: porous.porosity,
            fluid: porous.fluid_compressibility,
            grains: (1.0 - porous.biot) / (lambda + 2.0 / 3.0 * mu),
            mobility: porous.permeability / porous.viscosity,
            density: porous.fluid_density,
            reference: porous.reference_pressure,
            oedometric: lambda + 2.0 * mu,
            drained: lambda + 2.0 * mu / dim as f64,
        }
    }

    /// phi = b - (b - phi_0) exp(-eps - p/K_s) at volumetric strain and pressure.
    pub fn porosity_at(&self, strain: f64, pressure: f64) -> f64 {
        self.porosity + self.widening(strain, pressure)
    }

    /// phi - phi_0, without cancellation.
    fn widening(&self, strain: f64, pressure: f64) -> f64 {
        -(self.biot - self.porosity) * exp_m1_on_its_tangent(-strain - pressure * self.grains)
    }

    /// rho / rho_0 = exp(p/K_w).
    pub fn density_ratio(&self, pressure: f64) -> f64 {
        1.0 + exp_m1_on_its_tangent(pressure * self.fluid)
    }

    /// The fluid in a volume that was 1 when undeformed, beyond what it held then, over the
    /// reference density: the change of rho phi (1 + eps) at volumetric strain and pressure,
    /// without cancellation.
    pub fn content(&self, strain: f64, pressure: f64) -> f64 {
        let denser = exp_m1_on_its_tangent(pressure * self.fluid);
        let wider = self.widening(strain, pressure);
        let grown = denser + strain + denser * strain;
        (1.0 + denser) * (1.0 + strain) * wider + self.porosity * grown
    }

    /// phi_0/K_w + (b - phi_0)/K_s (1/Pa): the derivative of the content by the pressure at rest.
    pub fn storage(&self) -> f64 {
        self.porosity * self.fluid + (self.biot - self.porosity) * self.grains
    }

    /// What the skeleton yields to a pressure (1/Pa): b^2 over the geometric mean of the drained
    /// bulk modulus, for motions that are free, and the oedometric one, for motions that are not.
    pub fn yielding(&self) -> f64 {
        self.biot * self.biot / (self.drained * self.oedometric).sqrt()
    }

    /// Consolidation coefficient c_v (m2/s).
    pub fn consolidation(&self) -> f64 {
        self.mobility / (self.storage() + self.biot * self.biot / self.oedometric)
    }
}
