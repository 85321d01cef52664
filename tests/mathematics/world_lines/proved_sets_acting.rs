//! Sets of starts through events that act and through kinks: motions from them, by closed forms, end in the hull.

use geodesic_ivp::number::{Extended, Real};
use geodesic_ivp::study::proof::{Hull, hull};

use super::proved_acting::{decimal, number};
use crate::common::parsed;
use crate::random_scenes::random::Random;

/// So many draws of each family, and so many motions of each set.
const DRAWS: u64 = 40;
const MOTIONS: u64 = 12;

/// An interval around a number, with its ends.
fn around(middle: &str, radius: f64) -> (String, [Extended; 2]) {
    let off = Extended::from_decimal(&format!("{radius:e}")).unwrap();
    let ends = [decimal(middle) - off, decimal(middle) + off].map(|end| end.to_decimal(60));
    (format!("[{}, {}]", ends[0], ends[1]), ends.map(|end| decimal(&end)))
}

/// A number of an interval: an end, the other one, and then others.
fn member(random: &mut Random, ends: [Extended; 2], k: u64) -> Extended {
    let share = [0.0, 1.0].get(k as usize).copied().unwrap_or_else(|| random.between(0.0, 1.0));
    ends[0] + Extended::from(share) * (ends[1] - ends[0])
}

/// The ends of the hull in a coordinate; `None` where there is none.
fn of(hull: &Hull, name: &str) -> Option<[Extended; 2]> {
    let (_, ends) = hull.ends.as_ref().ok()?.iter().find(|(own, _)| own == name)?;
    Some(ends.map(Extended::from))
}

/// A ball that bounces, to a time.
fn ball([mut z, mut speed, e]: [Extended; 3], time: &str) -> Extended {
    let (g, two, mut left) = (decimal("9.81"), Extended::from(2.0), decimal(time));
    loop {
        let next = (speed + (speed * speed + two * g * z).sqrt()) / g;
        if next > left {
            return z + speed * left - g * left * left / two;
        }
        left -= next;
        (speed, z) = (e * (g * next - speed), Extended::ZERO);
    }
}

/// Most sets are proved, no motion ends outside, and narrow hulls are as wide as what corners reach, but for what is
/// quadratic in their widths.
#[test]
fn balls_from_a_box_bounce_into_the_hull() {
    let (mut proved, mut wide) = (0, 0.0_f64);
    for draw in 0..DRAWS {
        let mut random = Random(9100 + 64 * draw);
        let [z, speed, e] = [(0.6, 1.5), (-1.0, 1.0), (0.8, 0.95)].map(|(a, b)| number(&mut random, a, b));
        let radius = random.scale(1e-8, 1e-2);
        let ((z, of_z), (speed, of_speed)) = (around(&z, radius), around(&speed, 0.5 * radius));
        let limit = ["t_f", "gamma_f"][draw as usize % 2];
        let text = format!(
            "potential = {{ coordinates = [\"z\"], formula = \"9.81*z\" }}\nparticle.law = \"newtonian\"\n\
             initial = {{ z = {z}, z_dot = {speed} }}\ngrid.{limit} = 1.5\nsolver.accuracy = 1e-9\n[events]\n\
             floor = {{ when = \"z\", direction = \"down\", set = {{ z_dot = \"-{e}*z_dot\" }} }}"
        );
        let found = hull(&parsed(&text, &[]), &mut |_| true);
        let Some([low, high]) = of(&found, "z") else { continue };
        proved += 1;
        let mut reached = [high, low];
        for k in 0..MOTIONS {
            let start = [member(&mut random, of_z, k % 2), member(&mut random, of_speed, k / 2 % 2)];
            let start = if k < 4 { start } else { [of_z, of_speed].map(|ends| member(&mut random, ends, k)) };
            let end = ball([start[0], start[1], decimal(&e)], "1.5");
            assert!(low <= end && end <= high, "draw {draw}: {text}");
            reached =
                [if end < reached[0] { end } else { reached[0] }, if end > reached[1] { end } else { reached[1] }];
        }
        if radius < 1e-5 {
            wide = wide.max(((high - low) / (reached[1] - reached[0])).to_f64());
        }
    }
    assert!(proved as f64 > 0.8 * DRAWS as f64 && wide < 1.2, "{proved} proved, {wide} times as wide");
}

/// The spring of V = k|x| pushes with one force on each side: pieces of parabolas, and their turns.
#[test]
fn motions_in_a_kinked_potential_end_in_the_hull() {
    let mut proved = 0;
    for draw in 0..DRAWS {
        let mut random = Random(9900 + 64 * draw);
        let (x, radius) = (number(&mut random, 0.5, 1.5), random.scale(1e-8, 3e-3));
        let (interval, ends) = around(&x, radius);
        let text = format!(
            "potential = {{ coordinates = [\"x\"], formula = \"2*abs(x)\" }}\nparticle.law = \"newtonian\"\n\
             initial = {{ x = {interval}, x_dot = 0.0 }}\ngrid.t_f = 2.3\nsolver.accuracy = 1e-9\n"
        );
        let found = hull(&parsed(&text, &[]), &mut |_| true);
        let Some([low, high]) = of(&found, "x") else { continue };
        proved += 1;
        for k in 0..MOTIONS {
            let x = member(&mut random, ends, k);
            // A quarter of a period takes √x, as x = x₀ − t² there.
            let (quarter, mut left, two) = (x.sqrt(), decimal("2.3"), Extended::from(2.0));
            let mut sign = Extended::ONE;
            while left > two * quarter {
                left -= two * quarter;
                sign = -sign;
            }
            // From rest at ± x through 0, and on to the other side.
            let end =
                if left < quarter { x - left * left } else { (left - two * quarter) * (left - two * quarter) - x };
            assert!(low <= sign * end && sign * end <= high, "draw {draw}: {text}");
        }
    }
    assert!(proved as f64 > 0.8 * DRAWS as f64, "{proved} proved");
}

/// A parameter that an event sets by one that lies in an interval.
#[test]
fn springs_that_weaken_by_a_part_that_is_not_known_end_in_the_hull() {
    let mut proved = 0;
    for draw in 0..DRAWS {
        let mut random = Random(10_700 + 64 * draw);
        let (part, radius) = (number(&mut random, 0.8, 1.1), random.scale(1e-8, 1e-3));
        let (interval, ends) = around(&part, radius);
        let text = format!(
            "potential = {{ coordinates = [\"x\"], formula = \"k*x^2/2\" }}\nparticle.law = \"newtonian\"\n\
             parameters = {{ k = 4.0, part = {interval} }}\ninitial = {{ x = 1.0, x_dot = 0.0 }}\ngrid.t_f = 4.0\n\
             solver.accuracy = 1e-9\nevents.weaker = {{ when = \"x\", set = {{ k = \"part*k\" }} }}"
        );
        let found = hull(&parsed(&text, &[]), &mut |_| true);
        let Some([low, high]) = of(&found, "x") else { continue };
        proved += 1;
        for k in 0..MOTIONS {
            let root = member(&mut random, ends, k).sqrt();
            let (two, end) = (Extended::from(2.0), decimal("4"));
            let (mut time, mut frequency, mut sign) = (Extended::PI / (two * two), two * root, -Extended::ONE);
            while time + Extended::PI / frequency < end {
                time += Extended::PI / frequency;
                frequency *= root;
                sign = -sign;
            }
            let x = sign * two / frequency * (frequency * (end - time)).sin();
            assert!(low <= x && x <= high, "draw {draw}: {text}");
        }
    }
    assert!(proved as f64 > 0.8 * DRAWS as f64, "{proved} proved");
}
