//! The variables that nodes of a graph depend on.

use std::collections::HashMap;

use foldhash::fast::FixedState;

/// A set of variables of a node has a bit for each of the first, and the last one for all others together.
const FIRST: usize = 63;

/// The bit of those others.
pub(super) const LAST: u64 = 1 << FIRST;

/// The bit of a variable in a set of them, in which all from the 64th on share the last one.
pub(super) fn bit(variable: usize) -> u64 {
    1 << variable.min(FIRST)
}

/// The sets of the variables from the 64th on in all nodes of a graph. Each is kept once, since nodes share them.
#[derive(Debug, Clone)]
pub(super) struct OtherVariables {
    /// The set of every node, by its place: the first is empty.
    of_nodes: Vec<u32>,
    sets: Vec<Box<[u64]>>,
    places: HashMap<Box<[u64]>, u32, FixedState>,
    unions: HashMap<(u32, u32), u32, FixedState>,
}

impl Default for OtherVariables {
    fn default() -> Self {
        Self {
            of_nodes: Vec::new(),
            sets: vec![Box::default()],
            places: HashMap::default(),
            unions: HashMap::default(),
        }
    }
}

impl OtherVariables {
    /// Adds the node that a variable is.
    pub(super) fn push_variable(&mut self, variable: usize) {
        let set = variable.checked_sub(FIRST).map_or(0, |other| {
            let mut set = vec![0; other / 64 + 1];
            set[other / 64] = 1 << (other % 64);
            self.place(set)
        });
        self.of_nodes.push(set);
    }

    /// Adds a node with these operands.
    pub(super) fn push(&mut self, operands: impl Iterator<Item = usize>) {
        let mut all = 0;
        for operand in operands {
            all = self.union(all, self.of_nodes[operand]);
        }
        self.of_nodes.push(all);
    }

    /// True if a node depends on a variable from the 64th on.
    pub(super) fn contains(&self, node: usize, variable: usize) -> bool {
        let (set, other) = (&self.sets[self.of_nodes[node] as usize], variable - FIRST);
        set.get(other / 64).is_some_and(|word| word >> (other % 64) & 1 == 1)
    }

    /// True if two nodes depend on one variable from the 64th on.
    pub(super) fn share(&self, one: usize, other: usize) -> bool {
        let [one, other] = [one, other].map(|node| &self.sets[self.of_nodes[node] as usize]);
        one.iter().zip(other).any(|(one, other)| one & other != 0)
    }

    fn union(&mut self, one: u32, other: u32) -> u32 {
        if one == other || other == 0 {
            return one;
        }
        if one == 0 {
            return other;
        }
        if let Some(&known) = self.unions.get(&(one, other)) {
            return known;
        }
        let [shorter, longer] = [one, other].map(|set| &self.sets[set as usize]);
        let (shorter, longer) = if shorter.len() > longer.len() { (longer, shorter) } else { (shorter, longer) };
        let mut all = longer.to_vec();
        all.iter_mut().zip(shorter).for_each(|(all, more)| *all |= more);
        let all = self.place(all);
        self.unions.insert((one, other), all);
        all
    }

    fn place(&mut self, set: Vec<u64>) -> u32 {
        let Self { sets, places, .. } = self;
        *places.entry(set.into()).or_insert_with_key(|set| {
            sets.push(set.clone());
            (sets.len() - 1) as u32
        })
    }
}
