//! Checks before a run that there is enough memory for it. Otherwise the operating system might kill the program in the
//! middle of the run.

use std::fs;

use geodesic_ivp::Case;
use geodesic_ivp::scalar::{Extended, Real};
use geodesic_ivp::solve::scene::SceneSetup;
use geodesic_ivp::solve::{Setup, bytes_needed, scene_bytes_needed};

use super::report::Refusal;
use super::samples::SampleArgs;

/// Refuses a run that needs more memory than there is.
///
/// # Errors
/// [`Refusal`] with the memory that is needed and the memory that there is.
pub(super) fn check(case: &Case, samples: Option<&SampleArgs>) -> anyhow::Result<()> {
    let (only, count) = samples.map_or((false, 0), |samples| (samples.only(), samples.count()));
    let needed = if case.is_extended() {
        bytes_needed(&Setup::<Extended>::from(case), only, count)
    } else {
        bytes_needed(&Setup::<f64>::from(case), only, count)
    };
    let help = match count > 0 && !only && case.grid.windows > 1 {
        true => "take fewer nodes or digits, or --samples-only, which keeps one window at a time",
        false => "take fewer nodes, digits or samples",
    };
    refuse(needed, case.grid.n_gamma * case.grid.windows, case.solver.digits, help)
}

/// The same for a scene with so many samples.
///
/// # Errors
/// As [`check`].
pub(super) fn check_scene<S: Real>(setup: &SceneSetup<S>, samples: usize) -> anyhow::Result<()> {
    let help = "take fewer nodes, digits or samples";
    refuse(
        scene_bytes_needed(setup, samples),
        setup.settings.n_gamma * setup.settings.windows,
        setup.settings.digits,
        help,
    )
}

/// Refuses a run of so many nodes and digits if there is less memory than it needs, in bytes.
fn refuse(needed: f64, nodes: usize, digits: u32, help: &str) -> anyhow::Result<()> {
    let Some(available) = available().filter(|available| needed > *available) else { return Ok(()) };
    let (unit, name) = if needed < 1e8 { (1e6, "MB") } else { (1e9, "GB") };
    let [needed, available] = [needed, available].map(|bytes| bytes / unit);
    let message = format!(
        "the run needs about {needed:.2} {name} of memory for {nodes} nodes in {digits} digits, and there are \
         {available:.2} {name}"
    );
    Err(Refusal::usage(message).help(help).into())
}

/// The memory that the run can have, in bytes: the least of what the machine has left, what the process may still take,
/// and the limit of its control group. `None` where the operating system does not say.
fn available() -> Option<f64> {
    let first_number = |text: &str| text.split_whitespace().find_map(|word| word.parse::<f64>().ok());
    let read = |path: &str| fs::read_to_string(path).ok();
    let line = |path: &str, name: &str| {
        let text = read(path)?;
        text.lines().find_map(|line| line.strip_prefix(name)).and_then(first_number)
    };
    let kilobytes = |name| line("/proc/meminfo", name).map(|number| 1024.0 * number);
    let machine = kilobytes("MemAvailable:").map(|free| free + kilobytes("SwapFree:").unwrap_or(0.0));
    // The limit of the process includes what it has mapped already.
    let mapped = line("/proc/self/status", "VmSize:").map_or(0.0, |number| 1024.0 * number);
    let process = line("/proc/self/limits", "Max address space").map(|limit| (limit - mapped).max(0.0));
    let of_group = |name: &str| read(&format!("/sys/fs/cgroup/memory.{name}")).and_then(|text| first_number(&text));
    let group = of_group("max").map(|limit| (limit - of_group("current").unwrap_or(0.0)).max(0.0));
    [machine, process, group].into_iter().flatten().reduce(f64::min)
}
