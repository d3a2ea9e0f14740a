//! Who is called, and when, as whoever runs the instances sees it.

use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, OnceLock, Weak};

use jde_core::{Check, Nanos};
use jde_schema::derived::raw;
use jde_schema::prelude::*;

use super::{Bells, Engine, Signal};
use crate::app::parse;
use crate::clock::Clock;
use crate::plugin::{Plugins, SearchPath};

/// Wants to act whenever it is told to.
#[derive(Describe)]
#[schema(motor, period = "10ms")]
struct Act {}

impl Schema for Act {
    fn iterate(&mut self, _: &Context) -> jde_schema::Result {
        Ok(())
    }
}

static PLUGIN: raw::Plugin = jde_schema::plugin!("engine-tests", "Two that compete.", [Act]);

const TWO: &str = r#"
    roots = ["first", "second"]
    [schemas.first]
    type = "engine-tests/act"
    [schemas.second]
    type = "engine-tests/act"
"#;

/// Wants to be called for everything, and looks whether the rules are free when it is.
#[derive(Default)]
struct Ears {
    engine: OnceLock<Weak<Engine>>,
    left: AtomicUsize,
    called: AtomicUsize,
    alarms: AtomicUsize,
}

impl Ears {
    fn note(&self, count: &AtomicUsize) {
        let engine = self.engine.get().and_then(Weak::upgrade).unwrap();
        assert!(engine.rules.try_lock().is_ok(), "called under the rules' lock");
        count.fetch_add(1, Ordering::Relaxed);
    }
}

impl Bells for Ears {
    fn leave(&self, _: usize, _: Signal) -> bool {
        self.left.fetch_add(1, Ordering::Relaxed);
        true
    }

    fn call(&self, _: usize) {
        self.note(&self.called);
    }

    fn set_alarm(&self, _: Option<Nanos>) -> bool {
        true
    }

    fn call_alarm(&self) {
        self.note(&self.alarms);
    }
}

#[test]
fn whoever_is_rung_for_is_called_when_the_rules_are_free() {
    let mut plugins = Plugins::new(SearchPath::default());
    plugins.link(&PLUGIN).unwrap();
    let application = parse(TWO, Path::new("two.toml"), &[], &plugins).unwrap();
    let (engine, _ports) = Engine::new(application, Clock::standing(), vec![], None, None, None).unwrap();
    let ears = Arc::new(Ears::default());
    ears.engine.set(Arc::downgrade(&engine)).unwrap();
    let bells: Arc<dyn Bells> = Arc::clone(&ears) as _;
    engine.attach(&bells);
    let mut before = [0; 2];
    // How many calls and alarms there were since the last time.
    let mut since = || {
        let [left, called, alarms] =
            [&ears.left, &ears.called, &ears.alarms].map(|count| count.load(Ordering::Relaxed));
        assert_eq!(left, called, "each that is left for is called");
        let now = [called, alarms];
        let grown = [0, 1].map(|place| now[place] - before[place]);
        before = now;
        grown
    };
    let wants = |instance| {
        let check = Check {
            ready: true,
            urgency: 0.0,
            cause: 0,
        };
        engine.checked(instance, check);
    };

    engine.start();
    assert_eq!(since()[0], 2, "both are awake");
    wants(1);
    assert_eq!(since()[0], 1, "it is the only one that wants");
    let (may, _) = engine.begin(1);
    assert!(may);
    wants(0);
    assert_eq!(since(), [0, 1], "it has to wait, but not for ever");
    engine.end(1);
    assert_eq!(since()[0], 1, "it wins");
    engine.faulted(0, String::from("it broke"));
    assert!(since()[1] > 0, "it is to be restarted");
    engine.clock.set(3_600_000_000_000);
    engine.tick();
    assert!(since()[0] > 0, "it is");
}
