//! A scene with everything at once: off-diagonal components, a one-form, a force, and coefficients that depend on time.

use geodesic_ivp::diagnostics::Diagnostics;
use geodesic_ivp::number::{Extended, Real};
use geodesic_ivp::solve::WorldLine;

use crate::common::{line_of, parsed};

/// Coordinates t, x, y and z; z is ignorable and coupled to x.
const SCENE: &str = "initial = { t = 0.1, x = 0.5, y = -0.2, z = 0.3, \
     t_dot = 1, x_dot = 0.3, y_dot = -0.4, z_dot = 0.2 }\n\
     metric.coordinates = ['t', 'x', 'y', 'z']\nmetric.components = { 't t' = '1 + x^2/4', 't x' = '0.2*cos(t)', \
     'x x' = '-1 - y^2/10', 'y y' = '-1', 'x z' = '0.3*y', 'z z' = '-2 - sin(x)' }\nparameters.k = 0.3\n\
     metric.one_form = { x = '0.1*y', y = '0.2*x*t' }\n\
     metric.force = { t = '0.05*x_dot^2', x = '-k*x_dot', y = '-k*y_dot*t_dot' }\n";

const FORMS: [&str; 2] = ["strong", "weak"];
const SYSTEMS: [&str; 2] = ["physical-limit", "doubled"];

fn solved<S: Real>(sbp: &str, [form, system]: [&str; 2], n_gamma: usize, windows: usize) -> WorldLine<S> {
    let digits = if S::IS_EXTENDED { 40 } else { 16 };
    let grid = format!("grid={{gamma_f=2.0,n_gamma={n_gamma},windows={windows}}}");
    let scheme = format!("scheme={{sbp='{sbp}',form='{form}'}}");
    line_of(&parsed(SCENE, &[&grid, &scheme, &format!("solver={{system='{system}',digits={digits}}}")]))
}

fn error(line: &WorldLine<f64>, exact: &[f64]) -> f64 {
    line.end().q.iter().zip(exact).fold(0.0, |most: f64, (q, exact)| most.max((q - exact).abs()))
}

#[test]
fn every_operator_has_its_order_in_both_forms() {
    let exact = solved::<f64>("GLL20", ["weak", "physical-limit"], 20, 8).end().q;
    let orders = [("SBP21", [2.0, 2.0]), ("SBP42", [3.0, 4.0]), ("SBP63", [4.0, 6.0]), ("SBP84", [5.0, 8.0])];
    for (sbp, orders) in orders {
        for (form, order) in FORMS.into_iter().zip(orders) {
            let nodes = if order > 6.0 { [25, 37] } else { [61, 121] };
            let [coarse, fine] = nodes.map(|nodes| error(&solved(sbp, [form, "physical-limit"], nodes, 1), &exact));
            let slope = (coarse / fine).ln() / ((nodes[1] - 1) as f64 / (nodes[0] - 1) as f64).ln();
            assert!(slope > order - 0.35, "{sbp} {form}: {coarse:e}, {fine:e}, slope {slope}");
        }
    }
}

#[test]
fn the_physical_limit_is_a_critical_point_of_the_whole_action() {
    for (sbp, n_gamma) in [("SBP21", 12), ("SBP42", 12), ("SBP63", 16), ("GLL12", 12)] {
        for form in FORMS {
            let [limit, doubled] = SYSTEMS.map(|system| solved::<f64>(sbp, [form, system], n_gamma, 1));
            let bound = 1e-13 * n_gamma as f64 * limit.sbp().stiffness().powi(2);
            assert!(limit.gradient_norm < bound, "{sbp} {form}: {:e}", limit.gradient_norm);
            assert!(doubled.branch_distance() < 1e-11, "{sbp} {form}: {:e}", doubled.branch_distance());
            let apart = error(&doubled, &limit.end().q);
            assert!(apart < 1e-11, "{sbp} {form}: the systems end {apart:e} apart");
            let [doubled, limit] = [doubled, limit].map(|line| line.end().p);
            let momenta = doubled.iter().zip(&limit);
            assert!(momenta.clone().all(|(a, b)| (a - b).abs() < 1e-10), "{sbp} {form}: {momenta:?}");
        }
    }
}

#[test]
fn the_charge_of_an_ignorable_coordinate_is_exact_beside_everything_else() {
    for [form, system] in FORMS.into_iter().flat_map(|form| SYSTEMS.map(|system| [form, system])) {
        let line = solved::<Extended>("SBP42", [form, system], 24, 1);
        assert_eq!(line.geometry().ignorable().collect::<Vec<_>>(), [3]);
        let measured = Diagnostics::new(&line);
        let charge = &measured.charges[0];
        assert!(charge.max_interior.to_f64() < 1e-36, "{form} {system}: {:e}", charge.max_interior.to_f64());
        assert!(charge.max_corrected.to_f64() < 1e-36, "{form} {system}");
        assert!(measured.max_delta_g.to_f64() < 1e-34, "{form} {system}: {:e}", measured.max_delta_g.to_f64());
        assert!(form == "weak" || charge.max_last.to_f64() > 1e-9, "the last node takes up a defect");
    }
}
