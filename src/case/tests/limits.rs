//! What is too large is refused in words, before it costs memory or time.

use super::mistakes::message;
use super::*;

fn refusal(text: &str) -> String {
    match Case::read(text, Path::new("case.yaml"), &[]) {
        Err(Error::Input(text)) => text,
        other => panic!("{other:?}"),
    }
}

#[test]
fn texts_that_no_one_writes_are_refused_with_their_limit() {
    let ten = |of: &str| [of; 10].join(", ");
    let bomb = format!(
        "a: &a [{}]\nb: &b [{}]\nc: &c [{}]\nd: [{}]\n",
        ten("x"),
        ten("*a"),
        ten("*b"),
        ten("*c")
    ) + &format!("e: [{}]\n", ten("*c"));
    let stairs: String = (0..70).map(|i| " ".repeat(i) + "a:\n").collect();
    let too_deep = "lists and sections are nested deeper than 64";
    for (text, words) in [
        ("[".repeat(65), too_deep),
        ("{a: ".repeat(65), too_deep),
        (stairs, too_deep),
        ("- &a x\n".repeat(101), "there are more than 100 anchors"),
        (format!("- &a x\n{}", "- *a\n".repeat(101)), "there are more than 100 aliases"),
        (bomb, "aliases repeat more than 10000 values"),
        ("a: &a {b: *a}\n".to_owned(), "recursive references"),
        ("- a\n".repeat(400_000), "there are more than 400000 values, lists and sections"),
        (format!("a: {}\n", "x".repeat(5000)), "a text of 5000 bytes; at most 4096 are read"),
        (format!("{}: a\n", "x".repeat(5000)), "a text of 5000 bytes; at most 4096 are read"),
        ("a: \"\\e[2J\"".to_owned(), "a text holds the control character \\u{1b}"),
    ] {
        let told = refusal(&text);
        assert!(told.contains(words) && !told.contains('\n'), "{words}: {told}");
    }
}

#[test]
fn a_message_repeats_only_the_beginning_of_what_was_written() {
    let told = refusal(&format!("{}: a\n", "x".repeat(900)));
    let longest = told.lines().map(str::len).max().unwrap_or(0);
    assert!(told.contains("xxx...") && longest < 500, "{told}");
}

#[test]
fn lists_have_a_largest_length() {
    for (path, entry, most) in [
        ("expect", "{quantity: joint.damage, at: 1, equals: 0, absolute: 1}", 10_000),
        ("probes", "{name: mid, at: [0.5, 0.5, 1]}", 1000),
    ] {
        let list = format!("{path}=[{}]", vec![entry; most + 1].join(","));
        let told = message("mesh", "mesh", &[&list]);
        let words = format!("{path} must have at most {most} entries, got {}", most + 1);
        assert!(told.contains(&words) && told.len() < 1000, "{told}");
    }
}

#[test]
fn overrides_are_limited_in_number_and_length() {
    let many = vec!["title=x"; 1001];
    assert_eq!(message("mesh", "mesh", &many), "--set is given 1001 times; at most 1000");
    let long = format!("title={}", "x".repeat(1 << 20));
    let told = message("mesh", "mesh", &[&long]);
    assert!(told.starts_with("--set: 1048582 bytes are given in all"), "{told}");
    let path = format!("{}b=1", "a.".repeat(64));
    let told = message("mesh", "mesh", &[&path]);
    assert!(told.ends_with("65 names in front of `=`; at most 64 are read"), "{told}");
    let told = message("mesh", "mesh", &[&format!("x={}", "[".repeat(65))]);
    assert!(told.ends_with("nested deeper than 64"), "{told}");
}

#[test]
fn a_history_that_would_fill_the_memory_is_refused() {
    let instants: Vec<String> = (1..=10_000).map(|t| t.to_string()).collect();
    let probes: Vec<String> =
        (0..200).map(|i| format!("{{name: p{i}, at: [0.5, 0.5, 1]}}")).collect();
    let told = message(
        "mesh",
        "mesh",
        &[
            &format!("time.instants=[{}]", instants.join(",")),
            &format!("probes=[{}]", probes.join(",")),
        ],
    );
    assert!(told.contains("make history.csv too long: 10000 instants of "), "{told}");
}
