//! Checkpoints: the state of a run in one file that any number of ranks can go on from.
//!
//! Everything lies in the order of the names of nodes, whoever held them. A file has checksums of
//! its parts, so that a damaged one is not taken for a state. Of the files in a directory the
//! newest two are kept.

use std::path::{Path, PathBuf};

use ::hdf5::{Dataset, File, H5Type, LinkType};

use super::atomic_hdf5::AtomicFile;
use super::publisher::Publisher;
use super::vtkhdf::rows_of;
use crate::comm::{Comm, Rows, first_of};
use crate::error::{Error, Result};
use crate::fault;
use crate::hash::mix;

/// Name of the newest checkpoint of a directory.
pub const NEWEST: &str = "checkpoint.h5";
/// Name of the one before.
pub const PREVIOUS: &str = "checkpoint.previous.h5";

/// The group that holds everything.
const GROUP: &str = "checkpoint";
/// What is in it.
const MEMBERS: [&str; 5] = ["checksums", "interface", "interface_names", "meta", "nodal"];

/// A state as it is written: what is not a field as text, fields as rows.
pub struct Checkpoint<'a> {
    /// Everything but the fields.
    pub meta: &'a str,
    /// A row for every node; this rank's own.
    pub nodal: &'a Rows,
    /// A row for every secondary node of an interface; this rank's own.
    pub interface: &'a Rows,
}

/// Writes a checkpoint, which becomes the newest one of the directory when `publisher` has come to
/// it; the one before is kept. `nodes` bounds all names.
///
/// # Errors
/// `System` with the path and the reason; the same on all ranks.
///
/// # Parallel
/// Collective.
pub fn write(
    comm: &Comm,
    publisher: &mut Publisher,
    directory: &Path,
    nodes: u64,
    state: &Checkpoint<'_>,
) -> Result<()> {
    let [path, previous] = [NEWEST, PREVIOUS].map(|name| directory.join(name));
    // The temporary file of an earlier one bears the same name until it is published.
    comm.agree(publisher.finish())?;
    let nodal = comm.to_slabs(nodes, state.nodal);
    let interface = comm.to_slabs(nodes, state.interface);
    let checksums = [
        text_checksum(state.meta),
        comm.sum_u64(rows_checksum(&nodal)),
        comm.sum_u64(rows_checksum(&interface)),
    ];
    let root = comm.is_root();
    let meta: &[u8] = if root { state.meta.as_bytes() } else { &[] };
    let own_checksums: &[u64] = if root { &checksums } else { &[] };
    let numbers = |rows: &Rows| 8 * comm.sum_u64((rows.names.len() + rows.values.len()) as u64);
    let size = state.meta.len() as u64 + numbers(&nodal) + numbers(&interface) + 65536;
    let writing = AtomicFile { comm, path: &path };
    let publish = |temporary: &Path| publisher.replace(temporary, &path, &previous);
    writing.write(GROUP, size, publish, |file, group| {
        fault::strike(comm, "checkpoint")?;
        let of = |rows: usize| rows_of(comm, rows);
        writing.rows(file, group, "checksums", of(own_checksums.len()), 1, own_checksums)?;
        writing.rows(file, group, "meta", of(meta.len()), 1, meta)?;
        let rows = of(nodal.names.len());
        writing.rows(file, group, "nodal", rows, nodal.width, &nodal.values)?;
        let rows = of(interface.names.len());
        writing.rows(file, group, "interface_names", rows, 1, &interface.names)?;
        writing.rows(file, group, "interface", rows, interface.width, &interface.values)
    })
}

/// An open checkpoint whose parts are still to be read.
pub struct Opened {
    path: PathBuf,
    file: File,
    /// Everything but the fields.
    pub meta: String,
    checksums: [u64; 3],
}

impl Opened {
    /// Opens a file and reads its description, of at most `longest` bytes.
    ///
    /// # Errors
    /// `Input` when there is no such file, or it is no checkpoint, or it is damaged; the same on
    /// all ranks.
    ///
    /// # Parallel
    /// Collective.
    pub fn new(comm: &Comm, path: &Path, longest: usize) -> Result<Self> {
        comm.agree(Self::open(path, longest))
    }

    fn open(path: &Path, longest: usize) -> Result<Self> {
        let wrong = |cause: &dyn std::fmt::Display| not_a_checkpoint(path, cause);
        if let Err(cause) = std::fs::File::open(path) {
            let text = format!("cannot read the checkpoint {}: {cause}", path.display());
            return Err(Error::Input(text));
        }
        let file = File::open(path).map_err(|cause| unopened(path, &cause.to_string()))?;
        members(&file).map_err(|cause| wrong(&cause))?;
        let checksums = numbers::<u64>(&file, "checksums", &[3]).map_err(|cause| wrong(&cause))?;
        let meta = dataset(&file, "meta").map_err(|cause| wrong(&cause))?;
        let shape = meta.shape();
        let length = shape.first().copied().unwrap_or(0);
        if length > longest {
            let much =
                format!("its description has {length} bytes; this case has at most {longest}");
            return Err(wrong(&much));
        }
        let bytes = numbers::<u8>(&file, "meta", &[length]).map_err(|cause| wrong(&cause))?;
        let meta = String::from_utf8(bytes).map_err(|cause| wrong(&cause))?;
        let checksums = [checksums[0], checksums[1], checksums[2]];
        if text_checksum(&meta) != checksums[0] {
            return Err(wrong(&"its description is damaged"));
        }
        Ok(Self { path: path.to_path_buf(), file, meta, checksums })
    }

    /// Reads the fields: `nodes` nodal rows and `secondary` rows of interface nodes, of the given
    /// widths, in slabs.
    ///
    /// # Errors
    /// `Input` when they have other sizes or are damaged; the same on all ranks.
    ///
    /// # Parallel
    /// Collective.
    pub fn fields(
        &self,
        comm: &Comm,
        nodes: u64,
        secondary: u64,
        widths: [usize; 2],
    ) -> Result<[Rows; 2]> {
        let wrong = |cause: String| not_a_checkpoint(&self.path, &cause);
        let slab = |total: u64| {
            let bound = |rank: u64| first_of(rank, total, comm.size() as u64) as usize;
            bound(comm.rank() as u64)..bound(comm.rank() as u64 + 1)
        };
        let read = || -> std::result::Result<[Rows; 2], String> {
            let own = slab(nodes);
            let values = block(&self.file, "nodal", [nodes, widths[0] as u64], own.clone())?;
            let names = own.map(|name| name as u64).collect();
            let nodal = Rows { width: widths[0], names, values };
            let own = slab(secondary);
            let list = dataset(&self.file, "interface_names")?;
            expect::<u64>(&list, "interface_names", &[secondary as usize])?;
            readable(own.len() * size_of::<u64>())?;
            let names = list.read_slice_1d::<u64, _>(own.clone()).map_err(|e| e.to_string())?;
            let names: Vec<u64> = names.iter().copied().collect();
            if !names.is_sorted() || names.iter().any(|name| *name >= nodes) {
                return Err("its interface nodes are not of this mesh".into());
            }
            let values = block(&self.file, "interface", [secondary, widths[1] as u64], own)?;
            Ok([nodal, Rows { width: widths[1], names, values }])
        };
        let [nodal, interface] = comm.agree(read().map_err(wrong))?;
        let found = [rows_checksum(&nodal), rows_checksum(&interface)].map(|sum| comm.sum_u64(sum));
        if found != self.checksums[1..] {
            return Err(wrong("its fields are damaged".into()));
        }
        let finite = nodal.values.iter().chain(&interface.values).all(|v| v.is_finite());
        if comm.any(!finite) {
            return Err(wrong("it holds something that is not a number".into()));
        }
        Ok([nodal, comm.to_slabs(nodes, &interface)])
    }
}

/// Why HDF5 does not open a file that can be read.
fn unopened(path: &Path, cause: &str) -> Error {
    if !cause.contains("lock file") {
        return not_a_checkpoint(path, &format!("it is not a whole HDF5 file ({cause})"));
    }
    // Nothing is wrong with the file, so that the one before it is none the better.
    Error::System(format!(
        "cannot go on from {}: HDF5 cannot lock it ({cause}): another process holds it, or its file \
         system has no locks; in that case set HDF5_USE_FILE_LOCKING=FALSE in the environment of all \
         ranks",
        path.display()
    ))
}

fn not_a_checkpoint(path: &Path, cause: &dyn std::fmt::Display) -> Error {
    Error::Input(format!("cannot go on from {}: {cause}", path.display()))
}

/// Only the members that a checkpoint has, all of them in the file itself: a link could lead to any
/// other file.
fn members(file: &File) -> std::result::Result<(), String> {
    let check = |group: &::hdf5::Group, wanted: &[&str]| {
        let mut found = Vec::new();
        let visited = group.iter_visit_default(|name, link| {
            found.push((name.to_owned(), link.link_type));
            Ok(())
        });
        visited.map_err(|cause| cause.to_string())?;
        if let Some((name, _)) = found.iter().find(|(_, link)| *link != LinkType::Hard) {
            return Err(format!("its member {name} is a link"));
        }
        let names: Vec<&str> = found.iter().map(|(name, _)| name.as_str()).collect();
        if names == wanted { Ok(()) } else { Err(format!("it holds {}", names.join(", "))) }
    };
    check(file, &[GROUP])?;
    let group = file.group(GROUP).map_err(|cause| cause.to_string())?;
    check(&group, &MEMBERS)
}

/// A member whose numbers lie in the file itself.
fn dataset(file: &File, name: &str) -> std::result::Result<Dataset, String> {
    let dataset = file.dataset(&format!("{GROUP}/{name}")).map_err(|cause| cause.to_string())?;
    let list = dataset.create_plist().map_err(|cause| cause.to_string())?;
    // Without rows there is nothing that could lie elsewhere.
    if dataset.size() == 0 {
        return Ok(dataset);
    }
    if !list.external().is_empty() || !matches!(list.layout(), ::hdf5::dataset::Layout::Contiguous)
    {
        return Err(format!("{name} does not lie in the file itself"));
    }
    Ok(dataset)
}

/// Checks the type and the shape of a member before it is read.
fn expect<T: H5Type>(
    dataset: &Dataset,
    name: &str,
    shape: &[usize],
) -> std::result::Result<(), String> {
    let kind =
        dataset.dtype().and_then(|t| t.to_descriptor()).map_err(|cause| cause.to_string())?;
    let wanted = T::type_descriptor();
    let found = dataset.shape();
    if kind == wanted && found == shape {
        return Ok(());
    }
    Err(format!("{name} is {kind:?} of shape {found:?} where {wanted:?} of {shape:?} is needed"))
}

fn numbers<T: H5Type>(
    file: &File,
    name: &str,
    shape: &[usize],
) -> std::result::Result<Vec<T>, String> {
    let dataset = dataset(file, name)?;
    expect::<T>(&dataset, name, shape)?;
    readable(shape.iter().product::<usize>() * size_of::<T>())?;
    dataset.read_raw::<T>().map_err(|cause| cause.to_string())
}

/// Refuses what one rank cannot read at once by itself: MPI-IO and some kernels count the bytes of
/// an access in 32 bits. What all ranks write together has no such bound.
fn readable(bytes: usize) -> std::result::Result<(), String> {
    if i32::try_from(bytes).is_ok() {
        return Ok(());
    }
    Err(format!(
        "one rank would read {bytes} bytes of it, at most {} go: take more ranks",
        i32::MAX
    ))
}

/// Rows of a table of numbers.
fn block(
    file: &File,
    name: &str,
    [rows, width]: [u64; 2],
    own: std::ops::Range<usize>,
) -> std::result::Result<Vec<f64>, String> {
    let dataset = dataset(file, name)?;
    expect::<f64>(&dataset, name, &[rows as usize, width as usize])?;
    readable(own.len() * width as usize * size_of::<f64>())?;
    let values = dataset.read_slice_2d::<f64, _>((own, ..)).map_err(|cause| cause.to_string())?;
    Ok(values.iter().copied().collect())
}

/// The same for the same rows in any order, on any number of ranks when the ranks' are added.
fn rows_checksum(rows: &Rows) -> u64 {
    let row = |(name, values): (&u64, &[f64])| {
        values.iter().fold(mix(*name), |sum, value| mix(sum ^ value.to_bits()))
    };
    let all = rows.names.iter().zip(rows.values.chunks_exact(rows.width.max(1)));
    all.map(row).fold(0, u64::wrapping_add)
}

fn text_checksum(text: &str) -> u64 {
    let words = text.as_bytes().chunks(8).map(|part| {
        part.iter().fold(part.len() as u64, |word, byte| word << 7 ^ word >> 57 ^ u64::from(*byte))
    });
    words.fold(1, |sum, word| mix(sum ^ word))
}

/// The files of a directory to go on from, the newest first.
///
/// # Errors
/// `Input` when there is none.
pub fn candidates(directory: &Path) -> Result<Vec<PathBuf>> {
    let files = [NEWEST, PREVIOUS].map(|name| directory.join(name));
    let found: Vec<PathBuf> = files.into_iter().filter(|file| file.is_file()).collect();
    if found.is_empty() {
        return Err(Error::Input(format!(
            "there is no checkpoint in {} to go on from; start without --restart",
            directory.display()
        )));
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::readable;

    #[test]
    fn one_rank_reads_less_than_two_gibibytes_at_once() {
        assert_eq!(readable((1 << 31) - 1), Ok(()));
        let told = readable(1 << 31).unwrap_err();
        assert!(told.contains("2147483648 bytes") && told.contains("more ranks"), "{told}");
    }
}
