//! From a text to a valid case.

use super::mistakes::Found;
use super::observables::{self, Formulas};
use super::reader::Field;
use super::source::Source;
use super::{Case, CaseError, check, hint, initial, metric, rounding, settings, tables};
use crate::number::Extended;
use crate::solve::Continuation;

impl Case {
    /// Reads a case from TOML `text` after applying `overrides` of the form `dotted.key=value`.
    ///
    /// The value of an override is a TOML value; a word that is not one is taken as a string. With overrides, errors
    /// refer to the text as the overrides have changed it.
    ///
    /// # Errors
    /// [`CaseError`] for anything that is not a complete, valid case: syntax, an unknown or missing key, a wrong type,
    /// a number that is not finite or out of range, a formula that does not parse, a start outside the domain.
    pub fn parse(source_name: &str, text: &str, overrides: &[String]) -> Result<Self, CaseError> {
        let source = Source::new(source_name, text, overrides)?;
        let document = source.document()?;
        let root = Field::root(&source, document.as_item());
        let read = || Self::read(&root);
        // It may be missing because it is misspelt.
        let lacks = |error: &CaseError| {
            ["missing field", "neither ", "no potential"].iter().any(|begin| error.message.starts_with(begin))
        };
        if let Some(error) = Found::new(&root).first(|| read().err().filter(|error| !lacks(error))) {
            return Err(error);
        }
        let case = read();
        // All that a case of the paper lacks is named at once.
        let is_incomplete = case.as_ref().err().is_none_or(lacks);
        let missing = (source.is_of_x && is_incomplete).then(|| hint::missing(&root));
        missing.flatten().map_or(case, Err)
    }

    fn read(root: &Field<'_>) -> Result<Self, CaseError> {
        check::excluded(root)?;
        let mut scenery = check::geometry(root)?;
        let (tables, events) = (tables::read(&root.table("tables"), &scenery.text)?, root.table("events"));
        scenery.text.set_tables(tables.functions);
        scenery.text.hold(observables::set_names(&events));
        let (mut settings, regularised) = settings::solver(root)?;
        check::particle(&scenery)?;
        let compiled = scenery.geometry::<f64>()?;
        let initial = initial::read(root.table("initial"), &scenery, &compiled)?;
        initial.check_numbers(scenery.text.parameters())?;
        let mut found = check::start(&scenery, &initial, compiled, rounding(settings.digits))?;
        if settings.is_extended() {
            let exact = check::start::<Extended>(&scenery, &initial, scenery.geometry()?, rounding(settings.digits))?;
            (found.is_double, found.tau) = (exact.is_double, exact.tau);
        }
        let (is_double, (start, compiled)) = (found.is_double, found.place(&mut scenery, &initial)?);
        let names = scenery.text.coordinates();
        let formulas = Formulas { coordinates: &names, scene: &scenery.text };
        let gamma_i = initial.from.as_ref().map_or_else(|| "0".to_owned(), Continuation::gamma);
        let floors = settings::floor(root, &settings, &formulas)?;
        let invariants = root.table("invariants").fields();
        let case = Self {
            title: root.read("title", check::title)?,
            grid: settings::grid(root, &mut settings, &formulas, &start, gamma_i)?,
            expect: settings::expect(root, &formulas)?,
            invariants: invariants.iter().map(|field| formulas.invariant(field)).collect::<Result<_, _>>()?,
            events: events.fields().iter().map(|field| formulas.event(field)).collect::<Result<_, _>>()?,
            axes: formulas.axes(&root.table("plot"))?,
            preset: scenery.preset.map(|preset| preset.name),
            is_of_x: scenery.is_of_x,
            coefficients: scenery.coefficients,
            bodies: scenery.bodies,
            initial: initial.data,
            from: initial.from,
            geometry_text: scenery.text.clone(),
            compiled,
            t_dot: names.iter().position(|name| name == "t").map_or(0.0, |t| start.q_dot[t]),
            is_double,
            ignores_scheme: settings.accuracy.is_some() && root.get("scheme").is_some(),
            settings,
            regularised,
            floors,
            tables: tables.files,
            text: root.source.text.clone(),
        };
        check::acting(&case, &events)?;
        if let Some(preset) = scenery.preset {
            metric::check_use(preset, &scenery.places, |name| case.is_used(name))?;
        }
        Ok(case)
    }
}
