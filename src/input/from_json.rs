//! The tree of what a program has built, which is checked as that of a file is.

use serde_json::Value as Json;

use super::tree::{Data, Entry, Node, Origin, check_text};

impl Node {
    /// The tree of a value; its parts are numbered in their order.
    ///
    /// # Errors
    /// The path of a text that no file may hold, and why.
    pub fn from_json(value: &Json) -> Result<Node, String> {
        let mut builder = Builder { parts: 0, path: Vec::new() };
        builder.node(value).map_err(|reason| {
            let path = builder.path.join(".");
            if path.is_empty() { reason } else { format!("{path}: {reason}") }
        })
    }
}

struct Builder {
    parts: usize,
    /// Down to the part that is being built, or could not be.
    path: Vec<String>,
}

impl Builder {
    fn node(&mut self, value: &Json) -> Result<Node, String> {
        let origin = Origin::Code(self.parts);
        self.parts += 1;
        let data = match value {
            Json::Null => Data::Empty,
            Json::Bool(flag) => Data::Flag(*flag),
            Json::Number(number) => match number.as_i64() {
                Some(number) => Data::Integer(number),
                None => Data::Number(number.as_f64().unwrap_or(f64::NAN)),
            },
            Json::String(text) => {
                check_text(text)?;
                Data::Text(text.clone())
            }
            Json::Array(items) => {
                let below = items.iter().enumerate();
                let list = below.map(|(index, item)| self.below(&index.to_string(), item));
                Data::List(list.collect::<Result<_, _>>()?)
            }
            Json::Object(object) => {
                let mut entries = Vec::with_capacity(object.len());
                for (key, item) in object {
                    if key.is_empty() {
                        return Err("a key is empty".to_owned());
                    }
                    check_text(key)?;
                    let node = self.below(key, item)?;
                    entries.push(Entry { key: key.clone(), origin: node.origin, node });
                }
                Data::Map(entries)
            }
        };
        Ok(Node { data, origin })
    }

    /// The path stays where something is wrong.
    fn below(&mut self, step: &str, value: &Json) -> Result<Node, String> {
        self.path.push(step.to_owned());
        let node = self.node(value)?;
        self.path.pop();
        Ok(node)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn a_value_is_the_same_as_a_tree_and_keeps_its_order() {
        let value = json!({"a": [1, 2.5, u64::MAX], "b": {"c": "text", "d": true}});
        let tree = Node::from_json(&value).expect("a tree");
        assert_eq!(tree.to_json()["a"][0], 1);
        assert_eq!(tree.to_json()["a"][2], u64::MAX as f64);
        assert_eq!(tree.to_json()["b"], value["b"]);
        assert!(tree.locate("a.1") < tree.locate("b.c"));
    }

    #[test]
    fn what_no_file_may_hold_is_refused_with_its_path() {
        let refused = |value: Json| Node::from_json(&value).expect_err("a refusal");
        let found = refused(json!({"list": ["good", "steers \u{1b}[2J"]}));
        assert_eq!(found, "list.1: a text holds the control character \\u{1b}");
        assert_eq!(refused(json!({"a": {"": 1}})), "a: a key is empty");
        assert_eq!(refused(json!("x".repeat(5000))), "a text of 5000 bytes; at most 4096 are read");
    }
}
