use super::super::super::file_mesh::Kind;
use super::{block, groups_of, message, read};

const HEAD: &str = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n";
const SQUARE: &str = "$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 1 1 0\n7 0 1 0\n$EndNodes\n";

/// A square of four nodes (1, 2, 3, 7) with these elements.
fn square(elements: &[&str]) -> String {
    let list = elements.join("\n");
    format!("{HEAD}{SQUARE}$Elements\n{}\n{list}\n$EndElements\n", elements.len())
}

#[test]
fn comments_blank_lines_and_unknown_sections_are_passed_over() {
    let middle = square(&["1 3 0 1 2 3 7"]);
    let text = format!(
        "$Comments\n$Nodes 1 $EndComment\n$EndComments\n\n{}\r\n$Periodic\n1\n0 1 2\n$EndPeriodic\n\
         $NodeData\n$EndNodeDat\n$EndNodeData",
        middle.replace('\n', "\r\n\r\n")
    );
    let mesh = read(text.as_bytes()).expect("a mesh");
    assert_eq!(mesh, read(middle.as_bytes()).expect("a mesh"));
    assert_eq!(mesh.node_numbers, [1, 2, 3, 7]);
    assert_eq!(mesh.blocks[0].nodes, [0, 1, 2, 3]);
    assert_eq!(mesh.group_sets, [Vec::<u32>::new()]);
    assert!(mesh.groups.is_empty() && mesh.remarks.is_empty());
}

#[test]
fn an_element_that_is_written_for_each_of_its_groups_is_one() {
    let text = square(&["4 3 2 9 1 1 2 3 7", "5 3 2 2 1 1 2 3 7", "6 3 3 -5 1 0 1 2 3 7"]);
    let mesh = read(text.as_bytes()).expect("a mesh");
    let squares = block(&mesh, Kind::Quad4);
    assert_eq!(squares.numbers, [4]);
    assert_eq!(groups_of(&mesh, squares, 0), ["2", "5", "9"]);
    assert_eq!(mesh.group_sets[0], Vec::<u32>::new());
}

#[test]
fn copies_that_are_not_for_groups_are_errors() {
    for copies in [
        ["4 2 2 9 1 1 2 3", "8 2 2 9 1 1 2 3"],
        ["4 2 0 1 2 3", "8 2 0 1 2 3"],
        ["4 2 2 0 1 1 2 3", "8 2 2 9 1 1 2 3"],
    ] {
        let text = message(square(&copies).as_bytes());
        let expected = "$Elements: elements 4 and 8 (triangle of 3 nodes) are the same; ";
        assert!(text.starts_with(expected), "{text}");
    }
    let text = message(square(&["4 2 2 7 1 1 2 3", "8 2 2 9 1 1 3 2"]).as_bytes());
    assert!(text.contains("elements 4 and 8") && text.contains("different orders"), "{text}");
}

#[test]
fn points_of_two_entities_at_one_node_are_in_the_groups_of_both() {
    let text = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n\
                $Entities\n3 0 1 0\n1 0 0 0 1 5\n2 0 0 0 2 6 7\n3 0 0 0 1 5\n\
                1 0 0 0 1 1 0 0 0\n$EndEntities\n\
                $Nodes\n1 3 1 3\n2 1 0 3\n1\n2\n3\n0 0 0\n1 0 0\n0 1 0\n$EndNodes\n\
                $Elements\n4 4 1 4\n0 1 15 1\n1 1\n0 2 15 1\n2 1\n0 3 15 1\n3 1\n\
                2 1 2 1\n4 1 2 3\n$EndElements\n";
    let mesh = read(text.as_bytes()).expect("a mesh");
    let points = block(&mesh, Kind::Point1);
    assert_eq!((&points.numbers[..], &points.nodes[..]), (&[1][..], &[0][..]));
    assert_eq!(groups_of(&mesh, points, 0), ["5", "6", "7"]);
    // Cells that are there twice stay an error.
    let text = text.replace("$Elements\n4 4 1 4", "$Elements\n4 5 1 5");
    let text = text.replace("2 1 2 1\n4 1 2 3", "2 1 2 2\n4 1 2 3\n5 1 2 3");
    let text = message(text.as_bytes());
    assert!(text.contains("elements 4 and 5 (triangle of 3 nodes) are the same"), "{text}");
}

#[test]
fn one_name_is_one_group_in_each_dimension() {
    let names = |lines: &str, count: usize| {
        let section = format!("{HEAD}$PhysicalNames\n{count}\n{lines}$EndPhysicalNames\n");
        let elements = ["4 2 2 9 1 1 2 3", "5 1 2 9 1 1 2"];
        square(&elements).replacen(HEAD, &section, 1)
    };
    let mesh = read(names("2 9 \"a b\"\n1 9 \"a b\"\n", 2).as_bytes()).expect("a mesh");
    let found: Vec<_> = mesh.groups.iter().map(|g| (g.name.as_str(), g.dim)).collect();
    assert_eq!(found, [("a b", 1), ("a b", 2)]);

    let text = message(names("2 9 \"a\"\n2 8 \"a\"\n", 2).as_bytes());
    let expected = "$PhysicalNames, line 7: groups 9 and 8 of dimension 2 are both called `a`; ";
    assert!(text.starts_with(expected), "{text}");
    let text = message(names("2 8 \"9\"\n", 1).as_bytes());
    assert!(text.contains("groups 8 and 9 of dimension 2 are both called `9`"), "{text}");
    let text = message(names("2 9 \"a\"\n2 9 \"b\"\n", 2).as_bytes());
    assert!(text.contains("line 7: group 9 of dimension 2 is `a` and `b`"), "{text}");

    let mesh = read(names("2 9 \"a\"\n3 1 \"deep\"\n", 2).as_bytes()).expect("a mesh");
    assert_eq!(mesh.remarks[0], "groups without elements: deep (dimension 3)");
}

#[test]
fn points_without_a_group_and_nodes_without_an_element_are_left_out() {
    let text = square(&["1 15 2 0 1 7", "2 15 2 4 1 3", "3 15 0 2", "4 1 0 3 2"]);
    let mesh = read(text.as_bytes()).expect("a mesh");
    assert_eq!(mesh.node_numbers, [2, 3]);
    assert_eq!(mesh.points, [[1.0, 0.0, 0.0], [1.0, 1.0, 0.0]]);
    assert_eq!(block(&mesh, Kind::Point1).numbers, [2]);
    assert_eq!(block(&mesh, Kind::Point1).nodes, [1]);
    assert_eq!(block(&mesh, Kind::Line2).nodes, [1, 0]);
    assert_eq!(mesh.remarks, ["nodes of no element, left out: 2"]);
    let text = message(square(&["1 15 2 0 1 7"]).as_bytes());
    assert!(text.contains("no elements but points without a group"), "{text}");
}
