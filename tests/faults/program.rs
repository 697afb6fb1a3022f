//! The program with faults on demand: the command `column-hpc` for tests of failures. As `serve` it
//! runs many cases, one after the other.

mod injector;
mod serve;

use column_hpc::{cli, fault, run};

fn main() -> std::process::ExitCode {
    let words: Vec<String> = std::env::args().collect();
    if let [_, command, folder, owner] = &words[..]
        && command == "serve"
    {
        return serve::serve(folder.as_ref(), owner).into();
    }
    fault::inject(injector::strike);
    match cli::parse(words) {
        Ok(command) => run::execute(&command).into(),
        Err(exit) => {
            run::print_exit(&exit);
            exit.status.into()
        }
    }
}
