//! The motor schema that drives by chunks: it gives each of their commands when it comes due. It makes no chunk, and the
//! guards of its groups judge what it commands.

use std::collections::VecDeque;

use jde_schema::prelude::*;
use jde_schema::types::{Chunk, ChunkStep};

/// The most chunks before the newest that have a share in a command.
pub(crate) const MOST_BLENDED: u32 = 31;
/// The shortest time from one command to the next, s.
const SHORTEST_SPACING: f64 = 0.001;
/// The longest chunk, s: what was seen longer ago says nothing of what to do now.
const LONGEST: f64 = 10.0;

/// Drives by chunks: commands of the near future that another schema makes, of policy/chunks or of its own kind.
///
/// It gives each command when it comes due, in each iteration until the next one is due. It is ready while a command of the
/// newest chunk is due and the maker of the chunk is sure at all; its urgency is how sure. A chunk that is no chunk is refused
/// in words. A chunk of before the end of its authority is void (R7), whatever is left of it.
#[derive(Describe)]
#[schema(motor, period = "20ms", budget = "5ms")]
pub struct Steps {
    /// The commands that come due, and when. The time of the value is that at which the first one is due.
    #[import]
    chunk: Import<Chunk>,
    /// Speeds of the base.
    #[actuator]
    base: Actuator<Twist>,
    /// The command that came due, which of the chunk it is, and how old the chunk was.
    #[export]
    step: Export<ChunkStep>,
    /// The newest chunk, after those before it with which it is blended.
    chunks: VecDeque<Dated>,
    decided: Decided,
}

/// A chunk with its number and its time.
struct Dated {
    number: u64,
    time: Duration,
    chunk: Box<Chunk>,
}

/// What is due, or why nothing is.
struct Decided(Result<ChunkStep, String>);

impl Default for Decided {
    fn default() -> Self {
        Self(Err("it has not looked yet".to_owned()))
    }
}

impl Schema for Steps {
    fn awake(&mut self, _: &Context) -> Result {
        self.chunks.clear();
        self.decided = Decided::default();
        Ok(())
    }

    fn check(&mut self, cx: &Context) -> Result<Precondition> {
        let decided = self.decide(cx);
        if let Err(words) = &decided
            && self.decided.0.as_ref() != Err(words)
        {
            info!(cx, "it commands nothing: {words}");
        }
        self.decided = Decided(decided);
        let certainty = self.chunks.back().map_or(0.0, |newest| newest.chunk.certainty);
        Ok(Precondition::from(self.decided.0.is_ok()).urgency(certainty))
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        match &self.decided.0 {
            Ok(step) => {
                // Before the command, so that it also shows what a guard refuses.
                self.step.write(cx, *step);
                self.base.command(cx, step.command);
            }
            Err(_) => {
                self.step.retract(cx);
                self.base.command(cx, Twist::ZERO);
            }
        }
        Ok(())
    }
}

impl Steps {
    /// Returns the command that is due, or why none is.
    fn decide(&mut self, cx: &Context) -> Result<ChunkStep, String> {
        let Some(newest) = self.chunk.get(cx) else {
            // It has none yet, it has ended, or it is void with what was made of those before (R7).
            self.chunks.clear();
            return Err("there is no chunk".to_owned());
        };
        let (number, now) = (newest.sequence(), cx.now());
        if self.chunks.back().is_none_or(|known| known.number != number) {
            let dated = Dated {
                number,
                time: newest.time(),
                chunk: Box::new(*newest),
            };
            if let Err(words) = dated.check(now) {
                self.chunks.clear();
                return Err(format!("chunk {number} is refused: {words}"));
            }
            let first = number.saturating_sub(newest.blended.min(MOST_BLENDED).into());
            self.chunks.retain(|before| before.number >= first);
            self.chunks.push_back(dated);
        }
        self.step(now)
    }

    /// Returns the command of the newest chunk that is due, blended with those of the chunks before it for the same time.
    fn step(&self, now: Duration) -> Result<ChunkStep, String> {
        let newest = self.chunks.back().ok_or("there is no chunk")?;
        let steps = newest.chunk.commands.len();
        let Some(place) = newest.due(now) else {
            let lasted = newest.lasts().as_secs_f64();
            return Err(format!(
                "chunk {} has run out: its {steps} commands lasted {lasted} s",
                newest.number
            ));
        };
        if newest.chunk.certainty == 0.0 {
            return Err(format!("the maker of chunk {} is not sure", newest.number));
        }
        // Of the oldest chunk the weight is 1.
        let (mut command, mut weight, mut total, mut shares) = (Twist::ZERO, 1.0, 0.0, 0);
        for dated in &self.chunks {
            let Some(place) = dated.due(now) else { continue };
            add(&mut command, &dated.chunk.commands[place], weight);
            total += weight;
            weight *= newest.chunk.blend;
            shares += 1;
        }
        let mut mean = Twist::ZERO;
        add(&mut mean, &command, 1.0 / total);
        Ok(ChunkStep {
            chunk: newest.number,
            age: now.saturating_sub(newest.time).as_secs_f64(),
            step: place as u32 + 1,
            steps: steps as u32,
            blended: shares - 1,
            padding: Padding::ZERO,
            command: if shares == 1 {
                newest.chunk.commands[place]
            } else {
                mean
            },
        })
    }

    /// Returns the command that is due, or why none is.
    pub(crate) fn decided(&self) -> Result<&ChunkStep, &str> {
        self.decided.0.as_ref().map_err(String::as_str)
    }
}

impl Dated {
    /// Returns the place of the command that is due; `None` after the last one.
    fn due(&self, now: Duration) -> Option<usize> {
        let place = now.saturating_sub(self.time).as_nanos() / self.spacing().as_nanos();
        usize::try_from(place)
            .ok()
            .filter(|place| *place < self.chunk.commands.len())
    }

    fn spacing(&self) -> Duration {
        Duration::from_secs_f64(self.chunk.spacing)
    }

    fn lasts(&self) -> Duration {
        self.spacing() * self.chunk.commands.len() as u32
    }

    /// Refuses what is no chunk, as a whole.
    fn check(&self, now: Duration) -> Result<(), String> {
        let Chunk {
            spacing,
            certainty,
            blend,
            blended,
            ref commands,
            ..
        } = *self.chunk;
        if !(SHORTEST_SPACING..=LONGEST).contains(&spacing) {
            return Err(format!(
                "its commands are due {spacing} s after one another: expected {SHORTEST_SPACING} s to {LONGEST} s"
            ));
        }
        if !(0.0..=1.0).contains(&certainty) {
            return Err(format!("its maker is sure by {certainty}: expected 0 to 1"));
        }
        if blended > 0 && !(blend > 0.0 && blend <= 1.0) {
            return Err(format!(
                "the weights of its blend fall by {blend}: expected up to 1"
            ));
        }
        for (place, command) in commands.iter().enumerate() {
            if let Some(number) = numbers(command).into_iter().find(|number| !number.is_finite()) {
                let steps = commands.len();
                return Err(format!("its command {} of {steps} has {number}", place + 1));
            }
        }
        let lasts = self.lasts();
        if lasts.as_secs_f64() > LONGEST {
            let lasts = lasts.as_secs_f64();
            return Err(format!("it lasts {lasts} s, and {LONGEST} s is the most"));
        }
        match now.checked_sub(self.time) {
            None => Err("its first command is not due yet".to_owned()),
            Some(_) if commands.is_empty() => Err("it has no command".to_owned()),
            Some(age) if age >= lasts => Err("it came after its last command was over".to_owned()),
            Some(_) => Ok(()),
        }
    }
}

fn numbers(twist: &Twist) -> [f64; 6] {
    let Twist { linear, angular } = twist;
    [linear.x, linear.y, linear.z, angular.x, angular.y, angular.z]
}

fn add(sum: &mut Twist, share: &Twist, weight: f64) {
    let Twist { linear, angular } = sum;
    let sums = [
        &mut linear.x,
        &mut linear.y,
        &mut linear.z,
        &mut angular.x,
        &mut angular.y,
        &mut angular.z,
    ];
    for (sum, number) in sums.into_iter().zip(numbers(share)) {
        *sum += number * weight;
    }
}
