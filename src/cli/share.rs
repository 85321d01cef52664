//! The arguments of many runs: what varies, and the share of the rows that a job computes.

use clap::Args;
use clap_complete::engine::ArgValueCompleter;
use geodesic_ivp::study::many::Axis;

use super::complete;

#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Many runs")]
pub(super) struct VaryArgs {
    /// Run for each value of a key: one table, with a row for each run
    ///
    /// VALUES is a list (scheme.sbp=SBP21,SBP42), or START:STOP:COUNT for equidistant values with both ends among them
    /// (initial.x=0.1:0.9:9), or START..STOP:COUNT for intervals side by side (parameters.k=0.9..1.1:10), with a proof
    /// of where all motions from each end. Given several times, every combination is run.
    #[arg(
        long,
        value_name = "KEY=VALUES",
        add = ArgValueCompleter::new(complete::settings),
        conflicts_with_all = ["more", "samples_only"]
    )]
    pub(super) vary: Vec<Axis>,

    /// Compute only the K-th of N shares of the rows, for `merge`
    ///
    /// These are the rows K, K + N, K + 2N and so on. In a job array of SLURM, PBS or SGE `auto` is the share of the
    /// job.
    #[arg(long, value_name = "K/N", value_parser = share, requires = "vary")]
    pub(super) part: Option<Share>,

    /// The column that --plot shows
    ///
    /// Over one key that varies it is a line, over two a map. Without this option it is the end of the first coordinate
    /// but t.
    #[arg(long, value_name = "COLUMN", requires_all = ["vary", "plot"])]
    pub(super) column: Option<String>,
}

/// The K-th of N shares of the rows. Neighbouring rows, which take similar times, are in different shares.
#[derive(Debug, Clone, Copy)]
pub(super) struct Share {
    pub(super) k: usize,
    pub(super) n: usize,
}

impl Share {
    /// The share of a job in an array, by the variables that its scheduler sets: the index, and the first, the last
    /// and the distance of the indices, or their number.
    fn of_job(variable: impl Fn(&str) -> Option<usize>) -> Option<Self> {
        let counted = |index: &str, first: &str, count: &str| {
            let k = variable(index)?.checked_sub(variable(first).unwrap_or(1))? + 1;
            Some(Self { k, n: variable(count)? })
        };
        let stepped = || {
            let (index, first) = (variable("SGE_TASK_ID")?, variable("SGE_TASK_FIRST")?);
            let (last, step) = (variable("SGE_TASK_LAST")?, variable("SGE_TASK_STEPSIZE").unwrap_or(1).max(1));
            Some(Self { k: index.checked_sub(first)? / step + 1, n: last.checked_sub(first)? / step + 1 })
        };
        let found = counted("SLURM_ARRAY_TASK_ID", "SLURM_ARRAY_TASK_MIN", "SLURM_ARRAY_TASK_COUNT")
            .or_else(|| counted("PBS_ARRAY_INDEX", "PBS_ARRAY_FIRST", "PBS_ARRAY_COUNT"))
            .or_else(stepped);
        found.filter(|share| (1..=share.n).contains(&share.k))
    }
}

/// The share that `--part` names.
fn share(text: &str) -> Result<Share, String> {
    if text.trim() == "auto" {
        let variable = |name: &str| std::env::var(name).ok()?.trim().parse().ok();
        return Share::of_job(variable).ok_or_else(|| {
            "no variables of a job array are set, SLURM_ARRAY_TASK_ID and _COUNT or those of PBS or SGE: give K/N"
                .to_owned()
        });
    }
    let parsed = text.split_once('/').and_then(|(k, n)| Some((k.trim().parse().ok()?, n.trim().parse().ok()?)));
    let found = parsed.filter(|(k, n)| (1..=*n).contains(k)).map(|(k, n)| Share { k, n });
    found.ok_or_else(|| "expected K/N with 1 <= K <= N, for example 2/4".to_owned())
}

#[cfg(test)]
mod tests {
    use super::Share;

    #[test]
    fn a_job_of_an_array_knows_its_share() {
        let share = |set: &[(&str, usize)]| {
            let variable = |name: &str| set.iter().find(|(other, _)| *other == name).map(|(_, value)| *value);
            Share::of_job(variable).map(|Share { k, n }| (k, n))
        };
        let slurm = [("SLURM_ARRAY_TASK_ID", 3), ("SLURM_ARRAY_TASK_MIN", 0), ("SLURM_ARRAY_TASK_COUNT", 8)];
        assert_eq!([share(&slurm), share(&slurm[..2])], [Some((4, 8)), None]);
        assert_eq!(share(&[("PBS_ARRAY_INDEX", 2), ("PBS_ARRAY_COUNT", 5)]), Some((2, 5)));
        let sge = [("SGE_TASK_ID", 21), ("SGE_TASK_FIRST", 1), ("SGE_TASK_LAST", 91), ("SGE_TASK_STEPSIZE", 10)];
        assert_eq!(share(&sge), Some((3, 10)));
        assert_eq!(share(&[]), None);
        assert_eq!(share(&[("PBS_ARRAY_INDEX", 6), ("PBS_ARRAY_COUNT", 5)]), None);
    }
}
