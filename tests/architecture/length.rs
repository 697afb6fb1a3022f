//! Functions that are too long to be read at once: a reader of braces.

use super::{Source, assert_none, sources_in};

/// Most lines of a function, from `fn` to its closing brace.
const LONGEST: usize = 60;

/// A function that is too long.
struct Long {
    path: String,
    name: String,
    /// Of its `fn`, from 1.
    line: usize,
    lines: usize,
}

impl Long {
    fn words(&self) -> String {
        let Self { path, name, line, lines } = self;
        format!("{path}:{line}: {name} has {lines} lines")
    }
}

#[test]
fn functions_are_short() {
    let sources = sources_in("src").into_iter().filter(|s| s.path.ends_with(".rs"));
    let long = long_functions(&sources.collect::<Vec<_>>()).into_iter();
    let found = long.map(|long| long.words());
    assert_none(found.collect(), "split by meaning");
}

#[test]
fn a_long_function_is_found() {
    let source = |path: &str, text: String| Source { path: path.into(), text };
    let body = |lines: usize| "    let brace = ('{', \"}{\", r#\"\"{\"#); // {\n".repeat(lines);
    let text = |lines: usize| {
        format!(
            "/// fn f() {{\ntrait T {{\n    fn declared<'a>(&'a self) -> [u8; 2];\n}}\n\n\
             pub fn long(\n    x: [u8; 2],\n) -> fn(u8) {{\n{}}}\n\
             #[cfg(test)]\nmod tests {{\nfn tested() {{\n{}}}\n}}\n",
            body(lines),
            body(100)
        )
    };
    let found = |path: &str, lines: usize| -> Vec<String> {
        long_functions(&[source(path, text(lines))]).iter().map(Long::words).collect()
    };
    assert!(found("src/a.rs", 56).is_empty());
    assert_eq!(found("src/a.rs", 57), ["src/a.rs:6: long has 61 lines"]);
    assert!(found("src/a_tests.rs", 57).is_empty() && found("src/tests/b.rs", 57).is_empty());
}

/// Functions of more than [`LONGEST`] lines outside tests.
fn long_functions(sources: &[Source]) -> Vec<Long> {
    let mut found = Vec::new();
    for source in sources.iter().filter(|source| !is_of_tests(&source.path)) {
        let code = blanked(&source.text);
        let code = without_test_modules(&code);
        for (at, _) in code.match_indices("fn ") {
            if code[..at].ends_with(is_word) {
                continue;
            }
            let name: String = code[at + 3..].chars().take_while(|c| is_word(*c)).collect();
            let Some(end) = end_of(&code[at..]).filter(|_| !name.is_empty()) else { continue };
            let lines = 1 + newlines(&code[at..at + end]);
            if lines > LONGEST {
                let line = 1 + newlines(&code[..at]);
                found.push(Long { path: source.path.clone(), name, line, lines });
            }
        }
    }
    found
}

fn is_of_tests(path: &str) -> bool {
    path.split('/').any(|part| part.trim_end_matches(".rs").ends_with("tests"))
}

fn is_word(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

fn newlines(text: &str) -> usize {
    text.matches('\n').count()
}

/// Just after the brace that closes what a signature begins; none where it has no body.
fn end_of(code: &str) -> Option<usize> {
    let mut brackets = 0_i32;
    for (i, c) in code.char_indices() {
        match c {
            '(' | '[' => brackets += 1,
            ')' | ']' => brackets -= 1,
            // A `;` in brackets is of an array.
            ';' if brackets == 0 => return None,
            '{' => return end_of_braces(&code[i..]).map(|end| i + end),
            _ => {}
        }
    }
    None
}

/// Just after the brace that closes the first one.
fn end_of_braces(code: &str) -> Option<usize> {
    let mut depth = 0_i32;
    for (i, c) in code.char_indices() {
        match c {
            '{' => depth += 1,
            '}' => {
                depth -= 1;
                if depth == 0 {
                    return Some(i + 1);
                }
            }
            _ => {}
        }
    }
    None
}

/// The code with blanks in the place of modules of tests; lines stay where they are.
fn without_test_modules(code: &str) -> String {
    let mut left = code.to_owned();
    for (at, _) in code.match_indices("#[cfg(test)]\n") {
        let rest = &code[at..];
        let Some(item) = rest.lines().nth(1) else { continue };
        let is_module = item.trim_start().starts_with("mod ") && item.ends_with('{');
        if let Some(end) = end_of(&rest[item_start(rest)..]).filter(|_| is_module) {
            let end = at + item_start(rest) + end;
            left.replace_range(at..end, &blanks(&code[at..end]));
        }
    }
    left
}

/// Where the line after an attribute begins.
fn item_start(rest: &str) -> usize {
    rest.find('\n').map_or(rest.len(), |end| end + 1)
}

/// Blanks of the same length, with the same lines.
fn blanks(text: &str) -> String {
    text.bytes().map(|b| if b == b'\n' { '\n' } else { ' ' }).collect()
}

/// The text with blanks in the place of comments, texts and characters, whose braces count for
/// nothing; every byte stays where it is.
fn blanked(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let before = out.chars().next_back();
        let length = literal(rest, before).unwrap_or(0);
        if length > 0 {
            out.push_str(&blanks(&rest[..length]));
            rest = &rest[length..];
        } else {
            out.push(first);
            rest = &rest[first.len_utf8()..];
        }
    }
    out
}

/// The length of the comment, text or character that begins here.
fn literal(rest: &str, before: Option<char>) -> Option<usize> {
    if rest.starts_with("//") {
        return Some(rest.find('\n').unwrap_or(rest.len()));
    }
    if rest.starts_with("/*") {
        return Some(rest.find("*/").map_or(rest.len(), |end| end + 2));
    }
    if rest.starts_with('r') && !before.is_some_and(|c| is_word(c) && c != 'b') {
        let hashes = rest[1..].bytes().take_while(|b| *b == b'#').count();
        let body = rest[1 + hashes..].strip_prefix('"')?;
        let close = format!("\"{}", "#".repeat(hashes));
        let end = body.find(&close).map_or(body.len(), |end| end + close.len());
        return Some(2 + hashes + end);
    }
    if rest.starts_with('"') {
        return closing(rest, '"');
    }
    // A lifetime has no second quote after one character.
    let character = rest.strip_prefix('\'')?;
    match character.chars().next()? {
        '\\' => closing(rest, '\''),
        c => character[c.len_utf8()..].starts_with('\'').then(|| 2 + c.len_utf8()),
    }
}

/// The length up to the quote that closes the first one.
fn closing(rest: &str, quote: char) -> Option<usize> {
    let mut is_escaped = false;
    for (i, c) in rest.char_indices().skip(1) {
        if c == quote && !is_escaped {
            return Some(i + 1);
        }
        is_escaped = c == '\\' && !is_escaped;
    }
    Some(rest.len())
}
