//! The filter at one time: it moves on, and takes or refuses measurements.

use crate::matrix::{Matrix, cholesky, invert, product, symmetric, times, transpose};
use crate::measurement::{Innovation, Measurement, Thresholds, Wheels};
use crate::state::{
    BIAS, Covariance, DRIFT, Initial, Numbers, ProcessNoise, RATE, SIZE, State, TURN_SCALE, VX, VY,
    WAY_SCALE, X, Y, YAW, identity,
};

/// Standard deviation of the speed of a base whose wheels stand, m/s: it gives a little.
const STANDING_SPEED: f64 = 0.002;
/// Of its turn rate, rad/s.
const STANDING_RATE: f64 = 0.0005;
/// Half of the distance of wheels, m: how much a wheel that slips spoils the speed for each rad/s that it spoils the turn.
pub(crate) const SLIP_LEVER: f64 = 0.3;
/// What is left of the noise of the motion while the base stands.
const STANDING_NOISE: f64 = 1e-4;
/// How long before its first measurement a base that stood may have started, s.
const START_TIME: f64 = 0.1;
/// The longest step of the prediction, s: the turn in it is small for what bases turn.
const MAX_STEP: f64 = 0.1;

/// What has become of a measurement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Outcome {
    /// It was taken.
    Taken,
    /// It is farther from what was expected than its threshold: the Mahalanobis distance.
    Refused(f64),
    /// The wheels turn otherwise than the gyro, by so many rad/s: their turn was refused, and their speed counts less.
    Slips(f64),
    /// The wheels stand, and the estimate moves: the Mahalanobis distance.
    Pushed(f64),
    /// Its numbers are not finite, or its covariance is not positive definite.
    Invalid,
}

/// The estimate of a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Filter {
    state: State,
    covariance: Covariance,
    /// For how long the base still counts as standing, s: its wheels said so, and may have been silent since.
    stands: f64,
}

impl Filter {
    /// Returns an estimate of a base that stands or moves at most at some metres per second.
    #[must_use]
    pub fn new(state: State, initial: &Initial) -> Self {
        let mut covariance = [[0.0; SIZE]; SIZE];
        for (at, deviation) in [
            (X, initial.position),
            (Y, initial.position),
            (YAW, initial.yaw),
            // What is measured first says it.
            (VX, 1.0),
            (VY, 1.0),
            (RATE, 1.0),
            (BIAS, initial.bias),
            (WAY_SCALE, initial.way_scale),
            (TURN_SCALE, initial.turn_scale),
            (DRIFT, initial.drift),
        ] {
            covariance[at][at] = deviation * deviation;
        }
        Self {
            state,
            covariance,
            stands: 0.0,
        }
    }

    /// Returns what is estimated.
    #[must_use]
    pub const fn state(&self) -> &State {
        &self.state
    }

    /// Returns the covariance of x, y and the heading.
    #[must_use]
    pub fn pose_covariance(&self) -> Matrix<3, 3> {
        self.block([X, Y, YAW])
    }

    /// Returns the covariance of the speeds ahead and to the left and of the turn rate.
    #[must_use]
    pub fn twist_covariance(&self) -> Matrix<3, 3> {
        let scale = self.state.scale();
        let [ahead, left, _] = self.state.twist();
        let mut by_state = [[0.0; SIZE]; 3];
        (by_state[0][VX], by_state[0][WAY_SCALE]) = (scale, -scale * ahead);
        (by_state[1][VY], by_state[1][WAY_SCALE]) = (scale, -scale * left);
        by_state[2][RATE] = 1.0;
        symmetric(&product(
            &product(&by_state, &self.covariance),
            &transpose(&by_state),
        ))
    }

    /// Returns the standard deviation of the gyro's bias, rad/s.
    #[must_use]
    pub fn bias_deviation(&self) -> f64 {
        self.covariance[BIAS][BIAS].max(0.0).sqrt()
    }

    /// Returns the whole covariance, in the order of the fields of [`State`].
    #[must_use]
    pub const fn covariance(&self) -> &[[f64; 10]; 10] {
        &self.covariance
    }

    fn block<const N: usize>(&self, at: [usize; N]) -> Matrix<N, N> {
        at.map(|row| at.map(|column| self.covariance[row][column]))
    }

    /// Moves on by `time` s.
    pub fn predict(&mut self, time: f64, noise: &ProcessNoise) {
        let steps = (time / MAX_STEP).ceil().max(1.0);
        for _ in 0..steps as usize {
            self.step(time / steps, noise);
        }
    }

    fn step(&mut self, time: f64, noise: &ProcessNoise) {
        let (state, by) = self.state.after(time);
        self.state = state;
        let standing = time.min(self.stands);
        self.stands -= standing;
        let moving = time - standing + standing * STANDING_NOISE;
        self.covariance = product(&product(&by, &self.covariance), &transpose(&by));
        // What changes the velocity changes the pose as well. The noise acts in the middle of the motion, as if the
        // acceleration were constant in it: the discrete model of white noise (Bar-Shalom, Li and Kirubarajan, "Estimation
        // with applications to tracking and navigation", 2001, 6.3.2). Were each part of the motion another noise, a gyro of
        // 100 Hz would seem to miss turns between its measurements, and the heading would be known far too little.
        for (at, growth) in growths(time, moving, noise) {
            let effect: Numbers = core::array::from_fn(|row| if row == at { 1.0 } else { by[row][at] / 2.0 });
            for (row, a) in self.covariance.iter_mut().zip(effect) {
                for (number, b) in row.iter_mut().zip(effect) {
                    *number += growth * a * b;
                }
            }
        }
        self.covariance = symmetric(&self.covariance);
    }

    /// Takes a measurement, unless it is too far from what was expected. `gyro` is the mean of a gyro's turn rates while
    /// the wheels measured, with the variance of the mean.
    pub fn update(
        &mut self,
        measurement: &Measurement,
        gyro: Option<(f64, f64)>,
        noise: &ProcessNoise,
        thresholds: &Thresholds,
    ) -> Outcome {
        let before = *self;
        let outcome = self.update_once(measurement, gyro, noise, thresholds);
        let is_of_motion = matches!(measurement, Measurement::Turn(_) | Measurement::Wheels(_));
        if before.stands <= 0.0 || !is_of_motion || matches!(outcome, Outcome::Taken | Outcome::Invalid) {
            return outcome;
        }
        // It starts to move, unless that is refused as well.
        *self = Self {
            stands: 0.0,
            ..before
        };
        for (at, growth) in growths(START_TIME, START_TIME, noise) {
            self.covariance[at][at] += growth;
        }
        let outcome = self.update_once(measurement, gyro, noise, thresholds);
        if matches!(outcome, Outcome::Refused(_)) {
            *self = before;
        }
        outcome
    }

    fn update_once(
        &mut self,
        measurement: &Measurement,
        gyro: Option<(f64, f64)>,
        noise: &ProcessNoise,
        thresholds: &Thresholds,
    ) -> Outcome {
        let state = &self.state;
        match measurement {
            Measurement::Turn(turn) => self.take(&turn.innovation(state), thresholds.turn),
            Measurement::Heading(heading) => self.take(&heading.innovation(state), thresholds.heading),
            Measurement::Position(position) => self.take(&position.innovation(state), thresholds.position),
            Measurement::Place(place) => self.take(&place.innovation(state), thresholds.place),
            Measurement::Wheels(wheels) => self.roll(wheels, gyro, noise, thresholds.wheels),
        }
    }

    fn roll(
        &mut self,
        wheels: &Wheels,
        gyro: Option<(f64, f64)>,
        noise: &ProcessNoise,
        threshold: f64,
    ) -> Outcome {
        self.stands = 0.0;
        let turn = match gyro {
            Some((rate, variance)) => wheels.turn_beside(&self.state, rate, variance),
            None => wheels.turn(&self.state),
        };
        let difference = turn.difference[0];
        let mut taken = *self;
        let turned = taken.take(&turn, threshold);
        // Beside a base that is turned by hand, wheels that stand say nothing of their constants.
        if !wheels.is_standing {
            *self = taken;
        }
        let [[xx, xy, _], [yx, yy, _], _] = wheels.covariance;
        let slip = match turned {
            Outcome::Taken => 0.0,
            Outcome::Invalid => return Outcome::Invalid,
            Outcome::Refused(_) | Outcome::Slips(_) | Outcome::Pushed(_) => {
                (SLIP_LEVER * difference) * (SLIP_LEVER * difference)
            }
        };
        let speeds = wheels.speeds(&self.state, [[xx + slip, xy], [yx, yy + slip]]);
        let rolled = self.take(&speeds, threshold);
        if turned != Outcome::Taken {
            return Outcome::Slips(difference);
        }
        if rolled != Outcome::Taken || !wheels.is_standing {
            return rolled;
        }
        let standstill = Wheels::standstill(&self.state, STANDING_SPEED, STANDING_RATE);
        match self.take(&standstill, threshold) {
            Outcome::Refused(distance) => Outcome::Pushed(distance),
            other => {
                if other == Outcome::Taken {
                    self.stands = noise.standstill;
                }
                other
            }
        }
    }

    fn take<const M: usize>(&mut self, innovation: &Innovation<M>, threshold: f64) -> Outcome {
        let Innovation {
            difference,
            covariance,
            by_state,
        } = innovation;
        // Beside a large covariance of the state, a sum with it hides a covariance that is none.
        if cholesky(covariance).is_none() {
            return Outcome::Invalid;
        }
        let by_measurement = transpose(by_state);
        let cross = product(&self.covariance, &by_measurement);
        let mut sum = product(by_state, &cross);
        for (row, noise) in sum.iter_mut().flatten().zip(covariance.iter().flatten()) {
            *row += noise;
        }
        let Some(inverse) = invert(&sum) else {
            return Outcome::Invalid;
        };
        let weighted = times(&inverse, difference);
        let square: f64 = weighted.iter().zip(difference).map(|(a, b)| a * b).sum();
        if !square.is_finite() {
            return Outcome::Invalid;
        }
        if square > threshold * threshold {
            return Outcome::Refused(square.max(0.0).sqrt());
        }
        let gain = product(&cross, &inverse);
        let change = times(&gain, difference);
        let numbers: Numbers = self.state.numbers();
        self.state = State::of(core::array::from_fn(|at| numbers[at] + change[at]));
        // Joseph's form: it stays positive whatever is rounded.
        let mut kept = identity();
        let taken = product(&gain, by_state);
        for (kept, taken) in kept.iter_mut().flatten().zip(taken.iter().flatten()) {
            *kept -= taken;
        }
        let old = product(&product(&kept, &self.covariance), &transpose(&kept));
        let new = product(&product(&gain, covariance), &transpose(&gain));
        let mut next = old;
        for (next, new) in next.iter_mut().flatten().zip(new.iter().flatten()) {
            *next += new;
        }
        self.covariance = symmetric(&next);
        Outcome::Taken
    }

    /// The gyro's bias may be off by another `bias`, rad/s, and has turned the estimate by `yaw`, rad, that was no turn.
    pub(crate) fn doubt_bias(&mut self, bias: f64, yaw: f64) {
        self.covariance[BIAS][BIAS] += bias * bias;
        self.covariance[YAW][YAW] += yaw * yaw;
    }
}

/// How the variances grow in a time, in which the base may have moved for `moving` s.
fn growths(time: f64, moving: f64, noise: &ProcessNoise) -> [(usize, f64); 7] {
    [
        (X, noise.position * moving),
        (Y, noise.position * moving),
        (YAW, noise.yaw * moving),
        (VX, noise.vx * moving),
        (VY, noise.vy * moving),
        (RATE, noise.rate * moving),
        (BIAS, noise.bias * time),
    ]
}
