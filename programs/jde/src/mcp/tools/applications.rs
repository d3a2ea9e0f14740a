//! Tools that show running applications: which there are, their hierarchies, and why a schema acts.

use schemars::JsonSchema;
use serde::Deserialize;
use serde_json::json;

use super::{Call, OfApplication};
use crate::cli::tools::client::apps::Listing;
use crate::cli::tools::client::why::Selections;
use crate::failure::Failure;
use crate::mcp::answer::Answer;

/// No arguments.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct Nothing {}

/// A question about a selection.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct Question {
    /// The application; may be left out if only one runs.
    application: Option<String>,
    /// A recording to ask instead: a file in the folder of this server.
    recording: Option<String>,
    /// Names of schemas, and a group or a time if needed: "did vff take over from goon at 12.4s", "is goon not the winner",
    /// "nobody in example/base", "at 12.4s".
    question: String,
}

pub(super) fn list(call: &Call<'_>, _: Nothing) -> Result<Answer, Failure> {
    let mut listing = Listing::request(&call.session.client()?)?;
    if let Some(only) = call.session.only() {
        listing.entries.retain(|entry| entry.about.name == only);
    }
    Answer::new(&json!({"applications": listing.entries, "problems": listing.problems()}))
}

pub(super) fn hierarchy(call: &Call<'_>, arguments: OfApplication) -> Result<Answer, Failure> {
    let remote = call.session.remote(arguments.application.as_deref())?;
    Answer::new(&json!({"application": remote.about().name, "hierarchy": remote.hierarchy()?}))
}

pub(super) fn why(call: &Call<'_>, arguments: Question) -> Result<Answer, Failure> {
    let selections = match (&arguments.recording, &arguments.application) {
        (Some(_), Some(_)) => {
            return Err(Failure::broken(
                "a question is for an application or for a recording",
            ));
        }
        (Some(recording), None) => Selections::of_recording(&super::recordings::open(call, recording)?)?,
        (None, named) => Selections::of_application(&call.session.remote(named.as_deref())?)?,
    };
    let words: Vec<String> = arguments.question.split_whitespace().map(str::to_owned).collect();
    let question = selections.read_question(&words)?;
    Answer::new(&json!({"selection": selections.find(&question)?, "notes": selections.notes}))
}
