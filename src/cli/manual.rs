//! `man`, one page with all commands, the keys of a case, files, exit codes and examples.

use std::process::ExitCode;

use clap::CommandFactory;
use clap_mangen::Man;
use clap_mangen::roff::{Inline, Roff, bold, italic, roman};
use geodesic_ivp::case::{Cases, KEYS, Key};

use super::report::{self, RESULTS, rows};
use super::{Cli, out};

/// Examples of commands, and what they do.
const EXAMPLES: [(&str, &str); 11] = [
    ("geodesic-ivp run quartic", "Solve a built-in case; the files go to results/quartic."),
    ("geodesic-ivp run quartic --set scheme.sbp=SBP42 --plot", "The same with another operator, and with pictures."),
    ("geodesic-ivp run quartic --set solver.accuracy=1e-10 --json", "To an accuracy; the summary as JSON."),
    ("geodesic-ivp init pendulum > mine.toml", "Start a case of your own."),
    ("geodesic-ivp run mine.toml --sample-t 0:4:0.5", "Solve it, with values at times of your choice."),
    ("geodesic-ivp run morse --stdout --quiet | head -3", "One table into a pipe, and no files."),
    (
        "geodesic-ivp run henon-heiles --set solver.accuracy=1e-10 --vary initial.y=-0.1:0.3:5",
        "Five orbits, one table, and their crossings in another.",
    ),
    ("geodesic-ivp converge quartic --n-gamma 16,32,64 --sbp SBP21", "Fit the order of an operator."),
    (
        "geodesic-ivp converge kerr-inclined --n-gamma 40,80,160 --sbp SBP42",
        "The same for every coordinate of a scene.",
    ),
    ("geodesic-ivp work-precision henon-heiles --plot", "Error against time, beside other methods, with pictures."),
    ("geodesic-ivp check quartic --run", "Validate a case and compare its solution with its [expect] table."),
];

/// Prints the manual page. There is only this one, so it refers to no others.
pub(super) fn man() -> anyhow::Result<ExitCode> {
    let mut page = Vec::new();
    let mut command = Cli::command();
    command.build();
    let main = Man::new(command.clone());
    main.render_title(&mut page)?;
    main.render_name_section(&mut page)?;
    main.render_synopsis_section(&mut page)?;
    main.render_description_section(&mut page)?;
    main.render_options_section(&mut page)?;
    for subcommand in command.get_subcommands().filter(|subcommand| subcommand.get_name() != "help") {
        Roff::new()
            .control("SH", [format!("COMMAND {}", subcommand.get_name().to_uppercase()).as_str()])
            .to_writer(&mut page)?;
        let mut subcommand = subcommand.clone();
        let usage = subcommand.render_usage().to_string();
        let section = Man::new(subcommand);
        let mut text = Vec::new();
        section.render_description_section(&mut text)?;
        let mut synopsis = Roff::new();
        synopsis.control("SH", ["SYNOPSIS"]).text([bold(usage.trim_start_matches("Usage: ").to_owned())]);
        synopsis.to_writer(&mut text)?;
        section.render_options_section(&mut text)?;
        // The sections of each command become sub-sections of the page.
        page.extend(String::from_utf8(text)?.replace(".SH ", ".SS ").into_bytes());
    }
    for section in sections() {
        section.to_writer(&mut page)?;
    }
    out::write_data(&page)?;
    Ok(ExitCode::SUCCESS)
}

/// A section that begins with a paragraph. Its entries are paragraphs under headings, in the layout of options.
fn section<H: Into<Vec<Inline>>, T: Into<String>>(
    title: &str,
    text: &str,
    entries: impl IntoIterator<Item = (H, T)>,
) -> Roff {
    let mut roff = Roff::new();
    roff.control("SH", [title]).text([roman(text)]);
    for (heading, text) in entries {
        roff.control("TP", []).text(heading).text([roman(text)]);
    }
    roff
}

/// A text without the marks of code and without the places that words lead to.
fn plain(markdown: &str) -> String {
    let mut text = markdown.replace('`', "");
    while let Some((before, behind)) = text.split_once("](") {
        let (before, words) = before.rsplit_once('[').unwrap_or(("", before));
        text = format!("{before}{words}{}", behind.split_once(')').map_or("", |(_, rest)| rest));
    }
    text
}

/// The sections that are about no command.
fn sections() -> [Roff; 5] {
    let key = |key: &Key| {
        let mut heading = vec![bold(key.name), roman(" "), italic(key.takes())];
        match key.default {
            "" | "none" => {}
            needed if key.is_required() => heading.push(roman(format!(" ({needed})"))),
            default => heading.push(roman(format!(" [default: {default}]"))),
        }
        (heading, plain(key.meaning))
    };
    let is_of_scenes = |key: &&Key| matches!(key.cases, Cases::Scenes | Cases::MakesScene);
    let of_case = "A case is a TOML file with these keys, for example [grid] with n_gamma = 32 for grid.n_gamma. An \
                   unknown key is an error. Exactly one kind of potential is required, and exactly one of \
                   initial.x_dot and initial.velocity.";
    let of_scenes = "A case with [metric], or with several coordinates, a one-form, a force, masses or a law, is a \
                     scene. It has these keys besides, and [scheme] and [solver] as above. q stands for any of its \
                     coordinates, NAME for a name of your own.";
    let of_files = "Results go to results/<case> for run, to results/<case>/vary for run --vary, to \
                    results/<case>/<command> for the others, to results/converge/<case> for converge without CASE, or \
                    to the folder of --out.";
    let of_codes = "Ctrl-C and SIGTERM end every command within a second.";
    let file = |[command, files, content]: [String; 3]| ([bold(files)], format!("{command}: {content}"));
    [
        section("CASE FILE", of_case, KEYS.iter().filter(|key| !is_of_scenes(key)).map(key)),
        section("SCENES", of_scenes, KEYS.iter().filter(is_of_scenes).map(key)),
        section("FILES", of_files, rows(RESULTS, "| files of | names | content |").map(file)),
        section("EXIT STATUS", of_codes, report::exit_codes().map(|[code, meaning]| ([bold(code)], meaning))),
        section("EXAMPLES", "In any folder:", EXAMPLES.map(|(command, what)| ([bold(command)], what))),
    ]
}
