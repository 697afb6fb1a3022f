use super::super::super::file_mesh::{Group, Kind};
use super::writer::{FORMS, Form, Writer, square_v2, square_v4};
use super::{block, groups_of, message, read};

#[test]
fn every_form_of_both_versions_is_the_same_mesh() {
    let expected = read(&square_v4(Form::Ascii)).expect("a mesh");
    for form in FORMS {
        let [v4, v2] = [square_v4(form), square_v2(form)].map(|bytes| read(&bytes));
        assert_eq!(v4.as_ref(), Ok(&expected), "{form:?}");
        // The sets of groups may be numbered otherwise.
        let v2 = v2.unwrap_or_else(|e| panic!("{form:?}: {e}"));
        assert_eq!(v2.points, expected.points, "{form:?}");
        assert_eq!(v2.node_numbers, expected.node_numbers);
        assert_eq!((&v2.groups, &v2.remarks), (&expected.groups, &expected.remarks));
        for (ours, theirs) in v2.blocks.iter().zip(&expected.blocks) {
            assert_eq!((ours.kind, &ours.nodes), (theirs.kind, &theirs.nodes), "{form:?}");
            assert_eq!(ours.numbers, theirs.numbers, "{form:?}");
            for element in 0..ours.numbers.len() {
                let names = groups_of(&v2, ours, element);
                assert_eq!(names, groups_of(&expected, theirs, element), "{form:?}");
            }
        }
    }
    assert_eq!(expected.node_numbers, [10, 20, 9000, 40]);
    assert_eq!(expected.points[3], [0.0, 1.5, 0.0]);
    assert_eq!(expected.remarks, ["nodes of no element, left out: 1"]);
    let group = |name: &str, dim: usize| Group { name: name.into(), dim };
    assert_eq!(expected.groups, [group("bottom", 1), group("rock", 2), group("all", 2)]);
    let (lines, triangles) = (block(&expected, Kind::Line2), block(&expected, Kind::Tri3));
    assert_eq!(lines.nodes, [1, 0], "reversed by the negative tag");
    assert_eq!(triangles.nodes, [0, 1, 2, 0, 2, 3]);
    assert_eq!(triangles.numbers, [200, 300]);
    assert_eq!(groups_of(&expected, triangles, 1), ["rock", "all"]);
}

#[test]
fn the_errors_of_binary_files_say_the_byte() {
    let bytes = square_v4(Form::Little);
    let at = bytes.windows(9).position(|w| w == b"$Elements").expect("a section") + 10;
    // Behind the header of the section and of its first block, a number and half a node.
    let end = at + 32 + 20 + 12;
    let cut = message(&bytes[..end]);
    assert!(cut.starts_with(&format!("$Elements, byte {}: ", end - 4)), "{cut}");
    assert!(cut.contains("expected 8 bytes, 4 are left"), "{cut}");

    let mut huge = bytes.clone();
    huge[at..at + 8].copy_from_slice(&u64::MAX.to_le_bytes());
    let text = message(&huge);
    assert!(text.contains("18446744073709551615 blocks of elements cannot stand in"), "{text}");

    let mut w = Writer::new(Form::Big, "2.2");
    w.text("$Nodes\n1\n").int(1).reals(&[0.0, f64::NAN, 0.0]).text("\n$EndNodes\n");
    assert!(message(&w.bytes).contains("byte 61: a coordinate is NaN; "), "{}", message(&w.bytes));

    let swapped = b"$MeshFormat\n4.1 1 8\n\x01\x01\0\0\n$EndMeshFormat\n";
    assert!(message(swapped).contains("the 1 that tells the order of bytes is 257"));
}

#[test]
fn parametric_nodes_of_version_2_are_read() {
    for form in [Form::Ascii, Form::Little, Form::Big] {
        let mut w = Writer::new(form, "2.2");
        w.text("$ParametricNodes\n4\n");
        for (i, parameters) in [0, 1, 2, 0].into_iter().enumerate() {
            w.sizes(&[i as u64 + 1]).reals(&[i as f64, 0.0, 0.0]).ints(&[i as i32, 1]);
            w.reals(&[0.25; 2][..parameters]).end();
        }
        w.text("\n$EndParametricNodes\n$Elements\n1\n");
        match form {
            Form::Ascii => w.ints(&[1, 4, 0, 1, 2, 3, 4]),
            _ => w.ints(&[4, 1, 0, 1, 1, 2, 3, 4]),
        };
        w.text("\n$EndElements\n");
        let mesh = read(&w.bytes).unwrap_or_else(|e| panic!("{form:?}: {e}"));
        assert_eq!(mesh.points.iter().map(|p| p[0]).sum::<f64>(), 6.0);
        assert_eq!(mesh.blocks[0].nodes, [0, 1, 2, 3]);
    }
}
