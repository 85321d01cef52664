//! Which mutant is on. This file is copied into the program that is tested; nothing else refers to it.

use std::fs::OpenOptions;
use std::io::Write;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

/// Before the environment is read.
const UNREAD: u32 = u32::MAX;

/// All are off, and those that are reached are written down.
const COVER: u32 = u32::MAX - 1;

static ACTIVE: AtomicU32 = AtomicU32::new(UNREAD);
static REACHED: [AtomicBool; 1 << 15] = [const { AtomicBool::new(false) }; 1 << 15];

/// Whether mutant `n` is on: the one that the environment variable `MUTANT` names.
#[inline(always)]
pub fn on(n: u32) -> bool {
    let active = ACTIVE.load(Ordering::Relaxed);
    active == n || (active >= COVER && first_time(n, active))
}

#[cold]
#[inline(never)]
fn first_time(n: u32, active: u32) -> bool {
    if active == UNREAD {
        let number = |name| std::env::var(name).ok()?.parse().ok();
        let active = if log_name().is_some() { COVER } else { number("MUTANT").unwrap_or(0) };
        ACTIVE.store(active, Ordering::Relaxed);
        return on(n);
    }
    if !REACHED[n as usize].swap(true, Ordering::Relaxed) {
        let log = log_name().and_then(|name| OpenOptions::new().create(true).append(true).open(name).ok());
        // One write for each line: several processes share the file.
        log.map(|mut log| log.write_all(format!("{n}\n").as_bytes()));
    }
    false
}

/// The file named by `MUTANT_COVER`, for the numbers of the mutants that are reached.
fn log_name() -> Option<&'static str> {
    static NAME: OnceLock<Option<String>> = OnceLock::new();
    NAME.get_or_init(|| std::env::var("MUTANT_COVER").ok()).as_deref()
}
