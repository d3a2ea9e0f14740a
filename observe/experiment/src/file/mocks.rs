//! Schemas that are replaced by their ports: by constants, by a script, or by a recording.

use std::path::PathBuf;

use jde_abi::describe::{Port, Role};
use jde_app::InstanceConfig;
use jde_app::literal::parse_value;
use jde_core::Nanos;
use jde_decide::ReplayedDrive;
use jde_document::section::{Node, expect, number};
use jde_document::{FaultReport, Section, quote};
use jde_host::Mock;

use super::Subject;
use super::values::{moment, source};

/// The mocks of an experiment, and the recordings that they play.
#[derive(Default)]
pub(super) struct Mocks {
    pub(super) list: Vec<(String, Mock)>,
    pub(super) recordings: Vec<PathBuf>,
}

/// The keys of a step of a script that are no ports.
const SCRIPT_KEYS: [&str; 3] = ["at", "ready", "urgency"];

/// Returns the names of the schemas that are replaced.
pub(super) fn names(root: &Section) -> Vec<String> {
    let mocks = root.get("mock").and_then(|node| node.get_ref().as_table());
    let names = mocks.into_iter().flat_map(|mocks| mocks.keys());
    names.map(|name| name.get_ref().to_string()).collect()
}

/// Reads all mocks.
pub(super) fn read(report: &mut FaultReport, root: &Section, subject: &Subject<'_>) -> Mocks {
    let mut mocks = Mocks::default();
    let Some(section) = root.section(report, "mock", "`mock`") else {
        return mocks;
    };
    for (name, _) in section.entries() {
        let instances = &subject.application.instances;
        let Some(instance) = instances.iter().find(|instance| instance.name == name.text) else {
            let known = instances.iter().map(|instance| instance.name.as_str());
            report
                .fault(&name.span, format!("no schema is called {}", quote(name.text)))
                .suggest(name.text, "schemas", known);
            continue;
        };
        let what = format!("the mock of {}", quote(name.text));
        if let Some(table) = section.section(report, name.text, what)
            && let Some(mock) = mock(report, &table, subject, instance, &mut mocks.recordings)
        {
            mocks.list.push((name.text.to_owned(), mock));
        }
    }
    mocks
}

fn mock(
    report: &mut FaultReport,
    table: &Section,
    subject: &Subject<'_>,
    instance: &InstanceConfig,
    recordings: &mut Vec<PathBuf>,
) -> Option<Mock> {
    table.refuse_unknown(
        report,
        &["constant", "script", "recording", "schema", "ready", "urgency"],
    );
    let mut mock = match table.text(report, "recording") {
        None => Mock::default(),
        Some(file) => {
            let path = subject.file.parent()?.join(file.text);
            let name = table.text(report, "schema");
            let name = name.map_or(instance.name.as_str(), |name| name.text);
            let read = ReplayedDrive::open(&path).map_err(|error| error.to_string());
            match read
                .and_then(|drive| jde_decide::mock(&drive, name, instance).map_err(|error| error.to_string()))
            {
                Ok(mock) => {
                    recordings.push(path);
                    mock
                }
                Err(reason) => {
                    report.fault(&file.span, reason);
                    return None;
                }
            }
        }
    };
    if let Some(constants) = table.section(report, "constant", "`constant` of this mock") {
        set_ports(report, &constants, subject, instance, (0, &[]), &mut mock);
    }
    set_readiness(report, table, 0, &mut mock);
    let script = table.tables(report, "script", "step")?;
    for step in script.iter().flatten() {
        let at = match step.get("at") {
            Some(node) => moment(report, &step.key("at"), node)?,
            None => {
                report.fault(&step.span, format!("{} of the script has no `at`", step.label));
                continue;
            }
        };
        set_ports(report, step, subject, instance, (at, &SCRIPT_KEYS), &mut mock);
        set_readiness(report, step, at, &mut mock);
    }
    Some(mock)
}

/// Sets whether a motor schema is ready, and its urgency.
fn set_readiness(report: &mut FaultReport, table: &Section, from: Nanos, mock: &mut Mock) {
    let ready = table.flag(report, "ready");
    let urgency = table.get("urgency").and_then(|node| {
        let number = number(node.get_ref());
        expect(report, &table.key("urgency"), "a number", node, number)
    });
    if ready.is_some() || urgency.is_some() {
        mock.set_ready(from, ready.unwrap_or(true), urgency.unwrap_or_default());
    }
}

/// Sets the values of ports from a time on.
fn set_ports(
    report: &mut FaultReport,
    table: &Section,
    subject: &Subject<'_>,
    instance: &InstanceConfig,
    (from, others): (Nanos, &[&str]),
    mock: &mut Mock,
) {
    let is_own = |port: &&Port| {
        matches!(
            port.role,
            Role::Export { .. } | Role::Actuator | Role::ChildModulation { .. }
        )
    };
    for (name, node) in table.entries().filter(|(name, _)| !others.contains(&name.text)) {
        let mut ports = instance.schema.ports.iter().filter(is_own);
        let Some(port) = ports.clone().find(|port| port.name == name.text) else {
            let message = format!("schema {} writes no {}", quote(&instance.name), quote(name.text));
            let known = ports.by_ref().map(|port| port.name.as_str());
            report
                .fault(&name.span, message)
                .suggest(name.text, "it writes", known);
            continue;
        };
        set_port(report, subject, instance, port, (from, node), mock);
    }
}

fn set_port(
    report: &mut FaultReport,
    subject: &Subject<'_>,
    instance: &InstanceConfig,
    port: &Port,
    (from, node): (Nanos, &Node),
    mock: &mut Mock,
) {
    let folder = subject.file.parent().unwrap_or(subject.file);
    let text = source(subject.text, node);
    let owner = (instance.name.as_str(), port.name.as_str());
    match parse_value(&text, owner, &port.value_type, &port.unit, folder, &text) {
        Ok(value) => mock.set(&port.name, from, Some(value)),
        Err(faults) => {
            for fault in faults.list() {
                report.fault(&node.span(), fault.message.clone());
            }
        }
    }
}
