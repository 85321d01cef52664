//! The confusion table: what the program says of its results, against what is true of them.

use geodesic_ivp::diagnostics::verdict::Grade;

use super::judged::{Found, Judged};

/// A result may be off by so many times its estimate.
pub(crate) const MOST: f64 = 10.0;

/// Numbers of results.
#[derive(Default)]
pub(crate) struct Tally {
    /// Trusted and doubtful ones, with an error of at most the estimate, at most [`MOST`] times that, and more; those
    /// without an estimate; those without a reference.
    pub(crate) counts: [[usize; 5]; 2],
    pub(crate) refused: usize,
    /// Results whose estimate is right and small: all, and those that are called doubtful.
    pub(crate) good: [usize; 2],
}

impl Tally {
    /// Counts a result. Returns whether it is one that must not be: trusted, and off by more than it may be.
    pub(crate) fn count(&mut self, judged: &Judged) -> bool {
        let Some(found) = &judged.found else {
            self.refused += 1;
            return false;
        };
        let is_doubtful = judged.verdict.grade == Grade::Doubtful;
        let column = match *found {
            Found::NoReference => 4,
            Found::Error { .. } if judged.verdict.error.is_none() => 3,
            Found::Error { ratio, .. } if ratio <= 1.0 => 0,
            Found::Error { ratio, .. } if ratio <= MOST => 1,
            Found::Error { .. } => 2,
        };
        self.counts[usize::from(is_doubtful)][column] += 1;
        if let Found::Error { ratio, is_small: true } = *found
            && ratio <= 1.0
        {
            self.good[0] += 1;
            self.good[1] += usize::from(is_doubtful);
        }
        column == 2 && !is_doubtful
    }

    /// The share of good results that are called doubtful.
    pub(crate) fn too_careful(&self) -> f64 {
        self.good[1] as f64 / self.good[0].max(1) as f64
    }

    /// The table as Markdown.
    pub(crate) fn table(&self) -> String {
        let mut text = "| verdict | error ≤ estimate | ≤ 10 estimates | more | no estimate | no reference |\n\
                        |---|---|---|---|---|---|\n"
            .to_owned();
        for (name, counts) in ["trusted", "doubtful"].iter().zip(&self.counts) {
            let cells: Vec<String> = counts.iter().map(usize::to_string).collect();
            text += &format!("| {name} | {} |\n", cells.join(" | "));
        }
        text + &format!("| refused: {} | | | | | |\n", self.refused)
    }
}
