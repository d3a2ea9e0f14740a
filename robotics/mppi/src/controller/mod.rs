//! The sampling, and the mean of the samples by their costs.

use core::f32::consts::TAU;

use wide::f32x8;

use crate::critics::Situation;
use crate::smooth::{PAST, smooth};
use crate::{Base, Command, Motion};

/// Trajectories that are rolled out at once.
const LANES: usize = 8;
/// The share of the term that keeps samples near the last commands: γ = λ (1 − α) of the paper, for a
/// temperature of 0.3 and α = 0.95.
const GAMMA: f32 = 0.015;
/// The time after which the noise has changed to 1/e, s: about a fifth of a usual horizon.
const CORRELATION: f32 = 0.5;

/// How much is sampled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shape {
    /// Trajectories, rounded up to a multiple of eight.
    pub samples: usize,
    /// Steps of each.
    pub steps: usize,
    /// Duration of a step, s.
    pub step: f32,
}

/// How samples differ, and how strictly the cheaper ones count.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// Standard deviations of the speeds, m/s, and of the turn rate, rad/s.
    pub deviation: Command,
    /// Difference of costs at which a sample counts 1/e of another, above 0.
    pub temperature: f32,
}

/// A controller with the sequence of commands that it found last.
#[derive(Clone, Debug)]
pub struct Controller {
    shape: Shape,
    random: fastrand::Rng,
    /// The commands found last, and room for the next ones.
    sequence: Vec<Command>,
    next: Vec<Command>,
    /// The commands given last, the newest last.
    past: [Command; PAST],
    /// The commands of all samples: of each eight, step by step.
    samples: Vec<[f32x8; 3]>,
    costs: Vec<f32x8>,
    sums: Vec<[f32x8; 3]>,
    best: usize,
}

impl Controller {
    /// Returns a controller that stands. It allocates all that it will need: 96 bytes for each step of eight
    /// trajectories.
    #[must_use]
    pub fn new(shape: Shape, seed: u64) -> Self {
        let blocks = shape.samples.div_ceil(LANES).max(1);
        let steps = shape.steps.max(1);
        Self {
            shape: Shape {
                samples: blocks * LANES,
                steps,
                ..shape
            },
            random: fastrand::Rng::with_seed(seed),
            sequence: vec![[0.0; 3]; steps],
            next: vec![[0.0; 3]; steps],
            past: [[0.0; 3]; PAST],
            samples: vec![[f32x8::ZERO; 3]; blocks * steps],
            costs: vec![f32x8::ZERO; blocks],
            sums: vec![[f32x8::ZERO; 3]; steps],
            best: 0,
        }
    }

    /// Forgets its commands, as when the base was stopped.
    pub fn stand(&mut self) {
        self.sequence.fill([0.0; 3]);
        self.past = [[0.0; 3]; PAST];
    }

    /// Returns the command for the present step, `elapsed` s after the last call.
    ///
    /// Takes time by the number of samples times that of steps.
    pub fn command(&mut self, situation: &Situation<'_>, spread: &Spread, elapsed: f32) -> Command {
        self.pass(elapsed);
        self.sample(&situation.base, &spread.deviation);
        let steps = self.shape.steps;
        for (commands, cost) in self.samples.chunks_exact(steps).zip(&mut self.costs) {
            *cost = situation.cost(commands, self.shape.step);
        }
        self.keep_near(spread);
        self.average(spread.temperature);
        smooth(&self.past, &self.next, &mut self.sequence);
        let first = self.sequence.first().copied().unwrap_or_default();
        let command = situation.base.clamp(first.map(f32x8::splat));
        let command = command.map(|part| part.to_array()[0]);
        self.past.rotate_left(1);
        self.past[PAST - 1] = command;
        command
    }

    /// The places that the found commands lead to, from a motion on, for a person to see, m.
    pub fn found(&self, base: &Base, start: &Motion) -> impl Iterator<Item = (f32, f32)> {
        base.places(start, self.shape.step, self.sequence.iter().copied())
    }

    /// The places that the cheapest sample leads to, m.
    pub fn best(&self, base: &Base, start: &Motion) -> impl Iterator<Item = (f32, f32)> {
        let (block, lane) = (self.best / LANES, self.best % LANES);
        let steps = self.shape.steps;
        let commands = self.samples[block * steps..(block + 1) * steps].iter();
        let of_lane = move |command: &[f32x8; 3]| command.map(|part| part.to_array()[lane]);
        base.places(start, self.shape.step, commands.map(of_lane))
    }

    /// Moves on along the last sequence; after its end, its last command stays.
    fn pass(&mut self, elapsed: f32) {
        let passed = (elapsed / self.shape.step).clamp(0.0, self.shape.steps as f32);
        let (whole, share) = (passed as usize, passed.fract());
        let last = self.shape.steps - 1;
        for place in 0..=last {
            let at = |place: usize| self.sequence[place.min(last)];
            let (a, b) = (
                at(place.saturating_add(whole)),
                at(place.saturating_add(whole).saturating_add(1)),
            );
            self.sequence[place] = core::array::from_fn(|part| a[part] + share * (b[part] - a[part]));
        }
    }

    /// Draws the commands around the last sequence. The first sample is the sequence itself, the second stands.
    ///
    /// The noise of one step continues that of the step before, so that a sample leads away from the last
    /// trajectory (Vlahov et al., "Low frequency sampling in model predictive path integral control", 2024).
    fn sample(&mut self, base: &Base, deviation: &Command) {
        let (random, sequence) = (&mut self.random, &self.sequence);
        let kept = libm::expf(-self.shape.step / CORRELATION);
        let (kept, fresh) = (f32x8::splat(kept), f32x8::splat(libm::sqrtf(1.0 - kept * kept)));
        for (index, commands) in self.samples.chunks_exact_mut(sequence.len()).enumerate() {
            let mut noise = [f32x8::ZERO; 3];
            for (place, (command, around)) in commands.iter_mut().zip(sequence).enumerate() {
                let (ahead, turn) = normal_pair(random);
                let left = if base.sideways > 0.0 {
                    normal_pair(random).0
                } else {
                    f32x8::ZERO
                };
                let drawn = [ahead, left, turn];
                for ((noise, drawn), deviation) in noise.iter_mut().zip(drawn).zip(deviation) {
                    let drawn = drawn * f32x8::splat(*deviation);
                    *noise = if place == 0 {
                        drawn
                    } else {
                        *noise * kept + drawn * fresh
                    };
                }
                *command = core::array::from_fn(|part| f32x8::splat(around[part]) + noise[part]);
                if index == 0 {
                    for (values, around) in command.iter_mut().zip(around) {
                        let values = values.as_mut_array();
                        (values[0], values[1]) = (*around, 0.0);
                    }
                }
                *command = base.clamp(*command);
            }
        }
    }

    /// Adds the term of the information-theoretic free energy: what differs from the last sequence costs.
    fn keep_near(&mut self, spread: &Spread) {
        let factors = spread
            .deviation
            .map(|deviation| GAMMA / (deviation * deviation).max(1e-6));
        let samples = self.samples.chunks_exact(self.shape.steps);
        for (commands, cost) in samples.zip(&mut self.costs) {
            for (command, around) in commands.iter().zip(&self.sequence) {
                for part in 0..3 {
                    let apart = command[part] - f32x8::splat(around[part]);
                    *cost += apart * f32x8::splat(factors[part] * around[part]);
                }
            }
        }
    }

    /// Writes the mean of the samples, each by e^(−cost / temperature), to `next`.
    fn average(&mut self, temperature: f32) {
        let mut least = f32::INFINITY;
        for (block, cost) in self.costs.iter().enumerate() {
            for (lane, &cost) in cost.as_array().iter().enumerate() {
                if cost < least {
                    (least, self.best) = (cost, block * LANES + lane);
                }
            }
        }
        self.sums.fill([f32x8::ZERO; 3]);
        let mut total = 0.0;
        let scale = f32x8::splat(-1.0 / temperature.max(1e-3));
        for (commands, cost) in self.samples.chunks_exact(self.shape.steps).zip(&self.costs) {
            let weight = ((*cost - f32x8::splat(least)) * scale).exp();
            let sum = weight.reduce_add();
            // What counts less than a millionth changes nothing that the base could follow.
            if sum < 1e-6 {
                continue;
            }
            total += sum;
            for (sums, command) in self.sums.iter_mut().zip(commands) {
                for (sum, command) in sums.iter_mut().zip(command) {
                    *sum += *command * weight;
                }
            }
        }
        for (next, sums) in self.next.iter_mut().zip(&self.sums) {
            *next = sums.map(|sum| sum.reduce_add() / total);
        }
    }
}

/// Eight pairs of independent numbers of the standard normal distribution (Box and Muller, "A note on the
/// generation of random normal deviates", 1958).
fn normal_pair(random: &mut fastrand::Rng) -> (f32x8, f32x8) {
    // From the middles of 2²⁴ equal parts of 0 to 1, so that none is 0.
    let mut uniform = || {
        f32x8::from(core::array::from_fn(|_| {
            ((random.u32(..) >> 8) as f32 + 0.5) * (1.0 / 16_777_216.0)
        }))
    };
    let radius = (uniform().ln() * f32x8::splat(-2.0)).sqrt();
    let (sin, cos) = (uniform() * f32x8::splat(TAU)).sin_cos();
    (radius * cos, radius * sin)
}

#[cfg(test)]
mod tests;
