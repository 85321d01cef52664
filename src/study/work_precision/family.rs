//! The methods of `work-precision` and their ranges of settings.

use std::f64::consts::SQRT_2;

use super::OUTPUTS;
use crate::case::{Form, SbpName};
use crate::methods::{PEERS, Peer, Setting, Step};

/// A method with a range of settings.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Family {
    /// This program: one block of a finite-difference operator over all nodes.
    Block(SbpName, Form),
    /// This program: the weak form on spectral elements with this many nodes, in windows.
    Elements(usize),
    /// The library of this program: the windows of the same scheme, without certificate and storage.
    March(usize),
    /// This program: windows chosen for an accuracy that the run keeps.
    Accuracy,
    /// This program: windows chosen for a tolerance of each of them.
    Tolerance,
    /// One of [`PEERS`].
    Peer(&'static dyn Peer),
    /// A method of this name that another program measured.
    Other(String),
}

/// A group of methods, which are drawn as one curve.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[allow(missing_docs)] // As in `Family`.
pub enum Group {
    StrongBlocks,
    WeakBlocks,
    Elements,
    March,
    Accuracy,
    Tolerance,
    /// Those of [`PEERS`] that share a curve with the one of this index, which is the first of them.
    Peer(usize),
    Other,
}

impl Group {
    /// Entry of the legend.
    pub fn label(self) -> &'static str {
        match self {
            Self::StrongBlocks => "SBP strong",
            Self::WeakBlocks => "SBP weak",
            Self::Elements => "GLL weak",
            Self::March => "GLL march (library)",
            Self::Accuracy => "accuracy",
            Self::Tolerance => "tolerance",
            Self::Peer(first) => PEERS[first].about().curve,
            Self::Other => "measured elsewhere",
        }
    }

    /// Returns true if it belongs to this program.
    pub fn is_own(self) -> bool {
        self <= Self::Tolerance
    }
}

impl Family {
    /// Every method that is measured by default.
    pub fn all() -> Vec<Self> {
        let both = |sbp| [Self::Block(sbp, Form::Strong), Self::Block(sbp, Form::Weak)];
        let sizes = [4, 6, 8, 12, 16, 20, 24];
        let mut all: Vec<Self> = SbpName::STENCILS.into_iter().flat_map(both).collect();
        all.extend(sizes.map(Self::Elements));
        all.extend(sizes.map(Self::March));
        all.extend([Self::Accuracy, Self::Tolerance]);
        all.extend(PEERS.map(Self::Peer));
        all
    }

    /// Why there is no such method in a scene; `None` if there is.
    pub fn unsuitable(&self, is_separable: bool) -> Option<&'static str> {
        match self {
            Self::Peer(peer) => peer.unsuitable(is_separable),
            _ => None,
        }
    }

    /// The name in files.
    pub fn name(&self) -> String {
        match self {
            Self::Block(sbp, form) => format!("{sbp} {}", form.as_str()),
            Self::Elements(nodes) => format!("GLL{nodes} weak"),
            Self::March(nodes) => format!("GLL{nodes} march"),
            Self::Accuracy => "accuracy".to_owned(),
            Self::Tolerance => "tolerance".to_owned(),
            Self::Peer(peer) => peer.name(),
            Self::Other(name) => name.clone(),
        }
    }

    /// The curve it belongs to.
    pub fn group(&self) -> Group {
        match self {
            Self::Block(_, Form::Strong) => Group::StrongBlocks,
            Self::Block(_, Form::Weak) => Group::WeakBlocks,
            Self::Elements(_) => Group::Elements,
            Self::March(_) => Group::March,
            Self::Accuracy => Group::Accuracy,
            Self::Tolerance => Group::Tolerance,
            Self::Peer(peer) => {
                let curve = peer.about().curve;
                PEERS.iter().position(|other| other.about().curve == curve).map_or(Group::Other, Group::Peer)
            }
            Self::Other(_) => Group::Other,
        }
    }

    /// Returns true if it belongs to this program.
    pub fn is_own(&self) -> bool {
        self.group().is_own()
    }

    /// Returns true if its results are certified: it calls [`crate::solve()`] and not the library below that.
    pub fn is_certified(&self) -> bool {
        matches!(self, Self::Block(..) | Self::Elements(_) | Self::Accuracy)
    }

    /// The rule by which its steps, windows or nodes are chosen.
    pub(super) fn step(&self) -> Step {
        match self {
            Self::Peer(peer) => peer.about().step,
            Self::March(_) => Step::Iterated,
            Self::Accuracy | Self::Tolerance => Step::Adaptive,
            Self::Block(..) | Self::Elements(_) | Self::Other(_) => Step::Constant,
        }
    }

    /// Its settings, from cheap to expensive and without a last one for constant steps. The world-line takes `scale`
    /// Taylor steps of the reference, which are pieces of similar difficulty.
    pub(super) fn settings(&self, scale: f64) -> Box<dyn Iterator<Item = Setting>> {
        if self.step() == Step::Adaptive {
            return Box::new((2..=15).map(|digits| Setting::tolerance(10.0_f64.powi(-digits))));
        }
        // The number of steps per piece at the coarsest setting, the factor from setting to setting, and whether points
        // of output may lie anywhere between the ends of steps.
        let (coarsest, factor, has_dense_output) = match self {
            Self::Block(..) => (2.0, 2.0, false),
            Self::Peer(peer) => (peer.about().coarsest, SQRT_2, peer.about().has_dense_output),
            _ => (0.05, SQRT_2, matches!(self, Self::March(_))),
        };
        let unit = if has_dense_output { 1 } else { OUTPUTS };
        let first = (coarsest * scale / unit as f64).max(1.0);
        let steps = (0..).map(move |k| unit * (first * f64::powi(factor, k)).round() as usize);
        let mut last = 0;
        Box::new(steps.filter(move |&steps| std::mem::replace(&mut last, steps) != steps).map(Setting::steps))
    }

    /// A setting for display.
    pub(super) fn label(&self, setting: &Setting) -> String {
        let Setting { count, tolerance } = *setting;
        let inner = if tolerance > 0.0 { format!(" tol={tolerance:e}") } else { String::new() };
        match self {
            Self::Block(..) => format!("N={}", count + 1),
            Self::Elements(_) | Self::March(_) => format!("windows={count}{inner}"),
            Self::Peer(peer) => peer.label(*setting),
            Self::Accuracy | Self::Tolerance | Self::Other(_) => format!("tol={tolerance:e}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Family, Form, OUTPUTS, SbpName};

    /// The first setting has as many steps a piece as the family says, up to a multiple of the points of output, and
    /// each further one more by a factor.
    #[test]
    fn settings_begin_with_some_steps_a_piece() {
        let counts = |family: Family, scale: f64| family.settings(scale).take(3).map(|s| s.count).collect::<Vec<_>>();
        assert_eq!(counts(Family::March(20), 400.0), [20, 28, 40]);
        assert_eq!(counts(Family::Elements(20), 400.0 * OUTPUTS as f64), [20, 28, 40].map(|count| count * OUTPUTS));
        let block = Family::Block(SbpName::Sbp42, Form::Strong);
        assert_eq!(counts(block, 50.0 * OUTPUTS as f64), [100, 200, 400].map(|count| count * OUTPUTS));
        // There is one step between two points of output at least.
        assert_eq!(counts(Family::Elements(20), 1.0)[0], OUTPUTS);
        let tolerances: Vec<f64> = Family::Accuracy.settings(400.0).map(|setting| setting.tolerance).collect();
        assert!(tolerances[0] == 1e-2 && *tolerances.last().unwrap() == 1e-15);
    }
}
