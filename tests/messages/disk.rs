//! A disk that fills up and directories that go away in the middle of a run with checkpoints: one
//! message, status 4, what was written before stays whole, and the run goes on once there is room.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use column_hpc::output::history::Table;

use super::faults::{Ended, PROGRAM, watch};
use super::matrix::{SCENE, contents};
use super::{Folder, common, files};

/// Runs the scene with so many instants.
fn run(
    folder: &Folder,
    (ranks, instants): (usize, usize),
    fault: &str,
    more: &[&str],
    meanwhile: impl FnMut(),
) -> Ended {
    let [case, out] = ["case.yaml", "out"].map(|name| folder.path(name));
    let instants = instants_of(instants);
    let mut args = vec![case.to_str().expect("a name of ours"), "--output"];
    args.extend([out.to_str().expect("a name of ours"), "--set", &instants]);
    args.extend(more);
    watch(&folder.0, ranks, fault, &args, meanwhile)
}

fn instants_of(count: usize) -> String {
    let instants: Vec<String> = (1..=count).map(|i| format!("{}", i as f64 / 64.0)).collect();
    format!("time.instants=[{}]", instants.join(", "))
}

/// One message, of a file that could not be written.
fn assert_told(status: Option<i32>, stderr: &str, file: &str, cause: &str, label: &str) {
    assert_eq!(status, Some(4), "{label}: {stderr}");
    assert_eq!(stderr.lines().count(), 1, "{label}: {stderr}");
    assert!(stderr.starts_with("error: "), "{label}: {stderr}");
    assert!(stderr.contains("cannot write "), "{label}: {stderr}");
    assert!(stderr.contains(&format!("{file}: {cause} (os error ")), "{label}: {stderr}");
}

/// What is left is whole, nothing of it temporary: the rows of a history so far.
fn assert_whole(out: &Path, label: &str) -> Table {
    let temporary = |file: &std::path::PathBuf| file.to_string_lossy().contains(".tmp.");
    assert!(!files(out).iter().any(temporary), "{label}: {:?}", files(out));
    contents(out, label);
    let table = Table::read(&out.join("history.csv")).expect("a whole history");
    assert!(table.rows.iter().all(|row| row.len() == table.columns.len()), "{label}");
    table
}

/// The same values in as many rows as the shorter one has.
fn assert_begins_alike(one: &Table, other: &Table, label: &str) {
    assert_eq!(one.columns, other.columns);
    for name in ["time", "joint.normal_traction.mean", "joint.normal_jump.max", "energy.external"] {
        let column = one.column(name).expect(name);
        for (a, b) in one.rows.iter().zip(&other.rows) {
            let [a, b] = [a[column].expect(name), b[column].expect(name)];
            assert!((a - b).abs() <= 1e-9 * a.abs().max(1e-9), "{label}: {name} {a} {b}");
        }
    }
}

#[test]
fn files_that_may_not_grow_end_the_run_and_it_goes_on_with_room() {
    let unbroken = Folder::with(SCENE);
    assert_eq!(run(&unbroken, (1, 3), "", &[], || {}).status, Some(0));
    let unbroken = assert_whole(&unbroken.path("out"), "unbroken");
    for (ranks, fault, file, rows) in [
        (1, "history:0:full:2", "fields/bulk_000002.vtkhdf", 2),
        (2, "history:1:full:2", "fields/bulk_000002.vtkhdf", 2),
        // Rank 0 may still be busy with what was written before.
        (2, "state:0:full:2", "", 2),
        (3, "state:2:full:2", "checkpoint.h5", 2),
        (2, "row:0:full:2", "history.csv", 1),
        (2, "report:0:full", "report.json", 3),
    ] {
        let folder = Folder::with(SCENE);
        let ended = run(&folder, (ranks, 3), fault, &[], || {});
        let label = format!("{fault}: {ended:?}");
        assert_told(ended.status, &ended.stderr, file, "File too large", &label);
        let left = assert_whole(&folder.path("out"), &label);
        assert_eq!(left.rows.len(), rows, "{label}");
        assert_begins_alike(&left, &unbroken, &label);
        let again = run(&folder, (ranks, 3), "", &["--restart", "latest"], || {});
        assert_eq!((again.status, again.stderr.as_str()), (Some(0), ""), "after {label}");
        let whole = assert_whole(&folder.path("out"), &label);
        assert_eq!(whole.rows.len(), 3, "after {label}");
        assert_begins_alike(&whole, &unbroken, &label);
    }
}

/// Room for a file is made before it is written; where the disk fails all the same, the libraries
/// have words of their own.
#[test]
fn a_disk_that_fails_in_the_middle_of_a_file_ends_the_run() {
    for (ranks, fault) in
        [(1, "output:0:full:5"), (2, "output:0:full:6"), (3, "checkpoint:0:full:2")]
    {
        let folder = Folder::with(SCENE);
        let ended = run(&folder, (ranks, 3), fault, &[], || {});
        assert_eq!(ended.status, Some(4), "{fault}: {ended:?}");
        let told: Vec<&str> =
            ended.stderr.lines().filter(|line| line.starts_with("error: ")).collect();
        assert_eq!(told.len(), 1, "{fault}: {ended:?}");
        assert!(told[0].contains("cannot write "), "{fault}: {ended:?}");
        assert_eq!(assert_whole(&folder.path("out"), fault).rows.len(), 2, "{fault}");
        goes_on(&folder, 2);
    }
}

/// Does something to the output directory in the middle of a run, when its second row is written.
fn damaged(damage: impl Fn(&Path)) -> (Folder, Ended) {
    let folder = Folder::with(SCENE);
    let out = folder.path("out");
    let mut done = false;
    let ended = run(&folder, (2, 3), "history:0:wait:2", &[], || {
        let rows = fs::read_to_string(out.join("history.csv")).map_or(0, |t| t.lines().count());
        // The files of the first instant get their names meanwhile.
        if !done && rows == 3 && out.join("checkpoint.h5").is_file() {
            damage(&out);
            fs::write(folder.path("go"), "").expect("a folder of ours");
            done = true;
        }
    });
    assert!(done, "the run did not come to its second instant: {ended:?}");
    (folder, ended)
}

#[test]
fn a_directory_that_goes_away_in_the_middle_ends_the_run() {
    let remove = |path: &Path| fs::remove_dir_all(path).expect("a directory of ours");
    let replace = |path: &Path| {
        remove(path);
        fs::write(path, "in the way").expect("a folder of ours");
    };
    let absent = "No such file or directory";
    let file = "Not a directory";

    let (_, ended) = damaged(remove);
    let bulk = "out/fields/bulk_000002.vtkhdf";
    assert_told(ended.status, &ended.stderr, bulk, absent, "no directory");
    let (_, ended) = damaged(replace);
    assert_told(ended.status, &ended.stderr, bulk, file, "a file in its place");

    let (folder, ended) = damaged(|out| remove(&out.join("fields")));
    assert_told(ended.status, &ended.stderr, bulk, absent, "no fields");
    goes_on(&folder, 2);
    let (folder, ended) = damaged(|out| replace(&out.join("fields")));
    assert_told(ended.status, &ended.stderr, bulk, file, "a file in the place of fields");
    fs::remove_file(folder.path("out/fields")).expect("a file of ours");
    goes_on(&folder, 2);

    // Met at the third instant; the second is complete.
    let (folder, ended) = damaged(|out| {
        fs::remove_file(out.join("history.csv")).expect("a file of ours");
        fs::create_dir(out.join("history.csv")).expect("a folder of ours");
    });
    assert_told(ended.status, &ended.stderr, "history.csv", "Is a directory", "a directory");
    fs::remove_dir(folder.path("out/history.csv")).expect("a directory of ours");
    goes_on(&folder, 3);
}

/// What was damaged is repaired: the run goes on from its checkpoint, and writes the fields from
/// the instant `from` on.
fn goes_on(folder: &Folder, from: usize) {
    let again = run(folder, (3, 3), "", &["--restart", "latest"], || {});
    assert_eq!((again.status, again.stderr.as_str()), (Some(0), ""), "{again:?}");
    assert_eq!(assert_whole(&folder.path("out"), "repaired").rows.len(), 3);
    for step in from..=3 {
        let file = folder.path(&format!("out/fields/bulk_00000{step}.vtkhdf"));
        assert!(file.is_file(), "{}", file.display());
    }
}

/// Instants of the run on a small disk.
const MANY: usize = 40;

/// What happens to a small file system of its own, mounted at `disk`; `$RUN` runs the program
/// there.
fn on_a_small_disk(folder: &Folder, kilobytes: usize, script: &str) -> Output {
    let run = format!(
        "timeout -k 5 60 mpirun -n 2 --quiet {PROGRAM} case.yaml --output disk/out --quiet --set '{}'",
        instants_of(MANY)
    );
    let script = format!(
        "mount -t tmpfs -o size={kilobytes}k none disk 2>/dev/null || exit 99\n\
         run() {{ {run} \"$@\"; }}\n{script}"
    );
    fs::create_dir_all(folder.path("disk")).expect("a folder of ours");
    let own = rustix::process::geteuid().is_root();
    Command::new("unshare")
        .args(if own { &["-m"][..] } else { &["-m", "-r"] })
        .args(["bash", "-c", &script])
        .envs(common::environment())
        .current_dir(&folder.0)
        .output()
        .expect("util-linux")
}

/// Whether nobody may mount anything here, so that another test has to do.
fn is_refused(output: &Output) -> bool {
    let text = String::from_utf8_lossy(&output.stderr);
    output.status.code() == Some(99) || text.starts_with("unshare: ")
}

#[test]
fn a_disk_that_fills_up_ends_the_run_and_it_goes_on_with_room() {
    let folder = Folder::with(SCENE);
    let script = "run; echo $? >status; cp -r disk/out whole";
    if is_refused(&on_a_small_disk(&folder, 65536, script)) {
        eprintln!("nothing can be mounted here: files of limited size take the place of a disk");
        return files_that_may_not_grow_end_the_run_and_it_goes_on_with_room();
    }
    let unbroken = assert_whole(&folder.path("whole"), "unbroken");
    assert_eq!(unbroken.rows.len(), MANY);
    // Another file is the first without room each time.
    for kilobytes in [300, 328, 364, 404, 480] {
        let folder = Folder::with(SCENE);
        let output = on_a_small_disk(
            &folder,
            kilobytes,
            "run >said 2>told; echo $? >status; cp -r disk/out left\n\
             mount -o remount,size=65536k disk || exit 98\n\
             run --restart latest >&2; echo $? >again; cp -r disk/out whole",
        );
        let label = format!("{kilobytes} kB: {output:?}");
        let status = folder.read("status").trim().parse().ok();
        let told = folder.read("told");
        eprintln!("{kilobytes} kB: {told}");
        assert_told(status, &told, "", "No space left on device", &label);
        let left = assert_whole(&folder.path("left"), &label);
        assert!((1..MANY).contains(&left.rows.len()), "{label}");
        assert_begins_alike(&left, &unbroken, &label);
        assert_eq!((folder.read("again").as_str(), output.stderr.as_slice()), ("0\n", &b""[..]));
        let whole = assert_whole(&folder.path("whole"), &label);
        assert_eq!(whole.rows.len(), MANY);
        assert_begins_alike(&whole, &unbroken, &label);
    }
}

#[test]
fn a_disk_that_becomes_read_only_ends_the_run() {
    let folder = Folder::with(SCENE);
    let output = on_a_small_disk(
        &folder,
        65536,
        "COLUMN_HPC_FAULT=history:0:wait:3 run 2>told & run=$!\n\
         for i in {1..600}; do [ \"$(wc -l <disk/out/history.csv)\" = 4 ] && break; sleep 0.05; done 2>/dev/null\n\
         for i in {1..100}; do mount -o remount,ro disk 2>/dev/null && break; sleep 0.05; done\n\
         touch go; wait $run; echo $? >status; cp -r disk/out left\n\
         mount -o remount,rw disk || exit 98\n\
         run --restart latest >&2; echo $? >again; cp -r disk/out whole",
    );
    if is_refused(&output) {
        eprintln!(
            "nothing can be mounted here: a directory that is a file takes the place of a disk"
        );
        return a_directory_that_goes_away_in_the_middle_ends_the_run();
    }
    let status = folder.read("status").trim().parse().ok();
    let bulk = "fields/bulk_000003.vtkhdf";
    assert_told(status, &folder.read("told"), bulk, "Read-only file system", "read-only");
    assert_eq!(assert_whole(&folder.path("left"), "read-only").rows.len(), 3);
    assert_eq!((folder.read("again").as_str(), output.stderr.as_slice()), ("0\n", &b""[..]));
    assert_eq!(assert_whole(&folder.path("whole"), "writable again").rows.len(), MANY);
}
