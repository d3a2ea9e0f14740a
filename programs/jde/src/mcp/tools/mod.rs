//! The tools, in one table: what is listed, and what a call may do, is read from it. Descriptions are fixed; nothing from
//! a robot or a file is in them.

mod applications;
mod operate;
mod pictures;
mod recordings;
mod simulate;
mod variables;

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use rmcp::handler::server::tool::schema_for_type;
use rmcp::model::{JsonObject, ToolAnnotations};
use schemars::JsonSchema;
use serde::Deserialize;
use serde::de::DeserializeOwned;

use super::answer::Answer;
use super::session::Session;
use crate::failure::Failure;

/// What a tool does to robots.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Right {
    /// Reads, and changes nothing.
    Inspect,
    /// Runs an application in the simulator, in processes of its own.
    Simulate,
    /// Stops everything: always permitted.
    Stop,
    /// Acts as an operator.
    Operate,
}

/// A tool.
pub(super) struct Tool {
    pub(super) name: &'static str,
    pub(super) right: Right,
    description: &'static str,
    /// The schema of its arguments.
    schema: fn() -> Arc<JsonObject>,
    /// What it does. It may wait.
    pub(super) call: fn(&Call<'_>, JsonObject) -> Result<Answer, Failure>,
}

/// What a tool gets besides its arguments.
pub(super) struct Call<'c> {
    pub(super) session: &'c Session,
    /// Set when the answer is of no use any more.
    pub(super) abort: &'c AtomicBool,
}

/// The application of a call.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct OfApplication {
    /// The application; may be left out if only one runs.
    application: Option<String>,
}

/// A schema of an application.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct OfSchema {
    /// The application; may be left out if only one runs.
    application: Option<String>,
    /// The schema.
    schema: String,
}

macro_rules! table {
    ($($name:literal, $right:ident, $call:path, $arguments:ty, $description:literal;)*) => {
        /// All tools.
        pub(super) static TOOL_TABLE: &[Tool] = &[$(Tool {
            name: $name,
            right: Right::$right,
            description: $description,
            schema: schema_for_type::<$arguments>,
            call: |call, arguments| $call(call, parse(arguments)?),
        }),*];
    };
}

table! {
    "applications", Inspect, applications::list, applications::Nothing,
        "Lists the running applications: name, machine, file, and which schemas act.";
    "hierarchy", Inspect, applications::hierarchy, OfApplication,
        "Shows every schema of an application with its state, health, periods, load and counts, every group with its winner, and what operators hold.";
    "why", Inspect, applications::why, applications::Question,
        "Explains a selection: why a schema won, lost or did not act, or why nobody won, in a running application or in a recording.";
    "variables", Inspect, variables::list, variables::Patterns,
        "Lists the variables of an application: type, unit, meaning, age, writer and, if asked for, the newest value in short.";
    "get", Inspect, variables::get, variables::Names,
        "Reads the newest values of variables or of their fields, with time, age and writer.";
    "picture", Inspect, pictures::variable, pictures::Variable,
        "Returns the newest picture of a variable of the type Image or CompressedImage.";
    "panel", Inspect, pictures::panel, OfSchema,
        "Shows a schema's own panel: its widgets as text, and its pictures.";
    "recording", Inspect, recordings::info, recordings::OfRecording,
        "Surveys a recording: time, topics, selections of each group, faults, and what is damaged or missing.";
    "report", Inspect, recordings::report, recordings::Report,
        "Reports on a recording: the takeovers with their reasons, the events, a picture of the path and of the states, and the HTML page if asked for.";
    "check", Inspect, simulate::check, simulate::Check,
        "Checks an application's file without starting it: every fault with its place, or what would run and the contract of each group.";
    "test", Simulate, simulate::test, simulate::Tests,
        "Runs tests of an application in the simulator, in virtual time. No robot moves.";
    "experiment", Simulate, simulate::experiment, simulate::ExperimentFile,
        "Runs an experiment: many simulated drives, judged and measured. No robot moves, and no file is written.";
    "stop_all", Stop, operate::stop_all, OfApplication,
        "Stops everything at once, in all applications or in one: every root sleeps and every command is neutral. Only a person lets it go on.";
    "play", Operate, operate::play, OfSchema,
        "Keeps a schema awake, as its father would, until it is released or this server ends.";
    "stop", Operate, operate::stop, OfSchema,
        "Keeps a schema asleep until it is released or this server ends.";
    "force", Operate, operate::force, OfSchema,
        "Makes a motor schema the winner of its group while it is awake, until it is released or this server ends.";
    "release", Operate, operate::release, OfSchema,
        "Ends everything that this server holds of a schema. What other operators hold stays.";
    "set", Operate, operate::set, operate::Setting,
        "Writes a modulation of a schema, with its unit, until it is released or this server ends.";
    "period", Operate, operate::period, operate::Period,
        "Sets another period of a schema, until it is released or this server ends.";
}

impl Tool {
    /// Returns what clients see of it.
    pub(super) fn describe(&self) -> rmcp::model::Tool {
        let reads = matches!(self.right, Right::Inspect | Right::Simulate);
        rmcp::model::Tool::new(self.name, self.description, (self.schema)()).with_annotations(
            ToolAnnotations::new()
                .read_only(reads)
                .destructive(self.right == Right::Operate)
                .open_world(false),
        )
    }
}

/// Reads the arguments of a call. Unknown ones are refused.
fn parse<T: DeserializeOwned>(arguments: JsonObject) -> Result<T, Failure> {
    serde_json::from_value(arguments.into())
        .map_err(|error| Failure::broken(format!("the arguments do not fit: {error}")))
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn every_tool_has_a_name_of_its_own_and_refuses_unknown_arguments() {
        let names: BTreeSet<_> = TOOL_TABLE.iter().map(|tool| tool.name).collect();
        assert_eq!(names.len(), TOOL_TABLE.len());
        for tool in TOOL_TABLE {
            let schema = (tool.schema)();
            assert_eq!(schema["type"], "object", "{}", tool.name);
            assert_eq!(schema["additionalProperties"], false, "{}", tool.name);
        }
    }

    #[test]
    fn what_changes_a_robot_needs_the_right_to_operate_and_a_stop_of_everything_needs_none() {
        let of = |name: &str| TOOL_TABLE.iter().find(|tool| tool.name == name).unwrap();
        for name in ["play", "stop", "force", "release", "set", "period"] {
            assert_eq!(of(name).right, Right::Operate, "{name}");
        }
        assert_eq!(of("stop_all").right, Right::Stop);
        let changes = TOOL_TABLE
            .iter()
            .filter(|tool| tool.describe().annotations.unwrap().read_only_hint != Some(true));
        assert_eq!(changes.count(), 7);
    }
}
