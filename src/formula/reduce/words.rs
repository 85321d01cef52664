//! Products written as few multiplications, those of them shared that occur in several.

use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap};

use super::super::graph::NodeId;
use super::atoms::{AtomId, Product};

/// Index of a letter in its [`Words`].
pub(super) type LetterId = usize;

/// What products are multiplied from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Letter {
    Atom(AtomId),
    /// Its reciprocal.
    Reciprocal(AtomId),
    /// The product of two letters.
    Pair(LetterId, LetterId),
    /// A high power of a letter.
    Power(LetterId, u32),
    /// A letter times the number of that node. Nothing in it varies.
    Scaled(NodeId, LetterId),
}

/// Powers up to this one are written as products of squares.
const SPELT: u32 = 16;

/// Products as words of letters.
pub(super) struct Words<'l> {
    pub(super) letters: Vec<Letter>,
    index: HashMap<Letter, LetterId>,
    /// When the value of an atom is known: 0 if it is the same in all evaluations, then later ones.
    level_of: &'l [u8],
    levels: Vec<u8>,
}

/// A number times letters.
#[derive(Debug, Clone)]
pub(super) struct Word {
    pub(super) coefficient: NodeId,
    /// By the time when they are known.
    pub(super) letters: Vec<LetterId>,
}

impl<'l> Words<'l> {
    pub(super) fn new(level_of: &'l [u8]) -> Self {
        Self { letters: Vec::new(), index: HashMap::new(), level_of, levels: Vec::new() }
    }

    pub(super) fn level(&self, letter: LetterId) -> u8 {
        self.levels[letter]
    }

    fn letter(&mut self, letter: Letter) -> LetterId {
        if let Some(&known) = self.index.get(&letter) {
            return known;
        }
        self.levels.push(match letter {
            Letter::Atom(atom) | Letter::Reciprocal(atom) => self.level_of[atom],
            Letter::Pair(one, other) => self.levels[one].max(self.levels[other]),
            Letter::Power(letter, _) | Letter::Scaled(_, letter) => self.levels[letter],
        });
        self.letters.push(letter);
        self.index.insert(letter, self.letters.len() - 1);
        self.letters.len() - 1
    }

    /// The word of a product. What does not vary is one letter with the number, unless that is `one` or its negative.
    pub(super) fn spell(&mut self, product: &Product, units: [NodeId; 2]) -> Word {
        let mut letters = Vec::new();
        for &(atom, exponent) in &product.powers {
            let letter = if exponent < 0 { Letter::Reciprocal(atom) } else { Letter::Atom(atom) };
            let (mut power, mut rest) = (self.letter(letter), exponent.unsigned_abs());
            if rest > SPELT {
                letters.push(self.letter(Letter::Power(power, rest)));
                continue;
            }
            // Squares are written as such: intervals of them are not negative.
            while rest > 0 {
                if rest % 2 == 1 {
                    letters.push(power);
                }
                rest /= 2;
                if rest > 0 {
                    power = self.letter(Letter::Pair(power, power));
                }
            }
        }
        letters.sort_by_key(|&letter| (self.levels[letter], letter));
        let fixed = letters.iter().take_while(|&&letter| self.levels[letter] == 0).count();
        let mut coefficient = product.coefficient;
        if fixed > 0 && fixed < letters.len() {
            let mut joined = letters[0];
            for &letter in &letters[1..fixed] {
                joined = self.letter(Letter::Pair(joined, letter));
            }
            if !units.contains(&coefficient) {
                joined = self.letter(Letter::Scaled(coefficient, joined));
                coefficient = units[0];
            }
            letters.splice(..fixed, [joined]);
        }
        Word { coefficient, letters }
    }

    /// Writes pairs of letters that occur in several words, or several times in one, as one letter: the most frequent
    /// first.
    pub(super) fn share(&mut self, words: &mut [Word]) {
        let mut pairs = Pairs::default();
        for (place, word) in words.iter().enumerate() {
            pairs.see(place, &word.letters);
        }
        while let Some([one, other]) = pairs.next(&self.levels) {
            let pair = self.letter(Letter::Pair(one, other));
            let mut places = std::mem::take(&mut pairs.places.get_mut(&[one, other]).expect("it was counted").1);
            places.sort_unstable();
            places.dedup();
            for place in places {
                let letters = &mut words[place].letters;
                pairs.forget(letters);
                while replace(letters, [one, other], pair) {}
                letters.sort_by_key(|&letter| (self.levels[letter], letter));
                pairs.see(place, letters);
            }
        }
    }
}

/// Replaces a pair of letters by one; whether there was one.
fn replace(letters: &mut Vec<LetterId>, [one, other]: [LetterId; 2], pair: LetterId) -> bool {
    let Some(first) = letters.iter().position(|&letter| letter == one) else { return false };
    let Some(second) = (0..letters.len()).find(|&place| place != first && letters[place] == other) else {
        return false;
    };
    letters[first] = pair;
    letters.remove(second);
    true
}

/// How often pairs of letters could be shared, and in which words.
#[derive(Default)]
struct Pairs {
    places: HashMap<[LetterId; 2], (usize, Vec<usize>)>,
    queue: BinaryHeap<(usize, Reverse<u8>, Reverse<[LetterId; 2]>)>,
    changed: Vec<[LetterId; 2]>,
}

impl Pairs {
    /// The pairs of a word, each as often as it can be taken out.
    fn of(letters: &[LetterId]) -> Vec<([LetterId; 2], usize)> {
        let mut counts: Vec<(LetterId, usize)> = Vec::new();
        for &letter in letters {
            match counts.iter_mut().find(|(other, _)| *other == letter) {
                Some((_, count)) => *count += 1,
                None => counts.push((letter, 1)),
            }
        }
        let mut pairs = Vec::new();
        for (place, &(one, count)) in counts.iter().enumerate() {
            if count > 1 {
                pairs.push(([one, one], count / 2));
            }
            for &(other, others) in &counts[place + 1..] {
                pairs.push(([one.min(other), one.max(other)], count.min(others)));
            }
        }
        pairs
    }

    fn see(&mut self, place: usize, letters: &[LetterId]) {
        for (pair, count) in Self::of(letters) {
            let entry = self.places.entry(pair).or_default();
            entry.0 += count;
            entry.1.push(place);
            self.changed.push(pair);
        }
    }

    fn forget(&mut self, letters: &[LetterId]) {
        for (pair, count) in Self::of(letters) {
            self.places.get_mut(&pair).expect("it was counted").0 -= count;
            self.changed.push(pair);
        }
    }

    /// The most frequent pair that occurs twice at least; of equals the one that is known first.
    fn next(&mut self, levels: &[u8]) -> Option<[LetterId; 2]> {
        for pair in self.changed.drain(..) {
            let count = self.places[&pair].0;
            if count > 1 {
                self.queue.push((count, Reverse(levels[pair[0]].max(levels[pair[1]])), Reverse(pair)));
            }
        }
        while let Some((count, _, Reverse(pair))) = self.queue.pop() {
            if self.places[&pair].0 == count {
                return Some(pair);
            }
        }
        None
    }
}
