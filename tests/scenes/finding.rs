//! Scenes of a seed, their smallest forms that still fail, and the cases made of them.

use crate::hold::{Failure, Known, Verdict, hold};
use crate::launch::Setting;
use crate::relations::{Relation, pair};
use crate::scene::{Scene, scenes};
use proptest::strategy::{Strategy, ValueTree};
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};
use std::fs;
use std::path::Path;
use std::time::{Duration, Instant};

/// Attempts at a smaller scene: what is left after them is small enough to look at.
const ATTEMPTS: usize = 300;

/// As long as a finding is made smaller.
const PATIENCE: Duration = Duration::from_secs(45);

/// The scene of a seed, and the way to smaller ones.
pub fn tree(seed: u64) -> impl ValueTree<Value = Scene> {
    let mut bytes = [0; 32];
    bytes[..8].copy_from_slice(&seed.to_le_bytes());
    let rng = TestRng::from_seed(RngAlgorithm::ChaCha, &bytes);
    let mut runner = TestRunner::new_with_rng(Config::default(), rng);
    scenes().new_tree(&mut runner).expect("nothing is filtered")
}

/// The smallest scene found that fails in the same way.
pub fn shrink(seed: u64, relation: Relation, failure: Failure) -> (Scene, Failure) {
    let mut tree = tree(seed);
    let mut best = (tree.current(), failure);
    let start = Instant::now();
    if !tree.simplify() {
        return best;
    }
    for _ in 0..ATTEMPTS {
        if start.elapsed() > PATIENCE {
            break;
        }
        let scene = tree.current();
        let further = match hold(relation, &scene, &mut Known::default()) {
            Some(Verdict::Broken(failure)) if failure.values == best.1.values => {
                best = (scene, failure);
                tree.simplify()
            }
            _ => tree.complicate(),
        };
        if !further {
            break;
        }
    }
    best
}

/// Writes the case of a seed; returns its place below the package.
pub fn write_case(seed: u64) -> String {
    let scene = tree(seed).current();
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let place = format!("results/scenes/{seed}.yaml");
    fs::create_dir_all(root.join("results/scenes")).expect("the package is writable");
    let text = format!("# Scene of seed {seed}: {}\n{}", scene.words(), scene.build().case.yaml());
    fs::write(root.join(&place), text).expect("the package is writable");
    place
}

/// Writes the two cases of a finding; returns the place of the first below the package.
pub fn write(seed: u64, relation: Relation, scene: &Scene, failure: &Failure) -> String {
    let built = scene.build();
    let pair = pair(relation, scene, &built).expect("it applies");
    let name = format!("{seed}_{}", relation.name());
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let place = root.join("results/scenes");
    fs::create_dir_all(&place).expect("the package is writable");
    let commands = |case, setting: &Setting, file: &str| {
        let lines = setting.commands(case, file);
        lines.iter().map(|l| format!("#     {}\n", l.trim_end())).collect::<String>()
    };
    let (file, other) = (format!("{name}.yaml"), format!("{name}_other.yaml"));
    let second = if pair.other == pair.base { &file } else { &other };
    let against = match relation {
        Relation::Exact => String::new(),
        _ => format!("# against\n{}", commands(&pair.other, &pair.setting, second)),
    };
    let words = failure.words.replace('\n', "\n#   ");
    let head = format!(
        "# Scene of seed {seed}. Broken: {}.\n# Seen: {words}\n{}{against}",
        relation.words(),
        commands(&pair.base, &pair.base_setting, &file),
    );
    let save = |file: &str, text: String| {
        fs::write(place.join(file), text).expect("the package is writable");
    };
    save(&file, format!("{head}{}", pair.base.yaml()));
    if second == &other {
        save(&other, format!("{head}{}", pair.other.yaml()));
    }
    format!("results/scenes/{file}")
}
