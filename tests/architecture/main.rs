//! Rules of the source that the compiler does not check; they read text only.

mod circles;
mod length;

use std::fs;
use std::path::{Path, PathBuf};

/// The only places that may call C or touch the process: (prefixes of) paths below `src`.
const FENCES: [&str; 6] = [
    "src/simd.rs",
    "src/petsc/",
    "src/partition/metis.rs",
    "src/output/hdf5.rs",
    "src/runtime.rs",
    "src/comm/waiting.rs",
];

/// Where the order of a loop can become the order of communication.
const ORDERED: [&str; 4] = ["src/partition", "src/space", "src/interface", "src/assembly"];

/// Rooms with walls: the only other modules that they may use.
const WALLS: [(&str, &[&str]); 5] = [
    ("law", &["error"]),
    ("element", &[]),
    ("mesh", &["case", "element", "error"]),
    ("bulk", &["case", "element", "error", "mesh"]),
    (
        "assembly",
        &["bulk", "comm", "element", "error", "interface", "petsc", "simd", "space", "sparse"],
    ),
];

/// What a lattice is made of, and the only rooms that know of it.
const LATTICE: [&str; 5] = ["Column", "CellPlace", "NodePlace", "Facets", "lattice"];
const LATTICE_ROOMS: [&str; 2] = ["mesh", "reduce"];

/// Directories that exist on one machine only.
const MACHINE: [&str; 6] = ["/home/", "/root/", "/Users/", "/work/", "/tmp/", "/mnt/"];

/// The home of the user inside the container image, which is the same everywhere.
const IMAGE_HOME: &str = "/home/column";

const LONGEST_FILE: usize = 400;

const WIDEST: usize = 100;

/// Pages that are written by hand.
const PROSE: [&str; 12] = [
    "README.md",
    "ARCHITECTURE.md",
    "CONTRIBUTING.md",
    "CHANGELOG.md",
    "docs/accuracy.md",
    "docs/case.md",
    "docs/performance.md",
    "docs/promises.md",
    "docs/install.md",
    "docs/studies.md",
    "docs/theory.md",
    "docs/tutorial.md",
];

/// A text file: its path relative to the package, and its contents.
struct Source {
    path: String,
    text: String,
}

impl Source {
    /// The lines with their numbers, without those that are only a comment.
    fn code(&self) -> impl Iterator<Item = (usize, &str)> {
        let lines = self.text.lines().enumerate().map(|(i, line)| (i + 1, line));
        lines.filter(|(_, line)| !line.trim_start().starts_with("//"))
    }

    /// `mesh` of `src/mesh/column.rs` and of `src/mesh.rs`.
    fn module(&self) -> Option<&str> {
        let inner = self.path.strip_prefix("src/")?;
        Some(inner.split('/').next()?.trim_end_matches(".rs"))
    }

    fn is_this_file(&self) -> bool {
        self.path == "tests/architecture/main.rs"
    }
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Every text file below a directory of the package, sorted; build products and `.git` left out.
fn sources_in(directory: &str) -> Vec<Source> {
    let mut found = Vec::new();
    collect(&root().join(directory), &mut found);
    found.sort();
    let read = |path: PathBuf| {
        let relative = path.strip_prefix(root()).expect("collected below the root");
        let text = fs::read_to_string(&path).ok()?;
        Some(Source { path: relative.to_string_lossy().into_owned(), text })
    };
    found.into_iter().filter_map(read).collect()
}

fn collect(directory: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(directory).expect("a directory of the package").flatten() {
        let (path, name) = (entry.path(), entry.file_name());
        // `.git` is a file in a worktree.
        let mut product = ["target", "results", ".git", ".venv", "__pycache__"].iter();
        if product.any(|p| name == *p) {
            continue;
        }
        if path.is_dir() {
            collect(&path, found);
        } else if path.is_file() {
            found.push(path);
        }
    }
}

/// What is written in Rust, and what lies beside it.
fn code_and_tests() -> impl Iterator<Item = Source> {
    ["src", "tests", "examples"].into_iter().flat_map(sources_in)
}

/// The words (identifiers) of a line.
fn words(line: &str) -> impl Iterator<Item = &str> {
    line.split(|c: char| !c.is_alphanumeric() && c != '_').filter(|w| !w.is_empty())
}

/// The name in `pub mod name;`.
fn declared_module(line: &str) -> Option<&str> {
    let line = line.strip_prefix("pub ").or(line.strip_prefix("pub(crate) ")).unwrap_or(line);
    line.strip_prefix("mod ")?.strip_suffix(';')
}

/// The modules of `lib.rs` in the order in which they are declared.
fn modules(lib: &str) -> Vec<&str> {
    lib.lines().filter_map(declared_module).collect()
}

/// The top-level names that follow `crate::`, also those of `crate::{a, b::{c, d}}`.
fn crate_names(text: &str) -> Vec<&str> {
    let mut names = Vec::new();
    for (at, _) in text.match_indices("crate::") {
        if text[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_') {
            continue;
        }
        let rest = &text[at + "crate::".len()..];
        let Some(list) = rest.strip_prefix('{') else {
            names.extend(words(rest).next());
            continue;
        };
        let (mut depth, mut start) = (0_usize, 0);
        for (i, c) in list.char_indices() {
            match c {
                '{' => depth += 1,
                ',' | '}' if depth == 0 => {
                    names.extend(words(&list[start..i]).next());
                    start = i + 1;
                    if c == '}' {
                        break;
                    }
                }
                '}' => depth -= 1,
                _ => {}
            }
        }
    }
    names
}

/// Uses of a module that is declared below the user.
fn downward_uses(order: &[&str], source: &Source) -> Vec<String> {
    let position = |name: &str| order.iter().position(|m| *m == name);
    let Some(own) = source.module().and_then(position) else { return Vec::new() };
    let code: Vec<_> = source.code().map(|(_, line)| line).collect();
    let code = code.join("\n");
    let below = crate_names(&code).into_iter().filter(|name| position(name) > Some(own));
    below.map(|name| format!("{} uses crate::{name}, declared below it", source.path)).collect()
}

/// Uses of modules that `room` may not use.
fn uses_beyond(room: &str, allowed: &[&str], source: &Source) -> Vec<String> {
    let code: Vec<_> = source.code().map(|(_, line)| line).collect();
    let code = code.join("\n");
    let names = crate_names(&code).into_iter();
    let beyond = names.filter(|name| *name != room && !allowed.contains(name));
    beyond.map(|name| format!("{} uses crate::{name}", source.path)).collect()
}

/// Lines with one of the words, as `path:line`.
fn lines_with(source: &Source, forbidden: &[&str]) -> Vec<String> {
    let hit = |line: &str| words(line).any(|word| forbidden.contains(&word));
    let lines = source.code().filter(|(_, line)| hit(line));
    lines.map(|(number, line)| format!("{}:{number}: {}", source.path, line.trim())).collect()
}

fn is_comment(line: &str) -> bool {
    line.trim_start().starts_with("//")
}

fn is_prose(line: &str) -> bool {
    !["|", "![", "    ", "<!--", "["].iter().any(|start| line.starts_with(start))
}

/// Lines of more than [`WIDEST`] columns of the kind that counts; what is fenced off is code.
fn wide_lines(source: &Source, counts: fn(&str) -> bool) -> Vec<String> {
    let mut is_code = false;
    let mut found = Vec::new();
    for (i, line) in source.text.lines().enumerate() {
        is_code ^= line.starts_with("```");
        if !is_code && counts(line) && line.chars().count() > WIDEST {
            found.push(format!("{}:{}: {} columns", source.path, i + 1, line.chars().count()));
        }
    }
    found
}

/// Lines that name a directory of one machine.
fn machine_paths(source: &Source) -> Vec<String> {
    let mut found = Vec::new();
    for (i, line) in source.text.lines().enumerate() {
        let absolute = |at: usize| {
            !line[..at].ends_with(|c: char| c.is_alphanumeric() || "_-.}/)".contains(c))
                && !line[at..].starts_with(IMAGE_HOME)
        };
        if MACHINE.iter().any(|m| line.match_indices(m).any(|(at, _)| absolute(at))) {
            found.push(format!("{}:{}: {}", source.path, i + 1, line.trim()));
        }
    }
    found
}

fn assert_none(found: Vec<String>, rule: &str) {
    assert!(found.is_empty(), "{rule}:\n{}", found.join("\n"));
}

#[test]
fn modules_use_only_modules_declared_above_them() {
    let lib = fs::read_to_string(root().join("src/lib.rs")).expect("src/lib.rs");
    let order = modules(&lib);
    assert!(!order.is_empty(), "no modules found in src/lib.rs");
    let found = sources_in("src").iter().flat_map(|s| downward_uses(&order, s)).collect();
    assert_none(found, "a module may use only those declared above it in lib.rs");
}

#[test]
fn folders_of_the_solution_use_only_those_above_them() {
    let sources = sources_in("src");
    let list = fs::read_to_string(root().join("src/solve/mod.rs")).expect("src/solve/mod.rs");
    let order = modules(&list);
    assert!(order.len() > 5, "{order:?}");
    assert_none(circles::downward(&sources, "solve", &order), "against the order of solve/mod.rs");

    let source = |path: &str, text: &str| Source { path: path.into(), text: text.into() };
    let against = [
        source("src/solve/mod.rs", "mod a;\nmod b;\npub use b::B;"),
        source("src/solve/a/mod.rs", "use super::B;"),
        source("src/solve/b/mod.rs", "use super::a::A;\npub struct B;"),
    ];
    assert_eq!(circles::downward(&against, "solve", &["a", "b"]), ["solve::a uses solve::b"]);
}

#[test]
fn no_files_use_each_other() {
    let found = circles::circles(&sources_in("src"));
    assert_none(found, "circles of imports");

    let source = |path: &str, text: &str| Source { path: path.into(), text: text.into() };
    let circle = [
        source("src/lib.rs", "pub mod a;\npub mod c;"),
        source("src/a/mod.rs", "mod b;\npub use b::{B, Other};\n"),
        source("src/a/b.rs", "use crate::{error::Error, c::{C, D}};\npub struct B;"),
        source("src/c.rs", "use crate::a::B;\n#[cfg(test)]\nmod tests {\n use crate::a;\n}"),
        source("src/d.rs", "// use crate::a::B;\nfn f() -> crate::c::C {}"),
    ];
    assert_eq!(circles::circles(&circle), ["a::b uses c", "c uses a::b"]);
}

#[test]
fn laws_and_elements_know_no_solver_and_assembly_no_mesh() {
    let sources = sources_in("src");
    for (room, allowed) in WALLS {
        let inside: Vec<_> = sources.iter().filter(|s| s.module() == Some(room)).collect();
        assert!(!inside.is_empty(), "no module {room}");
        let found = inside.into_iter().flat_map(|s| uses_beyond(room, allowed, s)).collect();
        assert_none(found, "a wall of the house");
    }
}

#[test]
fn lattices_end_at_the_local_mesh() {
    let sources = sources_in("src").into_iter();
    let outside = sources.filter(|s| !s.module().is_some_and(|m| LATTICE_ROOMS.contains(&m)));
    let lines = outside.flat_map(|s| lines_with(&s, &LATTICE));
    // Words of messages.
    let found = lines.filter(|line| !line.contains('"'));
    assert_none(found.collect(), "only mesh/ and reduce/ know a lattice");
}

#[test]
fn files_are_short() {
    let long = code_and_tests().filter_map(|s| {
        let lines = s.text.lines().count();
        let too_long = s.path.ends_with(".rs") && lines > LONGEST_FILE;
        too_long.then(|| format!("{}: {lines} lines", s.path))
    });
    assert_none(long.collect(), "split by meaning");
}

/// Comments, and prose outside tables, code and pictures. Pages that scripts write are theirs.
#[test]
fn comments_and_prose_are_no_wider_than_a_screen() {
    let rust = code_and_tests().filter(|s| s.path.ends_with(".rs"));
    let mut found: Vec<_> = rust.flat_map(|s| wide_lines(&s, is_comment)).collect();
    for page in PROSE {
        let text = fs::read_to_string(root().join(page)).expect(page);
        found.extend(wide_lines(&Source { path: page.into(), text }, is_prose));
    }
    assert_none(found, "at most 100 columns");
}

#[test]
fn unsafe_stays_inside_the_fences() {
    let outside = code_and_tests()
        .filter(|s| !s.is_this_file() && !FENCES.iter().any(|f| s.path.starts_with(f)));
    let found = outside.flat_map(|s| lines_with(&s, &["unsafe"])).collect();
    assert_none(found, "unsafe outside the fences");
}

#[test]
fn communication_order_never_depends_on_hashes() {
    let sources = sources_in("src").into_iter();
    let ordered = sources.filter(|s| ORDERED.iter().any(|o| s.path.starts_with(o)));
    let found = ordered.flat_map(|s| lines_with(&s, &["HashMap", "HashSet"])).collect();
    assert_none(
        found,
        "use BTreeMap, BTreeSet or sorted vectors: their order is the same on all ranks",
    );
}

/// Files that pages name are there; names in capitals stand for any.
#[test]
fn pages_name_files_that_are_there() {
    let mut found = Vec::new();
    for page in PROSE {
        let text = fs::read_to_string(root().join(page)).expect(page);
        for name in text.split('`').skip(1).step_by(2).filter(|name| names_a_file(name)) {
            if !root().join(name).exists() {
                found.push(format!("{page}: {name}"));
            }
        }
    }
    assert_none(found, "a file that is not there");
    assert!(names_a_file("src/lib.rs") && names_a_file("docs/case.md"));
    assert!(!names_a_file("src/law/NAME.rs") && !names_a_file("src/main.rs and more"));
}

/// Whether a piece of code in a page is the path of a file of the package.
fn names_a_file(code: &str) -> bool {
    let rooms = ["src/", "tests/", "docs/", "scripts/", "cases/", "examples/", "findings/"];
    rooms.iter().any(|room| code.starts_with(room))
        && code.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || "/_.-".contains(c))
}

#[test]
fn no_file_names_a_directory_of_one_machine() {
    let sources = sources_in("").into_iter().filter(|s| !s.is_this_file());
    assert_none(sources.flat_map(|s| machine_paths(&s)).collect(), "paths of one machine");
}

#[test]
fn the_rules_find_what_they_look_for() {
    let source = |path: &str, text: &str| Source { path: path.into(), text: text.into() };
    let order = modules("mod error;\npub mod mesh;\npub(crate) mod solve;\n");
    assert_eq!(order, ["error", "mesh", "solve"]);

    let mesh = "use crate::{error::{Error, Result},\n    solve};\n// crate::solve\n";
    let found = downward_uses(&order, &source("src/mesh/column.rs", mesh));
    assert_eq!(found, ["src/mesh/column.rs uses crate::solve, declared below it"]);
    let upward = "use crate::mesh::Mesh;\nfn f() -> crate::error::Result<()> { my_crate::solve() }";
    assert!(downward_uses(&order, &source("src/solve.rs", upward)).is_empty());

    let law =
        source("src/law/tied.rs", "use crate::error::Result;\nuse crate::{law, petsc::Snes};");
    assert_eq!(uses_beyond("law", &["error"], &law), ["src/law/tied.rs uses crate::petsc"]);

    let raw = source("src/mesh.rs", "#![deny(unsafe_code)]\n// unsafe\nunsafe { f() }\n");
    assert_eq!(lines_with(&raw, &["unsafe"]), ["src/mesh.rs:3: unsafe { f() }"]);

    let wide = format!("{0}\n```\n{0}\n```\n| {0} |\n", "x".repeat(101));
    assert_eq!(wide_lines(&source("x.md", &wide), is_prose), ["x.md:1: 101 columns"]);

    let paths = "a: /tmp/x\nhttps://example.org/tmp/x\n$root/tmp/x\n/home/column\n\"/home/me\"\n";
    assert_eq!(
        machine_paths(&source("x.md", paths)),
        ["x.md:1: a: /tmp/x", "x.md:5: \"/home/me\""]
    );
}
