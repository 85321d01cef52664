//! From a text to a valid case.

use super::mistakes::Found;
use super::observables::{self, Formulas};
use super::reader::Section;
use super::settings::{self, Context, Scheme, Solver};
use super::source::Source;
use super::{Case, CaseError, check, hint, initial, metric, rounding, tables};
use crate::geometry::value_of;
use crate::number::{Extended, Real};
use crate::solve::{Continuation, Settings};

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
        let root = || Section::root(&source, document.as_table());
        let read = || Self::read(&source, root());
        // It may be missing because it is misspelt.
        let lacks = |error: &CaseError| {
            ["missing field", "neither ", "no potential"].iter().any(|begin| error.message.starts_with(begin))
        };
        if let Some(error) = Found::new(root).first(|| read().err().filter(|error| !lacks(error))) {
            return Err(error);
        }
        let case = read();
        // All that a case of the paper lacks is named at once.
        let is_incomplete = case.as_ref().err().is_none_or(lacks);
        let missing = (source.is_of_x && is_incomplete).then(|| hint::missing(document.as_table(), &source));
        missing.flatten().map_or(case, Err)
    }

    fn read<'t>(source: &'t Source, mut root: Section<'t>) -> Result<Self, CaseError> {
        let [title, metric, potential, force] = ["title", "metric", "potential", "force"].map(|key| root.take(key));
        let (body, pair) = (root.take("body"), root.section("pair")?);
        let [particle, initial, grid, scheme] = ["particle", "initial", "grid", "scheme"].map(|key| root.section(key));
        let [solver, expect, invariants] = ["solver", "expect", "invariants"].map(|key| root.section(key));
        let [events, plot, tables] = ["events", "plot", "tables"].map(|key| root.section(key));
        let mut scenery = check::geometry(&mut root, [metric, potential, force, body], [particle?, pair])?;
        let (tables, events) = (tables::read(&tables?, &scenery.text)?, events?);
        scenery.text.set_tables(tables.functions);
        scenery.text.hold(observables::set_names(&events));
        // First, because an accuracy in an override takes the scheme away.
        let ((mut solver, floor), scheme) = (settings::solver(solver?)?, scheme?);
        let ignores_scheme = solver.chooses_windows() && scheme.is_given();
        let scheme = settings::scheme(scheme, &solver)?;
        let operator = solver.chosen_by().map_or(Ok(scheme.sbp), Err);
        check::particle(&scenery)?;
        let compiled = scenery.geometry::<f64>()?;
        let initial = initial::read(initial?, &scenery, &compiled)?;
        initial.check_numbers(scenery.text.parameters())?;
        let mut found = check::start(&scenery, &initial, compiled, rounding(solver.digits))?;
        if solver.digits > f64::MOST_DIGITS {
            let geometry = scenery.geometry()?;
            let exact = check::start::<Extended>(&scenery, &initial, geometry, rounding(solver.digits))?;
            (found.is_double, found.tau) = (exact.is_double, exact.tau);
        }
        let (is_double, (start, compiled)) = (found.is_double, found.place(&mut scenery, &initial)?);
        let names = scenery.text.coordinates();
        let formulas = Formulas { coordinates: &names, scene: &scenery.text };
        let gamma_i = initial.from.as_ref().map_or_else(|| "0".to_owned(), Continuation::gamma);
        let context = Context { gamma_i, source, formulas: &formulas, start: &start };
        solver.floor = settings::floor(&floor, &solver, &context)?;
        let (grid, n_gamma, windows) = settings::grid(grid?, operator, &context)?;
        let (Solver { system, digits, max_iterations, sensitivity, .. }, Scheme { sbp, form, .. }) =
            (solver.clone(), scheme);
        let accuracy = solver.wanted(|number| value_of(number, scenery.text.parameters()).unwrap_or(f64::NAN));
        let settings = Settings { sbp, form, n_gamma, windows, system, digits, max_iterations, accuracy, sensitivity };
        let case = Self {
            title: title.map(|field| check::title(&field)).transpose()?,
            grid,
            expect: settings::expect(expect?, &context)?,
            invariants: formulas.invariants(&invariants?)?,
            events: formulas.events(&events)?,
            axes: formulas.axes(plot?)?,
            preset: scenery.preset.map(|preset| preset.name),
            is_of_x: source.is_of_x,
            coefficients: scenery.coefficients,
            bodies: scenery.bodies,
            initial: initial.data,
            from: initial.from,
            geometry_text: scenery.text.clone(),
            compiled,
            t_dot: names.iter().position(|name| name == "t").map_or(0.0, |t| start.q_dot[t]),
            is_double,
            ignores_scheme,
            settings,
            regularised: scheme.regularised,
            floors: solver.floor,
            tables: tables.files,
            text: source.text.clone(),
        };
        check::acting(&case, &events)?;
        if let Some(preset) = scenery.preset {
            metric::check_use(preset, &scenery.places, |name| case.is_used(name))?;
        }
        Ok(case)
    }
}
