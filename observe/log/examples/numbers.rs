//! Prints the numbers of every laser scan and every odometry message of a recording, as one line of JSON
//! each, to compare them with what other programs read.
//!
//! ```text
//! cargo run -p jde -- run safe-navigation --lockstep --for 10s --record drive.mcap
//! cargo run -p jde-log --example numbers drive.mcap
//! ```
//!
//! prints lines like
//!
//! ```text
//! {"topic":"/pioneer/odometry","log_time":1795271914047402112,"numbers":[1.5,2.25,0.4]}
//! ```

use std::error::Error;
use std::io::Write;

use jde_log::Recording;
use jde_ros::cdr;
use jde_types::{LaserScan, Odometry, Value};

fn main() -> Result<(), Box<dyn Error>> {
    let file = std::env::args_os()
        .nth(1)
        .ok_or("name a recording: numbers FILE.mcap")?;
    let mut out = std::io::stdout().lock();
    for message in Recording::open(file.as_ref())?.messages()? {
        let message = message?;
        let numbers = match message.channel.type_name.as_str() {
            "sensor_msgs/msg/LaserScan" => {
                let scan: LaserScan = value(&message.data)?;
                scan.ranges.iter().map(|range| f64::from(*range)).collect()
            }
            "nav_msgs/msg/Odometry" => {
                let odometry: Odometry = value(&message.data)?;
                let (pose, twist) = (odometry.pose.pose, odometry.twist.twist);
                vec![pose.position.x, pose.position.y, twist.linear.x, twist.angular.z]
            }
            _ => continue,
        };
        let line = serde_json::json!({
            "topic": message.channel.topic,
            "log_time": message.log_time,
            // JSON has no infinity, so a beam that hit nothing is null.
            "numbers": numbers.iter().map(|number: &f64| number.is_finite().then_some(*number)).collect::<Vec<_>>(),
        });
        writeln!(out, "{line}")?;
    }
    Ok(())
}

fn value<T: Value>(message: &[u8]) -> Result<T, Box<dyn Error>> {
    let bytes = cdr::decode(&T::describe(), message)?;
    Ok(T::from_bytes(&bytes).ok_or("as many bytes as the type has")?)
}
