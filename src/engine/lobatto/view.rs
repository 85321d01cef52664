//! What an observer sees of a window.

use super::State;
use super::rule::WeakRule;
use crate::number::vector::Twofold;

/// A window that has just been solved. Everything beyond its two ends and X is computed on request.
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
    pub(super) nodes: NodeValues<'a>,
    pub(super) certified: Option<Certified<'a>>,
}

/// What a certified march knows of a window.
#[derive(Debug, Clone, Copy)]
pub struct Certified<'a> {
    /// t on the n nodes, counted from the start of the window, so that it loses no digits.
    pub elapsed: &'a [f64],
    /// The largest entry of the gradient of the weak action at the window; infinite where a number overflows.
    pub gradient_norm: f64,
}

/// X, u = dt/ds and a = d²x/ds² on the nodes, where s = γ/unit.
#[derive(Debug, Clone, Copy)]
pub(super) struct NodeValues<'a> {
    pub(super) x: &'a [f64],
    pub(super) u: &'a [f64],
    pub(super) a: &'a [f64],
    pub(super) unit: f64,
}

/// A point inside a window.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Inside {
    /// t.
    pub t: f64,
    /// x.
    pub x: f64,
    /// w = dx/dγ.
    pub w: f64,
}

impl<'a> WindowView<'a> {
    /// A window that somebody has kept, from the first of `ends` to the second, with u = dt/dγ and a = d²x/dγ² on the
    /// nodes of `rule`. It does not know x there.
    pub(crate) fn stored(rule: &'a WeakRule, length: f64, ends: [Inside; 2], [u, a]: [&'a [f64]; 2]) -> Self {
        let [start, end] = ends.map(|end| State { t: end.t.into(), x: end.x.into(), w: end.w.into() });
        let nodes = NodeValues { x: &[], u, a, unit: 1.0 };
        Self { index: 0, gamma: Twofold::ZERO, length: length.into(), rule, start, end, nodes, certified: None }
    }

    /// X on the n nodes.
    pub fn x(&self) -> &'a [f64] {
        self.nodes.x
    }

    /// W = w + h A a on the n nodes, the scheme's own.
    pub fn w(&self) -> Vec<f64> {
        let [_, a] = self.scales();
        self.integral(self.start.w, a, self.nodes.a)
    }

    /// T = t + h A u on the n nodes, the scheme's own.
    pub fn t(&self) -> Vec<f64> {
        let [u, _] = self.scales();
        self.integral(self.start.t, u, self.nodes.u)
    }

    /// What certified marches add, see [`Certified`].
    pub fn certified(&self) -> Option<Certified<'a>> {
        self.certified
    }

    /// The factors that turn integrals over [0, 1] of the nodal values of u and a into t and w.
    pub(super) fn scales(&self) -> [f64; 2] {
        let scale = self.length.hi / self.nodes.unit;
        [scale, scale / self.nodes.unit]
    }

    fn integral(&self, start: Twofold, scale: f64, values: &[f64]) -> Vec<f64> {
        let rows = self.rule.a().chunks(self.rule.points());
        rows.map(|row| {
            let sum: f64 = row.iter().zip(values).map(|(a, v)| a.hi * v).sum();
            start.hi + (start.lo + scale * sum)
        })
        .collect()
    }
}
