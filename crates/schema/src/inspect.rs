//! A look at what the modulations name, before anything starts: `jde check` and `jde run` ask for it.
//!
//! ```
//! use jde_schema::bench::Bench;
//! use jde_schema::prelude::*;
//!
//! /// Plays a melody.
//! #[derive(Describe)]
//! #[schema(driver, period = "100ms")]
//! struct Player {
//!     /// The melody: "march" or "waltz".
//!     #[modulation(default = "march", fixed)]
//!     melody: Modulation<Text<28>>,
//!     beats: u32,
//! }
//!
//! impl Player {
//!     fn beats(&self, cx: &Context) -> Result<u32> {
//!         match self.melody.get(cx).as_str() {
//!             "march" => Ok(2),
//!             "waltz" => Ok(3),
//!             other => Err(format!("there is no melody `{other}`: it can be march or waltz").into()),
//!         }
//!     }
//! }
//!
//! impl Schema for Player {
//!     fn awake(&mut self, cx: &Context) -> Result {
//!         self.beats = self.beats(cx)?;
//!         Ok(())
//!     }
//!
//!     fn iterate(&mut self, _: &Context) -> Result {
//!         Ok(())
//!     }
//! }
//!
//! impl Inspect for Player {
//!     fn inspect(&self, cx: &Context, problems: &mut Problems) {
//!         problems.expect(&self.melody, self.beats(cx));
//!     }
//! }
//!
//! let mut bench = Bench::<Player>::new();
//! bench.set("melody", Text::<28>::new("tango"));
//! let problems = bench.inspect().unwrap();
//! assert_eq!(problems[0].modulation, "melody");
//! assert_eq!(problems[0].words, "there is no melody `tango`: it can be march or waltz");
//! ```

#![allow(unsafe_code)]

use core::fmt;

use jde_abi::raw;

use crate::context::Context;
use crate::input::Modulation;
use crate::schema::Schema;

/// A schema that looks at what its modulations name before anything starts.
pub trait Inspect: Schema {
    /// Reports what cannot work. Called on an instance that never awakes, in a process of its own, which is ended if the call takes
    /// more than a few seconds; with the modulations as the application sets them, and no other value.
    ///
    /// It reads and changes nothing: it opens no device, writes no file and calls nobody over a network. A panic is reported with the
    /// plugin's name, and is no reason not to start.
    fn inspect(&self, cx: &Context, problems: &mut Problems);
}

/// Takes the problems of one inspection; what is beyond [`raw::PROBLEMS_MOST`] is left out.
pub struct Problems<'call> {
    list: &'call raw::Problems,
    ports: *const raw::Port,
}

impl<'call> Problems<'call> {
    pub(crate) fn new(list: &'call raw::Problems, ports: *const raw::Port) -> Self {
        Self { list, ports }
    }

    /// The schema would fail when it awakes, because of this modulation: what is wrong, and what to do. `jde run` does not start
    /// then.
    pub fn wrong<T>(&mut self, modulation: &Modulation<T>, words: impl fmt::Display) {
        self.add(raw::PROBLEM_WRONG, modulation, &words);
    }

    /// What this modulation names is not there or may not be used at present, and the schema would start and wait for it: what is
    /// missing, and what to do. `jde run` warns and starts.
    pub fn unavailable<T>(&mut self, modulation: &Modulation<T>, words: impl fmt::Display) {
        self.add(raw::PROBLEM_UNAVAILABLE, modulation, &words);
    }

    /// What was made of this modulation; an error is [`wrong`](Self::wrong).
    pub fn expect<T, R, E: fmt::Display>(
        &mut self,
        modulation: &Modulation<T>,
        made: Result<R, E>,
    ) -> Option<R> {
        made.map_err(|error| self.wrong(modulation, error)).ok()
    }

    fn add<T>(&mut self, kind: u32, modulation: &Modulation<T>, words: &dyn fmt::Display) {
        let port = modulation.number(self.ports);
        let text = words.to_string();
        // SAFETY: the host's function and the first argument that it wants, and a text of that length. What it refuses is beyond the
        // most that it takes.
        unsafe {
            (self.list.add)(
                self.list.found,
                kind,
                port,
                text.as_ptr().cast(),
                text.len() as u64,
            )
        };
    }
}

impl fmt::Debug for Problems<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Problems")
    }
}
