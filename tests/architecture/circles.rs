//! Circles of imports among files: a reader of `use` lines and of paths in the code.

use std::collections::{BTreeMap, BTreeSet};

use super::Source;

/// A module by its path below the crate, as `solve::stepping`.
type Module = Vec<String>;

/// What one file imports, and what it hands on under its own name.
struct File {
    imports: Vec<Vec<String>>,
    exports: Vec<Vec<String>>,
}

/// What each module uses, where it is defined.
fn uses(sources: &[Source]) -> BTreeMap<Module, BTreeSet<Module>> {
    let files = files(sources);
    let exports = exports(&files);
    let of = |(module, file): (&Module, &File)| {
        let target = |path: &Vec<String>| target(&files, &exports, module, path);
        let targets = file.imports.iter().filter_map(target);
        (module.clone(), targets.filter(|t| t != module && !t.is_empty()).collect())
    };
    files.iter().map(of).collect()
}

/// Uses among the folders and files of `room` that run against `order`.
pub fn downward(sources: &[Source], room: &str, order: &[&str]) -> Vec<String> {
    let position = |module: &Module| {
        let inside = module.first().is_some_and(|first| first == room);
        order.iter().position(|name| inside && module.get(1).is_some_and(|second| second == name))
    };
    let mut found = Vec::new();
    for (module, targets) in uses(sources) {
        let Some(own) = position(&module) else { continue };
        let below = targets.iter().filter(|target| position(target) > Some(own));
        found.extend(below.map(|t| format!("{} uses {}", module.join("::"), t.join("::"))));
    }
    found
}

/// The modules of each circle, with what each of them uses of the others.
pub fn circles(sources: &[Source]) -> Vec<String> {
    let uses = uses(sources);
    let reached: BTreeMap<&Module, BTreeSet<&Module>> =
        uses.keys().map(|module| (module, reached(&uses, module))).collect();
    let mut found = Vec::new();
    for module in uses.keys().filter(|module| reached[*module].contains(*module)) {
        let back = |other: &&Module| reached.get(other).is_some_and(|r| r.contains(module));
        let others: Vec<_> = uses[module].iter().filter(back).map(|m| m.join("::")).collect();
        found.push(format!("{} uses {}", module.join("::"), others.join(", ")));
    }
    found
}

/// Every module but those of tests.
fn files(sources: &[Source]) -> BTreeMap<Module, File> {
    let mut files = BTreeMap::new();
    let is_test = |module: &Module| {
        let Some((name, parent)) = module.split_last() else { return false };
        let declared = format!("#[cfg(test)]\nmod {name};");
        let mut of_parent =
            sources.iter().filter(|s| module_of(&s.path).as_deref() == Some(parent));
        name.ends_with("tests") || of_parent.any(|s| s.text.contains(&declared))
    };
    for source in sources {
        let Some(module) = module_of(&source.path) else { continue };
        if module.iter().enumerate().any(|(i, _)| is_test(&module[..=i].to_vec())) {
            continue;
        }
        let code: Vec<_> = source.code().map(|(_, line)| line).collect();
        let code = code.join("\n");
        let code = code.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
        files.insert(module, read(code));
    }
    files
}

/// `solve::stepping` of `src/solve/stepping.rs`, and of `src/solve/stepping/mod.rs`.
fn module_of(path: &str) -> Option<Module> {
    let inner = path.strip_prefix("src/")?.strip_suffix(".rs")?;
    let inner = inner.strip_suffix("/mod").unwrap_or(inner);
    let words = if inner == "lib" || inner == "main" { "" } else { inner };
    Some(words.split('/').filter(|w| !w.is_empty()).map(str::to_owned).collect())
}

fn read(code: &str) -> File {
    let mut file = File { imports: Vec::new(), exports: Vec::new() };
    for statement in code.split(';') {
        let Some(at) = statement.rfind("use ") else { continue };
        let before = statement[..at].lines().last().unwrap_or_default().trim();
        let is_public = before.starts_with("pub");
        if !(before.is_empty() || is_public) {
            continue;
        }
        for path in expand(&statement[at + 4..]) {
            // What is only handed on is not used.
            if is_public { &mut file.exports } else { &mut file.imports }.push(path);
        }
    }
    // Paths in the code itself.
    for start in ["crate::", "super::"] {
        for (at, _) in code.match_indices(start) {
            let is_word = |c: char| c.is_alphanumeric() || c == '_';
            // The room of a visibility is not used.
            if code[..at].ends_with(|c| is_word(c) || c == ':') || code[..at].ends_with("pub(in ") {
                continue;
            }
            let end = code[at..].find(|c| !is_word(c) && c != ':').unwrap_or(code.len() - at);
            // A list in braces belongs to a `use`.
            let path = &code[at..at + end];
            if !path.ends_with("::") {
                file.imports.push(path.split("::").map(str::to_owned).collect());
            }
        }
    }
    file
}

/// The paths of `a::{b, c::{d, e}}`.
fn expand(text: &str) -> Vec<Vec<String>> {
    let text = text.trim();
    let Some((before, inner)) = text.split_once('{') else {
        let name = text.split(" as ").next().unwrap_or_default();
        return vec![name.split("::").map(|w| w.trim().to_owned()).collect()];
    };
    let inner = inner.strip_suffix('}').unwrap_or(inner);
    let (mut depth, mut start, mut parts) = (0, 0, Vec::new());
    for (i, c) in inner.char_indices() {
        match c {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => {
                parts.push(&inner[start..i]);
                start = i + 1;
            }
            _ => {}
        }
    }
    parts.push(&inner[start..]);
    let parts = parts.into_iter().filter(|part| !part.trim().is_empty());
    parts.flat_map(|part| expand(&format!("{before}{}", part.trim()))).collect()
}

/// The module that a path begins with, and what it names there.
fn resolve(
    files: &BTreeMap<Module, File>,
    module: &Module,
    path: &[String],
) -> Option<(Module, Vec<String>)> {
    let (mut at, mut rest) = (module.clone(), path);
    match rest.first()?.as_str() {
        "crate" => (at, rest) = (Vec::new(), &rest[1..]),
        "super" | "self" => {
            while let Some(word @ ("super" | "self")) = rest.first().map(String::as_str) {
                if word == "super" {
                    at.pop();
                }
                rest = &rest[1..];
            }
        }
        name => {
            let child: Module = module.iter().cloned().chain([name.to_owned()]).collect();
            files.get(&child)?;
        }
    }
    while let Some(name) = rest.first() {
        let child: Module = at.iter().cloned().chain([name.clone()]).collect();
        if !files.contains_key(&child) {
            break;
        }
        (at, rest) = (child, &rest[1..]);
    }
    Some((at, rest.to_vec()))
}

type Exports = BTreeMap<Module, BTreeMap<String, Module>>;

/// Where the names come from that a module hands on.
fn exports(files: &BTreeMap<Module, File>) -> Exports {
    let mut found = Exports::new();
    for (module, file) in files {
        for path in &file.exports {
            if let Some((from, rest)) = resolve(files, module, path)
                && let Some(name) = rest.last()
            {
                found.entry(module.clone()).or_default().insert(name.clone(), from);
            }
        }
    }
    found
}

/// The module in which what a path names is at home.
fn target(
    files: &BTreeMap<Module, File>,
    exports: &Exports,
    module: &Module,
    path: &[String],
) -> Option<Module> {
    let (mut at, rest) = resolve(files, module, path)?;
    while let Some(from) = rest.first().and_then(|name| exports.get(&at)?.get(name)) {
        if *from == at {
            break;
        }
        at = from.clone();
    }
    Some(at)
}

/// All modules that a module uses, also through others.
fn reached<'u>(
    uses: &'u BTreeMap<Module, BTreeSet<Module>>,
    module: &Module,
) -> BTreeSet<&'u Module> {
    let mut reached = BTreeSet::new();
    let mut next: Vec<&Module> = uses.get(module).into_iter().flatten().collect();
    while let Some(module) = next.pop() {
        if reached.insert(module) {
            next.extend(uses.get(module).into_iter().flatten());
        }
    }
    reached
}
