//! Reads the text file of a policy: every fault at once, with its line. What the network has is checked elsewhere.

use std::ops::Range;

use jde_document::section::{integer, number};
use jde_document::{Checked, FaultReport, Node, Section, WrongValue, quote, quote_all};
use toml::de::DeValue;

use crate::file::{
    Axis, COMMAND_AXES, Colours, Doubt, DoubtKind, Input, Kind, Memory, Output, Pick, PolicyFile, Role,
    Source,
};
use crate::scale::{Normal, Scale};
use crate::{choices, chunk};

/// The most numbers of one input, and values of one stack.
const MAX_COUNT: usize = 10_000;
const MAX_STACK: usize = 1000;
/// The most parts, outputs or memories.
const MAX_PARTS: usize = 1000;
/// The longest side of a picture; a picture of that size in colour is as large as a network takes.
const MAX_SIDE: usize = 256;
/// The largest period, s.
const MAX_PERIOD: f64 = 60.0;

/// The keys that say where an input comes from.
const SOURCE_KEYS: [&str; 6] = ["field", "rays", "path", "target", "pixels", "command"];
/// The keys of each input.
const COMMON_KEYS: [&str; 8] = ["limit", "range", "mean", "std", "clip", "stack", "into", "doc"];

/// Reads the tables of a file. Returns none after a fault.
pub(crate) fn read(report: &mut FaultReport, root: &Section<'_>) -> Option<PolicyFile> {
    let known = [
        "network", "period", "doc", "input", "output", "choices", "memory", "value", "scores", "doubt",
        "chunk",
    ];
    root.refuse_unknown(report, &known);
    let network = root.required(report, "network", |node| match node.get_ref().as_str() {
        Some(text) if !text.is_empty() => Ok((text.to_owned(), node.span())),
        _ => Err(WrongValue::shape(node, "the path of an ONNX file")),
    });
    let period = root.required(report, "period", |node| {
        within(node, 1e-4, MAX_PERIOD, "the time of a step in seconds")
    });
    let mut roles = Vec::new();
    let inputs = tables(report, root, "input", |report, section| {
        input(report, section, &mut roles)
    });
    let outputs = tables(report, root, "output", output);
    let memory = tables(report, root, "memory", |report, section| {
        section.refuse_unknown(report, &["input", "output"]);
        let mut name = |key| section.required(report, key, name);
        Some(Memory {
            input: name("input")?,
            output: name("output")?,
        })
    });
    let pick_at = |report: &mut FaultReport, key: &str, has_index| match root.get(key) {
        None => Some(None),
        Some(_) => {
            let keys: &[&str] = if has_index { &["of", "index"] } else { &["of"] };
            let section = root.nested(report, key, keys)?;
            pick(report, &section).map(Some)
        }
    };
    let (value, scores) = (pick_at(report, "value", true), pick_at(report, "scores", false));
    let doubt = match root.get("doubt") {
        None => Some(None),
        Some(_) => doubt(report, root).map(Some),
    };
    let choices = match root.get("choices") {
        None => Some(None),
        Some(_) => choices::read(report, root).map(Some),
    };
    let chunk = match root.get("chunk") {
        None => Some(None),
        Some(_) => chunk::read(report, root).map(Some),
    };
    if let Some([]) = inputs.as_deref() {
        report
            .fault(&root.span, "the file has no [[input]]")
            .advise("state what the network sees");
    }
    let (network, network_span) = network?;
    let file = PolicyFile {
        network,
        network_span,
        period: period?,
        roles,
        inputs: inputs?,
        outputs: outputs?,
        choices: choices?,
        value: value?,
        scores: scores?,
        memory: memory?,
        doubt: doubt?,
        chunk: chunk?,
    };
    commands_once(report, &file.outputs);
    choices::check(report, root, &file);
    chunk::check(report, root, &file);
    (report.count() == 0).then_some(file)
}

/// Reads the tables of a list; none if one of them has a fault.
fn tables<T>(
    report: &mut FaultReport,
    root: &Section<'_>,
    key: &str,
    mut read: impl FnMut(&mut FaultReport, &Section<'_>) -> Option<T>,
) -> Option<Vec<T>> {
    let list = root.tables(report, key, key)?;
    if list.len() > MAX_PARTS {
        report.fault(
            &root.key_span(key),
            format!("the file has more than {MAX_PARTS} tables [[{key}]]"),
        );
        return None;
    }
    // Each is read, so that the faults of all are reported.
    let read: Vec<Option<T>> = list
        .iter()
        .map(|section| read(report, section.as_ref()?))
        .collect();
    read.into_iter().collect()
}

fn input(report: &mut FaultReport, section: &Section<'_>, roles: &mut Vec<Role>) -> Option<Input> {
    let stated: Vec<&str> = SOURCE_KEYS
        .into_iter()
        .filter(|key| section.get(key).is_some())
        .collect();
    let [kind] = stated.as_slice() else {
        let message = match stated.as_slice() {
            [] => "says not where its numbers come from".to_owned(),
            many => format!("has {}", quote_all(many.iter().copied())),
        };
        section
            .fault(report, &section.span, message)
            .advise(format!("state one of {}", quote_all(SOURCE_KEYS)));
        return None;
    };
    let own: &[&str] = match *kind {
        "field" => &["field", "count"],
        "rays" => &["rays", "count", "from_deg", "to_deg", "unknown"],
        "path" => &["path", "pose", "ahead", "reach"],
        "target" => &["target", "reach"],
        "pixels" => &["pixels", "width", "height", "colours", "white"],
        _ => &["command"],
    };
    section.refuse_unknown(report, &[own, &COMMON_KEYS].concat());
    let mut role = |report: &mut FaultReport, key: &str, kind: Kind| {
        let (label, _) = section.required(report, key, name)?;
        add_role(report, section, key, roles, &label, kind)
    };
    let metres = |node: &Node<'_>| within(node, 0.0, 1e4, "a distance in metres");
    let degrees = |node: &Node<'_>| within(node, -360.0, 360.0, "an angle in degrees");
    let counted = |node: &Node<'_>| whole(node, 1, MAX_COUNT);
    // Pixels have a scale for each channel, all others one for each number.
    let mut channels = None;
    let (source, count) = match *kind {
        "field" => {
            let (text, _) = section.required(report, "field", name)?;
            let (label, path) = text.split_once('.').unwrap_or((&text, ""));
            let role = add_role(report, section, "field", roles, label, Kind::Any);
            let count = section.optional(report, "count", 1, counted);
            (
                Source::Field {
                    role: role?,
                    path: path.to_owned(),
                },
                count?,
            )
        }
        "rays" => {
            let role = role(report, "rays", Kind::Scan);
            let count = section.required(report, "count", counted);
            let from = section.required(report, "from_deg", degrees);
            let to = section.required(report, "to_deg", degrees);
            let unknown = section.optional(report, "unknown", None, |node| metres(node).map(Some));
            let (from, to) = (from?.to_radians(), to?.to_radians());
            if from >= to || to - from > core::f64::consts::TAU + 1e-9 {
                let message = "must be more than `from_deg`, by 360 at most";
                report.fault(
                    &section.key_span("to_deg"),
                    format!("{} {message}", section.key("to_deg")),
                );
                return None;
            }
            (
                Source::Rays {
                    role: role?,
                    from,
                    to,
                    unknown: unknown?,
                },
                count?,
            )
        }
        "path" => {
            let (role_of, pose) = (
                role(report, "path", Kind::Path),
                role(report, "pose", Kind::Odometry),
            );
            let (ahead, reach) = (
                section.required(report, "ahead", metres),
                section.required(report, "reach", metres),
            );
            let (ahead, reach) = (ahead?, reach?);
            (
                Source::Path {
                    role: role_of?,
                    pose: pose?,
                    ahead,
                    reach,
                },
                2,
            )
        }
        "target" => {
            let (pose, reach) = (
                role(report, "target", Kind::Odometry),
                section.required(report, "reach", metres),
            );
            (
                Source::Target {
                    pose: pose?,
                    reach: reach?,
                },
                2,
            )
        }
        "pixels" => {
            let role = role(report, "pixels", Kind::Image);
            let side = |node: &Node<'_>| whole(node, 1, MAX_SIDE);
            let width = section.required(report, "width", side);
            let height = section.required(report, "height", side);
            let colours = section.required(report, "colours", colours);
            let white = section.required(report, "white", |node| {
                within(node, 1e-3, 1e3, "the number of white")
            });
            let (width, height, colours) = (width?, height?, colours?);
            let count = match colours {
                Colours::Grey => 1,
                Colours::Rgb => 3,
            };
            channels = Some((count, white?));
            (
                Source::Pixels {
                    role: role?,
                    width,
                    height,
                    colours,
                    white: white?,
                },
                count * width * height,
            )
        }
        _ => (Source::Command(section.required(report, "command", axis)?), 1),
    };
    let scale = match channels {
        None => scale(report, section, count),
        Some((channels, white)) => {
            scale(report, section, channels).map(|scale| scale.of_channels(count / channels, white))
        }
    };
    let stack = section.optional(report, "stack", 1, |node| whole(node, 1, MAX_STACK));
    let into = section.optional(report, "into", None, |node| name(node).map(Some));
    Some(Input {
        span: section.span.clone(),
        source,
        count,
        scale: scale?,
        stack: stack?,
        into: into?,
    })
}

/// Returns the number of a role, which the first mention adds.
fn add_role(
    report: &mut FaultReport,
    section: &Section<'_>,
    key: &str,
    roles: &mut Vec<Role>,
    label: &str,
    kind: Kind,
) -> Option<usize> {
    let Some(known) = roles.iter().position(|role| role.name == label) else {
        roles.push(Role {
            name: label.to_owned(),
            kind,
        });
        return Some(roles.len() - 1);
    };
    let role = &mut roles[known];
    if role.kind == Kind::Any {
        role.kind = kind;
    } else if kind != Kind::Any && role.kind != kind {
        let message = format!("{} is `{label}`, which is something else above", section.key(key));
        report.fault(&section.key_span(key), message);
        return None;
    }
    Some(known)
}

fn scale(report: &mut FaultReport, section: &Section<'_>, count: usize) -> Option<Scale> {
    let mut two = |key| section.optional(report, key, None, |node| pair(node).map(Some));
    let (limit, clip, range) = (two("limit"), two("clip"), two("range"));
    let list = |node: &Node<'_>| numbers(node, count).map(Some);
    let mean = section.optional(report, "mean", None, list);
    let std = section.optional(report, "std", None, |node| {
        let list = numbers(node, count)?;
        match list.iter().all(|std| *std > 0.0) {
            true => Ok(Some(list)),
            false => Err(WrongValue::new(node, "must be above 0")),
        }
    });
    let (limit, clip, range, mean, std) = (limit?, clip?, range?, mean?, std?);
    let normal = match (range, mean, std) {
        (None, None, None) => Normal::None,
        (Some((low, high)), None, None) => Normal::Range(low, high),
        (None, Some(mean), Some(std)) => Normal::Deviation { mean, std },
        _ => {
            let message = "has parts of two normalisations";
            section
                .fault(report, &section.span, message)
                .advise("state `range`, or both `mean` and `std`, or none of them");
            return None;
        }
    };
    Some(Scale { limit, normal, clip })
}

fn output(report: &mut FaultReport, section: &Section<'_>) -> Option<Output> {
    section.refuse_unknown(report, &["command", "of", "index", "bounds", "scale", "doc"]);
    let axis = section.required(report, "command", axis);
    let pick = pick(report, section);
    let bounds = section.required(report, "bounds", pair);
    let is_scaled = section.required(report, "scale", |node| match node.get_ref().as_str() {
        Some("bounds") => Ok(true),
        Some("none") => Ok(false),
        Some(other) => Err(WrongValue::unknown(node, other, "a scale", ["bounds", "none"])),
        None => Err(WrongValue::shape(
            node,
            "\"bounds\", if -1 and 1 of the network are the bounds, or \"none\"",
        )),
    });
    Some(Output {
        axis: axis?,
        pick: pick?,
        bounds: bounds?,
        is_scaled: is_scaled?,
    })
}

fn commands_once(report: &mut FaultReport, outputs: &[Output]) {
    for (index, output) in outputs.iter().enumerate() {
        if outputs[..index].iter().any(|before| before.axis == output.axis) {
            report.fault(
                &output.pick.span,
                "this output commands a number that another one commands",
            );
        }
    }
}

fn doubt(report: &mut FaultReport, root: &Section<'_>) -> Option<Doubt> {
    let section = root.nested(report, "doubt", &["of", "index", "kind", "certain", "unsure"])?;
    let kind = section.required(report, "kind", |node| match node.get_ref().as_str() {
        Some("spread") => Ok(DoubtKind::Spread),
        Some("number") => Ok(DoubtKind::Number),
        Some(other) => Err(WrongValue::unknown(
            node,
            other,
            "a kind of doubt",
            ["spread", "number"],
        )),
        None => Err(WrongValue::shape(node, "\"spread\" or \"number\"")),
    });
    let doubted = |node: &Node<'_>| within(node, 0.0, 1e9, "a doubt of 0 or more");
    let certain = section.required(report, "certain", doubted);
    let unsure = section.required(report, "unsure", doubted);
    let pick = pick(report, &section);
    let (certain, unsure) = (certain?, unsure?);
    if unsure <= certain {
        let message = format!("{} must be more than `certain`", section.key("unsure"));
        report.fault(&section.key_span("unsure"), message);
        return None;
    }
    Some(Doubt {
        pick: pick?,
        kind: kind?,
        certain,
        unsure,
    })
}

pub(crate) fn pick(report: &mut FaultReport, section: &Section<'_>) -> Option<Pick> {
    let of = section.optional(report, "of", None, |node| name(node).map(Some));
    let index = section.optional(report, "index", 0, |node| whole(node, 0, MAX_COUNT));
    Some(Pick {
        span: section.span.clone(),
        of: of?,
        index: index?,
    })
}

fn name(node: &Node<'_>) -> Checked<(String, Range<usize>)> {
    match node.get_ref().as_str() {
        Some(text) if !text.is_empty() => Ok((text.to_owned(), node.span())),
        _ => Err(WrongValue::shape(node, "a name")),
    }
}

fn colours(node: &Node<'_>) -> Checked<Colours> {
    match node.get_ref().as_str() {
        Some("grey") => Ok(Colours::Grey),
        Some("rgb") => Ok(Colours::Rgb),
        Some(other) => Err(WrongValue::unknown(
            node,
            other,
            "a kind of colours",
            ["grey", "rgb"],
        )),
        None => Err(WrongValue::shape(node, "\"grey\" or \"rgb\"")),
    }
}

fn axis(node: &Node<'_>) -> Checked<Axis> {
    let (text, _) = name(node)?;
    let known = COMMAND_AXES.iter().find(|(name, _)| *name == text);
    let names = COMMAND_AXES.iter().map(|(name, _)| *name);
    known
        .map(|(_, axis)| *axis)
        .ok_or_else(|| WrongValue::unknown(node, &text, "a number of a velocity", names))
}

pub(crate) fn within(node: &Node<'_>, least: f64, most: f64, expected: &str) -> Checked<f64> {
    match number(node.get_ref()) {
        Some(number) if (least..=most).contains(&number) => Ok(number),
        Some(number) => Err(WrongValue::new(
            node,
            format!("is {number}: expected {expected}, {least} to {most}"),
        )),
        None => Err(WrongValue::shape(node, expected)),
    }
}

pub(crate) fn whole(node: &Node<'_>, least: usize, most: usize) -> Checked<usize> {
    let stated = integer(node.get_ref()).and_then(|number| usize::try_from(number).ok());
    match stated {
        Some(number) if (least..=most).contains(&number) => Ok(number),
        _ => Err(WrongValue::new(
            node,
            format!("must be a whole number, {least} to {most}"),
        )),
    }
}

/// A number of a list; magnitudes beyond are mistakes, and would overflow 32 bits.
pub(crate) fn one(node: &Node<'_>) -> Checked<f64> {
    within(node, -1e9, 1e9, "a number")
}

fn pair(node: &Node<'_>) -> Checked<(f64, f64)> {
    match node.get_ref() {
        DeValue::Array(list) if list.len() == 2 => match (one(&list[0])?, one(&list[1])?) {
            (low, high) if low < high => Ok((low, high)),
            _ => Err(WrongValue::new(
                node,
                "must be the lower and then the higher number",
            )),
        },
        _ => Err(WrongValue::shape(node, "a list of two numbers")),
    }
}

/// One number for all, or one for each.
fn numbers(node: &Node<'_>, count: usize) -> Checked<Vec<f64>> {
    match node.get_ref() {
        DeValue::Array(list) if list.len() == count => list.iter().map(one).collect(),
        DeValue::Array(list) => Err(WrongValue::new(
            node,
            format!(
                "has {} numbers: expected {}",
                list.len(),
                quote(&count.to_string())
            ),
        )),
        _ => Ok(vec![one(node)?]),
    }
}
