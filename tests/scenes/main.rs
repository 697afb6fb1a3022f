//! Random scenes, held against relations that must not matter and against closed forms.
//!
//! Without words it holds a fixed set of scenes; `look` goes on looking (`scripts/scenes.sh`).

#![allow(clippy::print_stdout)] // the runner's own report

mod build;
mod case;
mod change;
mod closed;
#[path = "../common/mod.rs"]
#[allow(dead_code)] // this program uses a part of it
mod common;
mod compare;
mod finding;
mod hold;
mod launch;
mod relations;
mod scene;

use clap::Parser;
use hold::{Known, Verdict, hold};
use relations::Relation;
use std::collections::{BTreeMap, BTreeSet};
use std::process::ExitCode;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::thread;
use std::time::{Duration, Instant};

/// Scenes of the usual tests.
const FIXED: u64 = 40;

/// Scenes at the same time: more would fight for the cores.
const WORKERS: usize = 2;

/// Random scenes, held against relations that must not matter and against closed forms.
#[derive(Parser)]
#[command(name = "scenes")]
struct Words {
    /// The first scene; the others follow it.
    #[arg(long, default_value_t = 1000)]
    seed: u64,
    /// Scenes to try; without it and without minutes 100.
    #[arg(long)]
    count: Option<u64>,
    /// Minutes after which no further scene is begun.
    #[arg(long)]
    minutes: Option<f64>,
    /// This relation alone.
    #[arg(long)]
    relation: Option<String>,
    /// As many scenes at the same time.
    #[arg(long, default_value_t = WORKERS)]
    workers: usize,
    /// Findings are written as they are, not shrunk.
    #[arg(long)]
    as_found: bool,
    /// The relations of the usual tests alone.
    #[arg(long)]
    choice: bool,
    /// The cases are written, not run.
    #[arg(long)]
    cases: bool,
}

/// What was found of how many.
#[derive(Default)]
struct Tally {
    held: BTreeMap<String, usize>,
    skipped: BTreeMap<String, usize>,
    broken: Vec<String>,
    /// Of what is broken.
    seeds: BTreeSet<u64>,
    scenes: usize,
}

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().collect();
    let looking = words.get(1).is_some_and(|word| word == "look");
    let words = if looking {
        Words::parse_from(&words[1..])
    } else {
        Words::parse_from([
            "fixed",
            "--seed",
            "1",
            "--count",
            &FIXED.to_string(),
            "--choice",
            "--as-found",
        ])
    };
    let only = words.relation.as_ref().map(|name| {
        Relation::named(name).unwrap_or_else(|| {
            let known = Relation::ALL.map(Relation::name).join(", ");
            println!("{name} is none of the relations: {known}");
            std::process::exit(2)
        })
    });
    let start = Instant::now();
    let limit = words.minutes.map(|m| Duration::from_secs_f64(60.0 * m));
    let endless = limit.is_some() && !words.cases;
    let count = words.count.unwrap_or(if endless { u64::MAX } else { 100 });
    let (next, tally) = (AtomicU64::new(0), Mutex::new(Tally::default()));
    let panics = AtomicUsize::new(0);
    if words.cases {
        (0..count).for_each(|turn| println!("{}", finding::write_case(words.seed + turn)));
        return ExitCode::SUCCESS;
    }
    thread::scope(|scope| {
        for _ in 0..words.workers {
            scope.spawn(|| {
                loop {
                    let turn = next.fetch_add(1, Ordering::Relaxed);
                    if turn >= count || limit.is_some_and(|l| start.elapsed() > l) {
                        break;
                    }
                    let seed = words.seed + turn;
                    let tried = std::panic::catch_unwind(|| try_seed(seed, only, &words));
                    match tried {
                        Ok(one) => report(seed, one, &mut tally.lock().expect("no panic in it")),
                        Err(_) => {
                            panics.fetch_add(1, Ordering::Relaxed);
                            println!("seed {seed}: a panic, see above");
                        }
                    }
                }
            });
        }
    });
    let tally = tally.into_inner().expect("no panic in it");
    summary(&tally, start.elapsed());
    let clean = tally.seeds.is_empty() && panics.into_inner() == 0;
    if clean { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// A scene, in words, with the verdicts of its relations.
struct Tried {
    scene: String,
    verdicts: Vec<(Relation, Verdict)>,
}

fn try_seed(seed: u64, only: Option<Relation>, words: &Words) -> Tried {
    let tree = finding::tree(seed);
    let scene = proptest::strategy::ValueTree::current(&tree);
    let mut known = Known::default();
    let mut verdicts = Vec::new();
    for (index, relation) in Relation::ALL.into_iter().enumerate() {
        // A third of them for each, another one for the next scene.
        let always = matches!(relation, Relation::Exact | Relation::BelowStrength);
        let chosen = !words.choice || always || (index as u64 + seed).is_multiple_of(4);
        if only.is_some_and(|o| o != relation) || !chosen {
            continue;
        }
        let Some(mut verdict) = hold(relation, &scene, &mut known) else { continue };
        if let Verdict::Broken(failure) = verdict {
            let (shrunk, failure) = if words.as_found {
                (scene.clone(), failure)
            } else {
                finding::shrink(seed, relation, failure)
            };
            let place = finding::write(seed, relation, &shrunk, &failure);
            let words = format!("{} [{place}]", failure.words);
            verdict = Verdict::Broken(hold::Failure { words, ..failure });
        }
        // What fails by itself says nothing about the others.
        let fails = always && matches!(&verdict, Verdict::Broken(failure) if !failure.values);
        verdicts.push((relation, verdict));
        if fails {
            break;
        }
    }
    Tried { scene: scene.words(), verdicts }
}

fn report(seed: u64, tried: Tried, tally: &mut Tally) {
    tally.scenes += 1;
    println!("seed {seed}: {}", tried.scene);
    let mut held = Vec::new();
    let mut skipped: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for (relation, verdict) in tried.verdicts {
        let name = relation.name();
        match verdict {
            Verdict::Held => {
                *tally.held.entry(name.clone()).or_default() += 1;
                held.push(name);
            }
            Verdict::Skipped(why) => {
                *tally.skipped.entry(why.chars().take(60).collect()).or_default() += 1;
                skipped.entry(why).or_default().push(name);
            }
            Verdict::Broken(failure) => {
                let kind = if failure.values { "values" } else { "status" };
                println!("    BROKEN  {name} ({kind}): {}", failure.words);
                tally.seeds.insert(seed);
                tally.broken.push(format!("seed {seed}, {name} ({kind}): {}", failure.words));
            }
        }
    }
    for (why, names) in skipped {
        println!("    skipped {}: {why}", names.join(" "));
    }
    if !held.is_empty() {
        println!("    held    {}", held.join(" "));
    }
}

fn summary(tally: &Tally, spent: Duration) {
    let sum = |of: &BTreeMap<String, usize>| of.values().sum::<usize>();
    let list = |of: &BTreeMap<String, usize>| {
        of.iter().map(|(name, n)| format!("{name} {n}")).collect::<Vec<_>>().join(", ")
    };
    println!("\n{} scenes in {:.0} s", tally.scenes, spent.as_secs_f64());
    println!("held {}: {}", sum(&tally.held), list(&tally.held));
    println!("skipped {}: {}", sum(&tally.skipped), list(&tally.skipped));
    println!("broken {}", tally.broken.len());
    for words in &tally.broken {
        println!("    {words}");
    }
}
