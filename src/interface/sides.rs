//! Which side of an interface carries the multipliers.

use crate::case::{Case, InterfaceSpec, Side, SurfaceBit};
use crate::mesh::{Lip, LipFacts, Marks, MeshFacts};

/// The two sides of one interface: which lip is which.
#[derive(Debug, Clone, Copy)]
pub struct Sides {
    /// The interface, by its index.
    pub interface: usize,
    /// The lip that carries the multipliers.
    pub secondary: Lip,
    /// Whether the sides may lie apart.
    pub has_gap: bool,
}

impl Sides {
    /// The sides of every interface: the secondary one as the case says, else the one of which
    /// fewer facets are held, else the softer side, else the one with more nodes, else the upper
    /// one.
    ///
    /// Where the displacement of a side is prescribed it carries no multiplier: on the whole of it,
    /// as that of a stamp, nothing would be transmitted.
    /// A stiff and coarse secondary side makes the condensed matrix harder for multigrid.
    pub fn choose(case: &Case, mesh: &MeshFacts) -> Vec<Self> {
        let choose = |(interface, spec): (usize, &InterfaceSpec)| {
            let about = |lip: &LipFacts| {
                let nodal =
                    lip.cell[0] * lip.cell[1] / (lip.order as f64).powi(mesh.dim as i32 - 1);
                (case.materials[lip.material].young_modulus, nodal)
            };
            let [below, above] = mesh.interfaces[interface].each_ref().map(about);
            let lower_is_softer_or_finer =
                below.0 < above.0 || (below.0 == above.0 && below.1 < above.1 * (1.0 - 1e-9));
            let held = mesh.interfaces[interface].map(|lip| held(case, &lip));
            let secondary = match spec.secondary {
                Some(Side::Lower) => Lip::Lower,
                None if held[0] < held[1] => Lip::Lower,
                None if held[0] > held[1] => Lip::Upper,
                None if lower_is_softer_or_finer => Lip::Lower,
                _ => Lip::Upper,
            };
            Self { interface, secondary, has_gap: spec.has_gap }
        };
        case.interfaces.iter().enumerate().map(choose).collect()
    }

    /// The lip that carries no multipliers.
    pub fn primary(&self) -> Lip {
        self.secondary.other()
    }

    /// Sign of the secondary displacement in the jump (upper minus lower).
    pub fn sign(&self) -> f64 {
        match self.secondary {
            Lip::Lower => -1.0,
            Lip::Upper => 1.0,
        }
    }

    /// Whether a node lies on the secondary side and may carry a multiplier.
    pub fn is_secondary(&self, node: &Marks) -> bool {
        node.is_lip(self.interface, self.secondary) && !node.is_junction
    }

    /// The secondary lip in numbers.
    pub fn secondary_facts<'m>(&self, mesh: &'m MeshFacts) -> &'m LipFacts {
        &mesh.interfaces[self.interface][self.secondary.index()]
    }
}

/// Which part of a lip has prescribed displacements: 0 of no facet, 1 of some facets, 2 the whole.
fn held(case: &Case, lip: &LipFacts) -> u8 {
    let is_held = |surfaces: u128| {
        case.boundary.iter().any(|entry| match case.surface_bit(&entry.on) {
            SurfaceBit::Place(place) if entry.prescribes_displacement() => {
                place < Marks::SURFACES && surfaces >> place & 1 == 1
            }
            _ => false,
        })
    };
    lip.surfaces.iter().map(|surfaces| u8::from(is_held(*surfaces))).sum()
}
