//! Replays of an application that is hard to replay: unpredictable sensors, derived values, a schema that
//! fails sometimes, one with many inputs, and a father that arbitrates, wakes its children at different
//! times, modulates them by the clock and changes its policy.

use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant, SystemTime};

use jde_abi::raw;
use jde_app::Application;
use jde_decide::{ReplayReport as Verdicts, ReplayedDrive, Span, Tolerance, replay_and_compare};
use jde_host::{Handle, Lockstep, Options, Running};
use jde_loader::{Plugins, SearchPath};
use jde_log::Recording;
use jde_recorder::{Origin, Recorder};
use jde_schema::derived::{Describe as _, plugin};
use jde_schema::prelude::*;

/// Exports a level that depends on the machine's clock.
#[derive(Describe)]
#[schema(driver, period = "4ms")]
struct Noise {
    /// A level from 0 to 1.
    #[export]
    level: Export<f64>,
    /// Has no effect.
    #[command(neutral = 0.0, validity = "100ms")]
    #[expect(dead_code, reason = "no test reads the commands")]
    effort: Command<f64>,
    state: u64,
}

/// Counts what a device says.
#[derive(Describe)]
#[schema(perceptive, period = "20ms")]
struct Device {
    /// The count.
    #[export]
    count: Export<f64>,
    counted: f64,
}

/// Averages the sensed level.
#[derive(Describe)]
#[schema(perceptive, period = "5ms")]
struct Smooth {
    /// The sensed level.
    #[import]
    level: Import<f64>,
    /// The mean of the level.
    #[export]
    mean: Export<f64>,
    value: f64,
}

/// Is ready above a level.
#[derive(Describe)]
#[schema(motor, period = "7ms")]
struct Above {
    /// The sensed level.
    #[import(trigger)]
    level: Import<f64>,
    /// The mean of the level.
    #[import(optional)]
    mean: Import<f64>,
    /// A value that another schema derives from the level.
    #[import(optional)]
    shown: Import<f64>,
    /// The level from which it is ready.
    #[modulation(default = 0.5)]
    from: Modulation<f64>,
    /// The level above which it fails.
    #[modulation(default = 2.0)]
    fragile: Modulation<f64>,
    /// The value of its commands.
    #[modulation(default = 1.0)]
    strength: Modulation<f64>,
    /// The command.
    #[actuator]
    effort: Actuator<f64>,
}

/// A schema with more inputs than fit into the record of a turn.
macro_rules! many {
    ($first:ident, $($input:ident),*; $last:ident) => {
        /// Exports the sum of its first and its last input, which it reads at different times.
        #[derive(Describe)]
        #[schema(perceptive, period = "23ms")]
        struct Many {
            /// The first input.
            #[import]
            $first: Import<f64>,
            $(
                /// Another input.
                #[import(optional)]
                #[expect(dead_code, reason = "the inputs only take up space")]
                $input: Import<f64>,
            )*
            /// The last input.
            #[import]
            $last: Import<f64>,
            /// The sum.
            #[export]
            shown: Export<f64>,
        }

        impl Schema for Many {
            fn iterate(&mut self, cx: &Context) -> Result {
                let first = self.$first.get(cx).map(|level| *level.value());
                delay(cx, Duration::from_millis(6));
                let last = self.$last.get(cx).map(|level| *level.value());
                self.shown.write(cx, last.unwrap_or(-1.0) + first.unwrap_or(-1.0));
                Ok(())
            }
        }
    };
}

many!(i00, i01, i02, i03, i04, i05, i06, i07, i08, i09, i10, i11, i12, i13, i14, i15, i16, i17, i18, i19, i20, i21, i22, i23, i24, i25,
    i26, i27, i28, i29, i30, i31, i32; i33);

/// Delays the schema in real time, so that other threads continue.
fn delay(cx: &Context, time: Duration) {
    let since = Instant::now();
    while cx.require_real_time().is_ok() && since.elapsed() < time {
        std::hint::spin_loop();
    }
}

/// A father of two.
#[derive(Describe)]
#[schema(motor, period = "11ms")]
struct Leader {
    /// The first child.
    #[child(group = "work")]
    one: Child,
    /// The second child.
    #[child(group = "work")]
    other: Child,
    /// The level from which the first child is ready.
    #[modulates(child = "one", name = "from")]
    from: Modulates<f64>,
    turns: u64,
}

impl Schema for Noise {
    fn iterate(&mut self, cx: &Context) -> Result {
        let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
        self.state = (self.state ^ now.unwrap_or_default().subsec_nanos() as u64)
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        self.level
            .write(cx, (self.state >> 40) as f64 / (1_u64 << 24) as f64);
        Ok(())
    }
}

impl Schema for Device {
    fn awake(&mut self, cx: &Context) -> Result {
        cx.require_real_time()
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        self.counted += 1.0;
        self.count.write(cx, self.counted);
        Ok(())
    }
}

impl Schema for Smooth {
    fn iterate(&mut self, cx: &Context) -> Result {
        if let Some(level) = self.level.get(cx) {
            self.value += 0.2 * (*level.value() - self.value);
            self.mean.write(cx, self.value);
        }
        Ok(())
    }
}

impl Schema for Above {
    fn check(&mut self, cx: &Context) -> Result<Precondition> {
        let Some(level) = self.level.get(cx) else {
            return Ok(false.into());
        };
        if *level.value() > self.fragile.get(cx) {
            return Err("too much".into());
        }
        let [mean, shown] =
            [&self.mean, &self.shown].map(|import| import.get(cx).map_or(0.0, |value| *value.value()));
        Ok(Precondition::from(*level.value() > self.from.get(cx)).urgency(*level.value() + mean + shown))
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        self.effort.command(cx, self.strength.get(cx));
        Ok(())
    }
}

impl Schema for Leader {
    fn iterate(&mut self, cx: &Context) -> Result {
        self.one.wake(cx);
        if self.turns == 0 {
            // The first child is selected long before the other is awake.
            delay(cx, Duration::from_millis(30));
        }
        self.turns += 1;
        if self.turns.is_multiple_of(40) {
            self.other.sleep(cx);
        } else {
            self.other.wake(cx);
        }
        if self.turns % 20 == 5 {
            // The level selects under the previous policy, and then under the new one.
            delay(cx, Duration::from_millis(8));
            self.one.set_policy(cx, Policy::URGENCY);
            delay(cx, Duration::from_millis(8));
            self.one.set_policy(cx, Policy::FATHER);
        }
        self.from.set(cx, 0.5 + 0.3 * cx.now().as_secs_f64().sin());
        Ok(())
    }
}

impl Arbitrate for Leader {
    fn arbitrate(&mut self, _: &Context, level: &Level) -> Result<Verdict> {
        let urgency = |child: &Child| level.candidate(child).map_or(0.0, |candidate| candidate.urgency);
        let (one, other) = (urgency(&self.one), urgency(&self.other));
        if self.turns.is_multiple_of(50) {
            return Err("no choice".into());
        }
        Ok(if one > other {
            Verdict::choose(&self.one, format!("{one:.3} is more than {other:.3}"))
        } else {
            Verdict::choose(&self.other, format!("{other:.3} is not less than {one:.3}"))
        })
    }
}

/// `Above` has no functions for awakening and sleeping, as a schema in C may.
const SCHEMAS: &[raw::Schema] = &[
    Noise::TABLE,
    Device::TABLE,
    Smooth::TABLE,
    Many::TABLE,
    raw::Schema {
        awake: None,
        sleep: None,
        ..Above::TABLE
    },
    Leader::TABLE,
];
static PLUGIN: raw::Plugin = plugin("many_schemas\0", "1\0", "Hard to replay.\0", false, SCHEMAS);

const TEXT: &str = r#"
name  = "many"
roots = ["leader"]
[schemas.noise]
type = "many_schemas/noise"
[schemas.smooth]
type    = "many_schemas/smooth"
imports = { level = "noise.level" }
[schemas.many]
type    = "many_schemas/many"
imports = { i00 = "noise.level", i33 = "noise.level" }
[schemas.leader]
type     = "many_schemas/leader"
children = { one = "one", other = "other" }
groups   = { work = { policy = "father" } }
[schemas.one]
type      = "many_schemas/above"
imports   = { level = "noise.level", mean = "smooth.mean", shown = "many.shown" }
actuators = { effort = "noise.effort" }
strength  = 1.0
[schemas.other]
type      = "many_schemas/above"
imports   = { level = "noise.level" }
actuators = { effort = "noise.effort" }
fragile   = 0.98
restart   = { back-off = "20ms", limit = 1000 }
"#;

fn plugins() -> Plugins {
    let mut plugins = Plugins::new(SearchPath::default());
    plugins.link(&PLUGIN).expect("the plugin is valid");
    plugins
}

fn application(plugins: &Plugins, text: &str) -> Application {
    jde_app::parse(text, Path::new("many.toml"), &[], plugins).unwrap_or_else(|faults| panic!("{faults}"))
}

/// Records until the driver has exported `levels` levels. Returns the number of recorded selections.
fn record(file: &Path, levels: u64, text: &str, real: bool) -> u64 {
    let plugins = plugins();
    let application = application(&plugins, text);
    let options = jde_recorder::RecorderOptions {
        origin: Origin::of(&application, true),
        application: Some(&application),
        overwrite: false,
        lossless: !real,
        on_trouble: Box::new(|error| panic!("{error}")),
    };
    let recorder = Arc::new(Recorder::create(file, options).expect("the file is created"));
    let watcher = Arc::clone(&recorder);
    let options = Options {
        observers: vec![recorder.observer()],
        start_hook: Some(Box::new(move |handle: &Handle| {
            for variable in handle.board().list() {
                let handle = handle.clone();
                watcher.watch(&variable, Arc::new(move || handle.now()));
            }
            Ok(())
        })),
        on_turn: Some(jde_recorder::turns(&recorder, &application, !real)),
        ..Options::default()
    };
    if real {
        let running = Running::start(application, &plugins, options).expect("the application starts");
        let level = running
            .handle()
            .board()
            .get("noise.level")
            .expect("the variable exists");
        while level.wait_newer(levels, Duration::from_secs(1)) <= levels {}
    } else {
        let mut lockstep = Lockstep::start(application, &plugins, options).expect("the application starts");
        lockstep.run_until(levels * 4_000_000);
    }
    assert_eq!(recorder.finish().lost, 0);
    let recording = Recording::open(file).expect("the recording is complete");
    let messages = recording.messages().expect("the messages can be read");
    let decisions = messages
        .filter(|message| message.as_ref().expect("the message is intact").channel.topic == "/jde/decisions");
    decisions.count() as u64
}

fn replay(file: &Path, text: &str) -> Verdicts {
    let plugins = plugins();
    let drive = ReplayedDrive::open(file).expect("the recording is complete");
    let application = application(&plugins, text);
    replay_and_compare(
        &drive,
        application,
        &plugins,
        Span::default(),
        &Tolerance::default(),
        |_| true,
    )
    .expect("the recording can be replayed")
}

#[track_caller]
fn check_replay_is_same(head: &str, real: bool) {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("many.mcap");
    let text = format!("{head}{TEXT}");
    let decisions = record(&file, 1500, &text, real);
    let verdict = replay(&file, &text);
    let first = (verdict.comparison.first.first(), &verdict.values);
    assert!(verdict.is_same(), "{first:#?}");
    assert_eq!(verdict.comparison.same, decisions, "every selection is compared");
    assert!(decisions > 500, "{decisions}");
    assert_eq!((verdict.lost_steps, verdict.missed), (0, Vec::new()));
    let values = verdict.values.expect("turns contain the written values");
    assert_eq!((values.different, values.unknown), (0, Vec::new()));
    assert!(values.same > 1000, "{}", values.same);
    // Opposite commands, with the same selections.
    let verdict = replay(&file, &text.replace("strength  = 1.0", "strength  = -1.0"));
    assert_eq!(verdict.comparison.different, 0);
    let values = verdict.values.expect("turns contain the written values");
    assert_eq!(values.first.len(), 1, "{values:#?}");
    let first = &values.first[0];
    assert_eq!(
        (&*first.schema, &*first.port, &*first.variable),
        ("one", "effort", "noise.effort")
    );
    assert_eq!((&*first.recorded, &*first.replayed), ("1", "-1"));
    assert_eq!(values.different, first.count);
    assert!(first.count > 10 && values.same > 1000, "{values:#?}");
    // The schema now fails at a lower level.
    let verdict = replay(&file, &text.replace("fragile   = 0.98", "fragile   = 0.9"));
    assert!(!verdict.is_same());
}

#[test]
fn r16_a_run_on_many_threads_is_replayed_with_the_same_result() {
    check_replay_is_same("", true);
}

#[test]
fn r16_a_run_in_a_thread_pool_is_replayed_with_the_same_result() {
    check_replay_is_same("executor = \"pool\"\n", true);
}

#[test]
fn r16_a_run_in_lockstep_is_replayed_with_the_same_result() {
    check_replay_is_same("", false);
}

#[test]
fn r16_a_schema_that_requires_real_time_does_not_awake_in_a_replay() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("device.mcap");
    let text =
        TEXT.replace("many.shown", "device.count") + "[schemas.device]\ntype = \"many_schemas/device\"\n";
    record(&file, 100, &text, true);
    let values = replay(&file, &text)
        .values
        .expect("turns contain the written values");
    let count = values.first.iter().find(|deviation| deviation.schema == "device");
    let count = count.unwrap_or_else(|| panic!("{values:#?}"));
    assert_eq!((&*count.recorded, &*count.replayed), ("1", "nothing"));
}
