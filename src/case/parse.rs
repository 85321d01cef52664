//! From a text to a valid case.

use std::sync::Arc;

use super::compiled::Compiled;
use super::observables::{self, Formulas};
use super::reader::Field;
use super::source::Source;
use super::{Case, CaseError, check, find, initial, intervals, missing, mistakes, rounding, settings, tables};
use crate::number::Extended;

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
        Self::parse_beside(source_name, text, overrides, None)
    }

    /// The same, beside a case that may have the same formulas, which are not compiled again then.
    pub(crate) fn parse_beside(
        source_name: &str,
        text: &str,
        overrides: &[String],
        other: Option<&Self>,
    ) -> Result<Self, CaseError> {
        let source = Source::new(source_name, text, overrides)?;
        let document = source.document()?;
        let root = Field::root(&source, document.as_item());
        let read = || Self::read(&root, other.map(|other| &other.compiled));
        // It may be missing because it is misspelt.
        let lacks = |error: &CaseError| {
            ["missing field", "neither ", "no potential"].iter().any(|begin| error.message.starts_with(begin))
        };
        if let Some(error) = mistakes::first(&root, || read().err().filter(|error| !lacks(error))) {
            return Err(error);
        }
        let case = read();
        // All that a case of the paper lacks is named at once.
        let is_incomplete = case.as_ref().err().is_none_or(lacks);
        let missing = (source.is_of_x && is_incomplete).then(|| missing::missing(&root));
        missing.flatten().map_or(case, Err)
    }

    fn read(root: &Field<'_>, known: Option<&Arc<Compiled>>) -> Result<Self, CaseError> {
        check::excluded(root)?;
        let mut scenery = check::geometry(root)?;
        let events = root.table("events");
        scenery.text.tables = tables::read(&root.table("tables"), &scenery.text)?;
        scenery.text.hold(observables::set_names(&events));
        let mut settings = settings::solver(root)?;
        check::particle(&scenery)?;
        let compiled = scenery.compiled(known)?;
        let geometry = scenery.geometry::<f64>(&compiled)?;
        let initial = initial::read(root.table("initial"), &scenery, &geometry)?;
        initial.check_numbers(&scenery.text.parameters)?;
        let rounding = rounding(settings.digits);
        let (mut is_double, mut tau) = check::start(&scenery, &initial, geometry, rounding)?;
        if settings.is_extended() {
            (is_double, tau) = check::start::<Extended>(&scenery, &initial, scenery.geometry(&compiled)?, rounding)?;
        }
        scenery.text.tau = tau;
        let compiled = if tau.is_some() { scenery.compiled(known)? } else { compiled };
        let (start, geometry) = check::placed(&scenery, &initial, &compiled, rounding, is_double)?;
        let names = scenery.text.names();
        let formulas = Formulas { coordinates: &names, scene: &scenery.text };
        let gamma_i = initial.from.as_ref().map(|(from, _)| from.gamma());
        let floors = settings::floor(root, &settings, &formulas)?;
        let invariants = root.table("invariants").fields();
        let case = Self {
            title: root.read("title", check::title)?,
            grid: settings::grid(root, &mut settings, &formulas, &start, gamma_i)?,
            expect: settings::expect(root, &formulas)?,
            invariants: invariants.iter().map(|field| formulas.invariant(field)).collect::<Result<_, _>>()?,
            events: events.fields().iter().map(|field| formulas.event(field)).collect::<Result<_, _>>()?,
            axes: formulas.axes(&root.table("plot"))?,
            find: find::read(root, &formulas)?,
            preset: scenery.preset.map(|preset| preset.name),
            is_of_x: root.source.is_of_x,
            coefficients: scenery.coefficients,
            bodies: scenery.bodies,
            initial: initial.data,
            intervals: intervals::intervals(root, &scenery.text.parameters)?,
            continues: initial.from.as_ref().map(|(_, summary)| summary.clone()),
            from: initial.from.map(|(from, _)| from),
            geometry_text: scenery.text.clone(),
            compiled,
            rough: geometry,
            t_dot: names.iter().position(|name| name == "t").map_or(0.0, |t| start.q_dot[t]),
            is_double,
            ignores_scheme: settings.accuracy.is_some() && root.get("scheme").is_some(),
            settings,
            proof: root.table("solver").read("proof", Field::is_true)?,
            floors,
            former: root.source.former.clone(),
            folder: root.source.folder.clone(),
            text: root.source.text.clone(),
        };
        check::acting(&case, &events)?;
        check::jumping(&case, &scenery.whole, &start.q)?;
        check::digits(&case, &scenery.whole)?;
        Ok(case)
    }
}
