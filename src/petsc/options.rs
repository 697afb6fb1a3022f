//! Which options of PETSc a run takes: not those that run or read something else.

/// What a name must not contain: debuggers, interpreters, other files and libraries, servers.
const REFUSED: [&str; 11] = [
    "debugger",
    "python",
    "matlab",
    "options_file",
    "options_string",
    "options_monitor",
    "petscrc",
    "dll_",
    "saws",
    "stop_for_debugger",
    "mpi_linear_solver_server",
];

/// Types of solvers that call an interpreter.
const REFUSED_VALUES: [&str; 2] = ["python", "matlab"];

/// The first of some words, options and their values, that asks PETSc to run or read something
/// else: an option, or a type of solver that does. Local.
pub fn refused_option<'w>(words: impl Iterator<Item = &'w str>) -> Option<&'w str> {
    let mut name = "";
    for word in words {
        let lower = word.to_ascii_lowercase();
        let is_name = word.starts_with('-') && word.parse::<f64>().is_err();
        if is_name {
            name = word;
            if REFUSED.iter().any(|part| lower.contains(part)) {
                return Some(word);
            }
        } else if name.ends_with("_type") && REFUSED_VALUES.contains(&lower.as_str()) {
            return Some(word);
        }
    }
    None
}

/// The options of a text, names without the dash and values, empty for flags. Local.
pub(super) fn options_in(text: &str) -> Vec<(String, String)> {
    let mut options: Vec<(String, String)> = Vec::new();
    for word in text.split_whitespace() {
        match (word.strip_prefix('-'), options.last_mut()) {
            (Some(name), _) if word.parse::<f64>().is_err() => {
                options.push((name.to_owned(), String::new()));
            }
            (_, Some((_, value))) => {
                let space = if value.is_empty() { "" } else { " " };
                *value += &format!("{space}{word}");
            }
            (_, None) => {}
        }
    }
    options
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_that_run_or_read_other_things_are_refused() {
        let refused = |text: &'static str| refused_option(text.split_whitespace());
        for text in [
            "-start_in_debugger",
            "-ksp_rtol 1e-5 -on_error_attach_debugger gdb",
            "-options_file other",
            "-OPTIONS_FILE_YAML other",
            "-pc_python_type module.Class",
            "-dll_append ./lib.so",
            "-saws_port 8080",
        ] {
            assert!(refused(text).is_some(), "{text}");
        }
        assert_eq!(refused("-ksp_type cg -pc_type python"), Some("python"));
        for text in ["-ksp_view -ksp_rtol 1e-5", "-pc_type hypre -shift -1e-3", "-log_view :python"]
        {
            assert_eq!(refused(text), None, "{text}");
        }
    }

    #[test]
    fn options_have_the_words_up_to_the_next_as_their_values() {
        let found = options_in("-ksp_view -shift -1e-3 -list a b\n");
        let found: Vec<_> = found.iter().map(|(n, v)| (n.as_str(), v.as_str())).collect();
        assert_eq!(found, [("ksp_view", ""), ("shift", "-1e-3"), ("list", "a b")]);
    }
}
