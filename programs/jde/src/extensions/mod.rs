//! What accompanies a run for the verbs: the link for tools, the recording, the node of ROS 2, and breakpoints.

mod breakpoints;
mod link;
mod page;
mod panels;
mod record;
mod ros;

use std::time::Duration;

pub(crate) use breakpoints::Breakpoints;
pub(crate) use link::LinkOptions;
pub(crate) use page::PageOptions;
pub(crate) use panels::PanelOptions;
pub(crate) use record::{
    RecordOptions, TriggerWindow, condition_failure, parse_triggers, recording_failure, recording_summary,
    report_trouble,
};
pub(crate) use ros::{CLOCK, RosOptions, SIM_TIME, SimTime, node_name as ros_node_name};

/// How often a thread that waits for a standstill looks for one.
const BREAKPOINT_INTERVAL: Duration = Duration::from_millis(20);
