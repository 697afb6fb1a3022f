//! From the text of a study to its checked types.

use std::path::Path;
use std::sync::LazyLock;

use serde_json::Value as Json;

use super::charts::chart_of;
use super::check::Checker;
use super::file::StudyFile;
use super::spec::Study;
use crate::error::{Error, Result};
use crate::input::problems::Problems;
use crate::input::schema::{check_against, schema_of};
use crate::input::text::read_text_of;
use crate::input::tree;

static SCHEMA: LazyLock<Json> = LazyLock::new(schema_of::<StudyFile>);

impl Study {
    /// Reads a study file and its base case.
    ///
    /// # Errors
    /// [`Error::Input`] with one line for each mistake: file, line, column, path, reason.
    pub fn read(path: &Path) -> Result<Study> {
        let text = read_text_of("study file", path)?;
        let mut tree = tree::parse(&text).map_err(|error| {
            let place =
                error.place.map_or(String::new(), |(line, column)| format!("{line}:{column}:"));
            Error::Input(format!("{}:{place} {}", path.display(), error.reason))
        })?;
        let mut problems = Problems::new(path, &[]);
        check_against(&SCHEMA, "the study", &mut tree, &mut problems);
        if !problems.is_empty() {
            return Err(problems.into_error());
        }
        let mut file: StudyFile = serde_json::from_value(tree.to_json())
            .map_err(|error| Error::Input(format!("{}: {error}", path.display())))?;
        let mut checker = Checker { tree: &tree, path, problems };
        let sections = std::mem::take(&mut file.charts);
        let mut study = checker.study(file, text);
        for (index, section) in sections.into_iter().enumerate() {
            study.charts.extend(chart_of(&mut checker, &study, index, section));
        }
        if checker.problems.is_empty() { Ok(study) } else { Err(checker.problems.into_error()) }
    }
}
