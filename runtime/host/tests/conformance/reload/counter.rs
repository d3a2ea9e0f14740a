//! Builds of one type of schema, linked in. Each has a number and a behaviour of its own.

use std::sync::Arc;

use jde_abi::raw;
use jde_loader::LoadedPlugin;
use jde_schema::prelude::*;

use crate::common::Scenario;

/// A call of a build.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Call {
    Awake,
    Check,
    Iterate,
    Sleep,
    Save,
    Restore,
    Drop,
}

/// The state of every build.
#[derive(Default)]
struct InstanceState {
    build: u32,
    scenario: Option<Arc<Scenario>>,
    name: String,
    steps: u32,
    /// Steps of this instance.
    own_steps: u32,
}

impl InstanceState {
    /// Behaves as the build with this number.
    fn perform(&mut self, cx: &Context, scenario: u32, build: u32, call: Call) -> Result {
        if self.scenario.is_none() {
            self.scenario = Some(Scenario::of(scenario));
            self.name = cx.name().to_owned();
            self.build = build;
        }
        if call == Call::Iterate {
            self.steps += 1;
            self.own_steps += 1;
        }
        match (build, call) {
            (3, Call::Iterate) if self.own_steps == 3 => Err("its third step is wrong".into()),
            (4, Call::Restore) => Err("the saved memory is invalid".into()),
            (6, Call::Check) => panic!("a panic in check"),
            (7, Call::Awake) => Err("it cannot awake".into()),
            (8, Call::Iterate) if self.own_steps == 2 => self.hang(scenario),
            (9, Call::Save) => panic!("a panic in save"),
            (15, Call::Restore) | (16, Call::Check) | (17, Call::Sleep) => self.hang(scenario),
            (17, Call::Iterate) if self.own_steps == 2 => {
                self.record("waits".to_owned());
                let scenario = Scenario::of(scenario);
                scenario.wait_until(|| scenario.has_line("go"));
                Ok(())
            }
            (_, Call::Check) => Ok(()),
            (_, Call::Iterate) => {
                self.record(format!("step {}", self.steps));
                Ok(())
            }
            (_, call) => {
                self.record(format!("{call:?}").to_lowercase());
                Ok(())
            }
        }
    }

    /// Like [`Self::perform`], for a call that cannot modify the instance.
    fn save(&self, cx: &Context, scenario: u32, build: u32) -> Result {
        let mut copy = Self::default();
        let saved = copy.perform(cx, scenario, build, Call::Save);
        // The drop of the copy must not be recorded.
        copy.scenario = None;
        saved
    }

    /// Blocks until the test records `release`.
    fn hang(&self, scenario: u32) -> Result {
        self.record("hangs".to_owned());
        let scenario = Scenario::of(scenario);
        scenario.wait_until(|| scenario.has_line("release"));
        Ok(())
    }

    fn record(&self, what: String) {
        if let Some(scenario) = &self.scenario {
            scenario.record(|| format!("{} {} {what}", self.name, self.build));
        }
    }
}

impl Drop for InstanceState {
    fn drop(&mut self) {
        self.record(format!("{:?}", Call::Drop).to_lowercase());
    }
}

macro_rules! build {
    ($build:literal: $plugin:ident, $name:ident) => {
        build!($build: $plugin, $name, {});
    };
    ($build:literal: $plugin:ident, $name:ident, { $($fields:tt)* }) => {
        build!($build: $plugin, $name, "counter", {
            /// An input.
            #[import(optional)]
            input: Import<f64>,
            /// The speed.
            #[modulation(default = 1.0, unit = "m/s")]
            speed: Modulation<f64>,
            $($fields)*
        });

        impl Memory for $name {
            const VERSION: u32 = $build;

            fn save(&self, cx: &Context, saving: &mut Saving) {
                if let Err(error) = self.state.save(cx, self.scenario.get(cx), $build) {
                    panic!("{error}");
                }
                saving.put(&self.state.steps);
            }

            fn restore(&mut self, cx: &Context, saved: &mut Saved) -> Result {
                self.state.perform(cx, self.scenario.get(cx), $build, Call::Restore)?;
                self.state.steps = saved.take()?;
                Ok(())
            }
        }
    };
    ($build:literal: $plugin:ident, $name:ident, $type:literal, { $($fields:tt)* }) => {
        /// A build. Some of its ports are only for its description.
        #[allow(dead_code, reason = "not every build reads all of its ports")]
        #[derive(Describe)]
        #[schema(motor, period = "10ms", name = $type)]
        struct $name {
            /// The number of the scenario.
            #[modulation(default = 0, fixed)]
            scenario: Modulation<u32>,
            /// The command of the base.
            #[actuator]
            base: Actuator<Twist>,
            $($fields)*
            state: InstanceState,
        }

        impl Schema for $name {
            fn awake(&mut self, cx: &Context) -> Result {
                self.state.perform(cx, self.scenario.get(cx), $build, Call::Awake)
            }

            fn check(&mut self, cx: &Context) -> Result<Precondition> {
                self.state.perform(cx, self.scenario.get(cx), $build, Call::Check)?;
                Ok(true.into())
            }

            fn iterate(&mut self, cx: &Context) -> Result {
                self.base.command(cx, Twist::planar(0.5, 0.0));
                self.state.perform(cx, self.scenario.get(cx), $build, Call::Iterate)
            }

            fn sleep(&mut self, cx: &Context) {
                // A sleeping build commands nothing, or the robot would stop at every reload.
                self.base.command(cx, Twist::ZERO);
                if let Err(error) = self.state.perform(cx, self.scenario.get(cx), $build, Call::Sleep) {
                    panic!("{error}");
                }
            }
        }

        static $plugin: raw::Plugin = jde_schema::plugin!("counter", "Counts its steps.", [$name]);
    };
}

/// Fails at its creation.
struct PanicsOnDefault;

impl Default for PanicsOnDefault {
    fn default() -> Self {
        panic!("there is no such device")
    }
}

build!(1: FIRST, First);
build!(2: SECOND, Second);
build!(3: FAILS_LATER, FailsLater);
build!(4: REFUSES_MEMORY, RefusesMemory);
build!(5: FAILS_TO_CREATE, FailsToCreate, {
    /// Fails at its creation.
    field: PanicsOnDefault,
});
build!(6: PANICS, Panics);
build!(7: CANNOT_AWAKE, CannotAwake);
build!(8: HANGS, Hangs);
build!(9: PANICS_IN_SAVE, PanicsInSave);
build!(10: INCOMPATIBLE, Incompatible, "counter", {
    /// An input of another type.
    #[import(optional)]
    input: Import<u32>,
    /// The speed, in another unit.
    #[modulation(default = 1.0, unit = "rad/s")]
    speed: Modulation<f64>,
    /// An import without a source.
    #[import]
    more: Import<f64>,
    /// A child without an instance.
    #[child(group = "legs")]
    leg: Child,
});
build!(11: WITHOUT_MEMORY, WithoutMemory, "counter", {
    /// An input.
    #[import(optional)]
    input: Import<f64>,
    /// The speed.
    #[modulation(default = 1.0, unit = "m/s")]
    speed: Modulation<f64>,
});
build!(12: OTHER, Other, "other", {});
build!(14: BARE, Bare, "counter", {});
build!(15: HANGS_IN_RESTORE, HangsInRestore);
build!(16: HANGS_IN_CHECK, HangsInCheck);
build!(17: HANGS_IN_SLEEP, HangsInSleep);

/// A build with other ports, all optional, in another order. It records what it reads.
#[derive(Describe)]
#[schema(motor, period = "10ms", name = "counter")]
struct Reordered {
    /// An export without a reader.
    #[export]
    steps: Export<u32>,
    /// The speed.
    #[modulation(default = 3.0, unit = "m/s")]
    speed: Modulation<f64>,
    /// A modulation without a writer.
    #[modulation(default = 7.0)]
    more: Modulation<f64>,
    /// An import without a source.
    #[import(optional)]
    nothing: Import<f64>,
    /// An input.
    #[import(optional)]
    input: Import<f64>,
    /// A child without an instance.
    #[child(group = "legs", optional)]
    leg: Child,
    /// The number of the scenario.
    #[modulation(default = 0, fixed)]
    scenario: Modulation<u32>,
    /// The command of the base.
    #[actuator]
    base: Actuator<Twist>,
    state: InstanceState,
}

impl Schema for Reordered {
    fn iterate(&mut self, cx: &Context) -> Result {
        self.steps.write(cx, 1);
        self.base.command(cx, Twist::planar(0.25, 0.0));
        self.state.perform(cx, self.scenario.get(cx), 13, Call::Iterate)?;
        let values = (
            self.speed.get(cx),
            self.more.get(cx),
            self.nothing.get(cx).is_some(),
            self.input.get(cx).map(|input| *input),
            self.leg.wake(cx) == Outcome::Accepted,
        );
        self.state.record(format!("reads {values:?}"));
        Ok(())
    }
}

static REORDERED: raw::Plugin = jde_schema::plugin!("counter", "Counts its steps.", [Reordered]);

/// A build that calls the speed by another name. It records what it reads.
#[derive(Describe)]
#[schema(motor, period = "10ms", name = "counter")]
struct Renamed {
    /// The number of the scenario.
    #[modulation(default = 0, fixed)]
    scenario: Modulation<u32>,
    /// An input.
    #[import(optional)]
    input: Import<f64>,
    /// The speed.
    #[modulation(default = 1.0, unit = "m/s", was = "speed")]
    pace: Modulation<f64>,
    /// The command of the base.
    #[actuator]
    base: Actuator<Twist>,
    state: InstanceState,
}

impl Schema for Renamed {
    fn iterate(&mut self, cx: &Context) -> Result {
        self.base.command(cx, Twist::planar(0.25, 0.0));
        self.state.perform(cx, self.scenario.get(cx), 18, Call::Iterate)?;
        let _ = self.input.get(cx);
        self.state.record(format!("paces {}", self.pace.get(cx)));
        Ok(())
    }
}

static RENAMED: raw::Plugin = jde_schema::plugin!("counter", "Counts its steps.", [Renamed]);

/// Returns the build with this number.
pub(super) fn build(number: u32) -> LoadedPlugin {
    let table = match number {
        1 => &FIRST,
        2 => &SECOND,
        3 => &FAILS_LATER,
        4 => &REFUSES_MEMORY,
        5 => &FAILS_TO_CREATE,
        6 => &PANICS,
        7 => &CANNOT_AWAKE,
        8 => &HANGS,
        9 => &PANICS_IN_SAVE,
        10 => &INCOMPATIBLE,
        11 => &WITHOUT_MEMORY,
        12 => &OTHER,
        13 => &REORDERED,
        14 => &BARE,
        15 => &HANGS_IN_RESTORE,
        16 => &HANGS_IN_CHECK,
        17 => &HANGS_IN_SLEEP,
        18 => &RENAMED,
        other => panic!("there is no build {other}"),
    };
    LoadedPlugin::linked_in(table).expect("its tables are valid")
}

/// The first build, to link in.
pub(super) static ORIGINAL: &raw::Plugin = &FIRST;
/// The build that cannot save, to link in.
pub(super) static CANNOT_SAVE: &raw::Plugin = &PANICS_IN_SAVE;
