//! Field files and the output directory on 1, 2, 3 and 4 ranks, some of them without rows.
//!
//! What is read back is compared bit by bit with one expectation for all numbers of ranks.
//!
//! Launched alone, the program starts itself under `mpirun`; under it, it runs the checks in order.

#![allow(clippy::print_stdout)] // the runner's own report

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

use column_hpc::comm::Comm;
use column_hpc::element::Shape;
use column_hpc::output::directory::OutputDirectory;
use column_hpc::output::publisher::Publisher;
use column_hpc::output::series::{self, Fixed, Series};
use column_hpc::output::vtkhdf::{Array, Data, Grid, Values};
use column_hpc::output::vtkhdf::{rows_of, write_grid};

const LAYERS: usize = 6;
const PER_LAYER: usize = 9;
const PLACE: &str = "COLUMN_HPC_TEST_DIRECTORY";

fn main() {
    match std::env::var_os(PLACE) {
        Some(place) => under_mpirun(Path::new(&place)),
        None => launch(),
    }
}

fn launch() {
    let place = std::env::temp_dir().join(format!("column-hpc-vtkhdf-{}", std::process::id()));
    for ranks in [1, 2, 3, 4] {
        let place = place.join(ranks.to_string());
        std::fs::create_dir_all(&place).expect("the temporary directory is writable");
        run(ranks, &place);
        println!("field files on {ranks} ranks: ok");
    }
    std::fs::remove_dir_all(place).expect("the directory is ours");
}

fn run(ranks: usize, place: &Path) {
    let mut child = Command::new("mpirun")
        .args(["-n", &ranks.to_string(), "--oversubscribe", "--bind-to", "none", "--quiet"])
        .arg(std::env::current_exe().expect("a running program has a path"))
        .env(PLACE, place)
        .env("OMPI_ALLOW_RUN_AS_ROOT", "1")
        .env("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1")
        .env("OMPI_MCA_pml", "ob1")
        .env("OMPI_MCA_btl", "self,vader")
        .env("OMPI_MCA_btl_vader_single_copy_mechanism", "none")
        .env("OMPI_MCA_mpi_yield_when_idle", "1")
        .env("OMPI_MCA_fcoll", "dynamic_gen2")
        .env("OMP_NUM_THREADS", "1")
        .spawn()
        .expect("mpirun: apt-get install openmpi-bin");
    let start = Instant::now();
    let status = loop {
        if let Some(status) = child.try_wait().expect("the child is ours") {
            break status;
        }
        if start.elapsed() > Duration::from_secs(180) {
            child.kill().expect("the child is ours");
            panic!("{ranks} ranks hang");
        }
        std::thread::sleep(Duration::from_millis(10));
    };
    assert!(status.success(), "{ranks} ranks: {status}");
}

fn under_mpirun(place: &Path) {
    std::panic::set_hook(Box::new(|info| {
        eprintln!("{info}");
        // A rank that is left alone would wait in a collective for ever.
        std::process::exit(101);
    }));
    let universe = mpi::initialize().expect("MPI is not initialised yet");
    let comm = Comm::world(universe);
    bulk_reads_back(&comm, place);
    surface_and_line_on_one_rank(&comm, place);
    errors_are_the_same_on_all_ranks(&comm, place);
    directory_is_refused_on_all_ranks(&comm, place);
}

/// Layers of cells of each rank; on 3 and 4 ranks some have none.
fn layers(comm: &Comm) -> std::ops::Range<usize> {
    let ends: &[usize] = match comm.size() {
        1 => &[LAYERS],
        2 => &[2, LAYERS],
        3 => &[3, 3, LAYERS],
        _ => &[0, 1, LAYERS, LAYERS],
    };
    let rank = comm.rank() as usize;
    let start = if rank == 0 { 0 } else { ends[rank - 1] };
    start..ends[rank]
}

fn node(i: usize, j: usize, k: usize) -> i64 {
    (i + 3 * j + PER_LAYER * k) as i64
}

fn point(id: usize) -> [f64; 3] {
    [(id % 3) as f64 / 3.0, (id / 3 % 3) as f64 / 7.0, (id / PER_LAYER) as f64 / 11.0]
}

fn displacement(id: usize) -> [f64; 3] {
    point(id).map(|x| (10.0 * x).sin())
}

/// Points of the layers: a rank owns the lower nodes of its cells, the last one the top as well.
fn points_of(layers: std::ops::Range<usize>) -> Vec<usize> {
    let top = if !layers.is_empty() && layers.end == LAYERS { LAYERS + 1 } else { layers.end };
    (layers.start * PER_LAYER..top * PER_LAYER).collect()
}

fn cells_of(layers: std::ops::Range<usize>) -> Vec<i64> {
    let mut connectivity = Vec::new();
    for k in layers {
        for (i, j) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            for z in [k, k + 1] {
                let corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)];
                connectivity.extend(corners.map(|(x, y)| node(x, y, z)));
            }
        }
    }
    connectivity
}

fn bulk_reads_back(comm: &Comm, place: &Path) {
    let ids = points_of(layers(comm));
    let points: Vec<_> = ids.iter().map(|&id| point(id)).collect();
    let connectivity = cells_of(layers(comm));
    let grid = Grid {
        points: &points,
        connectivity: &connectivity,
        shapes: &vec![Shape::Hex8; connectivity.len() / 8],
    };
    let u: Vec<f64> = ids.iter().flat_map(|&id| displacement(id)).collect();
    let global: Vec<i64> = ids.iter().map(|&id| 100 + id as i64).collect();
    let cells = connectivity.len() / 8;
    let first = rows_of(comm, cells).first as usize;
    let stress: Vec<f64> = (0..6 * cells).map(|i| (6 * first + i) as f64 / 13.0).collect();
    let material: Vec<i32> = (0..cells).map(|c| ((first + c) % 5) as i32).collect();
    let array = |name, components, values| Array { name, components, values };
    let known = Data {
        points: &[array("global_node_id", 1, Values::I64(&global))],
        cells: &[array("material", 1, Values::I32(&material))],
    };
    let data = Data {
        points: &[array("displacement", 3, Values::F64(&u))],
        cells: &[array("stress", 6, Values::F64(&stress))],
    };
    let fixed = Fixed { grid: &grid, data: known };
    let mut publisher = Publisher::default();
    let mut series = Series::new(place.to_path_buf(), "bulk");
    series
        .write(comm, &mut publisher, series::Instant { step: 3, time: 3.0 }, fixed, data)
        .expect("a writable directory");
    let data = Data { cells: &[], ..data };
    series
        .write(comm, &mut publisher, series::Instant { step: 4, time: 3.5 }, fixed, data)
        .expect("a writable directory");
    publisher.finish().expect("a writable directory");

    if comm.rank() == 0 {
        let ids = 0..(LAYERS + 1) * PER_LAYER;
        let cells = 4 * LAYERS;
        let file = Read::open(&place.join("bulk_000003.vtkhdf"));
        assert_eq!(file.kind(), ("UnstructuredGrid".into(), vec![1, 0]));
        assert_eq!(file.raw::<i64>("NumberOfPoints"), [ids.len() as i64]);
        assert_eq!(file.raw::<i64>("NumberOfCells"), [cells as i64]);
        assert_eq!(file.raw::<i64>("NumberOfConnectivityIds"), [8 * cells as i64]);
        assert_eq!(
            bits(&file.raw("Points")),
            bits(&ids.clone().flat_map(point).collect::<Vec<_>>())
        );
        assert_eq!(file.raw::<i64>("Connectivity"), cells_of(0..LAYERS));
        assert_eq!(
            file.raw::<i64>("Offsets"),
            (0..=cells as i64).map(|c| 8 * c).collect::<Vec<_>>()
        );
        assert_eq!(file.raw::<u8>("Types"), vec![12; cells]);
        let u: Vec<f64> = ids.clone().flat_map(displacement).collect();
        assert_eq!(bits(&file.raw("PointData/displacement")), bits(&u));
        let global: Vec<i64> = ids.map(|id| 100 + id as i64).collect();
        assert_eq!(file.raw::<i64>("PointData/global_node_id"), global);
        let stress: Vec<f64> = (0..6 * cells).map(|i| i as f64 / 13.0).collect();
        assert_eq!(bits(&file.raw("CellData/stress")), bits(&stress));
        assert_eq!(file.shape("CellData/stress"), [cells, 6]);
        let material: Vec<i32> = (0..cells).map(|c| (c % 5) as i32).collect();
        assert_eq!(file.raw::<i32>("CellData/material"), material);

        let text = std::fs::read_to_string(place.join("bulk.vtkhdf.series")).expect("the index");
        let index: serde_json::Value = serde_json::from_str(&text).expect("JSON");
        let expected = serde_json::json!({"file-series-version": "1.0", "files": [
            {"name": "bulk_000003.vtkhdf", "time": 3.0}, {"name": "bulk_000004.vtkhdf", "time": 3.5}]});
        assert_eq!(index, expected);
    }
}

/// An interface, and a 2D one, that only the last rank holds.
fn surface_and_line_on_one_rank(comm: &Comm, place: &Path) {
    let here = comm.rank() == comm.size() - 1;
    let all: Vec<[f64; 3]> = (0..PER_LAYER).map(point).collect();
    let quads = [[0, 1, 4, 3], [1, 2, 5, 4], [3, 4, 7, 6], [4, 5, 8, 7]];
    let damage: Vec<f64> = (0..PER_LAYER).map(|i| i as f64 / 8.0).collect();
    let grid = Grid {
        points: if here { &all } else { &[] },
        connectivity: if here { quads.as_flattened() } else { &[] },
        shapes: if here { &[Shape::Quad4; 4] } else { &[] },
    };
    let data = [Array {
        name: "damage",
        components: 1,
        values: Values::F64(if here { &damage } else { &[] }),
    }];
    let mut series = Series::new(place.to_path_buf(), "joint");
    let fixed = Fixed { grid: &grid, data: Data::default() };
    let data = Data { points: &data, cells: &[] };
    let publisher = &mut Publisher::default();
    series
        .write(comm, publisher, series::Instant { step: 3, time: 3.0 }, fixed, data)
        .expect("a writable directory");

    let line = Grid {
        points: if here { &all[..3] } else { &[] },
        connectivity: if here { &[0, 1, 1, 2] } else { &[] },
        shapes: if here { &[Shape::Line2; 2] } else { &[] },
    };
    let none = Data::default();
    write_grid(comm, publisher, &place.join("line.vtkhdf"), &line, none)
        .expect("a writable directory");
    // Nothing anywhere: an interface without cells in a part of the model still has its file.
    let nothing = Grid { points: &[], connectivity: &[], shapes: &[] };
    write_grid(comm, publisher, &place.join("nothing.vtkhdf"), &nothing, none)
        .expect("a writable directory");
    publisher.finish().expect("a writable directory");

    if comm.rank() == 0 {
        let file = Read::open(&place.join("joint_000003.vtkhdf"));
        assert_eq!(file.raw::<i64>("Connectivity"), quads.as_flattened());
        assert_eq!(file.raw::<u8>("Types"), [9; 4]);
        assert_eq!(bits(&file.raw("PointData/damage")), bits(&damage));
        let file = Read::open(&place.join("line.vtkhdf"));
        assert_eq!(file.raw::<i64>("Offsets"), [0, 2, 4]);
        assert_eq!(Read::open(&place.join("nothing.vtkhdf")).raw::<i64>("Offsets"), [0]);
        let left = std::fs::read_dir(place).expect("a directory").filter(|e| {
            let name = e.as_ref().expect("an entry").file_name();
            name.to_string_lossy().contains(".tmp.")
        });
        assert_eq!(left.count(), 0, "temporary files are left");
    }
}

fn errors_are_the_same_on_all_ranks(comm: &Comm, place: &Path) {
    let grid = Grid { points: &[[0.0; 3]], connectivity: &[], shapes: &[] };
    let (publisher, none) = (&mut Publisher::default(), Data::default());
    let error = write_grid(comm, publisher, &place.join("absent/bulk.vtkhdf"), &grid, none)
        .expect_err("there is no such directory");
    assert_eq!(error.exit_status(), 4);
    let text = error.to_string();
    assert!(text.contains("absent/bulk.vtkhdf") && text.contains("No such file"), "{text}");

    // One rank is wrong: one row too many.
    let last = comm.rank() == comm.size() - 1;
    let own: &[i64] = if last { &[0, i64::from(comm.size())] } else { &[] };
    let grid = Grid { connectivity: own, shapes: if last { &[Shape::Line2] } else { &[] }, ..grid };
    let path = place.join("wrong.vtkhdf");
    let error =
        write_grid(comm, publisher, &path, &grid, none).expect_err("a row that nobody writes");
    assert_eq!(error.exit_status(), 101);
    assert!(error.to_string().contains(&format!("row {} of", comm.size())), "{error}");
    assert!(!path.exists());
}

fn directory_is_refused_on_all_ranks(comm: &Comm, place: &Path) {
    let path = place.join("results");
    let (case, other) = (r#"{"title":"one","a":1}"#, r#"{"title":"one","a":2}"#);
    let directory = OutputDirectory::open(comm, &path, case, false).expect("a new directory");
    comm.barrier();
    let error = OutputDirectory::open(comm, &path, other, false).expect_err("another case");
    assert_eq!(error.exit_status(), 2);
    assert!(error.to_string().contains("`a` differs"), "{error}");
    OutputDirectory::open(comm, &path, other, true).expect("overwriting");
    assert_eq!(directory.fields(), path.join("fields"));
    assert!(directory.fields().is_dir());
}

fn bits(values: &[f64]) -> Vec<u64> {
    values.iter().map(|v| v.to_bits()).collect()
}

/// A field file read by one process.
struct Read {
    file: hdf5::File,
    path: PathBuf,
}

impl Read {
    fn open(path: &Path) -> Self {
        let file = hdf5::File::open(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        Self { file, path: path.to_path_buf() }
    }

    fn dataset(&self, name: &str) -> hdf5::Dataset {
        let found = self.file.dataset(&format!("VTKHDF/{name}"));
        found.unwrap_or_else(|e| panic!("{} {name}: {e}", self.path.display()))
    }

    fn raw<T: hdf5::H5Type>(&self, name: &str) -> Vec<T> {
        self.dataset(name).read_raw().unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    fn shape(&self, name: &str) -> Vec<usize> {
        self.dataset(name).shape()
    }

    fn kind(&self) -> (String, Vec<i64>) {
        let group = self.file.group("VTKHDF").expect("the group");
        let kind = group.attr("Type").expect("the type");
        assert_eq!(kind.dtype().expect("its type").size(), 16);
        let kind = kind.read_scalar::<hdf5::types::FixedAscii<16>>().expect("ASCII");
        (kind.to_string(), group.attr("Version").expect("the version").read_raw().expect("numbers"))
    }
}
