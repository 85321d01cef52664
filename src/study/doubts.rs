//! Reasons to doubt a run that no number says: what its events, its start and its formulas leave open.

use super::run::Run;
use crate::diagnostics::verdict::Reason;
use crate::number::Real;
use crate::solve::Setup;

/// The remedy where an event was not seen.
const SMALLER: &str = "ask for a smaller accuracy or tolerance, whose windows are shorter";
/// The remedy where sensitivity leaves something out.
const COMPARE: &str = "compare runs from neighbouring starts, with --vary";

impl<S: Real> Run<S> {
    /// The reasons to doubt this run of `setup`, whatever its numbers say.
    pub(super) fn doubts(&self, setup: &Setup<S>) -> Vec<Reason> {
        let mut found = Vec::new();
        if self.missed > 0 {
            let many = if self.missed == 1 { "once an event" } else { "several times an event" };
            let finding = format!("{many} that acts or ends the run was stepped over between two nodes");
            found.push(Reason::new(finding, SMALLER).remaining());
        }
        if let Some(name) = &self.unpaired {
            let finding = format!("an event {name} is met by this run or by the one that judges it, and not by both");
            found.push(Reason::new(finding, SMALLER));
        }
        if let Some((name, gamma)) = &self.unseen {
            let finding =
                format!("what {name} watches changes too narrowly to be followed, at gamma = {gamma:.6} first");
            found.push(Reason::new(finding, "write it with what changes as slowly as the motion").remaining());
        }
        if let Some(name) = &self.beyond {
            let finding =
                format!("the run begins where the event {name} acts, and goes on beyond: it does not act there");
            found.push(Reason::new(finding, "begin before it, or with the state behind it").remaining());
        }
        if let Some(gamma) = self.undecided {
            let finding = format!(
                "at gamma = {gamma:.6} the motion is where a force that jumps, or grows like a root, leads away: it \
                 may stay and it may leave, and the equations do not say which"
            );
            found.push(Reason::new(finding, "begin beside it, on the side that is meant").remaining());
        }
        if let Some(gamma) = self.line.touched {
            let finding = format!(
                "at gamma = {gamma:.6} the motion touches a place where a force jumps, or hardly passes it: its error \
                 decides which"
            );
            found.push(Reason::new(finding, "ask for a smaller solver.accuracy, which may tell"));
        }
        if let Some((name, gamma)) = &self.touched {
            let finding = format!(
                "at gamma = {gamma:.6} what {name} watches turns so near to zero that the error of the run decides \
                 whether it happens"
            );
            found.push(Reason::new(finding, "ask for a smaller solver.accuracy, which may tell"));
        }
        if setup.settings.sensitivity && self.line.sensitivity.is_none() {
            let finding = "solver.sensitivity ends where several events act at one place".to_owned();
            found.push(Reason::new(finding, COMPARE).remaining());
        }
        if let Some(function) = self.line.sensitivity.as_ref().and_then(|_| setup.place.geometry.jump()) {
            let finding = format!("solver.sensitivity leaves out what jumps of the equations do to it ({function})");
            found.push(Reason::new(finding, COMPARE).remaining());
        }
        found
    }
}
