//! Where the values of the robots of a run come from, found by the types of exports.

use jde_abi::describe::{Role, Type};
use jde_app::Application;
use jde_types::{Body, LaserScan, Odometry, Truth, Value};

/// An export of a schema.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Export {
    /// The schema.
    pub owner: String,
    /// What the feeder of a timeline knows it by: the name of a variable, or a topic.
    pub key: String,
}

impl Export {
    /// Returns the exports of a type of an application, by the names of variables.
    #[must_use]
    pub fn of_application(application: &Application, value_type: &Type) -> Vec<Self> {
        let exports = application.instances.iter().flat_map(|instance| {
            let ports = instance.schema.ports.iter();
            let ports = ports.filter(|port| {
                matches!(port.role, Role::Export { .. }) && port.value_type.name == value_type.name
            });
            ports.map(|port| Self {
                owner: instance.name.clone(),
                key: format!("{}.{}", instance.name, port.name),
            })
        });
        exports.collect()
    }
}

/// A robot, and the keys of the exports that tell of it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RobotSources {
    /// Its name: that of the schema which exports its pose.
    pub name: String,
    /// The ground truth.
    pub truth: Option<String>,
    /// The odometry.
    pub odometry: Option<String>,
    /// A laser.
    pub laser: Option<String>,
    /// The body.
    pub body: Option<String>,
}

impl RobotSources {
    /// Finds the robots among exports by type. Schemas that correct odometry export it as well, so a robot is a schema with
    /// ground truth, or else one that takes commands, or else the first with odometry.
    ///
    /// Returns also the schemas whose odometry is not shown, since it has a frame of its own.
    pub fn find(
        exports: impl Fn(&Type) -> Vec<Export>,
        is_commanded: impl Fn(&str) -> bool,
    ) -> (Vec<Self>, Vec<String>) {
        let [truths, odometries, lasers, bodies] = [
            Truth::describe(),
            Odometry::describe(),
            LaserScan::describe(),
            Body::describe(),
        ]
        .map(|value_type| exports(&value_type));
        let (commanded, others): (Vec<_>, Vec<_>) = odometries
            .iter()
            .partition(|odometry| is_commanded(&odometry.owner));
        let has_truth = |export: &&&Export| truths.iter().any(|truth| truth.owner == export.owner);
        let (naming, left_out): (Vec<&Export>, Vec<&Export>) = if !truths.is_empty() {
            let unknown = commanded.iter().filter(|odometry| !has_truth(odometry));
            (truths.iter().collect(), unknown.copied().collect())
        } else if !commanded.is_empty() {
            (commanded, Vec::new())
        } else if let Some((first, others)) = others.split_first() {
            (vec![*first], others.to_vec())
        } else {
            (lasers.iter().take(1).collect(), Vec::new())
        };
        let is_single = naming.len() == 1;
        // The robot's own export of a type; for a single robot, any of that type.
        let of = |robot: &Export, exports: &[Export]| {
            let own = exports.iter().find(|export| export.owner == robot.owner);
            let own = own.or(exports.first().filter(|_| is_single));
            own.map(|export| export.key.clone())
        };
        let robots = naming.into_iter().map(|robot| Self {
            name: robot.owner.clone(),
            truth: of(robot, &truths),
            odometry: of(robot, &odometries),
            laser: of(robot, &lasers),
            body: of(robot, &bodies),
        });
        let left_out = left_out.into_iter().map(|odometry| odometry.owner.clone());
        (robots.collect(), left_out.collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The names and ground truths of the robots, and those left out, of schemas with ground truth, with odometry, and with
    /// commands.
    fn found(truths: &[&str], odometries: &[&str], commanded: &[&str]) -> (Vec<(String, bool)>, Vec<String>) {
        let exports = |value_type: &Type| {
            let owners = match value_type.name.rsplit('/').next() {
                Some("Truth") => truths,
                Some("Odometry") => odometries,
                _ => &[],
            };
            let export = |owner: &&str| Export {
                owner: (*owner).to_owned(),
                key: format!("{owner}.{}", value_type.name),
            };
            owners.iter().map(export).collect()
        };
        let (robots, left_out) = RobotSources::find(exports, |owner| commanded.contains(&owner));
        let robots = robots
            .into_iter()
            .map(|robot| (robot.name, robot.truth.is_some()));
        (robots.collect(), left_out)
    }

    #[test]
    fn a_robot_has_ground_truth_or_takes_commands_or_is_the_first_with_odometry() {
        let robot = |name: &str, has_truth| (name.to_owned(), has_truth);
        assert_eq!(
            found(&["pioneer"], &["pioneer", "slam", "real"], &["pioneer", "real"]),
            (vec![robot("pioneer", true)], vec!["real".to_owned()])
        );
        assert_eq!(
            found(&[], &["slam", "left", "right"], &["left", "right"]),
            (vec![robot("left", false), robot("right", false)], vec![])
        );
        assert_eq!(
            found(&[], &["odom", "slam"], &[]),
            (vec![robot("odom", false)], vec!["slam".to_owned()])
        );
    }
}
