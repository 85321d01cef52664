//! Points of a world-line, one after the other in one list.

/// A point of the world-line of a scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct State<'s> {
    /// q^a of all coordinates.
    pub q: &'s [f64],
    /// p_a of all coordinates.
    pub p: &'s [f64],
}

/// Points of a world-line.
#[derive(Debug, Clone, PartialEq)]
pub struct States {
    dimension: usize,
    /// q and then p of each.
    values: Vec<f64>,
}

impl States {
    /// None so far, of so many coordinates, with room for `capacity`.
    pub(crate) fn new(dimension: usize, capacity: usize) -> Self {
        Self { dimension, values: Vec::with_capacity(2 * dimension * capacity) }
    }

    pub(crate) fn push(&mut self, q: &[f64], p: &[f64]) {
        self.values.extend_from_slice(q);
        self.values.extend_from_slice(p);
    }

    /// The last one so many times more.
    pub(super) fn repeat_last(&mut self, count: usize) {
        let from = self.values.len() - 2 * self.dimension;
        (0..count).for_each(|_| self.values.extend_from_within(from..from + 2 * self.dimension));
    }

    pub(super) fn clear(&mut self) {
        self.values.clear();
    }

    /// Their number.
    pub fn len(&self) -> usize {
        self.iter().len()
    }

    /// Returns true if there are none.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// One after the other.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = State<'_>> {
        self.values.chunks_exact(2 * self.dimension).map(|state| {
            let (q, p) = state.split_at(self.dimension);
            State { q, p }
        })
    }

    /// The one at this place.
    ///
    /// # Panics
    /// If there are fewer.
    pub fn at(&self, place: usize) -> State<'_> {
        self.iter().nth(place).expect("there are more points")
    }

    /// The last one.
    pub fn last(&self) -> Option<State<'_>> {
        self.iter().last()
    }
}
