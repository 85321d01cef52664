//! Metrics by name. All have the signature + − − … of the paper, and units with G = c = 1 unless they say otherwise.

use super::text::GeometryText;

/// A metric that a case can name in place of its components. Lists are of `NAME = FORMULA`, with semicolons between.
#[derive(Debug, Clone, Copy)]
pub struct Preset {
    /// Its name in a case.
    pub name: &'static str,
    coordinates: &'static str,
    components: &'static str,
    /// H = ½ g^ab p_a p_b in the coordinates and their momenta `p_NAME`, where it is shorter than what adjugates give.
    hamiltonian: Option<&'static str>,
    /// Definitions; a case may replace them.
    definitions: &'static str,
    /// Parameters with the values that they have unless the case gives others.
    parameters: &'static str,
}

/// The names and formulas of a list.
fn named(list: &'static str) -> impl Iterator<Item = (&'static str, &'static str)> {
    list.split("; ").filter_map(|part| part.split_once(" = "))
}

impl Preset {
    /// The preset of that name.
    pub fn from_name(name: &str) -> Option<&'static Self> {
        PRESETS.iter().find(|preset| preset.name == name)
    }

    /// The Hamiltonian of this metric, if it is one of a preset with the same definitions.
    pub(super) fn hamiltonian(text: &GeometryText) -> Option<&'static str> {
        let is_same = |preset: &&Self| {
            let own = preset.text();
            let is_defined = |definition| text.definitions.contains(definition);
            own.coordinates == text.coordinates
                && own.components == text.components
                && own.definitions.iter().all(is_defined)
        };
        PRESETS.iter().filter(|preset| preset.hamiltonian.is_some()).find(is_same)?.hamiltonian
    }

    /// The names of its parameters.
    pub fn parameters(&self) -> impl Iterator<Item = &'static str> {
        named(self.parameters).map(|(name, _)| name)
    }

    /// Its formulas.
    pub fn text(&self) -> GeometryText {
        let owned = |list| named(list).map(|(name, text)| (name.to_owned(), text.to_owned())).collect();
        let coordinates: Vec<String> = self.coordinates.split(' ').map(str::to_owned).collect();
        let index =
            |name: &str| coordinates.iter().position(|other| other == name).expect("a coordinate of the preset");
        let pair = |names: &str| names.split_once(' ').map(|(a, b)| [index(a), index(b)]).expect("two names");
        GeometryText {
            components: named(self.components).map(|(names, text)| (pair(names), text.to_owned())).collect(),
            definitions: owned(self.definitions),
            parameters: owned(self.parameters),
            coordinates,
            ..GeometryText::default()
        }
    }
}

const NONE: Preset =
    Preset { name: "", coordinates: "", components: "", hamiltonian: None, definitions: "", parameters: "" };

/// All presets.
pub const PRESETS: [Preset; 9] = [
    // Flat space-time in Cartesian coordinates (H. Minkowski, Phys. Z. 10 (1909) 75).
    Preset {
        name: "minkowski",
        coordinates: "t x y z",
        components: "t t = c^2; x x = -1; y y = -1; z z = -1",
        parameters: "c = 1",
        ..NONE
    },
    // Flat space-time, a plane in polar coordinates (H. Minkowski, Phys. Z. 10 (1909) 75).
    Preset {
        name: "polar",
        coordinates: "t r phi",
        components: "t t = c^2; r r = -1; phi phi = -r^2",
        parameters: "c = 1",
        ..NONE
    },
    // A plane through a mass m, outside the horizon r = 2m (K. Schwarzschild, Sitzungsber. Preuss. Akad. Wiss. (1916)
    // 189).
    Preset {
        name: "schwarzschild",
        coordinates: "t r phi",
        components: "t t = f; r r = -1/f; phi phi = -r^2",
        definitions: "f = 1 - 2*m/r",
        parameters: "m = 1",
        ..NONE
    },
    // The same in ingoing Eddington-Finkelstein coordinates, through the horizon (D. Finkelstein, Phys. Rev. 110 (1958)
    // 965).
    Preset {
        name: "schwarzschild-ef",
        coordinates: "v r phi",
        components: "v v = 1 - 2*m/r; v r = -1; phi phi = -r^2",
        parameters: "m = 1",
        ..NONE
    },
    // A mass m with angular momentum m a, in Boyer-Lindquist coordinates (R. H. Boyer and R. W. Lindquist, J. Math.
    // Phys. 8 (1967) 265).
    Preset {
        name: "kerr",
        coordinates: "t r theta phi",
        components: "t t = 1 - w; t phi = a*w*s2; r r = -sigma/(r^2 - 2*m*r + a^2); theta theta = -sigma; \
                     phi phi = -(r^2 + a^2 + a^2*w*s2)*s2",
        hamiltonian: Some(
            "(((r^2 + a^2)*p_t + a*p_phi)^2/(r^2 - 2*m*r + a^2) - (a*sin(theta)*p_t + p_phi/sin(theta))^2 \
             - (r^2 - 2*m*r + a^2)*p_r^2 - p_theta^2)/2/sigma",
        ),
        definitions: "sigma = r^2 + a^2*cos(theta)^2; s2 = sin(theta)^2; w = 2*m*r/sigma",
        parameters: "m = 1; a = 0",
    },
    // The equatorial plane of the same (R. H. Boyer and R. W. Lindquist, J. Math. Phys. 8 (1967) 265).
    Preset {
        name: "kerr-equatorial",
        coordinates: "t r phi",
        components: "t t = 1 - w; t phi = a*w; r r = -r^2/(r^2 - 2*m*r + a^2); phi phi = -(r^2 + a^2 + a^2*w)",
        hamiltonian: Some(
            "((p_t + a*(a*p_t + p_phi)/r^2)^2/(1 - 2*m/r + (a/r)^2) - (1 - 2*m/r + (a/r)^2)*p_r^2 \
             - ((a*p_t + p_phi)/r)^2)/2",
        ),
        definitions: "w = 2*m/r",
        parameters: "m = 1; a = 0",
    },
    // The same mass in Cartesian Kerr-Schild coordinates, through the horizon (R. P. Kerr and A. Schild, Proc. Symp.
    // Appl. Math. 17 (1965) 199).
    Preset {
        name: "kerr-schild",
        coordinates: "t x y z",
        components: "t t = 1 - h; t x = -h*u; t y = -h*v; t z = -h*w; x x = -1 - h*u^2; x y = -h*u*v; x z = -h*u*w; \
                     y y = -1 - h*v^2; y z = -h*v*w; z z = -1 - h*w^2",
        hamiltonian: Some("(p_t^2 - p_x^2 - p_y^2 - p_z^2 + h*(p_t - u*p_x - v*p_y - w*p_z)^2)/2"),
        definitions: "d = x^2 + y^2 + z^2 - a^2; r = sqrt((d + sqrt(d^2 + 4*a^2*z^2))/2); \
                      h = 2*m*r^3/(r^4 + a^2*z^2); u = (r*x + a*y)/(r^2 + a^2); v = (r*y - a*x)/(r^2 + a^2); w = z/r",
        parameters: "m = 1; a = 0",
    },
    // A flat expanding universe with the scale factor a(t), a definition (H. P. Robertson, Astrophys. J. 82 (1935)
    // 284).
    Preset {
        name: "flrw",
        coordinates: "t x y z",
        components: "t t = 1; x x = -a^2; y y = -a^2; z z = -a^2",
        definitions: "a = t^(2/3)",
        ..NONE
    },
    // Rays in a plane with the refractive index n(x, y), a definition (Fermat's principle; M. Born and E. Wolf,
    // Principles of Optics, 7th ed., ch. 3).
    Preset { name: "optics", coordinates: "x y", components: "x x = n^2; y y = n^2", definitions: "n = 1", ..NONE },
];

#[cfg(test)]
mod tests {
    use super::super::{Geometry, GeometryText, Tau};
    use super::{PRESETS, Preset};

    /// Presets with a Hamiltonian, with a one-form, and with a factor and `tau`.
    fn texts() -> Vec<GeometryText> {
        let mut texts = Vec::new();
        for preset in PRESETS.iter().filter(|preset| preset.hamiltonian.is_some()) {
            let mut text = preset.text();
            text.parameters.iter_mut().filter(|(name, _)| name == "a").for_each(|(_, value)| *value = "0.9".to_owned());
            texts.push(text.clone());
            let x = text.coordinates[1].clone();
            text.one_form = vec![(0, format!("0.3/{x}")), (1, format!("{x}/7")), (2, format!("0.1*{x}^2"))];
            texts.push(text.clone());
            (text.conformal, text.tau) = (Some(format!("1/(2 + {x}^2)")), Some(Tau::Spacelike));
            texts.push(text);
        }
        texts
    }

    /// q̇^a and then ṗ_a of active coordinates, anywhere.
    fn rates(text: &GeometryText) -> Vec<f64> {
        let geometry: Geometry = Geometry::new(text).unwrap();
        let (mut point, n) = (geometry.point(), geometry.dimension());
        point.evaluate(&[0.3, 2.7, 1.1, 0.4, 0.2][..n], &[0.9, -0.7, 1.3, -2.1, 0.8][..n]).unwrap();
        let velocities: Vec<f64> = (0..n).map(|a| point.q_dot(a)).collect();
        velocities.into_iter().chain((0..geometry.active().len()).map(|k| point.p_dot(k))).collect()
    }

    /// They belong to components and definitions, and rates are those of the same metric as one that is not known.
    #[test]
    fn hamiltonians_are_those_of_the_components() {
        for text in texts() {
            let [mut unknown, mut more, mut other] = [(); 3].map(|()| text.clone());
            unknown.components[0].1 = format!("({})", unknown.components[0].1);
            more.definitions.push(("n".to_owned(), "2".to_owned()));
            other.definitions.iter_mut().take(1).for_each(|(_, definition)| *definition = "2".to_owned());
            let is_known = |text: &GeometryText| Preset::hamiltonian(text).is_some();
            assert_eq!([&text, &more, &unknown].map(is_known), [true, true, false]);
            assert_eq!(is_known(&other), text.definitions.is_empty());
            let (known, expected) = (rates(&text), rates(&unknown));
            let size = expected.iter().fold(0.0_f64, |size, rate| size.max(rate.abs()));
            for (one, other) in known.iter().zip(&expected) {
                assert!((one - other).abs() <= 1e-13 * size, "{known:?} {expected:?}");
            }
        }
    }

    #[test]
    fn sweeps_are_short() {
        for (name, most) in [("kerr", 47), ("kerr-equatorial", 17), ("kerr-schild", 122)] {
            let mut text = Preset::from_name(name).unwrap().text();
            text.parameters[1].1 = "0.9".to_owned();
            let geometry: Geometry = Geometry::new(&text).unwrap();
            let (n, active, equations) = (geometry.dimension(), geometry.active(), &geometry.hamiltonian);
            let is_known = |variable: usize| variable >= 2 * n && !active.contains(&(variable - 2 * n));
            let varies = equations.program.depends_on(|variable| !is_known(variable));
            let slopes = equations.forces.iter().copied().chain(equations.active_velocities());
            let steps = equations.program.schedule(slopes, |register| !varies[register]).len();
            assert!(steps <= most, "{name}: {steps}");
        }
    }
}
