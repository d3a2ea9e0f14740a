//! One step of a network: numbers in, a decision out, and what it remembers.

use jde_onnx::Network;

use crate::choices::ChosenBy;
use crate::file::{Doubt, Output};

/// What a network decided.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decision {
    /// Speeds ahead and to the left, m/s, and the turn rate, rad/s, within their bounds. Of a chunk, the first ones.
    pub command: [f64; 3],
    /// The number of the command among those that the file lists, from 0; `None` if it lists none.
    pub choice: Option<usize>,
    /// What the network expects of the future, if the file names it.
    pub value: Option<f64>,
    /// How unsure it is, in the unit of the file's `certain`; `None` if the file states no doubt.
    pub doubt: Option<f64>,
    /// How sure it is, from 0 to 1; 1 if the file states no doubt.
    pub certainty: f64,
}

impl Decision {
    /// Returns whether the policy does not know after it, by whether it did not know before.
    #[must_use]
    pub fn leaves_unsure(&self, was_unsure: bool) -> bool {
        match self.certainty {
            0.0 => true,
            1.0 => false,
            _ => was_unsure,
        }
    }
}

/// A network with what it remembers.
#[derive(Debug)]
pub struct Runner {
    pub(crate) network: Network,
    /// For each input of the file, the network's input and the first number there.
    pub(crate) places: Vec<(usize, usize, usize)>,
    /// For each number of a command, the network's output, and how many numbers of it are of one command.
    pub(crate) outputs: Vec<(Output, usize, usize)>,
    /// The commands among which the network chooses, the output that says what it chose, and how.
    pub(crate) choices: Option<(Vec<[f64; 3]>, usize, ChosenBy)>,
    /// What was decided last, in the order in which it is due.
    pub(crate) commands: Vec<[f64; 3]>,
    /// Inputs and outputs of the network that are its memory.
    pub(crate) memory: Vec<(usize, usize)>,
    pub(crate) value: Option<(usize, usize)>,
    pub(crate) scores: Option<usize>,
    /// The doubt, the output that shows it, and the numbers of one member.
    pub(crate) doubt: Option<(Doubt, usize, usize)>,
    /// The names of the outputs.
    pub(crate) names: Vec<String>,
}

impl Runner {
    /// Forgets what was before: the memory becomes zeros.
    pub fn reset(&mut self) {
        for (input, _) in &self.memory {
            self.network.input_mut(*input).fill(0.0);
        }
    }

    /// Returns what the network decides by an observation. What it remembers changes with each call.
    ///
    /// # Errors
    /// The network gave a number that is not finite, or it chose by one. What it remembered is forgotten then, because it may
    /// contain it.
    pub fn step(&mut self, observation: &[f32]) -> Result<Decision, String> {
        let mut from = 0;
        for (input, start, count) in &self.places {
            self.network.input_mut(*input)[*start..][..*count]
                .copy_from_slice(&observation[from..][..*count]);
            from += count;
        }
        let ran = self.network.run().map_err(|error| error.to_string());
        let decision = ran.and_then(|()| self.decide());
        match &decision {
            Ok(_) => {
                for (input, output) in self.memory.clone() {
                    let next = self.network.output(output).to_vec();
                    self.network.input_mut(input).copy_from_slice(&next);
                }
            }
            Err(_) => self.reset(),
        }
        decision
    }

    fn decide(&mut self) -> Result<Decision, String> {
        let used = (self.outputs.iter().map(|(_, output, _)| *output))
            .chain(self.choices.as_ref().map(|(_, output, _)| *output))
            .chain(self.memory.iter().map(|(_, output)| *output))
            .chain(self.value.map(|(output, _)| output))
            .chain(self.scores)
            .chain(self.doubt.as_ref().map(|(_, output, _)| *output));
        for output in used {
            if let Some(number) = self
                .network
                .output(output)
                .iter()
                .find(|number| !number.is_finite())
            {
                return Err(format!("the network gave {number} in `{}`", self.names[output]));
            }
        }
        for (output, of, width) in &self.outputs {
            let numbers = self.network.output(*of).chunks(*width);
            for (command, numbers) in self.commands.iter_mut().zip(numbers) {
                let number = f64::from(numbers[output.pick.index]);
                command[output.axis.index()] = output.command(number);
            }
        }
        let mut choice = None;
        if let Some((commands, output, chosen_by)) = &self.choices {
            let chosen = chosen_by.chosen(self.network.output(*output));
            let command = commands.get(chosen);
            self.commands[0] =
                *command.ok_or_else(|| format!("the network chose {chosen}, which is none"))?;
            choice = Some(chosen);
        }
        let doubt = self
            .doubt
            .as_ref()
            .map(|(doubt, output, width)| doubt.of(self.network.output(*output), *width));
        let certainty = self.doubt.as_ref().zip(doubt);
        Ok(Decision {
            command: self.commands[0],
            choice,
            value: self
                .value
                .map(|(output, index)| f64::from(self.network.output(output)[index])),
            doubt,
            certainty: certainty.map_or(1.0, |((of, ..), doubt)| of.certainty(doubt)),
        })
    }

    /// Returns what the last step decided, in the order in which it is due: one command, or those of a chunk.
    #[must_use]
    pub fn commands(&self) -> &[[f64; 3]] {
        &self.commands
    }

    /// Returns the SHA-256 of the network, in hexadecimal digits.
    #[must_use]
    pub fn hash(&self) -> &str {
        self.network.hash()
    }

    /// Returns the scores of the last step; none if the file names none.
    #[must_use]
    pub fn scores(&self) -> &[f32] {
        self.scores.map_or(&[], |output| self.network.output(output))
    }
}
