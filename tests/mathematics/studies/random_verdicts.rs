//! No result that is trusted is off by more than ten times its estimate, and few good ones are called doubtful. (`cargo
//! bench --bench verdict` does the same with as many random scenes as one likes.)

use rayon::prelude::*;

use crate::random_scenes::draw::Drawn;
use crate::random_scenes::judged::Judged;
use crate::random_scenes::random::Random;
use crate::random_scenes::tally::Tally;

const SCENES: usize = 60;

#[test]
fn a_trusted_result_is_within_ten_estimates_and_few_good_ones_are_doubtful() {
    let mut random = Random(3);
    let drawn: Vec<Drawn> = (0..SCENES).map(|_| Drawn::new(&mut random)).collect();
    let judged: Vec<Judged> = drawn.par_iter().map(|drawn| Judged::of(&drawn.case())).collect();
    let mut tally = Tally::default();
    for (drawn, judged) in drawn.iter().zip(&judged) {
        assert!(!tally.count(judged), "{} {}: {drawn}", judged.verdict.grade.as_str(), drawn.scheme);
    }
    let [trusted, doubtful] = tally.counts.map(|counts| counts.iter().sum::<usize>());
    // All grades occur, so that the test can fail.
    assert!(trusted > SCENES / 3 && doubtful > SCENES / 8 && tally.refused > 0, "{}", tally.table());
    assert!(tally.too_careful() < 0.15, "{}", tally.table());
}
