//! What must hold, and what is measured.

use std::collections::BTreeSet;

use jde_document::section::{expect, number};
use jde_document::{FaultReport, Section, Text, WordOrTable, quote};

use super::Subject;
use super::expressions::Expressions;
use super::values::moment;
use crate::drive::measure::{Measure, Reduction};
use crate::drive::motion::{MotionMeasure, RobotMotion};
use crate::drive::property::{Property, PropertyKind};
use crate::drive::values::robots;
use crate::result::{Columns, FIXED, MeasureColumn};

/// What an experiment judges and measures.
#[derive(Default)]
pub(super) struct Judged {
    pub(super) properties: Properties,
    pub(super) measures: Measures,
}

#[derive(Default)]
pub(super) struct Properties {
    pub(super) names: Vec<String>,
    pub(super) list: Vec<Property>,
}

#[derive(Default)]
pub(super) struct Measures {
    pub(super) columns: Vec<MeasureColumn>,
    pub(super) list: Vec<Measure>,
}

/// The forms of a property, for messages.
const FORMS: &str =
    "give it `always`, `never` or `eventually`; `within`, `of` and `holds`; or `until` and `holds`";
/// The speed of the BARN challenge's optimal time, m/s.
const BARN_SPEED: f64 = 2.0;

/// Reads `must` and `measure`.
pub(super) fn read(
    report: &mut FaultReport,
    root: &Section,
    subject: &Subject<'_>,
    expressions: &mut Expressions,
) -> Judged {
    let mut judged = Judged::default();
    if let Some(must) = root.section(report, "must", "`must`") {
        for (name, _) in must.entries() {
            let what = format!("property {}", quote(name.text));
            let Some(section) = must.section(report, name.text, what) else {
                continue;
            };
            if let Some(property) = property(report, &section, subject, expressions) {
                judged.properties.names.push(name.text.to_owned());
                judged.properties.list.push(property);
            }
        }
    }
    if let Some(section) = root.section(report, "measure", "`measure`") {
        for (name, _) in section.entries() {
            if let Some((measure, unit)) = measure(report, &section, &name, subject, expressions) {
                let name = name.text.to_owned();
                judged.measures.columns.push(MeasureColumn { name, unit });
                judged.measures.list.push(measure);
            }
        }
    }
    judged
}

/// Reports names that stand for two columns.
pub(super) fn refuse_equal_columns(report: &mut FaultReport, root: &Section, columns: &Columns) {
    let mut known: BTreeSet<&str> = FIXED.into_iter().collect();
    let measures = columns.measures.iter().map(|measure| &measure.name);
    let named = [
        ("axes", columns.axes.iter().collect::<Vec<_>>()),
        ("must", columns.properties.iter().collect()),
        ("measure", measures.collect()),
    ];
    for (key, names) in named {
        for name in names {
            if !known.insert(name) {
                let span = root.entry_span(key, name);
                report
                    .fault(&span, format!("results have a column {} already", quote(name)))
                    .advise("give it another name");
            }
        }
    }
}

fn property(
    report: &mut FaultReport,
    section: &Section,
    subject: &Subject<'_>,
    expressions: &mut Expressions,
) -> Option<Property> {
    section.refuse_unknown(
        report,
        &[
            "always",
            "never",
            "eventually",
            "within",
            "of",
            "holds",
            "until",
            "from",
        ],
    );
    let from = section
        .get("from")
        .and_then(|node| moment(report, &section.key("from"), node));
    let has = |key: &str| section.get(key).is_some();
    let forms = ["always", "never", "eventually", "within", "until"];
    let given: Vec<_> = forms.into_iter().filter(|form| has(form)).collect();
    let [form] = given.as_slice() else {
        let how = if given.is_empty() {
            "says nothing"
        } else {
            "says several things"
        };
        report
            .fault(&section.span, format!("{} {how}", section.label))
            .advise(FORMS);
        return None;
    };
    let mut condition = |report: &mut FaultReport, key: &str| {
        if !has(key) {
            report
                .fault(&section.span, format!("{} has no `{key}`", section.label))
                .advise(FORMS);
            return None;
        }
        let text = section.text(report, key)?;
        Some((
            expressions.condition(report, subject, &text)?,
            text.text.trim().to_owned(),
        ))
    };
    let (kind, text) = match *form {
        "always" => condition(report, "always").map(|(place, text)| (PropertyKind::Always(place), text))?,
        "never" => condition(report, "never").map(|(place, text)| (PropertyKind::Never(place), text))?,
        "eventually" => {
            condition(report, "eventually").map(|(place, text)| (PropertyKind::Eventually(place), text))?
        }
        "within" => {
            let (of, holds) = (condition(report, "of"), condition(report, "holds"));
            let node = section.get("within")?;
            let time = moment(report, &section.key("within"), node);
            let ((of, _), (holds, text), time) = (of?, holds?, time?);
            (PropertyKind::Within { time, of, holds }, text)
        }
        _ => {
            let (until, holds) = (condition(report, "until"), condition(report, "holds"));
            let ((until, _), (holds, text)) = (until?, holds?);
            (PropertyKind::Until { until, holds }, text)
        }
    };
    Some(Property {
        kind,
        text,
        from: from.unwrap_or(0),
    })
}

fn measure(
    report: &mut FaultReport,
    section: &Section,
    name: &Text,
    subject: &Subject<'_>,
    expressions: &mut Expressions,
) -> Option<(Measure, String)> {
    const EXPECTED: &str =
        "a ready-made measure such as \"time\", or a reduction such as { min = \"clearance\" }";
    let table = match section.word_or_table(report, name.text, EXPECTED)? {
        WordOrTable::Word(word) => {
            let (measure, unit) = ready(report, &word, subject, 0, None)?;
            return Some((measure, unit.to_owned()));
        }
        WordOrTable::Table(table) => table,
    };
    let unit = table.text(report, "unit").map(|unit| unit.text.to_owned());
    if let Some(word) = table.text(report, "ready") {
        table.refuse_unknown(report, &["ready", "robot", "unit", "speed", "length"]);
        let robot = robot(report, &table, subject)?;
        let (measure, own) = ready(report, &word, subject, robot, Some(&table))?;
        return Some((measure, unit.unwrap_or_else(|| own.to_owned())));
    }
    let keys = Reduction::KEYS.map(|(key, _)| key);
    table.refuse_unknown(report, &[&keys[..], &["unit", "ready"]].concat());
    let given: Vec<_> = Reduction::KEYS
        .into_iter()
        .filter(|(key, _)| table.get(key).is_some())
        .collect();
    let [(key, reduction)] = given.as_slice() else {
        report
            .fault(
                &name.span,
                format!("measure {} needs one reduction", quote(name.text)),
            )
            .advise(format!("write one of {}", keys.join(", ")));
        return None;
    };
    let text = table.text(report, key)?;
    let place = match reduction {
        Reduction::Count | Reduction::TimeOf | Reduction::Share => {
            expressions.condition(report, subject, &text)
        }
        Reduction::Last | Reduction::Min | Reduction::Max | Reduction::Mean | Reduction::Integral => {
            expressions.any(report, subject, &text)
        }
    }?;
    let own = if *reduction == Reduction::TimeOf { "s" } else { "" };
    Some((
        Measure::Reduced(*reduction, place),
        unit.unwrap_or_else(|| own.to_owned()),
    ))
}

/// Returns the place of the robot that a measure names; of the first if it names none.
fn robot(report: &mut FaultReport, table: &Section, subject: &Subject<'_>) -> Option<usize> {
    let Some(name) = table.text(report, "robot") else {
        return table.get("robot").is_none().then_some(0);
    };
    let known = robots(subject.application);
    let place = known.iter().position(|robot| robot.owner == name.text);
    if place.is_none() {
        report
            .fault(&name.span, format!("no robot is called {}", quote(name.text)))
            .suggest(
                name.text,
                "robots",
                known.iter().map(|robot| robot.owner.as_str()),
            );
    }
    place
}

fn ready(
    report: &mut FaultReport,
    word: &Text,
    subject: &Subject<'_>,
    robot: usize,
    table: Option<&Section>,
) -> Option<(Measure, &'static str)> {
    if word.text == "time" {
        return Some((Measure::Time, "s"));
    }
    let plain = RobotMotion::READY
        .into_iter()
        .find(|(name, _)| *name == word.text);
    let motion = match plain {
        Some((_, motion)) => motion,
        None if word.text == "barn" => {
            let positive = |report: &mut FaultReport, key: &str| {
                let (section, node) = (table?, table?.get(key)?);
                let number = number(node.get_ref()).filter(|number| *number > 0.0);
                expect(report, &section.key(key), "a number above 0", node, number)
            };
            MotionMeasure::Barn {
                speed: positive(report, "speed").unwrap_or(BARN_SPEED),
                length: positive(report, "length"),
            }
        }
        None => {
            let known = RobotMotion::READY
                .into_iter()
                .map(|(name, _)| name)
                .chain(["time", "barn"]);
            report
                .fault(
                    &word.span,
                    format!("no ready-made measure is called {}", quote(word.text)),
                )
                .suggest(word.text, "ready-made measures", known);
            return None;
        }
    };
    if robots(subject.application).is_empty() {
        report
            .fault(
                &word.span,
                format!("{} needs the true state of a robot", quote(word.text)),
            )
            .advise("only a simulated robot exports it");
        return None;
    }
    let unit = match motion {
        MotionMeasure::Distance | MotionMeasure::Clearance => "m",
        MotionMeasure::Smoothness => "m/s3",
        MotionMeasure::Energy => "J",
        MotionMeasure::Spl | MotionMeasure::Barn { .. } => "",
    };
    Some((Measure::Motion(motion, robot), unit))
}
