//! Whatever the bytes are, there is a mesh or an error, and what a mesh refers to is there.

use proptest::prelude::*;

use super::super::super::file_mesh::FileMesh;
use super::files;
use super::read;
use super::writer::{FORMS, square_v2, square_v4};

/// The indices of a mesh lie inside it.
fn check(mesh: &FileMesh) {
    assert_eq!(mesh.points.len(), mesh.node_numbers.len());
    assert_eq!(mesh.group_sets.first(), Some(&Vec::new()));
    for block in &mesh.blocks {
        assert_eq!(block.nodes.len(), block.kind.nodes() * block.numbers.len());
        assert_eq!(block.groups.len(), block.numbers.len());
        assert!(block.nodes.iter().all(|node| (*node as usize) < mesh.points.len()));
        assert!(block.groups.iter().all(|set| (*set as usize) < mesh.group_sets.len()));
    }
    for set in &mesh.group_sets {
        assert!(set.is_sorted() && set.iter().all(|group| (*group as usize) < mesh.groups.len()));
    }
    assert!(mesh.points.iter().flatten().all(|x| x.is_finite()));
}

fn originals() -> Vec<Vec<u8>> {
    let small = FORMS.into_iter().flat_map(|form| [square_v2(form), square_v4(form)]);
    small.chain(files::NAMES.into_iter().map(files::bytes)).collect()
}

#[derive(Debug, Clone)]
enum Change {
    Set(u8),
    Flip(u8),
    Cut,
    Delete(usize),
    Repeat(usize),
    Word(&'static str),
}

const WORDS: &[&str] =
    &["-1", "0", "1e999", "nan", "18446744073709551615", "$EndNodes", "\n", " ", "99999"];

fn change() -> impl Strategy<Value = Change> {
    prop_oneof![
        any::<u8>().prop_map(Change::Set),
        (0..8_u8).prop_map(Change::Flip),
        Just(Change::Cut),
        (1..40_usize).prop_map(Change::Delete),
        (1..40_usize).prop_map(Change::Repeat),
        prop::sample::select(WORDS).prop_map(Change::Word),
    ]
}

fn apply(bytes: &mut Vec<u8>, at: usize, change: &Change) {
    let Some(at) = at.checked_rem(bytes.len()) else { return };
    let until = |length: usize| (at + length).min(bytes.len());
    match change {
        Change::Set(byte) => bytes[at] = *byte,
        Change::Flip(bit) => bytes[at] ^= 1 << bit,
        Change::Cut => bytes.truncate(at),
        Change::Delete(length) => drop(bytes.drain(at..until(*length))),
        Change::Repeat(length) => {
            let copy = bytes[at..until(*length)].to_vec();
            bytes.splice(at..at, copy);
        }
        Change::Word(word) => drop(bytes.splice(at..at, word.bytes())),
    }
}

#[test]
fn a_file_that_is_cut_anywhere_is_an_error_or_the_mesh() {
    for bytes in originals() {
        let whole = read(&bytes);
        whole.as_ref().map(check).unwrap_or_else(|e| panic!("{e}"));
        // Each place of small files, some of large ones.
        let stride = 1 + bytes.len() / 1000;
        for length in (0..bytes.len()).step_by(stride) {
            let cut = read(&bytes[..length]);
            let is_all = bytes[length..].iter().all(u8::is_ascii_whitespace);
            assert!(cut.is_err() || is_all || cut == whole, "{length} of {}", bytes.len());
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 2000,
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn changed_bytes_never_panic(
        which in any::<prop::sample::Index>(),
        changes in prop::collection::vec((any::<usize>(), change()), 1..4),
    ) {
        let originals = originals();
        let mut bytes = which.get(&originals).clone();
        for (at, change) in &changes {
            apply(&mut bytes, *at, change);
        }
        if let Ok(mesh) = read(&bytes) {
            check(&mesh);
        }
    }

    #[test]
    fn any_bytes_behind_a_header_never_panic(
        bytes in prop::collection::vec(any::<u8>(), 0..300),
        section in prop::sample::select(&["Nodes", "Elements", "Entities", "PhysicalNames"][..]),
        form in prop::sample::select(&FORMS[..]),
        version in prop::sample::select(&["2.2", "4.1"][..]),
    ) {
        let mut writer = super::writer::Writer::new(form, version);
        writer.text(&format!("${section}\n"));
        writer.bytes.extend(&bytes);
        prop_assert!(read(&writer.bytes).is_err());
        prop_assert!(read(&bytes).is_err());
    }
}
