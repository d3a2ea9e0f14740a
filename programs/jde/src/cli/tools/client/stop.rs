//! Verbs that stop and release one schema or everything (R14).

use clap::Args;
use clap_complete::ArgValueCompleter;
use jde_link::message::Action;

use super::operate::{DurationArg, SchemaArg};
use super::{Context, Target, all};
use crate::complete;
use crate::failure::Failure;
use crate::remote::name::split_application;

/// One schema, or everything.
#[derive(Args)]
#[group(required = true, multiple = false)]
struct SchemaOrAll {
    /// The schema, or APP:SCHEMA.
    #[arg(value_name = "SCHEMA", add = ArgValueCompleter::new(complete::schemas))]
    schema: Option<String>,
    /// All roots of all applications, or of the application that --app names.
    #[arg(long)]
    all: bool,
}

/// What to stop or release, in which application.
#[derive(Args)]
struct ScopeArgs {
    #[command(flatten)]
    which: SchemaOrAll,
    #[command(flatten)]
    target: Target,
}

/// Keep a schema asleep, or stop everything at once.
///
/// With --all every root sleeps, with everything below it, and every command of every driver is neutral.
/// No application ends, and `jde release --all` releases everything. The exit status is 0 only if everything
/// was stopped.
#[derive(Args)]
#[command(after_help = "Examples:
  jde stop goon
  jde stop goon --for 10s
  jde stop --all
  jde stop --all --app robot2 --at tls/robot2:7447")]
pub(crate) struct Stop {
    #[command(flatten)]
    scope: ScopeArgs,
    #[command(flatten)]
    lasting: DurationArg,
}

/// Release a schema: undo the actions of all operators on it. With --all, release everything that was stopped
/// at once.
#[derive(Args)]
#[command(after_help = "Examples:
  jde release goon
  jde release --all")]
pub(crate) struct Release {
    #[command(flatten)]
    scope: ScopeArgs,
}

impl Stop {
    pub(crate) fn run(self, context: &Context) -> Result<(), Failure> {
        match self.scope.into_schema() {
            Ok(schema) => schema.act(
                context,
                |schema| Action::Stop { schema },
                &self.lasting,
                "is stopped",
            ),
            Err(_) if self.lasting.time.is_some() => Err(Failure::usage(
                "a stop of everything cannot end by itself",
                "omit --for, and let it continue with `jde release --all`",
            )),
            Err(target) => all::stop(context, &target),
        }
    }
}

impl Release {
    pub(crate) fn run(self, context: &Context) -> Result<(), Failure> {
        let lasting = DurationArg { time: None };
        match self.scope.into_schema() {
            Ok(schema) => {
                let done = match is_held(context, &schema)? {
                    true => "is released",
                    false => "was held by nobody",
                };
                schema.act(context, |schema| Action::Release { schema }, &lasting, done)
            }
            Err(target) => all::release(context, &target),
        }
    }
}

/// Whether an operator holds a schema to anything.
fn is_held(context: &Context, schema: &SchemaArg) -> Result<bool, Failure> {
    let (named, name) = split_application(&schema.schema);
    let now = context.remote(&schema.target, named)?.hierarchy()?;
    let mut schemas = now.schemas.iter();
    Ok(schemas.any(|view| view.name == name && view.holds().next().is_some()))
}

impl ScopeArgs {
    /// Returns the one schema, or the target whose applications are all included.
    fn into_schema(self) -> Result<SchemaArg, Target> {
        let Self { which, target } = self;
        match which.schema {
            Some(schema) => Ok(SchemaArg { schema, target }),
            None => Err(target),
        }
    }
}
