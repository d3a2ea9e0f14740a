//! Choices in the text file: the commands among which a network chooses, by a score for each of them or by the number of one.

use jde_document::section::table;
use jde_document::{FaultReport, Section, WrongValue, quote};
use jde_onnx::Port;

use crate::file::{Pick, PolicyFile};
use crate::read::{one, pick};

/// The most commands among which a network chooses.
const MAX_CHOICES: usize = 1000;

/// The commands among which a network chooses.
#[derive(Clone, Debug)]
pub(crate) struct Choices {
    pub(crate) pick: Pick,
    /// Ahead and to the left, m/s, and the turn rate, rad/s.
    pub(crate) commands: Vec<[f64; 3]>,
}

/// How a network says what it chose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ChosenBy {
    /// By a score for each command.
    Scores,
    /// By the number of the command.
    Number,
}

/// Reads the table.
pub(crate) fn read(report: &mut FaultReport, root: &Section<'_>) -> Option<Choices> {
    let section = root.nested(report, "choices", &["of", "commands"])?;
    let pick = pick(report, &section);
    let list = section.required(report, "commands", |node| match node.get_ref().as_array() {
        Some(list) if (2..=MAX_CHOICES).contains(&list.len()) => Ok(list),
        _ => Err(WrongValue::new(
            node,
            format!("must be a list of 2 to {MAX_CHOICES} commands, such as {{ linear.x = 0.2 }}"),
        )),
    })?;
    let commands: Vec<Option<[f64; 3]>> = list
        .iter()
        .enumerate()
        .map(|(number, node)| {
            let section = table(report, node, "command", number)?;
            command(report, &section)
        })
        .collect();
    Some(Choices {
        pick: pick?,
        commands: commands.into_iter().collect::<Option<_>>()?,
    })
}

/// What a command does not state is 0.
fn command(report: &mut FaultReport, section: &Section<'_>) -> Option<[f64; 3]> {
    section.refuse_unknown(report, &["linear", "angular"]);
    let mut of = |part: &str, keys: &[&str]| {
        let Some(_) = section.get(part) else {
            return Some(vec![0.0; keys.len()]);
        };
        let part = section.nested(report, part, keys)?;
        keys.iter()
            .map(|key| part.optional(report, key, 0.0, one))
            .collect::<Option<Vec<f64>>>()
    };
    let (linear, angular) = (of("linear", &["x", "y"]), of("angular", &["z"]));
    let (linear, angular) = (linear?, angular?);
    Some([linear[0], linear[1], angular[0]])
}

/// A network that chooses gives no other commands.
pub(crate) fn check(report: &mut FaultReport, root: &Section<'_>, file: &PolicyFile) {
    if file.choices.is_none() {
        return;
    }
    if let Some(output) = file.outputs.first() {
        report
            .fault(
                &output.pick.span,
                "this output commands what [choices] commands too",
            )
            .advise("state the commands in [choices], or the bounds of numbers in [[output]]");
    }
    if file.chunk.is_some() {
        report.fault(
            &root.key_span("chunk"),
            "a network that makes chunks gives numbers of [[output]], and no [choices]",
        );
    }
}

impl Choices {
    /// Returns how the network says what it chose.
    pub(crate) fn chosen_by(&self, report: &mut FaultReport<'_>, port: &Port) -> Option<ChosenBy> {
        let (name, listed) = (quote(&port.name), self.commands.len());
        let (message, chosen_by) = match port.chosen_among {
            Some(among) if port.count() != 1 || among != listed => (
                format!(
                    "{name} has {} numbers of choices among {among}, and the file lists {listed} commands",
                    port.count()
                ),
                ChosenBy::Number,
            ),
            Some(_) => return Some(ChosenBy::Number),
            None if port.count() != listed => (
                format!(
                    "{name} has {} scores, of the shape {:?}, and the file lists {listed} commands",
                    port.count(),
                    port.shape
                ),
                ChosenBy::Scores,
            ),
            None => return Some(ChosenBy::Scores),
        };
        report.fault(&self.pick.span, message).advise(match chosen_by {
            ChosenBy::Scores => "list a command for each score, in their order",
            ChosenBy::Number => "list as many commands as the policy was trained with, in their order",
        });
        None
    }

    /// Returns the number of a command that is nearest to another, each speed as a share of the difference between the least
    /// and the greatest that is listed.
    pub(crate) fn nearest(&self, command: [f64; 3]) -> usize {
        let range = |axis: usize| {
            let speeds = || self.commands.iter().map(|listed| listed[axis]);
            speeds().fold(f64::MIN, f64::max) - speeds().fold(f64::MAX, f64::min)
        };
        let ranges = [range(0), range(1), range(2)];
        let far = |listed: &[f64; 3]| -> f64 {
            (0..3)
                .filter(|axis| ranges[*axis] > 0.0)
                .map(|axis| ((listed[axis] - command[axis]) / ranges[axis]).powi(2))
                .sum()
        };
        let distances = self.commands.iter().map(far).enumerate();
        distances
            .min_by(|(_, a), (_, b)| a.total_cmp(b))
            .map_or(0, |(number, _)| number)
    }
}

impl ChosenBy {
    /// Returns the number of what finite numbers choose: the highest score, and of equal ones the first.
    pub(crate) fn chosen(self, numbers: &[f32]) -> usize {
        match self {
            Self::Number => numbers[0] as usize,
            Self::Scores => {
                (1..numbers.len()).fold(0, |best, at| if numbers[at] > numbers[best] { at } else { best })
            }
        }
    }
}
