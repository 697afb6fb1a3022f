//! What is not yet available on the mesh of a file: one list, to be shortened.

use super::LATER;
use super::checker::Checker;
use crate::case::InterfaceSpec;
use crate::case::sections::Linear;
use crate::case::sections::file::CaseFile;

impl Checker<'_> {
    /// Refuses what is not yet available; `has_pressure` tells whether a pore pressure is computed
    /// or acts as a load.
    pub(super) fn not_yet_on_files(
        &mut self,
        file: &CaseFile,
        interfaces: &[InterfaceSpec],
        has_pressure: bool,
    ) {
        let films = interfaces.iter().enumerate().filter(|(_, i)| i.film.is_some());
        let films: Vec<String> = films.map(|(i, _)| format!("interfaces.{i}.fluid")).collect();
        for path in films {
            self.add(&path, format!("flow along an interface {LATER} on the mesh of a file"));
        }
        if has_pressure {
            let reason = format!(
                "with a pore pressure {LATER}; without porous data, or with physics: mechanics, it is \
                 left out"
            );
            self.add("mesh.file", reason);
        }
        if file.solver.linear == Linear::Multigrid && file.mesh.refine == 0 {
            let reason = "multigrid needs coarser meshes, which the mesh of a file has where \
                          mesh.refine makes it finer; take auto, gamg, hypre or mumps";
            self.add("solver.linear", reason.to_owned());
        }
    }
}
