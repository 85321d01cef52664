//! The front: the settings that no other one beats. And by how much the fastest method leads.

use super::Row;

/// The rows that no other row beats in both error and `cost`, from small errors to large ones.
pub fn front<'a>(rows: impl IntoIterator<Item = &'a Row>, cost: impl Fn(&Row) -> f64) -> Vec<&'a Row> {
    let mut ranked: Vec<(f64, &Row)> = rows.into_iter().filter_map(|row| Some((row.rank()?, row))).collect();
    ranked.sort_by(|a, b| a.0.total_cmp(&b.0).then(cost(a.1).total_cmp(&cost(b.1))));
    // After the first one, each row that is kept is cheaper than all more accurate ones.
    let mut cheapest = f64::INFINITY;
    let is_cheaper = |row: &&Row| {
        let before = cheapest;
        cheapest = before.min(cost(row));
        cost(row) < before
    };
    ranked.into_iter().map(|(_, row)| row).filter(is_cheaper).collect()
}

/// Compares this program with the others, at one error.
#[derive(Debug, Clone, PartialEq)]
pub struct Ratio<'r> {
    /// γ_f − γ_i.
    pub gamma_f: f64,
    /// The error of every coordinate that is allowed.
    pub error: f64,
    /// The fastest method of this program, its library included.
    pub own: Option<&'r Row>,
    /// The fastest certified method of this program.
    pub certified: Option<&'r Row>,
    /// The fastest of the other methods.
    pub other: Option<&'r Row>,
}

impl Ratio<'_> {
    /// Seconds of the others over seconds of this program, which leads if that is above 1.
    pub fn lead(&self) -> Option<f64> {
        Some(self.other?.seconds_min / self.own?.seconds_min)
    }

    /// The same ratio for certified solutions only.
    pub fn certified_lead(&self) -> Option<f64> {
        Some(self.other?.seconds_min / self.certified?.seconds_min)
    }
}

/// The comparison at the errors 1e-3, 1e-4, … 1e-12, for every length in `rows`.
pub fn ratios(rows: &[Row]) -> Vec<Ratio<'_>> {
    let mut lengths: Vec<f64> = rows.iter().map(|row| row.gamma_f).collect();
    lengths.sort_by(f64::total_cmp);
    lengths.dedup();
    let of = |gamma_f: f64, decade: i32| {
        let error = 10.0_f64.powi(-decade);
        let fastest = |wanted: &dyn Fn(&Row) -> bool| {
            let enough = |row: &&Row| row.gamma_f == gamma_f && row.rank().is_some_and(|rank| rank <= error);
            let rows = rows.iter().filter(enough).filter(|row| wanted(row));
            rows.min_by(|a, b| a.seconds_min.total_cmp(&b.seconds_min))
        };
        Ratio {
            gamma_f,
            error,
            own: fastest(&|row| row.method.is_own()),
            certified: fastest(&|row| row.method.is_certified()),
            other: fastest(&|row| !row.method.is_own()),
        }
    };
    lengths.into_iter().flat_map(|length| (3..=12).map(move |decade| of(length, decade))).collect()
}

#[cfg(test)]
mod tests {
    use super::super::{Method, RowErrors, RowStatus};
    use super::*;
    use crate::methods::{Composition, Rk4};

    #[test]
    fn the_front_has_what_nothing_beats() {
        let row = |method: Method, error: f64, seconds: f64| Row {
            method,
            setting: String::new(),
            gamma_f: 1.0,
            errors: Some(RowErrors { q: vec![error, 0.5 * error], delta_k: 0.0 }),
            seconds_min: seconds,
            seconds_median: seconds,
            evaluations: 0,
            points: 0,
            status: if error < 1e-10 { RowStatus::Inaccurate } else { RowStatus::Converged },
        };
        let rows = [
            row(Method::Peer(&Rk4), 1e-4, 1.0),
            row(Method::Peer(&Rk4), 1e-8, 10.0),
            row(Method::March(8), 1e-8, 8.0),
            row(Method::March(8), 1e-6, 9.0),
            row(Method::Elements(8), 1e-8, 16.0),
            row(Method::Peer(&Composition::VERLET), 1e-12, 0.1),
            row(Method::Peer(&Composition::VERLET), 1e-3, 2.0),
        ];
        let found: Vec<f64> = front(&rows, |row| row.seconds_min).iter().map(|row| row.seconds_min).collect();
        assert_eq!(found, [8.0, 1.0]);
        let table = ratios(&rows);
        assert_eq!((table.len(), table[0].error), (10, 1e-3));
        assert_eq!((table[0].lead(), table[0].certified_lead()), (Some(1.0 / 8.0), Some(1.0 / 16.0)));
        assert_eq!(table[5].lead(), Some(10.0 / 8.0));
        assert!(table[6].own.is_none() && table[6].other.is_none() && table[6].lead().is_none());
    }
}
