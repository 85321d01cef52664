//! Interrupts: Ctrl-C and SIGTERM end every command with exit code 130 and within a second.
//!
//! Nothing is left half-written, because unfinished files have no name yet. A study is computed on a thread of its own,
//! which hands over what is finished as it goes: the main thread, which writes the files, need not wait for a computation
//! that is under way, however long it takes, but leaves it to the end of the program.

use std::panic::resume_unwind;
use std::process::{ExitCode, exit};
use std::sync::mpsc::{Sender, channel};
use std::sync::{Mutex, PoisonError};
use std::thread;

use anyhow::Context;

use super::report;

/// The exit code of an interrupted command.
pub(super) const INTERRUPTED: u8 = 130;

/// Who is told of the first interrupt. Without anyone an interrupt ends the program.
static LISTENER: Mutex<Option<Box<dyn FnOnce() + Send>>> = Mutex::new(None);

fn set_listener(listener: Option<Box<dyn FnOnce() + Send>>) -> Option<Box<dyn FnOnce() + Send>> {
    std::mem::replace(&mut *LISTENER.lock().unwrap_or_else(PoisonError::into_inner), listener)
}

/// From here on an interrupt ends the program, at once or by the way of [`beside_it`].
pub(super) fn listen() -> anyhow::Result<()> {
    watch(|| match set_listener(None) {
        Some(listener) => listener(),
        None => exit(i32::from(INTERRUPTED)),
    })
    .context("cannot listen for interrupts")
}

/// The end of a study that was interrupted before it had anything to write: the files of an earlier one stay.
pub(super) fn before_any_result() -> ExitCode {
    report::warn("interrupted before anything was finished: no file was written");
    ExitCode::from(INTERRUPTED)
}

/// Calls `interrupted` for every Ctrl-C and SIGTERM, on a thread of its own. SIGHUP keeps its meaning, for nohup.
#[cfg(unix)]
fn watch(interrupted: impl Fn() + Send + 'static) -> anyhow::Result<()> {
    use signal_hook::consts::{SIGINT, SIGTERM};
    let mut signals = signal_hook::iterator::Signals::new([SIGINT, SIGTERM])?;
    thread::spawn(move || signals.forever().for_each(|_| interrupted()));
    Ok(())
}

/// Calls `interrupted` for every Ctrl-C, on a thread of its own.
#[cfg(not(unix))]
fn watch(interrupted: impl Fn() + Send + 'static) -> anyhow::Result<()> {
    Ok(ctrlc::set_handler(interrupted)?)
}

/// What happens beside the main thread.
enum Event<T> {
    News(T),
    Ended,
    Interrupted,
}

/// Tells of its end, however it comes about.
struct Ending<T>(Sender<Event<T>>);

impl<T> Drop for Ending<T> {
    fn drop(&mut self) {
        // Nobody listens after an interrupt.
        let _ = self.0.send(Event::Ended);
    }
}

/// Does `work` on another thread and hands everything that it tells to `hear` on this one, until it ends or is
/// interrupted: whether it was. After an interrupt it is left alone, and another one ends the program at once.
pub(super) fn beside_it<T: Send + 'static>(
    work: impl FnOnce(&(dyn Fn(T) + Sync)) + Send + 'static,
    mut hear: impl FnMut(T),
) -> bool {
    let (sender, events) = channel();
    let interrupts = sender.clone();
    set_listener(Some(Box::new(move || drop(interrupts.send(Event::Interrupted)))));
    let worker = thread::spawn(move || {
        let ending = Ending(sender);
        work(&|news| drop(ending.0.send(Event::News(news))));
    });
    for event in events {
        match event {
            Event::News(news) => hear(news),
            Event::Interrupted => return true,
            Event::Ended => break,
        }
    }
    set_listener(None);
    worker.join().unwrap_or_else(|panic| resume_unwind(panic));
    false
}

#[cfg(test)]
mod tests {
    use super::*;

    // One test: the listener is one for the whole program.
    #[test]
    fn work_is_heard_until_it_ends_or_is_interrupted() {
        let mut heard = Vec::new();
        let interrupted = beside_it(|tell| (0..3).for_each(tell), |news| heard.push(news));
        assert!(!interrupted && heard == [0, 1, 2]);
        assert!(set_listener(None).is_none(), "nobody listens to a computation that has ended");

        let mut heard = 0;
        let interrupted = beside_it(
            |tell| {
                tell(1);
                set_listener(None).expect("a computation is listened to")();
                // As long as a computation may take.
                thread::park();
            },
            |news| heard += news,
        );
        assert!(interrupted && heard == 1);

        let panics = std::panic::catch_unwind(|| beside_it(|_: &(dyn Fn(()) + Sync)| panic!("on purpose"), |()| {}));
        assert!(panics.is_err());
    }
}
