//! What is not yet available on the mesh of a file: one list, to be shortened.

use super::checker::Checker;
use crate::case::sections::Linear;
use crate::case::sections::file::CaseFile;

impl Checker<'_> {
    /// Refuses what is not yet available.
    pub(super) fn not_yet_on_files(&mut self, file: &CaseFile) {
        if file.solver.linear == Linear::Multigrid && file.mesh.refine == 0 {
            let reason = "multigrid needs coarser meshes, which the mesh of a file has where \
                          mesh.refine makes it finer; take auto, gamg, hypre or mumps";
            self.add("solver.linear", reason.to_owned());
        }
    }
}
