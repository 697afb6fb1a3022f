//! Pages of runs, looked at in a browser: what is drawn, where it is, and that nothing is fetched.

mod common;

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::{Duration, Instant};
use std::{env, fs, thread};

use serde_json::Value;

const PROGRAM: &str = env!("CARGO_BIN_EXE_column-hpc");
const PROBE: &str = include_str!("page_probe.js");

/// Colours of what was computed and of the law.
const COMPUTED: &str = "#0072B2";
const LAW: &str = "#E69F00";

struct Folder(PathBuf);

impl Folder {
    fn new() -> Self {
        static NUMBER: AtomicU32 = AtomicU32::new(0);
        let number = NUMBER.fetch_add(1, Ordering::Relaxed);
        let path = env::temp_dir().join(format!("column-hpc-page-{}-{number}", std::process::id()));
        fs::create_dir_all(&path).expect("the temporary directory is writable");
        Self(path)
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    /// Runs a case with the options; `fault` is one of the injector's, or nothing.
    fn run(&self, case: &str, fault: &str, options: &[&str]) -> Output {
        Command::new(PROGRAM)
            .arg(Path::new(env!("CARGO_MANIFEST_DIR")).join("cases").join(case))
            .arg("--output")
            .arg(self.path("out"))
            .args(options)
            .envs(common::environment())
            .env("COLUMN_HPC_FAULT", fault)
            .stdin(Stdio::null())
            .output()
            .expect("the program")
    }

    /// As [`Folder::run`] with a page, whose end is to be `status`.
    fn page(&self, case: &str, fault: &str, options: &[&str], status: i32) -> Page {
        let options: Vec<&str> = ["--report"].iter().chain(options).copied().collect();
        let answer = self.run(case, fault, &options);
        let told = String::from_utf8_lossy(&answer.stderr);
        assert_eq!(answer.status.code(), Some(status), "{case}: {told}");
        self.look(|html| html)
    }

    /// What the page is in a browser, after a change.
    fn look(&self, change: impl Fn(String) -> String) -> Page {
        let html = fs::read_to_string(self.path("out/report.html")).expect("a page");
        assert!(html.ends_with("</html>\n"));
        Page(browse(&self.0, &change(html)))
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// What the probe finds in a page.
fn browse(folder: &Path, html: &str) -> Value {
    // The page forbids scripts; a copy may have one.
    let start = html.find("<meta http-equiv").expect("a policy");
    let end = start + html[start..].find('>').expect("its end") + 1;
    let script = format!("<script>{PROBE}</script>");
    let copy = folder.join("probed.html");
    fs::write(&copy, format!("{}{script}{}", &html[..start], &html[end..]))
        .expect("a file of ours");
    let profile = folder.join("profile");
    let _ = fs::remove_dir_all(&profile);
    let dom = folder.join("dom.html");
    let mut browser = Command::new("chromium")
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run"])
        .args(["--disable-background-networking", "--disable-component-update", "--disable-sync"])
        // Nothing but the page is asked for anything.
        .args(["--host-resolver-rules=MAP * ~NOTFOUND", "--window-size=1280,2000"])
        .arg(format!("--user-data-dir={}", profile.display()))
        .args(["--virtual-time-budget=2000", "--dump-dom"])
        .arg(format!("file://{}", copy.display()))
        .stdin(Stdio::null())
        .stdout(fs::File::create(&dom).expect("a file of ours"))
        .stderr(Stdio::null())
        .spawn()
        .expect("chromium is on the PATH (Debian: chromium)");
    let end = Instant::now() + Duration::from_secs(60);
    while browser.try_wait().expect("a child of ours").is_none() {
        if Instant::now() > end {
            let _ = browser.kill();
            let _ = browser.wait();
            panic!("chromium was ended after 60 s");
        }
        thread::sleep(Duration::from_millis(10));
    }
    let dom = fs::read_to_string(dom).expect("the page as it was shown");
    let found = dom.split_once("<pre id=\"found\">").expect("the probe ran").1;
    let found = found.split_once("</pre>").expect("all of it").0;
    let text = found.replace("&lt;", "<").replace("&gt;", ">").replace("&nbsp;", "\u{a0}");
    serde_json::from_str(&text.replace("&amp;", "&")).expect("JSON of the probe")
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

fn point(value: &Value) -> (f64, f64) {
    (number(&value[0]), number(&value[1]))
}

struct Page(Value);

impl Page {
    fn charts(&self) -> &[Value] {
        self.0["charts"].as_array().expect("charts")
    }

    fn ids(&self) -> Vec<&str> {
        self.charts().iter().map(|chart| chart["id"].as_str().expect("a name")).collect()
    }

    fn chart(&self, id: &str) -> &Value {
        let found = self.charts().iter().find(|chart| chart["id"] == id);
        found.unwrap_or_else(|| panic!("no {id} among {:?}", self.ids()))
    }

    fn says(&self, words: &str) {
        let text = self.0["text"].as_str().expect("the text");
        assert!(text.contains(words), "no `{words}` in\n{text}");
    }

    /// Nothing is lost, cut off, unreadable or fetched.
    fn is_sound(&self) {
        assert_eq!(self.0["requests"], Value::Array(Vec::new()));
        assert!(number(&self.0["wider"]) <= 0.0, "the page is wider than its window");
        assert!(number(&self.0["contrast"]) >= 4.5, "contrast {}", self.0["contrast"]);
        for chart in self.charts() {
            let id = &chart["id"];
            assert_eq!(number(&chart["lost"]), 0.0, "{id}: coordinates outside");
            for fault in ["outside", "clashes"] {
                assert_eq!(chart[fault], Value::Array(Vec::new()), "{id}: {fault}");
            }
            assert_eq!(chart["overflows"], false, "{id}");
            assert!(number(&chart["contrast"]) >= 7.0, "{id}: contrast {}", chart["contrast"]);
            let words = chart["words"].as_array().expect("words").len();
            assert!(words >= 8, "{id}: {words} texts");
        }
    }

    /// The circles of what was computed, without that of the legend.
    fn circles(&self, id: &str, legends: usize) -> Vec<(f64, f64)> {
        let circles = self.chart(id)["circles"].as_array().expect("circles").iter();
        let mut all: Vec<_> =
            circles.filter(|c| c["color"] == COMPUTED).map(|c| point(&c["at"])).collect();
        all.truncate(all.len() - legends);
        all
    }

    /// How far the farthest point is from the band of the law, in pixels.
    fn farthest_from_law(&self, id: &str) -> f64 {
        let lines = self.chart(id)["lines"].as_array().expect("lines").iter();
        let bands: Vec<Vec<(f64, f64)>> = lines
            .filter(|line| line["color"] == LAW)
            .map(|line| line["points"].as_array().expect("points").iter().map(point).collect())
            .collect();
        // One for each panel, and one in the legend.
        assert_eq!(bands.len(), 1 + number(&self.chart(id)["panels"]) as usize, "{id}");
        let to_band = |p: &(f64, f64)| {
            let pieces = bands.iter().flat_map(|band| band.windows(2));
            pieces.map(|pair| distance(*p, pair[0], pair[1])).fold(f64::INFINITY, f64::min)
        };
        self.circles(id, 1).iter().map(to_band).fold(0.0, f64::max)
    }
}

fn distance(p: (f64, f64), a: (f64, f64), b: (f64, f64)) -> f64 {
    let (dx, dy) = (b.0 - a.0, b.1 - a.1);
    let length = dx * dx + dy * dy;
    let share = ((p.0 - a.0) * dx + (p.1 - a.1) * dy) / length.max(1e-9);
    let share = share.clamp(0.0, 1.0);
    (p.0 - a.0 - share * dx).hypot(p.1 - a.1 - share * dy)
}

#[test]
fn a_run_that_is_stopped_and_goes_on_has_a_page_each_time() {
    let folder = Folder::new();
    let stopped = folder.page("wtnv146/case.yaml", "history:0:term:4", &[], 75);
    stopped.is_sound();
    assert_eq!(stopped.0["status"], "status wait");
    stopped.says("stopped after 4 of 8 instants");
    stopped.says("Not compared: the run did not come to its end.");
    assert_eq!(stopped.circles("interface-joint", 1).len(), 4);

    let whole = folder.page("wtnv146/case.yaml", "", &["--restart", "latest"], 0);
    whole.is_sound();
    assert_eq!(whole.0["title"], "WTNV146 in 3D");
    assert_eq!(whole.0["status"], "status good");
    whole.says("done, all 43 expectations met");
    assert_eq!((number(&whole.0["outcomes"]), number(&whole.0["missed"])), (43.0, 0.0));
    let expected = ["interface-joint", "load", "damage", "probes", "energy", "convergence"];
    assert_eq!(whole.ids(), expected);
    // It opens and slides: eight instants in two panels, all on the law, softening and unloading.
    assert_eq!(whole.circles("interface-joint", 1).len(), 16);
    assert!(whole.farthest_from_law("interface-joint") < 1.0);
    // The undeformed state, and the instants.
    assert_eq!(whole.circles("load", 0).len(), 9);
    // Corrections and residuals.
    assert_eq!(whole.circles("convergence", 0).len(), 16);
    let words = |id: &str| -> Vec<&str> {
        let words = whole.chart(id)["words"].as_array().expect("words");
        words.iter().map(|word| word.as_str().expect("text")).collect()
    };
    for (id, label) in [
        ("interface-joint", "normal jump [mm]"),
        ("interface-joint", "normal traction [MPa]"),
        ("interface-joint", "shear traction along x [MPa]"),
        ("load", "displacement z of top [mm]"),
        ("load", "reaction z of top [MN]"),
        ("energy", "energy [J]"),
        ("convergence", "forces out of balance [N]"),
    ] {
        assert!(words(id).contains(&label), "{id}: {:?}", words(id));
    }

    // In the dark, whatever the screen of the machine.
    let dark = folder.look(|html| {
        assert_eq!(html.matches("@media(prefers-color-scheme:dark)").count(), 1);
        html.replace("@media(prefers-color-scheme:dark)", "@media all")
    });
    dark.is_sound();

    // The probe sees what is wrong.
    let wrong = folder.look(|html| {
        html.replacen("</h1>", "</h1><img src=\"http://127.0.0.1:9/picture.png\" alt=\"\">", 1)
            .replacen("\nnormal jump [mm]", &"normal jump [mm]".repeat(20), 1)
            .replacen("<circle cx=\"", "<circle cx=\"9", 1)
            .replacen("--soft:#5c5c5c", "--soft:#cccccc", 1)
    });
    assert_eq!(wrong.0["requests"][0], "http://127.0.0.1:9/picture.png");
    assert!(number(&wrong.0["contrast"]) < 4.5);
    let chart = wrong.chart("interface-joint");
    assert_eq!(number(&chart["lost"]), 1.0);
    for fault in ["outside", "clashes"] {
        assert!(!chart[fault].as_array().expect("a list").is_empty(), "{fault}");
    }
    assert!(wrong.farthest_from_law("interface-joint") > 100.0);

    // A run that is not asked for a page leaves none of another.
    assert_eq!(folder.run("wtnv146/case.yaml", "", &[]).status.code(), Some(0));
    assert!(!folder.path("out/report.html").exists());
}

#[test]
fn a_run_that_fails_has_a_page_that_says_why() {
    let folder = Folder::new();
    // A force that nothing holds once the interface is broken.
    let torn = "boundary.1={on: top, traction: {z: {table: [[0, 0], [8, 3.0e+6]]}}}";
    let page = folder.page("wtnv146/case.yaml", "", &["--set", torn, "--set", "expect=[]"], 3);
    page.is_sound();
    assert_eq!(page.0["status"], "status bad");
    page.says("failed after 2 of 8 instants");
    let report = fs::read_to_string(folder.path("out/report.json")).expect("a report");
    let report: Value = serde_json::from_str(&report).expect("whole JSON");
    let message = report["message"].as_str().expect("a message");
    page.says(message.lines().next().expect("words"));
    assert_eq!(page.circles("interface-joint", 1).len(), 2);
    assert!(page.farthest_from_law("interface-joint") < 1.0);

    // In its first step: nothing to draw, and a page all the same.
    let torn = "boundary.1={on: top, traction: {z: 3.0e+6}}";
    let options = ["--overwrite", "--set", torn, "--set", "expect=[]"];
    let page = folder.page("wtnv146/case.yaml", "", &options, 3);
    page.is_sound();
    page.says("failed after 0 of 8 instants");
    page.says("No instant was reached");
    assert!(page.charts().is_empty());
}

#[test]
fn interfaces_paths_and_fluids_have_their_charts() {
    let folder = Folder::new();
    let missed = "expect.0.equals=12345.0";
    let page = folder.page("two_interfaces/case.yaml", "", &["--set", missed], 1);
    page.is_sound();
    assert_eq!(page.0["status"], "status bad");
    assert_eq!(number(&page.0["missed"]), 1.0);
    page.says("12345");
    for id in ["interface-strong", "interface-weak"] {
        assert_eq!(page.circles(id, 1).len(), 5);
        assert!(page.farthest_from_law(id) < 1.0, "{id}");
    }

    // A law whose answer depends on the step, in a mixed mode.
    let page = folder.page("laws/benzeggagh_kenane.yaml", "", &["--overwrite"], 0);
    page.is_sound();
    assert_eq!(page.circles("interface-joint", 1).len(), 26);
    assert!(page.farthest_from_law("interface-joint") < 1.0);

    let case = "snap_back/column_50m_dissipation.yaml";
    let page = folder.page(case, "", &["--overwrite"], 0);
    page.is_sound();
    page.says("The displacement is what the case prescribes times the load factor.");
    assert!(page.ids().contains(&"load-factor"), "{:?}", page.ids());
    assert!(page.farthest_from_law("interface-joint") < 1.0);
    // Snap-back: the displacement falls together with the reaction.
    let load = page.circles("load", 0);
    assert_eq!(load.len(), 22);
    assert!(load[1..].windows(2).all(|pair| pair[1].0 < pair[0].0 && pair[1].1 > pair[0].1));

    let page = folder.page("injection/case.yaml", "", &["--overwrite"], 0);
    page.is_sound();
    page.says("Warnings");
    page.says("The traction is the effective one");
    for id in ["pressure", "flux", "mass"] {
        assert!(page.ids().contains(&id), "{:?}", page.ids());
    }
    assert!(page.farthest_from_law("interface-joint") < 1.0);
}

#[test]
fn a_page_that_cannot_be_written_is_told_once_and_leaves_nothing() {
    let folder = Folder::new();
    fs::create_dir_all(folder.path("out/report.html")).expect("a folder of ours");
    let answer = folder.run("wtnv146/case_2d.yaml", "", &["--report"]);
    let told = String::from_utf8_lossy(&answer.stderr);
    assert_eq!(answer.status.code(), Some(4), "{told}");
    assert_eq!(told.lines().count(), 1, "{told}");
    assert!(
        told.contains("cannot write") && told.contains("report.html: Is a directory"),
        "{told}"
    );
    let report = fs::read_to_string(folder.path("out/report.json")).expect("a report");
    assert!(report.contains("\"status\": \"done\""));
    let left = fs::read_dir(folder.path("out")).expect("the directory").flatten();
    assert!(left.into_iter().all(|entry| !entry.file_name().to_string_lossy().contains(".tmp.")));

    // The same on several ranks, of which one writes.
    let case = Path::new(env!("CARGO_MANIFEST_DIR")).join("cases/wtnv146/case_2d.yaml");
    let [case, out] = [case, folder.path("several")];
    let args =
        [case.to_str().expect("a name"), "--report", "--output", out.to_str().expect("ours")];
    assert_eq!(common::mpirun(2, PROGRAM, &args).status.code(), Some(0));
    let html = fs::read_to_string(out.join("report.html")).expect("a page");
    assert!(html.contains("<dt>ranks</dt><dd>2</dd>"));
}
