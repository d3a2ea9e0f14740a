//! Poses in the values of Nav2's action.

use jde_ros_node::interface::{Interfaces, humble, standard};
use jde_ros_node::{Action, Middleware, Settings, names};
use jde_schema::prelude::*;
use serde_json::{Value as Json, json};

/// The type of the action.
const TYPE: &str = "nav2_msgs/action/NavigateToPose";

/// The action of that name, in the form that the nodes behind this middleware have.
///
/// # Errors
/// If the name is empty, or not valid in ROS 2.
pub(crate) fn action(namespace: &str, name: &str, middleware: Middleware) -> Result<Action, String> {
    let name = names::topic(namespace, name)?.ok_or("an action has a name, as in \"navigate_to_pose\"")?;
    let action = Action::of_interface(name, TYPE, interfaces(middleware));
    action.ok_or_else(|| format!("{TYPE} is not known"))
}

/// The interfaces of the nodes behind this middleware.
fn interfaces(middleware: Middleware) -> &'static Interfaces {
    match middleware {
        Middleware::RmwHumble => humble(),
        Middleware::Rmw | Middleware::Bridge => standard(),
    }
}

/// Encodes a part of the action: `Goal`, `Feedback` or `GetResult_Response`.
///
/// # Panics
/// If the value has a field that the part does not have.
pub(crate) fn encode(middleware: Middleware, part: &str, value: &Json) -> Vec<u8> {
    match interfaces(middleware).encode(&format!("{TYPE}_{part}"), value) {
        Ok(message) => message,
        Err(error) => panic!("a value of {TYPE}_{part}: {error}"),
    }
}

/// Decodes a part of the action.
///
/// # Errors
/// If the message is none.
pub(crate) fn decode(middleware: Middleware, part: &str, message: &[u8]) -> Result<Json, String> {
    let value = interfaces(middleware).decode(&format!("{TYPE}_{part}"), message);
    value.map_err(|error| error.to_string())
}

/// The message of the result of a goal: nothing in Humble, otherwise the error and why.
pub(crate) fn result(middleware: Middleware, code: u16, why: &str) -> Vec<u8> {
    let result = match middleware {
        Middleware::RmwHumble => json!({}),
        Middleware::Rmw | Middleware::Bridge => json!({ "error_code": code, "error_msg": why }),
    };
    encode(middleware, "GetResult_Response", &json!({ "result": result }))
}

/// Refuses a connection that services and actions do not pass.
///
/// # Errors
/// If it is one to a bridge of DDS.
pub(crate) fn refuse_bridge(settings: &Settings<'_>) -> Result<(), &'static str> {
    match settings.middleware() {
        Middleware::Bridge => {
            Err("services and actions do not pass a bridge of DDS: connect to a router of rmw_zenoh")
        }
        Middleware::Rmw | Middleware::RmwHumble => Ok(()),
    }
}

/// A `geometry_msgs/msg/PoseStamped` of a pose.
pub(crate) fn stamped(pose: Pose2D, frame: &str, stamp: Time) -> Json {
    let Pose {
        position,
        orientation,
    } = pose.into();
    json!({
        "header": { "stamp": { "sec": stamp.sec, "nanosec": stamp.nanosec }, "frame_id": frame },
        "pose": {
            "position": { "x": position.x, "y": position.y },
            "orientation": { "z": orientation.z, "w": orientation.w },
        },
    })
}

/// Returns a pose in the frame of the targets.
///
/// # Errors
/// Why it cannot be driven to.
pub(crate) fn check(stated: &str, pose: Pose2D, frame: &str) -> Result<Pose2D, String> {
    if stated.is_empty() {
        return Err(format!(
            "its frame_id is empty, and targets here are in \"{frame}\": state the frame"
        ));
    }
    if stated.trim_start_matches('/') != frame {
        return Err(format!(
            "it is in the frame \"{stated}\", and targets here are in \"{frame}\""
        ));
    }
    let is_finite = pose.is_finite().then_some(pose);
    is_finite.ok_or_else(|| "its numbers are not finite".to_owned())
}

/// The pose of a `geometry_msgs/msg/PoseStamped`, in that frame.
///
/// # Errors
/// Why it cannot be driven to.
pub(crate) fn pose(stamped: &Json, frame: &str) -> Result<Pose2D, String> {
    let stated = stamped["header"]["frame_id"].as_str().unwrap_or_default();
    let number = |part: &str, axis: &str| stamped["pose"][part][axis].as_f64();
    let orientation = || {
        Some(Quaternion {
            x: number("orientation", "x")?,
            y: number("orientation", "y")?,
            z: number("orientation", "z")?,
            w: number("orientation", "w")?,
        })
    };
    let pose = || {
        Some(Pose2D::new(
            number("position", "x")?,
            number("position", "y")?,
            orientation()?.yaw(),
        ))
    };
    let nowhere = Pose2D::new(f64::NAN, f64::NAN, f64::NAN);
    check(stated, pose().unwrap_or(nowhere), frame)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pose_survives_and_another_frame_or_none_is_refused() {
        let expected = Pose2D::new(1.0, -2.0, 0.5);
        let value = stamped(expected, "map", Time { sec: 3, nanosec: 4 });
        let interface = "geometry_msgs/msg/PoseStamped";
        let message = standard().encode(interface, &value).expect("it is one");
        let value = standard().decode(interface, &message).expect("it is one");
        let found = pose(&value, "map").expect("it has a pose");
        assert!(found.distance_to(&expected) < 1e-12 && (found.theta - 0.5).abs() < 1e-12);
        let error = pose(&value, "odom").expect_err("another frame");
        assert!(error.contains("\"map\"") && error.contains("\"odom\""), "{error}");
        let nothing = standard().encode(interface, &json!({})).expect("it is one");
        let nothing = standard().decode(interface, &nothing).expect("it is one");
        let error = pose(&nothing, "map").expect_err("a goal that states nothing is none");
        assert!(error.contains("frame_id is empty"), "{error}");
        let mut endless = value;
        endless["pose"]["position"]["x"] = Json::Null;
        assert!(pose(&endless, "map").is_err());
    }
}
