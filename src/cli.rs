//! The command line.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};

use crate::scene::plot;
use crate::study::Request;

/// What the user asks for.
#[derive(Debug, Clone, PartialEq)]
pub enum Command {
    /// Run a case.
    Run(RunOptions),
    /// Read and check a case, say what will be modelled; solve nothing.
    Check(CheckOptions),
    /// Run a family of cases and chart them.
    Study(Request),
    /// Draw a picture of a finished run.
    Plot(plot::Request),
    /// Print the JSON Schema of the case file.
    Schema,
}

/// The end of the program before anything ran: help, version, or a wrong command line.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Exit {
    /// What is to be printed, once.
    pub text: String,
    /// The exit status.
    pub status: u8,
    /// Whether it goes to stdout (help, version) or to stderr.
    pub to_stdout: bool,
}

/// Options of `run`.
#[derive(Debug, Clone, PartialEq, Eq, Args)]
pub struct RunOptions {
    /// The case file
    #[arg(value_name = "CASE.yaml")]
    pub case: PathBuf,
    /// Set a value of the case: a.b.c=VALUE, with VALUE in YAML; list items count from 0; an
    /// empty VALUE takes the key away. Repeatable
    #[arg(long = "set", value_name = "a.b.c=VALUE")]
    pub overrides: Vec<String>,
    /// The output directory, instead of the case's
    #[arg(long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Replace the results of another case in the output directory
    #[arg(long)]
    pub overwrite: bool,
    /// Print nothing but errors
    #[arg(long, conflicts_with = "verbose")]
    pub quiet: bool,
    /// Print one line for each Newton iteration
    #[arg(long)]
    pub verbose: bool,
    /// Go on from a checkpoint: a file, or the latest of the output directory
    #[arg(long, value_name = "FILE|latest", conflicts_with = "overwrite")]
    pub restart: Option<String>,
    /// Write a page with charts, report.html, into the output directory too
    #[arg(long)]
    pub report: bool,
    /// Options for PETSc, after `--`; they override the case's
    #[arg(last = true, value_name = "PETSC OPTIONS", allow_hyphen_values = true)]
    pub petsc_options: Vec<String>,
}

/// Options of `check`.
#[derive(Debug, Clone, PartialEq, Eq, Args)]
pub struct CheckOptions {
    /// The case file
    #[arg(value_name = "CASE.yaml")]
    pub case: PathBuf,
    /// Set a value of the case, as for run. Repeatable
    #[arg(long = "set", value_name = "a.b.c=VALUE")]
    pub overrides: Vec<String>,
}

/// Options of `plot`.
#[derive(Debug, Clone, PartialEq, Args)]
struct PlotOptions {
    /// The output directory of a run that has written fields
    #[arg(value_name = "DIRECTORY")]
    directory: PathBuf,
    /// What to draw: mesh, a field (displacement, displacement_x, von_mises, stress_xx, ...), an
    /// interface by its name, or a quantity of it (NAME.damage); a name that is none lists all
    #[arg(long, value_name = "QUANTITY", default_value = "displacement")]
    of: String,
    /// The instant in s, one at which fields were written; the last if none is named
    #[arg(long, value_name = "INSTANT", allow_negative_numbers = true)]
    at: Option<f64>,
    /// The file to write, a PNG beside it; plot.svg in the directory if none is named
    #[arg(long, value_name = "FILE.svg")]
    output: Option<PathBuf>,
}

impl From<PlotOptions> for plot::Request {
    fn from(options: PlotOptions) -> Self {
        let PlotOptions { directory, of, at, output } = options;
        plot::Request { directory, of, at, output }
    }
}

/// Options of `study`.
#[derive(Debug, Clone, PartialEq, Eq, Args)]
struct StudyOptions {
    /// The study file
    #[arg(value_name = "STUDY.yaml")]
    study: PathBuf,
    /// The output directory, instead of the study's
    #[arg(long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Go on: runs that are finished are not run again
    #[arg(long)]
    resume: bool,
    /// Replace the study in the output directory
    #[arg(long, conflicts_with_all = ["resume", "part", "charts_only"])]
    overwrite: bool,
    /// Run the K-th of N shares only, and draw nothing; for the tasks of an array of jobs
    #[arg(long, value_name = "K/N", value_parser = share, conflicts_with = "charts_only")]
    part: Option<(usize, usize)>,
    /// List the runs; launch none
    #[arg(long)]
    dry_run: bool,
    /// Draw what finished runs have left; launch none
    #[arg(long)]
    charts_only: bool,
}

/// `K/N` with K from 1 to N.
fn share(text: &str) -> Result<(usize, usize), String> {
    let numbers = text.split_once('/').and_then(|(k, n)| Some((k.parse().ok()?, n.parse().ok()?)));
    numbers
        .filter(|(k, n): &(usize, usize)| (1..=*n).contains(k))
        .ok_or_else(|| "must be K/N with K from 1 to N".to_owned())
}

impl From<StudyOptions> for Request {
    fn from(options: StudyOptions) -> Self {
        let StudyOptions { study, output, resume, overwrite, part, dry_run, charts_only } = options;
        Request { study, output, resume, overwrite, part, dry_run, charts_only }
    }
}

/// Finite elements for columns and blocks crossed by cohesive interfaces.
///
/// `column-hpc CASE.yaml` is the same as `column-hpc run CASE.yaml`.
#[derive(Parser)]
#[command(name = "column-hpc", version, args_conflicts_with_subcommands = true)]
#[command(subcommand_negates_reqs = true, arg_required_else_help = true)]
#[command(after_help = "Exit status: 0 done; 1 an expectation was missed; 2 the input is wrong; \
                        3 the numerics failed; 4 a file, a library or the machine failed; 75 stopped, \
                        with a checkpoint; 101 a bug")]
struct CommandLine {
    #[command(subcommand)]
    command: Option<Word>,
    #[command(flatten)]
    run: Option<RunOptions>,
}

#[derive(Subcommand)]
enum Word {
    /// Run a case
    Run(RunOptions),
    /// Read and check a case, say what will be modelled; solve nothing
    Check(CheckOptions),
    /// Run a family of cases and chart them
    Study(StudyOptions),
    /// Draw a picture of a finished run, as SVG and PNG
    Plot(PlotOptions),
    /// Print the JSON Schema of the case file
    Schema,
}

/// Reads the command line, the name of the program first. Local; prints nothing.
///
/// # Errors
/// An [`Exit`]: status 0 for help and version, 2 for a wrong command line.
pub fn parse(args: Vec<String>) -> Result<Command, Exit> {
    let line = CommandLine::try_parse_from(args).map_err(|error| Exit {
        text: error.render().to_string().trim_end().to_owned(),
        status: if error.use_stderr() { 2 } else { 0 },
        to_stdout: !error.use_stderr(),
    })?;
    match (line.command, line.run) {
        (Some(Word::Check(options)), _) => Ok(Command::Check(options)),
        (Some(Word::Plot(options)), _) => Ok(Command::Plot(options.into())),
        (Some(Word::Schema), _) => Ok(Command::Schema),
        (Some(Word::Study(options)), _) => Ok(Command::Study(options.into())),
        (Some(Word::Run(options)), _) | (None, Some(options)) => run(options),
        (None, None) => Err(wrong("a case file is missing; see column-hpc --help")),
    }
}

fn run(options: RunOptions) -> Result<Command, Exit> {
    Ok(Command::Run(options))
}

fn wrong(what: &str) -> Exit {
    Exit { text: format!("error: {what}"), status: 2, to_stdout: false }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(words: &str) -> Result<Command, Exit> {
        parse(std::iter::once("column-hpc").chain(words.split(' ')).map(str::to_owned).collect())
    }

    #[test]
    fn run_is_the_default_command() {
        let short =
            line("case.yaml --set a.b=1 --set c=[1,2] --overwrite --output out --quiet --report");
        let Ok(Command::Run(options)) = &short else { panic!("{short:?}") };
        assert_eq!(options.case, PathBuf::from("case.yaml"));
        assert_eq!(options.overrides, ["a.b=1", "c=[1,2]"]);
        assert_eq!(options.output, Some(PathBuf::from("out")));
        assert!(options.overwrite && options.quiet && options.report && !options.verbose);
        let long = line(
            "run case.yaml --set a.b=1 --set c=[1,2] --overwrite --output out --quiet --report",
        );
        assert_eq!(short, long);
    }

    #[test]
    fn what_follows_two_dashes_goes_to_petsc() {
        for words in
            ["case.yaml -- -ksp_view -ksp_rtol 1e-5", "run case.yaml -- -ksp_view -ksp_rtol 1e-5"]
        {
            let Ok(Command::Run(options)) = line(words) else { panic!("{words}") };
            assert_eq!(options.petsc_options, ["-ksp_view", "-ksp_rtol", "1e-5"]);
        }
    }

    #[test]
    fn check_and_schema_are_commands() {
        let Ok(Command::Check(options)) = line("check case.yaml --set a=1") else { panic!() };
        assert_eq!((options.case, options.overrides), ("case.yaml".into(), vec!["a=1".to_owned()]));
        assert_eq!(line("schema"), Ok(Command::Schema));
    }

    #[test]
    fn a_plot_is_a_command() {
        let Ok(Command::Plot(request)) = line("plot out --of joint.damage --at -1.5") else {
            panic!()
        };
        let expected = plot::Request {
            directory: "out".into(),
            of: "joint.damage".to_owned(),
            at: Some(-1.5),
            output: None,
        };
        assert_eq!(request, expected);
        let exit = line("plot out --at soon").expect_err("no number");
        assert_eq!(exit.status, 2);
    }

    #[test]
    fn a_study_is_a_command() {
        let Ok(Command::Study(request)) = line("study s.yaml --part 2/3 --output out") else {
            panic!()
        };
        let expected = Request {
            study: "s.yaml".into(),
            output: Some("out".into()),
            part: Some((2, 3)),
            ..Request::default()
        };
        assert_eq!(request, expected);
    }

    #[test]
    fn a_wrong_command_line_ends_with_status_2_and_words() {
        for (words, expected) in [
            ("case.yaml --ouput x", "a similar argument exists: '--output'"),
            ("case.yaml --quiet --verbose", "cannot be used with"),
            ("case.yaml other.yaml", "unexpected argument 'other.yaml'"),
            ("check", "CASE.yaml"),
            ("--quiet", "CASE.yaml"),
            ("study", "STUDY.yaml"),
            ("study study.yaml --part 3/2", "K from 1 to N"),
            ("study study.yaml --resume --overwrite", "cannot be used with"),
            ("case.yaml --restart latest --overwrite", "cannot be used with"),
        ] {
            let exit = line(words).expect_err(words);
            assert_eq!((exit.status, exit.to_stdout), (2, false), "{words}");
            assert!(
                exit.text.starts_with("error: ") && exit.text.contains(expected),
                "{}",
                exit.text
            );
        }
        let nothing = parse(vec!["column-hpc".to_owned()]).expect_err("no words");
        assert_eq!((nothing.status, nothing.to_stdout), (2, false));
        assert!(nothing.text.contains("Usage: column-hpc"), "{}", nothing.text);
    }

    #[test]
    fn help_and_version_go_to_stdout_with_status_0() {
        for (words, expected) in
            [("--help", "--overwrite"), ("run --help", "a.b.c=VALUE"), ("--version", "0.1.0")]
        {
            let exit = line(words).expect_err(words);
            assert_eq!((exit.status, exit.to_stdout), (0, true), "{words}");
            assert!(exit.text.contains(expected), "{}", exit.text);
        }
    }
}
