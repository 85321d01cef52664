//! The paper's base cases and an orbit around a black hole on coarse grids, to the digits of independent programs: both
//! forms, both systems, and any number of digits. What is exact in theory is zero to the digits asked for.

use crate::common::{QUARTIC, case, distance, line_of, parsed, shipped, solved_in};
use geodesic_ivp::case::{Case, Form};
use geodesic_ivp::diagnostics::Diagnostics;
use geodesic_ivp::number::{Extended, Real};
use geodesic_ivp::solve::WorldLine;
use geodesic_ivp::{Solution, Status, solve};

fn read<S: Real>(text: &str) -> S {
    S::from_decimal(text).unwrap()
}

struct Base {
    text: &'static str,
    set: &'static str,
    end: Vec<&'static str>,
    last: Vec<f64>,
}

/// An orbit that falls towards a black hole.
const ORBIT: &str = "metric.preset = 'schwarzschild'\ngrid = { gamma_f = 40.0, n_gamma = 33 }\n\
                     scheme.form = 'strong'\n\
                     initial = { t = 0, r = 10, phi = 0, t_dot = 1.2, r_dot = -0.05, phi_dot = 0.03 }\n";

/// Behind @ stand the settings of a potential or an orbit and, in the strong form, Δp_a of the charges at the last
/// node, as published. What follows is q^a at the end, of potentials by an independent 100-digit program.
const BASES: &str = "@ potential={linear={alpha=0.25}} | 1.70339476621e-3
0.9971335746291577636846554134796076309812725357198337858600296866346344
0.9761916056480037954022088281977935687917616513511737365080920827969218
@ potential={linear={alpha=0.25}} scheme.sbp=SBP42 | 1.004786223e-6
0.9971296071048166056825284999699712220043206004729274817222058196096819
0.9760470232028565253567171045240423727682659409234750400869547831689843
@  | 5.93454699655e-2
1.468801423064326110333148834749417048967845333815025203765032107249465
0.1601801643661407023957676285707798759114176062382472041078852253897226
@ scheme.sbp=SBP42 | 5.78416591035e-3
1.468700371197799309103860409960511578224397674620524406615090445406213
0.1597852677469550743207985667503222881839771174173329340661003120892074
@ potential={linear={alpha=0.25}} scheme.form=weak |
0.9971151097491775694816452255460214429408422759436342700996604437438565
0.9760506286084057869098407081411635942717323384864257857066539974205039
@ potential={linear={alpha=0.25}} scheme.sbp=SBP42 scheme.form=weak |
0.9971295993901089008257494036375933267547323126000895638992924643570107
0.9760463906031115168135012742823952779111278544575222284281250875527799
@ scheme.form=weak |
1.467845286957429771520660850602670890688684833211762959588645421829265
0.1596526768674696838987378748942589779532047506668670139211550540460584
@ scheme.sbp=SBP42 scheme.form=weak |
1.468634332210151836834497911415784056947360675161369518713478914900886
0.1597777821251707290446712152081763128093268780064538857655034129040739
@ orbit scheme.sbp=SBP21 | -0.0702064 0.392967
53.8760029482 3.72639917093 2.49081375858
@ orbit scheme.sbp=SBP42 | -0.033648 0.157672
53.9568945458 3.6993501136 2.50786648864
@ orbit scheme.sbp=SBP42 scheme.form=weak |
54.0514978057 3.67228113435 2.52655645927
@ orbit scheme.sbp=GLL12 scheme.form=weak grid.n_gamma=12 |
53.9869982576 3.69493627391 2.5126063736";

fn bases() -> Vec<Base> {
    let base = |row: &'static str| {
        let (head, end) = row.split_once('\n').unwrap();
        let (set, last) = head.split_once('|').unwrap();
        let set = set.trim();
        let (text, set) = set.strip_prefix("orbit ").map_or((QUARTIC, set), |set| (ORBIT, set));
        let last = last.split_whitespace().map(|last| last.parse().unwrap()).collect();
        Base { text, set, end: end.split_whitespace().collect(), last }
    };
    BASES.split('@').skip(1).map(base).collect()
}

const SYSTEMS: [&str; 2] = ["solver.system=physical-limit", "solver.system=doubled"];

/// ε|t|/h, the rounding level of Dt at N = 32, with room for the operator's row sum and g00.
const ROUNDING: f64 = 32.0 * 8.0 * f64::EPSILON;

fn solved_base<S: Real>(base: &Base, more: &str) -> WorldLine<S> {
    let set: Vec<&str> = base.set.split_whitespace().chain(more.split(' ')).collect();
    line_of(&parsed(base.text, &set))
}

/// p_a − p_a,i at node k of the only window, from D̄q.
fn deviation<S: Real>(line: &WorldLine<S>, a: usize, k: usize) -> S {
    let start = &line.place.start;
    let rows: Vec<Vec<S>> = (0..start.q.len()).map(|a| line.q(a).collect()).collect();
    let q: Vec<S> = rows.iter().map(|row| row[k]).collect();
    let penalty = |a: usize| if k == 0 { (rows[a][0] - start.q[a]) / line.sbp().weights()[0] } else { S::ZERO };
    let q_dot: Vec<S> = (0..q.len()).map(|a| line.sbp().derivative_at(&rows[a], k) + penalty(a)).collect();
    line.geometry().momenta(&q, &q_dot)[a] - start.p[a]
}

/// In one coordinate all that is zero in theory is below `zero`; the last nodes of the strong form, which are not, stay
/// where they are.
fn assert_exact<S: Real>(name: &str, line: &WorldLine<S>, zero: S) {
    let (found, is_weak) = (Diagnostics::new(line), line.form == Form::Weak);
    let (charge, last) = (&found.charges[0], line.x().len() - 1);
    assert!(charge.max_interior < zero && charge.max_corrected < zero, "{name}: ΔQ_t");
    let is_close = S::IS_EXTENDED || is_weak;
    let [of_gradient, small] = if is_close { [zero; 2] } else { [1e-10, 1e-11].map(S::from) };
    assert!(line.gradient_norm < of_gradient, "{name}: gradient {:?}", line.gradient_norm);
    assert!(line.branch_distance() < small, "{name}: branches");
    // Another application of D costs a factor of N.
    let of_derivative = if S::IS_EXTENDED && !is_weak { zero } else { S::from(32.0) * zero };
    assert!(found.max_delta_g < of_derivative, "{name}: ΔG");
    if is_weak {
        assert!(line.multipliers().is_none() && charge.delta == charge.corrected, "{name}: nothing to correct");
        assert!(charge.delta.iter().all(|d| d.abs() < zero), "{name}: ΔQ_t at all nodes");
        assert!(found.delta_g.iter().flatten().all(|g| g.abs() < of_derivative), "{name}: ΔG at all nodes");
        // The checks can fail: the same numbers by plain D are not zero.
        let plain = line.sbp().derivative(line.elapsed())[0] - found.q_dot[0][0];
        assert!(plain.abs().to_f64() > 1e-7, "{name}: the regularisation is at work");
        return;
    }
    assert!(line.multipliers().unwrap()[..4].iter().all(|lambda| lambda.abs() < small), "{name}: λ1 … λ4");
    // The checks can fail.
    assert!(charge.last.abs().to_f64() > 1e-7, "{name}: the last node stands alone");
    assert!(found.delta_g[1][last].abs().to_f64() > 1e-7, "{name}: ΔG at the last node");
    let deviating = last + 1 - line.sbp().rows_reaching_last_node();
    let residuals = found.delta_g.iter().map(|residual| residual[deviating].abs().to_f64());
    assert!(S::IS_EXTENDED || residuals.fold(f64::INFINITY, f64::min) > 1e4 * 32.0 * ROUNDING, "{name}");
}

fn check<S: Real>(base: &Base, digits: u32, [close, zero]: [&str; 2]) {
    for system in SYSTEMS {
        let name = format!("{} {system} {digits}", base.set);
        let line: WorldLine<S> = solved_base(base, &format!("{system} solver.digits={digits}"));
        let (found, is_orbit) = (Diagnostics::new(&line), base.text == ORBIT);
        for (q, known) in line.end().q.iter().zip(&base.end) {
            let known: S = read(known);
            let most = if is_orbit { S::from(1e-10) * known } else { read(close) };
            assert!((*q - known).abs() < most, "{name}: {q:?} {known:?}");
        }
        if is_orbit {
            assert!(line.gradient_norm < S::from(1e-9), "{name}: {:?}", line.gradient_norm);
        } else {
            assert_exact(&name, &line, read(zero));
        }
        let zero = if S::IS_EXTENDED { read(zero) } else { S::from(1e-12) };
        let exact = line.nodes() - usize::from(line.form == Form::Strong);
        for a in line.geometry().ignorable() {
            (0..exact).for_each(|k| assert!(deviation(&line, a, k).abs() < zero, "{name}: charge {a}, node {k}"));
        }
        for (charge, &known) in found.charges.iter().zip(&base.last) {
            let most = match S::IS_EXTENDED {
                _ if is_orbit => 1e-5 * known.abs() + 1e-12,
                true => 1e-9 * known,
                false => 1e-11,
            };
            let independent = deviation(&line, charge.terms[0].0, exact);
            for last in [charge.last, independent] {
                assert!((last.to_f64() - known).abs() < most, "{name}: {last:?} at the last node, {known}");
            }
        }
    }
}

#[test]
fn the_base_cases_in_double_precision() {
    bases().iter().for_each(|base| check::<f64>(base, 16, ["1e-11", &ROUNDING.to_string()]));
}

#[test]
fn the_base_cases_in_40_digits() {
    bases().iter().for_each(|base| check::<Extended>(base, 40, ["1e-39", "1e-36"]));
}

#[test]
fn the_base_cases_in_60_digits() {
    bases()[..8].iter().for_each(|base| check::<Extended>(base, 60, ["1e-59", "1e-55"]));
}

#[test]
fn irrational_formulas_in_60_digits() {
    for name in ["pendulum-60-digits", "morse-60-digits"] {
        for (sbp, system) in ["SBP21", "SBP42"].iter().flat_map(|sbp| SYSTEMS.map(|system| (sbp, system))) {
            let line = line_of::<Extended>(&shipped(name, &[&format!("scheme.sbp={sbp}"), system]));
            assert_exact(&format!("{name} {sbp} {system}"), &line, read("1e-55"));
        }
    }
}

#[test]
fn the_most_digits_there_are() {
    for (base, system) in bases()[..8].iter().flat_map(|base| SYSTEMS.map(|system| (base, system))) {
        let name = format!("{} {system}", base.set);
        let line: WorldLine<Extended> = solved_base(base, &format!("{system} solver.digits=70"));
        assert_exact(&name, &line, read("1e-65"));
        // The second-order form of the action loses N² units of the last place, and says so.
        let warnings = Diagnostics::new(&line).warnings(&line);
        let warned = warnings.iter().any(|warning| warning.contains("of 70 digits"));
        assert!(system == SYSTEMS[0] && !warned || system == SYSTEMS[1], "{name}: {warnings:?}");
    }
}

#[test]
fn multipliers_and_ends_are_those_of_the_physical_limit() {
    for base in &bases()[..8] {
        let [limit, doubled]: [Solution; 2] = SYSTEMS.map(|system| solved_base(base, system));
        let is_strong = limit.form == Form::Strong;
        if let (Some(lambda), Some(other)) = (limit.multipliers(), doubled.multipliers()) {
            assert!(distance(lambda, other) < 1e-11 && (other[4] + doubled.q_t()).abs() < 1e-11, "{other:?}");
        }
        let apart = distance(limit.x(), doubled.x()).max(distance(limit.elapsed(), doubled.elapsed()));
        assert!(apart < if is_strong { 1e-11 } else { 1e-12 }, "{}: {apart:e}", base.set);
        let [limit, doubled] = [limit.end_state(), doubled.end_state()];
        assert!((limit.x_dot - doubled.x_dot).abs() < 1e-11, "{}", base.set);
        assert!(is_strong || (limit.q_t - doubled.q_t).abs() < 1e-15, "{}", base.set);
    }
}

/// w_N of the weak form belongs to the trajectory as x_N does, and is as accurate.
#[test]
fn what_is_handed_on_continues_the_trajectory() {
    let solution = solved_in::<f64>("scheme={sbp=\"SBP42\",form=\"weak\"} grid.n_gamma=257");
    let (found, x_dot) = (Diagnostics::new(&solution), solution.end_state().x_dot);
    assert!((x_dot + 1.416_825_598_093_154_3).abs() < 1e-9 && found.norm.max_ends < 1e-9, "{x_dot}");
    assert!((found.q_dot[1][256] - x_dot).abs() < 1e-11);
}

#[test]
fn the_end_velocities_of_the_paper() {
    let velocity = |overrides: &str| Diagnostics::new(&solved_in::<f64>(overrides)).q_dot[0][31];
    assert!((velocity("") - 2.058).abs() < 5e-4, "the paper: 2.06");
    assert!((velocity("potential={linear={alpha=0.25}}") - 1.00914).abs() < 5e-6);
}

#[test]
fn without_regularisation_the_critical_point_is_wrong_or_missing() {
    let ablation = "solver.system=doubled scheme.regularised=false";
    for (sbp, t_final) in [("SBP21", 1.0324), ("SBP42", 0.6350)] {
        let linear = solved_in::<f64>(&format!("{ablation} potential={{linear={{alpha=0.25}}}} scheme.sbp={sbp}"));
        assert!((linear.end_state().t - t_final).abs() < 5e-5, "{sbp}: t = {}", linear.end_state().t);
        assert!(sbp != "SBP21" || linear.gradient_norm < 1e-12, "{:e}", linear.gradient_norm);
        // In the quartic case Newton's method fails, or its damping carries it to a spurious point in which even and
        // odd nodes lie on two different curves.
        let quartic = format!("{ablation} scheme.sbp={sbp} solver.max_iterations=100");
        let Ok(spurious) = solve::<f64>(&case(&quartic)) else { continue };
        let splitting = Diagnostics::new(&spurious).sawtooth[0].1.amplitude.unwrap();
        assert!(splitting > 1e-2, "{sbp}: {splitting:e}");
    }
    assert!(solve::<f64>(&case(ablation)).is_err());
}

#[test]
fn extended_precision_confirms_f64() {
    for base in &bases()[..4] {
        let (short, long) = (solved_base::<f64>(base, SYSTEMS[0]), solved_base::<Extended>(base, SYSTEMS[0]));
        for (short, long) in short.end().q.iter().zip(&long.end().q) {
            assert!((short - long.to_f64()).abs() < 1e-14, "{}", base.set);
        }
    }
}

#[test]
fn a_case_number_is_the_decimal_that_is_written() {
    let digits = "solver.digits=60 scheme.sbp=SBP42";
    let tenth = solved_in::<Extended>(digits);
    // The f64 next to a tenth is another number …
    let double = solved_in::<Extended>(&format!(
        "initial.x_dot=0.1000000000000000055511151231257827021181583404541015625 {digits}"
    ));
    let difference = distance(tenth.x(), double.x()).to_f64();
    assert!(difference > 1e-18 && difference < 1e-16, "{difference}");
    // … and an eighth is the same in both.
    let written = ["0.125", "12.5e-2", "0.12500000000000000000000000000"].map(|eighth| {
        let kappa = format!("potential.quartic.kappa={eighth} {digits}");
        solved_in::<Extended>(&kappa).end_state().x
    });
    assert!(written[0] == written[1] && written[1] == written[2]);
    // A velocity of one tenth with a tangent of three is an ẋ of three tenths.
    let velocity = solved_in::<Extended>(&format!("initial={{t=0,x=1,t_dot=3,velocity=0.1}} {digits}"));
    let x_dot = solved_in::<Extended>(&format!("initial={{t=0,x=1,t_dot=3,x_dot=0.3}} {digits}"));
    assert!((velocity.end_state().x - x_dot.end_state().x).abs() < read::<Extended>("1e-60"));
}

#[test]
fn more_digits_than_asked_for_are_kept() {
    let long = "0.10000000000000000000000000000000000000000000000000000000000000001";
    let written = case(&format!("initial.x_dot={long} solver.digits=40"));
    assert!(written.to_toml().contains(&format!("x_dot = {long}")), "{}", written.to_toml());
    assert_eq!(Case::parse("again", &written.to_toml(), &[]).unwrap(), written);
    assert!(written != case("solver.digits=40"));
    for (digits, valid) in [("15", false), ("16", true), ("70", true), ("71", false), ("0", false)] {
        let overrides = [format!("solver.digits={digits}")];
        assert_eq!(Case::parse("digits", QUARTIC, &overrides).is_ok(), valid, "{digits}");
    }
}

#[test]
fn a_refinement_that_cannot_succeed_is_not_a_result() {
    // Even and odd nodes have parted: the critical point exists, but its Hessian says little about its neighbourhood.
    let overrides =
        "grid.gamma_f=200.0 grid.n_gamma=2001 solver.system=doubled solver.digits=70 solver.max_iterations=40";
    match solve::<Extended>(&case(overrides)) {
        Ok(solution) => assert!(solution.gradient_norm < read::<Extended>("1e-60"), "{:?}", solution.gradient_norm),
        Err(failure) => assert!(failure.status != Status::Converged && !failure.advice().is_empty()),
    }
}

/// Where rounding keeps corrections above the digits asked for, a run ends with those that there are.
#[test]
fn the_last_digits_are_those_of_the_type() {
    let set = "scheme={sbp='SBP84',form='weak'} grid={gamma_f=10.0,n_gamma=401} solver.digits=70";
    let solution = solved_in::<Extended>(set);
    let last = solution.iterations.history.last().unwrap().relative_step;
    assert!(last > 1e-71 && last < 1e-66, "{last:e}");
    assert!(solution.gradient_norm.to_f64() < 1e-64, "{:?}", solution.gradient_norm);

    let grid = "grid={gamma_f=400.0,n_gamma=401,windows=1}";
    let set = [grid, "scheme={sbp='SBP84',form='weak'}", "solver.digits=70"];
    let line = line_of::<Extended>(&shipped("schwarzschild-orbit", &set));
    let last = line.iterations.history.last().unwrap().relative_step;
    assert!(last > 1e-71 && last < 1e-66, "{last:e}");
}
