//! What is too large is refused in words, before it costs memory or time.

use super::mistakes::message;
use super::*;

fn read(text: &str) -> String {
    match Case::read(text, Path::new("case.yaml"), &[]) {
        Err(Error::Input(text)) => text,
        other => panic!("{other:?}"),
    }
}

/// `GOOD` with a list of `count` entries; `None` where it is read.
fn with_list(path: &str, entry: &str, count: usize) -> Option<String> {
    let list = vec![entry; count].join(",");
    let text = GOOD.to_owned() + &format!("{path}: [{list}]\n");
    Case::read(&text, Path::new("case.yaml"), &[]).err().map(|error| error.to_string())
}

#[test]
fn probe() {
    for text in [
        "[".repeat(65), "[".repeat(64), "{a: ".repeat(65), 
        (0..70).map(|i| " ".repeat(i) + "a:\n").collect::<String>(),
        "- &a x\n".repeat(101), format!("- &a x\n{}", "- *a\n".repeat(101)),
        "- a\n".repeat(400_000), "--- a\n".repeat(2), format!("a: {}\n", "x".repeat(5000)), format!("{}: a\n", "x".repeat(5000)),  format!("{}: a\n", "x".repeat(900)),
        "a: \"\\e[2J\"".to_owned(), "a: *a\n".to_owned(), "a: &a {b: *a}\n".to_owned(),
        "a: &a [x, x, x, x, x, x, x, x, x, x, x, x, x, x, x, x]\nb: &b [*a, *a, *a, *a, *a, *a, *a, *a, *a, *a]\nc: &c [*b, *b, *b, *b, *b, *b, *b, *b, *b, *b]\nd: [*c, *c, *c, *c, *c, *c, *c, *c]\n".to_owned(),
    ] {
        println!("{}", read(&text).chars().take(300).collect::<String>());
    }
    println!("{:?}", with_list("x", "1", 3));
    println!("{}", message("mesh", "mesh", &[&format!("{}=1", "a.".repeat(65))]));
    println!("{}", message("mesh", "mesh", &[&format!("x={}", "[".repeat(65))]));
}
