//! Every verb but `demo`.

mod check;
pub(crate) mod client;
mod completions;
mod describe;
mod docs;
pub(crate) mod experiment;
pub(crate) mod info;
mod link;
mod man;
mod mcp;
mod new;
pub(crate) mod plot;
mod plugins;
pub(crate) mod recording;
mod replay;
pub(crate) mod report;
mod ros_args;
mod ros_params;
mod run;
mod shell;
mod sim;
pub(crate) mod test;
mod validate;
mod view;
mod web;

use clap::Subcommand;
use jde_session::log::{Filter, Log};

use self::client::{Client, Context};
use crate::failure::Failure;

pub(super) use link::Link;

/// The verbs.
#[derive(Subcommand)]
pub(super) enum Tool {
    Run(run::Run),
    Experiment(experiment::ExperimentVerb),
    Test(test::Test),
    Replay(replay::Replay),
    Info(info::Info),
    Plot(plot::Plot),
    Report(report::Report),
    Sim(sim::Sim),
    Check(check::Check),
    Describe(describe::Describe),
    Validate(validate::Validate),
    Plugins(plugins::Plugins),
    New(new::New),
    Completions(completions::Completions),
    Man(man::Man),
    Docs(docs::Docs),
    #[command(flatten)]
    Client(Client),
    Shell(shell::Shell),
    Mcp(mcp::Mcp),
    View(view::View),
    Web(web::Web),
}

impl Tool {
    /// Runs the verb. `filter` selects the log of verbs that run an application. A reader that stops early does not turn a
    /// verdict into success.
    pub(super) fn run(self, filter: Option<Filter>) -> Result<(), Failure> {
        let has_verdict = self.has_verdict();
        self.run_verb(filter)
            .map_err(|failure| match has_verdict && failure.is_closed_pipe() {
                true => Failure::Unread,
                false => failure,
            })
    }

    /// Whether the exit status judges something.
    fn has_verdict(&self) -> bool {
        match self {
            Self::Replay(replay) => replay.decides(),
            Self::Client(client) => client.has_verdict(),
            other => matches!(
                other,
                Self::Experiment(_) | Self::Test(_) | Self::Check(_) | Self::Validate(_)
            ),
        }
    }

    fn run_verb(self, filter: Option<Filter>) -> Result<(), Failure> {
        match self {
            Self::Run(run) => run.run(filter),
            Self::Experiment(experiment) => experiment.run(filter),
            Self::Test(test) => test.run(),
            Self::Replay(replay) => replay.run(filter),
            Self::Info(info) => info.run(),
            Self::Plot(plot) => plot.run(),
            Self::Report(report) => report.run(),
            Self::Sim(sim) => sim.run(),
            Self::Check(check) => check.run(),
            Self::Describe(describe) => describe.run(),
            Self::Validate(validate) => validate.run(),
            Self::Plugins(plugins) => plugins.run(),
            Self::New(new) => new.run(),
            Self::Completions(completions) => completions.run(),
            Self::Man(man) => man.run(),
            Self::Docs(docs) => docs.run(),
            Self::Client(verb) => verb.run(&Context::new(Log::start(filter.unwrap_or_default()))),
            Self::Shell(shell) => shell.run(Log::start(filter.unwrap_or_default())),
            Self::Mcp(mcp) => mcp.run(filter),
            Self::View(view) => view.run(&Context::default(), filter),
            Self::Web(web) => web.run(&Context::default(), filter),
        }
    }
}
