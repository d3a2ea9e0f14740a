//! Tools that operate (R14). Each action is a hold of the agent, under a lease that ends with this server; only the stop
//! of everything lasts, and a person ends it.

use std::path::Path;

use jde_link::message::Action;
use jde_session::top;
use schemars::JsonSchema;
use serde::Deserialize;
use serde_json::{Value, json};

use super::{Call, OfApplication, OfSchema};
use crate::cli::tools::client::set::read_action;
use crate::failure::Failure;
use crate::mcp::answer::Answer;

/// A value of a modulation.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct Setting {
    /// The application; may be left out if only one runs.
    application: Option<String>,
    /// The modulation: "goon.fast".
    modulation: String,
    /// The value, in TOML or as a text, with its unit: "0.3 m/s", "kitchen", "[1.0, 2.0]".
    value: String,
}

/// A period.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct Period {
    /// The application; may be left out if only one runs.
    application: Option<String>,
    /// The schema.
    schema: String,
    /// A time or a frequency: "50ms", "20Hz".
    period: String,
}

pub(super) fn play(call: &Call<'_>, arguments: OfSchema) -> Result<Answer, Failure> {
    hold(call, arguments, |schema| Action::Play { schema })
}

pub(super) fn stop(call: &Call<'_>, arguments: OfSchema) -> Result<Answer, Failure> {
    hold(call, arguments, |schema| Action::Stop { schema })
}

pub(super) fn force(call: &Call<'_>, arguments: OfSchema) -> Result<Answer, Failure> {
    hold(call, arguments, |schema| Action::Force { schema })
}

pub(super) fn period(call: &Call<'_>, arguments: Period) -> Result<Answer, Failure> {
    let period = top::text::period(&arguments.period).map_err(Failure::broken)?;
    let of_schema = OfSchema {
        application: arguments.application,
        schema: arguments.schema,
    };
    hold(call, of_schema, |schema| Action::Period {
        schema,
        period_s: period as f64 / 1e9,
    })
}

pub(super) fn set(call: &Call<'_>, arguments: Setting) -> Result<Answer, Failure> {
    let remote = call.session.remote(arguments.application.as_deref())?;
    let value = arguments.value.trim();
    let action = read_action(&remote, &arguments.modulation, value, Path::new("."))?;
    let losses = call.session.holds.begin(&remote, &call.session.request(action))?;
    let application = &remote.about().name;
    Answer::new(&json!({"application": application, "done": true, "losses": losses}))
}

pub(super) fn release(call: &Call<'_>, arguments: OfSchema) -> Result<Answer, Failure> {
    let remote = call.session.remote(arguments.application.as_deref())?;
    let released = call.session.holds.release(&remote, &arguments.schema);
    if released == 0 {
        return Err(Failure::broken(format!(
            "this server holds nothing of `{}`",
            arguments.schema
        )));
    }
    Answer::new(&json!({"application": remote.about().name, "released": released}))
}

pub(super) fn stop_all(call: &Call<'_>, arguments: OfApplication) -> Result<Answer, Failure> {
    let (reach, name) = call.session.reach(arguments.application.as_deref())?;
    let request = call.session.request(Action::StopAll);
    let (mut stopped, mut failed) = (Vec::new(), Vec::new());
    jde_link::broadcast(
        &reach,
        name.as_deref(),
        &request,
        &mut |reply| match reply.outcome {
            Ok(roots) => stopped.push(json!({"application": reply.target, "roots": roots})),
            Err(error) => failed.push(format!("{} did not stop: {error}", reply.target)),
        },
    )?;
    if failed.is_empty() {
        return Answer::new(&json!({"stopped": stopped}));
    }
    let stopped: Value = stopped.into();
    Err(Failure::broken(format!(
        "{}; if it moves something, press the robot's own emergency stop. Stopped: {stopped}",
        failed.join("; ")
    )))
}

/// Begins a hold on a schema.
fn hold(
    call: &Call<'_>,
    OfSchema { application, schema }: OfSchema,
    action: impl FnOnce(String) -> Action,
) -> Result<Answer, Failure> {
    let remote = call.session.remote(application.as_deref())?;
    let request = call.session.request(action(schema));
    let losses = call.session.holds.begin(&remote, &request)?;
    Answer::new(&json!({"application": remote.about().name, "done": true, "losses": losses}))
}
