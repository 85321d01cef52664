//! The command line: the only part of the crate that reads arguments and writes to the terminal.

mod base_cases;
mod check;
mod complete;
mod converge;
mod family;
mod find;
mod find_args;
mod format;
mod init;
mod input;
mod interrupt;
mod judge;
mod lines;
mod manual;
mod memory;
mod merge;
mod out;
mod piped;
mod report;
mod run;
mod run_args;
mod run_tables;
mod samples;
mod share;
mod stability;
mod starts;
mod study;
mod together;
mod told;
mod vary;
mod work_precision;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::error::{ContextKind, ContextValue, Error, ErrorKind};
use clap::{Arg, Args, CommandFactory, Parser, Subcommand, ValueHint};
use clap_complete::engine::ArgValueCompleter;
use geodesic_ivp::formula::similar::nearest;

/// Reads the command line, executes the command and returns its exit code. A mistake in the command line ends the
/// program with exit code 2; help and version end it with 0.
pub fn main() -> ExitCode {
    complete::answer();
    let cli = Cli::try_parse().unwrap_or_else(|error| explained(error).exit());
    execute(cli.command).unwrap_or_else(|error| report::explain(&error).into())
}

/// The text at the end of `--help`.
fn after_help() -> String {
    let codes = report::exit_codes().map(|[code, meaning]| lines::wrapped(&format!("  {code:<4} {meaning}"), 7));
    format!(
        "Exit codes:\n{}\nCtrl-C and SIGTERM end every command within a second. `geodesic-ivp man` has every key of a \
         case.\n\nExamples:\n  geodesic-ivp run quartic\n  geodesic-ivp init pendulum > mine.toml",
        codes.collect::<String>()
    )
}

/// The command that the program is asked to carry out.
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
    /// Solve a case, and say how good the result is
    #[command(
        mut_arg("case", |case| case.required(true)),
        after_help = "Examples:\n  geodesic-ivp run quartic --plot\n  \
                      geodesic-ivp run mine.toml --set solver.accuracy=1e-10 --sample-t 0:10:0.5"
    )]
    Run(Box<run_args::RunArgs>),
    /// Find a start, an end or parameters with which the run of a case meets its [find]
    ///
    /// The case says in [find] which of its numbers are unknown, and what is to be met: formulas that are 0 at the end,
    /// a motion that returns, or data that the run is fitted to.
    #[command(
        mut_arg("case", |case| case.required(true)),
        after_help = "Examples:\n  geodesic-ivp find lambert\n  geodesic-ivp run results/lambert/find/found.toml --plot"
    )]
    Find(find_args::FindArgs),
    /// Sweep the number of nodes, and fit the orders of the errors
    ///
    /// The errors are those against a trajectory of the Taylor method.
    #[command(
        mut_arg("case", |case| with_default(case, "linear and quartic")),
        mut_arg("plot", |plot| plot.help("Also draw the errors and their fits")),
        mut_arg("verbose", |verbose| verbose.help("Also print slopes against 1/N, as the paper fits them")),
        after_help = "Example:\n  geodesic-ivp converge quartic --n-gamma 16,32,64 --sbp SBP21"
    )]
    Converge(converge::ConvergeArgs),
    /// Chart error against time, beside other methods
    #[command(
        mut_arg("case", |case| with_default(case, "quartic")),
        mut_arg("plot", |plot| plot.help("Also draw errors against time, evaluations and gamma")),
        after_help = "Example:\n  geodesic-ivp work-precision kerr-inclined --methods gll16,gauss,dop853 --plot"
    )]
    WorkPrecision(work_precision::WorkPrecisionArgs),
    /// Chart where each method holds and where it fails, over step and length
    #[command(
        mut_arg("case", |case| with_default(case, "quartic")),
        mut_arg("plot", |plot| plot.help("Also draw the maps, the onset of the sawtooth and the last charge")),
        after_help = "Example:\n  geodesic-ivp stability pendulum --methods sbp42,verlet --gamma-f 10 --plot"
    )]
    Stability(stability::StabilityArgs),
    /// Join the parts of a table that `run --vary … --part K/N` has written
    #[command(
        mut_arg("out", |out| out.required(true)),
        after_help = "Example:\n  geodesic-ivp merge part-1 part-2 --out whole"
    )]
    Merge(merge::MergeArgs),
    /// Validate a case, and print it with every default filled in
    #[command(
        mut_arg("case", |case| case.required(true)),
        after_help = "Example:\n  geodesic-ivp check mine.toml --run"
    )]
    Check(check::CheckArgs),
    /// Print a built-in case, as a start for your own
    #[command(after_help = "Example:\n  geodesic-ivp init pendulum > mine.toml")]
    Init(init::InitArgs),
    /// Print the JSON schema of a case, for an editor
    #[command(after_help = "Example:\n  geodesic-ivp schema > case.schema.json")]
    Schema,
    /// Print a shell completion script
    ///
    /// With it a shell offers commands, options, names of cases, and keys behind --set and --vary.
    #[command(
        after_help = "Examples:\n  source <(geodesic-ivp completions bash)  # in ~/.bashrc, or with zsh in ~/.zshrc\n  \
                      geodesic-ivp completions fish > ~/.config/fish/completions/geodesic-ivp.fish"
    )]
    Completions {
        /// The shell
        shell: clap_complete::Shell,
    },
    /// Print the manual page
    #[command(after_help = "Example:\n  geodesic-ivp man > geodesic-ivp.1")]
    Man,
}

/// The argument of a command that takes a built-in case if none is given.
fn with_default(case: Arg, default: &str) -> Arg {
    let help = case.get_help().map(ToString::to_string).unwrap_or_default();
    case.help(format!("{help} [default: {default}]"))
        .long_help(format!("{help}, see `init --list` [default: {default}]"))
}

/// Arguments of every command that reads a case.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Case")]
struct CaseArgs {
    /// A file, - for stdin, or a built-in case
    ///
    /// `init --list` names the built-in cases. A file, which is TOML, takes precedence over one of the same name.
    #[arg(
        index = 1,
        value_name = "CASE",
        value_hint = ValueHint::FilePath,
        add = ArgValueCompleter::new(complete::cases),
        display_order = 0
    )]
    case: Option<PathBuf>,

    /// Override a key of the case, e.g. --set grid.n_gamma=64
    ///
    /// May be given several times. VALUE is a value of TOML; words and formulas need no quotes.
    #[arg(
        long = "set",
        value_name = "KEY=VALUE",
        add = ArgValueCompleter::new(complete::settings),
        display_order = 2
    )]
    set: Vec<String>,

    /// Print neither summary nor progress; warnings remain
    #[arg(long, short, help_heading = out::RESULTS)]
    quiet: bool,
}

/// Executes the command.
fn execute(command: Command) -> anyhow::Result<ExitCode> {
    match &command {
        Command::Converge(_) | Command::WorkPrecision(_) | Command::Stability(_) | Command::Find(_) => {
            memory::require_room(true)?
        }
        Command::Run(args) => memory::require_room(!args.vary.vary.is_empty())?,
        Command::Check(_) | Command::Merge(_) => memory::require_room(false)?,
        Command::Init(_) | Command::Schema | Command::Completions { .. } | Command::Man => {}
    }
    interrupt::install()?;
    match command {
        Command::Run(args) if !args.vary.vary.is_empty() => vary::vary(&args.continued()),
        Command::Run(args) => run::run(&args.continued()),
        Command::Find(args) => find::find_numbers(&args),
        Command::Converge(args) if args.study.case.case.is_none() => base_cases::converge(&args),
        Command::Converge(args) => converge::converge(&args),
        Command::WorkPrecision(args) => work_precision::work_precision(&args),
        Command::Stability(args) => stability::stability(&args),
        Command::Merge(args) => merge::merge(&args),
        Command::Check(args) => check::check(&args),
        Command::Init(args) => init::init(&args),
        Command::Schema => init::schema(),
        Command::Completions { shell } => complete::completions(shell),
        Command::Man => manual::man(),
    }
}

/// The parser's message, and what to do if a case is missing or a command is misspelt.
fn explained(mut error: Error) -> Error {
    match (error.kind(), error.get(ContextKind::InvalidArg), error.get(ContextKind::InvalidSubcommand)) {
        (ErrorKind::MissingRequiredArgument, Some(ContextValue::Strings(names)), _)
            if names.iter().any(|name| name == "<CASE>") =>
        {
            // Three commands require a case; the usage line says which of them this is.
            let usage = error.get(ContextKind::Usage).map(ToString::to_string).unwrap_or_default();
            let is = |command: &str| usage.contains(&format!(" {command} "));
            let example = if is("check") { "check quartic" } else { "run quartic" };
            let example = if is("find") { "find lambert" } else { example };
            let tip = format!(
                "name a file, - for standard input, or a built-in case, for example `{example}`; \
                 `init --list` names these, and `init quartic > my-case.toml` starts one's own"
            );
            error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![tip.into()]));
        }
        (ErrorKind::InvalidSubcommand, _, Some(ContextValue::String(word)))
            if error.get(ContextKind::SuggestedSubcommand).is_none() =>
        {
            let command = Cli::command();
            let known = command.get_subcommands().map(clap::Command::get_name);
            if let Some(meant) = nearest(word, known).map(str::to_owned) {
                error.insert(ContextKind::SuggestedSubcommand, ContextValue::Strings(vec![meant]));
            }
        }
        (ErrorKind::UnknownArgument, Some(ContextValue::String(name)), _) if name == "--n-gamma" => {
            let tip = "the numbers of nodes follow from steps and lengths: give --delta-gamma and --gamma-f";
            error.remove(ContextKind::SuggestedArg);
            error.remove(ContextKind::Usage);
            error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![tip.into()]));
        }
        // A page of names would hide the one that was meant.
        (ErrorKind::InvalidValue, Some(ContextValue::String(name)), _) if name == "[NAME]" => {
            error.remove(ContextKind::ValidValue);
            let tip = "`init --list` names the built-in cases";
            if error.get(ContextKind::SuggestedValue).is_none() {
                error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![tip.into()]));
            }
        }
        _ => {}
    }
    error
}
