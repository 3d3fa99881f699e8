//! One run over many inputs: which, how long, and what was found.

use crate::random::Random;
use std::collections::BTreeMap;
use std::env;
use std::panic::{self, AssertUnwindSafe};
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// Kinds of findings after which a run ends: two are of a kind if only their numbers differ.
const ENOUGH: usize = 25;
/// Findings of a kind that are told.
const TOLD: u64 = 3;
/// An input that takes longer hangs.
const PATIENCE: Duration = Duration::from_secs(600);

/// What a panic said, and where. Panics of both tests go there; each takes its own away.
static SAID: Mutex<String> = Mutex::new(String::new());

pub struct Run {
    name: &'static str,
    seed: u64,
    inputs: u64,
    only: Option<u64>,
    limit: Option<Duration>,
}

fn number(name: &str) -> Option<u64> {
    let text = env::var(name).ok()?;
    Some(text.replace('_', "").parse().unwrap_or_else(|_| panic!("{name}={text} is not a number")))
}

impl Run {
    /// The run that the environment asks for; `usual` inputs where it says nothing.
    pub fn new(name: &'static str, count: &str, usual: u64) -> Self {
        Run {
            name,
            seed: number("CARREAU_FUZZ_SEED").unwrap_or(1),
            inputs: number(count).unwrap_or(usual),
            only: number("CARREAU_FUZZ_ONLY"),
            limit: number("CARREAU_FUZZ_SECONDS").map(Duration::from_secs),
        }
    }

    /// Where the files of findings go.
    pub fn keep(&self) -> Option<PathBuf> {
        env::var_os("CARREAU_FUZZ_KEEP").map(PathBuf::from)
    }

    /// Tries all inputs; fails with the list of findings.
    pub fn all(&self, try_one: impl Fn(u64, &mut Random) -> Result<(), String>) {
        panic::set_hook(Box::new(|info| {
            *SAID.lock().unwrap_or_else(std::sync::PoisonError::into_inner) = info.to_string();
        }));
        let current = Arc::new(AtomicU64::new(0));
        self.watch(Arc::clone(&current));
        let start = Instant::now();
        let (mut findings, mut done, mut slowest) = (BTreeMap::<String, u64>::new(), 0u64, (Duration::ZERO, 0));
        let inputs = self.only.map_or(0..self.inputs, |k| k..k + 1);
        for k in inputs {
            current.store(k, Ordering::Relaxed);
            let begin = Instant::now();
            let tried = panic::catch_unwind(AssertUnwindSafe(|| try_one(k, &mut Random::new(self.seed, k))));
            let took = begin.elapsed();
            slowest = slowest.max((took, k));
            done += 1;
            let wrong = match tried {
                Ok(Ok(())) => None,
                Ok(Err(what)) => Some(what),
                Err(_) => Some(SAID.lock().unwrap_or_else(std::sync::PoisonError::into_inner).clone()),
            };
            if let Some(what) = wrong {
                let kind: String = what.chars().filter(|c| !c.is_ascii_digit()).collect();
                let count = findings.entry(kind).or_default();
                *count += 1;
                if *count <= TOLD {
                    eprintln!("{}: seed {} input {k}: {what}", self.name, self.seed);
                }
            }
            if findings.len() >= ENOUGH || self.limit.is_some_and(|limit| start.elapsed() > limit) {
                break;
            }
        }
        current.store(u64::MAX, Ordering::Relaxed);
        let _ = panic::take_hook();
        eprintln!(
            "{}: {done} inputs from seed {}, {} kinds of findings, {:.0} s; slowest: input {} with {:.2} s",
            self.name,
            self.seed,
            findings.len(),
            start.elapsed().as_secs_f64(),
            slowest.1,
            slowest.0.as_secs_f64()
        );
        assert!(findings.is_empty(), "findings, and how often: {findings:#?}");
    }

    /// Ends the process with a word where an input hangs: no test could tell.
    fn watch(&self, current: Arc<AtomicU64>) {
        let (name, seed) = (self.name, self.seed);
        std::thread::spawn(move || {
            let (mut last, mut since) = (0, Instant::now());
            loop {
                std::thread::sleep(Duration::from_secs(1));
                match current.load(Ordering::Relaxed) {
                    u64::MAX => return,
                    now if now != last => (last, since) = (now, Instant::now()),
                    _ if since.elapsed() > PATIENCE => {
                        eprintln!("{name}: seed {seed} input {last} hangs");
                        std::process::exit(101);
                    }
                    _ => {}
                }
            }
        });
    }
}
