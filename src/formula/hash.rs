//! Tables whose keys are a few small integers.

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

/// A table that finds a key in a few instructions. Nobody makes up formulas whose nodes collide.
pub(super) type QuickMap<K, V> = HashMap<K, V, BuildHasherDefault<QuickHasher>>;

/// Multiplies integers into one number.
#[derive(Default)]
pub(super) struct QuickHasher(u64);

impl Hasher for QuickHasher {
    fn finish(&self) -> u64 {
        // Tables take the lowest bits for the place, and of a product the highest bits depend on most.
        self.0.rotate_left(26)
    }

    fn write(&mut self, bytes: &[u8]) {
        bytes.iter().for_each(|&byte| self.write_usize(byte.into()));
    }

    fn write_usize(&mut self, number: usize) {
        // 2^64 divided by the golden ratio, an odd number whose bits have no pattern.
        self.0 = (self.0.rotate_left(5) ^ number as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    }

    fn write_isize(&mut self, number: isize) {
        self.write_usize(number.cast_unsigned());
    }

    fn write_i32(&mut self, number: i32) {
        self.write_usize(number.cast_unsigned() as usize);
    }
}
