//! Finds PETSc, MPI and METIS and generates the bindings of the two C libraries that have no
//! maintained crate: PETSc and METIS.
//!
//! PETSc is looked for in `PETSC_DIR`/`PETSC_ARCH`, then by pkg-config, then where Debian puts it.
//! MPI headers come from `mpicc` (or `MPICC`), then pkg-config. METIS comes from `METIS_DIR` or the
//! system. Version 3.18 of PETSc is the one that is tested; a newer one gives a warning.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs};

/// Where a library's headers are and how to link it.
struct Found {
    include: Vec<PathBuf>,
    link: Vec<String>,
}

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed=src/petsc/wrapper.h");
    for name in ["PETSC_DIR", "PETSC_ARCH", "METIS_DIR", "MPICC", "PKG_CONFIG_PATH"] {
        println!("cargo::rerun-if-env-changed={name}");
    }
    let petsc = find_petsc().unwrap_or_else(|reasons| {
        panic!("PETSc was not found:\n{reasons}\nSet PETSC_DIR (and PETSC_ARCH), or on Debian: apt-get install libpetsc-real3.18-dev")
    });
    let version = petsc_version(&petsc.include);
    let mpi = find_mpi();
    let metis = find_metis();
    for found in [&petsc, &metis] {
        for line in &found.link {
            println!("cargo::{line}");
        }
    }
    // Found by the libraries before that of the C library (src/comm/waiting.rs).
    println!("cargo::rustc-link-arg=-Wl,--export-dynamic-symbol=sched_yield");
    println!("cargo::rustc-env=COLUMN_HPC_PETSC_VERSION={version}");
    println!("cargo::rustc-env=COLUMN_HPC_GIT={}", git_revision());
    let include: Vec<_> = [petsc.include, mpi, metis.include].concat();
    generate(&include);
}

/// The PETSc build, or every reason why none was found.
fn find_petsc() -> Result<Found, String> {
    let mut reasons = Vec::new();
    if let Ok(dir) = env::var("PETSC_DIR") {
        let dir = PathBuf::from(dir);
        let arch = env::var("PETSC_ARCH").map(|a| dir.join(a)).unwrap_or_else(|_| dir.clone());
        match petsc_in(&dir, &arch) {
            Ok(found) => return Ok(found),
            Err(reason) => reasons.push(format!("  PETSC_DIR: {reason}")),
        }
    }
    for name in ["PETSc", "petsc"] {
        match pkg_config::Config::new().cargo_metadata(true).atleast_version("3.18").probe(name) {
            Ok(library) => return Ok(Found { include: library.include_paths, link: Vec::new() }),
            Err(e) => {
                let text = e.to_string();
                let first = text.lines().find(|l| !l.trim().is_empty()).unwrap_or("no answer");
                reasons.push(format!("  pkg-config {name}: {first}"));
            }
        }
    }
    let debian = Path::new("/usr/lib/petsc");
    match petsc_in(debian, debian) {
        Ok(found) => Ok(found),
        Err(reason) => {
            reasons.push(format!("  Debian's place: {reason}"));
            Err(reasons.join("\n"))
        }
    }
}

/// A PETSc tree: headers in `dir/include` and `arch/include`, the library in `arch/lib`.
fn petsc_in(dir: &Path, arch: &Path) -> Result<Found, String> {
    let header = dir.join("include/petsc.h");
    if !header.exists() {
        return Err(format!("no {}", header.display()));
    }
    let lib = arch.join("lib");
    let name = ["petsc_real", "petsc"]
        .into_iter()
        .find(|n| lib.join(format!("lib{n}.so")).exists() || lib.join(format!("lib{n}.a")).exists())
        .ok_or_else(|| format!("no libpetsc in {}", lib.display()))?;
    Ok(Found {
        include: vec![dir.join("include"), arch.join("include")],
        link: vec![
            format!("rustc-link-search=native={}", lib.display()),
            format!("rustc-link-lib=dylib={name}"),
            format!("rustc-link-arg=-Wl,-rpath,{}", lib.display()),
        ],
    })
}

/// Reads `petscversion.h` and `petscconf.h`; refuses what the fence was not written for.
fn petsc_version(include: &[PathBuf]) -> String {
    let read = |file: &str| {
        include.iter().find_map(|d| fs::read_to_string(d.join(file)).ok()).unwrap_or_default()
    };
    let header = read("petscversion.h");
    let number = |key: &str| -> u32 {
        header
            .lines()
            .find_map(|l| l.strip_prefix("#define ")?.trim().strip_prefix(key)?.trim().parse().ok())
            .unwrap_or_else(|| panic!("petscversion.h does not define {key}"))
    };
    let (major, minor) = (number("PETSC_VERSION_MAJOR"), number("PETSC_VERSION_MINOR"));
    let patch = number("PETSC_VERSION_SUBMINOR");
    assert!((major, minor) >= (3, 18), "PETSc {major}.{minor} is too old: 3.18 or newer is needed");
    if (major, minor) > (3, 18) {
        println!(
            "cargo::warning=PETSc {major}.{minor} is newer than 3.18, the version that is tested"
        );
    }
    let conf = read("petscconf.h");
    for (key, what) in [
        ("PETSC_USE_COMPLEX", "complex scalars: a real build is needed"),
        ("PETSC_USE_REAL_SINGLE", "single precision: a double precision build is needed"),
        ("PETSC_USE_64BIT_INDICES", "64-bit indices: a build with 32-bit indices is needed"),
    ] {
        let defined = conf.lines().any(|l| l.split_whitespace().nth(1) == Some(key));
        assert!(!defined, "this PETSc has {what}");
    }
    format!("{major}.{minor}.{patch}")
}

/// Include directories of the MPI that `mpi-sys` links.
fn find_mpi() -> Vec<PathBuf> {
    let mpicc = env::var("MPICC").unwrap_or_else(|_| "mpicc".into());
    for flag in ["--showme:incdirs", "-show"] {
        if let Ok(out) = Command::new(&mpicc).arg(flag).output()
            && out.status.success()
        {
            let text = String::from_utf8_lossy(&out.stdout);
            let dirs: Vec<_> = text
                .split_whitespace()
                .filter_map(|w| if flag == "-show" { w.strip_prefix("-I") } else { Some(w) })
                .map(PathBuf::from)
                .collect();
            if !dirs.is_empty() {
                return dirs;
            }
        }
    }
    pkg_config::Config::new().cargo_metadata(false).probe("mpi-c").map_or_else(
        |_| panic!("MPI headers were not found: put mpicc on the PATH, or on Debian: apt-get install libopenmpi-dev"),
        |library| library.include_paths,
    )
}

fn find_metis() -> Found {
    let mut found = Found { include: Vec::new(), link: vec!["rustc-link-lib=dylib=metis".into()] };
    if let Ok(dir) = env::var("METIS_DIR") {
        let dir = PathBuf::from(dir);
        found.include.push(dir.join("include"));
        found.link.push(format!("rustc-link-search=native={}", dir.join("lib").display()));
        found.link.push(format!("rustc-link-arg=-Wl,-rpath,{}", dir.join("lib").display()));
    } else if !Path::new("/usr/include/metis.h").exists() {
        println!(
            "cargo::warning=no /usr/include/metis.h: set METIS_DIR, or on Debian: apt-get install libmetis-dev"
        );
    }
    found
}

/// The commit the program is built from, `unknown` outside a checkout.
fn git_revision() -> String {
    Command::new("git")
        .args(["describe", "--always", "--dirty", "--abbrev=12"])
        .output()
        .ok()
        .filter(|o| o.status.success())
        .map_or_else(|| "unknown".into(), |o| String::from_utf8_lossy(&o.stdout).trim().to_string())
}

fn generate(include: &[PathBuf]) {
    let mut builder = bindgen::builder()
        .header("src/petsc/wrapper.h")
        .use_core()
        .layout_tests(false)
        .generate_comments(false)
        .merge_extern_blocks(true)
        .default_enum_style(bindgen::EnumVariation::Consts)
        .prepend_enum_name(false)
        .derive_debug(false)
        .size_t_is_usize(true)
        .rust_edition(bindgen::RustEdition::Edition2024)
        // One type of communicator for rsmpi, PETSc and HDF5.
        .blocklist_type("^(MPI_.*|ompi_.*)$")
        .raw_line("use mpi::ffi::*;")
        .opaque_type("^_p_.*");
    for dir in include {
        builder = builder.clang_arg(format!("-I{}", dir.display()));
    }
    let list = fs::read_to_string("src/petsc/wrapper.h").expect("src/petsc/wrapper.h");
    for line in list.lines() {
        let Some(line) = line.strip_prefix("// bind ") else { continue };
        let (kind, names) = line.split_once(':').expect("// bind KIND: NAMES");
        for name in names.split_whitespace() {
            let name = format!("^{name}$");
            builder = match kind {
                "functions" => builder.allowlist_function(name),
                "types" => builder.allowlist_type(name),
                "variables" => builder.allowlist_var(name),
                other => panic!("wrapper.h: unknown kind {other}"),
            };
        }
    }
    let out = PathBuf::from(env::var("OUT_DIR").expect("cargo sets OUT_DIR")).join("petsc.rs");
    builder
        .generate()
        .expect("bindgen could not read the headers of PETSc and METIS (libclang: apt-get install libclang-dev)")
        .write_to_file(out)
        .expect("writing the bindings");
}
