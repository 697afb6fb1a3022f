//! The check of a tree against the JSON Schema of the types that it becomes.

use std::collections::BTreeSet;

use serde_json::Value as Json;

use super::problems::{Problems, nearest, shortened, suggestion};
use super::tree::{Data, Entry, Node, Origin};
use crate::error::number_text;

/// Most keys of one section, the named ones too.
const MOST_KEYS: usize = 1000;

/// Takes null away wherever it stands for a key that is left out: in a case file such a key is
/// not written at all.
fn without_null(schema: &mut Json) {
    match schema {
        Json::Array(items) => items.iter_mut().for_each(without_null),
        Json::Object(object) => {
            if object.get("default").is_some_and(Json::is_null) {
                object.remove("default");
            }
            if let Some(Json::Array(types)) = object.get_mut("type") {
                types.retain(|name| name != "null");
                if let [only] = &types[..] {
                    let only = only.clone();
                    object.insert("type".to_owned(), only);
                }
            }
            if let Some(Json::Array(choices)) = object.get_mut("anyOf") {
                choices.retain(|choice| choice["type"] != "null");
                if let [Json::Object(only)] = &choices[..] {
                    let only = only.clone();
                    object.remove("anyOf");
                    object.extend(only);
                }
            }
            object.values_mut().for_each(without_null);
        }
        _ => {}
    }
}

/// Checks a tree against the schema, takes unknown and repeated keys out of it, and returns the
/// sections that cannot be read; `whole` is what messages call the file.
pub(crate) fn check_against(
    root: &'static Json,
    whole: &'static str,
    tree: &mut Node,
    problems: &mut Problems,
) -> BTreeSet<String> {
    let mut walk = Walk { root, whole, problems, broken: BTreeSet::new() };
    walk.node(root, tree, "");
    walk.broken
}

/// The schema of a file whose sections are of this type.
pub(crate) fn schema_of<T: schemars::JsonSchema>() -> Json {
    let mut schema = schemars::schema_for!(T).to_value();
    without_null(&mut schema);
    schema
}

struct Walk<'a, 'p> {
    root: &'static Json,
    whole: &'static str,
    problems: &'a mut Problems<'p>,
    broken: BTreeSet<String>,
}

/// What a reference refers to.
fn resolve(root: &'static Json, mut schema: &'static Json) -> &'static Json {
    while let Some(name) = schema["$ref"].as_str() {
        schema = &root["$defs"][name.trim_start_matches("#/$defs/")];
    }
    schema
}

impl Walk<'_, '_> {
    /// A mistake that keeps the section from being read.
    fn breaks(&mut self, node: &Node, path: &str, reason: &str) {
        let section = path.split('.').next().unwrap_or_default();
        self.broken.insert(section.to_owned());
        let subject = if path.is_empty() { self.whole } else { path };
        self.problems.at(node.origin, format!("{subject} {reason}"));
    }

    fn node(&mut self, schema: &'static Json, node: &mut Node, path: &str) {
        if self.problems.is_full() {
            return;
        }
        let schema = resolve(self.root, schema);
        if node.data == Data::Empty && *schema != Json::Bool(true) {
            let is_built = matches!(node.origin, Origin::Code(_));
            // The one thing that a program can build and JSON cannot write.
            let reason = if is_built { "must be finite" } else { "has no value" };
            return self.breaks(node, path, reason);
        }
        if let Some(choices) = schema["anyOf"].as_array().or(schema["oneOf"].as_array()) {
            return self.choice(choices, node, path);
        }
        if let Some(words) = words_of(schema) {
            return self.word(&words, node, path);
        }
        let Some(wanted) = schema["type"].as_str() else { return };
        if !is_of(wanted, node) {
            let reason = format!("must be {}, got {}", name_of(wanted), node.describe());
            return self.breaks(node, path, &reason);
        }
        match node.data {
            Data::Integer(number) => self.bounds(schema, number as f64, node, path),
            Data::Number(number) => self.bounds(schema, number, node, path),
            Data::List(_) => self.list(schema, node, path),
            Data::Map(_) => self.map(schema, node, path),
            _ => {}
        }
    }

    fn bounds(&mut self, schema: &Json, number: f64, node: &Node, path: &str) {
        let got = number_text(number);
        if !number.is_finite() {
            return self.breaks(node, path, &format!("must be finite, got {got}"));
        }
        let bound = |name: &str| schema[name].as_f64();
        let reason = if bound("exclusiveMinimum").is_some_and(|low| number <= low) {
            match bound("exclusiveMinimum") {
                Some(low) if low != 0.0 => format!("must be above {low}"),
                _ => "must be positive".to_owned(),
            }
        } else if let Some(low) = bound("minimum").filter(|low| number < *low) {
            format!("must be at least {low}")
        } else if let Some(high) = bound("exclusiveMaximum").filter(|high| number >= *high) {
            format!("must be below {high}")
        } else if let Some(high) = bound("maximum").filter(|high| number > *high) {
            format!("must be at most {high}")
        } else {
            return;
        };
        self.breaks(node, path, &format!("{reason}, got {got}"));
    }

    fn list(&mut self, schema: &'static Json, node: &mut Node, path: &str) {
        let Data::List(items) = &mut node.data else { return };
        let (length, low, high) =
            (items.len() as u64, schema["minItems"].as_u64(), schema["maxItems"].as_u64());
        let too_many = high.is_some_and(|high| length > high);
        // Too many are not looked at one by one.
        if !too_many {
            for (index, item) in items.iter_mut().enumerate() {
                self.node(&schema["items"], item, &join(path, &index.to_string()));
            }
        }
        let wanted = match (low, high) {
            (Some(low), Some(high)) if low == high => format!("{low}"),
            (Some(low), Some(high)) => format!("{low} to {high}"),
            (Some(low), None) => format!("at least {low}"),
            (None, Some(high)) => format!("at most {high}"),
            (None, None) => return,
        };
        if too_many || low.is_some_and(|low| length < low) {
            self.breaks(node, path, &format!("must have {wanted} entries, got {length}"));
        }
    }

    fn map(&mut self, schema: &'static Json, node: &mut Node, path: &str) {
        let origin = node.origin;
        let Data::Map(entries) = &mut node.data else { return };
        if entries.len() > MOST_KEYS {
            let reason = format!("must have at most {MOST_KEYS} entries, got {}", entries.len());
            return self.breaks(node, path, &reason);
        }
        let known = keys_of(schema);
        let mut kept: Vec<Entry> = Vec::with_capacity(entries.len());
        let mut misspelt: BTreeSet<String> = BTreeSet::new();
        let mut is_misspelt = false;
        for mut entry in entries.drain(..) {
            let here = join(path, &entry.key);
            if kept.iter().any(|other| other.key == entry.key) {
                self.problems.at(entry.origin, format!("{here} is given twice"));
                continue;
            }
            if let Some(inner) = schema["properties"].get(&entry.key) {
                self.node(inner, &mut entry.node, &here);
            } else if schema["additionalProperties"].is_object() {
                self.node(&schema["additionalProperties"], &mut entry.node, &here);
            } else if schema["additionalProperties"] != Json::Bool(true) {
                misspelt.extend(self.unknown(&entry, &known, path).cloned());
                is_misspelt = true;
                continue;
            }
            kept.push(entry);
        }
        *entries = kept;
        let too_few = schema["minProperties"].as_u64().unwrap_or(0) > entries.len() as u64;
        let required = schema["required"].as_array().into_iter().flatten();
        for name in required.filter_map(Json::as_str) {
            if entries.iter().any(|entry| entry.key == name) {
                continue;
            }
            self.broken.insert(join(path, name).split('.').next().unwrap_or_default().to_owned());
            // A key that was meant by a misspelt one is not told twice.
            if !misspelt.contains(name) {
                self.problems.at(origin, format!("{} is missing", join(path, name)));
            }
        }
        if too_few && is_misspelt {
            // It has entries, of which the reader has been told.
            self.broken.insert(path.split('.').next().unwrap_or_default().to_owned());
        } else if too_few {
            self.breaks(node, path, "has no entries");
        }
    }

    /// Tells of a key that is none of the known ones; which of them was meant, if that is clear.
    fn unknown<'k>(
        &mut self,
        entry: &Entry,
        known: &'k [String],
        path: &str,
    ) -> Option<&'k String> {
        let here = join(path, &entry.key);
        let here = shortened(&here);
        let meant = truth(&entry.key).and_then(|flag| word_of_truth(flag, known));
        let hint = match meant {
            Some(word) => {
                format!(": tools for YAML 1.1 write the key {word} so; put it in quotes, '{word}':")
            }
            None if known.is_empty() => format!("; {path} has none, write {{}}"),
            None => suggestion(&entry.key, known),
        };
        self.problems.at(entry.origin, format!("{here} is not a known key{hint}"));
        meant.or_else(|| nearest(&entry.key, known))
    }

    /// One of several forms: words, numbers, lists, and sections told apart by their keys.
    fn choice(&mut self, choices: &'static [Json], node: &mut Node, path: &str) {
        let choices: Vec<&'static Json> =
            choices.iter().map(|one| resolve(self.root, one)).collect();
        let words: Vec<String> = choices.iter().filter_map(|one| words_of(one)).flatten().collect();
        if let (Data::Text(_), false) = (&node.data, words.is_empty()) {
            return self.word(&words, node, path);
        }
        let fitting: Vec<&'static Json> = choices
            .iter()
            .copied()
            .filter(|one| words_of(one).is_none())
            .filter(|one| one["type"].as_str().is_some_and(|wanted| is_of(wanted, node)))
            .collect();
        let Data::Map(entries) = &node.data else {
            return match fitting.first() {
                Some(one) => self.node(one, node, path),
                None => {
                    let (forms, got) = (forms_of(&choices), node.describe());
                    let hint = hint_of_truth(&node.data, &words);
                    self.breaks(node, path, &format!("must be {forms}, got {got}{hint}"))
                }
            };
        };
        let known: Vec<String> = fitting.iter().flat_map(|one| keys_of(one)).collect();
        let named: Vec<&String> =
            entries.iter().map(|entry| &entry.key).filter(|key| known.contains(key)).collect();
        match (&named[..], entries.first()) {
            ([_, _, ..], _) => {
                let has_all = |one: &&&'static Json| {
                    let keys = keys_of(one);
                    named.iter().all(|key| keys.contains(key))
                };
                if let Some(one) = fitting.iter().find(has_all) {
                    return self.node(one, node, path);
                }
                let told: Vec<String> = fitting.iter().flat_map(|one| told_keys(one)).collect();
                let reason = format!("must have one of the keys {}", told.join(", "));
                self.breaks(node, path, &reason);
            }
            ([key], _) => {
                if let Some(one) = fitting.iter().find(|one| keys_of(one).contains(key)) {
                    self.node(one, node, path);
                }
            }
            ([], Some(entry)) => {
                let hint = suggestion(&entry.key, &known);
                let (origin, here) = (entry.origin, shortened(&join(path, &entry.key)));
                self.breaks(
                    &Node { data: Data::Empty, origin },
                    &here,
                    &format!("is not a known key{hint}"),
                );
            }
            ([], None) => {
                let reason = format!("must be {}, got an empty section", forms_of(&choices));
                self.breaks(node, path, &reason);
            }
        }
    }

    fn word(&mut self, words: &[String], node: &Node, path: &str) {
        match &node.data {
            Data::Text(text) if words.contains(text) => {}
            Data::Text(text) => {
                let hint = suggestion(text, words);
                self.breaks(node, path, &format!("cannot be `{text}`{hint}"));
            }
            data => {
                let (known, got) = (words.join(", "), node.describe());
                let hint = hint_of_truth(data, words);
                self.breaks(node, path, &format!("must be one of {known}, got {got}{hint}"));
            }
        }
    }
}

/// Whether a key is one of the words for true and false.
fn truth(key: &str) -> Option<bool> {
    let key = key.to_ascii_lowercase();
    key.parse().ok()
}

/// The known word that YAML 1.1 takes for true or false, and which its tools write so.
fn word_of_truth(flag: bool, known: &[String]) -> Option<&String> {
    let words = if flag { ["on", "yes", "y"] } else { ["off", "no", "n"] };
    known.iter().find(|word| words.contains(&word.as_str()))
}

/// What is said of true or false where one of these words is wanted.
fn hint_of_truth(data: &Data, words: &[String]) -> String {
    let Data::Flag(flag) = data else { return String::new() };
    let word = word_of_truth(*flag, words);
    word.map_or_else(String::new, |word| {
        format!(": tools for YAML 1.1 write the word {word} so; put it in quotes, '{word}'")
    })
}

fn join(path: &str, step: &str) -> String {
    if path.is_empty() { step.to_owned() } else { format!("{path}.{step}") }
}

/// The words that a schema admits, where it admits nothing else.
fn words_of(schema: &Json) -> Option<Vec<String>> {
    let words = |list: &[Json]| list.iter().map(|word| word.as_str().map(str::to_owned)).collect();
    if let Some(word) = schema["const"].as_str() {
        return Some(vec![word.to_owned()]);
    }
    if let Some(list) = schema["enum"].as_array() {
        return words(list);
    }
    let choices = schema["oneOf"].as_array()?;
    choices.iter().map(words_of).collect::<Option<Vec<_>>>().map(|lists| lists.concat())
}

fn keys_of(schema: &Json) -> Vec<String> {
    schema["properties"].as_object().into_iter().flatten().map(|(key, _)| key.clone()).collect()
}

/// The keys that tell a section: those that it must have, or all.
fn told_keys(schema: &Json) -> Vec<String> {
    let must = |key: &String| {
        let required = schema["required"].as_array();
        required.is_none_or(|list| list.iter().any(|name| name.as_str() == Some(key)))
    };
    keys_of(schema).into_iter().filter(must).collect()
}

fn is_of(wanted: &str, node: &Node) -> bool {
    matches!(
        (wanted, &node.data),
        ("integer" | "number", Data::Integer(_))
            | ("number", Data::Number(_))
            | ("string", Data::Text(_))
            | ("boolean", Data::Flag(_))
            | ("array", Data::List(_))
            | ("object", Data::Map(_))
    )
}

fn name_of(kind: &str) -> &str {
    match kind {
        "integer" => "a whole number",
        "number" => "a number",
        "string" => "a text (in quotes if it looks like a number)",
        "boolean" => "true or false",
        "array" => "a list",
        _ => "a section",
    }
}

/// The forms of a choice in words: `a number, {table: ...} or {formula: ...}`.
fn forms_of(choices: &[&Json]) -> String {
    let forms: Vec<String> = choices
        .iter()
        .map(|one| match (words_of(one), one["type"].as_str()) {
            (Some(words), _) => words.join(", "),
            (None, Some("object")) => format!("{{{}: ...}}", told_keys(one).join(", ")),
            (None, kind) => name_of(kind.unwrap_or_default()).to_owned(),
        })
        .collect();
    match forms.split_last() {
        Some((last, rest)) if !rest.is_empty() => format!("{} or {last}", rest.join(", ")),
        _ => forms.concat(),
    }
}
