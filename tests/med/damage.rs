//! Copies of a good file, each damaged in one way, and what is said of them.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};

use column_hpc::error::Error;
use column_hpc::mesh::import::med;
use hdf5::types::FixedAscii;
use hdf5::{File, H5Type};

use super::path;

const MESH: &str = "/ENS_MAA/part";
const STEP: &str = "/ENS_MAA/part/-0000000000000000001-0000000000000000001";
const CELLS: &str = "/ENS_MAA/part/-0000000000000000001-0000000000000000001/MAI";
const FAMILIES: &str = "/FAS/part/ELEME";

/// A file that goes when it is dropped.
struct Copy(PathBuf);

impl Copy {
    fn new() -> Self {
        static NUMBER: AtomicU32 = AtomicU32::new(0);
        let number = NUMBER.fetch_add(1, Ordering::Relaxed);
        let name = format!("column-hpc-med-{}-{number}.med", std::process::id());
        let to = std::env::temp_dir().join(name);
        fs::copy(path("hex8"), &to).expect("the temporary directory is writable");
        Self(to)
    }

    /// What is said of the file after a damage.
    fn says(&self, damage: impl FnOnce(&File)) -> String {
        let file = File::open_rw(&self.0).expect("a good file");
        damage(&file);
        file.close().expect("a file of ours");
        said(&self.0)
    }
}

impl Drop for Copy {
    fn drop(&mut self) {
        let _ = fs::remove_file(&self.0);
    }
}

fn said(path: &Path) -> String {
    match med::read(path) {
        Ok(_) => "nothing".into(),
        Err(Error::Input(text)) => text.replace(path.to_string_lossy().as_ref(), "FILE"),
        Err(other) => panic!("{other:?}"),
    }
}

#[track_caller]
fn assert_says(damage: impl FnOnce(&File), wanted: &str) {
    let says = Copy::new().says(damage);
    assert_eq!(says, format!("cannot read the MED file FILE: {wanted}"));
}

/// Changes a list of numbers, which may change its length.
fn change<T: H5Type>(file: &File, at: &str, how: impl FnOnce(&mut Vec<T>)) {
    let old = file.dataset(at).expect("a dataset");
    let rows = old.attr("NBR").and_then(|rows| rows.read_scalar::<i64>());
    let mut list = old.read_raw::<T>().expect("numbers");
    how(&mut list);
    file.unlink(at).expect("a link");
    let new = file.new_dataset::<T>().shape(list.len()).create(at).expect("a dataset");
    new.write_raw(&list).expect("numbers");
    if let Ok(rows) = rows {
        number(&new, "NBR", rows);
    }
}

fn number(of: &hdf5::Location, name: &str, value: i64) {
    let _ = of.delete_attr(name);
    let attribute = of.new_attr::<i64>().create(name).expect("an attribute");
    attribute.write_scalar(&value).expect("a number");
}

fn unlink(file: &File, at: &str) {
    file.unlink(at).expect("a link");
}

#[test]
fn what_is_no_med_file_is_said() {
    let copy = Copy::new();
    let bytes = fs::read(&copy.0).expect("a copy");
    for length in (0..bytes.len()).step_by(bytes.len() / 50) {
        fs::write(&copy.0, &bytes[..length]).expect("a copy");
        let says = said(&copy.0);
        assert!(says.contains("FILE: it is not a whole HDF5 file ("), "{length}: {says}");
    }
    fs::write(&copy.0, "$MeshFormat\n4.1 0 8\n").expect("a copy");
    assert!(said(&copy.0).contains("it is not a whole HDF5 file"));
    let none = Path::new("tests/none.med");
    let says = "cannot read the mesh file FILE: No such file or directory (os error 2)";
    assert_eq!(said(none), says);
    assert_eq!(said(Path::new("tests")), "cannot read the mesh file FILE: it is not a file");
    let missing = "it is an HDF5 file, but no MED file: /INFOS_GENERALES is missing";
    assert_says(|file| unlink(file, "INFOS_GENERALES"), missing);
    assert_says(
        |file| number(&file.group("INFOS_GENERALES").expect("a group"), "MAJ", 2),
        "/INFOS_GENERALES: it has the version 2.2; versions 3 and 4 can be read (medimport \
         converts older ones)",
    );
}

#[test]
fn wrong_nodes_are_said() {
    let at = format!("{STEP}/NOE/COO");
    assert_says(|file| unlink(file, &at), &format!("{at}: missing"));
    let says = format!("{at}: the coordinate y of node 3 is NaN");
    assert_says(|file| change(file, &at, |list: &mut Vec<f64>| list[14] = f64::NAN), &says);
    let says = format!("{at}: the coordinate z of node 12 is -inf");
    let infinite = |list: &mut Vec<f64>| list[35] = f64::NEG_INFINITY;
    assert_says(|file| change(file, &at, infinite), &says);
    let says = format!("{at}: 35 entries where NBR says 12 nodes of 3 coordinates");
    assert_says(|file| change(file, &at, |list: &mut Vec<f64>| list.truncate(35)), &says);
    let says = format!("{at}: it holds Integer(U8) where floating-point numbers are needed");
    assert_says(|file| change(file, &at, |_: &mut Vec<i64>| ()), &says);
    let square = |file: &File| {
        unlink(file, &at);
        file.new_dataset::<f64>().shape((12, 3)).create(at.as_str()).expect("a dataset");
    };
    let says = format!("{at}: it has the shape [12, 3] where a list is needed");
    assert_says(square, &says);
    let says = format!("{STEP}/NOE/NUM: it holds the number -5");
    let at = format!("{STEP}/NOE/NUM");
    assert_says(|file| change(file, &at, |list: &mut Vec<i64>| list[0] = -5), &says);
    let says = format!("{STEP}/NOE/NUM: 11 entries where there are 12 of {STEP}/NOE");
    assert_says(|file| change(file, &at, |list: &mut Vec<i64>| list.truncate(11)), &says);
}

#[test]
fn wrong_elements_are_said() {
    let at = format!("{CELLS}/HE8/NOD");
    for wrong in [0, 13, -1, i64::MIN, i64::MAX] {
        let says = format!("{at}: node 2 of element 1 is {wrong}; nodes go from 1 to 12");
        assert_says(|file| change(file, &at, |list: &mut Vec<i64>| list[2] = wrong), &says);
    }
    let says = format!("{at}: 15 entries where NBR says 2 elements of 8 nodes");
    assert_says(|file| change(file, &at, |list: &mut Vec<i64>| list.truncate(15)), &says);
    for (name, what) in [
        ("TR7", "triangles of 7 nodes"),
        ("POG", "polygons"),
        ("POE", "polyhedra"),
        ("XYZ", "a type that is not known here"),
    ] {
        let rename = |file: &File| {
            file.relink(&format!("{CELLS}/HE8"), &format!("{CELLS}/{name}")).expect("a link");
        };
        let says = format!(
            "{CELLS}/{name}: elements of type {name} ({what}) cannot be read; mesh the part anew \
             with simplices, prisms, pyramids or hexahedra"
        );
        assert_says(rename, &says);
    }
    let says = format!("{CELLS}/HE8/NOD: missing");
    assert_says(|file| unlink(file, &at), &says);
}

#[test]
fn wrong_groups_are_said() {
    let at = format!("{CELLS}/HE8/FAM");
    let says = format!("{at}: entry 2 is the family -77, which is not among those of the elements");
    assert_says(|file| change(file, &at, |list: &mut Vec<i64>| list[1] = -77), &says);
    let family = format!("{FAMILIES}/Family_-4");
    let set = |file: &File, at: &str, name: &str, value: i64| {
        number(&file.group(at).expect("a group"), name, value);
    };
    let says = format!("{family}: its number is 4; families of elements have negative numbers");
    assert_says(|file| set(file, &family, "NUM", 4), &says);
    let says = format!("{family}: another family has the number -3 too");
    assert_says(|file| set(file, &family, "NUM", -3), &says);
    let says = format!("{family}/GRO/NOM: 2 names where NBR says 3");
    assert_says(|file| set(file, &format!("{family}/GRO"), "NBR", 3), &says);
    let twice = |file: &File| {
        let long = [b'x' as i8; 80];
        change(file, &format!("{family}/GRO/NOM"), |names: &mut Vec<[i8; 80]>| names.fill(long));
    };
    let says = format!(
        "{family}/GRO/NOM: it has the group {} twice; if two names were cut off to the 80 \
         characters that the format holds, give shorter ones",
        "x".repeat(80)
    );
    assert_says(twice, &says);
}

#[test]
fn meshes_of_other_kinds_are_said() {
    let two = |file: &File| file.link_hard(MESH, "/ENS_MAA/other").expect("a link");
    let says = "/ENS_MAA: it holds 2 meshes (other, part); write the one that is wanted into a \
                file of its own";
    assert_says(two, says);
    for (name, value, says) in [
        (
            "TYP",
            1,
            "it is a structured mesh (TYP), which is not read; convert it to an unstructured one",
        ),
        ("REP", 1, "its coordinates are not Cartesian (REP)"),
        ("ESP", 1, "its space has 1 dimensions (ESP); 2 or 3 can be read"),
    ] {
        let set = |file: &File| number(&file.group(MESH).expect("a group"), name, value);
        assert_says(set, &format!("{MESH}: {says}"));
    }
}

#[test]
fn parts_of_meshes_are_refused() {
    let profile = |file: &File| {
        let nodes = file.group(&format!("{STEP}/NOE")).expect("a group");
        nodes.delete_attr("PFL").expect("an attribute");
        let attribute = nodes.new_attr::<FixedAscii<8>>().create("PFL").expect("an attribute");
        let text = FixedAscii::<8>::from_ascii("half").expect("a text");
        attribute.write_scalar(&text).expect("a text");
    };
    let says = "it tells a part of the mesh only (profile half), which is not read";
    assert_says(profile, &format!("{STEP}/NOE: {says}"));
    let joint = |file: &File| {
        file.create_group("JNT").and_then(|all| all.create_group("part")).expect("a group");
    };
    let says = "/JNT/part: the mesh is one part of several (joints); write the whole mesh into one \
                file";
    assert_says(joint, says);
}

#[test]
fn whole_numbers_of_four_bytes_are_read() {
    let copy = Copy::new();
    let shorten = |file: &File| {
        for name in ["HE8/NOD", "HE8/FAM", "HE8/NUM", "QU4/NOD"] {
            change(file, &format!("{CELLS}/{name}"), |_: &mut Vec<i32>| ());
        }
    };
    assert_eq!(copy.says(shorten), "nothing");
    assert_eq!(med::read(&copy.0), med::read(&path("hex8")));
}

#[test]
fn units_and_equivalences_are_remarked() {
    let copy = Copy::new();
    let change = |file: &File| {
        let mesh = file.group(MESH).expect("a group");
        mesh.delete_attr("UNI").expect("an attribute");
        let attribute = mesh.new_attr::<FixedAscii<48>>().create("UNI").expect("an attribute");
        let text = FixedAscii::<48>::from_ascii("mm              mm").expect("a text");
        attribute.write_scalar(&text).expect("a text");
        file.create_group(&format!("{STEP}/EQS")).expect("a group");
    };
    assert_eq!(copy.says(change), "nothing");
    let mesh = med::read(&copy.0).expect("a mesh");
    let wanted = [
        "the file gives its coordinates in mm; they are taken as m",
        "the equivalences of the file (EQS) join nothing",
    ];
    assert_eq!(mesh.remarks, wanted);
}

#[test]
fn attributes_that_are_missing_are_said_where_they_are_needed() {
    let at = format!("{CELLS}/HE8/NOD");
    let remove = |file: &File| {
        file.dataset(&at).and_then(|list| list.delete_attr("NBR")).expect("an attribute");
    };
    assert_says(remove, &format!("{at}: its attribute NBR is missing"));
    let remove = |name: &'static str| {
        move |file: &File| {
            file.group(MESH).and_then(|mesh| mesh.delete_attr(name)).expect("an attribute");
        }
    };
    assert_says(remove("ESP"), &format!("{MESH}: its attribute ESP is missing"));
    for name in ["TYP", "REP", "UNI"] {
        assert_eq!(Copy::new().says(remove(name)), "nothing", "{name}");
    }
}

#[test]
fn of_several_steps_the_last_is_read() {
    let copy = Copy::new();
    let file = File::open_rw(&copy.0).expect("a good file");
    let later = file.create_group(&format!("{MESH}/later")).expect("a group");
    number(&later, "NDT", 3);
    number(&later, "NOR", -1);
    // What does not change is a soft link inside the file.
    file.link_soft(&format!("{STEP}/MAI"), &format!("{MESH}/later/MAI")).expect("a link");
    file.link_soft(&format!("{STEP}/NOE"), &format!("{MESH}/later/NOE")).expect("a link");
    file.close().expect("a file of ours");
    let mesh = med::read(&copy.0).expect("a mesh");
    assert_eq!(mesh.points.len(), 12);
    let says = "of the 2 steps of the mesh the last one is read (number 3, iteration -1)";
    assert_eq!(mesh.remarks, [says]);
}

#[test]
fn nothing_leads_out_of_the_file() {
    let at = format!("{STEP}/NOE/COO");
    let other = path("hex8");
    let other = other.to_string_lossy();
    let external = |file: &File| {
        unlink(file, &at);
        file.link_external(&other, &at, &at).expect("a link");
    };
    let says = Copy::new().says(external);
    let wanted = format!("cannot read the mesh file FILE: {at}: a link out of the file, which");
    assert!(says.starts_with(&wanted), "{says}");

    // The same through a soft link.
    let soft = |file: &File| {
        file.link_external(&other, "/", "/elsewhere").expect("a link");
        unlink(file, &at);
        file.link_soft(&format!("/elsewhere{at}"), &at).expect("a link");
    };
    let says = Copy::new().says(soft);
    assert!(says.contains("FILE: /elsewhere: a link out of the file"), "{says}");

    let outside = |file: &File| {
        unlink(file, &at);
        let list = file.new_dataset::<f64>().no_chunk().external("numbers.raw", 0, 36 * 8);
        list.shape(36).create(at.as_str()).expect("a dataset");
    };
    let says = format!("{at}: its numbers lie in another file, which is not read");
    assert_says(outside, &says);
}

#[test]
fn lists_are_no_longer_than_what_the_file_holds() {
    let at = format!("{STEP}/NOE/COO");
    let huge = 3_usize << 40;
    let says = format!(
        "{at}: {huge} entries are more than what is stored of them; the file is damaged, or was \
         not written to its end"
    );
    for chunked in [false, true] {
        let grow = |file: &File| {
            unlink(file, &at);
            let list = file.new_dataset::<f64>();
            let list = if chunked { list.chunk(1024).deflate(9) } else { list.no_chunk() };
            list.shape(huge).create(at.as_str()).expect("a dataset");
        };
        if chunked {
            let says = Copy::new().says(grow);
            assert!(says.contains("are more than what is stored"), "{says}");
        } else {
            assert_says(grow, &says);
        }
    }
}

#[test]
fn compressed_lists_are_read_and_other_filters_refused() {
    let at = format!("{STEP}/NOE/COO");
    let filtered = |other: bool| {
        let at = at.clone();
        move |file: &File| {
            let list = file.dataset(&at).and_then(|d| d.read_raw::<f64>()).expect("numbers");
            unlink(file, &at);
            let new = file.new_dataset::<f64>().chunk(10);
            let new = if other { new.nbit() } else { new.shuffle().deflate(6).fletcher32() };
            let new = new.shape(36).create(at.as_str()).expect("a dataset");
            new.write_raw(&list).expect("numbers");
            number(&new, "NBR", 12);
        }
    };
    let copy = Copy::new();
    assert_eq!(copy.says(filtered(false)), "nothing");
    assert_eq!(med::read(&copy.0), med::read(&path("hex8")));
    let says = format!(
        "{at}: it is stored with a filter that is not read (NBit); write it anew without \
         (h5repack -f NONE)"
    );
    assert_says(filtered(true), &says);
}

#[test]
fn a_byte_that_changed_ends_in_no_panic() {
    let bytes = fs::read(path("hex8")).expect("a good file");
    let mut state = 1_u64;
    let mut next = || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 33) as usize
    };
    for _ in 0..300 {
        let mut damaged = bytes.clone();
        for _ in 0..1 + next() % 3 {
            damaged[next() % bytes.len()] = next() as u8;
        }
        // A file of its own: the library remembers those that it could not close.
        let copy = Copy::new();
        fs::write(&copy.0, &damaged).expect("a copy");
        said(&copy.0);
    }
}
