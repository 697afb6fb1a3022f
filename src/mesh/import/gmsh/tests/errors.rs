//! Errors say the section, the line and what to do.

use super::message;
use super::writer::{Form, square_v2, square_v4};

/// What is said of a good file with one change, which must be possible.
fn changed(good: Vec<u8>, from: &str, to: &str) -> String {
    let text = String::from_utf8(good).expect("text");
    assert!(text.contains(from), "{from} is not in {text}");
    let text = message(text.replacen(from, to, 1).as_bytes());
    let (what, remedy) = text.rsplit_once("; ").expect("a remedy");
    assert!(!what.is_empty() && remedy.len() > 20, "{text}");
    text
}

fn assert_v2(changes: &[(&str, &str, &str)]) {
    for (from, to, expected) in changes {
        let text = changed(square_v2(Form::Ascii), from, to);
        assert!(text.starts_with(expected), "{text}\nnot\n{expected}");
    }
}

fn assert_v4(changes: &[(&str, &str, &str)]) {
    for (from, to, expected) in changes {
        let text = changed(square_v4(Form::Ascii), from, to);
        assert!(text.starts_with(expected), "{text}\nnot\n{expected}");
    }
}

#[test]
fn of_the_format() {
    assert_v4(&[
        ("4.1 0 8", "4.0 0 8", "$MeshFormat, line 2: the version is `4.0`; 2.2 and 4.1 are read"),
        ("4.1 0 8", "4.1 2 8", "$MeshFormat, line 2: the file type is `2`"),
        ("4.1 0 8", "4.1 0", "$MeshFormat, line 2: expected version, file type and size, found"),
        ("4.1 0 8", "4.1 1 16", "$MeshFormat, line 2: numbers have `16` bytes"),
        ("$MeshFormat", "$NOD", "$NOD, line 1: the version of the file is 1; "),
        ("$MeshFormat", "$Periodic", "$Periodic, line 1: $MeshFormat does not come first"),
        ("$MeshFormat", "solid cube", "line 1: expected the beginning of a section, found `solid"),
        ("$EndMeshFormat", "$EndFormat", "$MeshFormat, line 3: expected $EndMeshFormat, found"),
        ("$Nodes", "$MeshFormat", "$MeshFormat, line 17: the section comes twice or too late"),
    ]);
    assert!(message(b"").starts_with("line 1: the file has no $MeshFormat; "));
    assert!(message(b"$MeshFormat\n4.1 0 8\n$EndMeshFormat").contains("the file has no $Nodes"));
    assert!(message(b"$Comments\n\xff\n").contains("the section has no $EndComments"));
}

#[test]
fn of_nodes() {
    assert_v2(&[
        ("$Nodes\n5", "$Nodes\n6", "$Nodes, line 18: expected a number that is not negative, fou"),
        ("$Nodes\n5", "$Nodes\n4", "$Nodes, line 16: expected $EndNodes, found `40 0 1.5 0`; the "),
        ("$Nodes\n5", "$Nodes\n-5", "$Nodes, line 11: expected a count, found `-5`"),
        ("$Nodes\n5", "$Nodes\n5000000", "$Nodes, line 11: 5000000 nodes cannot stand in the "),
        ("20 1 0 0", "20 1 0", "$Nodes, line 13: expected a number, found the end of the line"),
        ("20 1 0 0", "20 1 0 0 4", "$Nodes, line 13: expected the end of the line, found `4`"),
        ("20 1 0 0", "20 nan 0 0", "$Nodes, line 13: a coordinate is NaN"),
        ("20 1 0 0", "20 1 1e999 0", "$Nodes, line 13: a coordinate is inf"),
        ("20 1 0 0", "10 1 0 0", "$Nodes, line 16: two nodes have the number 10"),
        ("20 1 0 0", "20 1 x 0", "$Nodes, line 13: expected a coordinate, found `x`"),
    ]);
    assert_v4(&[
        ("3 5 10 9000", "3 6 10 9000", "$Nodes, line 31: 6 nodes are promised, the blocks have 5"),
        ("2 7 1 3", "4 7 1 3", "$Nodes, line 25: an entity has dimension 4"),
        ("2 7 1 3", "2 7 0 3", "$Nodes, line 29: expected the end of the line, found `0.1`"),
        ("3 5 10 9000", "3 5 10", "$Nodes, line 18: expected a number, found the end of the lin"),
    ]);
}

#[test]
fn of_elements() {
    assert_v2(&[
        (
            "100 1 2",
            "100 26 2",
            "$Elements, line 21: elements of type 26 (line of third or higher ",
        ),
        ("100 1 2", "100 999 2", "$Elements, line 21: elements of type 999 (type that is not kno"),
        ("7 10 20 9000", "7 10 20 21", "$Elements, line 22: element 200 has node 21, which $Nodes"),
        ("7 10 20 9000", "7 10 20 10", "$Elements, line 22: element 200 (triangle of 3 nodes) has"),
        ("100 1 2 5 1", "100 1 4 5 1 1 3", "$Elements, line 21: the mesh is cut into partitions"),
        ("100 1 2", "100 1 2000", "$Elements, line 21: 2000 tags cannot stand in the "),
        ("$Elements\n5", "$Elements\n4", "$Elements, line 25: expected $EndElements, found `301"),
        ("$Elements\n5", "$Elements\n6", "$Elements, line 27: expected a number that is not neg"),
        ("$Nodes", "$Points", "$Points, line 10: the section has no $EndPoints"),
    ]);
    assert_v4(&[
        ("2 7 2 2", "2 8 2 2", "$Elements, line 38: $Entities has no entity 8 of dimension 2"),
        ("2 7 2 2", "2 7 4 2", "$Elements, line 38: a tetrahedron of 4 nodes belongs to an enti"),
        ("2 7 2 2", "2 7 2 9999", "$Elements, line 38: 9999 elements cannot stand in the "),
        ("2 3 100", "2 4 100", "$Elements, line 40: 4 elements are promised, the blocks have 3"),
        ("$Entities", "$PartitionedEntities", "$PartitionedEntities, line 10: the mesh is cut "),
        (
            "300 10 9000 40",
            "300 10 20 9000",
            "$Elements: elements 200 and 300 (triangle of 3 nodes",
        ),
        (
            "300 10 9000 40",
            "300 9000 20 10",
            "$Elements: elements 200 and 300 (triangle of 3 nodes",
        ),
    ]);
}

#[test]
fn of_groups_and_entities() {
    let text = String::from_utf8(square_v4(Form::Ascii)).expect("text");
    let text = message(text.replace("Entities\n", "Others\n").as_bytes());
    assert!(text.starts_with("$Elements, line 34: there is no $Entities before it; "), "{text}");
    assert_v4(&[
        ("2 6 5", "2 6 -5", "$Entities, line 14: entity 7 of dimension 2 belongs to one group wi"),
        ("2 6 5", "99 6 5", "$Entities, line 14: expected"),
        ("2 6 5", "999999 6 5", "$Entities, line 14: 999999 physical groups cannot stand in the"),
        ("1 1 1 0", "1 99999 1 0", "$Entities, line 11: 99999 entities cannot stand in the "),
        ("1 1 1 0", "1 1 1 1", "$Entities, line 16: expected an integer, found `$EndEntities`"),
        ("\n1 5 \"bottom\"", "\n1 5 bottom", "$PhysicalNames, line 6: expected dimension, numbe"),
        ("Names\n3", "Names\n4", "$PhysicalNames, line 9: expected dimension, number and \"name\""),
        ("Names\n3", "Names\n2", "$PhysicalNames, line 8: expected $EndPhysicalNames, found `2 6"),
    ]);
}
