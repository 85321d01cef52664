//! Random scenes and their judges. They are those of the bench `verdict`, which counts over thousands of scenes what
//! the tests here look at over some dozens.

#[path = "../../benches/verdict/draw.rs"]
pub(crate) mod draw;
#[path = "../../benches/verdict/judged.rs"]
pub(crate) mod judged;
#[path = "../../benches/verdict/random.rs"]
#[allow(dead_code, reason = "tests have no arguments")]
pub(crate) mod random;
#[path = "../../benches/verdict/several.rs"]
pub(crate) mod several;
#[path = "../../benches/verdict/tally.rs"]
#[allow(dead_code, reason = "only the counts are looked at here")]
pub(crate) mod tally;
#[path = "../../benches/verdict/truth.rs"]
pub(crate) mod truth;
