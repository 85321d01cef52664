//! The program `geodesic-ivp`. All of the command line is in the library, so that the code it calls is compiled only
//! once.

use std::process::ExitCode;

fn main() -> ExitCode {
    geodesic_ivp::cli::main()
}
