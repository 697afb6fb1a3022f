//! The tree of an HDF5 file, read with distrust: everything lies in the file itself, and no list is
//! longer than what the file can hold.

use std::collections::BTreeSet;
use std::ops::Range;
use std::path::Path;

use ::hdf5::dataset::Layout;
use ::hdf5::filters::Filter;
use ::hdf5::types::{FixedAscii, TypeDescriptor};
use ::hdf5::{Dataset, File, Group, LinkType, LocationType};

use crate::error::{Error, Result};

/// What is wrong, in words that begin with the path inside the file.
pub type Told<T> = std::result::Result<T, String>;

/// No format of compression that is read makes more of a byte: deflate reaches 1032.
const MOST_PER_BYTE: u64 = 1100;

/// A group of the file.
pub struct Folder {
    group: Group,
    /// Where it is in the file, with slashes; empty for the top.
    path: String,
    /// Bytes of the whole file.
    bytes: u64,
}

/// Opens a file and hands out its top group.
///
/// # Errors
/// `Input` when it cannot be read, is no whole HDF5 file, or leads to another file; `System` when
/// it is locked.
pub fn open(path: &Path) -> Result<Folder> {
    let unread = |cause: &dyn std::fmt::Display| {
        Error::Input(format!("cannot read the mesh file {}: {cause}", path.display()))
    };
    let metadata = std::fs::File::open(path).and_then(|file| file.metadata());
    let metadata = metadata.map_err(|cause| unread(&cause))?;
    if !metadata.is_file() {
        return Err(unread(&"it is not a file"));
    }
    let file = File::open(path).map_err(|cause| {
        let cause = cause.to_string();
        if cause.contains("lock file") {
            return Error::System(format!(
                "cannot read the mesh file {}: HDF5 cannot lock it ({cause}): another process \
                 writes it, or its file system has no locks; in that case set \
                 HDF5_USE_FILE_LOCKING=FALSE in the environment of all ranks",
                path.display()
            ));
        }
        unread(&format!("it is not a whole HDF5 file ({cause})"))
    })?;
    let group = file.group("/").map_err(|cause| unread(&format!("/: {cause}")))?;
    let top = Folder { group, path: String::new(), bytes: metadata.len() };
    stays_inside(&top).map_err(|cause| unread(&cause))?;
    Ok(top)
}

/// Refuses a file any group of which has a link into another file. Soft links then lead to what
/// lies in the file.
fn stays_inside(top: &Folder) -> Told<()> {
    let mut seen = BTreeSet::new();
    let mut left = vec![(top.group.clone(), String::new())];
    while let Some((group, path)) = left.pop() {
        for (name, link) in links(&group, &path)? {
            let inner = format!("{path}/{name}");
            match link {
                LinkType::Soft => continue,
                LinkType::Hard => {}
                LinkType::External => {
                    return Err(format!(
                        "{inner}: a link out of the file, which is not followed; put what it \
                         leads to into the file (h5repack --merge)"
                    ));
                }
            }
            let cause = |cause: ::hdf5::Error| format!("{inner}: {cause}");
            let info = group.loc_info_by_name(&name).map_err(cause)?;
            // A group may be linked into itself.
            if info.loc_type == LocationType::Group && seen.insert(format!("{:?}", info.token)) {
                left.push((group.group(&name).map_err(cause)?, inner.clone()));
            }
        }
    }
    Ok(())
}

/// The names of what a group holds, and the kinds of links to it.
fn links(group: &Group, path: &str) -> Told<Vec<(String, LinkType)>> {
    let mut found = Vec::new();
    let visited = group.iter_visit_default(|name, link| {
        found.push((name.to_owned(), link.link_type));
        Ok(())
    });
    visited.map_err(|cause| format!("{path}/: {cause}"))?;
    if let Some((name, _)) = found.iter().find(|(name, _)| name.contains('\u{fffd}')) {
        return Err(format!("{path}/{name}: its name is not in UTF-8; rename it"));
    }
    found.sort_by(|a, b| a.0.cmp(&b.0));
    Ok(found)
}

impl Folder {
    /// Where something in this group is.
    pub fn inner(&self, name: &str) -> String {
        format!("{}/{name}", self.path)
    }

    /// Where it is itself.
    pub fn path(&self) -> &str {
        if self.path.is_empty() { "/" } else { &self.path }
    }

    /// The sorted names of what it holds.
    pub fn members(&self) -> Told<Vec<String>> {
        Ok(links(&self.group, &self.path)?.into_iter().map(|(name, _)| name).collect())
    }

    /// Whether it holds something of that name.
    pub fn has(&self, name: &str) -> bool {
        self.group.link_exists(name)
    }

    /// A group in it, which has to be there.
    pub fn folder(&self, name: &str) -> Told<Folder> {
        let path = self.inner(name);
        if !self.has(name) {
            return Err(format!("{path}: missing"));
        }
        let group = self.group.group(name).map_err(|cause| format!("{path}: {cause}"))?;
        Ok(Folder { group, path, bytes: self.bytes })
    }

    /// A group in it, or none.
    pub fn find_folder(&self, name: &str) -> Told<Option<Folder>> {
        if self.has(name) { self.folder(name).map(Some) } else { Ok(None) }
    }

    /// A whole number among its attributes, or none.
    pub fn find_attribute(&self, name: &str) -> Told<Option<i64>> {
        attribute(&self.group, &self.path, name)
    }

    /// A whole number among its attributes, which has to be there.
    pub fn attribute(&self, name: &str) -> Told<i64> {
        let missing = || format!("{}: its attribute {name} is missing", self.path());
        self.find_attribute(name)?.ok_or_else(missing)
    }

    /// A short text among its attributes without the blanks at its end, or none.
    pub fn text(&self, name: &str) -> Told<Option<String>> {
        let path = self.path();
        let wrong = |cause: ::hdf5::Error| format!("{path}: its attribute {name}: {cause}");
        let Some(attribute) = find(&self.group, name).map_err(wrong)? else { return Ok(None) };
        let text = attribute.read_scalar::<FixedAscii<256>>().map_err(wrong)?;
        Ok(Some(String::from_utf8_lossy(text.as_bytes()).trim_end().to_owned()))
    }

    /// A list of whole numbers, or none where there is no dataset of that name.
    pub fn find_integers(&self, name: &str) -> Told<Option<Vec<i64>>> {
        if self.has(name) { self.integers(name).map(Some) } else { Ok(None) }
    }

    /// A list of whole numbers.
    pub fn integers(&self, name: &str) -> Told<Vec<i64>> {
        let (dataset, kind) = self.list(name, size_of::<i64>())?;
        if !matches!(kind, TypeDescriptor::Integer(_)) {
            return Err(self.wrong_type(name, &kind, "whole numbers"));
        }
        dataset.read_raw().map_err(|cause| self.unread(name, &cause))
    }

    /// Some of a list of whole numbers.
    pub fn integers_in(&self, name: &str, rows: Range<usize>) -> Told<Vec<i64>> {
        let (dataset, kind) = self.list(name, size_of::<i64>())?;
        if !matches!(kind, TypeDescriptor::Integer(_)) {
            return Err(self.wrong_type(name, &kind, "whole numbers"));
        }
        let read = dataset.read_slice_1d::<i64, _>(rows);
        read.map(|list| list.to_vec()).map_err(|cause| self.unread(name, &cause))
    }

    /// Some of a list of numbers, all of them finite or not.
    pub fn reals_in(&self, name: &str, rows: Range<usize>) -> Told<Vec<f64>> {
        let (dataset, kind) = self.list(name, size_of::<f64>())?;
        if !matches!(kind, TypeDescriptor::Float(_)) {
            return Err(self.wrong_type(name, &kind, "floating-point numbers"));
        }
        let read = dataset.read_slice_1d::<f64, _>(rows);
        read.map(|list| list.to_vec()).map_err(|cause| self.unread(name, &cause))
    }

    /// The length of a list of numbers of eight bytes at most.
    pub fn length(&self, name: &str) -> Told<usize> {
        Ok(self.list(name, size_of::<f64>())?.0.size())
    }

    /// A list of numbers, all of them finite or not.
    pub fn reals(&self, name: &str) -> Told<Vec<f64>> {
        let (dataset, kind) = self.list(name, size_of::<f64>())?;
        if !matches!(kind, TypeDescriptor::Float(_)) {
            return Err(self.wrong_type(name, &kind, "floating-point numbers"));
        }
        dataset.read_raw().map_err(|cause| self.unread(name, &cause))
    }

    /// A list of names of 80 bytes.
    pub fn names(&self, name: &str) -> Told<Vec<[u8; 80]>> {
        let (dataset, kind) = self.list(name, 80)?;
        let unread = |cause: ::hdf5::Error| self.unread(name, &cause);
        let wrong = || self.wrong_type(name, &kind, "names of 80 bytes");
        let TypeDescriptor::FixedArray(byte, 80) = &kind else { return Err(wrong()) };
        match **byte {
            // A conversion between the two would cut off what is beyond ASCII.
            TypeDescriptor::Integer(::hdf5::types::IntSize::U1) => {
                let names = dataset.read_raw::<[i8; 80]>().map_err(unread)?;
                Ok(names.into_iter().map(|name| name.map(|byte| byte as u8)).collect())
            }
            TypeDescriptor::Unsigned(::hdf5::types::IntSize::U1) => {
                dataset.read_raw::<[u8; 80]>().map_err(unread)
            }
            _ => Err(wrong()),
        }
    }

    /// The attribute NBR of a dataset: how many rows its list has.
    pub fn rows(&self, name: &str) -> Told<usize> {
        let path = self.inner(name);
        let dataset = self.dataset(name)?;
        let rows = attribute(&dataset, &path, "NBR")?;
        let rows = rows.ok_or_else(|| format!("{path}: its attribute NBR is missing"))?;
        usize::try_from(rows).map_err(|_| format!("{path}: its attribute NBR is {rows}"))
    }

    fn dataset(&self, name: &str) -> Told<Dataset> {
        if !self.has(name) {
            return Err(format!("{}: missing", self.inner(name)));
        }
        self.group.dataset(name).map_err(|cause| self.unread(name, &cause))
    }

    /// A dataset of one dimension that can be read: all of it in the file, and of a size that the
    /// file can hold. `bytes` is what each entry takes in memory.
    fn list(&self, name: &str, bytes: usize) -> Told<(Dataset, TypeDescriptor)> {
        let path = self.inner(name);
        let dataset = self.dataset(name)?;
        let cause = |cause: ::hdf5::Error| format!("{path}: {cause}");
        let kind = dataset.dtype().and_then(|kind| kind.to_descriptor()).map_err(cause)?;
        let &[length] = dataset.get_shape().map_err(cause)?.as_slice() else {
            let shape = dataset.shape();
            return Err(format!("{path}: it has the shape {shape:?} where a list is needed"));
        };
        let stored = self.stored(&dataset, &path)?;
        let needed = (length as u64).saturating_mul(bytes as u64);
        // A list of smaller numbers in the file grows in memory, by eight at most.
        let least = (length as u64).saturating_mul(kind.size().max(1) as u64);
        if least > stored || needed > stored.saturating_mul(8) {
            return Err(format!(
                "{path}: {length} entries are more than what is stored of them; the file is \
                 damaged, or was not written to its end"
            ));
        }
        Ok((dataset, kind))
    }

    /// Most bytes that a dataset can hold, after what the file holds of it.
    fn stored(&self, dataset: &Dataset, path: &str) -> Told<u64> {
        let cause = |cause: ::hdf5::Error| format!("{path}: {cause}");
        let list = dataset.create_plist().map_err(cause)?;
        if !list.get_external().map_err(cause)?.is_empty() {
            return Err(format!("{path}: its numbers lie in another file, which is not read"));
        }
        let stored = dataset.storage_size().min(self.bytes);
        match list.get_layout().map_err(cause)? {
            Layout::Compact | Layout::Contiguous => return Ok(stored),
            Layout::Chunked => {}
            Layout::Virtual => {
                return Err(format!("{path}: its numbers lie in other files, which are not read"));
            }
        }
        let filters = list.get_filters().map_err(cause)?;
        for filter in &filters {
            let known = matches!(filter, Filter::Deflate(_) | Filter::Shuffle | Filter::Fletcher32);
            if !known || !filter.is_available() {
                return Err(format!(
                    "{path}: it is stored with a filter that is not read ({filter:?}); write it \
                     anew without (h5repack -f NONE)"
                ));
            }
        }
        let most =
            match filters.iter().filter(|filter| matches!(filter, Filter::Deflate(_))).count() {
                0 => stored,
                1 => stored.saturating_mul(MOST_PER_BYTE),
                times => return Err(format!("{path}: it is compressed {times} times")),
            };
        // The library takes the memory of a whole chunk.
        let chunk = list.get_chunk().map_err(cause)?.unwrap_or_default();
        let entries = chunk.iter().fold(1_u64, |all, edge| all.saturating_mul(*edge as u64));
        if entries > most {
            return Err(format!(
                "{path}: chunks of {entries} entries are more than what is stored"
            ));
        }
        Ok(most)
    }

    fn unread(&self, name: &str, cause: &::hdf5::Error) -> String {
        format!("{}: {cause}", self.inner(name))
    }

    fn wrong_type(&self, name: &str, found: &TypeDescriptor, wanted: &str) -> String {
        format!("{}: it holds {found:?} where {wanted} are needed", self.inner(name))
    }
}

/// A whole number among the attributes of something, or none.
fn attribute(of: &::hdf5::Location, path: &str, name: &str) -> Told<Option<i64>> {
    let wrong = |cause: ::hdf5::Error| format!("{path}: its attribute {name}: {cause}");
    let Some(attribute) = find(of, name).map_err(wrong)? else { return Ok(None) };
    let kind = attribute.dtype().and_then(|kind| kind.to_descriptor()).map_err(wrong)?;
    if !matches!(kind, TypeDescriptor::Integer(_)) {
        return Err(format!("{path}: its attribute {name} is {kind:?}, not a whole number"));
    }
    attribute.read_scalar().map(Some).map_err(wrong)
}

/// An attribute, or none. To list all of them first would end the process where one is damaged.
fn find(of: &::hdf5::Location, name: &str) -> ::hdf5::Result<Option<::hdf5::Attribute>> {
    match of.attr(name) {
        Ok(attribute) => Ok(Some(attribute)),
        Err(cause) if cause.to_string().contains("can't locate attribute") => Ok(None),
        Err(cause) => Err(cause),
    }
}
