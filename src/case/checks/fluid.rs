//! Fluid in interfaces: imposed, connected with the pores, or flowing along them.

use super::checker::Checker;
use crate::case::sections::quantity::FluidSection;
use crate::case::sections::{FilmSpec, Material};
use crate::case::{ColumnSpec, InterfaceSpec};
use crate::error::number_text;

impl Checker<'_> {
    /// Puts the fluid of the section at `path` into an interface.
    pub(super) fn fluid(
        &mut self,
        path: &str,
        fluid: &FluidSection,
        interface: &mut InterfaceSpec,
    ) {
        let flows = fluid.flow || fluid.injection.is_some();
        interface.connected = fluid.connected;
        let pressure = fluid.pressure.as_ref();
        interface.fluid_pressure = pressure.map(|p| self.value(&format!("{path}.pressure"), p));
        if flows {
            let injection = fluid.injection.as_ref();
            let injection = injection.map(|i| self.value(&format!("{path}.injection"), i));
            interface.film = Some(FilmSpec { injection });
            for (key, given) in [("pressure", pressure.is_some()), ("connected", fluid.connected)] {
                if given {
                    let reason = "cannot stand beside flow and injection, where the pressure is to be \
                                  found";
                    self.add(&format!("{path}.{key}"), reason);
                }
            }
        } else if pressure.is_none() {
            self.add(path, "needs pressure, flow: true or injection");
        }
    }

    /// Where fluid flows along an interface it also flows into both sides.
    pub(super) fn films(
        &mut self,
        column: &ColumnSpec,
        materials: &[Material],
        interfaces: &[InterfaceSpec],
    ) {
        let at = |z: f64| {
            let is_there = |m: &&Material| m.z.is_none_or(|[low, high]| low <= z && z < high);
            materials.iter().find(is_there)
        };
        let mut fluid: Option<(&str, f64)> = None;
        for (index, interface) in interfaces.iter().enumerate() {
            let Some(z) = interface.height().filter(|_| interface.film.is_some()) else { continue };
            let path = format!("interfaces.{index}.fluid");
            let ends = materials.iter().filter_map(|m| m.z).flatten();
            let below = ends.filter(|end| *end < z).fold(0.0, f64::max);
            let beside = [at(0.5 * (below + z)), at(z.min(column.height()))];
            for material in beside.into_iter().flatten() {
                let Some(porous) = &material.porous else {
                    let reason = format!(
                        "flows along the interface and into both sides, but {} has no porous data \
                         (materials.{0}.porous)",
                        material.name
                    );
                    self.add(&path, reason);
                    continue;
                };
                let (name, viscosity) = *fluid.get_or_insert((&material.name, porous.viscosity));
                if viscosity != porous.viscosity {
                    let reason = format!(
                        "is {}, but {} in {name}: one fluid flows along the interface and in its sides",
                        number_text(porous.viscosity),
                        number_text(viscosity),
                    );
                    self.add(&format!("materials.{}.porous.viscosity", material.name), reason);
                }
            }
        }
    }
}
