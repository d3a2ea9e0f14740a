//! What the driver says of its base to guards and other drivers of it: how it follows its commands. It measures nothing.

use jde_motion::{BaseDynamics, Setpoint};
use jde_schema::prelude::*;
use jde_sim::{Kinematics, RobotConfig, Twist2};

use crate::Robot;

/// Returns how a robot follows its commands. The limits of a car's turn rate follow from its steering, so they are
/// unknown. Those of an omnidirectional robot are the lesser of ahead and to the side.
fn dynamics(config: &RobotConfig) -> BaseDynamics {
    let turns = |limit: f64| match config.kinematics {
        Kinematics::Car { .. } => 0.0,
        Kinematics::Differential | Kinematics::Omnidirectional { .. } => limit,
    };
    let least = |limit: f64| match config.kinematics {
        Kinematics::Omnidirectional {
            lateral_acceleration, ..
        } => limit.min(lateral_acceleration),
        Kinematics::Differential | Kinematics::Car { .. } => limit,
    };
    BaseDynamics {
        acceleration: least(config.linear_acceleration),
        deceleration: least(config.linear_deceleration),
        turn_acceleration: turns(config.angular_acceleration),
        turn_deceleration: turns(config.angular_deceleration),
        lag: config.lag,
    }
}

impl Robot {
    /// Publishes how the robot follows its commands.
    pub(crate) fn publish_dynamics(&mut self, cx: &Context, config: &RobotConfig) {
        self.dynamics.write(cx, dynamics(config));
    }

    /// Publishes what the motors are led to, as a driver knows it: without their dead band. Those of a car are led to a
    /// curvature. Those of a robot that accelerates otherwise to the side are led to what its dynamics do not say.
    pub(crate) fn publish_setpoint(
        &mut self,
        cx: &Context,
        config: &RobotConfig,
        setpoint: &mut Setpoint,
        command: Twist2,
    ) {
        let sideways = match config.kinematics {
            Kinematics::Car { .. } => return,
            Kinematics::Differential => 0.0,
            Kinematics::Omnidirectional {
                max_lateral,
                lateral_acceleration: to_side,
            } => {
                if [config.linear_acceleration, config.linear_deceleration] != [to_side; 2] {
                    return;
                }
                max_lateral
            }
        };
        let mut twist = Twist::planar(
            command.linear.clamp(-config.max_linear, config.max_linear),
            command.angular.clamp(-config.max_angular, config.max_angular),
        );
        twist.linear.y = command.lateral.clamp(-sideways, sideways);
        let strives = setpoint.update(cx.now(), twist, &dynamics(config));
        self.setpoint.write(cx, strives);
    }
}
