//! `geodesic-ivp`: the command line of the library. All of it is in the library, where what it calls is compiled already.

use std::process::ExitCode;

fn main() -> ExitCode {
    geodesic_ivp::cli::main()
}
