//! A text says more than its formulas: conserved sums are found, and coordinates that are coupled.

use geodesic_ivp::geometry::{Geometry, GeometryText, MOST_COUPLED};

use crate::common::{geometry, metric, newtonian, newtonian_start, preset, start};

fn sums(text: &GeometryText, x: &[f64], v: &[f64]) -> Vec<String> {
    let scene: Geometry = geometry(text);
    let start = newtonian_start(&scene, x, v);
    let sums = scene.conserved_sums(&start, || geometry(text));
    sums.iter().map(|sum| sum.formula(scene.names())).collect()
}

#[test]
fn sums_of_momenta() {
    let pair = newtonian(&["x1", "x2"], "(x1 - x2)^4/4 + cos(x1 - x2)");
    assert_eq!(sums(&pair, &[0.3, -0.4], &[0.1, 0.2]), ["p_x1 + p_x2"]);
    let oblique = newtonian(&["x", "y"], "sin(2*x - y)");
    assert_eq!(sums(&oblique, &[0.3, -0.4], &[0.1, 0.2]), ["p_x + 2*p_y"]);
    let henon_heiles = newtonian(&["x", "y"], "(x^2 + y^2)/2 + x^2*y - y^3/3");
    assert!(sums(&henon_heiles, &[0.1, 0.0], &[0.0, 0.5]).is_empty());
    let distance = |a: usize, b: usize| format!("1/sqrt((x{a} - x{b})^2 + (y{a} - y{b})^2)");
    let expression = format!("-{} - {} - {}", distance(1, 2), distance(1, 3), distance(2, 3));
    let bodies = newtonian(&["x1", "y1", "x2", "y2", "x3", "y3"], &expression);
    let mut found = sums(&bodies, &[1.0, -0.2, -1.0, 0.2, 0.0, 0.0], &[0.4, 0.4, 0.4, 0.4, -0.9, -0.8]);
    found.sort();
    assert_eq!(found, ["p_x1 + p_x2 + p_x3", "p_y1 + p_y2 + p_y3"]);
    // Friction on one of two bodies takes momentum away; the same on both by their difference does not.
    let mut rubbing = pair.clone();
    rubbing.force = vec![(0, "-x1_dot".into())];
    assert!(sums(&rubbing, &[0.3, -0.4], &[0.1, 0.2]).is_empty());
    rubbing.force = vec![(0, "x2_dot - x1_dot".into()), (1, "x1_dot - x2_dot".into())];
    assert_eq!(sums(&rubbing, &[0.3, -0.4], &[0.1, 0.2]), ["p_x1 + p_x2"]);
    // The momentum of an ignorable coordinate is conserved itself, and no sum is looked for.
    let hole: Geometry = geometry(&preset("schwarzschild", &[]));
    let at = start(&hole, &[0.0, 10.0, 0.0], &[1.2, -0.05, 0.03]);
    assert!(hole.conserved_sums(&at, || geometry(&preset("schwarzschild", &[]))).is_empty());
}

/// The forces on a light body are rounding errors of those on a heavy one, and metres are small beside an orbit.
#[test]
fn sums_of_momenta_do_not_depend_on_masses_and_units() {
    for (light, unit) in [(1e-7, 1.0), (1e-15, 1.5e11), (1e-30, 1e-20)] {
        let pair = |mass: &str, a: usize, b: usize| format!("-{mass}/sqrt((x{a} - x{b})^2 + (y{a} - y{b})^2)");
        let expression = [pair("2", 1, 2), pair("m", 1, 3), pair("2*m", 2, 3)].join(" + ").replace("+ -", "- ");
        let mut bodies = newtonian(&["x1", "y1", "x2", "y2", "x3", "y3"], &expression);
        bodies.parameters = vec![("m".to_owned(), format!("{light:e}"))];
        let at = [1.0, -0.2, -1.0, 0.2, 0.0, 0.0].map(|x| x * unit);
        let mut found = sums(&bodies, &at, &[0.4, 0.4, 0.4, 0.4, -0.9, -0.8]);
        found.sort();
        assert_eq!(found, ["p_x1 + p_x2 + p_x3", "p_y1 + p_y2 + p_y3"], "{light:e} in {unit:e}");
        let orbit = newtonian(&["x", "y"], "-1/sqrt(x^2 + y^2)");
        assert!(sums(&orbit, &[0.0, unit], &[1.0, 0.0]).is_empty(), "{unit:e}");
    }
}

#[test]
fn blocks_of_the_metric() {
    let mistake = |text: GeometryText| Geometry::<f64>::new(&text).unwrap_err().to_string();
    let three = metric(&["x", "y", "z"], &[("x x", "1"), ("x y", "x"), ("x z", "y")]);
    assert_eq!(mistake(three), "the determinant of the metric is zero everywhere (coordinates x, y, z)");
    // A determinant that vanishes for every x, though no term of it does, is found where the scene starts.
    let hidden: Geometry = geometry(&metric(&["x", "y"], &[("x x", "x"), ("x y", "x"), ("y y", "x")]));
    assert_eq!(hidden.with_domain_of(&[1.5, 0.0]).unwrap_err().block, Some(0));
    let names: Vec<String> = (0..=MOST_COUPLED).map(|k| format!("x{k}")).collect();
    let coupled = |count: usize| GeometryText {
        coordinates: names[..count].to_vec(),
        components: (0..count)
            .map(|k| ([k, k], "2".to_owned()))
            .chain((1..count).map(|k| ([k - 1, k], "x0/9".to_owned())))
            .collect(),
        ..GeometryText::default()
    };
    let many = "9 coordinates are coupled by off-diagonal components, at most 8 may be";
    assert_eq!(mistake(coupled(MOST_COUPLED + 1)), many);
    let largest: Geometry = geometry(&coupled(MOST_COUPLED));
    assert_eq!(largest.blocks, [(0..MOST_COUPLED).collect::<Vec<_>>()]);
}
