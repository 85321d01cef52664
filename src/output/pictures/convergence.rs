//! The pictures of `converge`: errors against the step.

use super::look;
use crate::case::Form;
use crate::output::chart::{Chart, Mark, Series, Style};
use crate::study::convergence::{Convergence, Slope};

/// With more schemes than this in one picture, the legend gives the fits and they are not drawn as lines.
const MOST_FITTED: usize = 4;

/// The errors of these slopes against Δγ with their fits, and dotted lines of each operator's order.
pub fn errors<S>(of: &str, convergence: &Convergence<S>, slopes: &[Slope]) -> Chart {
    let mut series = Vec::new();
    let mut guides: Vec<(i32, (f64, f64), f64)> = Vec::new();
    let crowded = slopes.len() > MOST_FITTED;
    for slope in slopes {
        let points: Vec<(usize, (f64, f64))> = (convergence.points.iter())
            .filter(|point| (point.sbp, point.form) == (slope.sbp, slope.form))
            .filter_map(|point| {
                let errors = point.errors.as_ref()?;
                Some((point.n_gamma, (point.delta_gamma, slope.quantity.of(errors))))
            })
            .collect();
        let all = points.iter().map(|&(_, place)| place).collect();
        let name = format!("{} {}", slope.scheme(), slope.quantity.symbol(&convergence.coordinates));
        let look = look::of_scheme(slope.sbp, slope.form);
        // x has filled symbols and t open ones.
        let is_time = slope.quantity.coordinate == Some(0);
        if crowded {
            let fitted = slope.fit.as_ref().map_or(String::new(), |fit| format!(", slope {:.2}", fit.slope));
            let mark = if is_time { Mark::DASHED_AND_OPEN_POINTS } else { Mark::LINE_AND_POINTS };
            series.push(Series::new(name + &fitted, mark, all).with_look(look));
            continue;
        }
        let mark = if is_time { Mark::OPEN_POINTS } else { Mark::POINTS };
        series.push(Series::new(name, mark, all).with_look(look));
        let Some((fit, (n_min, n_max))) = slope.fit.as_ref().zip(slope.n_range) else { continue };
        let in_range = points.iter().filter(|(n, _)| (n_min..=n_max).contains(n));
        let fitted: Vec<(f64, f64)> = in_range.map(|&(_, place)| place).collect();
        // The fitted line passes through the mean of the logarithms.
        let mean = |f: &dyn Fn(&(f64, f64)) -> f64| fitted.iter().map(f).sum::<f64>() / fitted.len() as f64;
        let (log_h, log_error) = (mean(&|p| p.0.ln()), mean(&|p| p.1.ln()));
        let line = |h: f64| (h, (log_error + fit.slope * (h.ln() - log_h)).exp());
        let ends = [fitted[0].0, fitted[fitted.len() - 1].0];
        let label = format!("slope {:.2}", fit.slope);
        series.push(Series::new(label, Mark::DASHED, ends.map(line).to_vec()).with_look(look));
        // The global error has one order more than the boundary closure; at the end of the weak form the error has the
        // order of the interior.
        let boundary_order = slope.sbp.boundary_order() as i32;
        let at_weak_end = slope.form == Form::Weak && slope.quantity.is_at_end;
        let order = if at_weak_end { 2 * boundary_order } else { boundary_order + 1 };
        if guides.iter().all(|(known, ..)| *known != order) {
            guides.push((order, fitted[fitted.len() - 1], ends[0]));
        }
    }
    for (order, (h, error), coarsest) in guides {
        // A factor of four below the data, so that the guide can be told from the fit.
        let points = vec![(h, error / 4.0), (coarsest, error / 4.0 * (coarsest / h).powi(order))];
        series.push(Series::new(format!("slope {order}"), Mark::DOTTED, points).with_look(Style::NEUTRAL));
    }
    let title = "How errors fall with the step: the steeper, the higher the order";
    Chart::new(title, of, ["step Δγ", "error"], series).log_log()
}
