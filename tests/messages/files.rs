//! Case files that cannot be read, and output directories that cannot be used.

use std::fs;
use std::time::{Duration, Instant};

use super::{Folder, PROGRAM, SCENE};

#[test]
fn a_case_file_that_cannot_be_read_is_named_with_the_reason() {
    let folder = Folder::new();
    fs::write(folder.path("empty.yaml"), "").expect("a folder of ours");
    fs::write(folder.path("binary.yaml"), [0xff, 0xfe]).expect("a folder of ours");
    fs::create_dir(folder.path("folder.yaml")).expect("a folder of ours");
    for (case, says) in [
        ("empty.yaml", "the case file is empty; cases/wtnv146/case.yaml is an example"),
        ("binary.yaml", "the case file is not UTF-8 text"),
        ("folder.yaml", "is a directory; name the case file in it"),
        ("none.yaml", "there is no such case file"),
        // A file whose start nobody can read, not even root.
        ("/proc/self/mem", "the case file cannot be read: Input/output error (os error 5)"),
    ] {
        for (ranks, args) in [(1, vec!["check", case]), (1, vec![case]), (2, vec![case])] {
            let answer = folder.run(ranks, &args);
            assert_eq!(answer.stderr, format!("error: {case}: {says}\n"));
            assert_eq!(answer.status, Some(2), "{case}");
        }
    }
}

#[test]
fn an_output_directory_that_cannot_be_made_ends_with_status_4() {
    let folder = Folder::new();
    for (ranks, who) in [(1, ""), (2, "rank 0: ")] {
        let answer = folder.run(ranks, &["case.yaml", "--output", "case.yaml/out"]);
        let says =
            "cannot create the output directory case.yaml/out: Not a directory (os error 20)";
        assert_eq!(answer.stderr, format!("error: {who}{says}\n"));
        assert_eq!(answer.status, Some(4));
    }
    assert_eq!(folder.read("case.yaml"), SCENE);
}

#[test]
fn results_of_another_case_are_kept_unless_overwritten() {
    let folder = Folder::new();
    assert_eq!(folder.run(1, &["case.yaml", "--quiet"]).status, Some(0));
    let before = folder.read("out/history.csv");
    let other = ["case.yaml", "--set", "materials.rock.elastic.young_modulus=6.0e9"];
    for ranks in [1, 2] {
        let answer = folder.run(ranks, &other);
        let says = "error: the output directory out holds results of another case (scene): \
                    `materials.rock.elastic.young_modulus` differs; choose another with --output \
                    DIR, or replace them with --overwrite\n";
        assert_eq!((answer.status, answer.stderr.as_str()), (Some(2), says));
    }
    // A case that is found wrong only once its mesh exists costs no results either.
    let wrong = "boundary.1.displacement.z={formula: \"1e-4*t/x\"}";
    let answer = folder.run(2, &["case.yaml", "--overwrite", "--set", wrong]);
    assert_eq!(answer.status, Some(2));
    assert_eq!(folder.read("out/history.csv"), before);

    assert_eq!(folder.run(1, &["case.yaml", "--quiet"]).status, Some(0), "the same case again");
    assert_eq!(folder.read("out/history.csv"), before);
    let mut overwrite = other.to_vec();
    overwrite.push("--overwrite");
    assert_eq!(folder.run(2, &overwrite).status, Some(0));
    assert_ne!(folder.read("out/history.csv"), before);
}

#[test]
fn a_reader_that_goes_away_does_not_stop_a_run() {
    let folder = Folder::new();
    let start = Instant::now();
    let line = format!("{PROGRAM} check case.yaml | head -c 1");
    let output = std::process::Command::new("sh")
        .args(["-c", &line])
        .current_dir(&folder.0)
        .output()
        .expect("a shell");
    assert_eq!(String::from_utf8_lossy(&output.stderr), "");
    assert!(start.elapsed() < Duration::from_secs(10));
}
