//! `find CASE --follow KEY=FROM:TO`: the family of what is found, in one more number of the case.

use std::process::ExitCode;
use std::sync::Arc;
use std::time::Duration;

use geodesic_ivp::Case;
use geodesic_ivp::case::Find;
use geodesic_ivp::output::{CASE, OutputSet, SUMMARY, family_summary, not_found_summary, pictures, write_members};
use geodesic_ivp::study::find::{Ended, Family, Member, NotFound, follow};

use super::find_args::{FindArgs, Followed, checked, with_error};
use super::lines::{listed, row, short, wrapped};
use super::report::{self, Interrupted, refused};
use super::study::{self, Placed};

const FAMILY: &str = "family.csv";
const PICTURE: &str = "family.svg";

/// The case at the first value, where the number that is followed is the last unknown.
fn read(args: &FindArgs, Followed { key, from, .. }: &Followed) -> anyhow::Result<(Case, Find)> {
    let (name, text) = (args.case.name(), args.case.read_text()?);
    let mut set = args.case.set.clone();
    set.push(format!("{key}={from}"));
    let parsed = |set: &[String]| Case::parse(&name, &text, set).map_err(|error| args.case.of_another_kind(error));
    let wanted = checked(&parsed(&set)?)?;
    let mut keys: Vec<String> = wanted.unknowns.iter().map(|unknown| format!("{:?}", unknown.key)).collect();
    if wanted.unknowns.iter().any(|unknown| unknown.key == *key) {
        let message = format!("{key} is one of the unknowns, and is to be followed");
        return Err(refused(&message, "follow another number, or take it out of find.unknowns"));
    }
    keys.push(format!("{key:?}"));
    set.push(format!("find.unknowns=[{}]", keys.join(", ")));
    let case = parsed(&set)?;
    let wanted = checked(&case)?;
    Ok((case, wanted))
}

pub(super) fn follow_family(args: &FindArgs, followed: &Followed) -> anyhow::Result<ExitCode> {
    let (case, wanted) = read(args, followed)?;
    args.case.note(&case);
    let target = args.output.target(&args.case, "find")?;
    let picture: &[&str] = if args.plot { &[PICTURE] } else { &[] };
    let files = OutputSet::open(target, &[&[FAMILY, SUMMARY, CASE], picture].concat())?;
    files.write_text(CASE, &case.to_toml())?;
    let family = match computed(&case, &wanted, followed.to, args.case.quiet)? {
        Ok(family) => family,
        Err(none) => {
            let summary = not_found_summary(&case, (&none.message, &none.advice), 0);
            files.write_text(SUMMARY, &summary)?;
            files.commit(&|name| [SUMMARY, CASE].contains(&name))?;
            args.output.tell(args.case.quiet, &summary, String::new)?;
            return Err(none.into());
        }
    };
    files.write_table(FAMILY, |out| write_members(out, &wanted, &family))?;
    let title = args.case.headed(case.title.as_deref());
    if args.plot {
        files.write_text(PICTURE, &pictures::family(&title, &wanted, &family))?;
    }
    let json = family_summary(&case, &wanted, &family);
    let placed = Placed::new(files, &json, None)?;
    if let Ended::Stopped(reason) = &family.ended {
        report::warn(&format!("the family is followed no further: {reason}"));
    }
    args.output.tell(args.case.quiet, &json, || told(&title, &wanted, &family) + &placed.written)?;
    Ok(ExitCode::SUCCESS)
}

/// Follows beside this thread, with a line about the last member if standard error is a terminal.
fn computed(case: &Case, wanted: &Find, to: f64, is_quiet: bool) -> anyhow::Result<Result<Family, NotFound>> {
    let bar = study::bar(is_quiet, 0, "{spinner} {msg} ({elapsed})");
    bar.set_message("the first member");
    bar.enable_steady_tick(Duration::from_millis(200));
    let problem = Arc::new((case.clone(), wanted.clone(), to));
    let (mut members, mut result) = (0, None);
    enum News {
        Member(f64),
        End(Box<Result<Family, NotFound>>),
    }
    let interrupted = study::computed(
        &bar,
        &problem,
        |(case, wanted, to), tell: &(dyn Fn(News) + Sync)| {
            let last = wanted.unknowns.len() - 1;
            let family = follow(case, wanted, *to, &mut |member| tell(News::Member(member.values[last])));
            tell(News::End(Box::new(family)));
        },
        |news| match news {
            News::Member(at) => {
                members += 1;
                bar.set_message(format!("member {members}, at {at:.6}"));
            }
            News::End(family) => result = Some(*family),
        },
    );
    Ok(result.filter(|_| !interrupted).ok_or(Interrupted)?)
}

/// The lines about a family.
fn told(title: &str, wanted: &Find, family: &Family) -> String {
    let (members, last) = (&family.members, wanted.unknowns.len() - 1);
    let key = &wanted.unknowns[last].key;
    let ends = [&members[0], &members[members.len() - 1]].map(|member| short(member.values[last]));
    let head = format!("{title}: {} members from {key} = {} to {}", members.len(), ends[0], ends[1]);
    let mut text = wrapped(&head, 2);
    let one = |member: &Member| {
        let all = wanted.unknowns.iter().zip(member.values.iter().zip(&member.errors));
        listed(all.map(|(unknown, (value, error))| format!("{} = {}", unknown.key, with_error(*value, *error))))
    };
    text += &row("first", &one(&members[0]));
    for fold in members.iter().filter(|member| member.is_fold) {
        text += &row("fold", &one(fold));
    }
    text += &row("last", &one(&members[members.len() - 1]));
    if family.ended == Ended::Back {
        text += &row("ended", &format!("where {key} comes back to its first value"));
    }
    text
}
