//! The widgets of a panel.

use serde::{Deserialize, Serialize};

use crate::{Area, Color, Shape, Solid, Wants};

/// A widget. A widget that accepts gestures has an `id`, which is unique in the panel and not shown. Gestures
/// name it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Item {
    /// A line or paragraph of text.
    Text {
        /// The text.
        text: String,
        /// Its style.
        words: Words,
    },
    /// A number with its name. Viewers show it in the units that their users prefer.
    Value {
        /// Its name.
        label: String,
        /// The number; finite.
        value: f64,
        /// Unit in SI symbols: "m/s", "rad"; empty for none.
        unit: String,
    },
    /// A button.
    Button {
        /// Identifies it in gestures.
        id: String,
        /// The text on it.
        label: String,
        /// Whether it can be pressed now.
        enabled: bool,
    },
    /// A switch that is on or off.
    Toggle {
        /// Identifies it in gestures.
        id: String,
        /// The text beside it.
        label: String,
        /// Whether it is on.
        on: bool,
    },
    /// A number to drag or to type.
    Slider {
        /// Identifies it in gestures.
        id: String,
        /// Its name.
        label: String,
        /// The present value; finite.
        value: f64,
        /// The least value; finite.
        least: f64,
        /// The greatest value; finite, not below the least.
        greatest: f64,
        /// Its unit; empty for none.
        unit: String,
    },
    /// One of several options.
    Choice {
        /// Identifies it in gestures.
        id: String,
        /// Its name.
        label: String,
        /// The options; at least one.
        #[serde(deserialize_with = "crate::bytes::items")]
        options: Vec<String>,
        /// The index of the present option.
        chosen: u32,
    },
    /// Pixels, shown as large as the space allows.
    Image {
        /// Identifies it in gestures. A click is in pixels from the upper left corner.
        id: String,
        /// Columns.
        width: u32,
        /// Rows.
        height: u32,
        /// Bytes of a pixel: 1 (grey), 3 (red, green, blue) or 4 (with opacity).
        channels: u8,
        /// Rows from the top, without gaps.
        #[serde(with = "crate::bytes::raw")]
        pixels: Vec<u8>,
        /// The gestures that it accepts.
        wants: Wants,
    },
    /// Curves over an axis.
    Plot {
        /// Identifies it across lists, so a viewer keeps its zoom.
        id: String,
        /// Its title.
        label: String,
        /// Name and unit of the horizontal axis: "time, s".
        across: String,
        /// Name and unit of the vertical axis.
        up: String,
        /// The curves.
        #[serde(deserialize_with = "crate::bytes::items")]
        traces: Vec<Trace>,
    },
    /// Texts in rows and columns.
    Table {
        /// Identifies it across lists, so a viewer keeps its scroll position.
        id: String,
        /// The headings of the columns.
        #[serde(deserialize_with = "crate::bytes::items")]
        columns: Vec<String>,
        /// The rows, each as long as `columns`.
        #[serde(deserialize_with = "crate::bytes::cells")]
        rows: Vec<Vec<String>>,
    },
    /// Widgets beside each other.
    Row {
        /// The widgets, from left to right.
        #[serde(deserialize_with = "crate::bytes::items")]
        items: Vec<Item>,
    },
    /// Widgets under a heading that can be folded.
    Group {
        /// Identifies it across lists, so a viewer keeps whether it is folded.
        id: String,
        /// The heading.
        label: String,
        /// Whether it is unfolded at first.
        open: bool,
        /// The widgets, from top to bottom.
        #[serde(deserialize_with = "crate::bytes::items")]
        items: Vec<Item>,
    },
    /// A plane in metres, x to the right and y up unless `forward_up`, with pan and zoom.
    Canvas {
        /// Identifies it in gestures, which are in metres.
        id: String,
        /// The area shown at first; `None` shows everything that is drawn.
        area: Option<Area>,
        /// Shows x up and y to the left: the robot's own frame, with the robot facing up the screen.
        forward_up: bool,
        /// The shapes, from back to front.
        #[serde(deserialize_with = "crate::bytes::items")]
        shapes: Vec<Shape>,
        /// The gestures that it accepts.
        wants: Wants,
    },
    /// Shapes in space, seen in a view of their own and in the 3D window.
    Scene {
        /// Identifies it in gestures, which are in metres.
        id: String,
        /// The REP-105 frame of its coordinates: `odom`, `base_link`.
        frame: String,
        /// The shapes.
        #[serde(deserialize_with = "crate::bytes::items")]
        solids: Vec<Solid>,
        /// The gestures that it accepts.
        wants: Wants,
    },
}

impl Item {
    /// Returns the `id` that gestures name, which also identifies the widget across lists. Texts, numbers and
    /// rows have none.
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

/// The style of a text.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Words {
    /// Normal text.
    #[default]
    Plain,
    /// A heading.
    Heading,
    /// Less prominent than normal text.
    Faint,
    /// All is well.
    Good,
    /// A warning.
    Warning,
    /// Something failed.
    Error,
    /// Monospaced text.
    Code,
}

/// A curve of a plot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Trace {
    /// Its name.
    pub name: String,
    /// Its color.
    pub color: Color,
    /// Its points; finite.
    #[serde(deserialize_with = "crate::bytes::points")]
    pub points: Vec<[f64; 2]>,
}
