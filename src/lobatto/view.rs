//! What an observer sees of a window.

use super::State;
use super::rule::WeakRule;
use super::twofold::Twofold;

/// A window that was just solved. Everything beyond the plain numbers is computed when it is asked for.
#[derive(Debug, Clone, Copy)]
pub struct WindowView<'a> {
    /// Index of the window.
    pub index: usize,
    /// γ − γ_i at its start.
    pub gamma: Twofold,
    /// Its length.
    pub length: Twofold,
    /// Its nodes and operators.
    pub rule: &'a WeakRule,
    /// The state at its start.
    pub start: State,
    /// The state at its end.
    pub end: State,
    /// X on the nodes.
    pub x: &'a [f64],
    /// dt/dγ = Q_t/g00(X) on the nodes.
    pub t_dot: &'a [f64],
    /// d²x/dγ² = a(X) on the nodes.
    pub acceleration: &'a [f64],
}

impl WindowView<'_> {
    /// W = w + h A a on the n nodes, the scheme's own.
    pub fn w(&self) -> Vec<f64> {
        self.integral(self.start.w, self.acceleration)
    }

    /// T = t + h A u on the n nodes, the scheme's own.
    pub fn t(&self) -> Vec<f64> {
        self.integral(self.start.t, self.t_dot)
    }

    /// t on the nodes, counted from the start of the window, where it costs no digits.
    pub fn elapsed(&self) -> Vec<f64> {
        self.integral(Twofold::ZERO, self.t_dot)
    }

    fn integral(&self, start: Twofold, values: &[f64]) -> Vec<f64> {
        let rows = self.rule.a().chunks(self.rule.points());
        rows.map(|row| {
            let sum: f64 = row.iter().zip(values).map(|(a, v)| a.hi * v).sum();
            start.hi + (start.lo + self.length.hi * sum)
        })
        .collect()
    }
}
