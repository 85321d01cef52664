//! The methods of the studies: the schemes of this program, and those to compare with.

use std::f64::consts::SQRT_2;

use super::work_precision::OUTPUTS;
use crate::case::{Form, SbpName};
use crate::methods::{About, PEERS, Peer, Setting, Step};

/// Those of [`PEERS`] that are not charted: they differ from another one in rounding, or in their number of stages.
const NOT_CHARTED: [&str; 3] = ["Kahan-Li 8 compensated", "Gauss 6", "Gauss 12"];

/// A method.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Method {
    /// One block of a finite-difference operator over all nodes.
    Block(SbpName, Form),
    /// The same operator in windows of [`WINDOW`](super::stability::WINDOW) intervals.
    Windows(SbpName, Form),
    /// The weak form on spectral elements with this many nodes, one per window.
    Elements(usize),
    /// The paper's strong form with D in place of D̄. It is solved as the doubled system, on small grids only.
    Unregularised(SbpName),
    /// The windows of elements as the library of this program has them, without certificate and storage.
    March(usize),
    /// The windows that this program chooses for an accuracy of the run.
    Accuracy,
    /// Those that it chooses for a tolerance of each of them.
    Tolerance,
    /// One of [`PEERS`].
    Peer(Peer),
    /// A method of this name that another program measured.
    Other(String),
}

impl Method {
    /// Every method that `stability` charts by default.
    pub fn charted() -> Vec<Self> {
        let mut all = Vec::new();
        for form in [Form::Strong, Form::Weak] {
            all.extend(SbpName::STENCILS.map(|sbp| Self::Block(sbp, form)));
        }
        all.extend([Form::Strong, Form::Weak].map(|form| Self::Windows(SbpName::Sbp21, form)));
        all.push(Self::Windows(SbpName::Sbp42, Form::Weak));
        all.extend([4, 8, 16].map(Self::Elements));
        all.extend([SbpName::Sbp21, SbpName::Sbp42].map(Self::Unregularised));
        all.extend([Self::Accuracy, Self::Tolerance]);
        all.extend(PEERS.into_iter().filter(|peer| !NOT_CHARTED.contains(&peer.name().as_str())).map(Self::Peer));
        all
    }

    /// Every method that `work-precision` measures by default.
    pub fn timed() -> Vec<Self> {
        let both = |sbp| [Self::Block(sbp, Form::Strong), Self::Block(sbp, Form::Weak)];
        let sizes = [4, 6, 8, 12, 16, 20, 24];
        let mut all: Vec<Self> = SbpName::STENCILS.into_iter().flat_map(both).collect();
        all.extend(sizes.map(Self::Elements));
        all.extend(sizes.map(Self::March));
        all.extend([Self::Accuracy, Self::Tolerance]);
        all.extend(PEERS.map(Self::Peer));
        all
    }

    /// The method of [`crate::methods`] that it is, if it is not solved on a grid.
    pub(super) fn peer(&self) -> Option<Peer> {
        match self {
            Self::March(nodes) => Some(Peer::Equal(*nodes)),
            Self::Accuracy => Some(Peer::Accuracy),
            Self::Tolerance => Some(Peer::Tolerance),
            Self::Peer(peer) => Some(*peer),
            _ => None,
        }
    }

    fn about(&self) -> Option<About> {
        self.peer().map(Peer::about)
    }

    /// Why there is no such method in a scene; `None` if there is.
    pub fn unsuitable(&self, is_separable: bool) -> Option<&'static str> {
        match self {
            Self::Unregularised(_) => Some("is for one coordinate"),
            Self::Peer(peer) => peer.unsuitable(is_separable),
            _ => None,
        }
    }

    /// The name without the form of the action.
    pub fn name(&self) -> String {
        match self {
            Self::Block(sbp, _) => sbp.to_string(),
            Self::Windows(sbp, _) => format!("{sbp} windows"),
            Self::Elements(nodes) => format!("GLL{nodes}"),
            Self::Unregularised(sbp) => format!("{sbp} unregularised"),
            Self::Other(name) => name.clone(),
            _ => self.about().map_or_else(String::new, |about| about.name),
        }
    }

    /// The form of the action, for schemes of this program.
    pub fn form(&self) -> Option<Form> {
        match self {
            Self::Block(_, form) | Self::Windows(_, form) => Some(*form),
            Self::Unregularised(_) => Some(Form::Strong),
            Self::Elements(_) | Self::March(_) | Self::Accuracy | Self::Tolerance => Some(Form::Weak),
            Self::Peer(_) | Self::Other(_) => None,
        }
    }

    /// Name and form, for display and for the command line.
    pub fn label(&self) -> String {
        match self {
            Self::Block(_, form) | Self::Windows(_, form) => format!("{} {}", self.name(), form.as_str()),
            Self::Elements(_) => format!("{} weak", self.name()),
            _ => self.name(),
        }
    }

    /// The curve that it shares with its kin where speed is drawn against accuracy: its place among all curves, and its
    /// entry in the legend.
    pub fn curve(&self) -> (usize, String) {
        let (place, label) = match self {
            Self::Block(_, Form::Strong) | Self::Windows(_, Form::Strong) | Self::Unregularised(_) => (0, "SBP strong"),
            Self::Block(..) | Self::Windows(..) => (1, "SBP weak"),
            Self::Elements(_) => (2, "GLL weak"),
            // The first word is the program, and the rest a setting of it.
            Self::Other(name) => (usize::MAX, name.split(' ').next().unwrap_or(name)),
            _ => {
                let curve = self.about().map_or("", |about| about.curve);
                let place = PEERS.iter().position(|peer| peer.about().curve == curve);
                (place.map_or(3, |place| 4 + place), curve)
            }
        };
        (place, label.to_owned())
    }

    /// Returns true if it belongs to this program.
    pub fn is_own(&self) -> bool {
        self.form().is_some()
    }

    /// Returns true if its results are certified: it calls [`crate::solve()`] and not the library below that.
    pub fn is_certified(&self) -> bool {
        matches!(self, Self::Block(..) | Self::Windows(..) | Self::Elements(_) | Self::Accuracy)
    }

    /// The rule by which its steps, windows or nodes are chosen.
    pub(super) fn step(&self) -> Step {
        self.about().map_or(Step::Constant, |about| about.step)
    }

    /// Returns true if it chooses its steps by a tolerance.
    pub fn is_adaptive(&self) -> bool {
        self.step() == Step::Adaptive
    }

    /// Its settings, from cheap to expensive and without a last one for constant steps. The world-line takes `scale`
    /// Taylor steps of the reference, which are pieces of similar difficulty.
    pub(super) fn settings(&self, scale: f64) -> Box<dyn Iterator<Item = Setting>> {
        if self.is_adaptive() {
            return Box::new((2..=15).map(|digits| Setting::tolerance(10.0_f64.powi(-digits))));
        }
        // The number of steps per piece at the coarsest setting, the factor from setting to setting, and whether points
        // of output may lie anywhere between the ends of steps.
        let (coarsest, factor, has_dense_output) = match (self, self.about()) {
            (_, Some(about)) => (about.coarsest, SQRT_2, about.has_dense_output),
            (Self::Elements(_), _) => (0.05, SQRT_2, false),
            _ => (2.0, 2.0, false),
        };
        let unit = if has_dense_output { 1 } else { OUTPUTS };
        let first = (coarsest * scale / unit as f64).max(1.0);
        let steps = (0..).map(move |k| unit * (first * f64::powi(factor, k)).round() as usize);
        let mut last = 0;
        Box::new(steps.filter(move |&steps| std::mem::replace(&mut last, steps) != steps).map(Setting::steps))
    }

    /// A setting for display.
    pub(super) fn setting(&self, setting: Setting) -> String {
        let Setting { count, tolerance } = setting;
        let inner = if tolerance > 0.0 { format!(" tol={tolerance:e}") } else { String::new() };
        match self {
            Self::Elements(_) | Self::March(_) => format!("windows={count}{inner}"),
            Self::Peer(peer) => peer.label(setting),
            Self::Accuracy | Self::Tolerance | Self::Other(_) => format!("tol={tolerance:e}"),
            _ => format!("N={}", count + 1),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The first setting has as many steps a piece as the method says, up to a multiple of the points of output, and
    /// each further one more by a factor.
    #[test]
    fn settings_begin_with_some_steps_a_piece() {
        let counts = |method: Method, scale: f64| method.settings(scale).take(3).map(|s| s.count).collect::<Vec<_>>();
        assert_eq!(counts(Method::March(20), 400.0), [20, 28, 40]);
        assert_eq!(counts(Method::Elements(20), 400.0 * OUTPUTS as f64), [20, 28, 40].map(|count| count * OUTPUTS));
        let block = Method::Block(SbpName::Sbp42, Form::Strong);
        assert_eq!(counts(block, 50.0 * OUTPUTS as f64), [100, 200, 400].map(|count| count * OUTPUTS));
        // There is one step between two points of output at least.
        assert_eq!(counts(Method::Elements(20), 1.0)[0], OUTPUTS);
        let tolerances: Vec<f64> = Method::Accuracy.settings(400.0).map(|setting| setting.tolerance).collect();
        assert!(tolerances[0] == 1e-2 && *tolerances.last().unwrap() == 1e-15);
    }
}
