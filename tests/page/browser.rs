//! Runs the program, and what a browser makes of its page.

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::{Duration, Instant};
use std::{env, fs, thread};

use serde_json::Value;

use super::common;

pub const PROGRAM: &str = env!("CARGO_BIN_EXE_column-hpc");
const WITH_FAULTS: &str = env!("CARGO_BIN_EXE_column-hpc-faults");
const PROBE: &str = include_str!("probe.js");

/// Colours of what was computed and of the law.
const COMPUTED: &str = "#0072B2";
const LAW: &str = "#E69F00";

pub struct Folder(PathBuf);

impl Folder {
    pub fn new() -> Self {
        static NUMBER: AtomicU32 = AtomicU32::new(0);
        let number = NUMBER.fetch_add(1, Ordering::Relaxed);
        let path = env::temp_dir().join(format!("column-hpc-page-{}-{number}", std::process::id()));
        fs::create_dir_all(&path).expect("the temporary directory is writable");
        Self(path)
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    /// Runs a case with the options; `fault` is one of the injector's, or nothing.
    pub fn run(&self, case: &str, fault: &str, options: &[&str]) -> Output {
        Command::new(if fault.is_empty() { PROGRAM } else { WITH_FAULTS })
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
    pub fn page(&self, case: &str, fault: &str, options: &[&str], status: i32) -> Page {
        let options: Vec<&str> = ["--report"].iter().chain(options).copied().collect();
        let answer = self.run(case, fault, &options);
        let told = String::from_utf8_lossy(&answer.stderr);
        assert_eq!(answer.status.code(), Some(status), "{case}: {told}");
        self.look(|html| html)
    }

    /// What the page is in a browser, after a change.
    pub fn look(&self, change: impl Fn(String) -> String) -> Page {
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

pub fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

pub fn point(value: &Value) -> (f64, f64) {
    (number(&value[0]), number(&value[1]))
}

pub struct Page(pub Value);

impl Page {
    pub fn charts(&self) -> &[Value] {
        self.0["charts"].as_array().expect("charts")
    }

    pub fn ids(&self) -> Vec<&str> {
        self.charts().iter().map(|chart| chart["id"].as_str().expect("a name")).collect()
    }

    pub fn chart(&self, id: &str) -> &Value {
        let found = self.charts().iter().find(|chart| chart["id"] == id);
        found.unwrap_or_else(|| panic!("no {id} among {:?}", self.ids()))
    }

    pub fn says(&self, words: &str) {
        let text = self.0["text"].as_str().expect("the text");
        assert!(text.contains(words), "no `{words}` in\n{text}");
    }

    /// Nothing is lost, cut off, unreadable or fetched.
    pub fn is_sound(&self) {
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
            let is_scene = number(&chart["paths"]) > 0.0;
            assert!(words >= if is_scene { 6 } else { 8 }, "{id}: {words} texts");
            assert_eq!(number(&chart["strays"]), 0.0, "{id}: areas and lines outside");
            let fonts = number(&chart["fonts"]);
            assert!(!is_scene || fonts >= 11.0, "{id}: text of {fonts} pixels");
        }
    }

    /// The circles of what was computed, without that of the legend.
    pub fn circles(&self, id: &str, legends: usize) -> Vec<(f64, f64)> {
        let circles = self.chart(id)["circles"].as_array().expect("circles").iter();
        let mut all: Vec<_> =
            circles.filter(|c| c["color"] == COMPUTED).map(|c| point(&c["at"])).collect();
        all.truncate(all.len() - legends);
        all
    }

    /// How far the farthest point is from the band of the law, in pixels.
    pub fn farthest_from_law(&self, id: &str) -> f64 {
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
