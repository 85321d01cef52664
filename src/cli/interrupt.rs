//! Interrupts (Ctrl-C): exit code 130, and nothing half-written, because unfinished files have no name yet.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::Context;

/// The exit code of an interrupted command.
pub(super) const INTERRUPTED: u8 = 130;

/// An interrupt ends the program at once.
pub(super) fn end_at_once() -> anyhow::Result<()> {
    ctrlc::set_handler(|| std::process::exit(i32::from(INTERRUPTED))).context("cannot listen for interrupts")
}

/// The first interrupt raises the flag that is returned, a second one ends the program at once.
pub(super) fn flag() -> anyhow::Result<Arc<AtomicBool>> {
    let flag = Arc::new(AtomicBool::new(false));
    let raised = Arc::clone(&flag);
    ctrlc::set_handler(move || {
        if raised.swap(true, Ordering::Relaxed) {
            std::process::exit(i32::from(INTERRUPTED));
        }
    })
    .context("cannot listen for interrupts")?;
    Ok(flag)
}
