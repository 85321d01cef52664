//! Random scenes and their judges. They are those of the benches `promises` and `verdict`, which count over thousands
//! of scenes what the tests here look at over some dozens.

#[path = "../../benches/verdict/draw.rs"]
pub(crate) mod draw;
#[path = "../../benches/verdict/judged.rs"]
pub(crate) mod judged;
#[path = "../../benches/promises/outcome.rs"]
pub(crate) mod outcome;
#[path = "../../benches/promises/random.rs"]
#[allow(dead_code, reason = "tests have no arguments")]
pub(crate) mod random;
#[path = "../../benches/promises/rough.rs"]
pub(crate) mod rough;
#[path = "../../benches/promises/scenes.rs"]
pub(crate) mod scenes;
#[path = "../../benches/verdict/several.rs"]
pub(crate) mod several;
#[path = "../../benches/verdict/tally.rs"]
#[allow(dead_code, reason = "only the counts are looked at here")]
pub(crate) mod tally;
#[path = "../../benches/promises/truth.rs"]
pub(crate) mod truth;
