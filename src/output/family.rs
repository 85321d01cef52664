//! Tables and summaries of families, and of searches from several starts.

use std::io::Write;

use csv::Writer;
use serde_json::{Value, json};

use super::find::decimal;
use super::json::{json, merged, present};
use crate::case::{Case, Find};
use crate::study::find::{Ended, Family, FromStart, Member, norm};
use crate::study::many::ManyRuns;

/// The unknowns of a family, the number that is followed first.
fn keys(wanted: &Find) -> impl Iterator<Item = &String> {
    let last = wanted.unknowns.len() - 1;
    let keys = wanted.unknowns.iter().map(|unknown| &unknown.key);
    keys.clone().skip(last).chain(keys.take(last))
}

/// The modulus of the largest multiplier, and the stability index that is furthest from 0, if there are such: but for
/// the one nearest to 1, which the direction along the motion has.
fn of_multipliers(member: &Member) -> [Option<f64>; 2] {
    let Some(multipliers) = &member.multipliers else { return [None; 2] };
    let largest = multipliers.values.first().map(|value| f64::hypot(value.re, value.im));
    let mut indices: Vec<f64> = multipliers.indices.iter().flatten().map(|index| index.re).collect();
    indices.sort_by(|a, b| (a - 1.0).abs().total_cmp(&(b - 1.0).abs()));
    [largest, indices.into_iter().skip(1).max_by(|a, b| a.abs().total_cmp(&b.abs()))]
}

/// Writes `family.csv`: a row for each member with the number that is followed, the unknowns and by how much these may
/// be off, the residual, the rate of the followed number, 1 at a fold, and the multipliers of what returns.
///
/// # Errors
/// If `out` cannot be written.
pub fn write_members(out: impl Write, wanted: &Find, family: &Family) -> csv::Result<()> {
    let mut writer = Writer::from_writer(out);
    let errors = keys(wanted).map(|key| format!("error_{key}"));
    let head = ["member".to_owned()].into_iter().chain(keys(wanted).cloned()).chain(errors);
    let last = ["residual_norm", "slope", "fold", "largest_multiplier", "stability_index"].map(str::to_owned);
    writer.write_record(head.chain(last))?;
    for (place, member) in family.members.iter().enumerate() {
        let n = member.values.len() - 1;
        let numbers = member.values[n..].iter().chain(&member.values[..n]);
        let numbers = numbers.chain(&member.errors[n..]).chain(&member.errors[..n]);
        let numbers = numbers.chain([&member.residual, &member.slope]).map(|number| decimal(*number));
        let fold = [u8::from(member.is_fold).to_string()];
        let of = of_multipliers(member).map(|number| number.map_or_else(String::new, decimal));
        writer.write_record([place.to_string()].into_iter().chain(numbers).chain(fold).chain(of))?;
    }
    Ok(writer.flush()?)
}

/// The summary of a family.
pub fn family_summary(case: &Case, wanted: &Find, family: &Family) -> String {
    let (ended, reason) = match &family.ended {
        Ended::AtEnd => ("at-end", None),
        Ended::Back => ("back", None),
        Ended::Stopped(reason) => ("stopped", Some(reason)),
    };
    let by_key = |member: &Member| -> Value {
        let all = wanted.unknowns.iter().zip(&member.values);
        all.map(|(unknown, value)| (unknown.key.clone(), Value::from(*value))).collect()
    };
    let folds = family.members.iter().filter(|member| member.is_fold).map(by_key);
    let of_family = json!({
        "followed": wanted.unknowns.last().map(|unknown| &unknown.key),
        "members": family.members.len(),
        "ended": ended,
        "reason": reason,
        "folds": folds.collect::<Vec<_>>(),
        "first": family.members.first().map(by_key),
        "last": family.members.last().map(by_key),
    });
    json(&merged([
        json!({"status": "followed", "version": env!("CARGO_PKG_VERSION")}),
        present(json!({"title": case.title.as_deref()})),
        json!({"find": present(of_family)}),
    ]))
}

/// Writes `starts.csv`: a row for each search with the values that it begins with, what came of it, the number of the
/// solution, the unknowns and by how much they may be off, and the residual.
///
/// # Errors
/// If `out` cannot be written.
pub fn write_starts(
    out: impl Write,
    wanted: &Find,
    starts: &ManyRuns,
    searches: &[FromStart],
    numbers: &[Option<usize>],
) -> csv::Result<()> {
    let mut writer = Writer::from_writer(out);
    let names = || wanted.unknowns.iter().map(|unknown| &unknown.key);
    let varied = starts.axes.iter().map(|axis| format!("start_{}", axis.key));
    let head = ["row".to_owned()].into_iter().chain(varied).chain(["status", "solution"].map(str::to_owned));
    let head = head.chain(names().cloned()).chain(names().map(|key| format!("error_{key}")));
    writer.write_record(head.chain(["residual_norm", "message"].map(str::to_owned)))?;
    for (run, (search, number)) in searches.iter().zip(numbers).enumerate() {
        let begin = [(run + 1).to_string()].into_iter().chain(starts.values(run).into_iter().map(str::to_owned));
        let number = number.map_or_else(String::new, |number| number.to_string());
        let (status, message) = match search {
            FromStart::Found(_) => ("found", String::new()),
            FromStart::NotFound(none) => ("not-found", none.message.clone()),
            FromStart::Invalid(error) => ("invalid-case", error.to_string()),
        };
        let numbers: Vec<String> = match search.found() {
            Some(found) => {
                let residuals: Vec<f64> = found.residuals.iter().map(|(_, residual, _)| *residual).collect();
                let all = found.values.iter().chain(&found.errors).copied().chain([norm(&residuals)]);
                all.map(decimal).collect()
            }
            None => vec![String::new(); 2 * wanted.unknowns.len() + 1],
        };
        writer.write_record(begin.chain([status.to_owned(), number]).chain(numbers).chain([message]))?;
    }
    Ok(writer.flush()?)
}

/// The summary of searches from several starts.
pub fn starts_summary(wanted: &Find, title: Option<&str>, searches: &[FromStart], numbers: &[Option<usize>]) -> String {
    let different = numbers.iter().flatten().max().copied().unwrap_or(0);
    let solution = |number: usize| -> Value {
        let first = searches.iter().zip(numbers).find(|(_, own)| **own == Some(number));
        let found = first.and_then(|(search, _)| search.found());
        let by_key = |values: &[f64]| -> Value {
            wanted
                .unknowns
                .iter()
                .map(|unknown| unknown.key.clone())
                .zip(values.iter().map(|&v| Value::from(v)))
                .collect()
        };
        let times = numbers.iter().filter(|own| **own == Some(number)).count();
        json!({
            "unknowns": found.map(|found| by_key(&found.values)),
            "errors": found.map(|found| by_key(&found.errors)),
            "times": times,
        })
    };
    let of_searches = json!({
        "searches": searches.len(),
        "found": numbers.iter().flatten().count(),
        "solutions": (1..=different).map(solution).collect::<Vec<_>>(),
    });
    let status = if different > 0 { "found" } else { "not-found" };
    json(&merged([
        json!({"status": status, "version": env!("CARGO_PKG_VERSION")}),
        present(json!({"title": title})),
        json!({"find": of_searches}),
    ]))
}
