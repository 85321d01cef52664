//! The colour and the shape of each method, which are the same in all pictures.
//!
//! A method of this program has a saturated colour and filled symbols on solid lines. The colour shows its form or
//! kind, and the shape whether it is one block, windows or elements; of methods that share both, the finer operator is
//! darker. Other methods are grey, with open symbols on dashed lines. A curve that combines several methods has the
//! look of one of them.

use crate::case::{Form, SbpName};
use crate::methods::{PEERS, Peer};
use crate::output::chart::{Mark, Shape, Style};
use crate::study::Method;

const STRONG: [u8; 3] = [213, 94, 0];
const WEAK: [u8; 3] = [20, 140, 225];
const SPECTRAL: [u8; 3] = [0, 158, 115];
const MARCH: [u8; 3] = [198, 66, 198];
const ACCURACY: [u8; 3] = [190, 135, 0];
const TOLERANCE: [u8; 3] = [205, 30, 60];

/// The smallest and the largest number of nodes between which the colours of elements are spread.
const ELEMENTS: (f64, f64) = (4.0, 24.0);

/// The looks of the curves of methods to compare with. Of the methods on one curve each is darker than the one before
/// it by this share of black.
const GREYS: [(&str, [u8; 3], f64, Shape); 7] = [
    ("RK4", [64, 68, 76], 0.0, Shape::Circle),
    ("Verlet", [130, 122, 112], 0.0, Shape::Square),
    ("Kahan–Li", [132, 140, 134], 0.3, Shape::Triangle),
    ("Gauss", [140, 132, 146], 0.16, Shape::Diamond),
    ("DOP853", [138, 138, 138], 0.0, Shape::Nabla),
    ("Radau5", [74, 66, 66], 0.0, Shape::Plus),
    ("Taylor", [104, 116, 122], 0.0, Shape::Star),
];

/// Those of other programs, with the tones of their greys.
const STRANGERS: [(&str, u8, Shape); 3] =
    [("heyoka", 40, Shape::Cross), ("heyoka×2", 84, Shape::Asterisk), ("SciPy", 110, Shape::Pentagon)];

/// A colour mixed with the share `black` of black.
fn darker(colour: [u8; 3], black: f64) -> [u8; 3] {
    colour.map(|part| (f64::from(part) * (1.0 - black)).round() as u8)
}

/// The share of black by which an operator is darker than the coarsest one of its kind.
fn depth(sbp: SbpName) -> f64 {
    match sbp {
        SbpName::Sbp21 => 0.0,
        SbpName::Sbp42 => 0.2,
        SbpName::Sbp63 => 0.38,
        SbpName::Sbp84 => 0.54,
        SbpName::Gll(nodes) => depth_of_element(usize::from(nodes)),
    }
}

fn depth_of_element(nodes: usize) -> f64 {
    let (least, most) = ELEMENTS;
    0.42 * ((nodes as f64 / least).ln() / (most / least).ln()).clamp(0.0, 1.2)
}

/// The look of a scheme in one block or, for a spectral element, with one element per window.
pub(super) fn of_scheme(sbp: SbpName, form: Form) -> Style {
    let (colour, shape) = match (sbp, form) {
        (SbpName::Gll(_), Form::Weak) => (SPECTRAL, Shape::Triangle),
        (SbpName::Gll(_), Form::Strong) => (STRONG, Shape::Triangle),
        (_, Form::Strong) => (STRONG, Shape::Circle),
        (_, Form::Weak) => (WEAK, Shape::Square),
    };
    Style { colour: darker(colour, depth(sbp)), shape }
}

/// The look of a method.
pub(super) fn of_method(method: &Method) -> Style {
    let coloured =
        |colour: [u8; 3], nodes: usize, shape: Shape| Style { colour: darker(colour, depth_of_element(nodes)), shape };
    match method {
        Method::Block(sbp, form) => of_scheme(*sbp, *form),
        // The same scheme, but in windows.
        Method::Windows(sbp, form) => Style { shape: Shape::Nabla, ..of_scheme(*sbp, *form) },
        Method::Unregularised(sbp) => Style { shape: Shape::Cross, ..of_scheme(*sbp, Form::Strong) },
        Method::Elements(nodes) => coloured(SPECTRAL, *nodes, Shape::Triangle),
        Method::March(nodes) => coloured(MARCH, *nodes, Shape::Diamond),
        Method::Accuracy => Style { colour: ACCURACY, shape: Shape::Star },
        Method::Tolerance => Style { colour: TOLERANCE, shape: Shape::Nabla },
        Method::Peer(peer) => of_peer(*peer),
        Method::Other(_) => of_stranger(&method.curve().1),
    }
}

/// The look of a method to compare with: those of one curve are ever darker.
fn of_peer(peer: Peer) -> Style {
    let curve = peer.about().curve;
    let (_, colour, step, shape) = GREYS.into_iter().find(|(of, ..)| *of == curve).expect("every curve has a look");
    let place = kin(curve).position(|other| other == peer).unwrap_or(0);
    Style { colour: darker(colour, step * place as f64), shape }
}

/// The methods of a curve.
fn kin(curve: &str) -> impl Iterator<Item = Peer> {
    PEERS.into_iter().filter(move |peer| peer.about().curve == curve)
}

/// The look of the methods of a program that measured them. The names are those of `scripts/work-precision.py`, where
/// `×2` is a run and a finer one for its error; of other names the look is any.
fn of_stranger(curve: &str) -> Style {
    let known = STRANGERS.into_iter().find(|(of, ..)| *of == curve);
    let sum: usize = curve.bytes().map(usize::from).sum();
    let any = ([60 + 20 * (sum % 4) as u8; 3], [Shape::Cross, Shape::Plus, Shape::Pentagon][sum % 3]);
    let (colour, shape) = known.map_or(any, |(_, tone, shape)| ([tone; 3], shape));
    Style { colour, shape }
}

/// The look of the curve that combines a method and its kin.
pub(super) fn of_curve(method: &Method) -> Style {
    of_method(&match method {
        Method::Block(_, form) => Method::Block(SbpName::Sbp42, *form),
        Method::Elements(_) => Method::Elements(16),
        Method::March(_) => Method::March(16),
        // The second of them, if there are several.
        Method::Peer(peer) => Method::Peer(kin(peer.about().curve).nth(1).unwrap_or(*peer)),
        alone => alone.clone(),
    })
}

/// How the curve of a method is drawn.
pub(super) fn mark(is_own: bool) -> Mark {
    if is_own { Mark::LINE_AND_POINTS } else { Mark::DASHED_AND_OPEN_POINTS }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// The lightness of a colour in greyscale, from 0 to 255.
    pub(in super::super) fn grey([red, green, blue]: [u8; 3]) -> f64 {
        0.299 * f64::from(red) + 0.587 * f64::from(green) + 0.114 * f64::from(blue)
    }

    /// The contrast to white as accessibility guidelines define it.
    fn contrast(colour: [u8; 3]) -> f64 {
        let linear = colour.map(|part| {
            let part = f64::from(part) / 255.0;
            if part <= 0.04045 { part / 12.92 } else { ((part + 0.055) / 1.055).powf(2.4) }
        });
        1.05 / (0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2] + 0.05)
    }

    fn saturation(colour: [u8; 3]) -> u8 {
        colour.iter().max().unwrap() - colour.iter().min().unwrap()
    }

    fn strangers() -> [Method; 3] {
        ["SciPy DOP853", "heyoka×2", "heyoka"].map(|name| Method::Other(name.to_owned()))
    }

    /// All methods of both studies, with their looks, and whether they are of this program.
    fn all() -> Vec<(String, Style, bool)> {
        let methods = Method::timed().into_iter().chain(strangers()).chain(Method::charted());
        methods.map(|method| (method.label(), of_method(&method), method.is_own())).collect()
    }

    #[test]
    fn every_method_is_seen_on_white_and_own_methods_are_coloured() {
        for (name, look, is_own) in all() {
            assert!(contrast(look.colour) >= 3.0, "{name}: {}", contrast(look.colour));
            let (least, most) = if is_own { (70, 255) } else { (0, 20) };
            assert!((least..=most).contains(&saturation(look.colour)), "{name}: {:?}", look.colour);
        }
    }

    #[test]
    fn no_two_methods_look_alike() {
        let methods = all();
        for (k, (name, look, _)) in methods.iter().enumerate() {
            for (other, its, _) in &methods[..k] {
                // A method has the same look in all studies, and no two methods share a look.
                assert_eq!(look == its, name == other, "{name} and {other}: {look:?}");
            }
        }
    }

    #[test]
    fn operators_of_a_form_are_told_apart_in_grey() {
        for form in [Form::Strong, Form::Weak] {
            let greys = SbpName::STENCILS.map(|sbp| grey(of_scheme(sbp, form).colour));
            assert!(greys.windows(2).all(|pair| pair[0] - pair[1] >= 18.0), "{greys:?}");
        }
    }

    #[test]
    fn curves_of_a_picture_differ_in_shape_or_in_grey() {
        let alike = |a: Style, b: Style| a.shape == b.shape && (grey(a.colour) - grey(b.colour)).abs() < 10.0;
        // The curves of speed against accuracy: those of this program are filled, others are open.
        for is_own in [true, false] {
            let methods = Method::timed().into_iter().chain(strangers()).filter(|method| method.is_own() == is_own);
            let curves: std::collections::BTreeMap<_, _> =
                methods.map(|method| (method.curve(), of_curve(&method))).collect();
            let curves: Vec<Style> = curves.into_values().collect();
            for (k, &one) in curves.iter().enumerate() {
                assert!(curves[..k].iter().all(|&other| !alike(one, other)), "{one:?} among {curves:?}");
            }
        }
    }
}
