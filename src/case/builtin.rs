//! The shipped cases, built into the program, so that they are at hand in any folder.

/// Declares `ALL` from the names of the files in `cases/`.
macro_rules! shipped {
    ($($name:literal,)*) => {
        /// Every shipped case as (name, text of its file).
        const ALL: &[(&str, &str)] =
            &[$(($name, include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/cases/", $name, ".toml")))),*];

        /// The names of the shipped cases: their files' names without the extension, in order.
        pub const NAMES: &[&str] = &[$($name),*];
    };
}

shipped![
    "double-well",
    "double-well-barrier",
    "free",
    "gamma-long",
    "gamma-short",
    "harmonic",
    "horizon",
    "horizon-near",
    "huge-units",
    "linear",
    "linear-sbp42",
    "linear-unregularised",
    "long-run",
    "morse",
    "morse-60-digits",
    "nearly-spacelike",
    "pendulum",
    "pendulum-60-digits",
    "pendulum-separatrix",
    "power-20",
    "quartic",
    "quartic-40-digits",
    "quartic-accuracy",
    "quartic-sbp42",
    "quartic-t-dot-4",
    "quartic-t-dot-4-sbp42",
    "quartic-t-dot-8",
    "quartic-t-dot-8-sbp42",
    "quartic-unregularised",
    "quartic-weak",
    "quartic-windows",
    "tanh-wall",
    "tiny-units",
    "units",
];

/// The text of the shipped case of that name.
pub fn text(name: &str) -> Option<&'static str> {
    ALL.iter().find(|(known, _)| *known == name).map(|(_, text)| *text)
}

/// The first line of a case file's comment, which says what the case is.
pub fn description(text: &str) -> &str {
    text.lines().next().and_then(|line| line.strip_prefix('#')).map_or("", str::trim)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Case;

    #[test]
    fn every_file_in_the_folder_is_built_in_and_described() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/cases");
        let mut files: Vec<String> = std::fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .filter_map(|name| name.strip_suffix(".toml").map(str::to_owned))
            .collect();
        files.sort();
        assert_eq!(files, NAMES);
        for name in NAMES {
            let text = text(name).unwrap();
            assert_eq!(text, std::fs::read_to_string(format!("{folder}/{name}.toml")).unwrap());
            assert!(description(text).len() > 20, "{name}");
            assert!(Case::parse(name, text, &[]).unwrap().title.is_some(), "{name}");
        }
    }
}
