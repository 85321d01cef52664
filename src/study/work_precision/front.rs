//! The front: the settings that no other one beats. And by how much the fastest method leads.

use super::Row;

/// The rows that no other row beats in both error and `cost`, from small errors to large ones.
pub fn front<'a>(rows: impl IntoIterator<Item = &'a Row>, cost: impl Fn(&Row) -> f64) -> Vec<&'a Row> {
    let mut ranked: Vec<(f64, f64, &Row)> =
        rows.into_iter().filter_map(|row| Some((row.rank()?, cost(row), row))).collect();
    ranked.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let mut cheapest = f64::INFINITY;
    ranked.retain(|&(_, cost, _)| {
        let kept = cost < cheapest;
        cheapest = cheapest.min(cost);
        kept
    });
    // The rows were sorted by error, and then by cost. After the first one, each row that is kept is cheaper than all
    // more accurate ones.
    ranked.into_iter().map(|(_, _, row)| row).collect()
}

/// The fastest row that is accurate enough.
#[derive(Debug, Clone, PartialEq)]
pub struct Leader {
    /// Its method.
    pub method: String,
    /// Its setting.
    pub setting: String,
    /// Its least seconds.
    pub seconds: f64,
}

/// Compares this program with the others, at one error.
#[derive(Debug, Clone, PartialEq)]
pub struct Ratio {
    /// γ_f − γ_i.
    pub gamma_f: f64,
    /// The error of every coordinate that is allowed.
    pub error: f64,
    /// The fastest method of this program, its library included.
    pub own: Option<Leader>,
    /// The fastest certified method of this program.
    pub certified: Option<Leader>,
    /// The fastest of the other methods.
    pub other: Option<Leader>,
}

impl Ratio {
    /// Seconds of the others over seconds of this program, which leads if that is above 1.
    pub fn lead(&self) -> Option<f64> {
        Some(self.other.as_ref()?.seconds / self.own.as_ref()?.seconds)
    }

    /// The same ratio for certified solutions only.
    pub fn certified_lead(&self) -> Option<f64> {
        Some(self.other.as_ref()?.seconds / self.certified.as_ref()?.seconds)
    }
}

/// The comparison at the errors 1e-3, 1e-4, … 1e-12, for every length in `rows`.
pub fn ratios(rows: &[Row]) -> Vec<Ratio> {
    let mut lengths: Vec<f64> = rows.iter().map(|row| row.gamma_f).collect();
    lengths.sort_by(f64::total_cmp);
    lengths.dedup();
    let of = |gamma_f: f64, decade: i32| {
        let error = 10.0_f64.powi(-decade);
        let fastest = |wanted: &dyn Fn(&Row) -> bool| {
            let enough = |row: &&Row| row.gamma_f == gamma_f && row.rank().is_some_and(|rank| rank <= error);
            let rows = rows.iter().filter(enough).filter(|row| wanted(row));
            let best = rows.min_by(|a, b| a.seconds_min.total_cmp(&b.seconds_min))?;
            Some(Leader { method: best.method.label(), setting: best.setting.clone(), seconds: best.seconds_min })
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

    fn row(method: Method, error: f64, seconds: f64, status: RowStatus) -> Row {
        Row {
            method,
            setting: String::new(),
            gamma_f: 1.0,
            errors: Some(RowErrors { q: vec![error, 0.5 * error], delta_k: 0.0 }),
            seconds_min: seconds,
            seconds_median: seconds,
            evaluations: 0,
            points: 0,
            status,
        }
    }

    #[test]
    fn the_front_has_what_nothing_beats() {
        let good = RowStatus::Converged;
        let rows = [
            row(Method::Peer(&Rk4), 1e-4, 1.0, good),
            row(Method::Peer(&Rk4), 1e-8, 10.0, good),
            row(Method::March(8), 1e-8, 8.0, good),
            row(Method::March(8), 1e-6, 9.0, good),
            row(Method::Peer(&Composition::VERLET), 1e-12, 0.1, RowStatus::Inaccurate),
            row(Method::Peer(&Composition::VERLET), 1e-3, 2.0, good),
        ];
        let found: Vec<f64> = front(&rows, |row| row.seconds_min).iter().map(|row| row.seconds_min).collect();
        assert_eq!(found, [8.0, 1.0]);
        let table = ratios(&rows);
        assert_eq!(table.len(), 10);
        assert_eq!(table[0].error, 1e-3);
        assert_eq!((table[0].lead(), table[0].certified_lead()), (Some(1.0 / 8.0), None));
        assert_eq!(table[5].lead(), Some(10.0 / 8.0));
        assert!(table[6].own.is_none() && table[6].other.is_none() && table[6].lead().is_none());
    }
}
