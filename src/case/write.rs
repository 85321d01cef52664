//! Writing a case as text.

use super::{Case, Decimal, FormulaSpec, Initial, PotentialSpec, Scheme, parse};

impl Case {
    /// The case as TOML, with every default filled in. Reading that text gives the same case.
    pub fn to_toml(&self) -> String {
        let text = toml::to_string(self).expect("every case can be written as TOML");
        let mut case = self.clone();
        let chosen: &[&str] = match self.solver.chooses_windows() {
            true if self.scheme == Scheme::default() => &["grid.n_gamma", "grid.windows", "scheme"],
            true => &["grid.n_gamma", "grid.windows"],
            false => &[],
        };
        parse::with_literals(&text, &case.numbers_mut(), chosen)
    }

    /// Every number of the case with its dotted key; for an element of an array the last part of the key is its index.
    pub(super) fn numbers_mut(&mut self) -> Vec<(String, &mut Decimal)> {
        let Initial { t, x, t_dot, x_dot, velocity } = &mut self.initial;
        let mut numbers = vec![
            ("particle.mass".to_owned(), &mut self.particle.mass),
            ("particle.c".to_owned(), &mut self.particle.c),
            ("initial.t".to_owned(), t),
            ("initial.x".to_owned(), x),
            ("initial.t_dot".to_owned(), t_dot),
            ("grid.gamma_i".to_owned(), &mut self.grid.gamma_i),
        ];
        let [t_final, x_final, tolerance] = match &mut self.expect {
            Some(expect) => [expect.t_final.as_mut(), expect.x_final.as_mut(), expect.tolerance.as_mut()],
            None => [None, None, None],
        };
        let optional = [
            ("initial.x_dot", x_dot.as_mut()),
            ("initial.velocity", velocity.as_mut()),
            ("grid.gamma_f", self.grid.gamma_f.as_mut()),
            ("grid.t_f", self.grid.t_f.as_mut()),
            ("expect.t_final", t_final),
            ("expect.x_final", x_final),
            ("expect.tolerance", tolerance),
            ("solver.accuracy", self.solver.accuracy.as_mut()),
            ("solver.tolerance", self.solver.tolerance.as_mut()),
        ];
        numbers.extend(optional.into_iter().filter_map(|(path, number)| Some((path.to_owned(), number?))));
        match &mut self.potential {
            PotentialSpec::Free {} => {}
            PotentialSpec::Linear { alpha } => numbers.push(("potential.linear.alpha".to_owned(), alpha)),
            PotentialSpec::Quartic { kappa } => numbers.push(("potential.quartic.kappa".to_owned(), kappa)),
            PotentialSpec::Polynomial { coefficients } => {
                let path = |k| format!("potential.polynomial.coefficients.{k}");
                numbers.extend(coefficients.iter_mut().enumerate().map(|(k, c)| (path(k), c)));
            }
            PotentialSpec::Formula(FormulaSpec { parameters, .. }) => {
                let path = |name: &String| format!("potential.formula.parameters.{name}");
                numbers.extend(parameters.iter_mut().map(|(name, value)| (path(name), value)));
            }
        }
        numbers
    }
}
