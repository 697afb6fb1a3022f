//! Cases with the mesh of a file: nothing of it is read here.

use super::super::sections::*;
use super::mistakes::message as message_of_column;
use super::*;
use crate::law::{Contact, Tied};

const DAM: &str = "\
mesh: {file: meshes/dam.msh, scale: 1.0e-3, raise_order: 2}
materials:
  concrete: {on: dam, elastic: {young_modulus: 2.0e10, poisson_ratio: 0.2}}
  rock: {on: [base, flank], elastic: {young_modulus: 4.0e10, poisson_ratio: 0.25}}
interfaces:
  - {name: joint, on: cut, flip: true, law: {contact: {}}, secondary: lower}
  - {name: bed, between: [rock_top, dam_bottom], law: {tied: {}}}
boundary:
  - {on: foot, displacement: {x: 0, y: 0}}
  - {on: mirror, displacement: {normal: 0, x: {formula: \"x*z*t\"}}}
  - {on: top, traction: {normal: -2.0e5, x: 0}}
  - {on: mirror, traction: {y: 1}}
time: {instants: [1, 2]}
gravity: [0, 0]
probes: [{name: mid, at: [0.5, 1.25]}]
expect:
  - {quantity: joint.shear_traction_1, at: 1, equals: 0, absolute: 1}
";

fn read(overrides: &[&str]) -> Result<Case> {
    let overrides: Vec<String> = overrides.iter().map(|one| (*one).to_owned()).collect();
    Case::read(DAM, Path::new("cases/dam/case.yaml"), &overrides)
}

fn dam(overrides: &[&str]) -> Case {
    read(overrides).unwrap_or_else(|error| panic!("{error}"))
}

fn message(overrides: &[&str]) -> String {
    match read(overrides) {
        Err(Error::Input(text)) => text,
        other => panic!("{overrides:?}: {other:?}"),
    }
}

#[test]
fn a_case_with_a_mesh_file_is_read() {
    let case = dam(&[]);
    let file = case.mesh.file().expect("a file");
    assert_eq!(file.path, Path::new("cases/dam/meshes/dam.msh"));
    assert_eq!((file.scale, file.raise_order, case.mesh.refine), (1.0e-3, true, 0));
    let groups: Vec<_> = case.materials.iter().map(|m| (m.name.as_str(), &m.groups)).collect();
    let expected = [vec!["dam".to_owned()], vec!["base".to_owned(), "flank".to_owned()]];
    assert_eq!(groups, [("concrete", &expected[0]), ("rock", &expected[1])]);
    assert_eq!(case.interfaces[0].location, Location::Group { name: "cut".into(), flip: true });
    let between = ["rock_top", "dam_bottom"].map(str::to_owned);
    assert_eq!(case.interfaces[1].location, Location::Between(between));
    assert_eq!(
        case.interfaces.iter().map(InterfaceSpec::place).collect::<Vec<_>>(),
        ["on cut", "between rock_top and dam_bottom"]
    );
    let mirror = &case.boundary[1];
    assert_eq!(mirror.normal_displacement, Some(Value::Constant(0.0)));
    assert_eq!(mirror.displacement[0].as_ref().map(|x| x.at([2.0, 0.0, 3.0], 5.0)), Some(30.0));
    assert_eq!(case.boundary[2].normal_traction, Some(Value::Constant(-2.0e5)));
    // Bodies, points and planes are matters of the mesh.
    assert!(
        case.free_motions(&[false, false], &[false, false]).is_empty()
            && case.axial_stiffness().is_none()
    );
}

#[test]
fn surfaces_are_the_groups_on_which_something_is_prescribed() {
    let pressure = "boundary.4={on: all, pressure: 0}";
    let case = dam(&[pressure]);
    // `top` is no side of a column here.
    let groups = ["foot", "mirror", "top"].map(|name| Surface::Group(name.to_owned()));
    assert_eq!(case.surfaces(), groups);
    assert_eq!(case.surface_bit(&groups[1]), SurfaceBit::Place(1));
    assert_eq!(case.surface_bit(&Surface::All), SurfaceBit::All);
    assert_eq!(case.surface_bit(&Surface::Top), SurfaceBit::Place(usize::MAX));
    assert_eq!(case.supported_surfaces(), [&groups[0], &groups[1]]);
    assert_eq!(case.supported_bits(), [0, 1].map(SurfaceBit::Place));
    let column = super::good(&[]);
    assert_eq!(column.surfaces(), Surface::COLUMN);
    assert_eq!(column.surface_bit(&Surface::Back), SurfaceBit::Place(5));
}

#[test]
fn defaults_of_a_mesh_file_are_written_out_and_read_again() {
    let case = dam(&["mesh.scale=", "mesh.raise_order="]);
    let file = case.mesh.file().expect("a file");
    assert_eq!((file.scale, file.raise_order), (1.0, false));
    let resolved = case.resolved();
    assert_eq!((&resolved["mesh"]["scale"], &resolved["mesh"]["order"]), (&1.0.into(), &().into()));
    let path = Path::new("cases/dam/other.yaml");
    assert_eq!(Case::read(&resolved.to_string(), path, &[]), Ok(case.clone()));
    let elsewhere = Case::read(&resolved.to_string(), Path::new("case.yaml"), &[]);
    let elsewhere = elsewhere.expect("the same case").mesh.file().map(|file| file.path.clone());
    assert_eq!(elsewhere.as_deref(), Some(Path::new("meshes/dam.msh")));
    assert_eq!(super::good(&[]).resolved()["mesh"]["order"], 1);
}

#[test]
fn a_case_with_a_mesh_file_can_be_built() {
    let stiff = |modulus, ratio| MaterialSection::elastic(modulus, ratio);
    let built = CaseFile::new(
        MeshSection::file("meshes/dam.msh").scale(1.0e-3).raise_order(2),
        TimeSection::instants([1.0, 2.0]),
    )
    .material("concrete", stiff(2.0e10, 0.2).on("dam"))
    .material("rock", stiff(4.0e10, 0.25).on(["base", "flank"]))
    .interface(
        InterfaceSection::on("joint", "cut", Contact::default()).flip(true).secondary(Side::Lower),
    )
    .interface(InterfaceSection::between("bed", ["rock_top", "dam_bottom"], Tied {}))
    .boundary(BoundarySection::on("foot").displacement(Components::xy(0.0, 0.0)))
    .boundary(
        BoundarySection::on("mirror").displacement(Components::default().normal(0.0).x("x*z*t")),
    )
    .boundary(BoundarySection::on("top").traction(Components::default().normal(-2.0e5).x(0.0)))
    .boundary(BoundarySection::on("mirror").traction(Components::default().y(1.0)))
    .gravity([0.0, 0.0])
    .probe(ProbeSection::new("mid", [0.5, 1.25]))
    .expect(ExpectSection::new("joint.shear_traction_1", 1.0, 0.0).absolute(1.0));
    let read = Case::read(DAM, Path::new("case.yaml"), &[]);
    assert_eq!(Case::build(built), read);
    // Sides of a column by their names too.
    let sections: CaseFile =
        serde_json::from_value(super::good(&[]).resolved()).expect("the sections of a case");
    let mut named = sections.clone();
    named.boundary[0].on = "bottom".into();
    assert_eq!(Case::build(named), Case::build(sections));
}

#[test]
fn the_dimension_is_told_later_and_makes_the_names_final() {
    let case = dam(&[]);
    assert!(!case.knows_dimension());
    let flat = case.clone().for_dimension(2).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!((flat.dim, flat.axes, flat.knows_dimension()), (2, &[0, 1][..], true));
    // What else the case says stays, and so does the place of the file.
    let other = Case { dim: 3, axes: &[0, 1, 2], knows_dimension: false, ..flat.clone() };
    assert_eq!(other, case);
    assert_eq!((flat.gravity, flat.probes[0].at), ([0.0; 3], [0.5, 1.25, 0.0]));
    let names = |interface: &str, tangents: &[&str]| -> Vec<String> {
        let mut names = vec!["normal_traction".to_owned()];
        names.extend(tangents.iter().map(|t| format!("shear_traction_{t}")));
        names.push("normal_jump".to_owned());
        names.extend(tangents.iter().map(|t| format!("sliding_{t}")));
        names.push("damage".to_owned());
        let names = names.iter().flat_map(|n| ["min", "max", "mean"].map(|s| format!("{n}.{s}")));
        names.map(|name| format!("{interface}.{name}")).collect()
    };
    let all = |axes: &[&str], tangents: &[&str]| -> Vec<String> {
        let mut list = ["time", "load_factor", "newton_iterations", "linear_iterations"]
            .map(String::from)
            .to_vec();
        for interface in ["joint", "bed"] {
            list.extend(names(interface, tangents));
            list.extend(axes.iter().map(|axis| format!("{interface}.force_{axis}")));
            list.push(format!("{interface}.area"));
        }
        for of in ["foot", "mirror", "total"] {
            list.extend(axes.iter().map(|axis| format!("{of}.reaction_{axis}")));
        }
        list.extend(axes.iter().map(|axis| format!("mid.displacement_{axis}")));
        list.extend(["elastic", "dissipated", "external"].map(|of| format!("energy.{of}")));
        list
    };
    assert_eq!(flat.columns(), all(&["x", "y"], &["1"]));
    let space = dam(&["gravity=", "probes.0.at=[1, 2, 3]"]).for_dimension(3).expect("in 3D");
    assert_eq!(space.columns(), all(&["x", "y", "z"], &["1", "2"]));
    assert_eq!(space.clone().for_dimension(3), Ok(space));
    // A column knows its own.
    let column = super::good(&[]);
    assert_eq!(column.clone().for_dimension(3), Ok(column.clone()));
    assert!(matches!(column.for_dimension(2), Err(Error::Bug(_))));
}

#[test]
fn what_a_mesh_in_the_plane_does_not_have_is_refused() {
    let case = dam(&[
        "boundary.0.displacement.z=0",
        "boundary.2.traction.z=1",
        "body_force={z: 1}",
        "gravity=[0, 0, 0]",
        "probes.0.at=[1, 2, 3]",
        "expect.0.quantity=joint.sliding_2",
        "expect.1={quantity: foot.reaction_z, at: 1, equals: 0, absolute: 1}",
    ]);
    let Err(Error::Input(text)) = case.for_dimension(2) else { panic!("a refusal") };
    let lack = "does not exist: the mesh lies in the plane z = 0, with components along x and y";
    let lines: Vec<&str> = text.lines().collect();
    for beginning in [
        &format!("boundary.0.displacement.z {lack}"),
        &format!("boundary.2.traction.z {lack}"),
        &format!("body_force.z {lack}"),
        "gravity must have 2 entries, got 3",
        "probes.0.at must have 2 entries, got 3",
        "expect.0.quantity cannot be `joint.sliding_2`; did you mean `joint.sliding_1`?",
        "expect.1.quantity cannot be `foot.reaction_z`; did you mean `foot.reaction_y`?",
    ] {
        assert!(lines.iter().any(|line| line.starts_with(beginning)), "{beginning}\n{text}");
    }
    assert_eq!(lines.len(), 7, "{text}");
    let Err(Error::Input(text)) = dam(&[]).for_dimension(3) else { panic!("a refusal") };
    assert_eq!(text, "gravity must have 3 entries, got 2\nprobes.0.at must have 3 entries, got 2");
}

#[test]
fn a_mistake_in_a_case_with_a_mesh_file_is_told() {
    for (assignment, expected) in [
        ("mesh.file=", "mesh needs a column or a file"),
        ("mesh.file=''", "mesh.file is empty; it must name a mesh file, MSH or MED"),
        ("mesh.scale=0", "mesh.scale must be positive, got 0"),
        ("mesh.scale=1e-60", "mesh.scale must be between 1e-50 and 1e50 m, got 1e-60"),
        ("mesh.raise_order=1", "mesh.raise_order must be at least 2, got 1"),
        ("mesh.raise_order=3", "mesh.raise_order must be at most 2, got 3"),
        (
            "mesh.order=2",
            "mesh.order is for columns; the cells of a file have orders of their own, which \
             raise_order: 2 raises",
        ),
        (
            "mesh.column={size: [1, 1], cells: [1, 1]}",
            "mesh.file cannot stand beside column; give one of them",
        ),
        (
            "materials.rock.z=[0, 1]",
            "materials.rock.z is for columns; with a mesh file give on, its groups of cells",
        ),
        ("materials.rock.on=[base, base]", "materials.rock.on names `base` twice"),
        (
            "materials.rock.on=dam",
            "materials.rock.on names `dam`, which consists of concrete already",
        ),
        ("materials.rock.on=''", "materials.rock.on names a group without a name"),
        ("materials.rock.on=[]", "materials.rock.on must have 1 to 1000 entries, got 0"),
        (
            "interfaces.0={name: joint, z: 2, law: {tied: {}}}",
            "interfaces.0.z is for columns; with a mesh file give on: GROUP, or between: [LOWER, \
             UPPER]",
        ),
        (
            "interfaces.0={name: joint, law: {tied: {}}}",
            "interfaces.0 needs on: GROUP, or between: [LOWER, UPPER]",
        ),
        (
            "interfaces.0.between=[a, b]",
            "interfaces.0.between cannot stand beside on; give one of them",
        ),
        ("interfaces.0.on=''", "interfaces.0.on names a group without a name"),
        ("interfaces.1.between=[a]", "interfaces.1.between must have 2 entries, got 1"),
        (
            "interfaces.1.between=[a, a]",
            "interfaces.1.between names `a` twice; the sides need a group each",
        ),
        ("interfaces.1.between=[a, cut]", "interfaces.1.between names `cut`, on which joint is"),
        (
            "interfaces.1.gap=as_drawn",
            "interfaces.1.gap is for contact between two groups of a mesh file; other laws join \
             sides that lie on each other",
        ),
        (
            "interfaces.1.flip=true",
            "interfaces.1.flip turns the normal of a group that is given by on; of between the \
             first group is the lower side",
        ),
        ("interfaces.1.name=joint", "interfaces.1.name `joint` is taken"),
        (
            "boundary.0.on=''",
            "boundary.0.on is empty; it must name a group of the mesh file, or be all",
        ),
        (
            "boundary.0.on=total",
            "boundary.0.on cannot be `total` where a displacement is prescribed: total.reaction_x \
             is the sum over all surfaces; rename the group",
        ),
        ("boundary.0.on=all", "boundary.0 is on `all`, which can carry a pressure only"),
        (
            "boundary.3={on: mirror, displacement: {normal: 1}}",
            "boundary.3.displacement.normal disagrees with boundary.1 (mirror): 1 against 0 at \
             time 1 on the nodes of both",
        ),
        (
            "body_force={normal: 1}",
            "body_force.normal acts inside the cells, where there is no normal",
        ),
    ] {
        let text = message(&[assignment, "expect=[]"]);
        assert!(text.lines().any(|line| line.ends_with(&format!(": {expected}"))), "{text}");
        assert_eq!(text.lines().count(), 1, "{assignment}: {text}");
    }
}

#[test]
fn a_pore_pressure_acts_on_a_mesh_file_as_on_columns() {
    let porous = "{biot: 1, porosity: 0.15, permeability: 1.0e-19, viscosity: 1.0e-3, \
                  fluid_compressibility: 5.0e-10, fluid_density: 1, density: 2.5}";
    let porous = |name: &str| format!("materials.{name}.porous={porous}");
    let (concrete, rock) = (porous("concrete"), porous("rock"));
    for (change, flows) in [
        ("boundary.0.pressure=1", true),
        ("boundary.4={on: all, pressure: 1}", false),
        ("interfaces.0.fluid={flow: true}", true),
        ("interfaces.0.fluid={pressure: 1, connected: true}", true),
    ] {
        let case = dam(&[&concrete, &rock, change]);
        assert_eq!((case.flow.is_some(), case.pressure_is_load), (flows, !flows), "{change}");
        // The nodes of connected lips are marked after those of the groups.
        let bit = change.contains("connected").then_some(case.surfaces().len());
        assert_eq!(case.lips_bit(0), bit.map(SurfaceBit::Place));
    }
    // Data that change nothing are left out as on columns, and so are those that are not asked for.
    let zero = "boundary.4={on: all, pressure: 0}";
    for (change, why) in [(zero, "on all nodes"), ("physics=mechanics", "asks for mechanics")] {
        let case = dam(&[&concrete, &rock, change]);
        assert!(case.left_out.iter().any(|words| words.contains(why)), "{:?}", case.left_out);
        let flat = case.clone().for_dimension(2).expect("the same in 2D");
        assert_eq!(flat.left_out, case.left_out);
    }
}

#[test]
fn a_material_without_groups_is_everything_or_the_group_of_its_name() {
    let only = dam(&["materials.concrete=", "materials.rock.on="]);
    assert!(only.materials[0].groups.is_empty());
    let named = dam(&["materials.rock.on="]);
    assert_eq!(named.materials[1].groups, ["rock"]);
}

#[test]
fn what_is_for_mesh_files_is_refused_in_a_column() {
    for (assignment, expected) in [
        ("mesh.scale=2", "mesh.scale is for meshes from files; give the size of the column in m"),
        (
            "mesh.raise_order=2",
            "mesh.raise_order is for meshes from files; a column takes order: 2",
        ),
        (
            "materials.rock.on=rock",
            "materials.rock.on is for meshes from files; in a column give z, its heights",
        ),
        (
            "interfaces.0.on=cut",
            "interfaces.0.on is for meshes from files; in a column give z, its height",
        ),
        (
            "interfaces.0={name: joint, between: [a, b], law: {tied: {}}}",
            "interfaces.0.between is for meshes from files; in a column give z, its height",
        ),
        ("interfaces.0={name: joint, law: {tied: {}}}", "interfaces.0.z is missing"),
    ] {
        let text = message_of_column("mesh", "mesh", &[assignment]);
        assert_eq!(text, format!("--set {assignment}: {expected}"));
    }
}

#[test]
fn the_normal_of_a_side_of_a_column_is_an_axis() {
    for (side, axis, sign) in [
        ("bottom", 2, -1.0),
        ("top", 2, 1.0),
        ("left", 0, -1.0),
        ("right", 0, 1.0),
        ("front", 1, -1.0),
        ("back", 1, 1.0),
    ] {
        let entry = format!(
            "boundary.2={{on: {side}, displacement: {{normal: 0}}, traction: {{normal: {{formula: \
             \"2*t\"}}}}}}"
        );
        let case = super::good(&["boundary.1.displacement.z=0", &entry]);
        let entry = &case.boundary[2];
        assert!(entry.normal_displacement.is_none() && entry.normal_traction.is_none());
        assert!(entry.displacement[axis].as_ref().is_some_and(Value::is_zero), "{side}");
        let at = |axis: usize| entry.traction[axis].as_ref().map(|v| v.at([0.0; 3], 3.0));
        let expected = std::array::from_fn(|a| (a == axis).then_some(6.0 * sign));
        assert_eq!([0, 1, 2].map(at), expected, "{side}");
        assert_eq!(entry.displacement.iter().flatten().count(), 1, "{side}");
    }
    let both = "boundary.2={on: left, traction: {normal: 1, x: 1}}";
    let expected =
        "boundary.2.traction.normal is along x on `left`, where x is given too; give one";
    assert_eq!(message_of_column("mesh", "mesh", &[both]), format!("--set {both}: {expected}"));
    let clash = "boundary.2={on: top, displacement: {normal: 1}}";
    let text = message_of_column("mesh", "mesh", &[clash]);
    assert!(text.contains("boundary.2.displacement.z disagrees with boundary.1 (top)"), "{text}");
}
