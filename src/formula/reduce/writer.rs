//! From normal forms back to a graph.

use super::super::graph::{Graph, Node, NodeId};
use super::Level;
use super::atoms::{Atom, Forms, Product};
use super::words::{Letter, LetterId, Word, Words};
use crate::number::Real;

/// Writes words as nodes of a graph.
pub(super) struct Writer<'g, 'w, S> {
    graph: &'g mut Graph<S>,
    words: &'w Words<'w>,
    /// 1 and −1.
    units: [NodeId; 2],
    /// The nodes of letters that were written.
    known: Vec<Option<NodeId>>,
    /// In how many words and pairs a letter is.
    uses: Vec<usize>,
    /// The nodes of atoms.
    atoms: Vec<NodeId>,
}

impl<'g, S: Real> Writer<'g, '_, S> {
    /// The nodes of `products`.
    pub(super) fn write(forms: Forms<'g, S>, products: &[Product], level: &impl Fn(usize) -> Level) -> Vec<NodeId> {
        let Forms { graph, atoms, .. } = forms;
        let units = [graph.whole(1), graph.whole(-1)];
        let is_needed = needed(&atoms, products);
        let levels = levels(graph, &atoms, level);
        let mut words = Words::new(&levels);
        // The words of all atoms in order, then those of the products.
        let of_atoms =
            atoms.iter().zip(&is_needed).filter(|&(_, &is_needed)| is_needed).flat_map(|(atom, _)| atom.parts());
        let mut spelt: Vec<Word> = of_atoms.chain(products).map(|product| words.spell(product, units)).collect();
        words.share(&mut spelt);
        let mut uses = vec![0; words.letters.len()];
        spelt.iter().flat_map(|word| &word.letters).for_each(|&letter| uses[letter] += 1);
        for letter in &words.letters {
            match *letter {
                Letter::Pair(one, other) => [one, other].map(|letter| uses[letter] += 1),
                Letter::Power(letter, _) | Letter::Scaled(_, letter) => {
                    [letter, letter].map(|letter| uses[letter] += 1)
                }
                Letter::Atom(_) | Letter::Reciprocal(_) => continue,
            };
        }
        let known = vec![None; words.letters.len()];
        let mut writer = Writer { graph, words: &words, units, known, uses, atoms: vec![NodeId::MAX; atoms.len()] };
        let mut spelt = spelt.into_iter();
        for (id, atom) in atoms.iter().enumerate().filter(|&(id, _)| is_needed[id]) {
            let parts: Vec<Word> = spelt.by_ref().take(atom.parts().len()).collect();
            writer.atoms[id] = writer.atom(atom, &parts);
        }
        spelt.map(|word| writer.word(&word)).collect()
    }

    fn atom(&mut self, atom: &Atom, parts: &[Word]) -> NodeId {
        match *atom {
            Atom::Variable(node) => node,
            Atom::Call(function, _) => {
                let argument = self.word(&parts[0]);
                self.graph.call(function, argument)
            }
            Atom::Power(_) => {
                let [base, exponent] = [0, 1].map(|part| self.word(&parts[part]));
                self.graph.power(base, exponent)
            }
            Atom::Sum(_) => self.sum(parts),
        }
    }

    /// The terms one after the other; one that is subtracted does not come first, if another one can.
    fn sum(&mut self, terms: &[Word]) -> NodeId {
        let is_negative = |writer: &Self, word: &Word| {
            writer.graph.as_constant(word.coefficient).is_some_and(|number| number < S::ZERO)
        };
        let first = terms.iter().position(|term| !is_negative(self, term)).unwrap_or(0);
        let mut sum = self.word(&terms[first]);
        for (_, term) in terms.iter().enumerate().filter(|&(place, _)| place != first) {
            if is_negative(self, term) {
                let number = self.graph.as_constant(term.coefficient).expect("a coefficient is a number");
                let positive = Word { coefficient: self.graph.constant(-number), letters: term.letters.clone() };
                let term = self.word(&positive);
                sum = self.graph.subtract(sum, term);
            } else {
                let term = self.word(term);
                sum = self.graph.add(sum, term);
            }
        }
        sum
    }

    fn word(&mut self, word: &Word) -> NodeId {
        // A reciprocal that varies and that nothing else needs is a division.
        let divisor = word.letters.iter().copied().find_map(|letter| match self.words.letters[letter] {
            Letter::Reciprocal(atom) if self.uses[letter] == 1 && self.words.level(letter) > 0 => Some((letter, atom)),
            _ => None,
        });
        let letters = word.letters.iter().copied();
        let letters: Vec<LetterId> =
            letters.filter(|&letter| divisor.is_none_or(|(other, _)| other != letter)).collect();
        let mut product = if self.units.contains(&word.coefficient) { None } else { Some(word.coefficient) };
        for letter in letters {
            let node = self.letter(letter);
            product = Some(match product {
                Some(product) => self.graph.multiply(product, node),
                None => node,
            });
        }
        let is_negative = word.coefficient == self.units[1];
        match (product, divisor) {
            (None, None) => word.coefficient,
            (None, Some((_, atom))) => {
                let divisor = self.atoms[atom];
                self.graph.divide(word.coefficient, divisor)
            }
            (Some(product), divisor) => {
                let product = match divisor {
                    Some((_, atom)) => {
                        let divisor = self.atoms[atom];
                        self.graph.divide(product, divisor)
                    }
                    None => product,
                };
                if is_negative { self.graph.negate(product) } else { product }
            }
        }
    }

    fn letter(&mut self, letter: LetterId) -> NodeId {
        if let Some(known) = self.known[letter] {
            return known;
        }
        let node = match self.words.letters[letter] {
            Letter::Atom(atom) => self.atoms[atom],
            Letter::Reciprocal(atom) => {
                let (one, divisor) = (self.units[0], self.atoms[atom]);
                self.graph.divide(one, divisor)
            }
            Letter::Pair(one, other) => {
                let [one, other] = [one, other].map(|letter| self.letter(letter));
                self.graph.multiply(one, other)
            }
            Letter::Power(letter, exponent) => {
                let base = self.letter(letter);
                self.graph.products(base, exponent as i32)
            }
            Letter::Scaled(number, letter) => {
                let node = self.letter(letter);
                self.graph.multiply(number, node)
            }
        };
        self.known[letter] = Some(node);
        node
    }
}

/// Which atoms the products need.
fn needed(atoms: &[Atom], products: &[Product]) -> Vec<bool> {
    let mut is_needed = vec![false; atoms.len()];
    let need = |product: &Product, is_needed: &mut [bool]| {
        product.powers.iter().for_each(|&(atom, _)| is_needed[atom] = true);
    };
    products.iter().for_each(|product| need(product, &mut is_needed));
    for id in (0..atoms.len()).rev() {
        if is_needed[id] {
            atoms[id].parts().iter().for_each(|part| need(part, &mut is_needed));
        }
    }
    is_needed
}

/// When atoms become known: with the last of their variables.
fn levels<S: Real>(graph: &Graph<S>, atoms: &[Atom], level: &impl Fn(usize) -> Level) -> Vec<Level> {
    let mut levels: Vec<Level> = Vec::with_capacity(atoms.len());
    for atom in atoms {
        levels.push(match *atom {
            Atom::Variable(node) => match graph.nodes[node] {
                Node::Variable(index) => level(index),
                _ => unreachable!("a variable's node"),
            },
            _ => {
                let inner = atom.parts().iter().flat_map(|part| &part.powers).map(|&(atom, _)| levels[atom]);
                inner.max().unwrap_or(0)
            }
        });
    }
    levels
}
