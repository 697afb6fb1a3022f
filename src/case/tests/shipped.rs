//! The shipped cases, and the schema against everything that they use.

use super::*;

pub(super) fn shipped() -> Vec<std::path::PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("cases");
    let folders = std::fs::read_dir(root).expect("the cases");
    let mut files: Vec<_> = folders
        .map(|folder| folder.expect("a folder of cases").path())
        .filter(|folder| !folder.ends_with("studies"))
        .filter_map(|folder| std::fs::read_dir(folder).ok())
        .flat_map(|files| files.filter_map(|file| Some(file.ok()?.path())))
        .filter(|path| path.extension().is_some_and(|extension| extension == "yaml"))
        .collect();
    files.sort();
    files
}

#[test]
fn every_shipped_case_is_read_and_checks_itself() {
    let files = shipped();
    assert!(files.len() >= 9, "{files:?}");
    for file in files {
        let text = read_text(&file).expect("a readable case");
        let case = Case::read(&text, &file, &[]).unwrap_or_else(|error| panic!("{error}"));
        assert!(!case.expect.is_empty() && text.starts_with('#'), "{}", file.display());
        let again = Case::read(&case.resolved().to_string(), &file, &[]);
        assert_eq!(again, Ok(case), "{}", file.display());
    }
}

#[test]
fn the_reference_case_carries_every_datum_of_its_source() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("cases/wtnv146/case.yaml");
    let text = read_text(&file).expect("the reference case");
    let case = Case::read(&text, &file, &[]).expect("a good case");
    let rock = &case.materials[0];
    assert_eq!((rock.young_modulus, rock.poisson_ratio), (5.8e9, 0.0));
    let porous = rock.porous.as_ref().expect("porous data");
    assert_eq!((porous.biot, porous.porosity, porous.permeability), (1.0, 0.15, 1.01937e-19));
    assert_eq!((porous.viscosity, porous.fluid_compressibility), (1e-3, 5e-10));
    assert_eq!((porous.fluid_density, porous.density, porous.reference_pressure), (1.0, 2.5, 0.0));
    let top = &case.boundary[1].displacement;
    let at = |axis: usize, time: f64| top[axis].as_ref().map(|value| value.at([0.0; 3], time));
    let heights = [-1e-4, 1e-4, 1e-3, 5e-4, 1.2e-3, 1.7e-3, 1.7e-3, -1e-4];
    for (time, height) in case.time.iter().zip(heights) {
        assert_eq!(at(2, *time), Some(height), "u_z at {time}");
        assert_eq!(at(0, *time), Some(if *time == 7.0 { 1e-3 } else { 0.0 }), "u_x at {time}");
    }
    let tractions: Vec<f64> = case
        .expect
        .iter()
        .filter(|expectation| expectation.quantity == "joint.normal_traction")
        .map(|expectation| expectation.equals)
        .collect();
    let exact = [
        -116000.0,
        116000.0,
        1017312.0728929382,
        508656.0364464691,
        697585.4214123009,
        0.0,
        0.0,
        -116000.0,
    ];
    for (found, wanted) in tractions.iter().zip(exact) {
        assert!((found - wanted).abs() <= 1e-15 * wanted.abs(), "{found} {wanted}");
    }
    assert_eq!(tractions.len(), 8);
    assert_eq!(case.left_out.len(), 3, "{:?}", case.left_out);
}

/// Every object of the schema is closed or a map of names, and every definition is reached.
#[test]
fn the_schema_leaves_no_section_open() {
    let schema = schema();
    let definitions = schema["$defs"].as_object().expect("definitions");
    let text = schema.to_string();
    for (name, definition) in definitions {
        assert!(text.contains(&format!("\"#/$defs/{name}\"")), "{name} is not used");
        if definition["type"] == "object" {
            assert_eq!(definition["additionalProperties"], false, "{name}");
        }
    }
    assert_eq!(schema["additionalProperties"], false);
    assert!(!text.contains("null"), "a key is written with a value or not at all");
    for key in ["title", "mesh", "materials", "interfaces", "boundary", "time", "expect"] {
        assert!(schema["properties"][key].is_object(), "{key}");
    }
    assert!(definitions["SolverSpec"]["properties"]["form"].is_object());
}

#[test]
fn the_example_of_the_manual_is_right() {
    let page = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/case.md");
    let page = std::fs::read_to_string(page).expect("the manual");
    let blocks: Vec<&str> = page.split("```yaml\n").skip(1).collect();
    let block = |i: usize| blocks[i].split("```").next().expect("the end of a block");
    Case::read(block(0), Path::new("manual.yaml"), &[]).expect("a case without mistakes");
    assert_eq!(blocks.len(), 6);
    // Other whole cases, and blocks of which each line is a section that the case may have.
    let (whole, parts): (Vec<usize>, Vec<usize>) =
        (1..6).partition(|i| block(*i).starts_with("mesh:"));
    assert_eq!(whole.len(), 2);
    let case = |i: usize| Case::read(block(i), Path::new("manual.yaml"), &[]);
    let dam = case(whole[0]).and_then(|dam| dam.for_dimension(3)).expect("a case with a mesh file");
    assert!(dam.mesh.file().is_some());
    let flow = case(whole[1]).expect("a case with flow");
    assert!(flow.flow.is_some());
    for section in parts.into_iter().flat_map(|i| block(i).lines()) {
        let section = section.replacen(": ", "=", 1);
        let changes = [section, "expect=[]".to_owned()];
        Case::read(block(0), Path::new("manual.yaml"), &changes).expect("a section");
    }
}
