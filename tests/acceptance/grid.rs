//! Field files as the tests read them.

use std::path::Path;

use column_hpc::element::Shape;

/// A grid of a field file.
pub struct Grid {
    pub points: Vec<[f64; 3]>,
    pub cells: Vec<(Shape, Vec<usize>)>,
    /// By point; of a scalar the first.
    pub values: Vec<[f64; 3]>,
}

fn rows(dataset: &hdf5::Dataset) -> Vec<[f64; 3]> {
    let values = dataset.read_raw::<f64>().expect("numbers");
    match dataset.ndim() {
        1 => values.into_iter().map(|value| [value, 0.0, 0.0]).collect(),
        _ => values.as_chunks::<3>().0.to_vec(),
    }
}

/// The grid with an array of its points.
pub fn read(path: &Path, array: &str) -> Grid {
    let file = hdf5::File::open(path).expect("a field file");
    let group = file.group("VTKHDF").expect("the group of the format");
    let list = |name: &str| group.dataset(name).expect(name).read_raw::<i64>().expect("numbers");
    let (connectivity, offsets) = (list("Connectivity"), list("Offsets"));
    let types = group.dataset("Types").expect("Types").read_raw::<u8>().expect("numbers");
    let shape = |number: u8| match number {
        3 => Shape::Line2,
        9 => Shape::Quad4,
        12 => Shape::Hex8,
        21 => Shape::Line3,
        28 => Shape::Quad9,
        29 => Shape::Hex27,
        other => panic!("cells of type {other}"),
    };
    let nodes = |ends: &[i64]| {
        connectivity[ends[0] as usize..ends[1] as usize].iter().map(|n| *n as usize).collect()
    };
    let cells = offsets.windows(2).zip(types).map(|(ends, t)| (shape(t), nodes(ends))).collect();
    let values = group.dataset(&format!("PointData/{array}")).expect(array);
    Grid { points: rows(&group.dataset("Points").expect("Points")), cells, values: rows(&values) }
}

/// Components that a 2D or 3D cell has.
pub fn plane<const DIM: usize>(x: [f64; 3]) -> [f64; DIM] {
    std::array::from_fn(|i| if DIM == 2 && i == 1 { x[2] } else { x[i] })
}
