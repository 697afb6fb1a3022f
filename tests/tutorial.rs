//! The tutorial, followed by a reader who writes every file, runs every command, and compares what
//! is printed.
//!
//! Of the blocks of `docs/tutorial.md`, in their order:
//!
//! - `yaml` is a file. The line above it ends in its name, "`NAME`:"; where that line begins with
//!   "Add to", the block goes to the end of the file.
//! - `sh` is run by bash, command by command, in a directory with a copy of `cases`. A command ends
//!   with status 0 or with that of its comment `# status N`.
//! - `text` is what the block of commands above it prints, by the rule of [`difference`].
//! - `console` prepares the reader's shell, which the test does by itself.

#[allow(dead_code)] // this program uses a part of it
mod common;

use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};
use std::{env, fs};

/// Seconds after which a command is taken to hang: where others hold the cores, ranks that wait for
/// each other get there slowly.
const TIME_LIMIT: &str = "600";

/// Stands for any lines, and at the end of a line for the rest of it.
const ANYTHING: &str = "...";

/// Units of what no two runs have alike.
const VARYING: [&str; 2] = ["s", "MB"];

/// Numbers agree to so much of their size.
const AGREEMENT: f64 = 1e-3;

/// What is shown as less is rounding, and what is printed has to be less than the second.
const ROUNDING: (f64, f64) = (1e-8, 1e-6);

/// In what a text differs from the one that is shown, or nothing.
///
/// Words are compared, not the spaces between them, nor empty lines. A line `...` stands for any
/// lines, also none; ` ...` at the end of a line for any words, also none. Integers are the same.
/// Numbers with a point or an exponent agree to a thousandth; those that are rounding only have to
/// be small. A number before `s` or `MB` may be any number.
fn difference(shown: &str, printed: &str) -> Option<String> {
    let (shown, printed) = (lines(shown), lines(printed));
    let parts: Vec<&[&str]> = shown.split(|line| *line == ANYTHING).collect();
    let mut from = 0;
    for (index, part) in parts.iter().enumerate() {
        let last = printed.len().saturating_sub(part.len()).max(from);
        let places = match (index == 0, index + 1 == parts.len()) {
            (true, true) if printed.len() > part.len() => {
                return Some(format!("not shown: {}", printed[part.len()]));
            }
            (true, _) => 0..=0,
            (false, true) => last..=last,
            (false, false) => from..=last,
        };
        let tried: Vec<_> = places.map(|at| (at, fitting(part, &printed[at..]))).collect();
        match tried.iter().find(|(_, fitting)| *fitting == part.len()) {
            Some((at, _)) => from = at + part.len(),
            None => {
                let (at, fitting) = *tried.iter().max_by_key(|t| t.1).expect("a place");
                let instead = printed.get(at + fitting).unwrap_or(&"nothing more");
                return Some(format!("shown:   {}\nprinted: {instead}", part[fitting]));
            }
        }
    }
    None
}

fn lines(text: &str) -> Vec<&str> {
    text.lines().map(str::trim).filter(|line| !line.is_empty()).collect()
}

/// How many lines of `part` are those of `printed`, from the first on.
fn fitting(part: &[&str], printed: &[&str]) -> usize {
    part.iter().zip(printed).take_while(|(shown, line)| line_fits(shown, line)).count()
}

fn line_fits(shown: &str, printed: &str) -> bool {
    let words = |line: &'_ str| line.split_whitespace().map(str::to_owned).collect::<Vec<_>>();
    let (mut shown, mut printed) = (words(shown), words(printed));
    if shown.last().is_some_and(|word| word == ANYTHING) {
        shown.pop();
        printed.truncate(shown.len());
    }
    let varies = |index: usize| shown.get(index + 1).is_some_and(|w| VARYING.contains(&w.as_str()));
    let pairs = || shown.iter().zip(&printed).enumerate();
    shown.len() == printed.len()
        && pairs().all(|(index, (shown, printed))| {
            let number = |word: &str| word.parse::<f64>().is_ok();
            word_fits(shown, printed) || varies(index) && number(shown) && number(printed)
        })
}

fn word_fits(shown: &str, printed: &str) -> bool {
    let (shown, printed) = (pieces(shown), pieces(printed));
    let mut pairs = shown.iter().zip(&printed);
    shown.len() == printed.len()
        && pairs.all(|(shown, printed)| shown == printed || number_fits(shown, printed))
}

fn number_fits(shown: &str, printed: &str) -> bool {
    let has_point = |number: &str| number.contains(['.', 'e']);
    let (Ok(s), Ok(p)) = (shown.parse::<f64>(), printed.parse::<f64>()) else { return false };
    has_point(shown)
        && if s.abs() < ROUNDING.0 {
            p.abs() < ROUNDING.1
        } else {
            (p - s).abs() <= AGREEMENT * s.abs()
        }
}

/// Numbers, and what is between them. Digits that belong to a name are no number.
fn pieces(word: &str) -> Vec<&str> {
    let mut found = Vec::new();
    let (mut start, mut at) = (0, 0);
    while at < word.len() {
        let before = word[..at].chars().next_back();
        let named = before.is_some_and(|c| c.is_alphanumeric() || "_.".contains(c));
        let length = if named { 0 } else { number_length(&word[at..]) };
        if length > 0 {
            found.extend([&word[start..at], &word[at..at + length]]);
            start = at + length;
        }
        at += length.max(word[at..].chars().next().map_or(1, char::len_utf8));
        at = at.max(start);
    }
    found.push(&word[start..]);
    found
}

/// Bytes of the number with which a text begins.
fn number_length(text: &str) -> usize {
    let digits = |from: usize| {
        let count = text[from..].bytes().take_while(u8::is_ascii_digit).count();
        (count > 0).then_some(from + count)
    };
    let Some(mut end) = digits(usize::from(text.starts_with('-'))) else { return 0 };
    if text[end..].starts_with('.') {
        end = digits(end + 1).unwrap_or(end);
    }
    if text[end..].starts_with('e') {
        let sign = usize::from(text[end + 1..].starts_with(['-', '+']));
        end = digits(end + 1 + sign).unwrap_or(end);
    }
    end
}

/// What the reader does, with the line of the page.
enum Step {
    Write { name: String, adds: bool, text: String },
    Run { line: usize, commands: String, shown: Option<String> },
}

/// What is to be done, in the order of the page.
fn steps(page: &str) -> Result<Vec<Step>, String> {
    let mut steps = Vec::new();
    let mut lines = page.lines().enumerate().map(|(index, line)| (index + 1, line));
    // The last line that is not empty.
    let mut above = "";
    while let Some((number, line)) = lines.next() {
        let Some(kind) = line.strip_prefix("```") else {
            above = if line.is_empty() { above } else { line };
            continue;
        };
        let mut text = String::new();
        loop {
            match lines.next() {
                Some((_, "```")) => break,
                Some((_, line)) => text = text + line + "\n",
                None => return Err(format!("line {number}: the block has no end")),
            }
        }
        let wrong = |what: &str| Err(format!("line {number}: {what}"));
        match (kind, steps.last_mut()) {
            ("yaml", _) => match above.strip_suffix("`:").and_then(|a| a.rsplit_once('`')) {
                Some((_, name)) => {
                    let (name, adds) = (name.to_owned(), above.starts_with("Add to"));
                    steps.push(Step::Write { name, adds, text });
                }
                None => return wrong("a file without a name"),
            },
            ("sh", _) => steps.push(Step::Run { line: number, commands: text, shown: None }),
            ("text", Some(Step::Run { shown: shown @ None, .. })) if above == "```sh" => {
                *shown = Some(text);
            }
            ("text", _) => return wrong("nothing above it prints"),
            ("console", _) => {}
            _ => return wrong("another kind of block"),
        }
        above = line;
    }
    Ok(steps)
}

/// The commands of a block, each with the status it is to end with.
fn commands(block: &str) -> Vec<(String, i32)> {
    let mut found: Vec<(String, i32)> = Vec::new();
    let mut goes_on = false;
    for line in block.lines() {
        if !goes_on {
            found.push((String::new(), 0));
        }
        let (command, status) = found.last_mut().expect("a command");
        *command = format!("{command}{line}\n");
        let stated = line.rsplit_once("# status ").and_then(|(_, number)| number.parse().ok());
        *status = stated.unwrap_or(*status);
        goes_on = line.ends_with('\\');
    }
    found
}

/// A directory in which the reader works.
struct Desk(PathBuf);

impl Desk {
    fn new() -> Self {
        static NUMBER: AtomicU32 = AtomicU32::new(0);
        let number = NUMBER.fetch_add(1, Ordering::Relaxed);
        let name = format!("column-hpc-tutorial-{}-{number}", std::process::id());
        let path = env::temp_dir().join(name);
        fs::create_dir_all(&path).expect("the temporary directory is writable");
        let cases = Path::new(env!("CARGO_MANIFEST_DIR")).join("cases");
        symlink(cases, path.join("cases")).expect("a folder of ours");
        Self(path)
    }

    /// What a command prints, on either stream, and its status.
    fn run(&self, command: &str) -> (String, Option<i32>) {
        let program = Path::new(env!("CARGO_BIN_EXE_column-hpc"));
        let mut path = vec![program.parent().expect("a directory").to_owned()];
        path.extend(env::split_paths(&env::var_os("PATH").unwrap_or_default()));
        let _cores = common::Cores::wait(2);
        let output = Command::new("timeout")
            .args([TIME_LIMIT, "bash", "-c", &format!("exec 2>&1\n{command}")])
            .current_dir(&self.0)
            .envs(common::environment())
            .env("PATH", env::join_paths(path).expect("no colons"))
            .stdin(Stdio::null())
            .output()
            .expect("timeout and bash are on the PATH");
        (String::from_utf8_lossy(&output.stdout).into_owned(), output.status.code())
    }

    /// Follows the page; tells everything that is not as it says.
    fn follow(&self, page: &str) -> Vec<String> {
        let steps = match steps(page) {
            Ok(steps) => steps,
            Err(fault) => return vec![fault],
        };
        steps.into_iter().flat_map(|step| self.take(step)).collect()
    }

    fn take(&self, step: Step) -> Vec<String> {
        let mut faults = Vec::new();
        match step {
            Step::Write { name, adds, text } => {
                let path = self.0.join(name);
                let before = if adds { fs::read_to_string(&path).unwrap() } else { String::new() };
                fs::write(path, before + &text).expect("a folder of ours");
            }
            Step::Run { line, commands: block, shown } => {
                let mut printed = String::new();
                for (command, expected) in commands(&block) {
                    let (text, status) = self.run(&command);
                    if status != Some(expected) {
                        faults.push(format!(
                            "line {line}: status {status:?} in the place of {expected}:\n{command}\
                             {text}"
                        ));
                    }
                    printed += &text;
                }
                if let Some(words) = shown.and_then(|shown| difference(&shown, &printed)) {
                    faults.push(format!("line {line}:\n{words}\n--- all of it:\n{printed}"));
                }
            }
        }
        faults
    }
}

impl Drop for Desk {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

#[test]
fn what_the_tutorial_says_is_what_happens() {
    let page = include_str!("../docs/tutorial.md");
    let runs = steps(page).expect("a page").into_iter().filter(|s| matches!(s, Step::Run { .. }));
    assert!(runs.count() > 15, "the blocks are not found");
    let faults = Desk::new().follow(page);
    assert!(faults.is_empty(), "docs/tutorial.md:\n{}", faults.join("\n\n"));
}

#[test]
fn a_page_that_is_wrong_is_found_out() {
    let faults = |page: &str| Desk::new().follow(page);
    let right = "Write `a.yaml`:\n\n```yaml\na: 1\n```\nAdd to `a.yaml`:\n```yaml\nb: 2\n```\n\
                 ```sh\ncat \\\n  a.yaml\nls absent   # status 2\n```\n\n\
                 ```text\na: 1\nb: 2\nls: ...\n```\n```console\nfalse\n```\n```sh\ntrue\n```\n";
    assert_eq!(faults(right), Vec::<String>::new());
    for (words, others, told) in [
        ("b: 2\nls", "b: 3\nls", "shown:   b: 3\nprinted: b: 2"),
        ("ls: ...", "...\nlast", "shown:   last\nprinted: ls:"),
        ("# status 2", "# status 3", "status Some(2) in the place of 3"),
        ("   # status 2", "", "status Some(2) in the place of 0"),
        ("\ntrue", "\nfalse", "status Some(1) in the place of 0"),
        ("Write `a.yaml`:", "Write it:", "line 3: a file without a name"),
        ("```text", "And:\n```text", "nothing above it prints"),
        ("```console", "```shell", "another kind of block"),
        ("true\n```", "true\n", "the block has no end"),
    ] {
        assert_eq!(right.matches(words).count(), 1, "{words}");
        let found = faults(&right.replace(words, others)).join("\n");
        assert!(found.contains(told), "{others}: {found}");
    }
}

#[test]
fn the_comparison_tells_what_matters_from_what_does_not() {
    let right = "mesh   6 cells, at bulk_07, done in 0.54 s\n\n   1  1.017312e6   -8.1e-22 (0.25)\n\
                 last of 60.5 MB";
    for same in [
        right,
        "mesh 6 cells, at bulk_07, done in 12 s\n1 1.01732e6 4e-9 (0.25)\nlast of 61 MB",
        "mesh 6 cells, ...\n...\n1  1.017312e6  ...\nlast of 60.5 MB ...\n...",
        "...\n1  1.0180e6  0.0 (0.25)\n...",
    ] {
        assert_eq!(difference(same, right), None, "{same}");
    }
    for (words, others) in [
        ("6 cells", "7 cells"),
        ("6 cells", "6.5 cells"),
        ("cells", "cell"),
        ("bulk_07", "bulk_08"),
        ("0.54 s", "soon s"),
        ("0.54 s", "0.54 m"),
        ("   1  1.0", "   2  1.0"),
        ("1.017312e6", "1.018400e6"),
        ("1.017312e6", "-1.017312e6"),
        ("1.017312e6", "1.017312e5"),
        ("-8.1e-22", "2.0e-6"),
        ("-8.1e-22", "2.0e-8"),
        ("(0.25)", "(0.26)"),
        ("(0.25)", "0.25"),
        ("(0.25)", "(0.25) more"),
        ("(0.25)", ""),
        ("last", "more\nlast"),
        ("\nlast of 60.5 MB", ""),
        ("mesh   6 cells, at bulk_07, done in 0.54 s\n", ""),
    ] {
        let wrong = right.replacen(words, others, 1);
        assert_ne!(wrong, right, "{words}");
        // Shown is what is wrong, then printed.
        assert!(difference(&wrong, right).is_some(), "{others}");
        assert!(words == "-8.1e-22" || difference(right, &wrong).is_some(), "{others}");
    }
    for (shown, printed) in
        [("a\n...\nc", "a\nb"), ("...\nb\n...\na\n...", "a\nb"), ("a\n...\na", "a"), ("...\nd", "")]
    {
        assert!(difference(shown, printed).is_some(), "{shown}");
    }
}
