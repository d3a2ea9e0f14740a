//! The result of a replay, as text and as JSON.

use std::io::{self, Write};

use jde_decide::{Deviation, Difference, ReplayReport, ReplayedDrive, Values};
use jde_drawing::text::counted;
use jde_host::replay::PortReading;
use jde_loader::SearchPath;
use jde_records::Decision;
use jde_records::wire::state_name;
use jde_session::load::{LoadedApplication, Trust};
use jde_terminal::{BAD, FAINT, GOOD, TITLE, TextWriter, WARN};
use jde_timeline::case_word;
use serde_json::{Value, json};

use crate::failure::{describe_skipped_folders, display_path};

/// Differences that are shown. The rest is only counted.
const MAX_SHOWN: usize = 5;

/// Prints which recording is replayed, and how the application differs from the recorded one.
pub(super) fn print_header(
    output: &mut TextWriter,
    file: &str,
    drive: &ReplayedDrive,
    application: &str,
    differences: &[String],
) -> io::Result<()> {
    let clock = if drive.hierarchy().lockstep {
        "lockstep"
    } else {
        "real time"
    };
    writeln!(
        output,
        "{TITLE}{file}{TITLE:#}: {}, recorded in {clock}",
        drive.name()
    )?;
    if drive.name() != application {
        writeln!(
            output,
            "{WARN}differs{WARN:#}: the application is called {application}"
        )?;
    }
    for difference in differences {
        writeln!(output, "{WARN}differs{WARN:#}: {difference}")?;
    }
    Ok(())
}

/// Prints where plugins are loaded from, as far as the recording determines that.
pub(super) fn print_plugins(
    output: &mut TextWriter,
    loaded: &LoadedApplication,
    trust: Trust,
) -> io::Result<()> {
    let relevant: Vec<_> = loaded
        .skipped_folders
        .iter()
        .filter(|folder| {
            let mut path = SearchPath::default();
            path.push(*folder, "");
            let mut plugins = loaded.application.plugins.iter();
            plugins.any(|plugin| path.find(&plugin.name).is_some())
        })
        .cloned()
        .collect();
    if !relevant.is_empty() {
        writeln!(
            output,
            "{WARN}not trusted{WARN:#}: {}",
            describe_skipped_folders(&relevant)
        )?;
    }
    if trust == Trust::Trusted {
        for plugin in &loaded.application.plugins {
            if let Some(file) = loaded.plugins.file_of(plugin) {
                writeln!(
                    output,
                    "{FAINT}{} from {}{FAINT:#}",
                    plugin.name,
                    display_path(&file)
                )?;
            }
        }
    }
    Ok(())
}

/// Prints the result of the comparison.
pub(super) fn print_verdict(
    output: &mut TextWriter,
    verdict: &ReplayReport,
    stopped: bool,
) -> io::Result<()> {
    let comparison = &verdict.comparison;
    // Shows the first difference, and then those with a takeover on either side: the others follow from
    // these.
    let first = comparison.first.iter().enumerate();
    let shown = first.filter(|(index, difference)| *index == 0 || has_takeover(difference));
    for (_, difference) in shown.take(MAX_SHOWN) {
        print_difference(output, difference)?;
    }
    let values = verdict.values.as_ref();
    for deviation in values.iter().flat_map(|values| &values.first).take(MAX_SHOWN) {
        print_deviation(output, deviation)?;
    }
    if let Some(damage) = &verdict.damage {
        writeln!(
            output,
            "{WARN}damaged{WARN:#}: {damage}; it was replayed up to there"
        )?;
    }
    if verdict.lost_steps > 0 {
        writeln!(
            output,
            "{WARN}lost{WARN:#}: {} steps of schemas are not in the recording, so the replay may differ by itself",
            verdict.lost_steps
        )?;
    }
    for (variable, missed) in &verdict.missed {
        writeln!(
            output,
            "{WARN}lost{WARN:#}: {missed} values of {variable} that schemas read in the recorded run are missing; the newest values were used instead"
        )?;
    }
    for (variable, unknown) in values.iter().flat_map(|values| &values.unknown) {
        writeln!(
            output,
            "{WARN}lost{WARN:#}: {unknown} values of {variable} that schemas wrote are not in the recording, and not compared"
        )?;
    }
    if values.is_none() {
        writeln!(
            output,
            "{WARN}not compared{WARN:#}: the values that schemas wrote; a recording of an older version does not contain them"
        )?;
    }
    for variable in &verdict.unknown {
        writeln!(
            output,
            "{WARN}lost{WARN:#}: operators wrote {variable}, and the values are not in the recording"
        )?;
    }
    for (schema, time) in &verdict.reloads {
        writeln!(
            output,
            "{WARN}reloaded{WARN:#}: the build of {schema} changed at {:.3} s, so two builds decided in the recorded run and one in the replay",
            *time as f64 / 1e9
        )?;
    }
    let until = verdict.until as f64 / 1e9;
    let stopped = if stopped { ", where it was stopped" } else { "" };
    let selections = (comparison.different, comparison.same, "selection");
    let values = values.map(|values: &Values| (values.different, values.same, "value"));
    let compared = || [Some(selections), values].into_iter().flatten();
    let shares = |differ: bool| {
        let shares = compared().filter(|(different, ..)| (*different > 0) == differ);
        let shares = shares.map(|(different, same, what)| format_share(different, same, what));
        shares.collect::<Vec<_>>().join(" and ")
    };
    let (same, different) = (shares(false), shares(true));
    if verdict.is_same() {
        writeln!(
            output,
            "{GOOD}same{GOOD:#}: {same} equal the recorded ones, until {until:.1} s{stopped}"
        )
    } else {
        let is_incomplete =
            verdict.lost_steps > 0 || !verdict.missed.is_empty() || !verdict.unknown.is_empty();
        let note = match (verdict.reloads.is_empty(), is_incomplete) {
            (false, _) => "; the changed builds may be the reason",
            (true, true) => "; what the recording has lost may be the reason",
            (true, false) => "",
        };
        let equal = match same.as_str() {
            "" => String::new(),
            same => format!(", and {same} equal them"),
        };
        writeln!(
            output,
            "{BAD}different{BAD:#}: {different} differ from the recorded ones{equal}, until {until:.1} s{stopped}{note}"
        )
    }
}

/// "3 of 7 values", or "7 values" if none differs.
fn format_share(different: u64, same: u64, what: &str) -> String {
    let total = different + same;
    let all = counted(total, what);
    match different {
        0 => all,
        different => format!("{different} of {all}"),
    }
}

fn print_deviation(output: &mut TextWriter, deviation: &Deviation) -> io::Result<()> {
    let Deviation {
        time_s,
        schema,
        port,
        variable,
        field,
        recorded,
        replayed,
        count,
    } = deviation;
    let name = if *variable == format!("{schema}.{port}") {
        String::new()
    } else {
        format!(" ({variable})")
    };
    let more = match count - 1 {
        0 => String::new(),
        more => format!(", and {more} more"),
    };
    let field = if field.is_empty() {
        String::new()
    } else {
        format!("{field} = ")
    };
    writeln!(
        output,
        "{TITLE}{time_s:9.3} s  {schema}.{port}{TITLE:#}{name}{more}"
    )?;
    writeln!(output, "      then  {field}{recorded}")?;
    writeln!(output, "      now   {field}{replayed}")
}

fn print_difference(output: &mut TextWriter, difference: &Difference) -> io::Result<()> {
    writeln!(
        output,
        "{TITLE}{:9.3} s  {}{TITLE:#}",
        difference.time_s, difference.group
    )?;
    print_decision(output, "then", difference.recorded.as_ref())?;
    print_decision(output, "now", difference.replayed.as_ref())?;
    for (name, inputs) in &difference.inputs {
        if is_explained_by(difference, name) && !inputs.is_empty() {
            let inputs: Vec<_> = inputs.iter().map(format_input).collect();
            writeln!(output, "      {name} saw {}", inputs.join(", "))?;
        }
    }
    Ok(())
}

fn print_decision(output: &mut TextWriter, when: &str, decision: Option<&Decision>) -> io::Result<()> {
    let Some(decision) = decision else {
        return writeln!(output, "      {when:<5} no selection");
    };
    let choice = decision.choice_name();
    writeln!(
        output,
        "      {when:<5} {choice} by {}: {} {FAINT}({}; {}){FAINT:#}",
        decision.decider,
        decision.reason,
        case_word(decision.case),
        decision.cause
    )?;
    let candidates = decision.candidates.iter().map(|candidate| {
        let urgency = candidate.urgency.filter(|urgency| *urgency != 0.0);
        let urgency = urgency.map_or(String::new(), |urgency| format!(" {urgency}"));
        let ready = if candidate.ready { ", ready" } else { "" };
        format!(
            "{} {}{ready}{urgency}",
            candidate.name,
            state_name(candidate.state)
        )
    });
    writeln!(
        output,
        "            {FAINT}{}{FAINT:#}",
        candidates.collect::<Vec<_>>().join("; ")
    )
}

fn has_takeover(difference: &Difference) -> bool {
    let sides = [&difference.recorded, &difference.replayed];
    sides.into_iter().flatten().any(|decision| decision.changed)
}

/// Whether the inputs of candidate `name` explain a difference. They do if its own entry differs between the
/// two selections. If all entries are equal, or one selection is missing, they do if it was chosen.
fn is_explained_by(difference: &Difference, name: &str) -> bool {
    let chosen = |decision: &Decision| decision.choice.as_deref() == Some(name);
    let (Some(then), Some(now)) = (&difference.recorded, &difference.replayed) else {
        let either = difference.recorded.as_ref().or(difference.replayed.as_ref());
        return either.is_some_and(chosen);
    };
    if then.candidates == now.candidates {
        return chosen(then) || chosen(now);
    }
    let entry = |decision: &Decision| {
        let mut candidates = decision.candidates.iter();
        candidates.find(|candidate| candidate.name == name).cloned()
    };
    entry(then) != entry(now)
}

fn format_input(reading: &PortReading) -> String {
    match &reading.value {
        None => format!("no {}", reading.port),
        Some((0, _, Some(value))) => format!("{} = {value}", reading.port),
        Some((number, time, Some(value))) => {
            format!(
                "{} = {value} (value {number}, of {:.3} s)",
                reading.port,
                *time as f64 / 1e9
            )
        }
        Some((number, time, None)) => {
            format!(
                "{} (value {number}, of {:.3} s)",
                reading.port,
                *time as f64 / 1e9
            )
        }
    }
}

/// Returns the complete result as JSON.
pub(super) fn json(
    file: &str,
    drive: &ReplayedDrive,
    differences: &[String],
    verdict: &ReplayReport,
) -> Value {
    let first = verdict.comparison.first.iter().map(|difference| {
        let inputs = difference.inputs.iter().map(|(schema, readings)| {
            let inputs = readings.iter().map(|reading| {
                let (number, time, value) = reading
                    .value
                    .clone()
                    .map_or((None, None, None), |(number, time, value)| {
                        (Some(number), Some(time as f64 / 1e9), value)
                    });
                json!({ "port": reading.port, "number": number, "measured_s": time, "value": value })
            });
            json!({ "schema": schema, "inputs": inputs.collect::<Vec<_>>() })
        });
        json!({
            "time_s": difference.time_s,
            "group": difference.group,
            "recorded": difference.recorded,
            "replayed": difference.replayed,
            "saw": inputs.collect::<Vec<_>>(),
        })
    });
    let counts = |counts: &[(String, u64)]| -> Vec<Value> {
        let counts = counts.iter();
        counts
            .map(|(variable, values)| json!({ "variable": variable, "values": values }))
            .collect()
    };
    let values = verdict.values.as_ref().map(|values| {
        json!({
            "same": values.same,
            "different": values.different,
            "unknown": counts(&values.unknown),
            "first": values.first,
        })
    });
    json!({
        "file": file,
        "application": drive.name(),
        "lockstep": drive.hierarchy().lockstep,
        "differs": differences,
        "same": verdict.comparison.same,
        "different": verdict.comparison.different,
        "values": values,
        "until_s": verdict.until as f64 / 1e9,
        "lost_steps": verdict.lost_steps,
        "missed": counts(&verdict.missed),
        "unknown": verdict.unknown,
        "reloads": verdict
            .reloads
            .iter()
            .map(|(schema, time)| json!({ "schema": schema, "time_s": *time as f64 / 1e9 }))
            .collect::<Vec<_>>(),
        "damage": verdict.damage,
        "first": first.collect::<Vec<_>>(),
    })
}
