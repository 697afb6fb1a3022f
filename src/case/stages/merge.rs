//! The sections of a case as each stage has them: what it changes in the place of what was before.

use crate::input::problems::{Problems, suggestion};
use crate::input::tree::{Data, Entry, Node};

/// The word that takes away what is prescribed.
const FREE: &str = "free";
const VECTORS: [&str; 2] = ["displacement", "traction"];
/// What of the pore fluid is prescribed on a surface: one of both.
const SCALARS: [&str; 2] = ["pressure", "flux"];
/// A surface that moves as a rigid body: as a whole.
const RIGID: &str = "rigid";

/// The whole case as it is in each of its stages, without `stages`. What a stage cannot change is
/// put among the `problems`.
pub(super) fn trees(tree: &Node, problems: &mut Problems<'_>) -> Vec<Node> {
    let mut current = tree.clone();
    take(&mut current, "stages");
    let is_column = tree.get("mesh").is_some_and(|mesh| mesh.get("column").is_some());
    let mut trees = Vec::new();
    for (number, stage) in tree.get("stages").map_or(&[][..], items).iter().enumerate() {
        let path = format!("stages.{number}");
        let mut merge = Merge { tree, path, is_column, problems: &mut *problems };
        merge.boundary(stage, &mut current);
        merge.fluid(stage, &mut current);
        merge.materials(stage, &mut current);
        trees.push(current.clone());
    }
    trees
}

/// A stage that is put over what was before.
struct Merge<'m, 'p> {
    tree: &'m Node,
    path: String,
    is_column: bool,
    problems: &'m mut Problems<'p>,
}

impl Merge<'_, '_> {
    fn add(&mut self, path: &str, reason: impl std::fmt::Display) {
        self.problems.add(self.tree, &format!("{}.{path}", self.path), reason);
    }

    fn boundary(&mut self, stage: &Node, current: &mut Node) {
        let changes = stage.get("boundary").map_or(&[][..], items);
        if changes.is_empty() {
            return;
        }
        let Data::List(list) = &mut section(current, "boundary", Data::List(Vec::new())).data
        else {
            return;
        };
        let mut given: Vec<(String, String)> = Vec::new();
        for (number, change) in changes.iter().enumerate() {
            let path = format!("boundary.{number}");
            let Some(on) = change.get("on").and_then(text) else { continue };
            let mut keys = VECTORS.iter().chain(&SCALARS).chain([&RIGID]);
            if keys.all(|key| change.get(key).is_none()) {
                let reason =
                    "changes nothing; give displacement, traction, pressure, flux or rigid";
                self.add(&path, reason);
            }
            for key in VECTORS {
                self.vector(&path, on, key, change, list, &mut given);
            }
            for key in SCALARS {
                let what = ("pressure or flux", &SCALARS[..]);
                self.scalar(&path, on, (key, what), change, list, &mut given);
            }
            self.scalar(&path, on, (RIGID, (RIGID, &[RIGID])), change, list, &mut given);
        }
        list.retain(|entry| entries(entry).len() > 1);
    }

    /// Changes components of what is prescribed on a surface.
    fn vector(
        &mut self,
        path: &str,
        on: &str,
        key: &str,
        change: &Node,
        list: &mut Vec<Node>,
        given: &mut Vec<(String, String)>,
    ) {
        let Some(node) = change.get(key) else { return };
        let path = format!("{path}.{key}");
        if is_free(node) {
            let mut found = false;
            for entry in list.iter_mut().filter(|entry| is_on(entry, on)) {
                found |= take(entry, key).is_some();
            }
            self.once(&path, given, on, &format!("{key}."));
            if !found {
                self.add(&path, format!("frees what is not prescribed on `{on}`"));
            }
            return;
        }
        for part in entries(node) {
            let path = format!("{path}.{}", part.key);
            let direction = self.direction(on, &part.key);
            self.once(&path, given, on, &format!("{key}.{direction}"));
            let mut found = false;
            for entry in list.iter_mut().filter(|entry| is_on(entry, on)) {
                let Some(Data::Map(parts)) = get_mut(entry, key).map(|node| &mut node.data) else {
                    continue;
                };
                let before = parts.len();
                parts.retain(|old| self.direction(on, &old.key) != direction);
                found |= parts.len() < before;
                if parts.is_empty() {
                    take(entry, key);
                }
            }
            if !is_free(&part.node) {
                let entry = entry_on(list, on, change);
                let parts = section(entry, key, Data::Map(Vec::new()));
                if let Data::Map(parts) = &mut parts.data {
                    parts.push(part.clone());
                }
            } else if !found {
                self.add(&path, format!("frees what is not prescribed on `{on}`"));
            }
        }
    }

    /// Changes what is prescribed on a surface as a whole: a `key` of those which exclude each
    /// other, with what they are.
    fn scalar(
        &mut self,
        path: &str,
        on: &str,
        (key, (what, keys)): (&str, (&str, &[&str])),
        change: &Node,
        list: &mut Vec<Node>,
        given: &mut Vec<(String, String)>,
    ) {
        let Some(node) = change.get(key) else { return };
        let path = format!("{path}.{key}");
        self.once(&path, given, on, what);
        let mut found = false;
        for entry in list.iter_mut().filter(|entry| is_on(entry, on)) {
            found |= keys.iter().filter(|key| take(entry, key).is_some()).count() > 0;
        }
        if !is_free(node) {
            let entry = entry_on(list, on, change);
            *section(entry, key, Data::Empty) = node.clone();
        } else if !found {
            self.add(&path, format!("frees what is not prescribed on `{on}`"));
        }
    }

    /// Notes that something is changed on a surface, by the name of what it is; a name that ends
    /// with a dot stands for all that begin with it.
    fn once(&mut self, path: &str, given: &mut Vec<(String, String)>, on: &str, what: &str) {
        let same = |other: &str| {
            let covers = |a: &str, b: &str| a.ends_with('.') && b.starts_with(a);
            other == what || covers(other, what) || covers(what, other)
        };
        if given.iter().any(|(surface, other)| surface == on && same(other)) {
            self.add(path, format!("is changed twice on `{on}` in one stage"));
        }
        given.push((on.to_owned(), what.to_owned()));
    }

    /// A component by its axis, also where it is called the normal of a side of a column.
    fn direction<'k>(&self, on: &str, key: &'k str) -> &'k str {
        match on {
            _ if key != "normal" || !self.is_column => key,
            "left" | "right" => "x",
            "front" | "back" => "y",
            "bottom" | "top" => "z",
            _ => key,
        }
    }

    fn fluid(&mut self, stage: &Node, current: &mut Node) {
        let Some(changes) = stage.get("fluid") else { return };
        for change in entries(changes) {
            let path = format!("fluid.{}", change.key);
            let Some(Data::List(interfaces)) =
                get_mut(current, "interfaces").map(|node| &mut node.data)
            else {
                self.add(&path, "must name an interface, and there is none");
                continue;
            };
            let name = |node: &Node| node.get("name").and_then(text).map(str::to_owned);
            let names: Vec<String> = interfaces.iter().filter_map(&name).collect();
            let Some(interface) =
                interfaces.iter_mut().find(|i| name(i).as_ref() == Some(&change.key))
            else {
                let hint = suggestion(&change.key, &names);
                self.add(&path, format!("must name an interface{hint}"));
                continue;
            };
            let fluid = section(interface, "fluid", Data::Map(Vec::new()));
            for part in entries(&change.node) {
                *section(fluid, &part.key, Data::Empty) = part.node.clone();
            }
        }
    }

    fn materials(&mut self, stage: &Node, current: &mut Node) {
        let Some(changes) = stage.get("materials") else { return };
        for change in entries(changes) {
            let Some(materials) = get_mut(current, "materials") else { continue };
            let names: Vec<String> = entries(materials).iter().map(|e| e.key.clone()).collect();
            let Some(material) = get_mut(materials, &change.key) else {
                let hint = suggestion(&change.key, &names);
                let path = format!("materials.{}", change.key);
                self.add(&path, format!("must name a material{hint}"));
                continue;
            };
            for part in entries(&change.node) {
                let Some(old) = get_mut(material, &part.key) else {
                    let path = format!("materials.{}.{}", change.key, part.key);
                    self.add(&path, "changes what the material does not have");
                    continue;
                };
                for value in entries(&part.node) {
                    *section(old, &value.key, Data::Empty) = value.node.clone();
                }
            }
        }
    }
}

/// What the sections of a tree prescribe on surfaces: their names, and whether it is a
/// displacement, and one as a rigid body.
pub(super) fn surfaces(tree: &Node) -> Vec<(String, [bool; 2])> {
    let of = |entry: &Node| {
        let on = entry.get("on").and_then(text)?.to_owned();
        let has = |key: &str| entry.get(key).is_some_and(|of| !entries(of).is_empty());
        Some((on, [has("displacement") || has(RIGID), has(RIGID)]))
    };
    tree.get("boundary").map_or(&[][..], items).iter().filter_map(of).collect()
}

/// Puts a section into a tree in the place of the one that is there.
pub(super) fn replace(tree: &mut Node, key: &str, data: Data) {
    let origin = tree.get(key).map_or(tree.origin, |node| node.origin);
    *section(tree, key, Data::Empty) = Node { data, origin };
}

/// Takes a key out of a section.
pub(super) fn take(node: &mut Node, key: &str) -> Option<Node> {
    let Data::Map(entries) = &mut node.data else { return None };
    let place = entries.iter().position(|entry| entry.key == key)?;
    Some(entries.remove(place).node)
}

/// The first entry on a surface, or a new one.
fn entry_on<'l>(list: &'l mut Vec<Node>, on: &str, change: &Node) -> &'l mut Node {
    let place = list.iter().position(|entry| is_on(entry, on)).unwrap_or_else(|| {
        let named = entries(change).iter().filter(|entry| entry.key == "on").cloned();
        list.push(Node { data: Data::Map(named.collect()), origin: change.origin });
        list.len() - 1
    });
    &mut list[place]
}

/// The part of a section under a key, made of `data` where there is none.
fn section<'n>(node: &'n mut Node, key: &str, data: Data) -> &'n mut Node {
    let origin = node.origin;
    if !matches!(node.data, Data::Map(_)) {
        node.data = Data::Map(Vec::new());
    }
    let Data::Map(entries) = &mut node.data else { unreachable!("it is a section") };
    let place = entries.iter().position(|entry| entry.key == key).unwrap_or_else(|| {
        entries.push(Entry { key: key.to_owned(), origin, node: Node { data, origin } });
        entries.len() - 1
    });
    &mut entries[place].node
}

/// The part of a section under a key.
pub(super) fn get_mut<'n>(node: &'n mut Node, key: &str) -> Option<&'n mut Node> {
    let Data::Map(entries) = &mut node.data else { return None };
    entries.iter_mut().find(|entry| entry.key == key).map(|entry| &mut entry.node)
}

fn items(node: &Node) -> &[Node] {
    if let Data::List(items) = &node.data { items } else { &[] }
}

fn entries(node: &Node) -> &[Entry] {
    if let Data::Map(entries) = &node.data { entries } else { &[] }
}

fn text(node: &Node) -> Option<&str> {
    if let Data::Text(text) = &node.data { Some(text) } else { None }
}

fn is_free(node: &Node) -> bool {
    text(node) == Some(FREE)
}

fn is_on(entry: &Node, on: &str) -> bool {
    entry.get("on").and_then(text) == Some(on)
}
