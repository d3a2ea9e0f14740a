//! A simulated base: its true motion, and what its sensors measure with the errors that the filter assumes.

use core::time::Duration;

use fastrand::Rng;
use jde_fuse::{
    Filter, Initial, Measurement, Outcome, Position, ProcessNoise, State, Thresholds, Timeline, Turn, Wheels,
};

pub(crate) const INITIAL: Initial = Initial {
    position: 0.01,
    yaw: 0.01,
    bias: 0.05,
    way_scale: 0.02,
    turn_scale: 0.05,
    drift: 0.05,
};
pub(crate) const NOISE: ProcessNoise = ProcessNoise {
    position: 1e-6,
    yaw: 1e-6,
    vx: 0.2,
    vy: 1e-4,
    rate: 1.0,
    bias: 1e-8,
    standstill: 0.5,
};
pub(crate) const THRESHOLDS: Thresholds = Thresholds {
    turn: 5.0,
    wheels: 5.0,
    heading: 5.0,
    position: 5.0,
    place: 5.0,
};
/// Standard deviations of a gyro, rad/s, of the wheels, m/s and rad/s, and of a fix, m.
const GYRO: f64 = 0.005;
const SPEED: f64 = 0.01;
const RATE: f64 = 0.02;
pub(crate) const FIX: f64 = 0.05;
/// Between two measurements of the gyro.
pub(crate) const STEP: Duration = Duration::from_millis(10);

/// What sensors measured, each with its time, in the order of time.
pub(crate) type Log = Vec<(Duration, Measurement)>;

/// The truth of a drive.
pub(crate) struct Drive {
    random: Rng,
    pub(crate) truth: State,
    pub(crate) log: Log,
    time: Duration,
    /// How long the wheels have stood.
    stands: Duration,
    /// How much more the wheels turn than the base, rad/s.
    pub(crate) slip: f64,
    pub(crate) has_fixes: bool,
    /// How fast the variance of the gyro's bias grows, (rad/s)²/s.
    pub(crate) bias_growth: f64,
}

impl Drive {
    pub(crate) fn new(seed: u64) -> Self {
        Self::with(seed, &INITIAL)
    }

    /// A base whose constants err by these deviations.
    pub(crate) fn with(seed: u64, initial: &Initial) -> Self {
        let mut drive = Self {
            random: Rng::with_seed(seed),
            truth: State::default(),
            log: Log::new(),
            time: Duration::ZERO,
            stands: Duration::ZERO,
            slip: 0.0,
            has_fixes: true,
            bias_growth: 0.0,
        };
        let Initial {
            position,
            yaw,
            bias,
            way_scale,
            turn_scale,
            drift,
        } = *initial;
        let mut draw = |deviation: f64| deviation * drive.normal();
        drive.truth = State {
            x: draw(position),
            y: draw(position),
            yaw: draw(yaw),
            bias: draw(bias),
            way_scale: draw(way_scale),
            turn_scale: draw(turn_scale),
            drift: draw(drift),
            ..State::default()
        };
        drive
    }

    /// A number of mean 0 and deviation 1 (Box and Muller, 1958).
    fn normal(&mut self) -> f64 {
        let radius = (-2.0 * (1.0 - self.random.f64()).ln()).sqrt();
        radius * (core::f64::consts::TAU * self.random.f64()).cos()
    }

    /// Drives for a time at a velocity, which it reaches at 0.5 m/s² and 2 rad/s².
    pub(crate) fn go(&mut self, seconds: f64, vx: f64, rate: f64) {
        for _ in 0..(seconds / STEP.as_secs_f64()).round() as usize {
            self.step(vx, rate);
        }
    }

    fn step(&mut self, vx: f64, rate: f64) {
        let time = STEP.as_secs_f64();
        self.time += STEP;
        if self.bias_growth > 0.0 {
            self.truth.bias += (self.bias_growth * time).sqrt() * self.normal();
        }
        let truth = &mut self.truth;
        truth.vx += (vx - truth.vx).clamp(-0.5 * time, 0.5 * time);
        truth.rate += (rate - truth.rate).clamp(-2.0 * time, 2.0 * time);
        let heading = truth.yaw + truth.rate * time / 2.0;
        truth.x += truth.vx * heading.cos() * time;
        truth.y += truth.vx * heading.sin() * time;
        truth.yaw = angle(truth.yaw + truth.rate * time);
        let truth = *truth;
        let turn = Turn {
            rate: truth.rate + truth.bias + GYRO * self.normal(),
            variance: GYRO * GYRO,
        };
        self.log.push((self.time, Measurement::Turn(turn)));
        let tick = self.time.as_millis() as u64;
        if tick.is_multiple_of(50) {
            self.roll();
        }
        if self.has_fixes && tick.is_multiple_of(1000) {
            let position = [truth.x + FIX * self.normal(), truth.y + FIX * self.normal()];
            let covariance = [[FIX * FIX, 0.0], [0.0, FIX * FIX]];
            let position = Position {
                position,
                covariance,
                antenna: [0.0; 2],
            };
            self.log.push((self.time, Measurement::Position(position)));
        }
    }

    fn roll(&mut self) {
        let truth = self.truth;
        let stands = truth.vx == 0.0 && truth.rate == 0.0 && self.slip == 0.0;
        self.stands = if stands {
            self.stands + Duration::from_millis(50)
        } else {
            Duration::ZERO
        };
        let noise = if stands {
            [0.0; 3]
        } else {
            [(); 3].map(|()| self.normal())
        };
        let wheels = Wheels {
            velocity: [
                (1.0 + truth.way_scale) * truth.vx + SPEED * noise[0],
                0.001 * noise[1],
            ],
            rate: (1.0 + truth.turn_scale) * truth.rate
                + truth.drift * truth.vx
                + self.slip
                + RATE * noise[2],
            covariance: [
                [SPEED * SPEED, 0.0, 0.0],
                [0.0, 1e-6, 0.0],
                [0.0, 0.0, RATE * RATE],
            ],
            lasts: Duration::ZERO,
            is_standing: self.stands >= Duration::from_millis(500),
        };
        self.log.push((self.time, Measurement::Wheels(wheels)));
    }

    /// Stands, and drives curves.
    pub(crate) fn around(&mut self) {
        self.go(3.0, 0.0, 0.0);
        for (vx, rate) in [
            (0.5, 0.0),
            (0.4, 0.8),
            (0.0, 0.0),
            (0.0, -1.0),
            (0.6, -0.3),
            (0.3, 0.5),
        ] {
            self.go(5.0, vx, rate);
        }
    }

    /// The square of the error of the pose, in units of its covariance: 3 in the mean.
    pub(crate) fn nees(&self, filter: &Filter) -> f64 {
        let (state, p) = (filter.state(), filter.pose_covariance());
        let e = [
            state.x - self.truth.x,
            state.y - self.truth.y,
            angle(state.yaw - self.truth.yaw),
        ];
        // Cramer's rule.
        let determinant = |m: [[f64; 3]; 3]| {
            m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1])
                - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0])
                + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0])
        };
        let solved = [0, 1, 2].map(|column| {
            let mut m = p;
            for (row, e) in m.iter_mut().zip(e) {
                row[column] = e;
            }
            determinant(m) / determinant(p)
        });
        e.iter().zip(solved).map(|(a, b)| a * b).sum()
    }
}

pub(crate) fn angle(angle: f64) -> f64 {
    angle.sin().atan2(angle.cos())
}

pub(crate) fn timeline() -> Timeline {
    let start = Filter::new(State::default(), &INITIAL);
    Timeline::new(Duration::ZERO, start, Duration::from_secs(1))
}

pub(crate) fn take(timeline: &mut Timeline, log: &[(Duration, Measurement)]) -> Vec<Outcome> {
    take_with(timeline, log, &NOISE)
}

pub(crate) fn take_with(
    timeline: &mut Timeline,
    log: &[(Duration, Measurement)],
    noise: &ProcessNoise,
) -> Vec<Outcome> {
    let add = |(time, measurement): &(Duration, Measurement)| {
        timeline
            .add(*time, *measurement, noise, &THRESHOLDS)
            .expect("it is in the history")
    };
    log.iter().map(add).collect()
}
