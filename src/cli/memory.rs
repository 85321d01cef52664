//! Checks before a run that there is enough memory for it. Otherwise the operating system might kill the program in the
//! middle of the run.

use std::fs;
use std::num::NonZero;
use std::thread::available_parallelism;

use geodesic_ivp::number::Real;
use geodesic_ivp::solve::{Settings, Setup, bytes_needed};

use super::report;

/// The room in megabytes that a command needs besides what is counted, and once more for each thread of a study: for a
/// stack, and for the space that the system reserves for its small allocations.
const ROOM: f64 = 128.0;

/// Refuses to begin where a limit of address space leaves too little for what is counted nowhere, in one thread or in
/// one for each core: without that room the program would be aborted in the middle.
pub(super) fn require_room(all_cores: bool) -> anyhow::Result<()> {
    let threads = if all_cores { available_parallelism().map_or(1, NonZero::get) } else { 0 };
    let least = ROOM * (1 + threads) as f64;
    let Some(left) = address_space().map(|bytes| bytes / 1e6).filter(|left| *left < least) else { return Ok(()) };
    let message = format!("a limit leaves {left:.0} MB of address space, and this command begins with {least:.0} MB");
    Err(report::refused_by_system(message, "raise the limit (ulimit -v)"))
}

/// Refuses a run that needs more memory than there is, of which only the last windows are kept if it is streamed, and
/// so many samples.
pub(super) fn check<S: Real>(setup: &Setup<S>, is_streamed: bool, samples: usize) -> anyhow::Result<()> {
    let needed = bytes_needed(setup, is_streamed, samples);
    let Some(available) = available().filter(|available| needed > *available) else { return Ok(()) };
    let Settings { n_gamma, windows, digits, .. } = setup.settings;
    let help = match samples > 0 && !is_streamed && windows > 1 {
        true => "take fewer nodes or digits, or --samples-only, which keeps a few windows at a time",
        false => "take fewer nodes, digits or samples",
    };
    let (unit, name) = if needed < 1e8 { (1e6, "MB") } else { (1e9, "GB") };
    let [needed, available] = [needed, available].map(|bytes| bytes / unit);
    let message = format!(
        "the run needs about {needed:.2} {name} of memory for {} nodes in {digits} digits, and there are \
         {available:.2} {name}",
        n_gamma * windows
    );
    Err(report::refused(message, help))
}

/// The memory that the run can have, in bytes: the least of what the machine has left, what the process may still take,
/// and the limit of its control group. `None` where the operating system does not say.
fn available() -> Option<f64> {
    let kilobytes = |name| line("/proc/meminfo", name).map(|number| 1024.0 * number);
    let machine = kilobytes("MemAvailable:").map(|free| free + kilobytes("SwapFree:").unwrap_or(0.0));
    let of_group = |name: &str| {
        fs::read_to_string(format!("/sys/fs/cgroup/memory.{name}")).ok().and_then(|text| first_number(&text))
    };
    let group = of_group("max").map(|limit| (limit - of_group("current").unwrap_or(0.0)).max(0.0));
    [machine, address_space(), group].into_iter().flatten().reduce(f64::min)
}

/// The address space that the process may still take, in bytes, if there is a limit.
fn address_space() -> Option<f64> {
    let limit = line("/proc/self/limits", "Max address space")?;
    // The limit includes what is mapped already.
    let mapped = line("/proc/self/status", "VmSize:").map_or(0.0, |number| 1024.0 * number);
    Some((limit - mapped).max(0.0))
}

/// The first number in the line of a file that starts with `name`.
fn line(path: &str, name: &str) -> Option<f64> {
    let text = fs::read_to_string(path).ok()?;
    text.lines().find_map(|line| line.strip_prefix(name)).and_then(first_number)
}

fn first_number(text: &str) -> Option<f64> {
    text.split_whitespace().find_map(|word| word.parse().ok())
}
