//! The two pictures at the top of the README: the time mesh that emerges, and the charge beside that of another method.
//!
//! ```text
//! cargo bench --bench first_picture -- docs
//! ```
//!
//! Without the folder nothing is drawn. The other method is the classical Runge–Kutta method on the geodesic equations
//! with both unknowns, ẗ = −(g00′/g00) ṫ ẋ and ẍ = −½ g00′ ṫ², with one step an interval of the same grid.

use std::path::Path;
use std::{env, fs};

use geodesic_ivp::case::builtin;
use geodesic_ivp::diagnostics::Diagnostics;
use geodesic_ivp::output::{Chart, Mark, Scale, Series, Style};
use geodesic_ivp::{Case, Solution, solve};

/// The quartic case with the weak form of SBP42, and settings.
fn solved(settings: [&str; 2]) -> Result<Solution, Box<dyn std::error::Error>> {
    let settings = ["scheme.sbp=SBP42", "scheme.form=weak"].iter().chain(&settings).map(|&setting| setting.to_owned());
    let text = builtin::text("quartic").expect("it is built in");
    Ok(solve(&Case::parse("first picture", text, &settings.collect::<Vec<_>>())?)?)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let Some(folder) = env::args().skip(1).find(|argument| !argument.starts_with('-')) else { return Ok(()) };
    let short = solved(["grid.gamma_f=8.0", "grid.n_gamma=65"])?;
    let nodes: Vec<(f64, f64)> = short.t().zip(short.x().iter().copied()).collect();
    let axis = nodes.iter().map(|&(t, _)| (t, -1.3)).collect();
    let mesh = Chart {
        title: "Even steps in γ, uneven steps in t: short where the potential is high".to_owned(),
        x_label: "t".to_owned(),
        y_label: "x".to_owned(),
        series: vec![
            Series::new("x(t) on the nodes", Mark::LINE_AND_POINTS, nodes),
            Series::new("their times", Mark::POINTS, axis),
        ],
        ..Chart::default()
    };

    let long = solved(["grid.gamma_f=100.0", "grid.n_gamma=2001"])?;
    let own = Diagnostics::new(&long).charges[0].delta.iter().map(|delta| delta.abs()).collect::<Vec<_>>();
    let charge = Chart {
        title: "The charge Q_t over a hundred units of γ".to_owned(),
        x_label: "γ".to_owned(),
        y_label: "|ΔQ_t|".to_owned(),
        y_scale: Scale::Log,
        series: vec![
            Series::new("RK4 on the geodesic equations", Mark::LINE, runge_kutta(100.0, 2000))
                .with_look(Style::NEUTRAL),
            Series::new("SBP42, weak form, the same 2001 nodes", Mark::LINE, long.gamma().zip(own).collect()),
        ],
        ..Chart::default()
    };
    for (name, chart) in [("mesh.svg", mesh), ("charge.svg", charge)] {
        fs::write(Path::new(&folder).join(name), chart.to_svg())?;
    }
    Ok(())
}

/// |g00 ṫ − Q_t| after every step, where g00 = 1 + x⁴.
fn runge_kutta(length: f64, steps: usize) -> Vec<(f64, f64)> {
    let start = [0.0, 1.0, 1.0, 0.1];
    let g00 = |x: f64| 1.0 + x.powi(4);
    let slope = |[_, x, u, w]: [f64; 4]| {
        let first = 4.0 * x.powi(3);
        [u, w, -first / g00(x) * u * w, -0.5 * first * u * u]
    };
    let moved = |y: [f64; 4], k: [f64; 4], h: f64| std::array::from_fn(|i| y[i] + h * k[i]);
    let charge = |y: [f64; 4]| g00(y[1]) * y[2];
    let (h, mut y) = (length / steps as f64, start);
    let mut found = Vec::new();
    for step in 1..=steps {
        let k1 = slope(y);
        let k2 = slope(moved(y, k1, 0.5 * h));
        let k3 = slope(moved(y, k2, 0.5 * h));
        let k4 = slope(moved(y, k3, h));
        y = std::array::from_fn(|i| y[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]));
        found.push((step as f64 * h, (charge(y) - charge(start)).abs()));
    }
    found
}
