//! A case that is built in code.

use std::path::Path;

use super::sections::CaseFile;
use super::{Case, read_tree};
use crate::error::{Error, Result};
use crate::input::problems::Problems;
use crate::input::text::LARGEST;
use crate::input::tree::Node;

/// Longest case, as JSON in bytes: that of the largest file, with every default written out, is
/// shorter.
const LONGEST: u64 = 8 * LARGEST;

/// What stands for the name of the file: the title and the output directory come of it where none
/// is given.
const NAME: &str = "case";

impl Case {
    /// Checks what was built in code as a file is checked: the same sections give the same case.
    /// The title is `case`, the output directory `results/case` where none is given. Local.
    ///
    /// # Errors
    /// [`Error::Input`] with one line for each mistake: path, reason.
    pub fn build(sections: CaseFile) -> Result<Case> {
        let refused = |reason: String| Error::Input(format!("the case: {reason}"));
        // A number that is not finite becomes null.
        let json = serde_json::to_value(&sections).map_err(|error| refused(error.to_string()))?;
        let bytes = json.to_string().len();
        if bytes as u64 > LONGEST {
            return Err(refused(format!("its sections have {bytes} bytes; at most {LONGEST} go")));
        }
        let tree = Node::from_json(&json).map_err(Error::Input)?;
        read_tree(tree, Path::new(NAME), Problems::new(Path::new(NAME), &[]), None)
    }

    /// The case of a mesh file that has been read and has `dim` dimensions, 2 (in the plane z = 0)
    /// or 3: its components, columns and expectations are final. A column knows its dimension
    /// itself. Local.
    ///
    /// # Errors
    /// [`Error::Input`] with one line for each mistake: components and points that such a mesh does
    /// not have, expectations of what there is not.
    pub fn for_dimension(self, dim: usize) -> Result<Case> {
        if self.knows_dimension && self.dim == dim {
            return Ok(self);
        }
        if self.mesh.file().is_none() || !(2..=3).contains(&dim) {
            return Err(Error::Bug(format!("a mesh in {dim}D for a case in {}D", self.dim)));
        }
        let tree = Node::from_json(&self.resolved()).map_err(Error::Input)?;
        let name = Path::new(NAME);
        let mut case = read_tree(tree, name, Problems::new(name, &[]), Some(dim))?;
        // Its path is relative to the folder of the case file.
        for (stage, before) in case.stages.iter_mut().zip(&self.stages) {
            stage.case.mesh.clone_from(&self.mesh);
            stage.case.search_as(&before.case);
        }
        case.search_as(&self);
        case.mesh = self.mesh;
        Ok(case)
    }

    /// Takes over what a search for accuracy has set beside the mesh.
    fn search_as(&mut self, other: &Case) {
        self.solver.tolerance = other.solver.tolerance;
        self.search.clone_from(&other.search);
        if let (Some(own), Some(flow)) = (&mut self.flow, &other.flow) {
            own.tolerance = flow.tolerance;
        }
    }

    /// Whether the dimension of the mesh is known; that of a mesh file is told to
    /// [`Case::for_dimension`].
    pub fn knows_dimension(&self) -> bool {
        self.knows_dimension
    }

    /// The sections that the case was made of, with every default written out: to build another
    /// case of them.
    pub fn sections(&self) -> &CaseFile {
        &self.file
    }
}
