//! Start and end of PETSc, its options and its log stages.

#![allow(unsafe_code)]

use super::error::{c_string, check, record, text};
use super::ffi;
use super::options::{options_in, refused_option};
use crate::comm::Comm;
use crate::error::{Error, Result};
use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::ffi::{CString, c_char, c_int};
use std::ptr;
use std::rc::Rc;

/// PETSc, initialised. Clones share it; it is finalised when the last one is gone, and every
/// vector, matrix and solver holds one.
#[derive(Clone)]
pub struct Petsc {
    session: Rc<Session>,
    /// What vectors, matrices and solvers are made on.
    comm: Comm,
}

struct Session {
    /// Freed after PETSc is finalised: `Drop` of the struct runs before its fields are dropped.
    _comm: Comm,
    /// The options of the command line, for [`Petsc::insert_options`].
    command_line: Vec<CString>,
    /// Options that presets have set and the user has not.
    defaults: RefCell<BTreeSet<String>>,
    /// What [`Petsc::options_of_case`] has set, with the values that stood there before.
    of_case: RefCell<Vec<(String, Option<String>)>>,
    /// Log stages by name: PETSc takes each name once.
    stages: RefCell<BTreeMap<String, c_int>>,
}

/// Options that every run gives to PETSc: no files of options, no handler of signals.
const FIXED: [&str; 2] = ["skip_petscrc", "no_signal_handler"];

/// Refuses options that run or read something else.
fn refuse<'w>(words: impl Iterator<Item = &'w str>) -> Result<()> {
    match refused_option(words) {
        None => Ok(()),
        Some(word) => Err(Error::Input(format!(
            "the PETSc option `{word}` is refused: it would run or read something other than the case"
        ))),
    }
}

impl Petsc {
    /// Starts PETSc on a duplicate of `comm`, with the options of the command line. Collective;
    /// once in a process.
    ///
    /// The files `.petscrc` and `petscrc` are not read, so that a run depends on its case and its
    /// command line alone (and on `PETSC_OPTIONS`).
    ///
    /// # Errors
    /// `Input` when the options do not begin with a `-name`, or one asks to run or read something
    /// else; `System` when the library is not the
    /// version that the program was built with, or does not start.
    pub fn start(comm: &Comm, options: &[String]) -> Result<Self> {
        if let Some(first) = options.first().filter(|first| !first.starts_with('-')) {
            return Err(Error::Input(format!(
                "`{first}` is no PETSc option: after `--` come options of PETSc, such as -ksp_monitor"
            )));
        }
        refuse(options.iter().map(String::as_str))?;
        check_version()?;
        let comm = comm.duplicate();
        let command_line = options.iter().map(|o| c_string(o)).collect::<Result<Vec<_>>>()?;
        let program = c_string("column-hpc")?;
        let fixed = FIXED.iter().map(|name| c_string(&format!("-{name}")));
        let fixed = std::iter::once(Ok(program)).chain(fixed).collect::<Result<Vec<_>>>()?;
        // PETSc keeps argv for as long as it runs: leaked.
        let mut argv: Vec<*mut c_char> = fixed
            .into_iter()
            .map(CString::into_raw)
            .chain(command_line.iter().map(|option| option.clone().into_raw()))
            .collect();
        let mut argc = c_int::try_from(argv.len())
            .map_err(|_| Error::Input("too many PETSc options".into()))?;
        argv.push(ptr::null_mut());
        let mut argv = Box::leak(argv.into_boxed_slice()).as_mut_ptr();
        // SAFETY: PETSc is not initialised yet and nothing else touches this variable; the
        // communicator outlives PETSc, since the session holds it.
        unsafe { ffi::PETSC_COMM_WORLD = comm.raw() };
        // SAFETY: argc and argv are those of a C main, leaked above; the two texts are optional.
        let code = unsafe { ffi::PetscInitialize(&mut argc, &mut argv, ptr::null(), ptr::null()) };
        check(code, "PetscInitialize")?;
        // SAFETY: the handler is a static function that needs no context.
        let code = unsafe { ffi::PetscPushErrorHandler(Some(record), ptr::null_mut()) };
        check(code, "PetscPushErrorHandler")?;
        let session = Session {
            _comm: comm.clone(),
            command_line,
            defaults: RefCell::default(),
            of_case: RefCell::default(),
            stages: RefCell::default(),
        };
        Ok(Petsc { session: Rc::new(session), comm })
    }

    /// The ranks that PETSc runs on. Local.
    pub fn comm(&self) -> &Comm {
        &self.comm
    }

    /// The same PETSc for what this rank does by itself. Local.
    pub fn alone(&self) -> Self {
        Petsc { session: Rc::clone(&self.session), comm: self.comm.alone() }
    }

    /// Whether the command line or the environment gives options. Local.
    pub fn has_options(&self) -> bool {
        let environment = std::env::var_os("PETSC_OPTIONS");
        !self.session.command_line.is_empty() || environment.is_some_and(|o| !o.is_empty())
    }

    /// Sets the options of a case in the place of those of the case before, if there was one in
    /// this process. Local, but to be called alike on all ranks.
    ///
    /// # Errors
    /// As [`Petsc::insert_options`].
    pub fn options_of_case(&self, options: &str) -> Result<()> {
        for (name, before) in self.session.of_case.take() {
            match before {
                Some(value) => self.set_option(&name, &value)?,
                None => self.clear_option(&name)?,
            }
        }
        let all = options_in(&self.all_options()?);
        let before = |name: &str| all.iter().find(|(other, _)| other.eq_ignore_ascii_case(name));
        let given = options_in(options).into_iter().map(|(name, _)| {
            let value = before(&name).map(|(_, value)| value.clone());
            (name, value)
        });
        self.session.of_case.replace(given.collect());
        self.insert_options(options)
    }

    /// Adds options as they are written in a case (`-name value -name value`). Those of the command
    /// line win. Local, but to be called alike on all ranks.
    ///
    /// # Errors
    /// `Input` when the text does not begin with a `-name`, or an option asks to run or read
    /// something else; `System` when PETSc refuses it.
    pub fn insert_options(&self, options: &str) -> Result<()> {
        if !options.trim().is_empty() && !options.trim_start().starts_with('-') {
            return Err(Error::Input(format!(
                "PETSc options are written as -name value, not `{options}`"
            )));
        }
        refuse(options.split_whitespace())?;
        let options = c_string(options)?;
        // SAFETY: PETSc is initialised, the string lives through the call.
        let code = unsafe { ffi::PetscOptionsInsertString(ptr::null_mut(), options.as_ptr()) };
        check(code, "PetscOptionsInsertString")?;
        let mut again: Vec<*mut c_char> =
            self.session.command_line.iter().map(|option| option.as_ptr().cast_mut()).collect();
        let count = c_int::try_from(again.len()).expect("counted when PETSc was started");
        // SAFETY: PETSc copies the strings and does not write to them; they outlive the call.
        let code =
            unsafe { ffi::PetscOptionsInsertArgs(ptr::null_mut(), count, again.as_mut_ptr()) };
        check(code, "PetscOptionsInsertArgs")
    }

    /// Sets one option, given without the dash; an empty value for a flag. Local, alike on all
    /// ranks.
    ///
    /// # Errors
    /// `System` when PETSc refuses it.
    pub fn set_option(&self, name: &str, value: &str) -> Result<()> {
        let name = c_string(&format!("-{name}"))?;
        let value = c_string(value)?;
        // SAFETY: PETSc is initialised and copies both strings.
        let code =
            unsafe { ffi::PetscOptionsSetValue(ptr::null_mut(), name.as_ptr(), value.as_ptr()) };
        check(code, "PetscOptionsSetValue")
    }

    /// Sets an option of a preset unless the user has set it; tells whether it did. Local, alike on
    /// all ranks.
    pub(super) fn set_default(&self, name: &str, value: &str) -> Result<bool> {
        if self.has_option(name)? {
            return Ok(false);
        }
        self.set_option(name, value)?;
        self.session.defaults.borrow_mut().insert(name.to_ascii_lowercase());
        Ok(true)
    }

    /// Takes an option of a preset out again. Local, alike on all ranks.
    pub(super) fn clear_default(&self, name: &str) -> Result<()> {
        self.session.defaults.borrow_mut().remove(&name.to_ascii_lowercase());
        self.clear_option(name)
    }

    fn clear_option(&self, name: &str) -> Result<()> {
        let name = c_string(&format!("-{name}"))?;
        // SAFETY: PETSc is initialised, the string lives through the call.
        let code = unsafe { ffi::PetscOptionsClearValue(ptr::null_mut(), name.as_ptr()) };
        check(code, "PetscOptionsClearValue")
    }

    /// Whether an option is set, given without the dash. Local.
    ///
    /// Asking is not using: the option still counts as unused.
    ///
    /// # Errors
    /// `System` when PETSc cannot list the options.
    pub fn has_option(&self, name: &str) -> Result<bool> {
        let all = options_in(&self.all_options()?);
        Ok(all.iter().any(|(option, _)| option.eq_ignore_ascii_case(name)))
    }

    /// The options of the user, of the command line, the case and the environment, as `-name` or
    /// `-name value`. Local.
    ///
    /// # Errors
    /// `System` when PETSc cannot list the options.
    pub fn user_options(&self) -> Result<Vec<String>> {
        let defaults = self.session.defaults.borrow();
        let is_ours =
            |name: &str| FIXED.contains(&name) || defaults.contains(&name.to_ascii_lowercase());
        let all = options_in(&self.all_options()?);
        let of_user = all.into_iter().filter(|(name, _)| !is_ours(name));
        Ok(of_user.map(|(name, value)| format!("-{name} {value}").trim_end().to_owned()).collect())
    }

    /// All options, as on a command line.
    fn all_options(&self) -> Result<String> {
        let mut list = ptr::null_mut();
        // SAFETY: PETSc is initialised and fills `list` with a string of its own.
        let code = unsafe { ffi::PetscOptionsGetAll(ptr::null_mut(), &mut list) };
        check(code, "PetscOptionsGetAll")?;
        // SAFETY: the string that PETSc has just made.
        let all = unsafe { text(list) };
        // SAFETY: a function pointer that PETSc sets before main and changes only in
        // PetscInitialize.
        if let Some(free) = unsafe { ffi::PetscTrFree } {
            let (function, file) = (c"has_option".as_ptr(), c"session.rs".as_ptr());
            // SAFETY: `list` comes from PETSc's allocator and is not used afterwards.
            check(unsafe { free(list.cast(), 0, function, file) }, "PetscFree")?;
        }
        Ok(all)
    }

    /// The user's options that nothing has asked for so far, as `-name` or `-name value`. Local.
    ///
    /// # Errors
    /// `System` when PETSc cannot list them.
    pub fn unused_options(&self) -> Result<Vec<String>> {
        let (mut count, mut names, mut values) = (0, ptr::null_mut(), ptr::null_mut());
        // SAFETY: PETSc is initialised and fills the three results.
        let code = unsafe {
            ffi::PetscOptionsLeftGet(ptr::null_mut(), &mut count, &mut names, &mut values)
        };
        check(code, "PetscOptionsLeftGet")?;
        let mut unused = Vec::new();
        for i in 0..usize::try_from(count).unwrap_or(0) {
            // SAFETY: `names` has `count` entries.
            let name = unsafe { *names.add(i) };
            // SAFETY: each is a string, without the dash.
            let name = unsafe { text(name) };
            // SAFETY: `values` has `count` entries.
            let value = unsafe { *values.add(i) };
            // SAFETY: each is a string or null.
            let value = unsafe { text(value) };
            if !self.session.defaults.borrow().contains(&name.to_ascii_lowercase()) {
                unused.push(format!("-{name} {value}").trim_end().to_string());
            }
        }
        // SAFETY: the three results of PetscOptionsLeftGet, given back once.
        let code = unsafe {
            ffi::PetscOptionsLeftRestore(ptr::null_mut(), &mut count, &mut names, &mut values)
        };
        check(code, "PetscOptionsLeftRestore")?;
        Ok(unused)
    }

    /// Counts what is done until the guard is dropped under `name` in `-log_view`. Collective.
    ///
    /// # Errors
    /// `System` when PETSc refuses the stage.
    pub fn stage(&self, name: &str) -> Result<Stage> {
        let known = self.session.stages.borrow().get(name).copied();
        let number = match known {
            Some(number) => number,
            None => {
                let (text, mut number) = (c_string(name)?, 0);
                // SAFETY: PETSc is initialised and copies the name.
                let code = unsafe { ffi::PetscLogStageRegister(text.as_ptr(), &mut number) };
                check(code, "PetscLogStageRegister")?;
                self.session.stages.borrow_mut().insert(name.to_string(), number);
                number
            }
        };
        // SAFETY: the number of a registered stage.
        check(unsafe { ffi::PetscLogStagePush(number) }, "PetscLogStagePush")?;
        Ok(Stage { _petsc: self.clone() })
    }
}

/// The library that is loaded is the one whose headers were read.
fn check_version() -> Result<()> {
    let (mut major, mut minor, mut patch, mut release) = (0, 0, 0, 0);
    // SAFETY: the function only writes its four results and needs no initialised PETSc.
    let code =
        unsafe { ffi::PetscGetVersionNumber(&mut major, &mut minor, &mut patch, &mut release) };
    check(code, "PetscGetVersionNumber")?;
    let built = (ffi::PETSC_VERSION_MAJOR as c_int, ffi::PETSC_VERSION_MINOR as c_int);
    if (major, minor) == built {
        return Ok(());
    }
    Err(Error::System(format!(
        "PETSc {major}.{minor}.{patch} is loaded, but the program was built with {}.{}: \
         build it again, or load the module it was built with",
        built.0, built.1
    )))
}

impl Drop for Session {
    fn drop(&mut self) {
        // Finalising is collective: a rank that is unwinding must not wait for the others.
        if std::thread::panicking() {
            return;
        }
        // SAFETY: pushed in `start`; every object of PETSc held this session and is gone.
        unsafe { ffi::PetscPopErrorHandler() };
        // SAFETY: initialised in `start`, finalised once; MPI is still up, since `comm` is.
        unsafe { ffi::PetscFinalize() };
    }
}

/// A log stage; it ends when this is dropped.
#[must_use = "the stage ends when the guard is dropped"]
pub struct Stage {
    _petsc: Petsc,
}

impl Drop for Stage {
    fn drop(&mut self) {
        // SAFETY: pushed when the guard was made; PETSc is still initialised, since we hold it.
        unsafe { ffi::PetscLogStagePop() };
    }
}
