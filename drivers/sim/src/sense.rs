//! Exports the simulated sensors in the standard interfaces.

use jde_schema::prelude::*;
use jde_sim::{BATTERY_CAPACITY, Pose2, World};

use crate::{ActiveRobot, Pioneer};

/// Values of `BatteryState` for a discharging battery in good health.
const DISCHARGING: u8 = 2;
const GOOD: u8 = 1;

impl Pioneer {
    /// Publishes every sensor at the world's time.
    pub(crate) fn sense(&mut self, cx: &Context, world: &World, active: &ActiveRobot) -> Result {
        self.publish_laser(cx, world, active)?;
        self.publish_sonars(cx, world, active)?;
        let (now, robot) = (cx.now(), active.claim.robot());
        let odometry = world.odometry(robot);
        let twist = Twist::planar(odometry.twist.linear, odometry.twist.angular);
        self.odometry
            .write(cx, Odometry::planar(now, pose(odometry.pose), twist));

        let pressed = world.bumpers(robot);
        let truth = world.truth(robot);
        let mut bumpers = Bumpers {
            header: Header::new(now, "base_link"),
            stalled: truth.stalled.into(),
            ..Bumpers::default()
        };
        bumpers.front.extend_from_slice(&pressed.front.map(Flag::from))?;
        // The simulator counts clockwise; the interface counts from left to right, facing ahead.
        let mut rear = pressed.rear.map(Flag::from);
        rear.reverse();
        bumpers.rear.extend_from_slice(&rear)?;
        self.bumpers.write(cx, bumpers);

        self.publish_state(cx, world, active);
        self.truth.write(
            cx,
            Truth {
                pose: pose(truth.pose),
                twist: Twist::planar(truth.twist.linear, truth.twist.angular),
                clearance: truth.clearance,
                min_clearance: truth.min_clearance,
                collisions: truth.collisions,
            },
        );
        Ok(())
    }

    /// Publishes the state of the head, the battery, the encoders and the connection.
    fn publish_state(&mut self, cx: &Context, world: &World, active: &ActiveRobot) {
        let (now, robot) = (cx.now(), active.claim.robot());
        let head = world.head(robot);
        self.pan_tilt.write(
            cx,
            PanTilt {
                header: Header::new(now, "base_link"),
                pan: head.pan,
                tilt: head.tilt,
                pan_velocity: head.pan_velocity,
                tilt_velocity: head.tilt_velocity,
            },
        );
        let battery = world.battery(robot);
        self.battery.write(
            cx,
            BatteryState {
                header: Header::new(now, "base_link"),
                voltage: battery.voltage as f32,
                current: battery.current as f32,
                charge: (battery.charge * BATTERY_CAPACITY) as f32,
                capacity: BATTERY_CAPACITY as f32,
                design_capacity: BATTERY_CAPACITY as f32,
                percentage: battery.charge as f32,
                power_supply_status: DISCHARGING,
                power_supply_health: GOOD,
                present: true.into(),
                ..BatteryState::default()
            },
        );
        let encoders = world.encoders(robot);
        self.encoders.write(
            cx,
            WheelEncoders {
                header: Header::new(now, "base_link"),
                left: encoders.left,
                right: encoders.right,
                ticks_per_meter: world.config(robot).ticks_per_meter,
            },
        );
        self.connection.write(
            cx,
            Connection {
                header: Header::new(active.since, ""),
                state: Connection::CONNECTED,
                note: Text::truncated(world.name()),
                ..Connection::default()
            },
        );
    }

    fn publish_laser(&mut self, cx: &Context, world: &World, active: &ActiveRobot) -> Result {
        let lasers = &active.lasers;
        let mut scan = self.laser.loan(cx);
        scan.header = Header::new(cx.now(), "laser");
        scan.angle_min = lasers.angle_min() as f32;
        scan.angle_max = lasers.angle_max() as f32;
        scan.angle_increment = lasers.angle_increment() as f32;
        scan.time_increment = 0.0;
        scan.scan_time = 0.0;
        scan.range_min = lasers.range_min as f32;
        scan.range_max = lasers.range_max as f32;
        scan.intensities.clear();
        world.laser(active.claim.robot(), lasers, scan.ranges.resize(lasers.beams))?;
        scan.publish();
        Ok(())
    }

    fn publish_sonars(&mut self, cx: &Context, world: &World, active: &ActiveRobot) -> Result {
        let ring = &active.ring;
        let mut sonars = self.sonars.loan(cx);
        sonars.header = Header::new(cx.now(), "base_link");
        sonars.radiation_type = 0;
        sonars.padding = Padding::ZERO;
        sonars.field_of_view = ring.cone as f32;
        sonars.min_range = ring.range_min as f32;
        sonars.max_range = ring.range_max as f32;
        for (pose, mount) in sonars
            .poses
            .resize(ring.mounts.len())
            .iter_mut()
            .zip(&ring.mounts)
        {
            *pose = self::pose(*mount);
        }
        world.sonars(
            active.claim.robot(),
            ring,
            sonars.ranges.resize(ring.mounts.len()),
        )?;
        sonars.publish();
        Ok(())
    }
}

fn pose(pose: Pose2) -> Pose2D {
    Pose2D::new(pose.x, pose.y, pose.heading)
}
