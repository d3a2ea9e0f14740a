//! The verbs by which an operator plays, forces, re-times, unloads and loads one schema (R14), and the common
//! code of all operators' actions.

use std::io::Write;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::{Duration, Instant};

use clap::Args;
use clap_complete::ArgValueCompleter;
use jde_app::period::{from_seconds, is_far_longer};
use jde_core::Nanos;
use jde_link::message::{Action, Request, SchemaInfo};
use jde_link::{Error, Hold, Remote};
use jde_session::top;
use jde_terminal::interrupt::SignalListener;
use jde_terminal::{self as terminal, FAINT, GOOD, WARN};

use super::{Context, Target};
use crate::complete;
use crate::failure::Failure;
use crate::quantity;
use crate::remote::name::split_application;
use crate::remote::request;

/// How long a hold stays in force without its client.
const HOLD_LEASE: Duration = Duration::from_secs(1);
/// The interval at which a hold is checked.
const CHECK_INTERVAL: Duration = Duration::from_millis(100);

/// A schema, and its application.
#[derive(Args)]
pub(super) struct SchemaArg {
    /// The schema, or APP:SCHEMA.
    #[arg(value_name = "SCHEMA", add = ArgValueCompleter::new(complete::schemas))]
    pub(super) schema: String,
    #[command(flatten)]
    pub(super) target: Target,
}

/// The duration of an action.
#[derive(Args)]
pub(super) struct DurationArg {
    /// End the action after this time, at Ctrl-C, or one second after this program ends or the network fails.
    /// Without it, the action stays until it is released.
    #[arg(long = "for", value_name = "TIME", allow_hyphen_values = true, value_parser = quantity::time)]
    pub(super) time: Option<Nanos>,
}

/// The messages of an action.
pub(super) struct ActionMessages {
    /// Printed when the action is in force.
    pub(super) done: String,
    /// Printed when it is over.
    pub(super) ended: String,
}

macro_rules! verbs {
    ($($(#[$doc:meta])* $name:ident, $action:expr, $done:literal;)*) => { $(
        #[derive(Args)]
        $(#[$doc])*
        pub(crate) struct $name {
            #[command(flatten)]
            schema: SchemaArg,
            #[command(flatten)]
            lasting: DurationArg,
        }

        impl $name {
            pub(crate) fn run(self, context: &Context) -> Result<(), Failure> {
                self.schema.act(context, $action, &self.lasting, $done)
            }
        }
    )* };
}

verbs! {
    /// Keep a schema awake, as its father would.
    #[command(after_help = "Examples:
  jde play goon
  jde play robot2:goon --for 10s")]
    Play, |schema| Action::Play { schema }, "is kept awake";

    /// Make a motor schema the winner of its group while it is awake.
    #[command(after_help = "Examples:
  jde force stop --for 5s")]
    Force, |schema| Action::Force { schema }, "is forced to win";
}

/// Set another period of a schema.
#[derive(Args)]
#[command(after_help = "Examples:
  jde period vff 50ms
  jde period vff 20Hz --for 1min")]
pub(crate) struct Period {
    #[command(flatten)]
    schema: SchemaArg,
    /// The period: a time or a frequency, such as 50ms or 20Hz.
    #[arg(value_name = "TIME", value_parser = top::text::period)]
    period: Nanos,
    #[command(flatten)]
    lasting: DurationArg,
}

/// End a schema's instance between two iterations, and keep it unloaded until it is loaded; its variables
/// stay.
#[derive(Args)]
#[command(after_help = "Examples:
  jde unload vff
  jde unload ball                   a plugin: all its schemas")]
pub(crate) struct Unload {
    #[command(flatten)]
    schema: SchemaArg,
}

/// Make a new instance of an unloaded schema, and return control of it to its father.
#[derive(Args)]
#[command(after_help = "Examples:
  jde load vff
  jde load ball")]
pub(crate) struct Load {
    #[command(flatten)]
    schema: SchemaArg,
}

impl Period {
    pub(crate) fn run(self, context: &Context) -> Result<(), Failure> {
        let period_s = self.period as f64 / 1e9;
        let done = format!("now runs every {}", top::text::format_setting(self.period));
        let action = |schema| Action::Period { schema, period_s };
        self.schema.act(context, action, &self.lasting, &done)
    }
}

impl Unload {
    pub(crate) fn run(self, context: &Context) -> Result<(), Failure> {
        let action = |schema| Action::Unload { schema };
        self.schema
            .act(context, action, &DurationArg { time: None }, "is unloaded")
    }
}

impl Load {
    pub(crate) fn run(self, context: &Context) -> Result<(), Failure> {
        let action = |schema| Action::Load { schema };
        self.schema
            .act(context, action, &DurationArg { time: None }, "is loaded")
    }
}

impl SchemaArg {
    pub(super) fn act(
        &self,
        context: &Context,
        action: impl FnOnce(String) -> Action,
        lasting: &DurationArg,
        done: &str,
    ) -> Result<(), Failure> {
        let (named, schema) = split_application(&self.schema);
        let remote = context.remote(&self.target, named)?;
        let messages = ActionMessages {
            done: format!("{schema} {done}"),
            ended: format!("{schema} is released from this hold"),
        };
        let done = perform_action(&remote, action(schema.to_owned()), lasting, &messages);
        if let Err(Failure::Link(Error::Refused { nearest: None, .. })) = &done {
            check_known(&remote, "schema", schema)?;
        }
        done
    }
}

/// Refuses a name that is neither of a schema nor of a plugin, and names those that exist.
pub(super) fn check_known(remote: &Remote, what: &str, name: &str) -> Result<(), Failure> {
    let schemas = remote.schemas()?.schemas;
    let of_plugin = |info: &SchemaInfo| info.type_name.split('/').next() == Some(name);
    if schemas.iter().any(|info| info.name == name || of_plugin(info)) {
        return Ok(());
    }
    let names = schemas.iter().map(|info| info.name.as_str());
    Err(Failure::unknown(what, name, names))
}

/// Performs an action. With a duration, holds it and returns at its end.
pub(super) fn perform_action(
    remote: &Remote,
    action: Action,
    lasting: &DurationArg,
    messages: &ActionMessages,
) -> Result<(), Failure> {
    warn_of_period(remote, &action)?;
    let request = request(action);
    let mut out = terminal::out();
    let Some(time) = lasting.time.map(Duration::from_nanos) else {
        let losses = remote.operate_reporting(&request)?;
        writeln!(out, "{GOOD}{}{GOOD:#}{}", messages.done, lost(&losses))?;
        return Ok(());
    };
    let (interrupt, interrupted) = channel();
    let _interrupts = SignalListener::on_first(move || {
        // The receiver outlives the listener.
        let _ = interrupt.send(());
    })?;
    let hold = begin_hold(remote, &request)?;
    writeln!(
        out,
        "{GOOD}{}{GOOD:#} {FAINT}for {:.1} s, or until Ctrl-C{FAINT:#}{}",
        messages.done,
        time.as_secs_f64(),
        lost(hold.losses())
    )?;
    out.flush()?;
    let end = Instant::now() + time;
    while let remaining @ 1.. = end.saturating_duration_since(Instant::now()).as_millis() {
        let wait = CHECK_INTERVAL.min(Duration::from_millis(
            u64::try_from(remaining).unwrap_or(u64::MAX),
        ));
        match interrupted.recv_timeout(wait) {
            Err(RecvTimeoutError::Timeout) => {}
            Ok(()) | Err(RecvTimeoutError::Disconnected) => break,
        }
        if let Some(reason) = hold.lost() {
            return Err(Failure::broken(format!(
                "the hold ended before its time: {reason}"
            )));
        }
    }
    drop(hold);
    writeln!(out, "{}", messages.ended)?;
    Ok(())
}

/// Warns of a period that is so far from the one at the start that its unit is probably wrong.
fn warn_of_period(remote: &Remote, action: &Action) -> Result<(), Failure> {
    let Action::Period { schema, period_s } = action else {
        return Ok(());
    };
    let schemas = remote.schemas()?.schemas;
    let Some(info) = schemas.iter().find(|info| info.name == *schema) else {
        return Ok(());
    };
    let (Ok(period), Ok(usual)) = (from_seconds(*period_s), from_seconds(info.period_s)) else {
        return Ok(());
    };
    if is_far_longer(period, usual) || is_far_longer(usual, period) {
        writeln!(
            terminal::err(),
            "{WARN}warning{WARN:#}: the period of `{schema}` becomes {}, and was {} at the start; check the unit",
            top::text::format_setting(period),
            top::text::format_setting(usual)
        )?;
    }
    Ok(())
}

/// Begins a hold that ends with this process: when it is dropped, or [`HOLD_LEASE`] after the process died or the network
/// failed.
///
/// # Errors
/// The application is a recording, refuses the action, or gives no answer.
pub(crate) fn begin_hold(remote: &Remote, request: &Request) -> Result<Hold, Failure> {
    if remote.about().executor == "replay" {
        return Err(Failure::usage(
            "changes of a recording do not end by themselves",
            "omit --for",
        ));
    }
    Ok(remote.hold(request, HOLD_LEASE)?)
}

/// What awake schemas lose by an action, to append to its message.
fn lost(losses: &str) -> String {
    if losses.is_empty() {
        String::new()
    } else {
        format!("; {WARN}{losses}{WARN:#}")
    }
}
