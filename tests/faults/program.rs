//! The program with faults on demand: the command `column-hpc` for tests of failures.

mod injector;

use column_hpc::{cli, fault, run};

fn main() -> std::process::ExitCode {
    fault::inject(injector::strike);
    match cli::parse(std::env::args().collect()) {
        Ok(command) => run::execute(&command).into(),
        Err(exit) => {
            run::print_exit(&exit);
            exit.status.into()
        }
    }
}
