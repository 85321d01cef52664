//! The colour and the shape of each method, which are the same in all pictures.
//!
//! A method of this program has a saturated colour and filled symbols on solid lines. The colour shows its form or
//! kind, and the shape whether it is one block, windows or elements; of methods that share both, the finer operator is
//! darker. Other methods are grey, with open symbols on dashed lines. A curve that combines several methods has the
//! look of one of them.

use crate::case::{Form, SbpName};
use crate::methods::{PEERS, Peer};
use crate::output::chart::{Look, Mark, Shape};
use crate::study::stability::Method;
use crate::study::work_precision::{Family, Group};

const STRONG: [u8; 3] = [213, 94, 0];
const WEAK: [u8; 3] = [20, 140, 225];
const SPECTRAL: [u8; 3] = [0, 158, 115];
const MARCH: [u8; 3] = [198, 66, 198];
const ACCURACY: [u8; 3] = [190, 135, 0];
const TOLERANCE: [u8; 3] = [176, 92, 0];

/// The smallest and the largest number of nodes between which the colours of elements are spread.
const ELEMENTS: (f64, f64) = (4.0, 24.0);

/// The looks of the curves of methods to compare with. Of the methods on one curve each is darker than the one before
/// it by this share of black.
const GREYS: [(&str, [u8; 3], f64, Shape); 7] = [
    ("RK4", [64, 68, 76], 0.0, Shape::Circle),
    ("Störmer–Verlet", [130, 122, 112], 0.0, Shape::Square),
    ("Kahan–Li 6, 8", [132, 140, 134], 0.3, Shape::Triangle),
    ("Gauss–Legendre", [140, 132, 146], 0.16, Shape::Diamond),
    ("DOP853", [138, 138, 138], 0.0, Shape::Nabla),
    ("Radau IIA 5", [74, 66, 66], 0.0, Shape::Plus),
    ("Taylor", [104, 116, 122], 0.0, Shape::Star),
];

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
pub(super) fn of_scheme(sbp: SbpName, form: Form) -> Look {
    let (colour, shape) = match (sbp, form) {
        (SbpName::Gll(_), Form::Weak) => (SPECTRAL, Shape::Triangle),
        (SbpName::Gll(_), Form::Strong) => (STRONG, Shape::Triangle),
        (_, Form::Strong) => (STRONG, Shape::Circle),
        (_, Form::Weak) => (WEAK, Shape::Square),
    };
    Look { colour: darker(colour, depth(sbp)), shape }
}

/// The look of a method of `work-precision`.
pub(super) fn of_family(family: &Family) -> Look {
    let grey = |colour: [u8; 3], black: f64, shape: Shape| Look { colour: darker(colour, black), shape };
    match family {
        Family::Block(sbp, form) => of_scheme(*sbp, *form),
        Family::Elements(nodes) => grey(SPECTRAL, depth_of_element(*nodes), Shape::Triangle),
        Family::March(nodes) => grey(MARCH, depth_of_element(*nodes), Shape::Diamond),
        Family::Accuracy => Look { colour: ACCURACY, shape: Shape::Star },
        Family::Tolerance => Look { colour: TOLERANCE, shape: Shape::Star },
        Family::Peer(peer) => of_peer(*peer),
        Family::Other(name) => of_stranger(name),
    }
}

/// The look of a method to compare with: those of one curve are ever darker.
fn of_peer(peer: &'static dyn Peer) -> Look {
    let curve = peer.about().curve;
    let Some(&(_, colour, step, shape)) = GREYS.iter().find(|(of, ..)| *of == curve) else {
        return of_stranger(&peer.name());
    };
    let place = kin(curve).position(|other| other == peer).unwrap_or(0);
    Look { colour: darker(colour, step * place as f64), shape }
}

/// The methods of a curve.
fn kin(curve: &str) -> impl Iterator<Item = &'static dyn Peer> {
    PEERS.into_iter().filter(move |peer| peer.about().curve == curve)
}

/// The look of a method that another program measured. If this program has a method of that name, the shape is the same
/// and the grey is another one.
fn of_stranger(name: &str) -> Look {
    let lower = name.to_lowercase();
    let namesake = PEERS.iter().find_map(|peer| {
        let (.., shape) = GREYS.iter().find(|(curve, ..)| *curve == peer.about().curve)?;
        lower.contains(&peer.name().to_lowercase()).then_some(*shape)
    });
    let sum: usize = name.bytes().map(usize::from).sum();
    let shape = namesake.unwrap_or([Shape::Cross, Shape::Plus][sum % 2]);
    // These greys lie between those of the built-in methods with the same shapes.
    let tone = 80 + 10 * (sum % 3) as u8;
    Look { colour: [tone; 3], shape }
}

/// The look of a curve, which combines the methods of a group.
pub(super) fn of_group(group: Group, name: &str) -> Look {
    of_family(&match group {
        Group::StrongBlocks => Family::Block(SbpName::Sbp42, Form::Strong),
        Group::WeakBlocks => Family::Block(SbpName::Sbp42, Form::Weak),
        Group::Elements => Family::Elements(16),
        Group::March => Family::March(16),
        Group::Accuracy => Family::Accuracy,
        Group::Tolerance => Family::Tolerance,
        // The second of them, if there are several.
        Group::Peer(first) => {
            let first = PEERS[first];
            Family::Peer(kin(first.about().curve).nth(1).unwrap_or(first))
        }
        Group::Other => Family::Other(name.to_owned()),
    })
}

/// The look of a method of `stability`.
pub(super) fn of_method(method: &Method) -> Look {
    match method {
        Method::Block(sbp, form) => of_scheme(*sbp, *form),
        Method::Elements(nodes, form) => of_scheme(SbpName::Gll(*nodes as u8), *form),
        // The same scheme, but in windows.
        Method::Windows(sbp, form) => Look { shape: Shape::Nabla, ..of_scheme(*sbp, *form) },
        Method::Unregularised(sbp) => Look { shape: Shape::Cross, ..of_scheme(*sbp, Form::Strong) },
        Method::Peer(peer) => of_peer(*peer),
        Method::Accuracy => of_family(&Family::Accuracy),
        Method::Tolerance => of_family(&Family::Tolerance),
    }
}

/// How the curve of a method is drawn.
pub(super) fn mark(is_own: bool) -> Mark {
    if is_own { Mark::LineAndPoints } else { Mark::DashedAndOpenPoints }
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

    fn strangers() -> [Family; 3] {
        ["SciPy DOP853", "SciPy LSODA", "heyoka"].map(|name| Family::Other(name.to_owned()))
    }

    /// All methods of both studies, with their looks, and whether they are of this program.
    fn all() -> Vec<(String, Look, bool)> {
        let families = Family::all().into_iter().chain(strangers());
        let families = families.map(|family| (family.name(), of_family(&family), family.is_own()));
        let methods = Method::all().into_iter().map(|method| (method.label(), of_method(&method), method.is_own()));
        families.chain(methods).collect()
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
        let alike = |a: Look, b: Look| a.shape == b.shape && (grey(a.colour) - grey(b.colour)).abs() < 10.0;
        // The curves of speed against accuracy: those of this program are filled, others are open.
        for is_own in [true, false] {
            let groups: Vec<Look> = Family::all()
                .iter()
                .map(Family::group)
                .collect::<std::collections::BTreeSet<_>>()
                .into_iter()
                .filter(|group| group.is_own() == is_own)
                .map(|group| of_group(group, ""))
                .chain(strangers().iter().filter(|_| !is_own).map(of_family))
                .collect();
            for (k, &one) in groups.iter().enumerate() {
                assert!(groups[..k].iter().all(|&other| !alike(one, other)), "{one:?} among {groups:?}");
            }
        }
    }
}
