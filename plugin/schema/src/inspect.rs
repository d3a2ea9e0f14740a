//! The inspection of what modulations name, before the application starts. `jde check` and `jde run` request
//! it.
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
use crate::output::Export;
use crate::schema::Schema;

/// A schema that inspects what its modulations name before the application starts.
pub trait Inspect: Schema {
    /// Reports what cannot work. The host calls it on an instance that never awakes, in a separate process,
    /// which it ends if the call takes more than a few seconds. The modulations have the values that the
    /// application sets. No other port has a value; an import tells whether it is bound.
    ///
    /// An inspection only reads: it must open no device, write no file and use no network. A panic is
    /// reported with the plugin's name and does not prevent the start.
    fn inspect(&self, cx: &Context, problems: &mut Problems);
}

/// What an inspection may find wrong: a modulation, or a port of a list; or an export that it finds absent.
pub trait Inspected {
    /// Returns the number of the port in a call of the type whose ports start at `ports`.
    #[doc(hidden)]
    fn number(&self, ports: *const raw::Port) -> u32;
}

impl<I: Inspected> Inspected for &I {
    fn number(&self, ports: *const raw::Port) -> u32 {
        (*self).number(ports)
    }
}

/// Collects the problems of one inspection. Problems beyond [`raw::PROBLEMS_MOST`] are dropped.
pub struct Problems<'call> {
    list: &'call raw::Problems,
    ports: *const raw::Port,
}

impl<'call> Problems<'call> {
    pub(crate) fn new(list: &'call raw::Problems, ports: *const raw::Port) -> Self {
        Self { list, ports }
    }

    /// Reports that this modulation or port of a list would make the schema fail when it awakes. `message` states what
    /// is wrong and what to do. `jde run` then does not start.
    pub fn wrong(&mut self, place: &impl Inspected, message: impl fmt::Display) {
        self.add(raw::PROBLEM_WRONG, place, &message);
    }

    /// Reports that what this place names is missing or may not be used at present. The schema would
    /// start and wait for it. `message` states what is missing and what to do. `jde run` warns and starts.
    pub fn unavailable(&mut self, place: &impl Inspected, message: impl fmt::Display) {
        self.add(raw::PROBLEM_UNAVAILABLE, place, &message);
    }

    /// Reports that this export never has a value with these modulations: a robot has no such sensor. `message` states
    /// why. `jde check` and `jde run` warn of each schema that imports it.
    pub fn absent<T>(&mut self, export: &Export<T>, message: impl fmt::Display) {
        self.add(raw::PROBLEM_UNAVAILABLE, export, &message);
    }

    /// Returns the value of `result`, and reports an error in it as [`wrong`](Self::wrong).
    pub fn expect<R, E: fmt::Display>(&mut self, place: &impl Inspected, result: Result<R, E>) -> Option<R> {
        result.map_err(|error| self.wrong(place, error)).ok()
    }

    fn add(&mut self, kind: u32, place: &impl Inspected, message: &dyn fmt::Display) {
        let port = place.number(self.ports);
        let text = message.to_string();
        // SAFETY: the host's function, the first argument that it requires, and a text of that length. A
        // refusal is ignored: it means that the list is full.
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
