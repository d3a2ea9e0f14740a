//! What people do to a panel.

use serde::{Deserialize, Serialize};

/// What somebody did to a widget of a panel.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Gesture {
    /// The widget's `id`.
    pub widget: String,
    /// What was done.
    pub touch: Touch,
}

/// What was done. Positions are metres in the plane or frame of a canvas or scene, and pixels of an image.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Touch {
    /// A button was pressed.
    Pressed,
    /// A toggle was switched.
    Toggled(bool),
    /// A slider was moved to a number.
    Moved(f64),
    /// Of a choice, this one was taken.
    Chose(u32),
    /// Something was clicked.
    Clicked {
        /// Where; z is 0 in a plane.
        at: [f64; 3],
        /// With what.
        button: Button,
    },
    /// Something is dragged.
    Dragged {
        /// Where it began.
        from: [f64; 3],
        /// Where it is.
        to: [f64; 3],
        /// With what.
        button: Button,
        /// Whether it is over.
        ended: bool,
    },
    /// A key went down or up, by its name: `a`, `Space`, `ArrowUp`.
    Key {
        /// Its name.
        key: String,
        /// Whether it went down.
        down: bool,
    },
}

/// A button of the mouse.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Button {
    /// The left one.
    #[default]
    Primary,
    /// The right one.
    Secondary,
    /// The one between.
    Middle,
}
