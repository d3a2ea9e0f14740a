//! A schema's own panel: widgets and shapes that any viewer shows, local or remote, and the gestures of its
//! users.
//!
//! ```
//! use jde_schema::bench::Bench;
//! use jde_schema::prelude::*;
//!
//! /// Counts, up to a limit that people may move.
//! #[derive(Describe)]
//! #[schema(perceptive, period = "100ms")]
//! struct Counter {
//!     #[export]
//!     count: Export<f64>,
//!     counted: f64,
//!     limit: f64,
//! }
//!
//! impl Schema for Counter {
//!     fn iterate(&mut self, cx: &Context) -> Result {
//!         self.counted = (self.counted + 1.0).min(self.limit);
//!         self.count.write(cx, self.counted);
//!         Ok(())
//!     }
//! }
//!
//! impl Panel for Counter {
//!     fn draw(&self, _: &Context, pen: &mut Pen) {
//!         pen.heading("Counter");
//!         pen.value("counted", self.counted, "");
//!         pen.slider("limit", "Limit", self.limit, 0.0..=10.0, "");
//!     }
//!
//!     fn touched(&mut self, _: &Context, gesture: &Gesture) -> Result {
//!         if let Some(limit) = gesture.moved("limit") {
//!             self.limit = limit;
//!         }
//!         Ok(())
//!     }
//! }
//!
//! let mut bench = Bench::<Counter>::new();
//! bench.touch("limit", jde_schema::panel::Touch::Moved(1.0)).unwrap();
//! bench.iterate().unwrap();
//! bench.iterate().unwrap();
//! let panel = bench.draw().unwrap();
//! assert_eq!(panel.value("counted"), 1.0);
//! assert_eq!(panel.slider("limit"), 1.0);
//! ```

#![allow(unsafe_code)]

mod at;
mod mark;
mod pen;
mod pixels;
mod plane;
mod space;
mod widget;

use core::ops::Deref;

pub use at::At;
pub use jde_panel::{Button, Color, Ink, Item, List, Shape, Solid, Stroke, Touch, Trace, Words};
pub use mark::Mark;
pub use pen::Pen;
pub use plane::{Canvas, Curves, Plane, Plot};
pub use space::{Scene, Space};
pub use widget::Widget;

use crate::context::Context;
use crate::error::Result;
use crate::schema::Schema;

/// A schema with a panel of its own.
pub trait Panel: Schema {
    /// Draws the whole panel in its present state. Called only while a viewer shows it: after an iteration or
    /// check, whose values the inputs still have, and while the schema sleeps. It delays the schema's next
    /// check, and has the budget of an iteration: a longer drawing is an overrun and is not shown.
    ///
    /// It must change nothing: the host refuses whatever it writes. A panic is shown in the panel and is not
    /// a fault.
    fn draw(&self, cx: &Context, pen: &mut Pen);

    /// Handles a gesture on a widget. Called between two iterations, before the next check.
    ///
    /// # Errors
    /// Any reason why the schema cannot continue. It becomes Faulted. A gesture that a user may make is not
    /// an error.
    fn touched(&mut self, cx: &Context, gesture: &Gesture) -> Result {
        let (_, _) = (cx, gesture);
        Ok(())
    }
}

/// A gesture on a widget: which widget, what was done, and by which operator.
#[derive(Clone, Debug, PartialEq)]
pub struct Gesture {
    inner: jde_panel::Gesture,
    by: String,
}

impl Gesture {
    pub(crate) fn new(by: String, inner: jde_panel::Gesture) -> Self {
        Self { inner, by }
    }

    /// Returns the operator, such as "ana@laptop".
    #[must_use]
    pub fn by(&self) -> &str {
        &self.by
    }
}

impl Deref for Gesture {
    type Target = jde_panel::Gesture;

    fn deref(&self) -> &jde_panel::Gesture {
        &self.inner
    }
}
