//! Builds of a type with lists of ports, whose entries stay those of the application file.

use jde_abi::raw;
use jde_host::reload::ReloadOptions;
use jde_loader::LoadedPlugin;
use jde_schema::prelude::*;
use jde_schema::{Exports, Imports};

use super::start_with;
use crate::common::{Executor, on_every_executor};

on_every_executor!(a_build_has_the_entries_of_its_lists_unless_they_have_changed);

/// What a value is multiplied by.
#[derive(Clone, Copy, Debug, Default, Value)]
#[repr(C)]
#[value(name = "test_msgs/msg/Gain")]
struct Gain {
    gain: f64,
}

/// The same with another type of number.
#[derive(Clone, Copy, Debug, Default, Value)]
#[repr(C)]
#[value(name = "test_msgs/msg/Gain")]
struct IntegerGain {
    gain: u64,
}

macro_rules! build {
    ($build:literal: $plugin:ident, $name:ident, $gain:ident, { $($fields:tt)* }) => {
        /// Gives what it takes, times the gain and its number.
        #[allow(dead_code, reason = "some ports are only for the description")]
        #[derive(Describe)]
        #[schema(perceptive, period = "10ms", name = "bridge")]
        struct $name {
            $($fields)*
            /// The variables that it takes.
            #[imports(default = $gain { gain: 1 as _ })]
            take: Imports<$gain>,
            /// What it gives.
            #[exports(default = Gain { gain: 1.0 })]
            give: Exports<Gain>,
            /// 1 since it has iterated.
            #[export]
            iterated: Export<u32>,
        }

        impl Schema for $name {
            fn iterate(&mut self, cx: &Context) -> Result {
                self.iterated.write(cx, 1);
                let taken = self.take.iter().find_map(|import| {
                    let value = f64::from_ne_bytes(import.get(cx)?.first_chunk().copied()?);
                    Some(f64::from($build) * import.settings().gain as f64 * value)
                });
                let Some(value) = taken else { return Ok(()) };
                self.give.iter_mut().try_for_each(|export| {
                    export.write_with(cx, None, |bytes| {
                        bytes.copy_from_slice(&value.to_ne_bytes());
                        Ok::<(), Error>(())
                    })
                })
            }
        }

        static $plugin: raw::Plugin = jde_schema::plugin!("bridge", "Has lists of ports.", [$name]);
    };
}

build!(1: FIRST, First, Gain, {});
build!(2: RENUMBERED, Renumbered, Gain, {
    /// Moves the numbers of the ports of the lists.
    #[import(optional)]
    more: Import<f64>,
});
build!(3: OTHER_SETTINGS, OtherSettings, IntegerGain, {});
build!(4: SAME_NAMES, SameNames, Gain, {
    /// Has the name of an entry of `give`.
    #[export]
    there: Export<f64>,
    /// Has the name of an entry of `take`.
    #[import(optional)]
    eye: Import<f64>,
});

const APP: &str = r#"
    roots = ["idle"]
    awake = ["bridge"]
    [schemas.robot]
    type = "test/robot"
    [schemas.eye]
    type = "test/eye"
    [schemas.bridge]
    type = "bridge/bridge"
    take.eye = { from = "eye.out", gain = 3 }
    give."/there" = { as = "there", type = "std_msgs/msg/Float64" }
    [schemas.idle]
    type = "test/motor"
    actuators = { base = "robot.velocity" }
"#;

fn a_build_has_the_entries_of_its_lists_unless_they_have_changed(executor: Executor) {
    let mut app = start_with(executor, &FIRST, APP);
    app.until(|app| app.handle.value::<f64>("bridge.there") == Ok(Some(12.0)));
    let (bridge, operator) = (app.index("bridge"), app.operator());
    let replace = |table| {
        let build = LoadedPlugin::linked_in(table).expect("its tables are valid");
        operator.replace(bridge, &build, ReloadOptions::default())
    };
    let reload = replace(&RENUMBERED).unwrap_or_else(|reasons| panic!("{reasons:#?}"));
    app.until_reloaded(&reload).expect("it fits");
    app.until(|app| app.handle.value::<f64>("bridge.there") == Ok(Some(24.0)));
    assert_eq!(
        replace(&OTHER_SETTINGS).err().unwrap_or_default(),
        [
            "the list `take` is gone, or has other settings, another kind or another validity, and the application has entries in it"
        ]
    );
    assert_eq!(
        replace(&SAME_NAMES).err().unwrap_or_default(),
        [
            "the export `there` has the name of an entry of the application's lists",
            "the import `eye` has the name of an entry of the application's lists",
        ]
    );
    app.stop();
}
