//! The built-in cases: their files are compiled into the program, so that they are available in every folder.

/// The purpose of a built-in case; cases are listed in this order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Group {
    /// The cases of the paper.
    Paper,
    /// Other potentials, forms and settings; each case shows one of them.
    Basic,
    /// Cases at the edge of what a scheme can do, and beyond it.
    Hard,
    /// Scenes of several coordinates that move by Newton's law.
    Newtonian,
    /// Scenes in relativity, light, and geodesics of curved spaces.
    Curved,
}

impl Group {
    /// Its heading in lists; basic and hard cases share one.
    pub fn heading(self) -> &'static str {
        match self {
            Self::Paper => "The paper's cases",
            Self::Basic | Self::Hard => "One coordinate: other potentials, settings and units",
            Self::Newtonian => "Newton's law in several coordinates",
            Self::Curved => "Relativity, black holes, light and curved spaces",
        }
    }

    /// Returns true if its cases are scenes of several coordinates.
    pub fn is_scene(self) -> bool {
        matches!(self, Self::Newtonian | Self::Curved)
    }
}

/// Declares `ALL` from the names of the files in `cases/`, `cases/hard/` and `cases/scenes/`.
macro_rules! shipped {
    ($($group:ident in $folder:literal: [$($name:literal,)*])*) => {
        /// Every built-in case as (name, group, text of its file).
        const ALL: &[(&str, Group, &str)] = &[$($((
            $name,
            Group::$group,
            include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/", $folder, "/", $name, ".toml")),
        ),)*)*];

        /// The names of the built-in cases, group by group: their files' names without folder and extension.
        pub const NAMES: &[&str] = &[$($($name,)*)*];
    };
}

shipped![
    Paper in "cases": [
        "linear",
        "linear-sbp42",
        "quartic",
        "quartic-40-digits",
        "quartic-sbp42",
        "quartic-t-dot-4",
        "quartic-t-dot-4-sbp42",
        "quartic-t-dot-8",
        "quartic-t-dot-8-sbp42",
    ]
    Basic in "cases": [
        "double-well",
        "free",
        "harmonic",
        "morse",
        "morse-60-digits",
        "pendulum",
        "pendulum-60-digits",
        "quartic-accuracy",
        "quartic-weak",
        "quartic-windows",
        "units",
    ]
    Hard in "cases/hard": [
        "double-well-barrier",
        "gamma-long",
        "gamma-short",
        "horizon",
        "horizon-near",
        "huge-units",
        "linear-unregularised",
        "long-run",
        "nearly-spacelike",
        "pendulum-separatrix",
        "power-20",
        "quartic-unregularised",
        "tanh-wall",
        "tiny-units",
    ]
    Newtonian in "cases/scenes": [
        "arenstorf",
        "bouncing-ball",
        "crossed-fields",
        "damped-oscillator",
        "double-pendulum",
        "dry-friction",
        "duffing",
        "henon-heiles",
        "henon-heiles-megno",
        "kepler",
        "kepler-eccentric",
        "kepler-levi-civita",
        "kepler-polar",
        "kick",
        "molecule-table",
        "outer-planets",
        "pleiades",
        "restitution",
        "rocket",
        "satellite-backward",
        "three-bodies",
    ]
    Curved in "cases/scenes": [
        "expanding-universe",
        "fish-eye",
        "kepler-relativistic",
        "kerr-inclined",
        "kerr-mino",
        "kerr-periodic",
        "kerr-photon",
        "light-capture",
        "light-deflection",
        "luneburg",
        "mercury",
        "schwarzschild-orbit",
        "schwarzschild-plunge",
        "torus",
        "two-bodies",
    ]
];

/// The text of the built-in case `name`, if there is one.
pub fn text(name: &str) -> Option<&'static str> {
    found(name).map(|(_, _, text)| *text)
}

/// The group of the built-in case `name`, if there is one.
pub fn group(name: &str) -> Option<Group> {
    found(name).map(|(_, group, _)| *group)
}

fn found(name: &str) -> Option<&'static (&'static str, Group, &'static str)> {
    ALL.iter().find(|(known, _, _)| *known == name)
}

/// The first line of a case file without its `#`: a sentence that says what the case is. Empty if that line is no
/// comment.
pub fn description(text: &str) -> &str {
    text.lines().next().and_then(|line| line.strip_prefix('#')).map_or("", str::trim)
}
