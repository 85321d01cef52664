//! Writing a scene as text.

use toml_edit::{Array, DocumentMut, InlineTable, Item, Table, Value};

use super::{Quantity, Rate, SceneCase, Sign};
use crate::geometry::{GeometryText, Law, MetricText, PotentialText};

impl SceneCase {
    /// The scene as TOML, with every default filled in. Reading that text gives the same scene.
    pub fn to_toml(&self) -> String {
        let mut document = DocumentMut::new();
        let root = document.as_table_mut();
        if let Some(title) = &self.title {
            insert(root, "title", title.as_str());
        }
        match &self.geometry {
            GeometryText::Metric(metric) => drop(root.insert("metric", Item::Table(self.metric_table(metric)))),
            GeometryText::Potential(potential) => {
                root.insert("potential", Item::Table(potential_table(potential)));
                root.insert("particle", Item::Table(particle_table(potential)));
            }
        }
        root.insert("initial", Item::Table(self.initial_table()));
        root.insert("grid", Item::Table(self.grid_table()));
        if !self.solver.chooses_windows() {
            let mut scheme = Table::new();
            insert(&mut scheme, "sbp", self.sbp.to_string());
            insert(&mut scheme, "form", self.form.as_str());
            root.insert("scheme", Item::Table(scheme));
        }
        let mut solver = Table::new();
        let system = serde_json::to_value(self.solver.system).expect("a system has a name");
        insert(&mut solver, "system", system.as_str().unwrap_or_default());
        insert(&mut solver, "digits", i64::from(self.solver.digits));
        insert(&mut solver, "max_iterations", self.solver.max_iterations as i64);
        for (key, number) in [("accuracy", &self.solver.accuracy), ("tolerance", &self.solver.tolerance)] {
            if let Some(number) = number {
                insert(&mut solver, key, quantity(number));
            }
        }
        root.insert("solver", Item::Table(solver));
        self.add_observables(root);
        if let Some(expect) = self.expect_table() {
            root.insert("expect", Item::Table(expect));
        }
        document.to_string()
    }

    fn metric_table(&self, metric: &MetricText) -> Table {
        let mut table = Table::new();
        let name = |a: usize| metric.coordinates[a].as_str();
        match self.preset {
            Some(preset) => insert(&mut table, "preset", preset),
            None => {
                insert(&mut table, "coordinates", Value::Array(metric.coordinates.iter().collect::<Array>()));
                let components =
                    metric.components.iter().map(|([a, b], text)| (format!("{} {}", name(*a), name(*b)), text));
                insert_formulas(&mut table, "components", true, components);
            }
        }
        let pairs = |pairs: &[(String, String)]| pairs.to_vec();
        let (definitions, parameters) = (pairs(&metric.definitions), pairs(&metric.parameters));
        insert_formulas(&mut table, "definitions", false, definitions.iter().map(|(name, text)| (name.clone(), text)));
        insert_formulas(&mut table, "parameters", false, parameters.iter().map(|(name, text)| (name.clone(), text)));
        insert_forms(&mut table, &metric.coordinates, &metric.one_form, &metric.force, metric.conformal.as_ref());
        table
    }

    fn initial_table(&self) -> Table {
        let mut table = Table::new();
        let names = self.coordinates();
        for (name, q) in names.iter().zip(&self.initial.q) {
            insert(&mut table, name, quantity(q));
        }
        let mut solve = InlineTable::new();
        for (name, rate) in names.iter().zip(&self.initial.rates) {
            match rate {
                Rate::Velocity(value) => insert(&mut table, &format!("{name}_dot"), quantity(value)),
                Rate::Momentum(value) => insert(&mut table, &format!("p_{name}"), quantity(value)),
                Rate::VelocityFromNorm(Some(sign)) => drop(solve.insert(format!("{name}_dot"), sign_value(*sign))),
                Rate::MomentumFromNorm(Some(sign)) => drop(solve.insert(format!("p_{name}"), sign_value(*sign))),
                // It follows from Newton's law, which the case names.
                Rate::VelocityFromNorm(None) | Rate::MomentumFromNorm(None) => {}
            }
        }
        if let Some(norm) = self.initial.norm.as_ref().filter(|_| !solve.is_empty()) {
            insert(&mut table, "norm", quantity(norm));
            insert(&mut table, "solve", Value::InlineTable(solve));
        }
        table
    }

    fn grid_table(&self) -> Table {
        let (mut table, grid) = (Table::new(), &self.grid);
        insert(&mut table, "gamma_i", quantity(&grid.gamma_i));
        for (key, value) in [("gamma_f", &grid.gamma_f), ("t_f", &grid.t_f)] {
            if let Some(value) = value {
                insert(&mut table, key, quantity(value));
            }
        }
        if !self.solver.chooses_windows() {
            insert(&mut table, "n_gamma", grid.n_gamma as i64);
            insert(&mut table, "windows", grid.windows as i64);
        }
        if let Some(until) = &grid.until {
            insert(&mut table, "until", formula(until));
        }
        table
    }

    fn add_observables(&self, root: &mut Table) {
        if !self.invariants.is_empty() {
            let mut table = Table::new();
            self.invariants.iter().for_each(|(name, text)| insert(&mut table, name, formula(text)));
            root.insert("invariants", Item::Table(table));
        }
        if !self.events.is_empty() {
            let mut table = Table::new();
            for event in &self.events {
                let mut entry = InlineTable::new();
                entry.insert("when", formula(&event.when));
                entry.insert("direction", event.direction.as_str().into());
                entry.insert("until", event.until.into());
                insert(&mut table, &event.name, Value::InlineTable(entry));
            }
            root.insert("events", Item::Table(table));
        }
        if let Some(axes) = &self.axes {
            let mut table = Table::new();
            insert(&mut table, "x", formula(&axes.x));
            insert(&mut table, "y", formula(&axes.y));
            root.insert("plot", Item::Table(table));
        }
    }

    fn expect_table(&self) -> Option<Table> {
        let expect = self.expect.as_ref()?;
        let (mut table, names) = (Table::new(), self.coordinates());
        insert(&mut table, "status", expect.status.as_str());
        if let Some(gamma) = &expect.gamma_final {
            insert(&mut table, "gamma_final", quantity(gamma));
        }
        for (a, value) in &expect.finals {
            insert(&mut table, &format!("{}_final", names[*a]), quantity(value));
        }
        if let Some(tolerance) = &expect.tolerance {
            insert(&mut table, "tolerance", quantity(tolerance));
        }
        Some(table)
    }
}

fn potential_table(potential: &PotentialText) -> Table {
    let mut table = Table::new();
    insert(&mut table, "coordinates", Value::Array(potential.coordinates.iter().collect::<Array>()));
    insert(&mut table, "formula", potential.expression.as_str());
    let parameters = potential.parameters.iter().map(|(name, text)| (name.clone(), text));
    insert_formulas(&mut table, "parameters", false, parameters);
    let PotentialText { coordinates, one_form, force, conformal, .. } = potential;
    insert_forms(&mut table, coordinates, one_form, force, conformal.as_ref());
    table
}

fn particle_table(potential: &PotentialText) -> Table {
    let PotentialText { coordinates, mass, masses, c, law, .. } = potential;
    let mut table = Table::new();
    let is_newtonian = *law == Law::Newtonian;
    let is_one = masses.iter().all(|other| other == mass);
    if is_one || !is_newtonian {
        insert(&mut table, "mass", formula(mass));
    }
    if !is_one {
        let masses = coordinates.iter().cloned().zip(masses);
        insert_formulas(&mut table, "masses", false, masses);
    }
    if !is_newtonian {
        insert(&mut table, "c", formula(c));
    }
    insert(&mut table, "law", if is_newtonian { "newtonian" } else { "relativistic" });
    table
}

fn insert_forms(
    table: &mut Table,
    coordinates: &[String],
    one_form: &[(usize, String)],
    force: &[(usize, String)],
    conformal: Option<&String>,
) {
    for (key, formulas) in [("one_form", one_form), ("force", force)] {
        insert_formulas(table, key, false, formulas.iter().map(|(a, text)| (coordinates[*a].clone(), text)));
    }
    if let Some(omega) = conformal {
        insert(table, "conformal", formula(omega));
    }
}

/// Inserts a table of formulas, unless it is empty and may be left out.
fn insert_formulas<'f>(
    table: &mut Table,
    key: &str,
    is_required: bool,
    formulas: impl Iterator<Item = (String, &'f String)>,
) {
    let mut inner = InlineTable::new();
    formulas.for_each(|(name, text)| drop(inner.insert(&name, formula(text))));
    if is_required || !inner.is_empty() {
        insert(table, key, Value::InlineTable(inner));
    }
}

fn insert(table: &mut Table, key: &str, value: impl Into<Value>) {
    table.insert(key, Item::Value(value.into()));
}

fn sign_value(sign: Sign) -> Value {
    match sign {
        Sign::Plus => "+".into(),
        Sign::Minus => "-".into(),
    }
}

fn quantity(quantity: &Quantity) -> Value {
    formula(quantity.text())
}

/// A number as it is written, or a formula as a string.
fn formula(text: &str) -> Value {
    let is_decimal = text.starts_with(|c: char| c.is_ascii_digit() || c == '-');
    let number = text.parse::<Value>().ok().filter(|_| is_decimal && !text.contains(['_', 'x', 'o', 'b', ' ']));
    let number = number.filter(|value| value.is_integer() || value.as_float().is_some_and(f64::is_finite));
    number.unwrap_or_else(|| Value::from(text))
}
