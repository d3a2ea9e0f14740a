//! The content of a schema's own panel: a [`List`] of widgets and shapes that any viewer can show, and the
//! [`Gesture`]s that a viewer returns. This crate has the data, its limits, its bytes (CBOR) and its path
//! through the C ABI. It refuses to draw and to know the viewers.

mod boundary;
mod builder;
mod bytes;
mod frame;
mod gesture;
mod item;
mod limits;
mod shape;
mod solid;
mod takes;

pub use boundary::{lend_gesture, lend_pen, read_gesture};
pub use builder::{Builder, Holds};
pub use bytes::{decode, encode};
pub use frame::{MAX_RATE, PanelFrame};
pub use gesture::{Button, Gesture, Touch};
pub use item::{Item, Trace, Words};
pub use limits::{Broken, MOST_BYTES, MOST_ENCODED, MOST_ITEMS, MOST_POINTS, MOST_SIDE, MOST_TEXT, check};
pub use shape::{Area, Color, Ink, Shape, Stroke, Wants};
pub use solid::{Place, Solid};

use serde::{Deserialize, Serialize};

/// The content of a panel at one instant. It replaces the previous content. A widget with the same `id` is
/// the same widget.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct List {
    /// When it was drawn, in nanoseconds since the application's start.
    pub time: u64,
    /// The widgets, from top to bottom.
    #[serde(deserialize_with = "crate::bytes::list")]
    pub items: Vec<Item>,
}

impl List {
    /// Returns every widget, each before the widgets inside it.
    pub fn walk(&self) -> impl Iterator<Item = &Item> + Clone {
        let mut open = vec![self.items.iter()];
        std::iter::from_fn(move || {
            loop {
                let Some(item) = open.last_mut()?.next() else {
                    open.pop();
                    continue;
                };
                if let Item::Row { items } | Item::Group { items, .. } = item {
                    open.push(items.iter());
                }
                return Some(item);
            }
        })
    }
}
