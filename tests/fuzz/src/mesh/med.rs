//! The file of a mesh of SALOME, as someone would make it who knows HDF5.
//!
//! An input is a recipe, one change of a real file on a line. Words are taken modulo what there is,
//! so that most changes do something. Changes of what is stored are made through the library; then
//! those of single bytes. What is no change is passed over.

use std::cell::Cell;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use column_hpc::error::Error;
use column_hpc::mesh::import::med as format;
use hdf5::types::{FixedAscii, IntSize, TypeDescriptor, VarLenUnicode};
use hdf5::{Dataset, File, H5Type, Location};

use super::{Meter, accepted, measured, sound, walk};

/// The real files: all types of elements, both versions, groups of all dimensions and of nodes.
const FILES: [&[u8]; 11] = [
    include_bytes!("../../../meshes/med_cut.med"),
    include_bytes!("../../../meshes/med_plane.med"),
    include_bytes!("../../../meshes/med_hex8.med"),
    include_bytes!("../../../meshes/med_mixed.med"),
    include_bytes!("../../../meshes/med_mixed2.med"),
    include_bytes!("../../../meshes/med_tet4_version3.med"),
    include_bytes!("../../../meshes/med_plane2.med"),
    include_bytes!("../../../meshes/med_prism18.med"),
    include_bytes!("../../../meshes/med_hex20.med"),
    include_bytes!("../../../meshes/med_hex27.med"),
    include_bytes!("../../../meshes/med_tet10.med"),
];
/// Entries of a list that a recipe may make in the file.
const MOST_ENTRIES: usize = 2000;

/// A place for changed files.
pub struct Bench {
    directory: PathBuf,
    /// Names are new: the library remembers damaged files that it could not close.
    number: Cell<u64>,
    files: Vec<Names>,
}

/// What a file holds.
struct Names {
    datasets: Vec<String>,
    /// Groups and datasets.
    all: Vec<String>,
}

impl Bench {
    /// Looks at the real files.
    pub fn new() -> Self {
        static BENCHES: AtomicU64 = AtomicU64::new(0);
        let number = BENCHES.fetch_add(1, Ordering::Relaxed);
        let name = format!("column-hpc-mesh-{}-{number}", std::process::id());
        let directory = std::env::temp_dir().join(name);
        fs::create_dir_all(&directory).expect("a temporary directory");
        let mut bench = Self { directory, number: Cell::new(0), files: Vec::new() };
        for bytes in FILES {
            let path = bench.next();
            fs::write(&path, bytes).expect("a file of ours");
            let mut names = Names { datasets: Vec::new(), all: Vec::new() };
            let file = File::open(&path).expect("a real file");
            names.collect(&file, "").expect("a real file");
            drop(file);
            fs::remove_file(&path).expect("a file of ours");
            bench.files.push(names);
        }
        bench
    }

    fn next(&self) -> PathBuf {
        self.number.set(self.number.get() + 1);
        self.directory.join(format!("{}.med", self.number.get()))
    }

    /// Reads what a recipe makes of a real file; whether there was a mesh in it. A refusal says
    /// where in the file.
    pub fn read(&self, recipe: &[u8], meter: &impl Meter) -> bool {
        let Ok(recipe) = std::str::from_utf8(recipe) else { return false };
        let lines: Vec<Vec<&str>> =
            recipe.lines().map(|line| line.split_whitespace().collect()).collect();
        let chosen = |line: &Vec<&str>| match line[..] {
            ["file", which] => which.parse::<usize>().ok(),
            _ => None,
        };
        let which = lines.iter().find_map(chosen).unwrap_or(0) % FILES.len();
        let path = self.next();
        make(&path, FILES[which], &self.files[which], &lines);
        let bytes = fs::metadata(&path).map_or(0, |file| file.len() as usize);
        let read = measured(bytes, meter, || format::read(&path));
        fs::remove_file(&path).expect("a file of ours");
        if let Err(Error::Input(words)) = &read {
            let name = path.to_string_lossy();
            let words = words.replace(&*name, "FILE");
            assert!(words.contains("FILE: /") || words.contains("FILE: it is "), "{words}");
            assert!(words.len() < 4000, "{} bytes of words", words.len());
        }
        let Some(mesh) = accepted(read) else { return false };
        sound(&mesh);
        // Most recipes leave most of a mesh as it is: it is cut, but not refined again and again.
        walk::walk(&mesh, 0);
        true
    }

    /// Afterwards nothing is left of the files.
    pub fn close(self) {
        let _ = fs::remove_dir_all(&self.directory);
    }
}

impl Names {
    fn collect(&mut self, group: &hdf5::Group, path: &str) -> hdf5::Result<()> {
        let mut names = group.member_names()?;
        names.sort();
        for name in names {
            let inner = format!("{path}/{name}");
            self.all.push(inner.clone());
            match group.group(&name) {
                Ok(group) => self.collect(&group, &inner)?,
                Err(_) => self.datasets.push(inner),
            }
        }
        Ok(())
    }
}

/// Writes the changed file.
fn make(path: &Path, original: &[u8], names: &Names, lines: &[Vec<&str>]) {
    fs::write(path, original).expect("a file of ours");
    let in_bytes = |line: &Vec<&str>| matches!(line[..], ["byte" | "word" | "truncate", ..]);
    if lines.iter().any(|line| !in_bytes(line) && line.len() > 1 && line[0] != "file") {
        let file = File::open_rw(path).expect("a file of ours");
        for line in lines {
            // What HDF5 does not make is no input either.
            let _ = change(&file, names, line);
        }
    }
    if lines.iter().any(in_bytes) {
        let mut bytes = fs::read(path).expect("a file of ours");
        for line in lines {
            change_bytes(&mut bytes, line);
        }
        fs::write(path, bytes).expect("a file of ours");
    }
}

/// One of a list, by a number modulo its length.
fn pick<'a, T>(list: &'a [T], number: &str) -> hdf5::Result<&'a T> {
    let number: usize = number.parse().map_err(|_| "no number")?;
    Ok(&list[number % list.len()])
}

fn parsed<T: std::str::FromStr>(word: &str) -> hdf5::Result<T> {
    word.parse().map_err(|_| "no number".into())
}

/// Changes of links, types, shapes and what is stored.
fn change(file: &File, names: &Names, line: &[&str]) -> hdf5::Result<()> {
    match *line {
        ["set", list, entry, value] => {
            let dataset = file.dataset(pick(&names.datasets, list)?)?;
            set(&dataset, parsed(entry)?, value)
        }
        ["as", list, kind, layout, length] => {
            let path = pick(&names.datasets, list)?;
            anew(file, path, kind, layout, parsed(length)?)
        }
        ["attribute", of, which, kind, value] => {
            let path = pick(&names.all, of)?;
            match file.group(path) {
                Ok(group) => attribute(&group, which, kind, value),
                Err(_) => {
                    let dataset = file.dataset(path)?;
                    attribute(&dataset, which, kind, value)
                }
            }
        }
        ["drop", one] => file.unlink(pick(&names.all, one)?),
        ["rename", one, name] => {
            let path = pick(&names.all, one)?;
            let folder = path.rsplit_once('/').map_or("", |(folder, _)| folder);
            file.relink(path, &format!("{folder}/{name}"))
        }
        ["link", kind, one, other] => {
            let (one, other) = (pick(&names.all, one)?, pick(&names.all, other)?);
            file.unlink(one)?;
            match kind {
                "hard" => file.link_hard(other, one),
                "soft" => file.link_soft(other, one),
                _ => file.link_external("other.med", other, one),
            }
        }
        ["group", one, name] => {
            let path = pick(&names.all, one)?;
            file.create_group(&format!("{path}/{name}")).map(drop)
        }
        _ => Ok(()),
    }
}

/// What is stored in a list that no recipe has made too long.
fn stored<T: H5Type>(dataset: &Dataset) -> hdf5::Result<Vec<T>> {
    if dataset.size() > MOST_ENTRIES { Err("it is long".into()) } else { dataset.read_raw() }
}

/// Changes an entry of a list, or a byte of a name.
fn set(dataset: &Dataset, entry: usize, value: &str) -> hdf5::Result<()> {
    fn of<T: H5Type + Copy>(dataset: &Dataset, entry: usize, value: T) -> hdf5::Result<()> {
        let mut list = stored::<T>(dataset)?;
        let length = list.len().max(1);
        *list.get_mut(entry % length).ok_or("it is empty")? = value;
        dataset.write_raw(&list)
    }
    match dataset.dtype()?.to_descriptor()? {
        TypeDescriptor::Integer(IntSize::U4) => of::<i32>(dataset, entry, parsed(value)?),
        TypeDescriptor::Integer(_) => of::<i64>(dataset, entry, parsed(value)?),
        TypeDescriptor::Float(_) => of::<f64>(dataset, entry, parsed(value)?),
        TypeDescriptor::FixedArray(..) => {
            let mut names = stored::<[i8; 80]>(dataset)?;
            let length = names.len().max(1);
            let name = names.get_mut(entry / 80 % length).ok_or("it is empty")?;
            name[entry % 80] = parsed(value)?;
            dataset.write_raw(&names)
        }
        _ => Ok(()),
    }
}

/// Makes a list anew: of another type, layout or length. What was in it comes again and again.
fn anew(file: &File, path: &str, kind: &str, layout: &str, length: usize) -> hdf5::Result<()> {
    let old = file.dataset(path)?;
    let rows = old.attr("NBR").and_then(|rows| rows.read_scalar::<i64>());
    match kind {
        "i8" => rewrite::<i8>(file, path, &old, layout, length)?,
        "i16" => rewrite::<i16>(file, path, &old, layout, length)?,
        "i32" => rewrite::<i32>(file, path, &old, layout, length)?,
        "u32" => rewrite::<u32>(file, path, &old, layout, length)?,
        "u64" => rewrite::<u64>(file, path, &old, layout, length)?,
        "f32" => rewrite::<f32>(file, path, &old, layout, length)?,
        "f64" => rewrite::<f64>(file, path, &old, layout, length)?,
        "names" => rewrite::<[i8; 80]>(file, path, &old, layout, length)?,
        "bytes" => rewrite::<[u8; 80]>(file, path, &old, layout, length)?,
        "pairs" => rewrite::<[i64; 2]>(file, path, &old, layout, length)?,
        "text" => {
            file.unlink(path)?;
            file.new_dataset::<VarLenUnicode>().shape(length % MOST_ENTRIES).create(path)?;
        }
        _ => rewrite::<i64>(file, path, &old, layout, length)?,
    }
    if let Ok(rows) = rows {
        file.dataset(path)?.new_attr::<i64>().create("NBR")?.write_scalar(&rows)?;
    }
    Ok(())
}

fn rewrite<T: H5Type + Clone>(
    file: &File,
    path: &str,
    old: &Dataset,
    layout: &str,
    length: usize,
) -> hdf5::Result<()> {
    let values = stored::<T>(old).unwrap_or_default();
    file.unlink(path)?;
    // Nothing is stored of a list that nothing is written to.
    let is_written = length <= MOST_ENTRIES && !values.is_empty();
    let builder = file.new_dataset::<T>();
    let chunk = length.clamp(1, 64);
    let builder = match layout {
        "chunked" => builder.chunk(chunk),
        "packed" => builder.chunk(length.clamp(1, MOST_ENTRIES)).shuffle().deflate(9),
        "summed" => builder.chunk(chunk).fletcher32(),
        "reduced" => builder.chunk(chunk).nbit(),
        "compact" => builder.layout(hdf5::dataset::Layout::Compact),
        "outside" => builder.no_chunk().external("other.raw", 0, 64),
        _ => builder.no_chunk(),
    };
    let dataset = match layout {
        "square" => builder.shape((length % MOST_ENTRIES, 2)).create(path)?,
        "scalar" => builder.shape(()).create(path)?,
        _ => builder.shape(length).create(path)?,
    };
    if is_written && !matches!(layout, "square" | "scalar" | "outside") {
        let list: Vec<T> = values.iter().cycle().take(length).cloned().collect();
        dataset.write_raw(&list)?;
    }
    Ok(())
}

/// Changes, makes anew or takes away an attribute.
fn attribute(of: &Location, which: &str, kind: &str, value: &str) -> hdf5::Result<()> {
    let mut names = of.attr_names()?;
    names.sort();
    let (is_new, name) = match which.parse::<usize>() {
        Ok(number) if !names.is_empty() => (false, names[number % names.len()].clone()),
        Ok(_) => return Ok(()),
        Err(_) => (true, which.to_owned()),
    };
    if !is_new || names.contains(&name) {
        of.delete_attr(&name)?;
    }
    let name = name.as_str();
    match kind {
        "i64" => of.new_attr::<i64>().create(name)?.write_scalar(&parsed::<i64>(value)?),
        "i32" => of.new_attr::<i32>().create(name)?.write_scalar(&parsed::<i32>(value)?),
        "u64" => of.new_attr::<u64>().create(name)?.write_scalar(&parsed::<u64>(value)?),
        "f64" => of.new_attr::<f64>().create(name)?.write_scalar(&parsed::<f64>(value)?),
        "list" => of.new_attr::<i64>().shape(parsed::<usize>(value)? % 100).create(name).map(drop),
        "text" => {
            let text = FixedAscii::<256>::from_ascii(value.as_bytes()).map_err(|_| "no ASCII")?;
            of.new_attr::<FixedAscii<256>>().create(name)?.write_scalar(&text)
        }
        "words" => of.new_attr::<VarLenUnicode>().create(name).map(drop),
        _ => Ok(()),
    }
}

/// Changes of single bytes, and of eight at a place that is a multiple of eight.
fn change_bytes(bytes: &mut Vec<u8>, line: &[&str]) -> Option<()> {
    match line {
        ["byte", at, value] => {
            let at = at.parse::<usize>().ok()?.checked_rem(bytes.len())?;
            bytes[at] = value.parse().ok()?;
        }
        ["word", at, value] => {
            let at = 8 * at.parse::<usize>().ok()?.checked_rem(bytes.len() / 8)?;
            let value: i64 = value.parse().ok()?;
            bytes[at..at + 8].copy_from_slice(&value.to_le_bytes());
        }
        ["truncate", length] => bytes.truncate(length.parse().ok()?),
        _ => return None,
    }
    Some(())
}
