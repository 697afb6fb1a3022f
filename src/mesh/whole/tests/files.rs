//! The files of the readers' tests, made whole.

use super::blocks::{dot, made, middle, minus, request, request_on};
use super::looks::{check, key, volume};
use crate::mesh::import::{FileMesh, Kind, gmsh, med};
use crate::mesh::whole::{Request, build, dual_graph};

/// All files, with what the readers make of them.
fn files() -> Vec<(String, FileMesh)> {
    let folder = format!("{}/tests/meshes", env!("CARGO_MANIFEST_DIR"));
    let entries = std::fs::read_dir(&folder).unwrap_or_else(|error| panic!("{folder}: {error}"));
    let mut paths: Vec<_> = entries.flatten().map(|entry| entry.path()).collect();
    paths.sort();
    let mut found = Vec::new();
    for path in paths {
        let name = path.file_name().map(|name| name.to_string_lossy().into_owned());
        let name = name.unwrap_or_default();
        let mesh = if name.ends_with(".msh") {
            let bytes = std::fs::read(&path).unwrap_or_else(|error| panic!("{name}: {error}"));
            gmsh::read(&bytes)
        } else if name.ends_with(".med") {
            med::read(&path)
        } else {
            continue;
        };
        found.push((name.clone(), mesh.unwrap_or_else(|error| panic!("{name}: {error}"))));
    }
    found
}

#[test]
fn files_of_gmsh_and_medcoupling_are_made_whole() {
    let files = files();
    assert!(files.len() >= 20, "{}", files.len());
    for (name, file) in files {
        let dim = file.blocks.iter().map(|block| block.kind.dim()).max().unwrap_or(0);
        let below = file.groups.iter().filter(|group| group.dim < dim);
        let mut surfaces: Vec<String> = below.map(|group| group.name.clone()).collect();
        surfaces.sort();
        surfaces.dedup();
        let asked = Request { surfaces, ..request() };
        let has_pyramids = file.blocks.iter().any(|block| {
            matches!(block.kind, Kind::Pyramid13 | Kind::Pyramid14) && !block.numbers.is_empty()
        });
        // Its sides lie on each other and share no node: a case has to name them.
        let is_cut = name.ends_with("med_cut.med");
        if has_pyramids || is_cut {
            assert!(build(&file, &asked, &name).is_err());
            continue;
        }
        let mesh = build(&file, &asked, &name).unwrap_or_else(|error| panic!("{error}"));
        println!(
            "{name}: {} cells, {} nodes, volume {}, {} bodies, {:?}",
            mesh.cells(),
            mesh.points.len(),
            volume(&mesh),
            mesh.body_count,
            mesh.remarks
        );
        assert!(volume(&mesh) > 0.0);
        let graph = dual_graph(&mesh);
        assert_eq!(graph.work.len(), mesh.cells());
        for surface in &mesh.surfaces {
            assert!(!surface.nodes.is_empty(), "{name}");
        }
    }
}

#[test]
fn a_file_is_cut_along_its_joint() {
    let files = files();
    let squares: Vec<_> = files.iter().filter(|(name, _)| name.contains("square-")).collect();
    assert_eq!(squares.len(), 4);
    for (name, file) in squares {
        let group = file.groups.iter().position(|group| group.name == "joint");
        let group = group.unwrap_or_else(|| panic!("{name} has a joint")) as u32;
        let mut middles = Vec::new();
        let mut length = 0.0;
        for block in file.blocks.iter().filter(|block| block.kind == Kind::Line2) {
            for (line, set) in block.nodes.chunks(2).zip(&block.groups) {
                if file.group_sets[*set as usize].contains(&group) {
                    middles.push(key(middle(file, line)));
                    let [p, q] = [line[0], line[1]].map(|node| file.points[node as usize]);
                    length += dot(minus(p, q), minus(p, q)).sqrt();
                }
            }
        }
        for order in [1, 2] {
            let asked = Request { raise_order: Some(order), ..request_on(&["joint"]) };
            let mesh = made(file, &asked);
            check(&mesh, &[length], |p| middles.contains(&key(p)));
        }
    }
}

#[test]
fn a_file_raised_keeps_its_volume() {
    for (name, file) in files().iter().filter(|(name, _)| name.contains("square-")) {
        let plain = made(file, &request());
        let raised = made(file, &Request { raise_order: Some(2), ..request() });
        assert!((volume(&plain) - volume(&raised)).abs() < 1e-12, "{name}");
        assert!(raised.points.len() > plain.points.len());
    }
}

#[test]
fn every_file_keeps_its_volume_when_it_is_refined() {
    let mut number = 0;
    for (name, file) in files() {
        let Ok(plain) = build(&file, &request(), &name) else { continue };
        let refined = made(&file, &Request { refine: 1, ..request() });
        let apart = volume(&refined) / volume(&plain) - 1.0;
        assert!(apart.abs() < 1e-12, "{name}: {apart}");
        assert!(refined.cells() >= plain.cells() << plain.dim());
        assert_eq!(refined.body_count, plain.body_count, "{name}");
        number += 1;
    }
    assert!(number >= 15, "{number}");
}
