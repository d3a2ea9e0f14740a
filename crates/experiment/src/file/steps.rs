//! What happens during a drive.

use jde_abi::describe::{Port, Role, Schema};
use jde_app::literal::parse_value;
use jde_document::section::expect;
use jde_document::time;
use jde_document::{FaultReport, Section, Text, quote};
use toml::de::DeTable;

use super::Subject;
use super::expressions::Expressions;
use super::values::{moment, source};
use crate::drive::step::{Step, StepAction, StepTime, StepWrite};

/// The keys that say what a step does.
const ACTIONS: [&str; 5] = ["play", "stop", "force", "release", "set"];

/// Reads `steps`, in the file's order.
pub(super) fn read(
    report: &mut FaultReport,
    root: &Section,
    subject: &Subject<'_>,
    expressions: &mut Expressions,
) -> Vec<Step> {
    let Some(node) = root.get("steps") else {
        return Vec::new();
    };
    let Some(list) = expect(
        report,
        "`steps`",
        "a list of tables",
        node,
        node.get_ref().as_array(),
    ) else {
        return Vec::new();
    };
    let steps = list.iter().filter_map(|node| {
        let entries: &DeTable = expect(
            report,
            "each of `steps`",
            "a table",
            node,
            node.get_ref().as_table(),
        )?;
        let section = Section::new("this step", node.span(), entries);
        step(report, &section, subject, expressions)
    });
    steps.collect()
}

fn step(
    report: &mut FaultReport,
    section: &Section,
    subject: &Subject<'_>,
    expressions: &mut Expressions,
) -> Option<Step> {
    section.refuse_unknown(report, &[&ACTIONS[..], &["at", "when"]].concat());
    let when = match (section.get("at"), section.text(report, "when")) {
        (Some(node), None) => moment(report, &section.key("at"), node).map(StepTime::At),
        (None, Some(text)) => expressions.condition(report, subject, &text).map(StepTime::When),
        (Some(_), Some(_)) | (None, None) => {
            report
                .fault(&section.span, "this step needs one of `at` and `when`")
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
            .fault(&section.span, "this step must do one thing")
            .advise(format!("write one of {}", ACTIONS.join(", ")));
        return None;
    };
    let action = match *key {
        "set" => set(report, section, subject),
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
    Some(Step {
        when: when?,
        action: action?,
        place,
    })
}

fn schema(report: &mut FaultReport, subject: &Subject<'_>, name: &Text) -> Option<usize> {
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

/// Reads the modulations that a step writes.
fn set(report: &mut FaultReport, section: &Section, subject: &Subject<'_>) -> Option<StepAction> {
    let table = section.section(report, "set", "`set` of this step")?;
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
        let Some(port) = modulations(&instance.schema).find(|port| port.name == variable) else {
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
        let folder = subject.file.parent().unwrap_or(subject.file);
        let text = source(subject.text, node);
        let owner = (owner.text, variable);
        match parse_value(&text, owner, &port.value_type, &port.unit, folder, name.text) {
            Ok(value) => actions.push(StepWrite::Value(schema, variable.to_owned(), value)),
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
