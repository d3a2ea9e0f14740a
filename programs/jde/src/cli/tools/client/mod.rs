//! The verbs that inspect and control a running application: clients of the link.
//!
//! A verb parses its options, sends requests and prints the replies. `remote` formats what the application
//! sends.

mod all;
pub(crate) mod apps;
mod events;
pub(crate) mod get;
pub(crate) mod operate;
pub(crate) mod panel;
mod past;
mod ps;
mod rate_limiter;
mod ready;
mod record;
mod reload;
mod resolve;
pub(crate) mod set;
mod standstill;
mod stop;
mod target;
mod top;
mod tuned;
pub(crate) mod vars;
mod watch;
pub(crate) mod why;

use clap::Subcommand;

use crate::failure::Failure;
use past::Past;
pub(crate) use target::{Context, Target};

/// The verbs of clients of the link.
#[derive(Subcommand)]
pub(crate) enum Client {
    Apps(apps::Apps),
    Ready(ready::Ready),
    Ps(ps::Ps),
    Top(top::Top),
    Vars(vars::Vars),
    Get(get::Get),
    Set(set::Set),
    Tuned(tuned::TunedArgs),
    Watch(watch::Watch),
    Events(events::Events),
    Why(why::Why),
    Panel(panel::Panel),
    Play(operate::Play),
    Stop(stop::Stop),
    Force(operate::Force),
    Release(stop::Release),
    Period(operate::Period),
    Unload(operate::Unload),
    Load(operate::Load),
    Reload(reload::Reload),
    Continue(standstill::Continue),
    Step(standstill::SingleStep),
    Record(record::Record),
}

impl Client {
    /// Whether the exit status judges something.
    pub(crate) const fn has_verdict(&self) -> bool {
        matches!(
            self,
            Self::Ready(_) | Self::Stop(_) | Self::Reload(_) | Self::Record(_)
        )
    }

    /// Runs the verb.
    pub(crate) fn run(self, context: &Context) -> Result<(), Failure> {
        let ran = match self {
            Self::Apps(apps) => apps.run(context),
            Self::Ready(ready) => ready.run(context),
            Self::Ps(ps) => ps.run(context),
            Self::Top(top) => top.run(context),
            Self::Vars(vars) => vars.run(context),
            Self::Get(get) => get.run(context),
            Self::Set(set) => set.run(context),
            Self::Tuned(tuned) => tuned.run(context),
            Self::Watch(watch) => watch.run(context),
            Self::Events(events) => events.run(context),
            Self::Why(why) => why.run(context),
            Self::Panel(panel) => panel.run(context),
            Self::Play(play) => play.run(context),
            Self::Stop(stop) => stop.run(context),
            Self::Force(force) => force.run(context),
            Self::Release(release) => release.run(context),
            Self::Period(period) => period.run(context),
            Self::Unload(unload) => unload.run(context),
            Self::Load(load) => load.run(context),
            Self::Reload(reload) => reload.run(context),
            Self::Continue(go_on) => go_on.run(context),
            Self::Step(step) => step.run(context),
            Self::Record(record) => record.run(context),
        };
        ran.and_then(|()| context.check_answers())
    }
}
