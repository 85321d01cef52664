//! Scenes twice: as texts, and as functions of this program that take dual numbers.

use geodesic_ivp::geometry::{Geometry, GeometryText};
use num_dual::DualNum;

use crate::common::{metric, newtonian, of_x};

/// A number with derivatives, or without.
pub(crate) trait Number: DualNum<Primitive = f64> + Copy {}
impl<D: DualNum<Primitive = f64> + Copy> Number for D {}

/// A scene as text and as functions.
pub(crate) trait Scene {
    /// The coordinates that are not ignorable.
    const ACTIVE: &'static [usize];
    /// The text.
    fn text() -> GeometryText;
    /// g_ab.
    fn metric<D: Number>(q: &[D]) -> Vec<Vec<D>>;
    /// A_a.
    fn one_form<D: Number>(q: &[D]) -> Vec<D>;
    /// F_a.
    fn force<D: Number>(q: &[D], q_dot: &[D]) -> Vec<D>;

    /// The compiled text.
    fn geometry() -> Geometry {
        Geometry::new(&Self::text()).unwrap_or_else(|error| panic!("{error}"))
    }

    /// ½ g_ab q̇^a q̇^b + A_a q̇^a.
    fn lagrangian<D: Number>(q: &[D], q_dot: &[D]) -> D {
        let (g, a) = (Self::metric(q), Self::one_form(q));
        let mut sum = D::from(0.0);
        for (row, (&one_form, &velocity)) in g.iter().zip(a.iter().zip(q_dot)) {
            sum += one_form * velocity;
            for (&entry, &other) in row.iter().zip(q_dot) {
                sum += entry * velocity * other * 0.5;
            }
        }
        sum
    }

    /// p_a = g_ab q̇^b + A_a.
    fn momenta<D: Number>(q: &[D], q_dot: &[D]) -> Vec<D> {
        let rows = Self::metric(q).into_iter().zip(Self::one_form(q));
        let product = |row: Vec<D>| row.iter().zip(q_dot).fold(D::from(0.0), |sum, (&g, &u)| sum + g * u);
        rows.map(|(row, one_form)| one_form + product(row)).collect()
    }
}

/// A matrix of zeros.
fn zeros<D: Number>(n: usize) -> Vec<Vec<D>> {
    vec![vec![D::from(0.0); n]; n]
}

fn set<D: Number>(g: &mut [Vec<D>], a: usize, b: usize, value: D) {
    g[a][b] = value;
    g[b][a] = value;
}

/// Every feature at once, in four coordinates of which the last is ignorable.
pub(crate) struct Everything;

impl Scene for Everything {
    const ACTIVE: &'static [usize] = &[0, 1, 2];

    fn text() -> GeometryText {
        let components = [
            ("t t", "2 + x^2/3 + sin(t)/4"),
            ("x t", "k*cos(y)"),
            ("x x", "-(1 + y^2/5)"),
            ("y y", "-1.5 - x*t/7"),
            ("y z", "x/5"),
            ("z z", "-exp(t/5)"),
        ];
        GeometryText {
            parameters: vec![("k".into(), "3/10".into())],
            definitions: vec![("late".into(), "t*early".into()), ("early".into(), "1/5".into())],
            one_form: vec![(0, "x*y/3".into()), (3, "0.4*sin(x) + late".into())],
            force: vec![(0, "0.1*z_dot".into()), (1, "t*z_dot^2/20 - 0.1*x_dot".into()), (2, "-y_dot*t_dot/5".into())],
            conformal: Some("1 + x^2/10 + y^2/9".into()),
            ..metric(&["t", "x", "y", "z"], &components)
        }
    }

    fn metric<D: Number>(q: &[D]) -> Vec<Vec<D>> {
        let (t, x, y) = (q[0], q[1], q[2]);
        let mut g = zeros(4);
        set(&mut g, 0, 0, x * x / 3.0 + t.sin() / 4.0 + 2.0);
        set(&mut g, 0, 1, y.cos() * 0.3);
        set(&mut g, 1, 1, -(y * y / 5.0) - 1.0);
        set(&mut g, 2, 2, -(x * t / 7.0) - 1.5);
        set(&mut g, 2, 3, x / 5.0);
        set(&mut g, 3, 3, -(t / 5.0).exp());
        let omega = x * x / 10.0 + y * y / 9.0 + 1.0;
        g.iter_mut().flatten().for_each(|entry| *entry *= omega);
        g
    }

    fn one_form<D: Number>(q: &[D]) -> Vec<D> {
        let (t, x, y) = (q[0], q[1], q[2]);
        vec![x * y / 3.0, D::from(0.0), D::from(0.0), x.sin() * 0.4 + t / 5.0]
    }

    fn force<D: Number>(q: &[D], u: &[D]) -> Vec<D> {
        vec![u[3] * 0.1, q[0] * u[3] * u[3] / 20.0 - u[1] * 0.1, -(u[2] * u[0]) / 5.0, D::from(0.0)]
    }
}

/// A curved plane with an indefinite metric, a one-form and a force across the velocity.
pub(crate) struct Plane;

impl Scene for Plane {
    const ACTIVE: &'static [usize] = &[0, 1];

    fn text() -> GeometryText {
        GeometryText {
            one_form: vec![(0, "y^2 - x".into())],
            force: vec![(1, "x_dot*y^2".into())],
            ..metric(&["x", "y"], &[("x x", "2 + sin(x*y)"), ("x y", "0.3"), ("y y", "-1 - x^2")])
        }
    }

    fn metric<D: Number>(q: &[D]) -> Vec<Vec<D>> {
        let (x, y) = (q[0], q[1]);
        let mut g = zeros(2);
        set(&mut g, 0, 0, (x * y).sin() + 2.0);
        set(&mut g, 0, 1, D::from(0.3));
        set(&mut g, 1, 1, -(x * x) - 1.0);
        g
    }

    fn one_form<D: Number>(q: &[D]) -> Vec<D> {
        vec![q[1] * q[1] - q[0], D::from(0.0)]
    }

    fn force<D: Number>(q: &[D], u: &[D]) -> Vec<D> {
        vec![D::from(0.0), u[0] * q[1] * q[1]]
    }
}

/// Null coordinates u and v, whose diagonal components are zero, and one more.
pub(crate) struct Null;

impl Scene for Null {
    const ACTIVE: &'static [usize] = &[0, 2];

    fn text() -> GeometryText {
        GeometryText {
            one_form: vec![(1, "w^3/4".into())],
            ..metric(&["u", "v", "w"], &[("u v", "2 + cos(w)"), ("w w", "-exp(u/4)"), ("u w", "w/6")])
        }
    }

    fn metric<D: Number>(q: &[D]) -> Vec<Vec<D>> {
        let (u, w) = (q[0], q[2]);
        let mut g = zeros(3);
        set(&mut g, 0, 1, w.cos() + 2.0);
        set(&mut g, 2, 2, -(u / 4.0).exp());
        set(&mut g, 0, 2, w / 6.0);
        g
    }

    fn one_form<D: Number>(q: &[D]) -> Vec<D> {
        vec![D::from(0.0), q[2] * q[2] * q[2] / 4.0, D::from(0.0)]
    }

    fn force<D: Number>(_: &[D], _: &[D]) -> Vec<D> {
        vec![D::from(0.0); 3]
    }
}

/// Newton's law with two masses, a magnetic field, friction and drive, and a conformal factor.
pub(crate) struct Lifted;

impl Scene for Lifted {
    const ACTIVE: &'static [usize] = &[0, 1, 2];

    fn text() -> GeometryText {
        let mut text = GeometryText {
            parameters: vec![("b".into(), "0.7".into())],
            one_form: vec![(0, "-b*y".into()), (1, "x^2/3".into())],
            force: vec![(0, "1/4 - x_dot/5 + y_dot^3".into())],
            conformal: Some("1 + x^2/4".into()),
            ..newtonian(&["x", "y"], "x^2*y + cos(y)")
        };
        text.potential.as_mut().unwrap().masses = vec!["3/2".into(), "b".into()];
        text
    }

    fn metric<D: Number>(q: &[D]) -> Vec<Vec<D>> {
        let (x, y) = (q[1], q[2]);
        let mut g = zeros(4);
        set(&mut g, 0, 0, (x * x * y + y.cos()) * 2.0);
        set(&mut g, 0, 1, y * 0.7);
        set(&mut g, 0, 2, -(x * x) / 3.0);
        set(&mut g, 0, 3, D::from(1.0));
        set(&mut g, 1, 1, D::from(-1.5));
        set(&mut g, 2, 2, D::from(-0.7));
        let omega = x * x / 4.0 + 1.0;
        g.iter_mut().flatten().for_each(|entry| *entry *= omega);
        g
    }

    fn one_form<D: Number>(_: &[D]) -> Vec<D> {
        vec![D::from(0.0); 4]
    }

    /// −Ω ṫ² F(x, dx/dt), and the work of it in p_t.
    fn force<D: Number>(q: &[D], u: &[D]) -> Vec<D> {
        let omega = q[1] * q[1] / 4.0 + 1.0;
        let [v_x, v_y] = [u[1] / u[0], u[2] / u[0]];
        let newton = -(v_x / 5.0) + v_y * v_y * v_y + 0.25;
        let force = -(omega * u[0] * u[0] * newton);
        vec![-(force * u[1] / u[0]), force, D::from(0.0), D::from(0.0)]
    }
}

/// V(x), a mass and a speed of light.
pub(crate) struct OneCoordinate;

impl Scene for OneCoordinate {
    const ACTIVE: &'static [usize] = &[1];

    fn text() -> GeometryText {
        unreachable!("it has constants of its own")
    }

    fn geometry() -> Geometry {
        of_x("exp(-0.7*x) + x^3/5", 1.7, 1.2)
    }

    fn metric<D: Number>(q: &[D]) -> Vec<Vec<D>> {
        let x = q[1];
        let mut g = zeros(2);
        set(&mut g, 0, 0, ((x * -0.7).exp() + x * x * x / 5.0) * (2.0 / 1.7) + 1.2 * 1.2);
        set(&mut g, 1, 1, D::from(-1.0));
        g
    }

    fn one_form<D: Number>(_: &[D]) -> Vec<D> {
        vec![D::from(0.0); 2]
    }

    fn force<D: Number>(_: &[D], _: &[D]) -> Vec<D> {
        vec![D::from(0.0); 2]
    }
}
