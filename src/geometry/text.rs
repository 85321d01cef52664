//! A scene as text: what a case file says about the metric, and what is wrong with it.

use std::ops::Range;

use crate::formula::FormulaError;
use crate::number::Real;
use crate::number::spline::Table;

/// A scene as text: a metric in formulas of its coordinates, or particles in a potential.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct GeometryText {
    /// The names of the coordinates, of a potential those of V besides t.
    pub coordinates: Vec<String>,
    /// g_ab by the indices of a pair of coordinates. What is not given is zero; a pair stands for both orders.
    pub components: Vec<([usize; 2], String)>,
    /// The potential from which the metric follows, in place of components.
    pub potential: Option<Potential>,
    /// Named expressions in the coordinates, the parameters and each other.
    pub definitions: Vec<(String, String)>,
    /// Named constants: numbers, or formulas in each other.
    pub parameters: Vec<(String, String)>,
    /// A_a by the index of the coordinate, in a potential that of Newton's L = ½mv² − V + A·v. What is not given is
    /// zero.
    pub one_form: Vec<(usize, String)>,
    /// F_a in the coordinates and their derivatives `NAME_dot`, in a potential besides −∂V. What is not given is zero.
    /// The derivatives are with respect to γ, with [`Law::Newtonian`] to t.
    pub force: Vec<(usize, String)>,
    /// Ω in the coordinates: the metric is Ω times what the components say.
    pub conformal: Option<String>,
    /// One more coordinate, which makes K zero.
    pub tau: Option<Tau>,
    /// Functions that formulas may use.
    pub tables: Vec<(String, Table)>,
    /// Parameters that events set, and those that depend on them: no formula is simplified by their values.
    pub held: Vec<String>,
    /// Parameters that are no numbers, but variables behind all others: a proof is about all of their values.
    pub unknown: Vec<String>,
}

/// A potential, and the particle or the particles in it.
#[derive(Debug, Clone, PartialEq)]
pub struct Potential {
    /// V in t and the coordinates.
    pub expression: String,
    /// m, the mass in c² + 2V/m.
    pub mass: String,
    /// m_a of every coordinate, in t.
    pub masses: Vec<String>,
    /// The speed of light; not used by [`Law::Newtonian`].
    pub c: String,
    /// The law that the potential stands for.
    pub law: Law,
}

/// The flat coordinate `tau`, with which a particle with K ≠ 0 is one with K = 0. It is the last one, and coupled to no
/// other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Tau {
    /// K > 0: its component is −Ω.
    Timelike,
    /// K < 0: its component is Ω.
    Spacelike,
}

impl Tau {
    /// Its name.
    pub const NAME: &'static str = "tau";

    /// Its component, without Ω.
    pub fn component<S: Real>(self) -> S {
        match self {
            Self::Timelike => -S::ONE,
            Self::Spacelike => S::ONE,
        }
    }
}

/// The law that a potential stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Law {
    /// The paper's metric, diag(c² + 2V/m, −m_a/m, …): Newton's law for |V| ≪ mc² and speeds far below c.
    #[default]
    Relativistic,
    /// The lift L = ½(2V ṫ² + 2 ṫ ṡ − m_a (ẋ^a)²): exactly Newton's law (L. P. Eisenhart, Ann. of Math. 30 (1928) 591).
    Newtonian,
}

impl GeometryText {
    /// The potential V of a particle of mass 1, where c is 1.
    pub fn of_potential(coordinates: &[&str], expression: &str, law: Law) -> Self {
        let one = || "1".to_owned();
        let masses = coordinates.iter().map(|_| one()).collect();
        let potential = Potential { expression: expression.to_owned(), mass: one(), masses, c: one(), law };
        let coordinates = coordinates.iter().map(|&name| name.to_owned()).collect();
        Self { coordinates, potential: Some(potential), ..Self::default() }
    }

    /// V of x alone, of a particle of this mass, with this speed of light.
    pub fn of_x(expression: &str, mass: f64, c: f64) -> Self {
        let mut text = Self::of_potential(&["x"], expression, Law::Relativistic);
        let [mass, c] = [mass, c].map(|number| format!("{number:?}"));
        text.potential = text.potential.map(|potential| Potential { masses: vec![mass.clone()], mass, c, ..potential });
        text
    }

    /// The law that the potential stands for, if there is one.
    pub fn law(&self) -> Option<Law> {
        self.potential.as_ref().map(|potential| potential.law)
    }

    /// The energy of particles in a potential by Newton's law, V ṫ + Σ ½ m_a (ẋ^a)²/ṫ, as a formula of the state.
    pub(crate) fn energy(&self) -> Option<String> {
        let Potential { expression, masses, .. } = self.potential.as_ref()?;
        let terms = masses.iter().zip(&self.coordinates);
        let kinetic = terms.map(|(mass, x)| format!("({mass})*{x}_dot^2")).collect::<Vec<_>>().join(" + ");
        Some(format!("({expression})*t_dot + ({kinetic})/(2*t_dot)"))
    }

    /// The names of all coordinates, in order.
    pub fn names(&self) -> Vec<String> {
        let lifted = (self.law() == Some(Law::Newtonian)).then_some("s");
        let last = self.tau.map(|_| Tau::NAME).or(lifted);
        self.positions().into_iter().chain(last.map(str::to_owned)).collect()
    }

    /// The coordinates that formulas of positions may use; they are the first ones.
    pub(crate) fn positions(&self) -> Vec<String> {
        self.potential.iter().map(|_| "t".to_owned()).chain(self.coordinates.iter().cloned()).collect()
    }

    /// The coordinates whose momenta have the other sign than in mechanics: with Newton's law the Lagrangian is −1 of
    /// the one there, and g_aa = −m.
    pub(crate) fn mirrored(&self) -> Range<usize> {
        if self.law() == Some(Law::Newtonian) { 1..self.coordinates.len() + 1 } else { 0..0 }
    }

    /// Lets events set what of these names is a parameter.
    pub fn hold(&mut self, mut names: Vec<String>) {
        names.retain(|name| self.parameters.iter().any(|(parameter, _)| parameter == name));
        self.held = with_dependent(&self.parameters, names);
    }

    /// Returns true if one of these parameters is in a number of the law itself, which has to be one: in the mass of
    /// the relativistic law or in c.
    pub(crate) fn is_law_of(&self, parameters: &[String]) -> bool {
        let all = with_dependent(&self.parameters, parameters.to_vec());
        let of_law = self.potential.iter().filter(|of| of.law == Law::Relativistic);
        of_law.flat_map(|of| [&of.mass, &of.c]).any(|number| all.iter().any(|name| uses(number, name)))
    }
}

impl GeometryText {
    /// The parameters that formulas of the scene depend on, or that events set.
    pub(crate) fn parameters_in_use(&self) -> Vec<String> {
        let Self { components, potential, definitions, one_form, force, conformal, .. } = self;
        let of_potential =
            potential.iter().flat_map(|of| [&of.expression, &of.mass, &of.c].into_iter().chain(&of.masses));
        let of_pairs = components.iter().map(|(_, formula)| formula);
        let of_coordinates = one_form.iter().chain(force).map(|(_, formula)| formula);
        let of_names = definitions.iter().map(|(_, formula)| formula);
        let formulas = of_potential.chain(of_pairs).chain(of_coordinates).chain(of_names).chain(conformal);
        let mut formulas: Vec<&String> = formulas.collect();
        let mut used = self.held.clone();
        loop {
            let is_next = |(name, _): &&(String, String)| {
                !used.contains(name) && formulas.iter().any(|formula| uses(formula, name))
            };
            let Some((name, formula)) = self.parameters.iter().find(is_next) else { return used };
            used.push(name.clone());
            formulas.push(formula);
        }
    }

    /// Returns true if another scene has the same formulas, and the same numbers for these parameters: it is the same
    /// then if no formula depends on others.
    pub(crate) fn is_like(&self, other: &Self, parameters: &[String]) -> bool {
        let Self {
            coordinates,
            components,
            potential,
            definitions,
            parameters: own,
            one_form,
            force,
            conformal,
            tau,
            tables,
            held,
            unknown,
        } = self;
        let number = |all: &[(String, String)], name: &String| all.iter().find(|(other, _)| other == name).cloned();
        *coordinates == other.coordinates
            && *components == other.components
            && *potential == other.potential
            && *definitions == other.definitions
            && *one_form == other.one_form
            && *force == other.force
            && *conformal == other.conformal
            && *tau == other.tau
            && *tables == other.tables
            && *held == other.held
            && *unknown == other.unknown
            && parameters.iter().all(|name| number(own, name) == number(&other.parameters, name))
    }
}

/// These parameters, and those that depend on them.
pub(crate) fn with_dependent(parameters: &[(String, String)], mut names: Vec<String>) -> Vec<String> {
    let is_next = |text: &str, names: &[String]| names.iter().any(|name| uses(text, name));
    while let Some((next, _)) = parameters.iter().find(|(name, text)| !names.contains(name) && is_next(text, &names)) {
        names.push(next.clone());
    }
    names
}

/// The words of a text, in which names occur.
pub(super) fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_'))
}

/// Returns true if `name` occurs in the text as a word of its own.
pub(crate) fn uses(text: &str, name: &str) -> bool {
    words(text).any(|word| word == name)
}

/// One of the formulas of a scene.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Place {
    /// The component of a pair of coordinates.
    Component([usize; 2]),
    /// A definition.
    Definition(String),
    /// A parameter.
    Parameter(String),
    /// A_a of a coordinate.
    OneForm(usize),
    /// F_a of a coordinate.
    Force(usize),
    /// Ω.
    Conformal,
    /// V.
    Potential,
    /// The mass, or the mass of a coordinate.
    Mass(Option<usize>),
    /// c.
    SpeedOfLight,
}

/// A mistake in a scene.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum GeometryError {
    /// A formula is not understood.
    #[error("{1}")]
    Formula(Place, FormulaError),
    /// A parameter or a mass is not a finite number.
    #[error("not a finite number")]
    NotFinite(Place),
    /// Definitions or parameters that refer to each other in a circle, in order.
    #[error("the definitions are circular: {}", .0.join(" -> "))]
    Circular(Vec<String>),
    /// The metric has no inverse, or one that is too large, and what to do.
    #[error("{0}")]
    Metric(String, Option<String>),
}

impl GeometryError {
    /// The formula that it is about.
    pub fn place(&self) -> Option<&Place> {
        match self {
            Self::Formula(place, _) | Self::NotFinite(place) => Some(place),
            _ => None,
        }
    }
}
