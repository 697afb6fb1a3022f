//! The command `column-hpc`: reads the command line, and ends with the status that `run` gives.

use column_hpc::{cli, run};

fn main() -> std::process::ExitCode {
    match cli::parse(std::env::args().collect()) {
        Ok(command) => run::execute(&command).into(),
        Err(exit) => {
            run::print_exit(&exit);
            exit.status.into()
        }
    }
}
