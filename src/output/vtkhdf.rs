//! Field files: VTKHDF 1.0 static unstructured grids, one file for all ranks.
//!
//! A file holds one part in global numbering: the rows of rank r follow those of the ranks below
//! it, a node appears once, and connectivity counts rows of the whole file. Readers then give a
//! plain grid, on any number of ranks.
//!
//! Format: VTK file formats, "VTKHDF file format", version 1.0.

use std::path::Path;

use super::atomic_hdf5::AtomicFile;
use super::hdf5::{CollectiveFile, Rows};
use super::publisher::Publisher;
use crate::comm::Comm;
use crate::element::Shape;
use crate::error::{Error, Result};
use crate::fault;
use ::hdf5::Group;
use ::hdf5::types::FixedAscii;

/// VTK's number of a kind of cell.
pub const fn cell_type(shape: Shape) -> u8 {
    match shape {
        Shape::Line2 => 3,
        Shape::Tri3 => 5,
        Shape::Quad4 => 9,
        Shape::Tet4 => 10,
        Shape::Hex8 => 12,
        Shape::Prism6 => 13,
        Shape::Pyramid5 => 14,
        Shape::Line3 => 21,
        Shape::Tri6 => 22,
        Shape::Tet10 => 24,
        Shape::Quad9 => 28,
        Shape::Hex27 => 29,
        Shape::Prism18 => 32,
    }
}

/// One rank's share of a grid.
#[derive(Debug, Clone, Copy)]
pub struct Grid<'a> {
    /// Positions of the points that this rank writes in m; of a 2D model (x, 0, z).
    pub points: &'a [[f64; 3]],
    /// Points of this rank's cells as rows of the whole file, cell by cell.
    pub connectivity: &'a [i64],
    /// The shape of each of this rank's cells.
    pub shapes: &'a [Shape],
}

/// A grid in another file of the same directory.
#[derive(Debug, Clone, Copy)]
pub struct StoredGrid<'a> {
    /// Name of the file.
    pub file: &'a str,
    /// The grid.
    pub grid: &'a Grid<'a>,
    /// What does not change, in the same file.
    pub data: Data<'a>,
}

/// What the datasets of a grid are called, counts first.
const GRID: [&str; 7] = [
    "NumberOfPoints",
    "NumberOfCells",
    "NumberOfConnectivityIds",
    "Points",
    "Connectivity",
    "Offsets",
    "Types",
];
/// Group of the values at points.
const POINT_DATA: &str = "PointData";

/// The data of a file.
#[derive(Debug, Clone, Copy, Default)]
pub struct Data<'a> {
    /// Values at points.
    pub points: &'a [Array<'a>],
    /// Values at cells.
    pub cells: &'a [Array<'a>],
}

/// Values at this rank's points or cells, shape (points or cells, `components`).
#[derive(Debug, Clone, Copy)]
pub struct Array<'a> {
    /// Name in the file, without `/` and `.`.
    pub name: &'a str,
    /// Number of components; two are for neither vectors nor tensors: write vectors with three.
    pub components: usize,
    /// The numbers, row by row.
    pub values: Values<'a>,
}

impl Array<'_> {
    /// Bytes of one row in the file.
    fn row_bytes(&self) -> u64 {
        let one = match self.values {
            Values::F64(_) | Values::I64(_) => 8,
            Values::I32(_) => 4,
        };
        one * self.components as u64
    }
}

/// The numbers of an [`Array`].
#[derive(Debug, Clone, Copy)]
pub enum Values<'a> {
    /// Real numbers.
    F64(&'a [f64]),
    /// Global ids.
    I64(&'a [i64]),
    /// Small integers: rank, material, state.
    I32(&'a [i32]),
}

impl Values<'_> {
    fn len(&self) -> usize {
        match self {
            Values::F64(v) => v.len(),
            Values::I64(v) => v.len(),
            Values::I32(v) => v.len(),
        }
    }
}

/// The row of this rank's first of `own` rows, and the number of rows of all ranks.
///
/// # Parallel
/// Collective.
pub fn rows_of(comm: &Comm, own: usize) -> Rows {
    let own = own as u64;
    Rows { first: comm.exscan_u64(own), total: comm.sum_u64(own) }
}

/// Writes one grid with its data; the file is complete or absent under its name, which `publisher`
/// gives it.
///
/// # Arguments
/// * `point_data`, `cell_data` the same names, kinds and components in the same order on all ranks
///
/// # Errors
/// [`Error::System`] with the path and the reason if the file cannot be written; [`Error::Bug`] if
/// lengths do not fit or connectivity names a row that no rank writes. The same on all ranks.
///
/// # Parallel
/// Collective; a rank may have no points and no cells.
pub fn write_grid(
    comm: &Comm,
    publisher: &mut Publisher,
    path: &Path,
    grid: &Grid,
    data: Data,
) -> Result<()> {
    let writer = GridWriter::new(comm, path, grid);
    comm.agree(check(grid, writer.points.total, data))?;
    let size = writer.size_of(data) + writer.size_of_grid();
    writer.write(publisher, size, |file, group| {
        writer.grid(file, group, grid)?;
        writer.data(file, group, data, |_, _| Ok(()))
    })
}

/// Writes data on a grid that is in another file. The new file links to all of that.
///
/// # Errors
/// As [`write_grid`].
///
/// # Parallel
/// Collective; a rank may have no points and no cells.
pub fn write_data(
    comm: &Comm,
    publisher: &mut Publisher,
    path: &Path,
    stored: StoredGrid,
    data: Data,
) -> Result<()> {
    let StoredGrid { file, grid, data: fixed } = stored;
    let writer = GridWriter::new(comm, path, grid);
    comm.agree(check(grid, writer.points.total, data))?;
    let link = |group: &Group, place: &str, name: &str| {
        writer.file.agreed(group.link_external(file, &format!("{place}/{name}"), name))
    };
    writer.write(publisher, writer.size_of(data), |file, group| {
        for name in GRID {
            link(group, "/VTKHDF", name)?;
        }
        writer.data(file, group, data, |group, name| {
            let arrays = if name == POINT_DATA { fixed.points } else { fixed.cells };
            let place = format!("/VTKHDF/{name}");
            arrays.iter().try_for_each(|array| link(group, &place, array.name))
        })
    })
}

fn check(grid: &Grid, points: u64, data: Data) -> Result<()> {
    let bug = |text: String| Err(Error::Bug(format!("field output: {text}")));
    let (rows, nodes) = (grid.shapes.len(), grid.shapes.iter().map(|s| s.nodes()).sum::<usize>());
    if nodes != grid.connectivity.len() {
        let entries = grid.connectivity.len();
        return bug(format!("{entries} connectivity entries for cells of {nodes} nodes"));
    }
    if let Some(row) = grid.connectivity.iter().find(|&&r| r < 0 || r as u64 >= points) {
        return bug(format!("connectivity names row {row} of {points} points"));
    }
    let of = |arrays: &'_ [Array], rows: usize| {
        let wrong =
            arrays.iter().find(|a| a.components == 0 || a.values.len() != rows * a.components);
        wrong.map(|a| (a.name.to_string(), a.values.len(), a.components, rows))
    };
    match of(data.points, grid.points.len()).or_else(|| of(data.cells, rows)) {
        Some((name, values, components, rows)) => {
            bug(format!("{name} has {values} values for {rows} rows of {components} components"))
        }
        None => Ok(()),
    }
}

struct GridWriter<'a> {
    file: AtomicFile<'a>,
    points: Rows,
    cells: Rows,
    connectivity: Rows,
}

impl<'a> GridWriter<'a> {
    /// Collective.
    fn new(comm: &'a Comm, path: &'a Path, grid: &Grid) -> Self {
        let (points, cells) = (rows_of(comm, grid.points.len()), rows_of(comm, grid.shapes.len()));
        let connectivity = rows_of(comm, grid.connectivity.len());
        Self { file: AtomicFile { comm, path }, points, cells, connectivity }
    }

    /// Bytes of data, with ample room for names and shapes.
    fn size_of(&self, data: Data) -> u64 {
        let of = |arrays: &[Array]| -> u64 { arrays.iter().map(Array::row_bytes).sum() };
        let headers = 16384 + 4096 * (data.points.len() + data.cells.len()) as u64;
        self.points.total * of(data.points) + self.cells.total * of(data.cells) + headers
    }

    /// Bytes of the grid.
    fn size_of_grid(&self) -> u64 {
        self.points.total * 24 + self.connectivity.total * 8 + self.cells.total * 9
    }

    /// Writes the file, `fill` what is in its group, and has it published.
    fn write(
        &self,
        publisher: &mut Publisher,
        size: u64,
        fill: impl FnOnce(&CollectiveFile, &Group) -> Result<()>,
    ) -> Result<()> {
        let path = self.file.path;
        let publish = |temporary: &Path| publisher.publish(temporary, path);
        self.file.write("VTKHDF", size, publish, |file, group| {
            self.file.agreed(write_kind(group))?;
            fault::strike(self.file.comm, "output")?;
            fill(file, group)
        })
    }

    fn grid(&self, file: &CollectiveFile, group: &Group, grid: &Grid) -> Result<()> {
        let (points, cells, connectivity) = (self.points, self.cells, self.connectivity);
        let root = self.file.comm.is_root();
        let totals = [points.total, cells.total, connectivity.total];
        for (name, total) in GRID.into_iter().zip(totals) {
            let own: &[i64] = if root { &[total as i64] } else { &[] };
            self.file.rows(file, group, name, Rows { first: 0, total: 1 }, 1, own)?;
        }
        self.file.rows(file, group, "Points", points, 3, grid.points.as_flattened())?;
        self.file.rows(file, group, "Connectivity", connectivity, 1, grid.connectivity)?;

        // Offsets has one entry more than there are cells: rank 0 writes the leading zero.
        let mut end = connectivity.first as i64;
        let ends = grid.shapes.iter().map(|shape| {
            end += shape.nodes() as i64;
            end
        });
        let offsets: Vec<i64> = root.then_some(0).into_iter().chain(ends).collect();
        let first = if root { 0 } else { cells.first + 1 };
        self.file.rows(
            file,
            group,
            "Offsets",
            Rows { first, total: cells.total + 1 },
            1,
            &offsets,
        )?;
        let types: Vec<u8> = grid.shapes.iter().map(|shape| cell_type(*shape)).collect();
        self.file.rows(file, group, "Types", cells, 1, &types)
    }

    /// Writes data; `more` adds to the group of the given name.
    fn data(
        &self,
        file: &CollectiveFile,
        parent: &Group,
        data: Data,
        more: impl Fn(&Group, &str) -> Result<()>,
    ) -> Result<()> {
        let kinds = [(POINT_DATA, self.points, data.points), ("CellData", self.cells, data.cells)];
        for (name, rows, arrays) in kinds {
            let group = self.file.agreed(parent.create_group(name))?;
            for array in arrays {
                let (name, components) = (array.name, array.components);
                match array.values {
                    Values::F64(v) => self.file.rows(file, &group, name, rows, components, v)?,
                    Values::I64(v) => self.file.rows(file, &group, name, rows, components, v)?,
                    Values::I32(v) => self.file.rows(file, &group, name, rows, components, v)?,
                }
            }
            more(&group, name)?;
        }
        Ok(())
    }
}

/// The two attributes by which readers know the format.
///
/// `Type` must be a fixed-length ASCII string of exactly its length: older readers refuse others.
fn write_kind(group: &Group) -> ::hdf5::Result<()> {
    let kind = FixedAscii::<16>::from_ascii(b"UnstructuredGrid").expect("sixteen ASCII letters");
    group.new_attr::<FixedAscii<16>>().create("Type")?.write_scalar(&kind)?;
    group.new_attr_builder().with_data(&[1i64, 0]).create("Version")?;
    Ok(())
}
