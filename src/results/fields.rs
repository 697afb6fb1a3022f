//! One field file: a grid, and the values at its points and cells.

use std::path::{Path, PathBuf};

use ::hdf5::{Dataset, File, Group};

use crate::element::Shape;
use crate::error::{Error, Result};
use crate::output::vtkhdf::cell_type;

/// Where values at points and at cells are.
const POINT_DATA: &str = "PointData";
const CELL_DATA: &str = "CellData";

/// The fields of the bulk or of an interface at one instant. Arrays are read when they are asked
/// for; everything here is local.
#[derive(Debug)]
pub struct Snapshot {
    path: PathBuf,
    group: Group,
}

/// The grid of a field file: cells of any kinds.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct FieldGrid {
    /// The places of the points (m).
    pub points: Vec<[f64; 3]>,
    /// The shape of each cell.
    pub shapes: Vec<Shape>,
    /// Where the points of each cell begin in `nodes`, and where those of the last end.
    pub starts: Vec<usize>,
    /// The points of the cells by their rows, in the order of the shapes.
    pub nodes: Vec<u32>,
}

impl FieldGrid {
    /// The points of a cell.
    pub fn cell(&self, cell: usize) -> &[u32] {
        &self.nodes[self.starts[cell]..self.starts[cell + 1]]
    }
}

/// Values at points or cells, one row for each.
#[derive(Debug, Clone, PartialEq)]
pub struct Array {
    /// Values of a row: 1, 3 for vectors (x, y, z), 6 for stresses (xx, yy, zz, xy, yz, xz).
    pub components: usize,
    /// The values, row by row.
    pub values: Vec<f64>,
}

impl Array {
    /// The rows, in the order of the points or cells.
    pub fn rows(&self) -> impl ExactSizeIterator<Item = &[f64]> {
        self.values.chunks_exact(self.components)
    }
}

impl Snapshot {
    /// Opens a field file. The file with the grid, to which it leads, stands beside it.
    ///
    /// # Errors
    /// [`Error::System`] with the path when it is no field file.
    pub fn open(path: &Path) -> Result<Self> {
        let failed = |cause: ::hdf5::Error| Error::file("cannot read", path, cause);
        let group = File::open(path).and_then(|file| file.group("VTKHDF")).map_err(failed)?;
        Ok(Self { path: path.to_path_buf(), group })
    }

    /// The places of the points (m); y is 0 in 2D.
    ///
    /// # Errors
    /// [`Error::System`] when they cannot be read.
    pub fn points(&self) -> Result<Vec<[f64; 3]>> {
        let points = self.read("Points")?;
        if points.components != 3 {
            return Err(self.wrong("Points has no three components"));
        }
        Ok(points.values.as_chunks::<3>().0.to_vec())
    }

    /// The shape of each cell, and its points by their rows.
    ///
    /// # Errors
    /// [`Error::System`] when they cannot be read, or do not fit each other.
    pub fn cells(&self) -> Result<Vec<(Shape, Vec<usize>)>> {
        let grid = self.grid()?;
        let rows = |cell| grid.cell(cell).iter().map(|row| *row as usize).collect();
        Ok(grid.shapes.iter().enumerate().map(|(cell, shape)| (*shape, rows(cell))).collect())
    }

    /// Points and cells, as flat arrays.
    ///
    /// # Errors
    /// As [`Snapshot::cells`].
    pub fn grid(&self) -> Result<FieldGrid> {
        let points = self.points()?;
        let [connectivity, starts, types] =
            ["Connectivity", "Offsets", "Types"].map(|name| self.counts(name));
        let (connectivity, starts, types) = (connectivity?, starts?, types?);
        let fits = |row: &usize| *row < points.len() && u32::try_from(*row).is_ok();
        if !connectivity.iter().all(fits) || starts.len() != types.len() + 1 {
            return Err(self.wrong("its cells do not fit its points"));
        }
        let shape = |(ends, kind): (&[usize], &usize)| {
            let found = Shape::ALL.into_iter().find(|s| usize::from(cell_type(*s)) == *kind);
            found.filter(|shape| {
                connectivity.get(ends[0]..ends[1]).map(<[_]>::len) == Some(shape.nodes())
            })
        };
        let shapes = starts.windows(2).zip(&types).map(shape).collect::<Option<Vec<_>>>();
        let shapes = shapes.ok_or_else(|| self.wrong("it holds cells that are none"))?;
        let nodes = connectivity.iter().map(|row| *row as u32).collect();
        Ok(FieldGrid { points, shapes, starts, nodes })
    }

    /// The names of the arrays at points.
    ///
    /// # Errors
    /// [`Error::System`] when they cannot be read.
    pub fn names_at_points(&self) -> Result<Vec<String>> {
        self.names(POINT_DATA)
    }

    /// The names of the arrays at cells.
    ///
    /// # Errors
    /// [`Error::System`] when they cannot be read.
    pub fn names_at_cells(&self) -> Result<Vec<String>> {
        self.names(CELL_DATA)
    }

    /// An array at points: `displacement` (m) in the bulk; `jump` (m), `traction` (Pa), `damage`,
    /// `state` on an interface; `pressure` (Pa) where there is one.
    ///
    /// # Errors
    /// [`Error::Input`] when there is no such array; [`Error::System`] when it cannot be read.
    pub fn at_points(&self, name: &str) -> Result<Array> {
        self.array(POINT_DATA, name)
    }

    /// An array at cells: `stress` (Pa), `material`, `rank` in the bulk, and what flow adds.
    ///
    /// # Errors
    /// As [`Snapshot::at_points`].
    pub fn at_cells(&self, name: &str) -> Result<Array> {
        self.array(CELL_DATA, name)
    }

    /// Values of a row of an array at points or cells, without reading it.
    ///
    /// # Errors
    /// [`Error::System`] when there is no such array.
    pub(crate) fn components(&self, name: &str, at_cells: bool) -> Result<usize> {
        let place = if at_cells { CELL_DATA } else { POINT_DATA };
        let shape = self.dataset(&format!("{place}/{name}"))?.shape();
        Ok(shape.get(1).copied().unwrap_or(1))
    }

    fn array(&self, place: &str, name: &str) -> Result<Array> {
        let known = self.names(place)?;
        if !known.iter().any(|other| other == name) {
            let (path, known) = (self.path.display(), known.join(", "));
            return Err(Error::Input(format!("{path} has no {place} `{name}` (it has: {known})")));
        }
        let array = self.read(&format!("{place}/{name}"))?;
        let of = if place == CELL_DATA { "Types" } else { "Points" };
        let rows = self.dataset(of)?.shape().first().copied().unwrap_or_default();
        if array.rows().len() != rows {
            return Err(self.wrong(format!("{name} has no row for each of {rows} {of}")));
        }
        Ok(array)
    }

    fn names(&self, place: &str) -> Result<Vec<String>> {
        let group = self.group.group(place).map_err(|cause| self.wrong(cause))?;
        group.member_names().map_err(|cause| self.wrong(cause))
    }

    fn dataset(&self, name: &str) -> Result<Dataset> {
        self.group.dataset(name).map_err(|cause| self.wrong(cause))
    }

    fn read(&self, name: &str) -> Result<Array> {
        let dataset = self.dataset(name)?;
        let components = match dataset.shape()[..] {
            [_] => 1,
            [_, components] if components > 0 => components,
            _ => return Err(self.wrong(format!("{name} is no table"))),
        };
        let values = dataset.read_raw().map_err(|cause| self.wrong(cause))?;
        Ok(Array { components, values })
    }

    fn counts(&self, name: &str) -> Result<Vec<usize>> {
        let counts = self.dataset(name)?.read_raw::<i64>().map_err(|cause| self.wrong(cause))?;
        let counts = counts.into_iter().map(usize::try_from).collect::<std::result::Result<_, _>>();
        counts.map_err(|cause| self.wrong(cause))
    }

    fn wrong(&self, cause: impl std::fmt::Display) -> Error {
        Error::file("cannot read", &self.path, cause)
    }
}
