//! Chunks in the text file: how many commands a network gives at once, and when they are due. It makes none.

use jde_document::{FaultReport, Section, quote};
use jde_onnx::Port;

use crate::file::{Input, Pick, PolicyFile, Source};
use crate::read::{whole, within};

/// The most commands of a chunk: those of a `Chunk`. The shortest time between two, and the longest chunk, s: what was seen
/// longer ago says nothing of what to do now.
const MAX_STEPS: usize = 128;
const MIN_SPACING: f64 = 0.001;
const MAX_CHUNK: f64 = 10.0;

/// The commands that a network gives at once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChunkRule {
    /// How many they are.
    pub steps: usize,
    /// The time from one to the next, s.
    pub spacing: f64,
    /// The weight of each chunk in a blend, as a share of the weight of the chunk before it. `None` if a new chunk replaces
    /// the one before.
    pub blend: Option<f64>,
}

/// Reads the table.
pub(crate) fn read(report: &mut FaultReport, root: &Section<'_>) -> Option<ChunkRule> {
    let section = root.nested(report, "chunk", &["steps", "spacing", "blend"])?;
    let steps = section.required(report, "steps", |node| whole(node, 1, MAX_STEPS));
    let spacing = section.required(report, "spacing", |node| {
        let expected = "the time from one command to the next in seconds";
        within(node, MIN_SPACING, MAX_CHUNK, expected)
    });
    let blend = section.optional(report, "blend", None, |node| {
        within(
            node,
            1e-3,
            1.0,
            "the weight of a chunk as a share of that of the one before",
        )
        .map(Some)
    });
    let rule = ChunkRule {
        steps: steps?,
        spacing: spacing?,
        blend: blend?,
    };
    let lasts = rule.steps as f64 * rule.spacing;
    if lasts > MAX_CHUNK {
        let message = format!("a chunk lasts {lasts} s, and {MAX_CHUNK} s is the most");
        report.fault(&section.key_span("spacing"), message);
        return None;
    }
    Some(rule)
}

/// A chunk must last until the next one, and its network sees none of its commands.
pub(crate) fn check(report: &mut FaultReport, root: &Section<'_>, file: &PolicyFile) {
    let Some(rule) = file.chunk else { return };
    let lasts = rule.steps as f64 * rule.spacing;
    if lasts < file.period {
        let period = file.period;
        let message = format!("a chunk lasts {lasts} s, and the next one is made after {period} s");
        report
            .fault(&root.key_span("chunk"), message)
            .advise("state more steps, or a shorter `period`");
    }
    let is_command = |input: &&Input| matches!(input.source, Source::Command(_));
    for input in file.inputs.iter().filter(is_command) {
        report
            .fault(
                &input.span,
                "a network that makes chunks does not see the last command",
            )
            .advise("give it the variable `step` of policy/steps, as `field = \"step.command.linear.x\"`");
    }
}

/// Returns how many numbers of an output are of one command of a chunk: all without chunks.
pub(crate) fn width(
    report: &mut FaultReport<'_>,
    chunk: Option<ChunkRule>,
    pick: &Pick,
    port: &Port,
) -> Option<usize> {
    let Some(ChunkRule { steps, .. }) = chunk else {
        return Some(port.count());
    };
    let width = port.shape.last().copied().unwrap_or(1);
    if port.count() != steps * width {
        let message = format!(
            "{} has the shape {:?}: expected a row for each of {steps} steps",
            quote(&port.name),
            port.shape
        );
        report.fault(&pick.span, message);
        return None;
    }
    if pick.index >= width {
        let message = format!(
            "the network's {} has {width} numbers for a step, and none at {}",
            quote(&port.name),
            pick.index
        );
        report.fault(&pick.span, message);
        return None;
    }
    Some(width)
}
