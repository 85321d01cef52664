//! The command line: the only part of the crate that reads arguments and writes to the terminal.

mod base_cases;
mod check;
mod converge;
mod details;
mod drawn;
mod init;
mod input;
mod interrupt;
mod lines;
mod manual;
mod memory;
mod merge;
mod methods;
mod out;
mod report;
mod run;
mod samples;
mod shell;
mod stability;
mod stdout;
mod study;
mod told;
mod usage;
mod vary;
mod work_precision;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, Parser, Subcommand, ValueHint};

use report::exit_code;

/// Reads the command line, executes the command and returns its exit code.
pub fn main() -> ExitCode {
    Cli::from_command_line().execute().unwrap_or_else(|error| exit_code(&error))
}

/// The text at the end of `--help`.
fn after_help() -> String {
    let codes = report::EXIT_CODES.map(|(code, meaning)| format!("  {code:<4} {meaning}\n"));
    format!(
        "Exit codes:\n{}\nCtrl-C and SIGTERM end every command within a second. `geodesic-ivp man` also has every key \
         of a case file.",
        codes.concat()
    )
}

/// What the program is asked to do.
#[derive(Debug, Parser)]
#[command(
    version,
    about = "Solve initial value problems as geodesics: exact Noether charge, emergent time mesh",
    long_about = "A point particle in a potential V(x) is a free particle in a curved space-time. Its geodesic action \
                  is discretised along the world-line parameter gamma with summation-by-parts operators and doubled \
                  degrees of freedom; the critical point gives t(gamma) and x(gamma) together and conserves the \
                  Noether charge of time translations exactly.\n\n\
                  Method: A. Rothkopf and J. Nordström, arXiv:2307.04490 (2023).",
    after_help = after_help(),
    arg_required_else_help = true
)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Solve one case and write its trajectory, residuals and summary
    #[command(mut_arg("case", |case| case.required(true)))]
    Run(run::RunArgs),
    /// Sweep the number of nodes and fit the slopes of the errors against a reference trajectory (without CASE: of the
    /// paper's four base cases)
    Converge(converge::ConvergeArgs),
    /// Chart speed against accuracy: this program's schemes beside other methods on the same world-line
    WorkPrecision(work_precision::WorkPrecisionArgs),
    /// Chart where methods fail: every scheme over step and length, beside the limits of linear theory
    Stability(stability::StabilityArgs),
    /// Join the parts of a table that `run --vary … --part K/N` has written
    #[command(mut_arg("out", |out| out.required(true)))]
    Merge(merge::MergeArgs),
    /// Validate a case and print it with every default filled in
    #[command(mut_arg("case", |case| case.required(true)))]
    Check(check::CheckArgs),
    /// Write a built-in case to standard output, as a start for one's own
    Init(init::InitArgs),
    /// Print a shell completion script
    Completions {
        /// The shell
        shell: clap_complete::Shell,
    },
    /// Print the manual page
    Man,
}

/// Arguments of every command that reads a case.
#[derive(Debug, Clone, Args)]
struct CaseArgs {
    /// Case file (TOML), - for standard input, or the name of a built-in case (`init --list` names them)
    #[arg(index = 1, value_name = "CASE", value_hint = ValueHint::FilePath)]
    case: Option<PathBuf>,

    /// Override a case key, e.g. --set grid.n_gamma=64 (repeatable)
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,

    /// Print no summary and no progress (warnings and errors remain)
    #[arg(long, short)]
    quiet: bool,
}

impl Cli {
    /// Reads the command line. A mistake in it ends the program with exit code 2; help and version end it with 0.
    fn from_command_line() -> Self {
        Self::try_parse().unwrap_or_else(|error| usage::explained(error).exit())
    }

    /// Executes the command.
    ///
    /// # Errors
    /// The error that ended the command; [`exit_code`] turns it into a message and an exit code.
    fn execute(self) -> anyhow::Result<ExitCode> {
        match &self.command {
            Command::Converge(_) | Command::WorkPrecision(_) | Command::Stability(_) => memory::require_room(true)?,
            Command::Run(args) => memory::require_room(args.vary.is_given())?,
            Command::Check(_) | Command::Merge(_) => memory::require_room(false)?,
            Command::Init(_) | Command::Completions { .. } | Command::Man => {}
        }
        interrupt::listen()?;
        match self.command {
            Command::Run(args) => run::run(&args),
            Command::Converge(args) => converge::converge(&args),
            Command::WorkPrecision(args) => work_precision::work_precision(&args),
            Command::Stability(args) => stability::stability(&args),
            Command::Merge(args) => merge::merge(&args),
            Command::Check(args) => check::check(&args),
            Command::Init(args) => init::init(&args),
            Command::Completions { shell } => shell::completions(shell),
            Command::Man => manual::man(),
        }
    }
}
