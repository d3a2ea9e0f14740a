//! A policy: its text file together with its network, checked as one.

use std::path::{Path, PathBuf};

use jde_abi::describe::Type;
use jde_document::{FaultReport, Faults, Section, parse, quote, quote_all};
use jde_onnx::{Network, Port};

use crate::choices::Choices;
use crate::chunk::{self, ChunkRule};
use crate::file::{Doubt, DoubtKind, Pick, PolicyFile};
use crate::observe::Observer;
use crate::runner::Runner;
use crate::{file, read};

/// A policy that was read, without what it has seen.
#[derive(Debug)]
pub struct Policy {
    file: PolicyFile,
}

/// The name of an input or an output in the text file, and its place there.
type Named = (String, std::ops::Range<usize>);

impl Policy {
    /// Reads a text file alone, as training does before there is a network.
    ///
    /// # Errors
    /// All faults of the file, with their lines.
    pub fn load_text(path: &Path) -> Result<Self, Faults> {
        Self::with_report(path, |_, file| Some(file)).map(|file| Self { file })
    }

    /// Reads a text file and its network.
    ///
    /// # Errors
    /// All faults of the file, or the fault of the network, or what of one does not fit the other, with their lines.
    pub fn load(path: &Path) -> Result<(Self, Runner), Faults> {
        let (file, runner) = Self::with_report(path, |report, file| {
            let network = Network::load(&network_path(path, &file.network));
            let key = &file.network_span;
            let network = network
                .map_err(|error| _ = report.fault(key, error.to_string()))
                .ok()?;
            let runner = connect(report, &file, network)?;
            Some((file, runner))
        })?;
        Ok((Self { file }, runner))
    }

    fn with_report<T>(
        path: &Path,
        then: impl FnOnce(&mut FaultReport<'_>, PolicyFile) -> Option<T>,
    ) -> Result<T, Faults> {
        let text = jde_document::read(path, "the text file of a policy")?;
        let mut report = FaultReport::new(path, &text);
        let read = parse(&mut report, &text).and_then(|document| {
            let root = Section::new("the policy", 0..0, document.get_ref());
            read::read(&mut report, &root).and_then(|file| then(&mut report, file))
        });
        match (read, report.count()) {
            (Some(read), 0) => Ok(read),
            _ => Err(report.into_faults()),
        }
    }

    /// Returns the names of the variables that an application binds, in their order.
    pub fn roles(&self) -> impl ExactSizeIterator<Item = &str> {
        self.file.roles.iter().map(|role| role.name.as_str())
    }

    /// Returns the time of a step, s.
    #[must_use]
    pub fn period(&self) -> f64 {
        self.file.period
    }

    /// Whether it sees the target that its father states.
    #[must_use]
    pub fn sees_target(&self) -> bool {
        let is_target = |input: &file::Input| matches!(input.source, file::Source::Target { .. });
        self.file.inputs.iter().any(is_target)
    }

    /// Returns what is stated of the commands that its network gives at once; `None` if it gives one.
    #[must_use]
    pub fn chunk(&self) -> Option<ChunkRule> {
        self.file.chunk
    }

    /// Whether it commands anything.
    #[must_use]
    pub fn commands(&self) -> bool {
        !self.file.outputs.is_empty() || self.file.choices.is_some()
    }

    /// Returns among how many commands its network chooses; `None` if it gives numbers of a command.
    #[must_use]
    pub fn choices(&self) -> Option<usize> {
        self.file.choices.as_ref().map(|choices| choices.commands.len())
    }

    /// Returns the least and the greatest number of the network for each number that it commands; none if it chooses.
    #[must_use]
    pub fn action_bounds(&self) -> Vec<(f32, f32)> {
        self.file.outputs.iter().map(file::Output::range).collect()
    }

    /// Returns the command for numbers of a network, in the order of the file's outputs, or for the number of a choice: ahead,
    /// to the left, and the turn rate. It stands for a number that is no choice.
    #[must_use]
    pub fn command(&self, action: &[f64]) -> [f64; 3] {
        if let Some(choices) = &self.file.choices {
            let chosen = action.first().filter(|number| **number >= 0.0);
            let chosen = chosen.and_then(|number| choices.commands.get(*number as usize));
            return chosen.copied().unwrap_or_default();
        }
        let mut command = [0.0; 3];
        for (output, number) in self.file.outputs.iter().zip(action) {
            command[output.axis.index()] = output.command(*number);
        }
        command
    }

    /// Returns the numbers of a network that would have given a command, or the number of the choice that is nearest to it.
    #[must_use]
    pub fn action(&self, command: [f64; 3]) -> Vec<f64> {
        if let Some(choices) = &self.file.choices {
            return vec![choices.nearest(command) as f64];
        }
        let outputs = self.file.outputs.iter();
        outputs
            .map(|output| output.number(command[output.axis.index()]))
            .collect()
    }

    /// Returns what turns values into numbers, for variables of these types, in the order of the roles.
    ///
    /// # Errors
    /// Each role whose variable does not fit, with what is wrong.
    pub fn observer(&self, types: &[&Type]) -> Result<Observer, Vec<(String, String)>> {
        Observer::new(&self.file, types)
    }
}

/// A path is relative to the text file.
fn network_path(file: &Path, network: &str) -> PathBuf {
    file.parent().unwrap_or(Path::new("")).join(network)
}

/// Finds the inputs and outputs that the file names in the network.
fn connect(report: &mut FaultReport<'_>, file: &PolicyFile, network: Network) -> Option<Runner> {
    let (inputs, outputs): (Vec<Port>, Vec<Port>) = (
        network.inputs().cloned().collect(),
        network.outputs().cloned().collect(),
    );
    let key = &file.network_span;
    let memory: Vec<Option<(usize, usize)>> = file
        .memory
        .iter()
        .map(|memory| {
            let input = find(report, &inputs, Some(&memory.input), key, "input");
            let output = find(report, &outputs, Some(&memory.output), key, "output");
            let (input, output) = (input?, output?);
            let (from, to) = (&outputs[output].shape, &inputs[input].shape);
            if from != to {
                let message = format!(
                    "{} has the shape {from:?}, and {} {to:?}",
                    quote(&memory.output.0),
                    quote(&memory.input.0)
                );
                report.fault(&memory.output.1, message);
                return None;
            }
            Some((input, output))
        })
        .collect();
    let memory: Vec<(usize, usize)> = memory.into_iter().collect::<Option<_>>()?;
    let seen: Vec<Port> = inputs
        .iter()
        .enumerate()
        .filter(|(index, _)| memory.iter().all(|(input, _)| input != index))
        .map(|(_, port)| port.clone())
        .collect();
    let mut filled = vec![0; inputs.len()];
    let mut places = Vec::new();
    for input in &file.inputs {
        let place = find(report, &seen, input.into.as_ref(), &input.span, "input")?;
        let place = inputs.iter().position(|port| port.name == seen[place].name)?;
        let count = input.count * input.stack;
        check_picture(report, input, &inputs[place]);
        places.push((place, filled[place], count));
        filled[place] += count;
    }
    for (port, filled) in inputs.iter().zip(&filled).filter(|(port, _)| seen.contains(port)) {
        if port.count() != *filled {
            let message = format!(
                "the network takes {} numbers in {}, of the shape {:?}, and the file gives {filled}",
                port.count(),
                quote(&port.name),
                port.shape
            );
            report
                .fault(key, message)
                .advise("count the numbers of each [[input]], times its `stack`");
        }
    }
    let picked = |report: &mut FaultReport<'_>, pick: &Pick, is_one: bool| {
        let output = find(report, &outputs, pick.of.as_ref(), &pick.span, "output")?;
        let count = outputs[output].count();
        if outputs[output].chosen_among.is_some() {
            let message = format!(
                "the network's {} is the number of a choice",
                quote(&outputs[output].name)
            );
            let fault = report.fault(&pick.span, message);
            fault.advise("state the commands among which it chooses, in [choices]");
            return None;
        }
        if count == 0 || is_one && pick.index >= count {
            let message = format!(
                "the network's {} has {count} numbers, and none at {}",
                quote(&outputs[output].name),
                pick.index
            );
            report.fault(&pick.span, message);
            return None;
        }
        Some(output)
    };
    let commands: Vec<Option<_>> = file
        .outputs
        .iter()
        .map(|output| {
            let of = picked(report, &output.pick, true)?;
            let width = chunk::width(report, file.chunk, &output.pick, &outputs[of])?;
            Some((output.clone(), of, width))
        })
        .collect();
    let choices = file.choices.as_ref().map(|choices| {
        let Choices { pick, commands } = choices;
        let output = find(report, &outputs, pick.of.as_ref(), &pick.span, "output")?;
        let chosen_by = choices.chosen_by(report, &outputs[output])?;
        Some((commands.clone(), output, chosen_by))
    });
    let value = file
        .value
        .as_ref()
        .map(|pick| picked(report, pick, true).map(|output| (output, pick.index)));
    let scores = file.scores.as_ref().map(|pick| picked(report, pick, false));
    let doubt = file.doubt.as_ref().map(|doubt| {
        let output = picked(report, &doubt.pick, doubt.kind == DoubtKind::Number)?;
        let width = members(report, doubt, &outputs[output])?;
        Some((doubt.clone(), output, width))
    });
    let none_missing = report.count() == 0;
    none_missing.then_some(Runner {
        names: outputs.iter().map(|port| port.name.clone()).collect(),
        network,
        places,
        outputs: commands.into_iter().flatten().collect(),
        commands: vec![[0.0; 3]; file.chunk.map_or(1, |chunk| chunk.steps)],
        choices: choices.flatten(),
        memory,
        value: value.flatten(),
        scores: scores.flatten(),
        doubt: doubt.flatten(),
    })
}

/// Reports a picture whose sides or channels are in another place, which as many numbers would hide.
fn check_picture(report: &mut FaultReport<'_>, input: &file::Input, port: &Port) {
    let file::Source::Pixels { width, height, .. } = input.source else {
        return;
    };
    let given = [input.count * input.stack / (width * height), height, width];
    if port.shape.len() > 2 && !port.shape.ends_with(&given) {
        let message = format!(
            "the network takes {}, of the shape {:?}, and the file gives {given:?}: channels, height, width",
            quote(&port.name),
            port.shape
        );
        report.fault(&input.span, message).advise(
            "state its `width`, `height`, `colours` and `stack`; export a network with the channels first",
        );
    }
}

/// Returns how many numbers each member of an ensemble gives.
fn members(report: &mut FaultReport<'_>, doubt: &Doubt, port: &Port) -> Option<usize> {
    let width = port.shape.last().copied().unwrap_or(1);
    if doubt.kind == DoubtKind::Spread && port.count() / width.max(1) < 2 {
        let message = format!(
            "{} has the shape {:?}: expected a row for each of several members",
            quote(&port.name),
            port.shape
        );
        report.fault(&doubt.pick.span, message);
        return None;
    }
    Some(width)
}

/// Returns the input or output of a name; without one, the only one there is.
fn find(
    report: &mut FaultReport<'_>,
    ports: &[Port],
    named: Option<&Named>,
    span: &std::ops::Range<usize>,
    what: &str,
) -> Option<usize> {
    let names = || ports.iter().map(|port| port.name.as_str());
    match (named, ports) {
        (None, [_]) => Some(0),
        (None, _) => {
            let key = if what == "input" { "into" } else { "of" };
            let message = format!(
                "the network has {} {what}s, so `{key}` must name one: {}",
                ports.len(),
                quote_all(names())
            );
            report.fault(span, message);
            None
        }
        (Some((name, span)), _) => {
            let found = ports.iter().position(|port| port.name == *name);
            if found.is_none() {
                let message = format!("the network has no {what} {}", quote(name));
                report.fault(span, message).suggest(name, "it has", names());
            }
            found
        }
    }
}
