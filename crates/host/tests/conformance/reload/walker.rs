//! Builds of one type of schema, linked in. Each has its number and its own behaviour.

use std::sync::Arc;

use jde_abi::raw;
use jde_loader::LoadedPlugin;
use jde_schema::prelude::*;

use crate::common::Stage;

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
struct Own {
    build: u32,
    stage: Option<Arc<Stage>>,
    name: String,
    steps: u32,
    /// Steps of this instance.
    own_steps: u32,
}

impl Own {
    /// Behaves as the build of that number does.
    fn perform(&mut self, cx: &Context, stage: u32, build: u32, call: Call) -> Result {
        if self.stage.is_none() {
            self.stage = Some(Stage::of(stage));
            self.name = cx.name().to_owned();
            self.build = build;
        }
        if call == Call::Iterate {
            self.steps += 1;
            self.own_steps += 1;
        }
        match (build, call) {
            (3, Call::Iterate) if self.own_steps == 3 => Err("its third step is wrong".into()),
            (4, Call::Restore) => Err("it knows better".into()),
            (6, Call::Check) => panic!("it looked"),
            (7, Call::Awake) => Err("it does not get up".into()),
            (8, Call::Iterate) if self.own_steps == 2 => self.hang(stage),
            (9, Call::Save) => panic!("it forgot"),
            (15, Call::Restore) | (16, Call::Check) | (17, Call::Sleep) => self.hang(stage),
            (17, Call::Iterate) if self.own_steps == 2 => {
                self.say("waits".to_owned());
                let stage = Stage::of(stage);
                stage.wait_until(|| stage.did("go"));
                Ok(())
            }
            (_, Call::Check) => Ok(()),
            (_, Call::Iterate) => {
                self.say(format!("step {}", self.steps));
                Ok(())
            }
            (_, call) => {
                self.say(format!("{call:?}").to_lowercase());
                Ok(())
            }
        }
    }

    /// Like [`Self::perform`], for a call that cannot modify the instance.
    fn save(&self, cx: &Context, stage: u32, build: u32) -> Result {
        let mut own = Self::default();
        let saved = own.perform(cx, stage, build, Call::Save);
        // The copy's end must not be recorded.
        own.stage = None;
        saved
    }

    /// Blocks until the test records `let go`.
    fn hang(&self, stage: u32) -> Result {
        self.say("hangs".to_owned());
        let stage = Stage::of(stage);
        stage.wait_until(|| stage.did("let go"));
        Ok(())
    }

    fn say(&self, what: String) {
        if let Some(stage) = &self.stage {
            stage.note(|| format!("{} {} {what}", self.name, self.build));
        }
    }
}

impl Drop for Own {
    fn drop(&mut self) {
        self.say(format!("{:?}", Call::Drop).to_lowercase());
    }
}

macro_rules! build {
    ($build:literal: $plugin:ident, $name:ident) => {
        build!($build: $plugin, $name, {});
    };
    ($build:literal: $plugin:ident, $name:ident, { $($fields:tt)* }) => {
        build!($build: $plugin, $name, "walker", {
            /// What it looks at.
            #[import(optional)]
            input: Import<f64>,
            /// How fast.
            #[modulation(default = 1.0, unit = "m/s")]
            speed: Modulation<f64>,
            $($fields)*
        });

        impl Memory for $name {
            const VERSION: u32 = $build;

            fn save(&self, cx: &Context, saving: &mut Saving) {
                if let Err(error) = self.own.save(cx, self.stage.get(cx), $build) {
                    panic!("{error}");
                }
                saving.put(&self.own.steps);
            }

            fn restore(&mut self, cx: &Context, saved: &mut Saved) -> Result {
                self.own.perform(cx, self.stage.get(cx), $build, Call::Restore)?;
                self.own.steps = saved.take()?;
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
            /// The number of its stage.
            #[modulation(default = 0, fixed)]
            stage: Modulation<u32>,
            /// The command of the base.
            #[actuator]
            base: Actuator<Twist>,
            $($fields)*
            own: Own,
        }

        impl Schema for $name {
            fn awake(&mut self, cx: &Context) -> Result {
                self.own.perform(cx, self.stage.get(cx), $build, Call::Awake)
            }

            fn check(&mut self, cx: &Context) -> Result<Precondition> {
                self.own.perform(cx, self.stage.get(cx), $build, Call::Check)?;
                Ok(true.into())
            }

            fn iterate(&mut self, cx: &Context) -> Result {
                self.base.command(cx, Twist::planar(0.5, 0.0));
                self.own.perform(cx, self.stage.get(cx), $build, Call::Iterate)
            }

            fn sleep(&mut self, cx: &Context) {
                // A sleeping build commands nothing, or the robot would stop at every reload.
                self.base.command(cx, Twist::ZERO);
                if let Err(error) = self.own.perform(cx, self.stage.get(cx), $build, Call::Sleep) {
                    panic!("{error}");
                }
            }
        }

        static $plugin: raw::Plugin = jde_schema::plugin!("walk", "Walks.", [$name]);
    };
}

/// Fails at its creation.
struct Fuse;

impl Default for Fuse {
    fn default() -> Self {
        panic!("there is no such device")
    }
}

build!(1: FIRST, First);
build!(2: SECOND, Second);
build!(3: FAILS_LATER, FailsLater);
build!(4: REFUSES, Refuses);
build!(5: STILLBORN, Stillborn, {
    /// Fails at its creation.
    fuse: Fuse,
});
build!(6: PANICS, Panics);
build!(7: LIES, Lies);
build!(8: HANGS, Hangs);
build!(9: FORGETS, Forgets);
build!(10: MISFIT, Misfit, "walker", {
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
build!(11: FORGETFUL, Forgetful, "walker", {
    /// What it looks at.
    #[import(optional)]
    input: Import<f64>,
    /// How fast.
    #[modulation(default = 1.0, unit = "m/s")]
    speed: Modulation<f64>,
});
build!(12: OTHER, Other, "runner", {});
build!(14: BARE, Bare, "walker", {});
build!(15: HANGS_AT_ONCE, HangsAtOnce);
build!(16: HANGS_FIRST, HangsFirst);
build!(17: HANGS_LAST, HangsLast);

/// A build with other ports, all optional, in another order. It records what it reads.
#[derive(Describe)]
#[schema(motor, period = "10ms", name = "walker")]
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
    /// The number of its stage.
    #[modulation(default = 0, fixed)]
    stage: Modulation<u32>,
    /// The command of the base.
    #[actuator]
    base: Actuator<Twist>,
    own: Own,
}

impl Schema for Reordered {
    fn iterate(&mut self, cx: &Context) -> Result {
        self.steps.write(cx, 1);
        self.base.command(cx, Twist::planar(0.25, 0.0));
        self.own.perform(cx, self.stage.get(cx), 13, Call::Iterate)?;
        let sees = (
            self.speed.get(cx),
            self.more.get(cx),
            self.nothing.get(cx).is_some(),
            self.input.get(cx).map(|input| *input),
            self.leg.wake(cx) == Outcome::Accepted,
        );
        self.own.say(format!("sees {sees:?}"));
        Ok(())
    }
}

static REORDERED: raw::Plugin = jde_schema::plugin!("walk", "Walks.", [Reordered]);

/// The build of that number.
pub(super) fn build(number: u32) -> LoadedPlugin {
    let table = match number {
        1 => &FIRST,
        2 => &SECOND,
        3 => &FAILS_LATER,
        4 => &REFUSES,
        5 => &STILLBORN,
        6 => &PANICS,
        7 => &LIES,
        8 => &HANGS,
        9 => &FORGETS,
        10 => &MISFIT,
        11 => &FORGETFUL,
        12 => &OTHER,
        13 => &REORDERED,
        14 => &BARE,
        15 => &HANGS_AT_ONCE,
        16 => &HANGS_FIRST,
        17 => &HANGS_LAST,
        other => panic!("there is no build {other}"),
    };
    LoadedPlugin::linked_in(table).expect("its tables are right")
}

/// The first build, to link in.
pub(super) static ORIGINAL: &raw::Plugin = &FIRST;
/// The build that cannot save, to link in.
pub(super) static CANNOT_SAVE: &raw::Plugin = &FORGETS;
