//! What varies: axes, cases, values that are the same for all drives, and variants of plugins.

use std::collections::BTreeSet;
use std::ops::Range;
use std::path::Path;

use jde_abi::describe::Role;
use jde_app::{Application, Faults, Override};
use jde_document::section::{Node, expect, integer, report_wrong_shape};
use jde_document::{FaultReport, Section, Text, quote};

use super::values::{label, source};
use super::worlds::{world, worlds};
use super::{SetValue, Subject, load};
use crate::applications::Applications;
use crate::experiment::{Axis, AxisChoice, AxisValues, CASE, Experiment, Variant};

/// An axis, and the position of each of its values.
pub(super) struct DraftAxis {
    axis: Axis,
    spans: Vec<Range<usize>>,
}

impl DraftAxis {
    pub(super) fn finish(self) -> Axis {
        self.axis
    }
}

/// The largest number of values of all axes together. Each is checked in the application, which takes about a millisecond.
const MAX_VALUES: usize = 4000;

/// The modulation that is the start of a simulated robot.
const START: &str = "start";

/// Reads the values that every drive sets.
pub(super) fn read_set(report: &mut FaultReport, root: &Section, text: &str, folder: &Path) -> Vec<SetValue> {
    match root.section(report, "set", "`set`") {
        Some(section) => set_values(report, &section, text, folder),
        None => Vec::new(),
    }
}

fn set_values(report: &mut FaultReport, section: &Section, text: &str, folder: &Path) -> Vec<SetValue> {
    let entries = section.entries();
    let set =
        entries.filter_map(|(name, node)| set_value(report, &name, source(text, node), node.span(), folder));
    set.collect()
}

/// Returns a value that sets `schema.variable`.
pub(super) fn set_value(
    report: &mut FaultReport,
    name: &Text,
    value: String,
    span: Range<usize>,
    folder: &Path,
) -> Option<SetValue> {
    let Some((schema, variable)) = name.text.split_once('.') else {
        report
            .fault(
                &name.span,
                format!("{} names no variable of a schema", quote(name.text)),
            )
            .advise("write schema and variable in quotes, such as \"goon.fast\"");
        return None;
    };
    let value = Override {
        schema: schema.to_owned(),
        variable: variable.to_owned(),
        value,
        folder: folder.to_owned(),
        place: None,
    };
    Some(SetValue { value, span })
}

/// Reads the variants. The first is used where nothing chooses one; without variants it replaces nothing.
pub(super) fn read_variants(report: &mut FaultReport, root: &Section, folder: &Path) -> Vec<Variant> {
    let axes = root
        .get("axes")
        .and_then(|node| node.get_ref().as_table())
        .map(|axes| Section::new("`axes`", root.key_span("axes"), axes));
    let section = axes.and_then(|axes| axes.section(report, "variants", "`variants` of `axes`"));
    let Some(section) = section else {
        return vec![Variant::default()];
    };
    let names: Vec<_> = section.entries().map(|(name, _)| name).collect();
    let variants = names.iter().map(|name| {
        let pairs = section.pairs(report, name.text);
        let mut plugins = Vec::new();
        for (plugin, file) in pairs {
            let path = folder.join(file.text);
            if !path.is_file() {
                report
                    .fault(
                        &file.span,
                        format!("there is no file {}", quote(&path.display().to_string())),
                    )
                    .advise("build the plugin, or correct the path, which is relative to this file");
            }
            plugins.push((plugin.text.to_owned(), path));
        }
        Variant {
            name: name.text.to_owned(),
            plugins,
        }
    });
    let variants: Vec<_> = variants.collect();
    if variants.is_empty() {
        report.fault(&section.span, "`variants` has no variant");
        return vec![Variant::default()];
    }
    variants
}

/// Reads the axes and the cases.
pub(super) fn read(
    report: &mut FaultReport,
    root: &Section,
    subject: &Subject<'_>,
    variants: &[Variant],
) -> Vec<DraftAxis> {
    let mut axes = Vec::new();
    axes.extend(cases(report, root, subject, variants));
    let Some(section) = root.section(report, "axes", "`axes`") else {
        return axes;
    };
    section.refuse_unknown(report, &["seeds", "worlds", "starts", "set", "variants"]);
    for (key, node) in section.entries() {
        match key.text {
            "seeds" => axes.extend(seeds(report, node)),
            "worlds" => {
                let values = list(report, "`worlds` of `axes`", node);
                axes.push(choices("world", values, |value| worlds(report, subject, value)));
            }
            "starts" => {
                let values = list(report, "`starts` of `axes`", node);
                axes.push(choices("start", values, |value| start(report, subject, value)));
            }
            "set" => {
                let Some(sets) = section.section(report, "set", "`set` of `axes`") else {
                    continue;
                };
                for (name, node) in sets.entries() {
                    let values = list(report, &sets.key(name.text), node);
                    let folder = folder(subject.file);
                    axes.push(choices(name.text, values, |value| {
                        let set =
                            set_value(report, &name, source(subject.text, value), value.span(), folder)?;
                        Some(AxisChoice {
                            label: label(subject.text, value),
                            seed: None,
                            overrides: vec![set.value],
                            variant: None,
                        })
                    }));
                }
            }
            "variants" => axes.push(variant_axis(&section, variants)),
            _ => {}
        }
    }
    axes
}

/// Checks each value of the axes in the application, with the first values of all others.
///
/// # Errors
/// Faults of the application itself that only a value causes.
pub(super) fn check_values(
    report: &mut FaultReport,
    axes: &[DraftAxis],
    set: &[SetValue],
    variants: &[Variant],
    applications: &mut Applications,
) -> Result<(), Faults> {
    let count = |draft: &DraftAxis| match &draft.axis.values {
        AxisValues::Choices(choices) => choices.len(),
        AxisValues::Seeds(_) => 0,
    };
    let values: usize = axes.iter().map(count).sum();
    if values > MAX_VALUES {
        let last = axes
            .iter()
            .filter_map(|draft| draft.spans.last())
            .max_by_key(|span| span.end);
        report
            .fault(
                &last.cloned().unwrap_or_default(),
                format!("the axes and cases have {values} values together, each of which is checked in the application"),
            )
            .advise(format!(
                "at most {MAX_VALUES} are possible, seeds not counted; write several experiments"
            ));
        return Ok(());
    }
    for DraftAxis { axis, spans } in axes {
        let AxisValues::Choices(choices) = &axis.values else {
            continue;
        };
        for (choice, span) in choices.iter().zip(spans) {
            let own = choice.overrides.iter().map(|value| SetValue {
                value: value.clone(),
                span: span.clone(),
            });
            let all: Vec<_> = set
                .iter()
                .map(|set| SetValue {
                    value: set.value.clone(),
                    span: set.span.clone(),
                })
                .chain(own)
                .collect();
            let variant = &variants[choice.variant.unwrap_or(0)];
            load(report, applications, &all, variant)?;
        }
    }
    Ok(())
}

/// Reads `"1..100"`, or a list of whole numbers.
fn seeds(report: &mut FaultReport, node: &Node) -> Option<DraftAxis> {
    const EXPECTED: &str = "a range such as \"1..100\", or a list of whole numbers";
    let seeds: Vec<u64> = if let Some(range) = node.get_ref().as_str() {
        let ends = range.split_once("..").and_then(|(first, last)| {
            let last = last.strip_prefix('=').unwrap_or(last);
            Some((
                first.trim().parse::<u64>().ok()?,
                last.trim().parse::<u64>().ok()?,
            ))
        });
        match ends {
            Some((first, last)) if first <= last && last - first < Experiment::MAX_DRIVES as u64 => {
                (first..=last).collect()
            }
            Some(_) | None => {
                report
                    .fault(&node.span(), format!("`seeds` is {}", quote(range)))
                    .advise(format!(
                        "write {EXPECTED}; at most {} seeds are possible",
                        Experiment::MAX_DRIVES
                    ));
                return None;
            }
        }
    } else {
        let list = expect(report, "`seeds`", EXPECTED, node, node.get_ref().as_array())?;
        let seeds = list.iter().map(|node| seed(report, node));
        seeds.collect::<Option<_>>()?
    };
    if seeds.is_empty() {
        report.fault(&node.span(), "`seeds` is empty");
        return None;
    }
    Some(DraftAxis {
        axis: Axis {
            name: String::from("seed"),
            values: AxisValues::Seeds(seeds),
        },
        spans: Vec::new(),
    })
}

fn seed(report: &mut FaultReport, node: &Node) -> Option<u64> {
    let seed = integer(node.get_ref()).and_then(|seed| u64::try_from(seed).ok());
    expect(report, "a seed", "a whole number from 0", node, seed)
}

/// Returns the values of an axis; reports a value that is no list, or an empty one.
fn list<'a>(report: &mut FaultReport, what: &str, node: &'a Node<'a>) -> Vec<&'a Node<'a>> {
    match node.get_ref().as_array() {
        Some(list) if !list.is_empty() => list.iter().collect(),
        Some(_) => {
            report.fault(&node.span(), format!("{what} is empty"));
            Vec::new()
        }
        None => {
            report_wrong_shape(
                report,
                what,
                "a list of values, one for each drive of the axis",
                node,
            );
            Vec::new()
        }
    }
}

fn choices<'a, Choices: IntoIterator<Item = AxisChoice>>(
    name: &str,
    values: Vec<&'a Node<'a>>,
    mut read: impl FnMut(&'a Node<'a>) -> Choices,
) -> DraftAxis {
    let read = values
        .iter()
        .flat_map(|value| read(value).into_iter().map(|choice| (choice, value.span())));
    let (choices, spans) = read.unzip();
    DraftAxis {
        axis: Axis {
            name: name.to_owned(),
            values: AxisValues::Choices(choices),
        },
        spans,
    }
}

/// A start for each of the robots that it names: `{ pioneer = [1, 2, "90 deg"] }`.
fn start(report: &mut FaultReport, subject: &Subject<'_>, node: &Node) -> Option<AxisChoice> {
    let starts = expect(
        report,
        "each of `starts`",
        "a table of robots, such as { pioneer = [1, 2, \"90 deg\"] }",
        node,
        node.get_ref().as_table(),
    )?;
    let section = Section::new("`starts`", node.span(), starts);
    let overrides = section.entries().map(|(robot, place)| Override {
        schema: robot.text.to_owned(),
        variable: START.to_owned(),
        // The modulation is a list of at most one pose.
        value: format!("[{}]", source(subject.text, place)),
        folder: folder(subject.file).to_owned(),
        place: None,
    });
    Some(AxisChoice {
        label: label(subject.text, node),
        seed: None,
        overrides: overrides.collect(),
        variant: None,
    })
}

fn variant_axis(section: &Section, variants: &[Variant]) -> DraftAxis {
    let choices = variants.iter().enumerate().map(|(place, variant)| AxisChoice {
        label: variant.name.as_str().into(),
        seed: None,
        overrides: Vec::new(),
        variant: Some(place),
    });
    DraftAxis {
        axis: Axis {
            name: String::from("variant"),
            values: AxisValues::Choices(choices.collect()),
        },
        spans: vec![section.key_span("variants"); variants.len()],
    }
}

/// Reads `[[cases]]` as one axis.
fn cases(
    report: &mut FaultReport,
    root: &Section,
    subject: &Subject<'_>,
    variants: &[Variant],
) -> Option<DraftAxis> {
    let node = root.get("cases")?;
    let tables = root.tables(report, "cases", "case")?;
    let mut names = BTreeSet::new();
    let mut choices = Vec::new();
    let mut spans = Vec::new();
    for section in tables.iter().flatten() {
        if let Some(choice) = case(report, section, subject, variants, &mut names) {
            choices.push(choice);
            spans.push(section.span.clone());
        }
    }
    if tables.is_empty() {
        report.fault(&node.span(), "`cases` is empty");
    }
    Some(DraftAxis {
        axis: Axis {
            name: CASE.to_owned(),
            values: AxisValues::Choices(choices),
        },
        spans,
    })
}

fn case(
    report: &mut FaultReport,
    section: &Section,
    subject: &Subject<'_>,
    variants: &[Variant],
    names: &mut BTreeSet<String>,
) -> Option<AxisChoice> {
    section.refuse_unknown(report, &["name", "seed", "world", "start", "set", "variant"]);
    let Some(name) = section.text(report, "name") else {
        if section.get("name").is_none() {
            section.fault(report, &section.span, "has no `name`");
        }
        return None;
    };
    if !names.insert(name.text.to_owned()) {
        report.fault(
            &name.span,
            format!("there is a case {} already", quote(name.text)),
        );
    }
    let mut choice = AxisChoice {
        label: name.text.into(),
        seed: section.get("seed").and_then(|node| seed(report, node)),
        overrides: Vec::new(),
        variant: None,
    };
    if let Some(node) = section.get("world") {
        choice.overrides.extend(world(report, subject, node)?.overrides);
    }
    if let Some(node) = section.get("start") {
        choice.overrides.extend(start(report, subject, node)?.overrides);
    }
    if let Some(set) = section.section(report, "set", section.key("set")) {
        let values = set_values(report, &set, subject.text, folder(subject.file));
        choice.overrides.extend(values.into_iter().map(|set| set.value));
    }
    if let Some(name) = section.text(report, "variant") {
        choice.variant = variants.iter().position(|variant| variant.name == name.text);
        if choice.variant.is_none() {
            report
                .fault(&name.span, format!("no variant is called {}", quote(name.text)))
                .suggest(
                    name.text,
                    "variants",
                    variants.iter().map(|variant| variant.name.as_str()),
                );
        }
    }
    Some(choice)
}

/// Returns the schemas that have a modulation of this name.
pub(super) fn with_modulation<'a>(
    application: &'a Application,
    name: &'a str,
) -> impl Iterator<Item = &'a str> {
    let has = move |instance: &&jde_app::InstanceConfig| {
        let mut ports = instance.schema.ports.iter();
        ports.any(|port| port.name == name && matches!(port.role, Role::Modulation { .. }))
    };
    let instances = application.instances.iter().filter(has);
    instances.map(|instance| instance.name.as_str())
}

pub(super) fn folder(file: &Path) -> &Path {
    file.parent().unwrap_or(Path::new("/"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn too_many_values_are_refused_before_the_first_is_checked() {
        let choice = |number: usize| AxisChoice {
            label: number.into(),
            seed: None,
            overrides: Vec::new(),
            variant: None,
        };
        let axis = DraftAxis {
            axis: Axis {
                name: "speed".to_owned(),
                values: AxisValues::Choices((0..=MAX_VALUES).map(choice).collect()),
            },
            spans: vec![0..1; MAX_VALUES + 1],
        };
        let mut report = FaultReport::new(Path::new("many.toml"), "x");
        // There is neither an application nor a variant to check a value with.
        let mut applications = Applications::new("missing.toml".into(), None);
        let checked = check_values(&mut report, &[axis], &[], &[], &mut applications);
        assert!(checked.is_ok());
        let message = report.into_faults().to_string();
        assert!(message.contains("have 4001 values together"), "{message}");
    }
}
