//! Start and end of the process: environment, MPI, PETSc, panics.

#![allow(unsafe_code)]

use crate::comm::{Comm, abort, yield_while_waiting};
use crate::error::{Error, Result};
use crate::petsc::Petsc;
use crate::signals;
use mpi::topology::SimpleCommunicator;
use mpi::traits::Communicator;
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::ptr::NonNull;
use std::sync::atomic::{AtomicBool, Ordering};
use std::{env, panic, process, ptr};

/// Exit status of a run that ends by a panic.
const PANIC: u8 = 101;

/// MPI and PETSc, started: what a program needs to run cases. The fields are dropped in their
/// order: PETSc ends before MPI.
///
/// Vectors, matrices and communicators keep what they need alive, so the order in which a program
/// drops them does not matter; that all ranks drop them in the same order does.
pub struct Runtime {
    /// Of the process, not of what a rank does by itself.
    _libraries: Option<Libraries>,
    /// PETSc.
    pub petsc: Petsc,
    /// All ranks; the last of the communicators to go finalises MPI.
    pub comm: Comm,
}

impl Runtime {
    /// Starts MPI, then PETSc with the options of the command line. Collective, once in a process,
    /// and before the process has a second thread.
    ///
    /// From here on a panic on any rank ends the whole job with status 101.
    ///
    /// # Errors
    /// `System` when MPI or PETSc does not start, `Input` when `options` are no options.
    pub fn start(options: &[String]) -> Result<Self> {
        choose_file_writer();
        yield_while_waiting();
        // A second thread writes files and makes no calls of MPI.
        let universe = mpi::initialize_with_threading(mpi::Threading::Funneled)
            .map(|(universe, _)| universe)
            .ok_or_else(|| Error::System("MPI has been started before in this process".into()))?;
        abort_on_panic();
        let comm = Comm::world(universe);
        if comm.size() > 1 {
            use_one_blas_thread();
        }
        let petsc = comm.agree(Petsc::start(&comm, options))?;
        comm.agree(signals::listen())?;
        Ok(Runtime { _libraries: Some(Libraries), petsc, comm })
    }

    /// The same for what this rank does by itself. Local.
    pub fn alone(&self) -> Self {
        let petsc = self.petsc.alone();
        Runtime { _libraries: None, comm: petsc.comm().clone(), petsc }
    }

    /// Ends PETSc and MPI, then the process. Collective; nothing that holds PETSc or a
    /// communicator may be left.
    pub fn exit(self, status: u8) -> ! {
        if CANNOT_END.load(Ordering::Relaxed) && status != 0 {
            // Everybody has said what there is to say.
            self.comm.barrier();
            SimpleCommunicator::world().abort(status.into());
        }
        drop(self);
        process::exit(status.into())
    }
}

/// Whether a library is in no state to be ended.
static CANNOT_END: AtomicBool = AtomicBool::new(false);

/// Takes note that a file could not be closed: HDF5 crashes when MPI ends after that, so that a run
/// that fails is then ended without. Local; on all ranks or on none.
pub fn leave_libraries() {
    CANNOT_END.store(true, Ordering::Relaxed);
}

/// Makes a panic end the job at once: unwinding would run collective drops that wait for the other
/// ranks.
fn abort_on_panic() {
    panic::set_hook(Box::new(|info| {
        let trace = std::backtrace::Backtrace::capture();
        let trace = match trace.status() {
            std::backtrace::BacktraceStatus::Captured => format!("\n{trace}"),
            _ => String::new(),
        };
        abort(
            PANIC,
            &format!(
                "{info}\nThis is a bug in column-hpc: please report it with the case file.{trace}"
            ),
        )
    }));
}

/// Open MPI 4's default way to write files collectively (`vulcan`) can lose data under HDF5
/// (open-mpi/ompi issue 12718); another is chosen unless the user has.
fn choose_file_writer() {
    let name = "OMPI_MCA_fcoll";
    if env::var_os(name).is_none() {
        // SAFETY: called before MPI starts, while the process has one thread.
        unsafe { env::set_var(name, "dynamic_gen2") };
    }
}

unsafe extern "C" {
    fn dlsym(handle: *mut c_void, symbol: *const c_char) -> *mut c_void;
    fn dlopen(name: *const c_char, flags: c_int) -> *mut c_void;
    fn dl_iterate_phdr(
        callback: unsafe extern "C" fn(*const Loaded, usize, *mut c_void) -> c_int,
        data: *mut c_void,
    ) -> c_int;
}

/// What the dynamic linker tells of a library, as far as it is read here.
#[repr(C)]
struct Loaded {
    address: usize,
    /// A string of C.
    name: *const c_char,
}

/// Notes the name of a library.
///
/// # Safety
/// As `dl_iterate_phdr` calls it, with a vector of names as its data.
unsafe extern "C" fn note_library(loaded: *const Loaded, _: usize, data: *mut c_void) -> c_int {
    // SAFETY: valid for the length of the call by the contract.
    let (name, names) = unsafe { ((*loaded).name, &mut *data.cast::<Vec<CString>>()) };
    if !name.is_null() {
        // SAFETY: a string of C by the contract of the linker.
        names.push(unsafe { CStr::from_ptr(name) }.to_owned());
    }
    0
}

/// Keeps every library mapped until the process ends, from when this goes. Open MPI unloads its
/// components while a thread of one of them may still run: of a small case one run in 300 crashed
/// after all its work was done.
struct Libraries;

impl Drop for Libraries {
    fn drop(&mut self) {
        keep_libraries();
    }
}

fn keep_libraries() {
    const LAZY_NOT_LOADED_NO_DELETE: c_int = 0x1 | 0x4 | 0x1000;
    let mut names: Vec<CString> = Vec::new();
    // SAFETY: the callback fits, and the vector outlives the call.
    unsafe { dl_iterate_phdr(note_library, (&raw mut names).cast()) };
    for name in names.iter().filter(|name| !name.is_empty()) {
        // SAFETY: a string of C; nothing is loaded that is not there.
        unsafe { dlopen(name.as_ptr(), LAZY_NOT_LOADED_NO_DELETE) };
    }
}

/// A function of the C library, where it has it.
fn of_c(name: &CStr) -> Option<NonNull<c_void>> {
    // SAFETY: a null handle and a name that ends with a zero.
    NonNull::new(unsafe { dlsym(ptr::null_mut(), name.as_ptr()) })
}

/// Gives memory that is free back to the system, where the C library can: what was large for a
/// moment then adds nothing to what is large later. Local.
pub fn give_back_memory() {
    if let Some(found) = of_c(c"malloc_trim") {
        // SAFETY: glibc has it with this signature.
        let trim =
            unsafe { std::mem::transmute::<NonNull<c_void>, extern "C" fn(usize) -> c_int>(found) };
        trim(0);
    }
}

/// Arrays above a size get pages of their own, which go back to the system with them, as long as
/// this is there. Open MPI forbids that at its start: all that was ever taken stays then, in
/// pieces, and arrays that grow are copied.
pub struct OwnPages(());

impl OwnPages {
    /// Bytes of the smallest array that gets pages of its own.
    const LEAST: c_int = 128 << 10;
    /// The same afterwards: the largest that glibc chooses when large arrays come and go.
    const AFTERWARDS: c_int = 32 << 20;

    /// Local.
    pub fn start() -> Self {
        Self::set(Self::LEAST, Self::LEAST);
        Self(())
    }

    fn set(mapped: c_int, kept: c_int) {
        // As in glibc's malloc.h, where the number of such arrays is 65536 by default.
        const TRIM_THRESHOLD: c_int = -1;
        const MMAP_THRESHOLD: c_int = -3;
        const MMAP_MAX: c_int = -4;
        if let Some(found) = of_c(c"mallopt") {
            // SAFETY: glibc has it with this signature.
            let set = unsafe {
                std::mem::transmute::<NonNull<c_void>, extern "C" fn(c_int, c_int) -> c_int>(found)
            };
            set(MMAP_MAX, 65_536);
            set(MMAP_THRESHOLD, mapped);
            set(TRIM_THRESHOLD, kept);
        }
    }
}

impl Drop for OwnPages {
    fn drop(&mut self) {
        Self::set(Self::AFTERWARDS, 2 * Self::AFTERWARDS);
    }
}

/// Several ranks with a thread per core each would fight for the cores: OpenBLAS, if that is the
/// BLAS, gets one thread unless the environment says otherwise.
fn use_one_blas_thread() {
    let chosen = ["OPENBLAS_NUM_THREADS", "GOTO_NUM_THREADS", "OMP_NUM_THREADS"];
    if chosen.iter().any(|name| env::var_os(name).is_some()) {
        return;
    }
    // SAFETY: the null handle looks the name up in the libraries that are loaded.
    let found = unsafe { dlsym(ptr::null_mut(), c"openblas_set_num_threads".as_ptr()) };
    if found.is_null() {
        return;
    }
    // SAFETY: the function of that name in OpenBLAS: `void openblas_set_num_threads(int)`.
    let set: extern "C" fn(c_int) =
        unsafe { std::mem::transmute::<*mut c_void, extern "C" fn(c_int)>(found) };
    set(1);
}
