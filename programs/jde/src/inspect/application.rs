//! Describes what of an application would run: the hierarchy, all bindings, and the contract of every group.

use std::io::{self, Write};

use jde_abi::describe::{Kind, Port, Role};
use jde_app::period::format_setting;
use jde_app::{Application, Binding, Executor, GroupConfig, ImportSource, InstanceConfig, Isolation};
use jde_core::{Absence, Id, Policy, SchemaId, contract};
use jde_terminal::{FAINT, TITLE, WARN};

use super::doc::join_lines;
use super::value::format_modulation;
use crate::failure;

/// Writes the description.
///
/// # Errors
/// The output cannot be written.
pub(crate) fn write(application: &Application, output: &mut dyn Write) -> io::Result<()> {
    let file = failure::display_path(&application.path);
    writeln!(
        output,
        "{TITLE}{}{TITLE:#}  {FAINT}{file}{FAINT:#}",
        application.name
    )?;
    if !application.doc.is_empty() {
        writeln!(output, "{}", join_lines(&application.doc))?;
    }
    let executor = match application.executor {
        Executor::Threads => "a thread for each schema that is awake",
        Executor::Pool => "a pool of threads for all schemas",
    };
    let mission = application
        .mission
        .map(|mission| application.variable_name(mission));
    let until = mission.map_or_else(
        || "runs until it is stopped".to_owned(),
        |name| format!("ends when {name} reports the end"),
    );
    writeln!(output, "{executor}; seed {}; {until}", application.seed)?;

    for group in application.groups.iter().filter(|group| group.father.is_none()) {
        write_group(application, group, 0, output)?;
    }
    for (title, of_roots) in [
        ("awake with the roots", true),
        ("awake while another schema needs them", false),
    ] {
        let instances = application.instances.entries();
        let mut ungrouped = instances
            .filter(|(id, instance)| instance.group.is_none() && application.awake.contains(id) == of_roots)
            .peekable();
        if ungrouped.peek().is_some() {
            writeln!(output)?;
            writeln!(output, "{TITLE}{title}{TITLE:#}")?;
        }
        for (_, instance) in ungrouped {
            write_instance(application, instance, "", 1, output)?;
        }
    }

    if !application.link.off {
        super::link::write(&application.link, output)?;
    }

    let contracts = contract(&application.spec());
    if !contracts.is_empty() {
        writeln!(output)?;
        writeln!(
            output,
            "{TITLE}contracts{TITLE:#}: the longest time from a situation to the first iteration of the schema that responds"
        )?;
    }
    for contract in contracts {
        for line in contract.to_string().lines() {
            writeln!(output, "  {line}")?;
        }
    }
    Ok(())
}

/// Writes the modulations that have the default of their type, by schema, and marks those that the file sets
/// nevertheless.
///
/// # Errors
/// The output cannot be written.
pub(crate) fn write_defaults(application: &Application, output: &mut dyn Write) -> io::Result<()> {
    writeln!(output)?;
    writeln!(
        output,
        "{TITLE}defaults{TITLE:#}: modulations that have the default of their type"
    )?;
    for instance in &application.instances {
        let ports = instance.schema.ports.iter().zip(&instance.bindings);
        let values = ports.filter_map(|(port, binding)| match (binding, &port.role) {
            (Binding::Modulation { initial, set, .. }, Role::Modulation { default, limits, .. })
                if initial == default =>
            {
                let value = format_modulation(port, limits, initial);
                let note = if *set { " (set without effect)" } else { "" };
                Some(format!("{} = {value}{FAINT}{note}{FAINT:#}", port.name))
            }
            _ => None,
        });
        let values: Vec<_> = values.collect();
        if !values.is_empty() {
            writeln!(
                output,
                "  {TITLE}{}{TITLE:#}  {}",
                instance.name,
                values.join(", ")
            )?;
        }
    }
    Ok(())
}

fn write_group(
    application: &Application,
    group: &GroupConfig,
    depth: usize,
    output: &mut dyn Write,
) -> io::Result<()> {
    let indent = "  ".repeat(depth);
    let short = group.father.and_then(|_| group.name.rsplit('/').next());
    let short = short.unwrap_or(&group.name);
    if depth == 0 {
        writeln!(output)?;
    }
    writeln!(
        output,
        "{indent}{TITLE}{short}{TITLE:#}: {}; nobody ready: {}; patience {}",
        policy(group.policy),
        absence(application, group.absence),
        format_setting(group.patience_ns)
    )?;
    for member in &group.members {
        let instance = &application.instances[*member];
        let role = role(application, *member, group);
        write_instance(application, instance, &role, depth + 1, output)?;
        let own = application
            .groups
            .iter()
            .filter(|group| group.father == Some(*member));
        for group in own {
            write_group(application, group, depth + 2, output)?;
        }
    }
    Ok(())
}

/// Returns the father's name for a member, if it differs from the member's own.
fn role(application: &Application, member: SchemaId, group: &GroupConfig) -> String {
    let Some(father) = group.father.map(|father| &application.instances[father]) else {
        return String::new();
    };
    let role = father.children.find(|child| *child == Some(member));
    let name = role.map(|role| father.schema.children[role.index()].name.as_str());
    match name {
        Some(name) if name != application.instances[member].name => format!(" as {name}"),
        Some(_) | None => String::new(),
    }
}

fn write_instance(
    application: &Application,
    instance: &InstanceConfig,
    role: &str,
    depth: usize,
    output: &mut dyn Write,
) -> io::Result<()> {
    let indent = "  ".repeat(depth);
    let kind = match instance.schema.kind {
        Kind::Motor => "",
        Kind::Perceptive => "perceptive, ",
        Kind::Driver => "driver, ",
    };
    let plugin = &application.plugins[instance.plugin].name;
    writeln!(
        output,
        "{indent}{TITLE}{}{TITLE:#}{role}  {FAINT}{plugin}/{}, {kind}every {}, at most {}{FAINT:#}",
        instance.name,
        instance.schema.name,
        format_setting(instance.period_ns),
        format_setting(instance.budget_ns)
    )?;
    if let Some(isolation) = instance.isolate {
        writeln!(output, "{indent}    {}", describe_isolation(isolation))?;
    }
    for (port, binding) in instance.schema.ports.iter().zip(&instance.bindings) {
        if let Some(line) = describe_binding(application, instance, port, binding) {
            writeln!(output, "{indent}    {line}")?;
        }
    }
    Ok(())
}

/// Describes the limits of a process of its own.
fn describe_isolation(isolation: Isolation) -> String {
    let memory = isolation
        .memory
        .map(|bytes| format!("at most {:.1} MB of memory", bytes as f64 / 1e6));
    let cpu = isolation
        .cpu
        .map(|seconds| format!("at most {seconds} s of processor time per call"));
    let network = (!isolation.network).then(|| String::from("no network"));
    let files = isolation.read_only.then(|| String::from("files read-only"));
    let limits: Vec<_> = [memory, cpu, network, files].into_iter().flatten().collect();
    let limits = if limits.is_empty() {
        String::from("no limits")
    } else {
        limits.join(", ")
    };
    format!("in a process of its own: {limits}")
}

/// Describes a binding. `None` for a port that needs none.
fn describe_binding(
    application: &Application,
    instance: &InstanceConfig,
    port: &Port,
    binding: &Binding,
) -> Option<String> {
    let unbound = || format!("{WARN}unbound{WARN:#}");
    let name = &port.name;
    match binding {
        Binding::Export | Binding::Command => {
            let mut listed = instance.listed.iter().zip(instance.listed_ports());
            let (entry, _) = listed.find(|(_, own)| std::ptr::eq(*own, port))?;
            let arrow = match binding {
                Binding::Command => "<-",
                _ => "->",
            };
            Some(format!(
                "{} {arrow} {name}, {}",
                entry.label, port.value_type.name
            ))
        }
        Binding::Import {
            source,
            trigger,
            stale_ns,
        } => {
            let source = source.map_or_else(unbound, |source| describe_source(application, source));
            let trigger = if *trigger { ", which triggers" } else { "" };
            let stale = stale_ns.map(|stale| format!(", no older than {}", format_setting(stale)));
            Some(format!(
                "{name} <- {source}{trigger}{}",
                stale.unwrap_or_default()
            ))
        }
        Binding::Modulation { initial, .. } => {
            let Role::Modulation { default, limits, .. } = &port.role else {
                return None;
            };
            let value = format_modulation(port, limits, initial);
            (initial != default).then(|| format!("{name} = {value}"))
        }
        Binding::Actuator { target } => {
            let target = target.map_or_else(unbound, |command| application.variable_name(command));
            Some(format!("{name} -> {target}"))
        }
        Binding::ChildModulation { target } => {
            let target = target.map_or_else(unbound, |target| application.target_name(target));
            let Role::ChildModulation { child } = port.role else {
                return None;
            };
            Some(format!(
                "{}.{name} -> {target}",
                instance.schema.children[child].name
            ))
        }
    }
}

/// Describes the source of an import. For another application's variable, includes the age at which it
/// becomes invalid.
fn describe_source(application: &Application, source: ImportSource) -> String {
    let name = application.source_name(source);
    match source {
        ImportSource::Local(..) => name,
        ImportSource::Remote(remote) => {
            let stale = format_setting(application.remotes[remote].stale_ns);
            format!("{name}, another application's, until it is {stale} old")
        }
    }
}

fn policy(policy: Policy) -> String {
    let kind = policy.kind();
    let time = kind.time.as_ref();
    let time = time.map(|time| format!("{} {}", time.key, format_setting(policy.time())));
    let number = kind.number.as_ref();
    let number = number.map(|number| format!("{} {}", number.key, policy.number()));
    let parameters: Vec<String> = time.into_iter().chain(number).collect();
    if parameters.is_empty() {
        return kind.name.to_owned();
    }
    format!("{} ({})", kind.name, parameters.join(", "))
}

fn absence(application: &Application, absence: Absence) -> String {
    match absence {
        Absence::Brake => "brake".to_owned(),
        Absence::Hold { for_ } => format!("hold for {}, then brake", format_setting(for_)),
        Absence::Fallback(id) => format!("{} wins although it is not ready", application.instances[id].name),
    }
}
