//! The widgets of a panel.

use serde::{Deserialize, Serialize};

use crate::{Area, Color, Shape, Solid, Wants};

/// A widget. Those that people can touch have an `id`, unique in the panel and not shown; a gesture names it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Item {
    /// A line or paragraph of text.
    Text {
        /// What it says.
        text: String,
        /// How it matters.
        words: Words,
    },
    /// A number with its name; viewers show it in the units their users like.
    Value {
        /// What it is.
        label: String,
        /// Finite.
        value: f64,
        /// Unit as the symbols of SI: "m/s", "rad"; empty for none.
        unit: String,
    },
    /// Something to press.
    Button {
        /// Names it in gestures.
        id: String,
        /// What is on it.
        label: String,
        /// Whether it can be pressed now.
        enabled: bool,
    },
    /// Something that is on or off.
    Toggle {
        /// Names it in gestures.
        id: String,
        /// What is beside it.
        label: String,
        /// How it is.
        on: bool,
    },
    /// A number to drag or to type.
    Slider {
        /// Names it in gestures.
        id: String,
        /// What it is.
        label: String,
        /// What it is at; finite.
        value: f64,
        /// Least; finite.
        least: f64,
        /// Greatest; finite, not below the least.
        greatest: f64,
        /// Its unit; empty for none.
        unit: String,
    },
    /// One of several.
    Choice {
        /// Names it in gestures.
        id: String,
        /// What it is.
        label: String,
        /// What there is; at least one.
        #[serde(deserialize_with = "crate::bytes::items")]
        options: Vec<String>,
        /// The place of the present one.
        chosen: u32,
    },
    /// Pixels, shown as large as there is room.
    Image {
        /// Names it in gestures; a click is given in pixels from the upper left corner.
        id: String,
        /// Columns.
        width: u32,
        /// Rows.
        height: u32,
        /// Bytes of a pixel: 1 (grey), 3 (red, green, blue) or 4 (and how opaque).
        channels: u8,
        /// Rows from the top, without gaps.
        #[serde(with = "crate::bytes::raw")]
        pixels: Vec<u8>,
        /// What is handed back.
        wants: Wants,
    },
    /// Curves over an axis.
    Plot {
        /// Keeps its zoom from list to list.
        id: String,
        /// What it shows.
        label: String,
        /// Name and unit of the horizontal axis: "time, s".
        across: String,
        /// Name and unit of the vertical one.
        up: String,
        /// The curves.
        #[serde(deserialize_with = "crate::bytes::items")]
        traces: Vec<Trace>,
    },
    /// Texts in rows and columns.
    Table {
        /// Keeps its place from list to list.
        id: String,
        /// What is above the columns.
        #[serde(deserialize_with = "crate::bytes::items")]
        columns: Vec<String>,
        /// The rows, each as long as `columns`.
        #[serde(deserialize_with = "crate::bytes::cells")]
        rows: Vec<Vec<String>>,
    },
    /// Widgets beside each other.
    Row {
        /// From left to right.
        #[serde(deserialize_with = "crate::bytes::items")]
        items: Vec<Item>,
    },
    /// Widgets under a heading that can be folded.
    Group {
        /// Keeps whether it is folded.
        id: String,
        /// The heading.
        label: String,
        /// Whether it is unfolded at first.
        open: bool,
        /// From top to bottom.
        #[serde(deserialize_with = "crate::bytes::items")]
        items: Vec<Item>,
    },
    /// A plane in metres, x to the right and y up unless `forward_up`, with pan and zoom.
    Canvas {
        /// Names it in gestures, which are in metres.
        id: String,
        /// What is seen at first; nothing: all that is drawn.
        area: Option<Area>,
        /// Shown with x up and y to the left, as a robot that looks up the screen sees its own frame.
        forward_up: bool,
        /// From back to front.
        #[serde(deserialize_with = "crate::bytes::items")]
        shapes: Vec<Shape>,
        /// What is handed back.
        wants: Wants,
    },
    /// Shapes in space, seen in a view of their own and in the 3D window.
    Scene {
        /// Names it in gestures, which are in metres.
        id: String,
        /// The frame of REP-105 in which they are: `odom`, `base_link`.
        frame: String,
        /// The shapes.
        #[serde(deserialize_with = "crate::bytes::items")]
        solids: Vec<Solid>,
        /// What is handed back.
        wants: Wants,
    },
}

impl Item {
    /// The `id` by which gestures name it, and by which it is the same widget from list to list; texts, numbers and rows have none.
    #[must_use]
    pub fn id(&self) -> Option<&str> {
        match self {
            Self::Text { .. } | Self::Value { .. } | Self::Row { .. } => None,
            Self::Button { id, .. }
            | Self::Toggle { id, .. }
            | Self::Slider { id, .. }
            | Self::Choice { id, .. }
            | Self::Image { id, .. }
            | Self::Plot { id, .. }
            | Self::Table { id, .. }
            | Self::Group { id, .. }
            | Self::Canvas { id, .. }
            | Self::Scene { id, .. } => Some(id),
        }
    }
}

/// How a text matters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Words {
    /// As it is.
    #[default]
    Plain,
    /// A heading.
    Heading,
    /// Less than the rest.
    Faint,
    /// All is well.
    Good,
    /// Something is off.
    Warning,
    /// Something failed.
    Error,
    /// Letters of one width.
    Code,
}

/// A curve of a plot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Trace {
    /// What it is.
    pub name: String,
    /// Its color.
    pub color: Color,
    /// Its points, finite.
    #[serde(deserialize_with = "crate::bytes::points")]
    pub points: Vec<[f64; 2]>,
}
