//! A signal ends a run in order from the moment at which others can find it.

use std::path::Path;
use std::sync::Arc;

use jde_host::{StartHook, StartHookError};
use jde_loader::{Plugins, SearchPath};
use jde_records::event::{Event, Observer};
use jde_session::load::LoadedApplication;
use jde_session::log::{Filter, Log};
use jde_session::run::{
    Extension, Finished, PreparedExtension, ProgressMode, RecordingSummary, RunContext, RunOptions, RunView,
    run,
};
use jde_session::summary::Ending;
use jde_watchdog::Watchdog;
use rustix::process::{Signal, getpid, kill_process};

/// Sends the process a signal where the link would open.
struct SignalAtStart;

impl Extension for SignalAtStart {
    fn prepare(&self, _: &RunContext<'_>) -> Result<Option<Box<dyn PreparedExtension>>, StartHookError> {
        Ok(Some(Box::new(Self)))
    }
}

impl PreparedExtension for SignalAtStart {
    fn observer(&self) -> Box<dyn Observer> {
        Box::new(|_: &Event| {})
    }

    fn before_start(&self, _: &Arc<Plugins>) -> StartHook {
        Box::new(|_| Ok(kill_process(getpid(), Signal::TERM)?))
    }

    fn finish(&self) -> Option<RecordingSummary> {
        None
    }
}

#[test]
fn r10_a_signal_before_the_first_iteration_stops_a_run_of_either_kind() {
    let _watchdog = Watchdog::for_test();
    let folder = jde_test_plugins::folder(&["pair"]);
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../apps/pair.toml");
    let log = Log::start(Filter::default());
    for lockstep in [true, false] {
        let mut path = SearchPath::default();
        path.push(&folder, "built for this test");
        let plugins = Plugins::new(path);
        let application = jde_app::load(&file, &[], &plugins).unwrap_or_else(|faults| panic!("{faults}"));
        let loaded = LoadedApplication {
            application,
            plugins,
            skipped_folders: Vec::new(),
        };
        let options = RunOptions {
            lockstep,
            limit: None,
            speed: 1.0,
            view: RunView::Lines(ProgressMode::Nothing),
            output: Box::new(std::io::sink()),
            decisions: None,
            picture: None,
            extensions: vec![Box::new(SignalAtStart)],
            stopped: false,
            watch: false,
        };
        let Ok(Finished { summary, .. }) = run(loaded, options, &log) else {
            panic!("the run starts");
        };
        assert_eq!(summary.outcome, Ending::Stopped);
    }
}
