//! Damaged mesh files: one message with the place in the file and status 2, the same from `check`
//! and from a run on one and on two ranks.

use std::fs;
use std::path::PathBuf;

use hdf5::{File, H5Type};

use super::Folder;

fn shipped(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/meshes").join(name)
}

/// Of a mesh file, two groups of its cells, and one of its facets.
fn case(file: &str, cells: &str, facets: &str) -> String {
    format!(
        "mesh: {{file: {file}}}\n\
         materials: {{rock: {{on: [{cells}], elastic: {{young_modulus: 5.8e9, poisson_ratio: 0}}}}}}\n\
         boundary: [{{on: {facets}, displacement: {{x: 0, y: 0}}}}]\n\
         time: {{instants: [1]}}\noutput: {{directory: out}}\n"
    )
}

/// The message is all that is said, each time.
#[track_caller]
fn assert_refused(folder: &Folder, says: &str) {
    for (ranks, args) in [(1, vec!["check", "case.yaml"]), (1, vec!["case.yaml"])] {
        let answer = folder.run(ranks, &args);
        assert!(answer.stderr.starts_with(&format!("error: {says}")), "{}", answer.stderr);
        assert_eq!(answer.stderr.lines().count(), 1, "{}", answer.stderr);
        assert_eq!(answer.status, Some(2), "{}", answer.stderr);
    }
    let of_two = folder.run(2, &["case.yaml"]);
    assert!(of_two.stderr.starts_with(&format!("error: {says}")), "{}", of_two.stderr);
    assert_eq!(of_two.stderr.lines().count(), 1, "{}", of_two.stderr);
    assert_eq!(of_two.status, Some(2));
    assert!(!folder.path("out/history.csv").exists(), "{says}");
}

#[test]
fn a_damaged_text_file_of_gmsh_is_refused_with_the_line() {
    let good = fs::read_to_string(shipped("square-2.2.msh")).expect("a file of ours");
    let nodes = good.find("$EndNodes").expect("nodes");
    let cut = |at: usize| (&good[at..], "");
    for ((from, to), says) in [
        (cut(nodes), "$Nodes, line 38: the file ends before $EndNodes; the file is cut off"),
        (("$Nodes\n21", "$Nodes\n22"), "$Nodes, line 38: expected a number that is not negative"),
        (("$Nodes\n21", "$Nodes\n20"), "$Nodes, line 37: expected $EndNodes, found `21 "),
        (
            ("$Nodes\n21", "$Nodes\n18446744073709551615"),
            "$Nodes, line 16: 18446744073709551615 nodes cannot stand in the ",
        ),
        (("\n2 1 0 0\n", "\n2 nan 0 0\n"), "$Nodes, line 18: a coordinate is NaN"),
        (("\n2 1 0 0\n", "\n2 1 1e400 0\n"), "$Nodes, line 18: a coordinate is inf"),
        (("\n2 1 0 0\n", "\n99 1 0 0\n"), "$Elements, line 43: element 3 has node 2, which $Nodes"),
        (("\n8\n0 1", "\n4000000000\n0 1"), "$PhysicalNames, line 14: expected dimension, number"),
    ] {
        let folder = Folder::with(&case("square.msh", "\"all of it\"", "bottom"));
        let bad = good.replacen(from, to, 1);
        assert_ne!(bad, good, "{from}");
        fs::write(folder.path("square.msh"), bad).expect("a folder of ours");
        assert_refused(&folder, &format!("square.msh: {says}"));
    }
}

#[test]
fn a_damaged_binary_file_of_gmsh_is_refused_with_the_byte() {
    let good = fs::read(shipped("square-4.1-binary.msh")).expect("a file of ours");
    let find = |word: &str| {
        let at = good.windows(word.len()).position(|bytes| bytes == word.as_bytes());
        at.unwrap_or_else(|| panic!("no {word}"))
    };
    // Behind a section's name: blocks, all nodes, smallest and largest number.
    let (nodes, elements) = (find("$Nodes") + 7, find("$Elements") + 10);
    let end = find("$EndNodes");
    let set = |at: usize, value: u64| {
        let mut bytes = good.clone();
        bytes[at..at + 8].copy_from_slice(&value.to_le_bytes());
        bytes
    };
    // A block: dimension, entity, parameters, how many nodes; their numbers; their coordinates.
    let first = nodes + 32;
    for (bytes, says) in [
        (good[..end - 11].to_vec(), format!("$Nodes, byte {}: expected 8 bytes, 6 are", end - 17)),
        (set(nodes + 8, 20), format!("$Nodes, byte {}: 20 nodes are promised, the", end - 9)),
        (set(nodes + 8, u64::MAX), format!("$Nodes, byte {}: {} nodes", nodes + 24, u64::MAX)),
        (set(first + 28, f64::NAN.to_bits()), format!("$Nodes, byte {}: a co", first + 28)),
        (set(elements, 1 << 60), format!("$Elements, byte {}: {}", elements + 24, 1_u64 << 60)),
        (set(elements + 60, 77), format!("$Elements, byte {}: element 1 has", elements + 60)),
    ] {
        let folder = Folder::with(&case("square.msh", "\"all of it\"", "bottom"));
        fs::write(folder.path("square.msh"), bytes).expect("a folder of ours");
        assert_refused(&folder, &format!("square.msh: {says}"));
    }
}

#[test]
fn groups_without_cells_are_refused_with_those_that_there_are() {
    let good = fs::read_to_string(shipped("square-2.2.msh")).expect("a file of ours");
    let empty = good.replacen("$PhysicalNames\n8", "$PhysicalNames\n9\n2 77 \"void\"", 1);
    let there = "groups with the numbers of their elements: cells ";
    for (cells, facets, says) in [
        ("void", "bottom", "material `rock`: the group `void` has no elements; "),
        ("\"all of it\"", "void", "surface `void`: the group `void` has no elements; "),
        ("bottom", "bottom", "material `rock`: the group `bottom` has facets, not cells; "),
    ] {
        let folder = Folder::with(&case("square.msh", cells, facets));
        fs::write(folder.path("square.msh"), &empty).expect("a folder of ours");
        assert_refused(&folder, &format!("square.msh: {says}{there}"));
    }
}

/// Changes a list of numbers.
fn change<T: H5Type>(file: &File, at: &str, how: impl FnOnce(&mut Vec<T>)) {
    let list = file.dataset(at).expect("a dataset");
    let mut values = list.read_raw::<T>().expect("numbers");
    how(&mut values);
    list.write_raw(&values).expect("numbers");
}

/// A list of which nothing is stored, with another attribute that says how long it is.
fn huge(file: &File, at: &str, rows: i64) {
    file.unlink(at).expect("a link");
    let shape = 3 * rows as usize;
    let list = file.new_dataset::<f64>().no_chunk().shape(shape).create(at).expect("a dataset");
    list.new_attr::<i64>().create("NBR").and_then(|n| n.write_scalar(&rows)).expect("a number");
}

#[test]
fn a_damaged_file_of_med_is_refused_with_the_dataset() {
    const STEP: &str = "/ENS_MAA/part/-0000000000000000001-0000000000000000001";
    const FAMILY: &str = "/FAS/part/ELEME/Family_-4/GRO/NOM";
    let (nodes, cells) = (format!("{STEP}/NOE/COO"), format!("{STEP}/MAI/HE8/NOD"));
    let count = |file: &File, at: &str, rows: i64| {
        let attribute = file.dataset(at).and_then(|list| list.attr("NBR")).expect("a count");
        attribute.write_scalar(&rows).expect("a number");
    };
    type Damage<'d> = Box<dyn Fn(&File) + 'd>;
    let damages: Vec<(Damage, String)> = vec![
        (
            Box::new(|file| count(file, &nodes, 13)),
            format!("{nodes}: 36 entries where NBR says 13 nodes of 3 coordinates"),
        ),
        (
            Box::new(|file| count(file, &cells, i64::MAX)),
            format!("{cells}: 16 entries where NBR says {} elements of 8 nodes", i64::MAX),
        ),
        (
            Box::new(|file| change(file, &cells, |list: &mut Vec<i64>| list[2] = 13)),
            format!("{cells}: node 2 of element 1 is 13; nodes go from 1 to 12"),
        ),
        (
            Box::new(|file| change(file, &nodes, |list: &mut Vec<f64>| list[14] = f64::NAN)),
            format!("{nodes}: the coordinate y of node 3 is NaN"),
        ),
        (
            Box::new(|file| huge(file, &nodes, 1 << 50)),
            format!("{nodes}: {} entries are more than what is stored of them", 3_u64 << 50),
        ),
        (
            // All names of the groups of a family.
            Box::new(|file| change(file, FAMILY, |names: &mut Vec<[i8; 80]>| names.fill([32; 80]))),
            "material `rock`: there is no group `lower`; groups with the numbers".into(),
        ),
    ];
    let mesh = |folder: &Folder| folder.path("part.med");
    for (damage, says) in damages {
        let folder = Folder::with(&case("part.med", "lower", "bottom"));
        // HDF5 locks the file that it changes, and a process that another test starts meanwhile
        // keeps that lock: the case gets a copy.
        let changed = folder.path("changed.med");
        fs::copy(shipped("med_hex8.med"), &changed).expect("a folder of ours");
        let file = File::open_rw(&changed).expect("a good file");
        damage(&file);
        file.close().expect("a file of ours");
        fs::copy(&changed, mesh(&folder)).expect("a folder of ours");
        let of_reader = format!("cannot read the MED file part.med: {says}");
        let says = if says.starts_with('/') { of_reader } else { format!("part.med: {says}") };
        assert_refused(&folder, &says);
    }
    let folder = Folder::with(&case("part.med", "lower", "bottom"));
    let good = fs::read(shipped("med_hex8.med")).expect("a file of ours");
    fs::write(mesh(&folder), &good[..9000]).expect("a folder of ours");
    let says = "cannot read the mesh file part.med: it is not a whole HDF5 file (";
    assert_refused(&folder, says);
}
