//! The slopes of a sweep, and when they should not be read as orders.

use super::fit::{Fit, points_above_plateau, range};
use super::{Convergence, Quantity};
use crate::case::{Form, SbpName};
use crate::number::Real;

/// The fitted slope of one quantity, for one operator and form.
#[derive(Debug, Clone)]
pub struct Slope {
    /// Operator.
    pub sbp: SbpName,
    /// Form of the action.
    pub form: Form,
    /// The quantity that was fitted.
    pub quantity: Quantity,
    /// Its name in files.
    pub name: String,
    /// The fit; `None` with fewer than two points above the rounding plateau.
    pub fit: Option<Fit>,
    /// Smallest and largest N of the fit; `None` without points.
    pub n_range: Option<(usize, usize)>,
    /// Number of points of the fit.
    pub points: usize,
    /// First N on the rounding plateau, if the sweep reaches it.
    pub plateau_from: Option<usize>,
    /// Smallest N from which on the local slopes agree, if they do.
    pub asymptotic_from: Option<usize>,
}

impl Slope {
    /// The operator, and the form if it is not that of the paper.
    pub fn scheme(&self) -> String {
        match self.form {
            Form::Strong => self.sbp.to_string(),
            Form::Weak => format!("{} weak", self.sbp),
        }
    }

    /// A warning, if the number should not be read as an order.
    pub fn warning(&self) -> Option<String> {
        self.doubt().map(|doubt| format!("{} {}: {doubt}", self.scheme(), self.name))
    }

    /// The warnings of several slopes; those of the same scheme that say the same are one.
    pub fn warnings(slopes: &[Self]) -> Vec<String> {
        let mut found: Vec<(String, Vec<&str>, String)> = Vec::new();
        for (slope, doubt) in slopes.iter().filter_map(|slope| Some((slope, slope.doubt()?))) {
            let scheme = slope.scheme();
            match found.iter_mut().find(|(other, _, same)| *other == scheme && *same == doubt) {
                Some((_, names, _)) => names.push(&slope.name),
                None => found.push((scheme, vec![&slope.name], doubt)),
            }
        }
        let one = |(scheme, names, doubt): (String, Vec<&str>, String)| match names.as_slice() {
            [first, _, .., last] => format!("{scheme} {first} … {last} ({}): {doubt}", names.len()),
            names => format!("{scheme} {}: {doubt}", names.join(", ")),
        };
        found.into_iter().map(one).collect()
    }

    /// Why the number should not be read as an order, and what to do.
    fn doubt(&self) -> Option<String> {
        match &self.fit {
            None if self.plateau_from.is_some() => {
                Some("no slope, the errors are rounding; sweep coarser grids with --n-gamma".to_owned())
            }
            None => {
                Some("no slope, fewer than two grids were solved in the range; sweep more with --n-gamma".to_owned())
            }
            Some(fit) if !fit.is_asymptotic() => {
                let (low, high) = range(&fit.local_slopes);
                let finest = self.n_range.map_or(0, |(_, finest)| finest);
                let remedy = match self.asymptotic_from {
                    Some(coarsest) => format!("fit finer grids: --fit-range {coarsest}:{finest}"),
                    None if self.plateau_from.is_some() => "sweep more grids above the rounding level".to_owned(),
                    None => format!("sweep finer grids: --n-gamma {finest},{},{}", 2 * finest, 4 * finest),
                };
                Some(format!("not asymptotic ({low:.2} to {high:.2}); {remedy}"))
            }
            Some(_) => None,
        }
    }
}

impl<S: Real> Convergence<S> {
    /// The slopes of every operator, form and quantity over the grids with `n_range.0` ≤ N ≤ `n_range.1` whose errors
    /// lie above the rounding plateau.
    pub fn slopes(&self, n_range: (usize, usize)) -> Vec<Slope> {
        let quantities = Quantity::all(self.coordinates.len());
        let of_scheme = |scheme| quantities.iter().map(move |&quantity| self.slope(scheme, quantity, n_range));
        self.schemes().into_iter().flat_map(of_scheme).collect()
    }

    /// Every operator and form, in order.
    pub fn schemes(&self) -> Vec<(SbpName, Form)> {
        let mut schemes: Vec<(SbpName, Form)> = self.points.iter().map(|point| (point.sbp, point.form)).collect();
        schemes.dedup();
        schemes
    }

    /// The slope of one quantity for one operator and form.
    pub fn slope(&self, (sbp, form): (SbpName, Form), quantity: Quantity, n_range: (usize, usize)) -> Slope {
        let (mut delta_gamma, mut n_gamma, mut errors) = (Vec::new(), Vec::new(), Vec::new());
        for point in self.points.iter().filter(|point| (point.sbp, point.form) == (sbp, form)) {
            let in_range = (n_range.0..=n_range.1).contains(&point.n_gamma);
            let error = point.errors.as_ref().map(|errors| quantity.of(errors));
            if let Some(error) = error.filter(|error| in_range && error.is_finite()) {
                delta_gamma.push(point.delta_gamma);
                n_gamma.push(point.n_gamma);
                errors.push(error);
            }
        }
        let size = quantity.pick(&self.reference.sizes);
        let kept = points_above_plateau(&delta_gamma, &n_gamma, &errors, size, self.digits);
        let fit = Fit::new(&delta_gamma[..kept], &n_gamma[..kept], &errors[..kept]);
        Slope {
            sbp,
            form,
            quantity,
            name: quantity.name(&self.coordinates),
            asymptotic_from: fit.as_ref().and_then(Fit::asymptotic_from).map(|first| n_gamma[first]),
            fit,
            n_range: n_gamma[..kept].first().copied().zip(n_gamma[..kept].last().copied()),
            points: kept,
            plateau_from: n_gamma.get(kept).copied(),
        }
    }
}
