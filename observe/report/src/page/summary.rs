//! The head of a page: the application, problems of the recording, and the most important numbers.

use jde_timeline::{Counts, Ending, Severity};
use jde_types::Mission;
use maud::{Markup, html};

use super::{Page, at, counted, trouble};
use crate::analysis::GroupStatistics;
use crate::chart;

pub(super) fn summary(page: &Page<'_>, file: &str) -> Markup {
    let analysis = page.analysis;
    html! {
        header {
            h1 { (analysis.title) }
            p {
                (file)
                @if let Some(begun) = analysis.begun() { " · " (begun) }
                @if let Some(seed) = analysis.survey.seed { " · seed " (seed) }
                @match analysis.lockstep {
                    Some(true) => " · in lockstep, virtual time",
                    Some(false) => " · in real time",
                    None => "",
                }
                @if let Some(jde) = &analysis.survey.jde { " · recorded by jde " (jde) }
            }
        }
        @for remark in analysis.remarks() { p.warn { (remark) } }
        @for cause in &analysis.survey.triggers {
            p.note { "Recorded because of " b { (cause.reason) } " at " (at(cause.time_s)) "." }
        }
        @if analysis.survey.messages == 0 { p.warn { "The recording holds no messages that can be read." } }
        @for missing in missing(page) { p.note { (missing) } }
    }
}

/// The usual parts of a page that this recording has no data for.
fn missing(page: &Page<'_>) -> Vec<&'static str> {
    let analysis = page.analysis;
    let mut missing = Vec::new();
    if analysis.survey.messages == 0 {
        return missing;
    }
    if !analysis.ending.drive.has_path() {
        missing.push("There is no path: no odometry and no ground truth was recorded.");
    }
    if analysis.survey.decisions == 0 {
        missing.push("The states of schemas are not known: no selections were recorded. `jde run --record` and `jde record` record them.");
    } else if !analysis.has_turns {
        missing.push("Iterations and load are not known: turns were not recorded. `jde run --record` without conditions records them.");
    }
    missing
}

pub(super) fn facts(page: &Page<'_>) -> Markup {
    let analysis = page.analysis;
    let ending = &analysis.ending;
    let total = |of: fn(&GroupStatistics) -> u64| analysis.groups.iter().map(of).sum::<u64>();
    let schemas = analysis.timeline.schemas();
    let sum = |of: fn(&Counts) -> u64| schemas.iter().map(|schema| of(&schema.counts)).sum::<u64>();
    let seconds = analysis.columns.seconds();
    html! {
        dl.facts {
            @if analysis.survey.messages > 0 {
                div { dt { "Time" } dd { (chart::seconds(seconds)) small { "from " (at(analysis.columns.from as f64 / 1e9)) } } }
            }
            @if let Some(mission) = analysis.mission() { (mission_text(mission)) }
            @if let Some(ending) = analysis.timeline.ending() { (ending_text(page, ending)) }
            @for path in ending.drive.paths.iter().filter(|path| path.points.len() > 1) {
                div { dt { "Distance" } dd {
                    (format!("{:.1} m", path.distance))
                    @if ending.drive.paths.len() > 1 { small { (path.robot) } }
                } }
            }
            @if let Some(collisions) = ending.collisions {
                div { dt { "Contacts" } dd {
                    (trouble(collisions))
                    @if let Some(clearance) = ending.min_clearance { small { "least clearance " (format!("{clearance:.2} m")) } }
                } }
            }
            @if analysis.survey.decisions > 0 {
                div { dt { "Switches" } dd {
                    (total(|group| group.switches)) small { "of " (counted(total(|group| group.decisions), "selection")) }
                } }
                div { dt { "Overruns" } dd { (trouble(sum(|schema| schema.overruns))) } }
                div { dt { "Refused" } dd { (trouble(sum(|schema| schema.refused))) small { "rows of commands and wakes" } } }
                div { dt { "Faults" } dd { (trouble(sum(|schema| schema.faults))) } }
                div { dt { "Late takeovers" } dd { (trouble(sum(|schema| schema.late))) small { "longer than their contracts" } } }
            }
            @if analysis.events.operations > 0 {
                div { dt { "Operators" } dd { (counted(analysis.events.operations, "action")) } }
            }
        }
    }
}

/// How the application ended, in a word, and why.
fn ending_text(page: &Page<'_>, ending: &Ending) -> Markup {
    let class = match ending.severity() {
        Severity::Good => "good",
        Severity::Warning => "",
        Severity::Bad => "bad",
    };
    html! {
        div { dt { "Outcome" } dd {
            span class=(class) { (ending.word()) }
            small { (ending.reason()) " at " (at(page.analysis.timeline.now() as f64 / 1e9)) }
        } }
    }
}

fn mission_text(mission: &Mission) -> Markup {
    let state = match mission.state {
        Mission::DONE => "done",
        Mission::FAILED => "failed",
        _ => "not done at the end",
    };
    html! {
        div {
            dt { "Mission" }
            dd {
                @match mission.state {
                    Mission::DONE => span.good { (state) },
                    Mission::FAILED => span.bad { (state) },
                    _ => (state),
                }
                small {
                    @if mission.total > 0 { (mission.reached) " of " (mission.total) } @else { (mission.reached) }
                    @if mission.note.as_str().is_empty() { " reached" } @else { " · " (mission.note.as_str()) }
                }
            }
        }
    }
}
