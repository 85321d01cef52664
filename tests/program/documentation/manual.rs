//! The manual page and the completions have all that the program has.

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::process::Command;

use geodesic_ivp::case::builtin::NAMES;
use geodesic_ivp::case::{Cases, KEYS, Key};

use super::commands;
use crate::common::{Folder, succeeded};

fn printed(arguments: &str) -> String {
    Folder::new().succeeds(arguments)
}

/// The page without its marks for fonts, its definitions and its escapes.
pub(crate) fn page() -> String {
    let text = printed("man");
    let plain = ["\\fB", "\\fI", "\\fR", "\\&"].iter().fold(text, |text, mark| text.replace(mark, ""));
    let lines = plain.lines().filter(|line| !line.starts_with(".ie ") && !line.starts_with(".el "));
    lines.collect::<Vec<_>>().join("\n").replace("\\-", "-").replace("\\*(Aq", "'")
}

/// The part of the page below a heading.
pub(crate) fn section<'a>(page: &'a str, title: &str) -> &'a str {
    let rest = [format!(".SH {title}\n"), format!(".SH \"{title}\"\n")]
        .iter()
        .find_map(|heading| page.split_once(heading.as_str()))
        .unwrap_or_else(|| panic!("there is no section {title} in\n{page}"))
        .1;
    rest.split("\n.SH ").next().unwrap()
}

/// The headings of a section's entries, each with the text below it.
fn entries<'a>(page: &'a str, title: &str) -> Vec<(&'a str, &'a str)> {
    let parts = section(page, title).split("\n.TP\n").skip(1);
    parts.map(|part| part.split_once('\n').map(|(heading, text)| (heading, text.trim_end())).unwrap()).collect()
}

/// The commands of `--help`, each with the long options that its own help names.
fn commands() -> Vec<(String, BTreeSet<String>)> {
    let help = printed("--help");
    let list = help.split_once("Commands:\n").unwrap().1.split("\n\n").next().unwrap();
    let names = list.lines().filter(|line| line.starts_with("  ") && !line.starts_with("   "));
    let names = names.map(|line| line.split_whitespace().next().unwrap()).filter(|name| *name != "help");
    let options = |name: &str| {
        let help = printed(&format!("{name} --help"));
        let lines = help.lines().map(str::trim_start).filter(|line| line.starts_with('-'));
        let words = lines.filter_map(|line| line.split([' ', ',']).find(|word| word.starts_with("--")));
        words.map(str::to_owned).collect::<BTreeSet<_>>()
    };
    names.map(|name| (name.to_owned(), options(name))).collect()
}

#[test]
fn the_manual_page_has_every_command_and_option() {
    let (page, commands) = (page(), commands());
    assert_eq!(commands.len(), 11, "{commands:?}");
    for (name, options) in commands {
        let section = section(&page, &format!("COMMAND {}", name.to_uppercase()));
        assert!(options.contains("--help"));
        for option in options {
            let is_named = section.lines().any(|line| line.split([' ', ',']).any(|word| word == option));
            assert!(is_named, "{name} {option} is not in\n{section}");
        }
    }
    assert!(section(&page, "OPTIONS").contains("--version"));
}

/// What is offered for the last of these words. Fish asks so; all shells get the same.
fn completed(folder: &Folder, words: &str) -> Vec<String> {
    let mut program = folder.program("--");
    program.env("GEODESIC_IVP_COMPLETE", "fish").arg("geodesic-ivp").args(words.split(' '));
    let lines = succeeded(&program.output().unwrap());
    lines.lines().map(|line| line.split('\t').next().unwrap().to_owned()).collect()
}

#[test]
fn completions_have_every_command_and_option() {
    let folder = Folder::new();
    let all = completed(&folder, "");
    for (name, options) in commands() {
        assert!(all.contains(&name), "{name}");
        let offered = completed(&folder, &format!("{name} --"));
        for option in options {
            assert!(offered.contains(&option), "{name} {option}: {offered:?}");
        }
    }
}

#[test]
fn completions_know_cases_keys_and_values() {
    let folder = Folder::new();
    for command in ["run", "check", "converge", "stability", "work-precision"] {
        let cases = completed(&folder, &format!("{command} "));
        assert!(NAMES.iter().all(|name| cases.iter().any(|case| case == name)), "{command}: {cases:?}");
    }
    folder.write("quarter.toml", "");
    folder.write("quarter.csv", "");
    let [cases, keys, values, shells, of_sweep] = [
        "run qua",
        "run quartic --set grid.",
        "run quartic --set scheme.sbp=SBP",
        "completions f",
        "run quartic --vary solver.pr",
    ]
    .map(|words| completed(&folder, words));
    let has = |words: &[String], word: &str| words.iter().any(|other| other == word);
    assert!(has(&cases, "quartic-weak") && has(&cases, "quarter.toml") && !has(&cases, "quarter.csv"), "{cases:?}");
    assert!(has(&keys, "grid.n_gamma=") && has(&keys, "grid.t_f=") && keys.iter().all(|key| key.starts_with("grid.")));
    assert_eq!(values, ["scheme.sbp=SBP21", "scheme.sbp=SBP42", "scheme.sbp=SBP63", "scheme.sbp=SBP84"]);
    assert_eq!((shells, of_sweep), (vec!["fish".to_owned()], vec!["solver.proof=".to_owned()]));
}

/// The scripts of all shells are there, and that of bash is tried in it.
#[test]
fn a_shell_offers_what_the_program_answers() {
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        assert!(printed(&format!("completions {shell}")).contains("GEODESIC_IVP_COMPLETE"), "{shell}");
    }
    let folder = Folder::new();
    let program = PathBuf::from(folder.program("").get_program());
    folder.write("completions.bash", printed("completions bash"));
    // As bash splits them.
    for (words, offered) in [
        ("wo", "work-precision"),
        ("run units", "units"),
        ("run units --set grid.wi", "grid.windows="),
        ("run units --set scheme.sbp = SBP8", "SBP84"),
        ("run units --set = grid.wi", "grid.windows="),
        ("run pendulum --set parameters.", "parameters.g="),
        ("find bra", "bratu"),
        ("find pend", ""),
    ] {
        let word = words.split(' ').next_back().unwrap();
        let line = format!(
            "PATH={}:$PATH; source ./completions.bash; COMP_WORDS=(geodesic-ivp {words}); \
             COMP_CWORD=$((${{#COMP_WORDS[@]}} - 1)); \
             _geodesic_ivp geodesic-ivp {word} 2>/dev/null; echo \"${{COMPREPLY[@]}}\"",
            program.parent().unwrap().display()
        );
        let bash = Command::new("bash").arg("-c").arg(line).current_dir(folder.path("")).output().unwrap();
        assert_eq!(succeeded(&bash).trim(), offered);
    }
}

#[test]
fn the_manual_page_has_every_key_of_a_case_and_of_scenes() {
    let page = page();
    let is_general = |key: &&Key| matches!(key.cases, Cases::All | Cases::OfX);
    for (title, general) in [("CASE FILE", true), ("SCENES", false)] {
        let named = entries(&page, title).into_iter().map(|(heading, _)| heading.split(' ').next().unwrap());
        let known = KEYS.iter().filter(|key| is_general(key) == general).map(|key| key.name);
        assert_eq!(named.collect::<Vec<_>>(), known.collect::<Vec<_>>(), "{title}");
    }
    let (_, proof) =
        *entries(&page, "CASE FILE").iter().find(|(heading, _)| heading.starts_with("solver.proof")).unwrap();
    let told = "true: run also proves where the motion ends, and how far the run is from there; false: it does not.";
    assert!(proof.starts_with(told) && !proof.contains("]("), "{proof}");
}

/// They are tables of a page, which is found by their headings.
#[test]
fn the_manual_page_has_the_files_and_the_exit_codes() {
    let page = page();
    assert_eq!(entries(&page, "EXIT STATUS").iter().map(|entry| entry.0).collect::<String>(), "012345130");
    assert!(entries(&page, "FILES").len() > 15);
}

#[test]
#[ignore = "long: the examples measure speed and map stability"]
fn the_examples_of_the_manual_page_run() {
    let (page, folder) = (page(), Folder::new());
    let examples = entries(&page, "EXAMPLES");
    assert!(examples.len() >= 6, "{examples:?}");
    for (command, _) in examples {
        commands::printed(&folder.path(""), command).unwrap_or_else(|error| panic!("{command}: {error}"));
    }
}

#[test]
fn long_help_names_every_method() {
    let joined = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
    for command in ["work-precision", "stability"] {
        let help = joined(&printed(&format!("{command} --help")));
        let refused = Folder::new().fails(&format!("{command} --methods euler"), 2);
        let list = refused.split_once("the methods for this case are").unwrap().1;
        assert!(list.lines().all(|line| line.chars().count() <= 100), "{list}");
        assert!(list.split(',').map(joined).all(|method| help.contains(&method)), "{command}: {list}");
    }
}
