//! A layout of Foxglove and Lichtblick for one application: its space, the states of its motor schemas, its log, commands over
//! time, parameters, and the service that stops everything.

use serde_json::{Value, json};

use super::channel::{Channel, LINES};
use crate::model::Model;

/// Types that the 3D panel draws.
const DRAWN: [&str; 7] = [
    "sensor_msgs/msg/LaserScan",
    "sensor_msgs/msg/PointCloud2",
    "nav_msgs/msg/OccupancyGrid",
    "nav_msgs/msg/Path",
    "geometry_msgs/msg/PoseArray",
    "geometry_msgs/msg/PoseStamped",
    "geometry_msgs/msg/PolygonStamped",
];
/// The type of commands whose speeds are plotted.
const COMMAND: &str = "geometry_msgs/msg/Twist";
/// Commands that are plotted.
const MAX_PLOTTED: usize = 3;

/// Returns the layout.
pub(super) fn of(model: &Model, channels: &[Channel]) -> Value {
    let drawn = channels
        .iter()
        .filter(|channel| DRAWN.contains(&channel.schema.0.as_str()));
    let visible: serde_json::Map<String, Value> = drawn
        .map(|channel| (channel.topic.clone(), json!({ "visible": true })))
        .collect();
    let motors = model
        .schemas
        .schemas
        .iter()
        .filter(|schema| schema.kind == "motor");
    let states = motors.map(|schema| {
        let path = format!("/jde/states{{schema==\"{}\"}}.to_state", schema.name);
        json!({ "value": path, "label": schema.name, "timestampMethod": "receiveTime" })
    });
    let commands = channels
        .iter()
        .filter(|channel| channel.schema.0 == COMMAND)
        .take(MAX_PLOTTED);
    let plots = commands.flat_map(|channel| {
        ["linear.x", "angular.z"].map(|field| {
            let path = format!("{}.{field}", channel.topic);
            json!({ "value": path, "enabled": true, "timestampMethod": "receiveTime" })
        })
    });
    let row = |first: Value, second: Value, percent: u8| json!({ "direction": "row", "first": first, "second": second, "splitPercentage": percent });
    let column = |first: Value, second: Value, percent: u8| json!({ "direction": "column", "first": first, "second": second, "splitPercentage": percent });
    let left = column(json!("3D!space"), json!("Plot!commands"), 65);
    let stop = row(json!("Parameters!modulations"), json!("CallService!stop"), 65);
    let right = column(
        json!("StateTransitions!states"),
        column(json!("RosOut!log"), stop, 50),
        35,
    );
    json!({
        "configById": {
            "3D!space": { "topics": visible },
            "StateTransitions!states": { "isSynced": true, "paths": states.collect::<Vec<_>>() },
            "RosOut!log": { "topicToRender": LINES, "minLogLevel": 1, "searchTerms": [] },
            "Plot!commands": { "paths": plots.collect::<Vec<_>>(), "isSynced": true, "showLegend": true },
            "Parameters!modulations": {},
            "CallService!stop": { "serviceName": "/jde/stop_all", "requestPayload": "{}", "buttonText": "Stop everything" },
        },
        "globalVariables": {},
        "userNodes": {},
        "playbackConfig": { "speed": 1 },
        "layout": row(left, right, 55),
    })
}
