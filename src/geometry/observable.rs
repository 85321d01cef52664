//! Formulas of a state: what a user wants to see conserved, or where a run is to end.

use std::collections::BTreeMap;

use super::parts;
use super::text::{GeometryError, GeometryText, Place};
use crate::formula::{self, Graph, Names, Program};
use crate::number::Real;

/// A formula in the positions `q`, the velocities `q_dot` and the momenta `p_q` of a scene, in `norm`, which is K at
/// the start, and in the parameters and definitions of the scene.
#[derive(Debug, Clone)]
pub struct Observable<S = f64> {
    program: Program<S>,
    registers: Vec<S>,
    /// True if velocities and momenta are those of the reversed motion.
    is_reversed: bool,
}

/// The names that an observable may use of a scene with these coordinates: all positions, all velocities, all momenta
/// and the norm.
pub fn observed(coordinates: &[String]) -> Vec<String> {
    let velocities = coordinates.iter().map(|name| format!("{name}_dot"));
    let momenta = coordinates.iter().map(|name| format!("p_{name}"));
    coordinates.iter().cloned().chain(velocities).chain(momenta).chain(["norm".to_owned()]).collect()
}

impl<S: Real> Observable<S> {
    /// Compiles the formula `text` for the scene `geometry`, whose text gives the parameters. Mistakes are reported at
    /// `place`.
    ///
    /// # Errors
    /// [`GeometryError::Formula`] with the mistake.
    pub fn new(text: &str, scene: &GeometryText, place: Place) -> Result<Self, GeometryError> {
        let all = observed(&scene.coordinates());
        let variables: Vec<&str> = all.iter().map(String::as_str).collect();
        let parameters: BTreeMap<String, S> = parts::parameters(scene.parameters())?;
        let mut graph = Graph::default();
        let definitions = parts::definitions(&mut graph, &scene.positions(), &parameters, scene)?;
        let (parameters, definitions, tables) = (&parameters, &definitions, scene.tables());
        let names = Names { variables: &variables, parameters, definitions, tables };
        let node = formula::parse(text, names, &mut graph).map_err(|error| GeometryError::Formula(place, error))?;
        let program = Program::new(&mut graph, variables.len(), &[node]);
        Ok(Self { registers: program.registers(|constant| constant), program, is_reversed: false })
    }

    /// The same, which is given velocities and momenta of the reversed motion.
    pub fn of_reversed(self) -> Self {
        Self { is_reversed: true, ..self }
    }

    /// The value at a state, where `norm` is K at the start.
    pub fn at(&mut self, q: &[S], q_dot: &[S], p: &[S], norm: S) -> S {
        let n = q.len();
        for (place, values) in [q, q_dot, p].into_iter().enumerate() {
            self.registers[place * n..][..n].copy_from_slice(values);
        }
        if self.is_reversed {
            self.registers[n..3 * n].iter_mut().for_each(|rate| *rate = -*rate);
        }
        self.registers[3 * n] = norm;
        self.program.run(1, &mut self.registers);
        self.registers[self.program.output(0)]
    }
}
