//! Roundings have no direction: what they add up to along a run, what witnesses see of them, and where forces jump.

use geodesic_ivp::diagnostics::verdict::Grade;
use geodesic_ivp::number::{Extended, Real};
use geodesic_ivp::study::run::{Judged, NoRun, Run, Wanted, run};
use geodesic_ivp::{Case, solve};

use crate::common::{end, line_of, parsed};

/// A particle of Newton's law that begins at x with ẋ = v, to a γ.
fn particle([x, v, length]: [f64; 3], rest: &str) -> Case {
    let text = format!(
        "particle.law = \"newtonian\"\ngrid.gamma_f = {length:?}\npotential.coordinates = [\"x\"]\n\
         initial.x = {x:?}\ninitial.x_dot = {v:?}\n{rest}"
    );
    parsed(&text, &[])
}

/// A run with what is said of it; `None` if it is refused.
fn judged(case: &Case) -> Option<(Run, Judged)> {
    let setup = case.setup::<f64>();
    match run(case, &setup, Wanted::default()).0 {
        Ok(run) => {
            let judged = run.judged(&setup, false, false);
            Some((run, judged))
        }
        Err(NoRun::Unsolved(..)) => None,
        Err(none) => panic!("{none:?}"),
    }
}

/// The run is trusted, and x is off from `exact` by no more than it says.
#[track_caller]
fn is_trusted(case: &Case, exact: f64) -> Run {
    let (run, judged) = judged(case).expect("it has an end");
    assert_eq!(judged.verdict.grade, Grade::Trusted, "{:?}", judged.verdict.reasons);
    let (off, most) = ((end(&run.line, "x") - exact).abs(), judged.error.unwrap().at_most_at_end()[1]);
    assert!(off <= most + 1e-15, "{off:e} of {most:e}");
    run
}

/// At t = 27044 a double is known to 2e-12. If all roundings had one direction, x would be known to 1e-8.
#[test]
fn roundings_of_a_clock_add_up_like_a_root() {
    for k in 0..8_u32 {
        let (start, w, a, v) = (27_044.5 + f64::from(k) / 8.0, 1.2 + 0.05 * f64::from(k), 1.8, 0.3);
        let length = 30.0 + 0.1 * f64::from(k);
        // ẍ = a cos(ω t).
        let number = Extended::from;
        let phase = |t: f64| number(w) * (number(start) + number(t));
        let gain = <Extended as Real>::cos(phase(0.0)) - <Extended as Real>::cos(phase(length));
        let slope = number(v) - number(a) * <Extended as Real>::sin(phase(0.0)) / number(w);
        let exact = slope * number(length) + number(a) * gain / (number(w) * number(w));
        let rest = format!(
            "initial.t = {start:?}\nsolver.accuracy = 3e-10\npotential.formula = \"0\"\n\
             potential.force.x = \"{a:?}*cos({w:?}*t)\""
        );
        is_trusted(&particle([0.0, v, length], &rest), exact.to_f64());
    }
}

/// Sums of large numbers, and potentials that lose all but nine digits: the motion is that of what is left, and the
/// force of the Lagrangian, the work and the energy are known no better than their formulas.
#[test]
fn witnesses_know_what_their_formulas_lose() {
    let [x, length] = [0.225_693_323_406_683_72, 4.181_581_203_757_807];
    let rest = "solver.accuracy = 2.7e-7\npotential.formula = \"0\"\n\
                potential.force.x = \"-0.7*((7472087588794138.0 + x) - 7472087588794138.0)\"";
    is_trusted(&particle([x, 0.0, length], rest), x * (0.7_f64.sqrt() * length).cos());
    // V = (1 − cos bx)/b² has the force sin(bx)/b, which is x to 3e-11 of it.
    let flat = "potential.formula = \"(1 - cos(b*x))/b^2\"\nparameters.b = 2.0438494937388545e-6\n";
    for scheme in [
        "solver.accuracy = 1e-6",
        "solver.accuracy = 1e-9",
        "solver.tolerance = 1e-9",
        "grid = { n_gamma = 16, windows = 12 }\nscheme = { sbp = \"GLL16\", form = \"weak\" }",
    ] {
        let scheme = scheme.replace("grid = { n_gamma = 16, windows = 12 }", "grid.n_gamma = 16\ngrid.windows = 12");
        let case = particle([x, 0.0, length], &format!("{flat}{scheme}"));
        let (run, judged) = judged(&case).expect("it has an end");
        assert_eq!(judged.verdict.grade, Grade::Trusted, "{scheme}: {:?}", judged.verdict.reasons);
        assert!((end(&run.line, "x") - x * length.cos()).abs() < 1e-10, "{scheme}");
        // V is rounding from window to window, and s, which nothing depends on, asks for none that are shorter.
        assert!(run.line.windows.len() < 40, "{scheme}: {} windows", run.line.windows.len());
    }
}

/// On top of a hill ẍ = 100 (x − 1) a kick is e^{10 t}/20 times as large at the end, and no error is there to show it.
#[test]
fn a_kick_at_rest_on_a_hill_is_seen_or_doubted() {
    let mut found = 0;
    for force in [1e-3, 1e-5, 1e-6, 1e-8, 1e-10, 1e-13] {
        for (begin, width) in [(0.680_58, 0.01), (0.3, 1e-3), (1.1, 1e-4), (0.841, 1e-5)] {
            let (last, length) = (begin + width, 3.0);
            let grown = |at: f64| (10.0 * (length - at)).cosh();
            let of_step = force / 100.0 * (grown(begin) - grown(last));
            let area = force * width * std::f64::consts::PI.sqrt() * (25.0 * width * width).exp();
            let of_bell = area * (10.0 * (length - begin)).sinh() / 10.0;
            for (pulse, way) in [
                (format!("{force:?}*step(t - {begin:?})*step({last:?} - t)"), of_step),
                (format!("{force:?}*exp(-((t - {begin:?})/{width:?})^2)"), of_bell),
            ] {
                let rest = format!(
                    "solver.accuracy = 1e-4\npotential.formula = \"-50*(x - 1)^2\"\npotential.force.x = \"{pulse}\""
                );
                let Some((run, judged)) = judged(&particle([1.0, 0.0, length], &rest)) else { continue };
                if judged.verdict.grade == Grade::Trusted {
                    found += 1;
                    let (off, size) = ((end(&run.line, "x") - 1.0 - way).abs(), (1.0 + way).max(1.0));
                    assert!(off <= 1e-4 * size, "{pulse}: {off:e} of {size:e}");
                }
            }
        }
    }
    println!("{found} are trusted");
}

/// The argument of a step loses digits where it changes its sign: x(1.4 − x) is 0.49 at its top, and is known to
/// 1e-16, so that a sign that changes 1e-6 beside the top is known to 1e-10 in x.
#[test]
fn a_jump_whose_argument_cancels_is_where_its_decimals_say() {
    let mut largest = 0.0_f64;
    for k in 1..=20_u32 {
        // The step is 1 where |x − 0.7| < d.
        let (depth, v) = (1e-12 * f64::from(k), 0.9 + 0.01 * f64::from(k));
        let level = format!("{:.30}", Extended::from_decimal("0.49").unwrap().to_f64() - depth);
        let text = format!("potential.force.x = \"1000*step(1.4*x - x^2 - {level})\"\npotential.formula = \"0\"\n");
        let accuracy = "solver.accuracy = 1e-9\n";
        let case = particle([0.0, v, 3.0], &format!("{text}{accuracy}"));
        let Some((run, judged)) = judged(&case) else { continue };
        // 0.7² − level, to all digits.
        let half = (Extended::from_decimal("0.49").unwrap() - Extended::from_decimal(&level).unwrap()).sqrt();
        let (v, force, two) = (Extended::from(v), Extended::from(1000.0), Extended::from(2.0));
        let out = (v * v + two * force * two * half).sqrt();
        let (begin, last) =
            (Extended::from_decimal("0.7").unwrap() - half, Extended::from_decimal("0.7").unwrap() + half);
        let inside = two * two * half / (v + out);
        let exact = last + out * (Extended::from(3.0) - begin / v - inside);
        let off = (Extended::from(end(&run.line, "x")) - exact).to_f64().abs();
        let most = judged.error.unwrap().at_most_at_end()[1];
        assert!(off <= most || judged.verdict.grade == Grade::Doubtful, "{k}: {off:e} of {most:e}");
        largest = largest.max(off);
    }
    println!("{largest:e}");
}

/// With decimals k a = c, where a is a double, a particle rests for ever on top of cos(k x − c), and is pushed by what
/// doubles make of k a − c. Both marches are pushed alike.
#[test]
fn what_begins_with_rounding_alone_is_right_or_doubted() {
    let mut moved = 0;
    for (k, a, c) in
        [(1.4, 0.625, 0.875), (1.3, 0.75, 0.975), (1.1, 0.375, 0.4125), (0.7, 1.25, 0.875), (1.9, 0.5, 0.95)]
    {
        for length in [3.0, 20.0, 40.0] {
            for scheme in [
                "solver.accuracy = 1e-2",
                "solver.accuracy = 1e-8",
                "solver.tolerance = 1e-10",
                "grid.n_gamma = 16\ngrid.windows = 40\nscheme = { sbp = \"GLL16\", form = \"weak\" }",
            ] {
                let rest = format!("potential.formula = \"cos({k:?}*x - {c:?})\"\n{scheme}");
                let Some((run, judged)) = judged(&particle([a, 0.0, length], &rest)) else { continue };
                let off = (end(&run.line, "x") - a).abs();
                moved += u32::from(off > 1e-6);
                let most = judged.error.map_or(0.0, |error| error.at_most_at_end()[1]);
                let is_doubted = judged.verdict.grade == Grade::Doubtful;
                assert!(is_doubted || off <= most + 1e-15, "{k} {length} {scheme}: {off:e} of {most:e}");
            }
            // A force that is nothing but the rounding of a product and a sum.
            let rest = format!(
                "potential.coordinates = [\"x\", \"y\"]\npotential.formula = \"0\"\n\
                 potential.force.x = \"1e14*({k:?}*y - {c:?})\"\ninitial.y = {a:?}\ninitial.y_dot = 0\n\
                 solver.accuracy = 1e-4"
            );
            let text = format!(
                "particle.law = \"newtonian\"\ngrid.gamma_f = {length:?}\ninitial.x = 0.5\n\
                 initial.x_dot = 0.3\n{rest}"
            );
            let Some((run, judged)) = judged(&parsed(&text, &[])) else { continue };
            let off = (end(&run.line, "x") - 0.5 - 0.3 * length).abs();
            let is_doubted = judged.verdict.grade == Grade::Doubtful;
            assert!(is_doubted || off <= 1e-4 * 0.3 * length, "{k} {length}: {off:e}");
        }
    }
    assert!(moved > 3, "{moved}");
}

/// A jump at a time that is far from 0 is met in windows in which t is one number: its rate is known all the same.
#[test]
fn a_jump_by_a_far_clock_leaves_all_witnesses_finite() {
    for start in [0.0, 10.0, 100.0, 1e3, 1e5] {
        let later = 1.8;
        let in_time = format!("-x + 10*step(t - {:?})", start + later);
        for force in [in_time.as_str(), "-0.3*x_dot + step(x^2 - 0.3)", "step(x - 0.9)"] {
            let rest = format!(
                "initial.t = {start:?}\nsolver.accuracy = 1e-7\npotential.formula = \"0\"\n\
                 potential.force.x = \"{force}\""
            );
            let case = particle([0.3, 0.4, 4.0], &rest);
            let (run, judged) = judged(&case).unwrap_or_else(|| panic!("{start} {force} is refused"));
            assert_eq!(judged.verdict.grade, Grade::Trusted, "{start} {force}: {:?}", judged.verdict.reasons);
            if force.starts_with("-x") {
                let free = 0.3 * 4.0_f64.cos() + 0.4 * 4.0_f64.sin();
                let exact = free + 10.0 * (1.0 - (4.0_f64 - later).cos());
                assert!((end(&run.line, "x") - exact).abs() < 1e-6, "{start}");
            }
        }
    }
}

/// V = (C + a x²) − C is a x². Its slope loses nothing, but g00 at the start does, which Q_t is made of.
#[test]
fn momenta_that_the_metric_has_rounded_are_in_the_error() {
    let text = |formula: &str| {
        format!(
            "particle.c = 3.0\ngrid.gamma_f = 20.0\nsolver.accuracy = 1e-10\npotential.formula = \"{formula}\"\n\
             initial = {{ t = 0, x = -0.67, t_dot = 1, x_dot = -0.15 }}"
        )
    };
    let known = judged(&parsed(&text("0.65*x^2"), &[])).expect("it has an end").0;
    for large in ["1e4", "1e6", "1e8"] {
        let case = parsed(&text(&format!("({large} + 0.65*x^2) - {large}")), &[]);
        let Some((run, judged)) = judged(&case) else { continue };
        let off = (end(&run.line, "x") - end(&known.line, "x")).abs();
        let most = judged.error.map_or(f64::INFINITY, |error| error.at_most_at_end()[1]);
        assert!(off <= most + 1e-11, "{large}: {off:e} of {most:e}");
        assert!(large != "1e8" || judged.verdict.grade == Grade::Doubtful, "{large}");
    }
}

/// The tail of a pulse moves what rests at 0 by numbers that have lost digits, as they are too small for a double, and
/// by 1e-270 and more, of which rounding of t takes some digits. All of that is nothing to what comes later.
#[test]
fn what_rests_at_zero_is_moved_by_the_tail_of_a_pulse() {
    let (height, place, length) = (0.3, 5.2, 9.0);
    for width in [0.3, 0.1, 0.03] {
        let rest = format!(
            "solver.accuracy = 1e-12\npotential.formula = \"0\"\n\
             potential.force.x = \"{height:?}*exp(-((t - {place:?})/{width:?})^2)\""
        );
        let area = height * width * std::f64::consts::PI.sqrt();
        is_trusted(&particle([0.0, 0.0, length], &rest), area * (length - place));
    }
    let narrow = "solver.accuracy = 1e-12\npotential.formula = \"0\"\n\
                  potential.force.x = \"0.3*exp(-((t - 5.2)/1e-4)^2)\"\n";
    let refused = solve::<f64>(&particle([0.0, 0.0, length], narrow)).unwrap_err();
    assert!(refused.advice().contains("solver.floor"), "{refused}");
    let area = height * 1e-4 * std::f64::consts::PI.sqrt();
    is_trusted(&particle([0.0, 0.0, length], &format!("{narrow}solver.floor.x = 1e-6")), area * (length - place));
}

/// A bracket that is zero in decimals, times a large number, in a pulse that is a thousandth of the run. No place that
/// is spread over the run need lie in it.
#[test]
fn what_formulas_lose_in_a_short_part_of_a_run_is_part_of_its_error() {
    let (x, v, length) = (0.197, 0.867, 200.0_f64);
    let exact = x * length.cos() + v * length.sin();
    let grid = "grid = { gamma_f = 200, n_gamma = 20, windows = 400 }\nscheme = { sbp = \"GLL20\", form = \"weak\" }";
    let march = "grid.gamma_f = 200\nsolver.tolerance = 1e-9";
    let mut worse = 0;
    for (k, zero) in ["(0.1*y - y*0.3/3)", "((y + 0.7)^2 - y^2 - 1.4*y - 0.49)", "(sin(y)^2 + cos(y)^2 - 1)"]
        .into_iter()
        .cycle()
        .take(18)
        .enumerate()
    {
        let (large, place) = (10.0_f64.powf(6.0 + 0.15 * k as f64), 20.0 + 9.37 * k as f64);
        let width = [0.3, 0.1, 0.04][k % 3];
        let scheme = if k % 6 == 5 { grid } else { march };
        let pulse = format!("{large:e}*{zero}*exp(-((t - {place:?})/{width:?})^2)");
        let text = format!(
            "particle.law = \"newtonian\"\ninitial = {{ x = {x:?}, x_dot = {v:?}, y = -0.155, y_dot = -0.183 }}\n\
             potential = {{ coordinates = [\"x\", \"y\"], formula = \"0\", force.x = \"-x + {pulse}\" }}\n{scheme}"
        );
        let (run, judged) = judged(&parsed(&text, &[])).expect("it has an end");
        let (off, most) = ((end(&run.line, "x") - exact).abs(), judged.error.unwrap().at_most_at_end()[1]);
        assert!(off <= most + 1e-13, "{text}: {off:e} of {most:e}");
        worse += usize::from(off > 1e-10);
    }
    assert!(worse > 3, "rounding is to be seen: {worse}");
}

/// A motion that would come to rest beside a hill is left by all of its neighbours: what the doubles of the start lack
/// grows by 4e8. The decimals of the start are those of the motion that does not.
#[test]
fn a_start_has_all_digits_of_its_decimals() {
    for (k, [x, v], length, tolerance) in [
        (1.0_f64, [0.0013, -0.5013], 19.9_f64, "1e-12"),
        (1.0, [0.0013, -0.5013], 11.9, "1e-12"),
        (7.0, [0.7, -5.04], 2.23, "1e-9"),
    ] {
        let forced = -1.0 / (1.0 + k * k);
        let rest = format!(
            "solver.tolerance = {tolerance}\npotential.formula = \"-{k:?}^2*x^2/2\"\npotential.force.x = \"cos(t)\""
        );
        let exact = forced * length.cos() + (x - forced) * (-k * length).exp();
        let run = is_trusted(&particle([x, v, length], &rest), exact);
        let lacks = |number: f64| {
            let decimal = <Extended as Real>::from_decimal(&format!("{number:?}")).expect("it is a number");
            (Extended::from(number) - decimal).to_f64()
        };
        let grown = (lacks(x) + lacks(v) / k).abs() / 2.0 * (k * length).exp();
        let off = (end(&run.line, "x") - exact).abs();
        assert!(off < grown / 3.0, "{k} {length}: {off:e} of {grown:e}");
    }
    // On a given grid, too.
    let rest = "grid = { gamma_f = 11.9, n_gamma = 16, windows = 40 }\nscheme = { sbp = \"GLL16\", form = \"weak\" }\n\
                potential = { coordinates = [\"x\"], formula = \"-x^2/2\", force.x = \"cos(t)\" }\n\
                particle.law = \"newtonian\"\ninitial = { x = 0.0013, x_dot = -0.5013 }";
    let length = 11.9_f64;
    is_trusted(&parsed(rest, &[]), -0.5 * length.cos() + 0.5013 * (-length).exp());
}

/// A time of ten million has no double next to it that is nearer than 2e-9: what the motion does until then is part of
/// the error of a run that ends there.
#[test]
fn an_end_at_a_far_time_is_as_uncertain_as_that_is() {
    for (start, way, w) in [(1e7, 0.3, 1e3), (1e4, 3.7, 10.0), (1e5, 0.3, 40.0)] {
        let text = format!(
            "particle.law = \"newtonian\"\npotential = {{ coordinates = [\"x\"], formula = \"{w:?}^2*x^2/2\" }}\n\
             initial = {{ t = {start:?}, x = 1.0, x_dot = 0.0 }}\ngrid.t_f = \"{start:?} + {way:?}\"\n\
             solver.tolerance = 1e-12"
        );
        let (run, judged) = judged(&parsed(&text, &[])).expect("it has an end");
        let (off, most) = ((end(&run.line, "x") - (w * way).cos()).abs(), judged.error.unwrap().at_most_at_end()[1]);
        assert!(off <= most && most < 1e-5, "{start}: {off:e} of {most:e}");
    }
}

/// Around a circle windows may be so long that substitution does not converge from a straight line. The end of a run in
/// such a window is guessed from that.
#[test]
fn a_run_ends_in_a_window_that_is_as_long_as_the_motion_allows() {
    for accuracy in ["1e-4", "1e-5", "1e-6", "1e-7", "1e-8", "1e-10"] {
        for t_f in [3.0_f64, 4.2, 5.0, 6.0, 7.0] {
            for factor in ["1/(x^2 + y^2)", "1/sqrt(x^2 + y^2)"] {
                let text = format!(
                    "potential.coordinates = [\"x\", \"y\"]\npotential.formula = \"-1/sqrt(x^2 + y^2)\"\n\
                     potential.conformal = \"{factor}\"\nparticle.law = \"newtonian\"\n\
                     initial = {{ x = 1.0, y = 0.0, x_dot = 0.0, y_dot = 1.0 }}\ngrid.t_f = {t_f:?}\n\
                     solver.accuracy = {accuracy}"
                );
                is_trusted(&parsed(&text, &[]), t_f.cos());
            }
        }
    }
}

/// What a formula of the start comes to in doubles need not be the double next to its decimals. Windows begin at what
/// the decimals are, and the tightest tolerance takes no difference of both for an error.
#[test]
fn a_start_is_what_its_decimals_are() {
    let mut away = 0;
    for k in 0..60_u32 {
        let unit = 1.484_264_036_198_753_2e-7 * 1.37_f64.powi(k.cast_signed());
        let [x, v] = [-0.865_219_253_229_735_1 + 0.017 * f64::from(k), 0.552_619_774_728_163_4];
        let text = format!(
            "potential = {{ coordinates = [\"x\"], formula = \"-cos(x/L)\", parameters.L = {unit:?} }}\n\
             particle = {{ law = \"newtonian\", masses.x = \"1/L^2\" }}\n\
             initial = {{ x = \"L*({x:?})\", x_dot = \"L*{v:?}\" }}\ngrid.gamma_f = 3.1\n\
             solver = {{ tolerance = 1e-15, error = false }}"
        );
        let case = parsed(&text, &[]);
        let start = case.setup::<f64>().place.start.q[1];
        let decimal = |number: f64| <Extended as Real>::from_decimal(&format!("{number:?}")).expect("it is a number");
        let exact = decimal(unit) * decimal(x);
        away += u32::from(exact.to_f64() != start);
        line_of::<f64>(&case);
    }
    assert!(away > 5, "{away}");
}
