//! Pictures of runs whose field files hold cells of all kinds.

use std::fs;
use std::path::{Path, PathBuf};

use ::hdf5::File;

use super::plot::{Request, plot};
use super::skin::tests::block;
use crate::case::Case;
use crate::element::Shape;
use crate::output::vtkhdf::cell_type;
use crate::results::FieldGrid;

const CASE: &str = "\
title: Any mesh
mesh: {column: {size: [4, 4, 4], cells: [4, 4, 4]}}
materials: {rock: {elastic: {young_modulus: 5.8e9, poisson_ratio: 0}}}
boundary:
  - {on: bottom, displacement: {x: 0, y: 0, z: 0}}
  - {on: top, traction: {z: -2.0e6}}
time: {instants: [1, 2]}
";

/// A folder of a run, removed with its end.
struct Folder(PathBuf);

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

impl Folder {
    /// Writes what a run of the case would have, with this mesh in the place of its own.
    fn of(name: &str, grid: &FieldGrid) -> Self {
        let place = std::env::temp_dir();
        let folder = Self(place.join(format!("column-hpc-scene-{name}-{}", std::process::id())));
        fs::create_dir_all(folder.0.join("fields")).expect("a temporary directory");
        let case = Case::read(CASE, Path::new("case.yaml"), &[]).expect("a case");
        let text = serde_json::to_string(&case.resolved()).expect("JSON");
        fs::write(folder.0.join("case.resolved.json"), text).expect("a file of ours");
        fs::write(folder.0.join("history.csv"), "time\n1\n2\n").expect("a file of ours");
        let index = r#"{"files": [{"name": "bulk_1.vtkhdf", "time": 1}, {"name": "bulk_1.vtkhdf", "time": 2}]}"#;
        let index_path = folder.0.join("fields/bulk.vtkhdf.series");
        fs::write(index_path, index).expect("a file of ours");
        fields(&folder.0.join("fields/bulk_1.vtkhdf"), grid).expect("a field file");
        folder
    }

    fn plot(&self, of: &str, at: Option<f64>) -> Result<String, String> {
        let request = Request {
            directory: self.0.clone(),
            of: of.to_owned(),
            at,
            output: Some(self.0.join("picture.svg")),
        };
        let [drawing, image] = plot(&request).map_err(|error| error.to_string())?;
        assert_eq!(&fs::read(image).expect("an image")[1..4], b"PNG");
        Ok(fs::read_to_string(drawing).expect("a drawing"))
    }
}

/// All texts of a drawing, in their order.
fn texts(svg: &str) -> String {
    let texts = svg.split("<text").skip(1).filter_map(|text| {
        let text = text.split_once('>')?.1.split_once("</text>")?.0;
        Some(text.trim())
    });
    texts.collect::<Vec<_>>().join(" ")
}

fn fields(path: &Path, grid: &FieldGrid) -> ::hdf5::Result<()> {
    let file = File::create(path)?;
    let group = file.create_group("VTKHDF")?;
    let put = |group: &::hdf5::Group, name: &str, components: usize, values: &[f64]| {
        let rows = values.len() / components;
        let dataset = group.new_dataset::<f64>().shape([rows, components]).create(name)?;
        dataset.write_raw(values)
    };
    put(&group, "Points", 3, grid.points.as_flattened())?;
    let whole = |name: &str, values: Vec<i64>| {
        group.new_dataset::<i64>().shape([values.len()]).create(name)?.write_raw(&values)
    };
    whole("Connectivity", grid.nodes.iter().map(|n| i64::from(*n)).collect())?;
    whole("Offsets", grid.starts.iter().map(|s| *s as i64).collect())?;
    whole("Types", grid.shapes.iter().map(|s| i64::from(cell_type(*s))).collect())?;
    let points = group.create_group("PointData")?;
    let moved: Vec<f64> =
        grid.points.iter().flat_map(|p| [1e-4 * p[2] * p[2], 0.0, -2e-4 * p[2]]).collect();
    put(&points, "displacement", 3, &moved)?;
    let cells = group.create_group("CellData")?;
    let stress: Vec<f64> =
        (0..grid.shapes.len()).flat_map(|i| [0.0, 0.0, 1e5 * i as f64, 0.0, 0.0, 0.0]).collect();
    put(&cells, "stress", 6, &stress)
}

/// A block whose hexahedra are cut: by turns into six tetrahedra, two prisms, six pyramids about a
/// point in the middle, or not at all.
fn mixed(counts: [usize; 3]) -> FieldGrid {
    let whole = block(counts);
    let mut grid =
        FieldGrid { points: whole.points.clone(), starts: vec![0], ..Default::default() };
    for cell in 0..whole.shapes.len() {
        let nodes = whole.cell(cell);
        let mut push = |shape: Shape, local: &[usize], apex: Option<u32>| {
            grid.shapes.push(shape);
            grid.nodes.extend(local.iter().map(|i| nodes[*i]).chain(apex));
            grid.starts.push(grid.nodes.len());
        };
        // Layers of one kind each: their sides fit each other where diagonals do.
        match cell * 4 / whole.shapes.len() {
            0 => {
                for [a, b] in [[1, 2], [2, 3], [3, 7], [7, 4], [4, 5], [5, 1]] {
                    push(Shape::Tet4, &[0, a, b, 6], None);
                }
            }
            1 => {
                push(Shape::Prism6, &[0, 1, 2, 4, 5, 6], None);
                push(Shape::Prism6, &[0, 2, 3, 4, 6, 7], None);
            }
            2 => {
                let middle = whole.points.len() + cell;
                for facet in Shape::Hex8.facets() {
                    let base: Vec<usize> = facet.iter().rev().copied().collect();
                    push(Shape::Pyramid5, &base, Some(middle as u32));
                }
            }
            _ => push(Shape::Hex8, &[0, 1, 2, 3, 4, 5, 6, 7], None),
        }
    }
    for cell in 0..whole.shapes.len() {
        let corners = whole.cell(cell).iter().map(|i| whole.points[*i as usize]);
        let sum = corners.fold([0.0; 3], |sum, p| super::vector::plus(sum, 0.125, p));
        grid.points.push(sum);
    }
    grid
}

#[test]
fn meshes_of_cells_of_all_kinds_are_drawn_the_same_each_time() {
    let folder = Folder::of("mixed", &mixed([4, 4, 4]));
    let mesh = folder.plot("mesh", None).expect("a drawing");
    for words in [
        "96 tetrahedra of 4 nodes",
        "32 prisms of 6 nodes",
        "96 pyramids of 5 nodes",
        "16 hexahedra of 8 nodes",
        "bottom x, y, z held",
        "top traction z -2 MPa",
    ] {
        assert!(texts(&mesh).contains(words), "{words} in {}", texts(&mesh));
    }
    assert!(mesh.contains("role=\"img\"") && mesh.contains("prefers-color-scheme:dark"));
    for words in ["<script", "href", "url(", "NaN", "inf"] {
        assert!(!mesh.contains(words), "{words}");
    }
    assert_eq!(mesh, folder.plot("mesh", None).expect("the same"));
    let shape = folder.plot("displacement", Some(1.0)).expect("a drawing");
    assert!(shape.contains(">t = 1 s<") && shape.contains(">displacement [mm]<"), "{shape}");
    let stress = folder.plot("von_mises", None).expect("a drawing");
    assert!(stress.contains(">von Mises stress [MPa]<") && stress.contains(">t = 2 s<"));
}

#[test]
fn a_large_mesh_makes_a_small_drawing_that_tells_so() {
    let folder = Folder::of("large", &block([110, 100, 1]));
    for of in ["mesh", "displacement", "stress_zz"] {
        let text = folder.plot(of, None).expect("a drawing");
        assert!(text.len() < 3_000_000, "{of}: {} bytes", text.len());
        let told = texts(&text);
        assert!(told.contains("The surface has 22\u{a0}420 facets"), "{of}: {told}");
        assert!(told.contains("merged on a grid of"), "{of}: {told}");
    }
}

#[test]
fn what_cannot_be_drawn_is_told_with_what_can() {
    let folder = Folder::of("wrong", &block([1, 1, 1]));
    let told = |of: &str, at| folder.plot(of, at).expect_err("a refusal");
    let unknown = told("von_misses", None);
    assert!(unknown.contains("did you mean `von_mises`?"), "{unknown}");
    assert!(unknown.contains("mesh, displacement, displacement_x"), "{unknown}");
    let late = told("mesh", Some(7.0));
    assert!(late.contains("no fields were written at 7 s") && late.contains("1, 2"), "{late}");
    // A file that does not fit itself.
    let mut short = block([1, 1, 1]);
    short.points.truncate(7);
    fields(&folder.0.join("fields/bulk_1.vtkhdf"), &short).expect("a field file");
    assert!(told("mesh", None).contains("its cells do not fit its points"));
    fs::remove_file(folder.0.join("fields/bulk.vtkhdf.series")).expect("a file of ours");
    let none = told("mesh", None);
    assert!(none.contains("has no field files") && none.contains("fields: all"), "{none}");
    fs::remove_file(folder.0.join("history.csv")).expect("a file of ours");
    assert!(told("mesh", None).contains("holds no results"));
}
