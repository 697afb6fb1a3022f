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
        read_tree(tree, Path::new(NAME), Problems::new(Path::new(NAME), &[]))
    }

    /// The sections that the case was made of, with every default written out: to build another
    /// case of them.
    pub fn sections(&self) -> &CaseFile {
        &self.file
    }
}
