//! The guard of an arm with two joints in a plane: no speeds take effect after which it could not stop in time. It plans
//! nothing, and knows no obstacle but the zones that its application states.

mod plane;
mod state;

use jde_schema::prelude::*;
use jde_schema::types::{JointState, Zones};

pub use state::ArmState;

/// Refuses speeds of joints after which the arm could not stop before a limit of a joint or a forbidden zone, and limits
/// them to a part with which it can, if there is one.
///
/// The joints are named `shoulder` and `elbow`; an elbow of 0 stretches the arm. A joint that is beyond its limit may
/// return, and an arm that is too near to a zone may leave. A command of 0 is always accepted. Without the state of both
/// joints every command is refused.
#[derive(Describe)]
#[schema(perceptive, period = "50ms", budget = "10ms")]
pub struct Arm {
    /// The angles and speeds of the joints.
    #[import(trigger)]
    joints: Import<JointState>,
    /// Length from the shoulder to the elbow.
    #[modulation(default = 0.4, unit = "m", min = 0.01, max = 5.0, fixed)]
    upper_arm: Modulation<f64>,
    /// Length from the elbow to the hand.
    #[modulation(default = 0.3, unit = "m", min = 0.01, max = 5.0, fixed)]
    forearm: Modulation<f64>,
    /// Least angle of the shoulder.
    #[modulation(default = -2.8, unit = "rad", min = -7.0, max = 7.0, fixed)]
    shoulder_min: Modulation<f64>,
    /// Greatest angle of the shoulder.
    #[modulation(default = 2.8, unit = "rad", min = -7.0, max = 7.0, fixed)]
    shoulder_max: Modulation<f64>,
    /// Least angle of the elbow.
    #[modulation(default = -2.4, unit = "rad", min = -7.0, max = 7.0, fixed)]
    elbow_min: Modulation<f64>,
    /// Greatest angle of the elbow.
    #[modulation(default = 2.4, unit = "rad", min = -7.0, max = 7.0, fixed)]
    elbow_max: Modulation<f64>,
    /// Where no part of the arm may be, in the frame of the shoulder.
    #[modulation(default = Zones::EMPTY, fixed)]
    zones: Modulation<Zones>,
    /// Distance to keep from the zones: the thickness of the arm, and what its motors overshoot.
    #[modulation(default = 0.05, unit = "m", min = 0.0, max = 1.0)]
    margin: Modulation<f64>,
    /// Time for which a command is in force before the next judgement of it takes effect.
    #[modulation(default = 0.1, unit = "s", min = 0.0, max = 10.0)]
    reaction: Modulation<f64>,
    /// Greatest decline of the speed of a joint.
    #[modulation(default = 4.0, unit = "rad/s2", min = 0.01, limit)]
    deceleration: Modulation<f64>,
    /// The state by which it judges.
    #[export]
    state: Export<ArmState>,
}

impl Schema for Arm {
    fn iterate(&mut self, cx: &Context) -> Result {
        let joints = self.joints.require(cx)?;
        let of = |name| {
            let place = joints.joint(name)?;
            let angle = *joints.position.get(place)?;
            let speed = *joints.velocity.get(place)?;
            (angle.is_finite() && speed.is_finite()).then_some((angle, speed))
        };
        let (Some(shoulder), Some(elbow)) = (of("shoulder"), of("elbow")) else {
            self.state.retract(cx);
            return Ok(());
        };
        let state = ArmState {
            angles: [shoulder.0, elbow.0],
            speeds: [shoulder.1, elbow.1],
            least: [self.shoulder_min.get(cx), self.elbow_min.get(cx)],
            greatest: [self.shoulder_max.get(cx), self.elbow_max.get(cx)],
            links: [self.upper_arm.get(cx), self.forearm.get(cx)],
            zones: self.zones.get(cx),
            margin: self.margin.get(cx),
            reaction: self.reaction.get(cx),
            deceleration: self.deceleration.get(cx),
        };
        self.state.write(cx, state);
        Ok(())
    }
}

impl Guard for Arm {
    type State = ArmState;
    type Command = JointState;
    const STATE_EXPORT: &'static str = "state";

    fn judge(state: &ArmState, age: Duration, command: &JointState) -> Result<(), String> {
        state.judge(age, command)
    }

    fn limit(state: &ArmState, age: Duration, command: &JointState) -> Option<JointState> {
        state.limit(age, command)
    }
}

impl Inspect for Arm {
    fn inspect(&self, cx: &Context, problems: &mut Problems) {
        for (least, greatest) in [
            (&self.shoulder_min, &self.shoulder_max),
            (&self.elbow_min, &self.elbow_max),
        ] {
            if least.get(cx) >= greatest.get(cx) {
                problems.wrong(least, "the least angle is not below the greatest");
            }
        }
        if self.zones.get(cx).zones.iter().any(|zone| zone.corners.len() < 3) {
            problems.wrong(&self.zones, "a zone has fewer than three corners");
        }
    }
}

#[cfg(test)]
mod tests;
