//! Mistakes that keys and values have by themselves: all of them are told at once, each in fitting words.

use geodesic_ivp::case::Case;

use super::KEPLER;

/// All that keys and values have wrong by themselves is told at once, in the order of the text.
#[test]
fn the_mistakes_of_keys_and_values_are_all_found_at_once() {
    let text = r#"
titel = "Six"
[potential]
coordinates = ["x", 1]
formula = { expression = 2, parametres = {} }
[particle]
law = "newton"
[grid]
n_gamma = 3.5
windows = 0
[scheme]
sbp = "SBP22"
[solver]
digits = 99
accuracy = 2
[events]
up = { when = "x", direction = "left", unti = true }
"#;
    let error = Case::parse("case", text, &[]).unwrap_err();
    let all: Vec<_> = std::iter::once(&error).chain(&error.further).collect();
    let places: Vec<&str> = all.iter().map(|error| &text[error.span.clone().unwrap()]).collect();
    let expected = "titel 1 2 parametres \"newton\" 3.5 0 \"SBP22\" 99 2 \"left\" unti";
    assert_eq!(places.join(" "), expected);
    assert!(error.to_string().ends_with("(and 11 more mistakes)"), "{error}");
}

/// Where nothing says what the coordinates are, that is what is wrong, and not their names.
#[test]
fn coordinates_of_an_unknown_geometry_are_no_unknown_keys() {
    let text = "[initial]\nr = 1.0\nr_dot = 0.0\n[scheme]\nsbp = \"GLL8\"\n";
    let error = Case::parse("case", text, &[]).unwrap_err();
    assert!(error.message.starts_with("missing field") && error.further.is_empty(), "{error}");
}

/// A key of one that is known is not told to be one of several.
#[test]
fn a_single_key_is_said_to_be_the_only_one() {
    let overrides = ["potential.quartic.kapa=1".to_owned()];
    let text = geodesic_ivp::case::builtin::text("quartic").unwrap();
    let error = Case::parse("case", text, &overrides).unwrap_err();
    assert_eq!(error.message, "unknown field `kapa`, the only key is `kappa`");
    assert_eq!(error.help.as_deref(), Some("did you mean `kappa`?"));
}

#[test]
fn an_event_has_no_name_of_a_column() {
    for name in ["gamma", "window", "event"] {
        let text = format!("{KEPLER}\n[events]\n{name} = {{ when = \"x\" }}\n");
        let error = Case::parse("case", &text, &[]).unwrap_err();
        assert!(error.message.contains(&format!("an event cannot have the name '{name}'")), "{error}");
        assert_eq!(&text[error.span.unwrap()], name);
    }
}
