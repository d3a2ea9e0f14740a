//! What happens during a drive.

use jde_abi::describe::{Port, Role, Schema};
use jde_app::literal::parse_value;
use jde_app::{time, warn_of_former_name};
use jde_core::SchemaId;
use jde_document::section::{expect, number};
use jde_document::{FaultReport, Section, Text, quote};
use jde_host::SensorFault;
use jde_sim::Edits;

use super::Subject;
use super::expressions::Expressions;
use super::values::{moment, source};
use crate::drive::step::{DriveStep, EDIT, StepAction, StepTime, StepWrite};
use crate::experiment::{Axis, Experiment};

/// The keys that say what a step does.
const ACTIONS: [&str; 13] = [
    "play", "stop", "force", "release", "set", "place", "add", "remove", "halt", "resume", "raise", "lower",
    "fail",
];

/// Those that change the world of a simulated robot.
const EDITS: [&str; 7] = ["place", "add", "remove", "halt", "resume", "raise", "lower"];

/// Reads `steps`, in the file's order.
pub(super) fn read(
    report: &mut FaultReport,
    root: &Section,
    subject: &Subject<'_>,
    axes: &[Axis],
    expressions: &mut Expressions,
) -> Vec<DriveStep> {
    let tables = root.tables(report, "steps", "step").unwrap_or_default();
    let steps = tables.iter().flatten();
    let steps = steps.filter_map(|section| step(report, section, subject, axes, expressions));
    steps.collect()
}

fn step(
    report: &mut FaultReport,
    section: &Section,
    subject: &Subject<'_>,
    axes: &[Axis],
    expressions: &mut Expressions,
) -> Option<DriveStep> {
    section.refuse_unknown(report, &[&ACTIONS[..], &["at", "when", "case"]].concat());
    let case = section.text(report, "case");
    if let Some(case) = &case
        && !Experiment::cases(axes).any(|name| name == case.text)
    {
        report
            .fault(&case.span, format!("there is no case {}", quote(case.text)))
            .suggest(case.text, "cases", Experiment::cases(axes));
    }
    let when = match (section.get("at"), section.text(report, "when")) {
        (Some(node), None) => moment(report, &section.key("at"), node).map(StepTime::At),
        (None, Some(text)) => expressions.condition(report, subject, &text).map(StepTime::When),
        (Some(_), Some(_)) | (None, None) => {
            report
                .fault(
                    &section.span,
                    format!("{} needs one of `at` and `when`", section.label),
                )
                .advise("write `at = \"20s\"`, or `when = \"EXPRESSION\"`");
            None
        }
    };
    let given: Vec<_> = ACTIONS
        .into_iter()
        .filter(|key| section.get(key).is_some())
        .collect();
    let [key] = given.as_slice() else {
        report
            .fault(&section.span, format!("{} must do one thing", section.label))
            .advise(format!("write one of {}", ACTIONS.join(", ")));
        return None;
    };
    let action = match *key {
        "set" => set(report, section, subject),
        "fail" => fail(report, section, subject),
        word if EDITS.contains(&word) => edit(report, section, word, subject),
        word => section
            .text(report, word)
            .and_then(|name| schema(report, subject, &name))
            .map(|schema| match word {
                "play" => StepAction::Play(schema),
                "stop" => StepAction::Stop(schema),
                "force" => StepAction::Force(schema),
                _ => StepAction::Release(schema),
            }),
    };
    let place = format!("{}:{}", subject.file.display(), report.line(section.span.start));
    Some(DriveStep {
        case: case.map(|case| case.text.to_owned()),
        when: when?,
        action: action?,
        place,
    })
}

fn schema(report: &mut FaultReport, subject: &Subject<'_>, name: &Text) -> Option<SchemaId> {
    let place = subject.application.instance(name.text);
    if place.is_none() {
        let known = subject
            .application
            .instances
            .iter()
            .map(|instance| instance.name.as_str());
        report
            .fault(&name.span, format!("no schema is called {}", quote(name.text)))
            .suggest(name.text, "schemas", known);
    }
    place
}

/// Reads a change of the world, which the driver of any of its robots makes.
fn edit(
    report: &mut FaultReport,
    section: &Section,
    word: &str,
    subject: &Subject<'_>,
) -> Option<StepAction> {
    let node = section.get(word)?;
    let instances = &subject.application.instances;
    let driver = instances.find(|instance| modulations(&instance.schema).any(|port| port.name == EDIT));
    let Some(driver) = driver else {
        report
            .fault(
                &section.key_span(word),
                format!("`{word}` needs a simulated robot"),
            )
            .advise("no schema of the application can change a world");
        return None;
    };
    let text = format!("{{ {word} = {} }}", source(subject.text, node));
    match Edits::parse(&text) {
        Ok(_) => Some(StepAction::Edit { driver, text }),
        Err(error) => {
            report.fault(&node.span(), error.to_string());
            None
        }
    }
}

/// Reads how an export fails.
fn fail(report: &mut FaultReport, section: &Section, subject: &Subject<'_>) -> Option<StepAction> {
    let table = section.section(report, "fail", section.key("fail"))?;
    table.refuse_unknown(
        report,
        &["export", "as", "for", "sigma", "first", "last", "range", "by"],
    );
    for key in ["export", "as"]
        .into_iter()
        .filter(|key| table.get(key).is_none())
    {
        report.fault(&table.span, format!("{} has no `{key}`", table.label));
    }
    let (export, word) = (table.text(report, "export")?, table.text(report, "as")?);
    let (owner, name) = export.text.split_once('.').unwrap_or((export.text, ""));
    let owner = Text {
        text: owner,
        span: export.span.clone(),
    };
    let schema = schema(report, subject, &owner)?;
    let ports = &subject.application.instances[schema].schema.ports;
    let mut exports = ports
        .iter()
        .filter(|port| matches!(port.role, Role::Export { .. }));
    if !exports.clone().any(|port| port.name == name) {
        report
            .fault(
                &export.span,
                format!("schema {} has no export {}", quote(owner.text), quote(name)),
            )
            .suggest(name, "exports", exports.by_ref().map(|port| port.name.as_str()));
        return None;
    }
    let number = |report: &mut FaultReport, key: &str| {
        let Some(node) = table.get(key) else {
            report.fault(&word.span, format!("{} needs `{key}`", quote(word.text)));
            return None;
        };
        expect(report, &table.key(key), "a number", node, number(node.get_ref()))
    };
    let fault = match word.text {
        "silent" => SensorFault::Silent,
        "frozen" => SensorFault::Frozen,
        "noise" => SensorFault::Noise {
            sigma: number(report, "sigma")?,
        },
        "blocked" => SensorFault::Blocked {
            first: number(report, "first")? as u32,
            last: number(report, "last")? as u32,
            range: number(report, "range")? as f32,
        },
        "contradictory" => SensorFault::Contradictory,
        "late" => {
            let Some(node) = table.get("by") else {
                report.fault(&word.span, "\"late\" needs `by`");
                return None;
            };
            SensorFault::Late {
                by: moment(report, &table.key("by"), node)?,
            }
        }
        other => {
            let kinds = ["silent", "frozen", "noise", "blocked", "contradictory", "late"];
            report
                .fault(&word.span, format!("an export cannot fail as {}", quote(other)))
                .suggest(other, "kinds", kinds);
            return None;
        }
    };
    let time = match table.get("for") {
        Some(node) => Some(moment(report, &table.key("for"), node)?),
        None => None,
    };
    Some(StepAction::Fail {
        schema,
        export: name.to_owned(),
        fault,
        time,
    })
}

/// Reads the modulations that a step writes.
fn set(report: &mut FaultReport, section: &Section, subject: &Subject<'_>) -> Option<StepAction> {
    let table = section.section(report, "set", section.key("set"))?;
    let mut actions = Vec::new();
    for (name, node) in table.entries() {
        let Some((owner, variable)) = name.text.split_once('.') else {
            report
                .fault(
                    &name.span,
                    format!("{} names no variable of a schema", quote(name.text)),
                )
                .advise("write schema and variable in quotes, such as \"goon.fast\"");
            continue;
        };
        let owner = Text {
            text: owner,
            span: name.span.clone(),
        };
        let Some(schema) = schema(report, subject, &owner) else {
            continue;
        };
        if variable == "period" {
            let period = time::period(report, &table.key(name.text), node)?;
            actions.push(StepWrite::Period(schema, period));
            continue;
        }
        let instance = &subject.application.instances[schema];
        let Some(port) = instance.schema.modulation_named(variable) else {
            let known = modulations(&instance.schema).map(|port| port.name.as_str());
            report
                .fault(
                    &name.span,
                    format!(
                        "schema {} has no modulation {}",
                        quote(owner.text),
                        quote(variable)
                    ),
                )
                .suggest(variable, "modulations", known);
            continue;
        };
        let port = &instance.schema.ports[port];
        if port.name != variable {
            warn_of_former_name(report, &name.span, &quote(name.text), &port.name);
        }
        let folder = subject.file.parent().unwrap_or(subject.file);
        let text = source(subject.text, node);
        let owner = (owner.text, variable);
        match parse_value(&text, owner, &port.value_type, &port.unit, folder, name.text) {
            Ok(value) => actions.push(StepWrite::Value(schema, port.name.clone(), value)),
            Err(faults) => {
                for fault in faults.list() {
                    report.fault(&node.span(), fault.message.clone());
                }
            }
        }
    }
    Some(StepAction::Write(actions))
}

fn modulations(schema: &Schema) -> impl Iterator<Item = &Port> {
    let ports = schema.ports.iter();
    ports.filter(|port| matches!(port.role, Role::Modulation { .. }))
}
