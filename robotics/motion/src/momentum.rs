//! How a lagging base moves, and what it strives for: what an odometry cannot measure is estimated.

use core::time::Duration;

use jde_types::{Twist, TwistWithCovariance};

use crate::{BaseDynamics, Travel};

/// The longest time between two odometries that belong together. What was measured before says nothing about the
/// present.
const MAX_GAP: Duration = Duration::from_millis(500);
/// For how long a base usually accelerates in one way, s: about two periods of a schema that commands.
const PERSISTENCE: f64 = 0.1;
/// How far the acceleration of motors differs from that of their dynamics, as a share of the greatest: by a load, by the
/// floor.
const MODEL_ERROR: f64 = 0.1;
/// Standard deviation of a velocity whose covariance is unknown, m/s and rad/s.
const MIN_NOISE: f64 = 1e-3;
/// The greatest standard deviation of a measurement, m/s and rad/s. Drivers state more, often 1000, if they do not know
/// it.
const MAX_NOISE: f64 = 1.0;
/// The time in which a setpoint is compared with what the base does, s: several periods of an odometry.
const COMPARISON: f64 = 0.5;
/// By how many standard deviations the base must move otherwise than by its setpoint, before that is not believed.
const CONTRADICTION: f64 = 3.0;
/// Where the velocities in the plane are in the covariance of a twist in space.
const DIAGONAL: [usize; 3] = [0, 7, 35];

/// Estimates the velocity of a base and what it strives for, by a Kalman filter for each of its velocities (Kalman, "A
/// new approach to linear filtering and prediction problems", 1960). What the base strives for is the setpoint of its
/// driver; if that is unknown, it changes at random within the limits of acceleration. The velocity follows by the lag,
/// and the noise is the covariance of the odometry, at most what the base can change within its lag.
///
/// A setpoint that is not of this base, or that the base does not obey, must not hide a motion: if the base moves
/// otherwise, the velocity is found without it, and the base strives for the faster of the setpoint and what is found.
///
/// A base without a lag moves as it was measured, and so does one of which a number is not valid.
#[derive(Clone, Copy, Debug, Default)]
pub struct Momentum {
    last: Option<Duration>,
    axes: [Axis; 3],
}

/// What is known of the motors of a base.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Motors {
    /// How they follow.
    pub dynamics: BaseDynamics,
    /// What they are led to at present; `None` if it is unknown.
    pub setpoint: Option<Twist>,
}

/// One of the velocities.
#[derive(Clone, Copy, Debug, Default)]
struct Axis {
    velocity: f64,
    target: f64,
    /// Variances of both, and their covariance.
    variances: [f64; 2],
    covariance: f64,
    /// The velocity by the setpoint alone, and the mean of what was measured beyond it.
    modelled: f64,
    excess: f64,
    /// The setpoint, if the base moves otherwise.
    contradicted: Option<f64>,
}

impl Motors {
    /// Returns motors that follow by `dynamics`, with the setpoint of this age. An old one says nothing of the present.
    #[must_use]
    pub fn new(dynamics: BaseDynamics, setpoint: Option<(Twist, Duration)>) -> Self {
        let young = setpoint.filter(|(_, age)| *age <= MAX_GAP);
        Self {
            dynamics,
            setpoint: young.map(|(twist, _)| twist),
        }
    }
}

impl Momentum {
    /// Takes what was measured at `time`, which differs between two measurements, and returns how the base moves: its
    /// velocity, and what that lacks of what the base strives for. The pose is the origin. All is finite if what was
    /// measured is.
    pub fn update(&mut self, time: Duration, measured: &TwistWithCovariance, motors: &Motors) -> Travel {
        let dynamics = &motors.dynamics;
        let measurement = parts(&measured.twist);
        if dynamics.lag == 0.0 || !dynamics.is_valid() || !measurement.iter().all(|part| part.is_finite()) {
            self.last = None;
            return Travel {
                velocity: measured.twist,
                ..Travel::default()
            };
        }
        let setpoint = motors.setpoint.as_ref().map(parts);
        let setpoint = setpoint.filter(|parts| parts.iter().all(|part| part.is_finite()));
        let since = self.last.map(|last| time.saturating_sub(last));
        let is_same = self.last.replace(time) == Some(time);
        let rate = dynamics.acceleration.max(dynamics.deceleration);
        let turn_rate = dynamics.turn_acceleration.max(dynamics.turn_deceleration);
        let rates = [rate, rate, turn_rate];
        for (part, axis) in self.axes.iter_mut().enumerate() {
            let (seen, target) = (measurement[part], setpoint.map(|parts| parts[part]));
            let change = rates[part] * dynamics.lag;
            let noise = noise(measured.covariance[DIAGONAL[part]], change);
            match since {
                _ if is_same => {}
                Some(since) if !since.is_zero() && since <= MAX_GAP => {
                    let step = since.as_secs_f64();
                    let target = axis.believed(step, dynamics.lag, target, (seen, noise), change);
                    axis.predict(step, rates[part], dynamics.lag, target);
                    axis.correct(seen, noise);
                }
                Some(_) | None => *axis = Axis::new(seen, noise, change, target),
            }
            if !axis.velocity.is_finite() || !axis.lead().is_finite() {
                *axis = Axis::new(seen, noise, change, None);
            }
        }
        let twist = |of: fn(&Axis) -> f64| {
            let [ahead, left, turn] = self.axes.each_ref().map(of);
            let mut twist = Twist::planar(ahead, turn);
            twist.linear.y = left;
            twist
        };
        Travel {
            velocity: twist(|axis| axis.velocity),
            lead: twist(Axis::lead),
            ..Travel::default()
        }
    }
}

impl Axis {
    /// A velocity that may lack as much as `lead` of what the base strives for, if that is unknown.
    fn new(measured: f64, noise: f64, lead: f64, target: Option<f64>) -> Self {
        let (variance, covariance) = match target {
            Some(_) => (0.0, 0.0),
            None => (noise + lead * lead, noise),
        };
        Self {
            velocity: measured,
            target: target.unwrap_or(measured),
            variances: [noise, variance],
            covariance,
            modelled: measured,
            excess: 0.0,
            contradicted: None,
        }
    }

    /// What the velocity lacks.
    fn lead(&self) -> f64 {
        // One that points the other way would hide the motion. A base that is held moves in neither direction.
        let faster = |target: f64| {
            target.abs() > self.target.abs() && target * self.target >= -MIN_NOISE * target.abs()
        };
        self.contradicted
            .filter(|target| faster(*target))
            .unwrap_or(self.target)
            - self.velocity
    }

    /// Returns the setpoint if the base moves by it: the mean of what was measured is that of the model, up to the noise
    /// of a mean and the error of the model. What was found by a setpoint that is contradicted is dropped.
    fn believed(
        &mut self,
        step: f64,
        lag: f64,
        setpoint: Option<f64>,
        (seen, noise): (f64, f64),
        change: f64,
    ) -> Option<f64> {
        let Some(target) = setpoint else {
            (self.modelled, self.excess, self.contradicted) = (seen, 0.0, None);
            return None;
        };
        let mean = f64::midpoint(self.contradicted.unwrap_or(self.target), target);
        self.modelled += (mean - self.modelled) * (1.0 - libm::exp(-step / lag));
        let weight = 1.0 - libm::exp(-step / COMPARISON);
        self.excess += (seen - self.modelled - self.excess) * weight;
        let of_noise = CONTRADICTION * (noise * weight / (2.0 - weight)).sqrt();
        let of_model = MODEL_ERROR * (change + seen.abs().max(self.modelled.abs()));
        if self.excess.abs() <= of_noise + of_model {
            self.contradicted = None;
            return setpoint;
        }
        if self.contradicted.is_none() {
            let (modelled, excess) = (self.modelled, self.excess);
            *self = Self {
                modelled,
                excess,
                ..Self::new(seen, noise, change, None)
            };
        }
        self.contradicted = setpoint;
        None
    }

    fn predict(&mut self, step: f64, rate: f64, lag: f64, target: Option<f64>) {
        let kept = libm::exp(-step / lag);
        let follows = 1.0 - kept;
        let [variance, of_target] = self.variances;
        if let Some(target) = target {
            let error = MODEL_ERROR * rate * step;
            let mean = f64::midpoint(self.target, target);
            self.velocity += (mean - self.velocity) * follows;
            self.target = target;
            self.variances = [kept * kept * variance + error * error, 0.0];
            self.covariance = 0.0;
            return;
        }
        let of_target = of_target + rate * rate * step * PERSISTENCE;
        self.velocity += (self.target - self.velocity) * follows;
        self.variances = [
            kept * kept * variance + 2.0 * kept * follows * self.covariance + follows * follows * of_target,
            of_target,
        ];
        self.covariance = kept * self.covariance + follows * of_target;
    }

    fn correct(&mut self, measured: f64, noise: f64) {
        let lack = measured - self.velocity;
        let total = self.variances[0] + noise;
        let gains = [self.variances[0] / total, self.covariance / total];
        self.velocity += gains[0] * lack;
        self.target += gains[1] * lack;
        self.variances[1] -= gains[1] * self.covariance;
        self.variances[0] *= 1.0 - gains[0];
        self.covariance *= 1.0 - gains[0];
    }
}

/// Returns the variance that counts for one that an odometry states, of a base that changes by `change` within its lag.
fn noise(stated: f64, change: f64) -> f64 {
    let stated = if stated <= MAX_NOISE * MAX_NOISE {
        stated
    } else {
        0.0
    };
    stated.min(change * change).max(MIN_NOISE * MIN_NOISE)
}

fn parts(twist: &Twist) -> [f64; 3] {
    [twist.linear.x, twist.linear.y, twist.angular.z]
}

#[cfg(test)]
mod tests {
    use jde_types::Pose2D;

    use super::*;
    use crate::Setpoint;

    const DYNAMICS: BaseDynamics = BaseDynamics {
        acceleration: 4.0,
        deceleration: 4.0,
        turn_acceleration: 20.0,
        turn_deceleration: 20.0,
        lag: 0.2,
    };
    const PERIOD: Duration = Duration::from_millis(20);

    fn measured(velocity: Twist, deviation: f64) -> TwistWithCovariance {
        let variance = deviation * deviation;
        TwistWithCovariance::planar(velocity, &[[variance, 0.0, 0.0], [0.0; 3], [0.0, 0.0, variance]])
    }

    fn motors(lag: f64, setpoint: Option<Twist>) -> Motors {
        let dynamics = BaseDynamics { lag, ..DYNAMICS };
        Motors { dynamics, setpoint }
    }

    /// The sum of twelve uniform numbers, which is nearly normal.
    fn noise(step: u32) -> f64 {
        let mut random = u64::from(step) + 1;
        let uniform = (0..12).map(|_| {
            random = random
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (random >> 11) as f64 / (1_u64 << 53) as f64
        });
        uniform.sum::<f64>() - 6.0
    }

    /// Drives by commands of half a second each, and returns the standard errors of velocity and lead in the second half
    /// of them, m/s.
    fn errors(deviation: f64, is_known: bool) -> (f64, f64) {
        let (mut momentum, mut travel) = (Momentum::default(), Travel::default());
        let mut setpoint = Setpoint::default();
        let (mut velocity, mut lead, mut count) = (0.0_f64, 0.0_f64, 0.0);
        for step in 0..200_u32 {
            let command = Twist::planar(f64::from(step / 25 % 3), 0.0);
            setpoint.update(PERIOD * step, command, &DYNAMICS);
            travel = travel.after(PERIOD.as_secs_f64(), &command, &DYNAMICS);
            let strives = setpoint.update(PERIOD * (step + 1), command, &DYNAMICS);
            let mut seen = travel.velocity;
            seen.linear.x += deviation * noise(step);
            let motors = motors(DYNAMICS.lag, is_known.then_some(strives));
            let found = momentum.update(PERIOD * (step + 1), &measured(seen, deviation), &motors);
            assert_eq!(found.pose, Pose2D::ORIGIN);
            if step % 25 > 12 {
                velocity += (found.velocity.linear.x - travel.velocity.linear.x).powi(2);
                lead += (found.lead.linear.x - travel.lead.linear.x).powi(2);
                count += 1.0;
            }
        }
        ((velocity / count).sqrt(), (lead / count).sqrt())
    }

    #[test]
    fn without_noise_it_finds_what_the_base_strives_for() {
        let (velocity, lead) = errors(0.0, false);
        assert!(velocity < 1e-3 && lead < 0.06, "{velocity} m/s, {lead} m/s");
    }

    #[test]
    fn of_the_noise_of_an_odometry_half_is_left() {
        let (velocity, lead) = errors(0.3, false);
        assert!(velocity < 0.2 && lead < 0.35, "{velocity} m/s, {lead} m/s");
    }

    #[test]
    fn with_the_setpoint_of_the_driver_a_tenth_is_left() {
        let (velocity, lead) = errors(0.3, true);
        assert!(velocity < 0.04 && lead < 0.04, "{velocity} m/s, {lead} m/s");
    }

    #[test]
    fn a_base_that_is_blocked_stands_whatever_it_strives_for() {
        let mut momentum = Momentum::default();
        let motors = motors(DYNAMICS.lag, Some(Twist::planar(1.0, 0.0)));
        let standing = measured(Twist::ZERO, 0.0);
        let odometries = (0..50).map(|step| momentum.update(PERIOD * step, &standing, &motors));
        let found = odometries.last().expect("50 odometries");
        assert!(
            found.velocity.linear.x < 0.01 && found.lead.linear.x > 0.99,
            "{found:?}"
        );
    }

    #[test]
    fn a_setpoint_that_is_old_counts_as_none() {
        let twist = Twist::planar(1.0, 0.0);
        let setpoint = |ms| Motors::new(DYNAMICS, Some((twist, Duration::from_millis(ms)))).setpoint;
        assert_eq!((setpoint(400), setpoint(600)), (Some(twist), None));
    }

    /// The velocity and lead ahead after a second at 1 m/s, of an odometry that states this deviation, m/s.
    fn steady(deviation: f64, setpoint: Option<f64>) -> (f64, f64) {
        let mut momentum = Momentum::default();
        let motors = motors(DYNAMICS.lag, setpoint.map(|speed| Twist::planar(speed, 0.0)));
        momentum.update(Duration::ZERO, &measured(Twist::ZERO, deviation), &motors);
        let moving = measured(Twist::planar(1.0, 0.0), deviation);
        let found = (1..=50).map(|step| momentum.update(PERIOD * step, &moving, &motors));
        let found = found.last().expect("50 odometries");
        (found.velocity.linear.x, found.lead.linear.x)
    }

    #[test]
    fn no_covariance_and_no_setpoint_of_another_base_hide_a_motion() {
        for deviation in [0.0, 0.3, 1.0, 1e3, f64::INFINITY, f64::NAN] {
            for setpoint in [None, Some(0.0), Some(-0.5), Some(-2.0)] {
                let (velocity, lead) = steady(deviation, setpoint);
                assert!(
                    (velocity - 1.0).abs() < 0.15 && lead > -0.15,
                    "{velocity} m/s, {lead} m/s by {deviation} m/s and {setpoint:?}"
                );
            }
        }
    }

    #[test]
    fn numbers_that_overflow_or_are_not_valid_leave_what_was_measured_and_nothing_lasts() {
        let mut momentum = Momentum::default();
        let mut update = |step, acceleration, lag, setpoint| {
            let mut motors = motors(lag, setpoint);
            motors.dynamics.acceleration = acceleration;
            let found = momentum.update(PERIOD * step, &measured(Twist::planar(0.3, 0.0), 0.1), &motors);
            (found.velocity.linear.x, found.lead.linear.x)
        };
        for (step, acceleration) in (0_u32..).zip([1e200, 1e200, 1e200, f64::NAN, -1.0, f64::INFINITY]) {
            assert_eq!(
                update(step, acceleration, 0.2, None),
                (0.3, 0.0),
                "{acceleration} m/s2"
            );
        }
        for (step, lag) in (6_u32..).zip([f64::NAN, -0.1, f64::INFINITY]) {
            assert_eq!(update(step, 4.0, lag, None), (0.3, 0.0), "{lag} s");
        }
        let far = Some(Twist::planar(f64::MAX, 0.0));
        assert!((9..20).all(|step| update(step, 4.0, 0.2, far).0.is_finite()));
        let found = (20..70)
            .map(|step| update(step, 4.0, 0.2, None))
            .last()
            .expect("50");
        assert!((found.0 - 0.3).abs() < 0.05 && found.1.abs() < 0.05, "{found:?}");
    }

    #[test]
    fn a_base_without_a_lag_a_gap_and_numbers_that_are_none_change_nothing_of_what_was_measured() {
        let mut momentum = Momentum::default();
        let mut update = |ms, speed, lag| {
            let measured = measured(Twist::planar(speed, 0.0), 0.1);
            let found = momentum.update(Duration::from_millis(ms), &measured, &motors(lag, None));
            (found.velocity.linear.x, found.lead.linear.x)
        };
        assert_eq!(update(0, 0.3, 0.0), (0.3, 0.0));
        assert_eq!(update(100, 0.3, 0.2), (0.3, 0.0), "the first");
        let next = update(200, 0.6, 0.2);
        assert!(next.0 > 0.3 && next.0 < 0.6 && next.1 > 0.0, "{next:?}");
        assert_eq!(update(200, 0.6, 0.2), next, "the same odometry");
        assert_eq!(update(900, 0.1, 0.2), (0.1, 0.0), "after a gap");
        assert_eq!(update(800, 0.2, 0.2), (0.2, 0.0), "a clock that jumped");
        assert!(update(820, f64::NAN, 0.2).0.is_nan());
        assert_eq!(update(840, 0.2, 0.2), (0.2, 0.0));
    }
}
