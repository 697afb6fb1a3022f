//! The case file as a tree that knows where each of its parts was written.

use crate::error::number_text;
use serde::Deserialize;
use serde::de::{Deserializer, Error as _, MapAccess, SeqAccess, Visitor};
use serde_saphyr::Spanned;
use serde_saphyr::options::{DuplicateKeyPolicy, NonFiniteFloatPolicy};

/// Deepest nesting of lists and sections, and longest dotted path.
const DEEPEST: usize = 64;
/// Most values, lists and sections of one text.
const MOST_VALUES: usize = 400_000;
/// Most anchors, and most aliases that repeat them.
const MOST_ALIASES: usize = 100;
/// Most values, and ends of lists and sections, that all aliases together repeat.
const MOST_REPEATED: usize = 10_000;
/// Longest text of one value or key, in bytes.
const LONGEST_TEXT: usize = 4096;

/// Where a part of the tree was written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Origin {
    /// Line and column in the file, from 1.
    File(u64, u64),
    /// The position of a `--set` in the list of overrides.
    Override(usize),
    /// In a program: how many parts come before it.
    Code(usize),
}

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Node {
    pub data: Data,
    pub origin: Origin,
}

#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Data {
    Empty,
    Flag(bool),
    Integer(i64),
    Number(f64),
    Text(String),
    List(Vec<Node>),
    Map(Vec<Entry>),
}

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Entry {
    pub key: String,
    pub origin: Origin,
    pub node: Node,
}

/// Why a text is no tree, with line and column where they are known.
#[derive(Debug)]
pub(crate) struct SyntaxError {
    pub place: Option<(u64, u64)>,
    pub reason: String,
}

/// Reads YAML. Repeated keys and numbers that are not finite stay in the tree, so that they are
/// reported together with everything else.
pub(crate) fn parse(text: &str) -> Result<Node, SyntaxError> {
    let options = serde_saphyr::options! {
        strict_booleans: true,
        duplicate_keys: DuplicateKeyPolicy::PassThrough,
        non_finite_float_policy: NonFiniteFloatPolicy::PassThrough,
        with_snippet: false,
        budget: serde_saphyr::budget! {
            max_nodes: MOST_VALUES,
            max_depth: DEEPEST,
            flow_nesting_limit: DEEPEST,
            max_anchors: MOST_ALIASES,
            max_aliases: MOST_ALIASES,
            max_merge_keys: MOST_ALIASES,
        },
        alias_limits: serde_saphyr::alias_limits! {
            max_total_replayed_events: MOST_REPEATED,
            max_replay_stack_depth: 8,
        },
    };
    let root: Spanned<Data> =
        serde_saphyr::from_str_with_options(text, options).map_err(|error| SyntaxError {
            place: error.location().map(|place| (place.line(), place.column())),
            reason: reason_of(&error),
        })?;
    Ok(Node::from(root))
}

/// The parser's words without its place, which is told in front; for a limit our own.
fn reason_of(error: &serde_saphyr::Error) -> String {
    let text = error.without_snippet().to_string();
    let limits = [
        (
            "recursion limit exceeded",
            format!("lists and sections are nested deeper than {DEEPEST}"),
        ),
        ("Depth {", format!("lists and sections are nested deeper than {DEEPEST}")),
        ("Nodes {", format!("there are more than {MOST_VALUES} values, lists and sections")),
        ("Events {", format!("there are more than {MOST_VALUES} values, lists and sections")),
        ("Anchors {", format!("there are more than {MOST_ALIASES} anchors")),
        ("Aliases {", format!("there are more than {MOST_ALIASES} aliases")),
        ("MergeKeys {", format!("there are more than {MOST_ALIASES} merge keys")),
        ("alias replay", format!("aliases repeat more than {MOST_REPEATED} values")),
    ];
    if let Some((_, words)) = limits.iter().find(|(breach, _)| text.contains(breach)) {
        return words.clone();
    }
    let end = text.find(" at line ").unwrap_or(text.len());
    // What follows a semicolon is advice to programmers.
    let end = text[..end].find("; use ").unwrap_or(end);
    text[..end].lines().next().unwrap_or_default().to_owned()
}

impl From<Spanned<Data>> for Node {
    fn from(spanned: Spanned<Data>) -> Self {
        let origin = Origin::File(spanned.referenced.line(), spanned.referenced.column());
        Node { data: spanned.value, origin }
    }
}

impl<'de> Deserialize<'de> for Data {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(DataVisitor)
    }
}

/// Refuses texts that are too long to be meant, and characters that would steer a terminal.
pub(super) fn check_text(text: &str) -> Result<(), String> {
    if text.len() > LONGEST_TEXT {
        return Err(format!("a text of {} bytes; at most {LONGEST_TEXT} are read", text.len()));
    }
    match text.chars().find(|c| c.is_control() && !matches!(c, '\n' | '\t')) {
        Some(found) => {
            Err(format!("a text holds the control character {}", found.escape_unicode()))
        }
        None => Ok(()),
    }
}

struct DataVisitor;

impl<'de> Visitor<'de> for DataVisitor {
    type Value = Data;

    fn expecting(&self, formatter: &mut std::fmt::Formatter) -> std::fmt::Result {
        formatter.write_str("a value, a list or a section")
    }

    fn visit_unit<E>(self) -> Result<Data, E> {
        Ok(Data::Empty)
    }

    fn visit_none<E>(self) -> Result<Data, E> {
        Ok(Data::Empty)
    }

    fn visit_some<D: Deserializer<'de>>(self, deserializer: D) -> Result<Data, D::Error> {
        deserializer.deserialize_any(self)
    }

    fn visit_bool<E>(self, flag: bool) -> Result<Data, E> {
        Ok(Data::Flag(flag))
    }

    fn visit_i64<E>(self, number: i64) -> Result<Data, E> {
        Ok(Data::Integer(number))
    }

    fn visit_u64<E>(self, number: u64) -> Result<Data, E> {
        Ok(i64::try_from(number).map_or(Data::Number(number as f64), Data::Integer))
    }

    fn visit_i128<E>(self, number: i128) -> Result<Data, E> {
        Ok(Data::Number(number as f64))
    }

    fn visit_u128<E>(self, number: u128) -> Result<Data, E> {
        Ok(Data::Number(number as f64))
    }

    fn visit_f64<E>(self, number: f64) -> Result<Data, E> {
        Ok(Data::Number(number))
    }

    fn visit_str<E: serde::de::Error>(self, text: &str) -> Result<Data, E> {
        check_text(text).map_err(E::custom)?;
        Ok(Data::Text(text.to_owned()))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Data, A::Error> {
        let mut items = Vec::new();
        while let Some(item) = list.next_element::<Spanned<Data>>()? {
            items.push(Node::from(item));
        }
        Ok(Data::List(items))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Data, A::Error> {
        let mut entries = Vec::new();
        while let Some(key) = map.next_key::<Spanned<String>>()? {
            let origin = Origin::File(key.referenced.line(), key.referenced.column());
            if key.value.is_empty() {
                return Err(A::Error::custom("a key is empty"));
            }
            check_text(&key.value).map_err(A::Error::custom)?;
            let node = Node::from(map.next_value::<Spanned<Data>>()?);
            entries.push(Entry { key: key.value, origin, node });
        }
        Ok(Data::Map(entries))
    }
}

/// The names of a dotted path.
fn steps_of(path: &str) -> Result<Vec<&str>, String> {
    let steps: Vec<&str> = path.trim().split('.').collect();
    if steps.iter().any(|step| step.is_empty()) {
        return Err("a name in front of `=` is empty".to_owned());
    }
    if steps.len() > DEEPEST {
        let names = steps.len();
        return Err(format!("{names} names in front of `=`; at most {DEEPEST} are read"));
    }
    steps.iter().try_for_each(|step| check_text(step))?;
    Ok(steps)
}

impl Node {
    /// What it is, for messages: `the number 3`, `a list`.
    pub fn describe(&self) -> String {
        match &self.data {
            Data::Empty => "nothing".to_owned(),
            Data::Flag(flag) => format!("`{flag}`"),
            Data::Integer(number) => format!("{number}"),
            Data::Number(number) => number_text(*number),
            Data::Text(text) => {
                let shown: String = text.chars().take(40).collect();
                let more = if shown.len() < text.len() { "..." } else { "" };
                format!("the text `{shown}{more}`")
            }
            Data::List(items) => format!("a list of {}", items.len()),
            Data::Map(_) => "a section".to_owned(),
        }
    }

    /// The part of a section under a key.
    pub fn get(&self, key: &str) -> Option<&Node> {
        let Data::Map(entries) = &self.data else { return None };
        entries.iter().find(|entry| entry.key == key).map(|entry| &entry.node)
    }

    /// The same without places; a number that is not finite becomes null.
    pub fn to_json(&self) -> serde_json::Value {
        use serde_json::Value as Json;
        match &self.data {
            Data::Empty => Json::Null,
            Data::Flag(flag) => Json::from(*flag),
            Data::Integer(number) => Json::from(*number),
            Data::Number(number) => Json::from(*number),
            Data::Text(text) => Json::from(text.as_str()),
            Data::List(items) => items.iter().map(Node::to_json).collect(),
            Data::Map(entries) => Json::Object(
                entries.iter().map(|entry| (entry.key.clone(), entry.node.to_json())).collect(),
            ),
        }
    }

    /// Where the value at a dotted path was written, or the nearest section around it.
    pub fn locate(&self, path: &str) -> Origin {
        self.follow(path.split('.'), |entry| {
            // A section that spans lines is pointed at by its key.
            let is_section = matches!(entry.node.data, Data::Map(_) | Data::List(_));
            if is_section { entry.origin } else { entry.node.origin }
        })
    }

    /// Where the key at the end of these steps was written, likewise; keys may hold dots.
    pub fn locate_key<'s>(&self, steps: impl IntoIterator<Item = &'s str>) -> Origin {
        self.follow(steps, |entry| entry.origin)
    }

    fn follow<'s>(
        &self,
        steps: impl IntoIterator<Item = &'s str>,
        of_entry: impl Fn(&Entry) -> Origin,
    ) -> Origin {
        let mut here = self;
        let mut origin = self.origin;
        for step in steps {
            let next = match &here.data {
                Data::Map(entries) => {
                    let entry = entries.iter().find(|entry| entry.key == step);
                    entry.map(|entry| (&entry.node, of_entry(entry)))
                }
                Data::List(items) => step
                    .parse::<usize>()
                    .ok()
                    .and_then(|index| items.get(index))
                    .map(|item| (item, item.origin)),
                _ => None,
            };
            let Some((node, place)) = next else { break };
            (here, origin) = (node, place);
        }
        origin
    }

    /// Sets the value at the dotted path of `a.b.c=VALUE`, creating missing sections; an empty
    /// VALUE takes the key away. `number` is the position of the override.
    pub fn set(&mut self, assignment: &str, number: usize) -> Result<(), String> {
        let (path, value) =
            assignment.split_once('=').ok_or("expected a.b.c=VALUE, but there is no `=`")?;
        let mut value = match value.trim() {
            "" => Node { data: Data::Empty, origin: self.origin },
            text => parse(text).map_err(|error| error.reason)?,
        };
        let origin = Origin::Override(number);
        value.stamp(origin);
        let steps = steps_of(path)?;
        let mut here = self;
        for (depth, step) in steps.iter().enumerate() {
            let last = depth + 1 == steps.len();
            if here.data == Data::Empty {
                *here = Node { data: Data::Map(Vec::new()), origin };
            }
            if let Data::Map(entries) = &mut here.data
                && last
                && value.data == Data::Empty
            {
                entries.retain(|entry| entry.key != *step);
                return Ok(());
            }
            here = here.child(&steps[..depth], step, origin)?;
        }
        *here = value;
        Ok(())
    }

    /// What a step leads to from here, where `path` led; a key or the item after the last is made.
    fn child(&mut self, path: &[&str], step: &str, origin: Origin) -> Result<&mut Node, String> {
        let parent = if path.is_empty() { "the case".to_owned() } else { path.join(".") };
        let what = self.describe();
        let empty = Node { data: Data::Empty, origin };
        match &mut self.data {
            Data::Map(entries) => {
                let index = entries.iter().position(|entry| entry.key == step);
                let index = index.unwrap_or_else(|| {
                    entries.push(Entry { key: step.to_owned(), origin, node: empty });
                    entries.len() - 1
                });
                Ok(&mut entries[index].node)
            }
            Data::List(items) => {
                let length = items.len();
                match step.parse::<usize>() {
                    Ok(index) if index < length => Ok(&mut items[index]),
                    Ok(index) if index == length => {
                        items.push(empty);
                        Ok(&mut items[index])
                    }
                    _ => Err(format!(
                        "{parent} is a list of {length}; `{step}` is no position in it \
                         (0 to {length}, {length} appends)"
                    )),
                }
            }
            _ => Err(format!("{parent} is {what}, so `{step}` cannot be set in it")),
        }
    }

    fn stamp(&mut self, origin: Origin) {
        self.origin = origin;
        match &mut self.data {
            Data::List(items) => items.iter_mut().for_each(|item| item.stamp(origin)),
            Data::Map(entries) => entries.iter_mut().for_each(|entry| {
                entry.origin = origin;
                entry.node.stamp(origin);
            }),
            _ => {}
        }
    }
}
