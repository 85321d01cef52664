//! Rewrites Rust files so that they hold all their mutants at once. Each has a number, and is switched on at run time.
//!
//! `mutants FOLDER LEFT_OUT FILE...` rewrites files of the project in FOLDER and prints a line for every mutant:
//! number, file, line, column, function, what changes, and the code around it. LEFT_OUT names a file with numbers that
//! are left out, as they do not compile.

mod rewrite;

use std::collections::HashSet;
use std::path::Path;
use std::{env, fs};

use rewrite::{Mutant, Rewrite};

const SWITCH: &str = include_str!("mutant.rs");

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = env::args().skip(1).collect();
    let [folder, left_out, files @ ..] = &arguments[..] else { return Err("FOLDER LEFT_OUT FILE...".into()) };
    let left_out: HashSet<u32> = fs::read_to_string(left_out)?.lines().filter_map(|line| line.parse().ok()).collect();
    let root = Path::new(folder);
    let mut count = 0;
    for name in files {
        let path = root.join(name);
        let text = fs::read_to_string(&path)?;
        let rewrite = Rewrite::of(&text, &syn::parse_file(&text)?, count, &left_out);
        count = rewrite.count;
        for Mutant { number, line, column, function, what, code } in &rewrite.mutants {
            println!("{number}\t{name}\t{line}\t{column}\t{function}\t{what}\t{code}");
        }
        fs::write(path, rewrite.text())?;
    }
    fs::write(root.join("crates/engine/src/mutant.rs"), SWITCH)?;
    // Mutants of all packages ask the lowest one, by the path crate::mutant.
    append(&root.join("crates/engine/src/lib.rs"), "#[allow(missing_docs)]\npub mod mutant;")?;
    append(&root.join("crates/critical-point/src/lib.rs"), "use geodesic_ivp_engine::mutant;")?;
    append(&root.join("src/lib.rs"), "pub use geodesic_ivp_engine::mutant;")
}

fn append(file: &Path, code: &str) -> Result<(), Box<dyn std::error::Error>> {
    let text = fs::read_to_string(file)?;
    Ok(fs::write(file, format!("{text}\n{code}\n"))?)
}
