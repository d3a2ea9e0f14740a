//! Where the laser is on the robot, and which poses are those of the robot. It knows no file and no clock.
//!
//! The poses of a log are of three kinds: that of the laser and that of the robot in a scan, and that of the robot in an
//! `ODOM` line. In a log as CARMEN writes it, the first two differ by where the laser is mounted, and the last two agree.
//! A program that corrects a log writes its poses over those of the laser (`vasco`), or over both (GMapping); then the
//! mount is only among the parameters, as GMapping reads it.

use core::f64::consts::PI;

use jde_schema::types::{Pose2D, normalize_angle};

use super::Entry;
use super::record::Source;

/// How far from the robot's centre a laser may be, m.
const MAX_MOUNT_DISTANCE: f64 = 10.0;
/// How far poses of one mount differ, m and rad: they are written with two or more digits.
const MOUNT_TOLERANCE: f64 = 0.03;
/// The share of the scans whose poses must be of one mount.
const MIN_SHARE: f64 = 0.95;
/// Two poses that are nearer are the same, m and rad.
const POSE_TOLERANCE: f64 = 1e-3;
/// What a turn counts as, m/rad.
const TURN: f64 = 0.5;

/// What the poses of a log are.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Poses {
    /// Where the laser is on the robot.
    pub(super) mount: Pose2D,
    /// Whether the poses of the `ODOM` lines are of another kind than those of the scans.
    pub(super) contradicts: bool,
    /// What was decided, for people.
    pub(super) notes: Vec<String>,
}

impl Poses {
    /// Finds the mount, and leaves in each entry the pose of the robot. `stated` is the offset of the laser in the
    /// parameters of the log, m ahead.
    pub(super) fn of(entries: &mut [Entry], source: Source, stated: Option<f64>) -> Self {
        let ahead = stated
            .filter(|offset| offset.abs() <= MAX_MOUNT_DISTANCE)
            .unwrap_or(0.0);
        let usual = Pose2D::new(ahead, 0.0, if source.is_rear() { PI } else { 0.0 });
        let mut poses = Self {
            mount: usual,
            contradicts: false,
            notes: Vec::new(),
        };
        poses.find_mount(entries, usual);
        let way = |poses: &mut dyn Iterator<Item = Pose2D>| {
            let mut last = None;
            poses
                .map(|pose| last.replace(pose).map_or(0.0, |last| step(&last, &pose)))
                .sum::<f64>()
        };
        let robot = |entry: &Entry| entry.reading.robot;
        let of_scans = way(&mut entries
            .iter()
            .filter(|entry| entry.sweep.is_some())
            .filter_map(robot));
        let of_wheels = way(&mut entries
            .iter()
            .filter(|entry| entry.sweep.is_none())
            .filter_map(robot));
        let of_all = way(&mut entries.iter().filter_map(robot));
        if of_all > 2.0 * of_scans.max(of_wheels) + 2.0 {
            poses.contradicts = of_scans > 0.01 * of_wheels;
            if !poses.contradicts {
                poses.notes.push(
                    "the poses in its scans stand still; those of its ODOM lines are played".to_owned(),
                );
                for entry in entries.iter_mut().filter(|entry| entry.sweep.is_some()) {
                    entry.reading.robot = None;
                }
            }
        }
        poses
    }

    fn find_mount(&mut self, entries: &mut [Entry], usual: Pose2D) {
        let pairs: Vec<(Pose2D, Pose2D)> = (entries.iter())
            .filter_map(|entry| entry.reading.robot.zip(entry.reading.laser))
            .collect();
        let mounts: Vec<Pose2D> = pairs.iter().map(|(robot, laser)| robot.localize(laser)).collect();
        let Some(first) = mounts.first() else { return };
        let median = |of: &dyn Fn(&Pose2D) -> f64| {
            let mut all: Vec<f64> = mounts.iter().map(of).collect();
            all.sort_by(f64::total_cmp);
            all[all.len() / 2]
        };
        let turn = median(&|mount| normalize_angle(mount.theta - first.theta));
        let mount = Pose2D::new(
            median(&|mount| mount.x),
            median(&|mount| mount.y),
            normalize_angle(first.theta + turn),
        );
        let is_same = |other: &&Pose2D| {
            mount.distance_to(other) <= MOUNT_TOLERANCE
                && normalize_angle(mount.theta - other.theta).abs() <= MOUNT_TOLERANCE
        };
        let is_mounted = mounts.iter().filter(is_same).count() as f64 >= MIN_SHARE * mounts.len() as f64
            && libm::hypot(mount.x, mount.y) <= MAX_MOUNT_DISTANCE;
        if is_mounted {
            let is_none =
                libm::hypot(mount.x, mount.y) < POSE_TOLERANCE && mount.theta.abs() < POSE_TOLERANCE;
            self.mount = if is_none { usual } else { mount };
            return;
        }
        let ways = pairs
            .windows(2)
            .map(|pair| (step(&pair[0].0, &pair[1].0), step(&pair[0].1, &pair[1].1)));
        let (robot, laser) = ways.fold((0.0, 0.0), |sum, way| (sum.0 + way.0, sum.1 + way.1));
        let Pose2D { x, .. } = usual;
        if robot > 0.01 * laser {
            self.notes.push(format!(
                "the poses of its laser were corrected afterwards; the odometry is that of the robot, with its laser {x} m ahead"
            ));
            return;
        }
        self.notes.push(format!(
            "its robot stands still while its laser moves; the odometry is that of the laser, {x} m ahead of the robot"
        ));
        let back = usual.localize(&Pose2D::ORIGIN);
        for reading in entries.iter_mut().map(|entry| &mut entry.reading) {
            reading.robot = reading
                .laser
                .map(|laser| laser.transform(&back))
                .or(reading.robot);
        }
    }
}

/// How far the robot went and turned from one pose to the next, m.
fn step(from: &Pose2D, to: &Pose2D) -> f64 {
    from.distance_to(to) + TURN * normalize_angle(to.theta - from.theta).abs()
}
