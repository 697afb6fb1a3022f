//! Meshes of files that are read in slabs by all ranks are those that one rank reads whole.

use column_hpc::case::Case;
use column_hpc::comm::Comm;
use column_hpc::error::Result;
use column_hpc::mesh::{LocalMesh, MeshFacts};
use column_hpc::partition::{self, Import, Method};
use column_hpc::runtime::Runtime;
use column_hpc::solve;

const ROCK: &str = "{rock: {elastic: {young_modulus: 1.0e9, poisson_ratio: 0.2}}}";
const BOTH: &str =
    "{rock: {on: [lower, upper], elastic: {young_modulus: 1.0e9, poisson_ratio: 0.2}}}";
const PAIR: &str = "{one: {on: lower, elastic: {young_modulus: 1.0e9, poisson_ratio: 0.2}}, \
                    two: {on: upper, elastic: {young_modulus: 2.0e9, poisson_ratio: 0.2}}}";

/// A mesh of `tests/meshes`, options of the mesh, materials, place of the interface, groups at
/// which something is prescribed, and why one rank has to read it, if it has.
type Given =
    (&'static str, &'static str, &'static str, &'static str, &'static [&'static str], &'static str);

const MESHES: &[Given] = &[
    ("square-4.1.msh", "", ROCK, "", &["left", "sides"], ""),
    ("square-4.1-binary.msh", ", raise_order: 2", ROCK, "on: joint", &["left", "pin"], ""),
    (
        "square-2.2.msh",
        ", raise_order: 2",
        ROCK,
        "",
        &["left", "sides"],
        "once for each of their groups",
    ),
    (
        "square-2.2-binary.msh",
        ", scale: 0.001",
        ROCK,
        "on: joint",
        &["left"],
        "once for each of their groups",
    ),
    ("hex20-4.1.msh", "", ROCK, "", &["bottom", "top"], ""),
    ("hex27-2.2.msh", "", ROCK, "", &["bottom", "top"], ""),
    ("prism15-4.1-binary.msh", "", ROCK, "", &["bottom", "top"], ""),
    ("tet10-4.1-binary.msh", "", ROCK, "", &["left", "right"], ""),
    ("tet4-2.2-binary.msh", ", raise_order: 2", ROCK, "", &["left", "right"], "$ParametricNodes"),
    ("interfaces/crossing.msh", "", ROCK, "on: joint", &["outer"], ""),
    ("interfaces/branching.msh", ", raise_order: 2", ROCK, "on: joint", &["outer"], ""),
    ("interfaces/ending.msh", ", raise_order: 2", ROCK, "on: joint", &["outer"], ""),
    (
        "interfaces/leaning.msh",
        "",
        BOTH,
        "on: joint",
        &["z0", "x0", "y0"],
        "facets of interfaces are divided",
    ),
    ("interfaces/corner.msh", ", raise_order: 2", ROCK, "on: joint", &["x0", "y0", "z0"], ""),
    ("turned/hex8.msh", ", raise_order: 2", PAIR, "on: joint", &["foot", "head"], ""),
    ("turned/prism18.msh", "", BOTH, "on: joint", &["foot", "head"], ""),
    ("turned/tet10.msh", "", PAIR, "on: joint", &["foot", "head"], ""),
    ("turned/mixed-pair.msh", "", BOTH, "between: [below, above]", &["foot", "head"], ""),
    ("turned/tet4-apart.msh", ", raise_order: 2", BOTH, "between: [above, below]", &["foot"], ""),
    ("turned/hex27-apart.msh", "", PAIR, "between: [below, above]", &["foot", "head"], ""),
    ("med_tet4_version3.med", ", raise_order: 2", ROCK, "", &["skin"], ""),
    ("med_tet10.med", "", ROCK, "", &["skin"], ""),
    ("med_hex20.med", "", ROCK, "", &["skin"], ""),
    ("med_plane2.med", "", ROCK, "", &["rim"], ""),
    ("med_hex8.med", "", ROCK, "", &["top", "edge"], "groups of nodes"),
];

fn case((mesh, options, materials, place, held, _): &Given) -> Case {
    let path = format!("{}/tests/meshes/{mesh}", env!("CARGO_MANIFEST_DIR"));
    case_of(&path, options, materials, place, held)
}

fn case_of(path: &str, options: &str, materials: &str, place: &str, held: &[&str]) -> Case {
    let law = "law: {linear_softening: {strength: 1.1e6, fracture_energy: 900.0}}";
    let interface = match place {
        "" => String::new(),
        place => format!("interfaces: [{{name: joint, {place}, {law}}}]\n"),
    };
    let held: Vec<String> =
        held.iter().map(|on| format!("  - {{on: {on}, displacement: {{x: 0}}}}\n")).collect();
    let text = format!(
        "mesh: {{file: \"{path}\"{options}}}\nmaterials: {materials}\n{interface}boundary:\n{}\
         time: {{instants: [1]}}\nsolver: {{linear: mumps}}\n",
        held.concat()
    );
    Case::read(&text, std::path::Path::new("case.yaml"), &[]).expect("a case")
}

/// The part of this rank with what is known of the whole, and what was said.
struct Part {
    mesh: LocalMesh,
    facts: MeshFacts,
    remarks: Vec<String>,
}

fn read(comm: &Comm, case: &Case, import: Import, method: Method) -> Result<Part> {
    let family = partition::family(comm, case, (import, method), solve::family, solve::divides)?;
    let (facts, remarks) = (family.facts(), family.remarks.clone());
    let mut meshes = partition::share_out(comm, family, method)?;
    let mesh = meshes.pop().expect("a mesh");
    Ok(Part { mesh, facts, remarks })
}

/// Every array, and every number that is known of the mesh, is the same. With elimination: coarser
/// meshes are looked for in what is read whole alone.
pub fn are_those_read_whole(runtime: &Runtime) {
    let comm = &runtime.comm;
    for (number, given) in MESHES.iter().enumerate() {
        let case = case(given);
        let method = [Method::Scattered, Method::Metis][number % 2];
        let read = |import| read(comm, &case, import, method).expect("a mesh");
        let (whole, slabs) = (read(Import::Whole), read(Import::Slabs));
        let name = format!("{} with {:?}", given.0, given.3);
        let why = difference(comm, &whole, &slabs).unwrap_or_else(|what| panic!("{name}: {what}"));
        assert!(!comm.is_root() || why.is_empty() == given.5.is_empty(), "{name}: {why}");
        assert!(!comm.is_root() || why.contains(given.5), "{name}: {why}");
    }
}

/// Why one rank has to read a mesh, if it has, of which all that is known is the same read either
/// way; else what differs.
fn difference(comm: &Comm, whole: &Part, slabs: &Part) -> std::result::Result<String, String> {
    if whole.facts != slabs.facts || whole.mesh.facts != slabs.mesh.facts {
        return Err(format!("{:?} and {:?}", whole.facts, slabs.facts));
    }
    let (said, mut of_slabs) = (&whole.remarks, slabs.remarks.clone());
    let mut why = String::new();
    if of_slabs.last().is_some_and(|last| last.contains("not in slabs")) {
        why = of_slabs.pop().unwrap_or_default();
    }
    // What rank 0 has to say.
    if comm.is_root() && *said != of_slabs {
        return Err(format!("{said:?} and {of_slabs:?}"));
    }
    let list = |part: &Part| serde_json::to_value(&part.mesh).expect("arrays");
    let (whole, slabs) = (list(whole), list(slabs));
    for (field, value) in whole.as_object().expect("fields") {
        if *value != slabs[field] {
            return Err(format!("{field}: {value} and {}", slabs[field]));
        }
    }
    Ok(why)
}

/// Compares the meshes of many cases, read whole and in slabs, and prints what differs: a random
/// search is done by hand.
pub fn compare(runtime: &Runtime, paths: &[String]) {
    let comm = &runtime.comm;
    let say = |words: String| comm.is_root().then(|| println!("{words}"));
    for path in paths {
        let text = std::fs::read_to_string(path).expect("a case");
        let Ok(case) = Case::read(&text, std::path::Path::new(path), &[]) else {
            say(format!("{path}: NO CASE"));
            continue;
        };
        for method in [Method::Scattered, Method::Metis] {
            let read = |import| read(comm, &case, import, method);
            let told = match (read(Import::Whole), read(Import::Slabs)) {
                (Ok(whole), Ok(slabs)) => difference(comm, &whole, &slabs),
                (Err(whole), Err(slabs)) if whole == slabs => Ok(format!("refused: {whole}")),
                (whole, slabs) => Err(format!("{:?} and {:?}", whole.err(), slabs.err())),
            };
            let is_other = comm.any(told.is_err());
            match told {
                Err(what) => {
                    println!("{path}: {method:?}: rank {}: OTHER: {what:.900}", comm.rank())
                }
                Ok(why) if !is_other => drop(say(format!("{path}: {method:?}: same. {why}"))),
                Ok(_) => {}
            }
        }
    }
}

/// A damaged file is refused in the words of the one who reads it whole, on all ranks; or it is the
/// same mesh.
pub fn damage_is_told_alike(runtime: &Runtime) {
    let comm = &runtime.comm;
    let directory = std::env::temp_dir().join(format!("column-hpc-slabs-{}", comm.size()));
    for (name, held) in [
        ("square-4.1.msh", "left"),
        ("interfaces/corner.msh", "x0"),
        ("tet10-4.1-binary.msh", "left"),
        ("turned/tet4-apart.msh", "foot"),
        ("med_tet10.med", "skin"),
    ] {
        let whole = std::fs::read(format!("{}/tests/meshes/{name}", env!("CARGO_MANIFEST_DIR")));
        let whole = whole.expect("a file of ours");
        let file = directory.join(name.replace('/', "-"));
        for way in 0..4 {
            let mut bytes = whole.clone();
            let at = (2 * way + 1) * bytes.len() / 8;
            match way % 2 {
                0 => bytes.truncate(at),
                // HDF5 itself is not to be tested.
                _ if name.ends_with("med") => continue,
                _ => bytes[at] = bytes[at].wrapping_add(3),
            }
            let write = || {
                std::fs::create_dir_all(&directory).expect("a temporary directory");
                std::fs::write(&file, &bytes).expect("a file");
            };
            if comm.is_root() {
                write();
            }
            comm.barrier();
            let case = case_of(&file.to_string_lossy(), "", ROCK, "", &[held]);
            let read = |import| {
                let part = read(comm, &case, import, Method::Scattered);
                part.map(|part| (part.facts, part.mesh.cells))
            };
            let both = [read(Import::Whole), read(Import::Slabs)];
            assert_eq!(both[0], both[1], "{name}, way {way}");
            comm.barrier();
        }
    }
    if comm.is_root() {
        std::fs::remove_dir_all(&directory).expect("a directory of ours");
    }
}

/// Two squares that share a node only: one rank reads them, and knows what hangs on what.
pub fn hinges_are_seen(runtime: &Runtime) {
    let comm = &runtime.comm;
    let text = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n\
                1 1 \"left\"\n2 1 \"rock\"\n$EndPhysicalNames\n$Nodes\n7\n1 0 0 0\n2 1 0 0\n3 1 1 0\n\
                4 0 1 0\n5 2 1 0\n6 2 2 0\n7 1 2 0\n$EndNodes\n$Elements\n3\n\
                1 1 2 1 1 1 4\n2 3 2 1 1 1 2 3 4\n3 3 2 1 1 3 5 6 7\n$EndElements\n";
    let file = std::env::temp_dir().join(format!("column-hpc-hinge-{}.msh", comm.size()));
    if comm.is_root() {
        std::fs::write(&file, text).expect("a file");
    }
    comm.barrier();
    let case = case_of(&file.to_string_lossy(), "", ROCK, "", &["left"]);
    let read = |import| read(comm, &case, import, Method::Scattered).expect("a mesh");
    let (whole, slabs) = (read(Import::Whole), read(Import::Slabs));
    assert_eq!(whole.facts.hinges.nodes.len(), 1);
    assert_eq!(whole.facts, slabs.facts);
    let why = slabs.remarks.last().cloned().unwrap_or_default();
    assert!(!comm.is_root() || why.contains("hang on others"), "{why}");
    comm.barrier();
    if comm.is_root() {
        std::fs::remove_file(&file).expect("a file of ours");
    }
}

/// Prints what the import of a file with the groups `rock`, `bottom` and `top` takes: seconds, and
/// by rank the most memory beyond what there was before, against the arrays of the part (MB).
pub fn measure(runtime: &Runtime, words: &[String]) {
    let (comm, path) = (&runtime.comm, &words[0]);
    let options = words.get(1).map_or("", String::as_str);
    let case = case_of(path, options, ROCK, "", &["bottom", "top"]);
    let import = if words.len() > 2 { Import::Whole } else { Import::Auto };
    comm.barrier();
    let (before, start) = (most_memory(), std::time::Instant::now());
    let part = read(comm, &case, import, Method::Metis).expect("a mesh");
    comm.barrier();
    let seconds = start.elapsed().as_secs_f64();
    let taken = most_memory() - before;
    let mesh = &part.mesh;
    let nodes: usize = (0..mesh.cells.len()).map(|cell| 4 * mesh.cell_nodes(cell).len()).sum();
    let of_node = size_of::<(u64, [f64; 3])>() + size_of::<column_hpc::mesh::Marks>();
    let bytes = 16 * mesh.cells.len() + nodes + of_node * mesh.nodes.names.len();
    let of_rank = [taken, bytes as f64 / 1e6, mesh.cells.len() as f64];
    for (rank, of_rank) in comm.gather(&of_rank).into_iter().flatten().enumerate() {
        let [taken, bytes, cells] = of_rank[..] else { continue };
        println!(
            "{seconds:.1} s; rank {rank}: {taken:.0} MB for {bytes:.0} MB, {cells} cells: {:.2}",
            taken / bytes
        );
    }
    if comm.is_root() {
        part.remarks.iter().for_each(|words| println!("{words}"));
    }
}

/// The most memory that this process has had (MB).
fn most_memory() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").expect("a file of Linux");
    let line = status.lines().find(|line| line.starts_with("VmHWM")).expect("a line");
    let number = line.split_whitespace().nth(1).and_then(|kb| kb.parse::<f64>().ok());
    number.expect("a number") * 1.024e-3
}
