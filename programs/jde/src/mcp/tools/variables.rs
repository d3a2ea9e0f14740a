//! Tools that show the variables of an application.

use schemars::JsonSchema;
use serde::Deserialize;
use serde_json::{Value, json};

use super::Call;
use crate::cli::tools::client::get::Reading;
use crate::cli::tools::client::vars;
use crate::failure::Failure;
use crate::mcp::answer::Answer;

/// The most variables of a call of `get`.
const MAX_NAMES: usize = 64;
/// The most characters of a value in the list.
const MAX_SHOWN: usize = 200;

/// Which variables to list.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct Patterns {
    /// The application; may be left out if only one runs.
    application: Option<String>,
    /// Full names of variables, with * for any text: "pioneer.*". All if there is none.
    #[serde(default)]
    patterns: Vec<String>,
    /// Whether to show the newest values, long ones in part.
    #[serde(default)]
    values: bool,
}

/// Which variables to read.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct Names {
    /// The application; may be left out if only one runs.
    application: Option<String>,
    /// Variables or fields: "pioneer.odometry.pose.pose.position", "pioneer.laser.ranges[90]". At most 64.
    variables: Vec<String>,
}

pub(super) fn list(call: &Call<'_>, arguments: Patterns) -> Result<Answer, Failure> {
    let remote = call.session.remote(arguments.application.as_deref())?;
    let variables = vars::select(&remote, arguments.patterns)?;
    let listed = variables.iter().map(|variable| {
        let mut listed = json!(variable);
        // The definition of a message of ROS 2 is longer than all the rest.
        if let Value::Object(fields) = &mut listed {
            fields.remove("definition");
        }
        if arguments.values {
            let mut value = vars::short_value(&remote, variable)?;
            if let Some((end, _)) = value.char_indices().nth(MAX_SHOWN) {
                value.truncate(end);
                value.push('…');
            }
            listed["value"] = json!(value);
        }
        Ok(listed)
    });
    let listed = listed.collect::<Result<Vec<_>, Failure>>()?;
    Answer::new(&json!({"application": remote.about().name, "variables": listed}))
}

pub(super) fn get(call: &Call<'_>, arguments: Names) -> Result<Answer, Failure> {
    if arguments.variables.len() > MAX_NAMES {
        return Err(Failure::broken(format!(
            "a call reads at most {MAX_NAMES} variables"
        )));
    }
    let remote = call.session.remote(arguments.application.as_deref())?;
    let read = |name: &String| Ok(Reading::request(&remote, name)?.to_json(&remote));
    let values = arguments.variables.iter().map(read);
    Answer::new(&values.collect::<Result<Vec<_>, Failure>>()?)
}
