//! Interrupts: Ctrl-C and SIGTERM end every command with exit code 130 and within a second. Only a proof ends alone,
//! and its run is kept.
//!
//! No file is left half-written, because unfinished files are not yet at their final names. A study is computed on a
//! thread of its own, which hands over every result as soon as it is finished. The main thread writes the files. After
//! an interrupt it does not wait for the computation that is running, however long that would take; the end of the
//! program stops it.

use std::error::Error;
use std::num::NonZero;
use std::panic::resume_unwind;
use std::process::exit;
use std::sync::Once;
use std::sync::atomic::{AtomicU8, Ordering};
use std::sync::mpsc::{RecvTimeoutError, sync_channel};
use std::thread;
use std::time::Duration;

use anyhow::Context;

use super::report::{self, INTERRUPTED};

/// The state of the program: an interrupt ends it unless a computation is [`WATCHED`], which it leaves [`STOPPED`].
static STATE: AtomicU8 = AtomicU8::new(IDLE);
const IDLE: u8 = 0;
const WATCHED: u8 = 1;
const STOPPED: u8 = 2;

/// The variable of rayon that says how many threads there are.
const THREADS: &str = "RAYON_NUM_THREADS";
/// More threads than so many on a core take time to start, and none is faster for them.
const MOST_PER_CORE: usize = 4;

/// More results than these do not wait to be written, so that they do not fill the memory.
const MOST_WAITING: usize = 64;

/// The main thread looks for an interrupt so often.
const WATCH: Duration = Duration::from_millis(20);

/// From this call on, an interrupt ends the program with exit code 130: at once, or by way of [`run_interruptible`].
pub(super) fn install() -> anyhow::Result<()> {
    watch(interrupt).context("cannot install for interrupts")
}

fn interrupt() {
    if STATE.compare_exchange(WATCHED, STOPPED, Ordering::SeqCst, Ordering::SeqCst).is_err() {
        exit(i32::from(INTERRUPTED));
    }
}

/// Calls `interrupted` for every Ctrl-C and SIGTERM, on a thread of its own. SIGHUP is left alone, so that nohup works.
/// SIGXFSZ is heard and not heeded: what is written beyond a limit is an error then, which is told like any other.
#[cfg(unix)]
fn watch(interrupted: impl Fn() + Send + 'static) -> anyhow::Result<()> {
    use signal_hook::consts::{SIGINT, SIGTERM, SIGXFSZ};
    let mut signals = signal_hook::iterator::Signals::new([SIGINT, SIGTERM, SIGXFSZ])?;
    let heeded = move || signals.forever().filter(|signal| *signal != SIGXFSZ).for_each(|_| interrupted());
    thread::Builder::new().spawn(heeded)?;
    Ok(())
}

/// Calls `interrupted` for every Ctrl-C, on a thread of its own.
#[cfg(not(unix))]
fn watch(interrupted: impl Fn() + Send + 'static) -> anyhow::Result<()> {
    Ok(ctrlc::set_handler(interrupted)?)
}

/// Does `work`, which can ask whether an interrupt has come. Such an interrupt does not end the program, but the next
/// one does.
pub(super) fn watched(work: impl FnOnce(&dyn Fn() -> bool)) {
    STATE.store(WATCHED, Ordering::SeqCst);
    work(&|| STATE.load(Ordering::SeqCst) == STOPPED);
    STATE.store(IDLE, Ordering::SeqCst);
}

/// Runs `work` on another thread and passes everything that it reports to `hear` on this thread. Returns whether an
/// interrupt came before `work` ended. Then `work` is left running, and another interrupt ends the program at once.
///
/// A system without room for the threads of a study ends the program with exit code 1.
pub(super) fn run_interruptible<T: Send + 'static>(
    work: impl FnOnce(&(dyn Fn(T) + Sync)) + Send + 'static,
    mut hear: impl FnMut(T),
) -> bool {
    start_threads();
    STATE.store(WATCHED, Ordering::SeqCst);
    let (sender, news) = sync_channel(MOST_WAITING);
    let worker = thread::Builder::new().spawn(move || work(&|one| drop(sender.send(one))));
    let worker = worker.unwrap_or_else(|error| without_threads(error));
    while STATE.load(Ordering::SeqCst) != STOPPED {
        match news.recv_timeout(WATCH) {
            Ok(one) => hear(one),
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => {
                worker.join().unwrap_or_else(|panic| resume_unwind(panic));
                return STATE.swap(IDLE, Ordering::SeqCst) == STOPPED;
            }
        }
    }
    true
}

/// Starts the threads that studies compute with. What computes with them before [`run_interruptible`] calls this first.
pub(super) fn start_threads() {
    static STARTED: Once = Once::new();
    STARTED.call_once(|| {
        // Threads that run already are no error of the system, and have no source.
        if let Err(error) = rayon::ThreadPoolBuilder::new().num_threads(threads()).build_global()
            && error.source().is_some()
        {
            without_threads(error);
        }
    });
}

/// The number of threads: that of `RAYON_NUM_THREADS` up to a limit, or 0, which stands for one on each core.
fn threads() -> usize {
    let asked = std::env::var(THREADS).ok().and_then(|text| text.parse().ok()).unwrap_or(0);
    let cores = thread::available_parallelism().map_or(1, NonZero::get);
    let most = MOST_PER_CORE * cores;
    if asked > most {
        let message = format!("{THREADS} = {asked} is more than {MOST_PER_CORE} threads for each of {cores} cores");
        report::warn(&format!("{message}: {most} are started"));
    }
    asked.min(most)
}

fn without_threads(error: impl Into<anyhow::Error>) -> ! {
    let error = error.into().context("cannot start the threads of a study");
    exit(i32::from(report::explain(&error)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_of_the_work_is_one_of_the_program() {
        let panics =
            std::panic::catch_unwind(|| run_interruptible(|_: &(dyn Fn(()) + Sync)| panic!("on purpose"), |()| {}));
        assert!(panics.is_err());
    }
}
