//! Every mistake has its exact message.

use super::*;

/// The message of `GOOD` with a replacement and overrides.
pub(super) fn message(from: &str, to: &str, overrides: &[&str]) -> String {
    match read_with(from, to, overrides) {
        Err(Error::Input(text)) => text,
        other => panic!("{to} {overrides:?}: {other:?}"),
    }
}

/// An expected message with the names of all laws, so that a new one is no matter of this file.
fn with_laws(expected: &str) -> String {
    let names = LawSpec::NAMES;
    let choice = |name: &&str| format!("{{{name}: ...}}");
    let choices: Vec<String> = names.iter().map(choice).collect();
    let (last, first) = choices.split_last().expect("there are laws");
    let choices = format!("{} or {last}", first.join(", "));
    expected.replace("LAWS", &names.join(", ")).replace("CHOICES", &choices)
}

#[test]
fn a_mistake_in_the_file_is_told_with_its_place_and_reason() {
    for (from, to, expected) in [
        (
            "young_modulus",
            "young_modulos",
            "5:15: materials.rock.elastic.young_modulos is not a known key; did you mean \
             `young_modulus`? (known: density, poisson_ratio, thermal_expansion, \
             young_modulus)",
        ),
        (
            "5.8e9",
            "-5.8e9",
            "5:30: materials.rock.elastic.young_modulus must be positive, got -5.8e9",
        ),
        (
            "5.8e9",
            "stiff",
            "5:30: materials.rock.elastic.young_modulus must be a number, got the text `stiff`",
        ),
        ("5.8e9", ".nan", "5:30: materials.rock.elastic.young_modulus must be finite, got NaN"),
        ("5.8e9", "-.inf", "5:30: materials.rock.elastic.young_modulus must be finite, got -inf"),
        ("5.8e9, ", ", ", "5:28: materials.rock.elastic.young_modulus has no value"),
        (
            "ratio: 0",
            "ratio: 0.5",
            "5:52: materials.rock.elastic.poisson_ratio must be below 0.5, got 0.5",
        ),
        (
            "ratio: 0",
            "ratio: -1",
            "5:52: materials.rock.elastic.poisson_ratio must be above -1, got -1",
        ),
        ("z: 2.5", "z: 5", "8:8: interfaces.0.z must lie inside the column, in (0, 5), got 5"),
        (
            "on: top",
            "on: tpo",
            "12:10: boundary.1.on cannot be `tpo`; did you mean `top`? (known: bottom, top, left, \
             right, front, back, all)",
        ),
        ("on: top", "on: all", "12:5: boundary.1 is on `all`, which can carry a pressure only"),
        ("[1, 1, 5]}", "[0, 1, 5]}", "2:37: mesh.column.cells.0 must be at least 1, got 0"),
        (
            "[1, 1, 5]}",
            "[10000000000, 1, 5]}",
            "2:29: mesh.column.cells make too many unknowns: 10000000000 x 1 x 5 cells, refined 0 \
             times, have up to 480000000048 displacement components; at most 2147483647 can be \
             numbered",
        ),
        ("[1, 1, 5]}", "[1, 5]}", "2:29: mesh.column.cells must have 3 entries as size has, got 2"),
        ("[1, 1, 5]}", "[1, 1, 5.5]}", "2:43: mesh.column.cells.2 must be a whole number, got 5.5"),
        (
            "cells: [1, 1, 5]",
            "bodies: [{cells: [1, 1, 5]}]",
            "2:29: mesh.column.bodies has 1 bodies, but 1 interface(s) make 2",
        ),
        (", cells: [1, 1, 5]", "", "2:3: mesh.column needs cells or bodies; give one of them"),
        ("size: [1, 1", "size: [1, -1", "2:22: mesh.column.size.1 must be positive, got -1"),
        (
            "[[0, 0], [1, 1.0e-4]]",
            "[[1, 0], [0, 1.0e-4]]",
            "12:62: boundary.1.displacement.z.table.1 has time 0 after 1; the times must rise",
        ),
        (
            "[[0, 0], [1, 1.0e-4]]",
            "[[0, 0], [1]]",
            "12:62: boundary.1.displacement.z.table.1 must have 2 entries, got 1",
        ),
        (
            "table: [[0, 0], [1, 1.0e-4]]",
            "tabel: [[0, 0]]",
            "12:46: boundary.1.displacement.z.tabel is not a known key; did you mean `table`? \
             (known: over, table, formula)",
        ),
        (
            "table: [[0, 0], [1, 1.0e-4]]",
            "formula: \"1e-4*(x\"",
            "12:55: boundary.1.displacement.z.formula cannot be read: `)` is missing at column 8 \
             of the formula",
        ),
        (
            "table: [[0, 0], [1, 1.0e-4]]",
            "table: [[0, 0]], formula: \"1\"",
            "12:45: boundary.1.displacement.z must have one of the keys table, formula",
        ),
        (
            "{table: [[0, 0], [1, 1.0e-4]]}",
            "[1]",
            "12:45: boundary.1.displacement.z must be a number, {table: ...} or {formula: ...}, \
             got a list of 1",
        ),
        (
            "900}",
            "900, augmentation: 0.25}",
            "9:83: interfaces.0.law.linear_softening.augmentation must be above 0.5: r = \
             3.361111111111111e8 Pa/m has to exceed the softening slope 6.722222222222222e8 Pa/m, \
             got 0.25",
        ),
        (
            "strength: 1.1e6",
            "strength: -1.1e6",
            "9:40: interfaces.0.law.linear_softening.strength must be positive, got -1.1e6",
        ),
        (
            "linear_softening",
            "linear_softning",
            "9:11: interfaces.0.law.linear_softning is not a known key; did you mean \
             `linear_softening`? (known: LAWS)",
        ),
        (
            "{linear_softening: {strength: 1.1e6, fracture_energy: 900}}",
            "contact",
            "9:10: interfaces.0.law must be CHOICES, got the \
             text `contact`",
        ),
        (
            "[1, 2]",
            "[2, 1]",
            "13:22: time.instants.1 must be above the instant before it at 2, got 1",
        ),
        ("[1, 2]", "[0, 1]", "13:19: time.instants.0 must be above the start at 0, got 0"),
        ("time: {instants: [1, 2]}\n", "", "1:1: time is missing"),
        (
            "0.5, 1.25]",
            "0.5, 6]",
            "14:22: probes.0.at must lie inside the column of size [1.0, 1.0, 5.0], got [0.5, 0.5, \
             6.0]",
        ),
        ("name: mid", "name: joint", "14:17: probes.0.name `joint` is taken"),
        (
            "name: mid",
            "name: a b",
            "14:17: probes.0.name must be made of letters, digits, _ and -, got `a b`",
        ),
        (
            "normal_traction",
            "normal_tracton",
            "16:16: expect.0.quantity cannot be `joint.normal_tracton`; did you mean \
             `joint.normal_traction`? (known: time, load_factor, newton_iterations, \
             linear_iterations, joint.normal_traction, joint.shear_traction_x, \
             joint.shear_traction_y, joint.normal_jump, joint.sliding_x, joint.sliding_y, \
             joint.damage, joint.force_x, joint.force_y, joint.force_z, joint.area, bottom.reaction_x, bottom.reaction_y, bottom.reaction_z, \
             top.reaction_x, top.reaction_y, top.reaction_z, total.reaction_x, total.reaction_y, \
             total.reaction_z, mid.displacement_x, mid.displacement_y, mid.displacement_z, energy.elastic, energy.dissipated, \
             energy.external)",
        ),
        (
            "at: 1,",
            "at: 1.5,",
            "16:43: expect.0.at must be one of time.instants; the nearest is 1, got 1.5",
        ),
        (", relative: 1.0e-9", "", "16:5: expect.0 needs a tolerance: relative, absolute or both"),
        ("probes:", "mesh: 3\nprobes:", "14:1: mesh is given twice"),
        ("  rock:", "\trock:", "4:2: tabs disallowed within this context (block indentation)"),
        ("time:", "---\ntime:", "14:1: multiple YAML documents detected"),
        (
            "displacement: {x: 0, y: 0, z: 0}",
            "flux: 1",
            "11:24: boundary.0.flux acts on pores, but no material is porous (materials.NAME.porous)",
        ),
    ] {
        let expected = with_laws(expected);
        assert_eq!(message(from, to, &[]), format!("case.yaml:{expected}"), "{to}");
    }
}

#[test]
fn a_mistake_in_an_override_is_told_with_the_override() {
    for (assignment, expected) in [
        (
            "boundary.2={on: top, displacement: {z: 1.0e-3}}",
            "boundary.2.displacement.z disagrees with boundary.1 (top): 0.001 against 1e-4 at time \
             1 on the nodes of both",
        ),
        (
            "interfaces.1={name: other, z: 2, law: {tied: {}}}",
            "interfaces.1.z must be above the interface before it at 2.5, got 2",
        ),
        ("interfaces.1={name: joint, z: 3, law: {tied: {}}}", "interfaces.1.name `joint` is taken"),
        (
            "solver={linear: gamg, form: saddle_point}",
            "solver.form saddle_point needs linear: mumps or auto",
        ),
        (
            "solver.petsc_options=-ksp_view -start_in_debugger",
            "solver.petsc_options `-start_in_debugger` would run or read something other than the \
             case",
        ),
        (
            "output.checkpoint.every=often",
            "output.checkpoint.every must be like 10 min, 90 s, 2 h or 23:30:00, got `often`",
        ),
        (
            "output.fields=al",
            "output.fields cannot be `al`; did you mean `all`? (known: all, none)",
        ),
        (
            "control={opening: {of: jont, equals: 1}}",
            "control.opening.of must name an interface, got `jont`; did you mean `joint`? (known: \
             joint)",
        ),
        (
            "control={dissipation: {of: joint, step: 2}}",
            "control.dissipation.step must be at most 1, got 2",
        ),
        ("control={arc: {}}", "control.arc is not a known key (known: opening, dissipation)"),
        ("mesh.refine=-1", "mesh.refine must be at least 0, got -1"),
        ("mesh.refine=21", "mesh.refine must be at most 20, got 21"),
        ("title=12", "title must be a text (in quotes if it looks like a number), got 12"),
        ("materials.rock.z=[0, 2]", "materials.rock.z ends at 2, but the column is 5 high"),
        ("a.b", "expected a.b.c=VALUE, but there is no `=`"),
        ("a..b=1", "a name in front of `=` is empty"),
        (
            "boundary.9.on=top",
            "boundary is a list of 2; `9` is no position in it (0 to 2, 2 appends)",
        ),
        ("mesh.order.x=1", "mesh.order must be a whole number, got a section"),
        ("boundary.0.on.x=1", "boundary.0.on is the text `bottom`, so `x` cannot be set in it"),
        ("boundary.0.displacement.x=[", "unclosed bracket '['"),
    ] {
        let expected = format!("--set {assignment}: {expected}");
        assert_eq!(message("mesh", "mesh", &[assignment]), expected);
    }
}

#[test]
fn what_is_planned_is_refused_as_not_yet_available() {
    let text = message("mesh", "mesh", &["materials.rock.elastic.thermal_expansion=1.0e-5"]);
    assert!(text.contains("is not yet available") && !text.contains('\n'), "{text}");
}

#[test]
fn all_mistakes_are_told_at_once() {
    let text = GOOD
        .replace("5.8e9", "-5.8e9")
        .replace("z: 2.5", "hight: 3\n    z: 7")
        .replace("[1, 2]", "[1, 1]")
        .replace("on: bottom", "on: botom");
    let error = Case::read(&text, Path::new("case.yaml"), &["solver.linear=mump".to_owned()]);
    let expected = "\
case.yaml:5:30: materials.rock.elastic.young_modulus must be positive, got -5.8e9
case.yaml:8:5: interfaces.0.hight is not a known key (known: between, flip, fluid, \
gap, initial, law, name, on, secondary, z)
case.yaml:9:8: interfaces.0.z must lie inside the column, in (0, 5), got 7
case.yaml:12:10: boundary.0.on cannot be `botom`; did you mean `bottom`? (known: bottom, top, \
left, right, front, back, all)
case.yaml:14:22: time.instants.1 must be above the instant before it at 1, got 1
--set solver.linear=mump: solver.linear cannot be `mump`; did you mean `mumps`? (known: auto, \
mumps, aggregation, gamg, hypre, multigrid)";
    assert_eq!(error, Err(Error::Input(expected.to_owned())));
}

#[test]
fn a_2d_case_has_no_y() {
    let text = message("mesh", "mesh", &["mesh.column={size: [1, 5], cells: [1, 5]}"]);
    assert_eq!(
        text,
        "case.yaml:11:42: boundary.0.displacement.y does not exist in 2D\n\
         case.yaml:12:39: boundary.1.displacement.y does not exist in 2D\n\
         case.yaml:14:22: probes.0.at must have 2 entries, got 3"
    );
}

#[test]
fn materials_must_cover_the_column_once() {
    let elastic = "elastic: {young_modulus: 1, poisson_ratio: 0}";
    for (low, expected) in
        [(2.5, "leaves a gap between 2 and 2.5"), (1.0, "overlaps between 1 and 2")]
    {
        let upper = format!("materials.upper={{z: [{low}, 5], {elastic}}}");
        let text = message("mesh", "mesh", &["materials.rock.z=[0, 2]", &upper]);
        assert!(text.ends_with(&format!("materials.upper.z {expected}")), "{text}");
    }
}

#[test]
fn a_body_that_can_move_freely_is_named_with_its_motion() {
    let contact = "interfaces.0.law={contact: {}}";
    for (overrides, expected) in [
        (
            vec![contact, "boundary.1.displacement={z: 0}"],
            "body 2 (between joint and the top) can move freely: translation along x, translation \
             along y, rotation about z",
        ),
        (
            vec![contact, "boundary.0.displacement={x: 0, y: 0}", "boundary.1.displacement={x: 0}"],
            "body 1 (between the bottom and joint) can move freely: translation along z, rotation \
             about x, rotation about y",
        ),
        (
            vec!["boundary.0.displacement={x: 0, y: 0}", "boundary.1.displacement={x: 0, y: 0}"],
            "bodies 1 to 2 (the whole column) can move freely: translation along z",
        ),
        (
            vec!["interfaces=", "expect=", "boundary=[{on: left, displacement: {x: 0, y: 0}}]"],
            "body 1 (the whole column) can move freely: translation along z",
        ),
    ] {
        let text = message("mesh", "mesh", &overrides);
        let expected = format!(
            "boundary leaves a body free: {expected}; prescribe displacements that prevent it, or \
             choose a law that holds"
        );
        assert!(text.contains(&expected), "{text}");
        let is_contact = overrides[0] == contact;
        assert_eq!(text.contains("; a contact holds what is pressed on it"), is_contact, "{text}");
    }
    // Side supports reach every body; the same column with a bond needs no more than its bottom.
    let sides = "boundary=[{on: bottom, displacement: {z: 0}}, {on: top, displacement: {z: 0}}, \
                 {on: left, displacement: {x: 0}}, {on: front, displacement: {y: 0}}]";
    assert!(read_with("mesh", "mesh", &[contact, sides]).is_ok());
    let bottom = "boundary=[{on: bottom, displacement: {x: 0, y: 0, z: 0}}]";
    assert!(read_with("mesh", "mesh", &[bottom]).is_ok());
}

#[test]
fn a_text_that_is_no_case_is_refused() {
    for (text, expected) in [
        ("", ": the case file is empty; cases/wtnv146/case.yaml is an example"),
        ("# a\n", ": the case file is empty; cases/wtnv146/case.yaml is an example"),
        ("[1]", ":1:1: the case must be a section, got a list of 1"),
        ("a: *x", ":1:4: alias references unknown anchor"),
    ] {
        let error = Case::read(text, Path::new("case.yaml"), &[]);
        assert_eq!(error, Err(Error::Input(format!("case.yaml{expected}"))), "{text}");
    }
    let deep = "[".repeat(100_000);
    assert!(matches!(Case::read(&deep, Path::new("case.yaml"), &[]), Err(Error::Input(_))));
}

#[test]
fn a_file_that_cannot_be_read_is_refused() {
    let folder = std::env::temp_dir().join(format!("column-hpc-read-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    let large = folder.join("large.yaml");
    std::fs::write(&large, vec![b' '; (1 << 20) + 1]).expect("a large file");
    let binary = folder.join("binary.yaml");
    std::fs::write(&binary, [0xff, 0xfe, 0x00]).expect("a binary file");
    for (path, expected) in [
        (folder.join("none.yaml"), "there is no such case file"),
        (folder.clone(), "is a directory; name the case file in it"),
        (large, "the case file is larger than 1048576 bytes"),
        (binary, "the case file is not UTF-8 text"),
    ] {
        let expected = Error::Input(format!("{}: {expected}", path.display()));
        assert_eq!(read_text(&path), Err(expected));
    }
    std::fs::remove_dir_all(&folder).expect("the folder is ours");
}

#[test]
fn a_law_whose_modes_differ_is_not_followed_by_its_dissipation() {
    let law = |shear: &str| {
        format!(
            "interfaces.0.law={{benzeggagh_kenane: {{strength: 1e6, shear_strength: 1e6, \
             fracture_energy: 900, shear_fracture_energy: {shear}, exponent: 2}}}}"
        )
    };
    let control = "control={dissipation: {of: joint, step: 0.1}}";
    let found = message("mesh", "mesh", &[&law("901"), control]);
    let reason = "control.dissipation.of names `joint`, whose modes differ in strength or energy: \
                  what is dissipated is no measure of its path; take control.opening";
    assert!(found.contains(reason), "{found}");
    assert!(read_with("mesh", "mesh", &[&law("900"), control]).is_ok());
    assert!(read_with("mesh", "mesh", &[&law("901")]).is_ok());
}
