//! A run ends where its case says, and a case that does not say is none.

use super::read;

/// A case of x, one under Newton's law, and one of a metric, without an end.
const ENDLESS: [&str; 3] = [
    "potential.free = {}\ninitial = { t = 0, x = 0, t_dot = 1, velocity = 0.5 }\nsolver.accuracy = 1e-8\n",
    "potential.formula = \"x^2\"\nparticle.law = \"newtonian\"\ninitial = { x = 1, x_dot = 0 }\n\
     solver.accuracy = 1e-8\n",
    "metric.preset = \"polar\"\ninitial = { t = 0, r = 1, t_dot = 1, r_dot = 0.5, p_phi = 0 }\n\
     scheme.sbp = \"GLL16\"\n",
];

#[test]
fn a_case_that_nothing_ends_says_what_to_write() {
    for text in ENDLESS {
        // An event may never be met: the run would go on to an end that nobody has asked for.
        for more in ["", "grid.until = \"t - 3\"\n", "events.late = { when = \"t - 3\", until = true }\n"] {
            let error = read(&format!("{text}{more}")).unwrap_err();
            assert_eq!(error.message, "neither gamma_f nor t_f is given: the run has no end", "{text}{more}");
            let help = error.help.unwrap();
            assert!(help.contains("grid.gamma_f") && help.contains("grid.t_f"), "{help}");
        }
        for end in ["grid.gamma_f = 2", "grid.t_f = 2"] {
            assert!(read(&format!("{text}{end}\n")).is_ok(), "{text}{end}");
        }
    }
}

#[test]
fn a_case_without_a_scheme_hears_of_the_simple_way() {
    for text in ENDLESS {
        let text = text.replace("solver.accuracy = 1e-8\n", "").replace("scheme.sbp = \"GLL16\"\n", "");
        let error = read(&format!("{text}grid.gamma_f = 1\n")).unwrap_err();
        let help = error.help.unwrap();
        assert!(help.starts_with("the simple way is solver.accuracy = 1e-10"), "{}: {help}", error.message);
    }
}
