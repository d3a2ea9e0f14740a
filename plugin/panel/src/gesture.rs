//! Gestures of users on a panel.

use serde::{Deserialize, Serialize};

use crate::Broken;
use crate::limits::wrong;

/// The maximum length of the name of a widget or key in a gesture, in bytes.
const MAX_LENGTH: usize = 256;

/// A user's gesture on a widget of a panel.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Gesture {
    /// The widget's `id`.
    pub widget: String,
    /// The kind of the gesture, with its values.
    pub touch: Touch,
}

/// The kind of a gesture. Positions are metres in the plane or frame of a canvas or scene, and pixels of an
/// image.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Touch {
    /// A button was pressed.
    Pressed,
    /// A toggle was switched.
    Toggled(bool),
    /// A slider was moved to this number.
    Moved(f64),
    /// The option with this index was chosen.
    Chose(u32),
    /// A point was clicked.
    Clicked {
        /// The position; z is 0 in a plane.
        at: [f64; 3],
        /// The mouse button.
        button: Button,
    },
    /// A point is dragged.
    Dragged {
        /// Where the drag began.
        from: [f64; 3],
        /// Where the drag is now.
        to: [f64; 3],
        /// The mouse button.
        button: Button,
        /// Whether the drag has ended.
        ended: bool,
    },
    /// A key was pressed or released, by its name: `a`, `Space`, `ArrowUp`.
    Key {
        /// The name of the key.
        key: String,
        /// Whether it was pressed.
        down: bool,
    },
}

impl Gesture {
    /// Returns whether this button was pressed.
    #[must_use]
    pub fn pressed(&self, widget: &str) -> bool {
        self.widget == widget && self.touch == Touch::Pressed
    }

    /// Returns the new value of this toggle.
    #[must_use]
    pub fn toggled(&self, widget: &str) -> Option<bool> {
        match self.touch {
            Touch::Toggled(on) if self.widget == widget => Some(on),
            _ => None,
        }
    }

    /// Returns the new value of this slider.
    #[must_use]
    pub fn moved(&self, widget: &str) -> Option<f64> {
        match self.touch {
            Touch::Moved(to) if self.widget == widget => Some(to),
            _ => None,
        }
    }

    /// Returns the index of the option that was chosen in this choice.
    #[must_use]
    pub fn chose(&self, widget: &str) -> Option<usize> {
        match self.touch {
            Touch::Chose(position) if self.widget == widget => Some(position as usize),
            _ => None,
        }
    }

    /// Returns where this widget was clicked with the left button.
    #[must_use]
    pub fn clicked(&self, widget: &str) -> Option<[f64; 3]> {
        match self.touch {
            Touch::Clicked {
                at,
                button: Button::Primary,
            } if self.widget == widget => Some(at),
            _ => None,
        }
    }

    /// Returns whether it is a drag that continues. The next gesture of its widget then contains all that
    /// this one does.
    #[must_use]
    pub fn goes_on(&self) -> bool {
        matches!(self.touch, Touch::Dragged { ended: false, .. })
    }

    /// Describes the gesture on the panel of `owner`, to be used after a name: "clicked `field` of example at
    /// (1.20, 3.40)".
    #[must_use]
    pub fn words(&self, owner: &str) -> String {
        let position = |[x, y, z]: [f64; 3]| {
            if z == 0.0 {
                format!("({x:.2}, {y:.2})")
            } else {
                format!("({x:.2}, {y:.2}, {z:.2})")
            }
        };
        let button_text = |button: Button| match button {
            Button::Primary => "",
            Button::Secondary => " with the right button",
            Button::Middle => " with the middle button",
        };
        let widget = format!("`{}` of {owner}", self.widget);
        match &self.touch {
            Touch::Pressed => format!("pressed {widget}"),
            Touch::Toggled(true) => format!("switched {widget} on"),
            Touch::Toggled(false) => format!("switched {widget} off"),
            Touch::Moved(to) => format!("moved {widget} to {to}"),
            Touch::Chose(index) => format!("chose number {index} of {widget}"),
            Touch::Clicked { at, button } => {
                format!("clicked {widget} at {}{}", position(*at), button_text(*button))
            }
            Touch::Dragged { from, to, button, .. } => format!(
                "dragged {widget} from {} to {}{}",
                position(*from),
                position(*to),
                button_text(*button)
            ),
            Touch::Key { key, down: true } => format!("pressed the key {key} on {widget}"),
            Touch::Key { key, down: false } => format!("let go of the key {key} on {widget}"),
        }
    }

    /// Checks whether the gesture can be passed on unchanged.
    ///
    /// # Errors
    /// A name is too long or has control characters, which could control a terminal, or a number is not
    /// finite.
    pub fn check(&self) -> Result<(), Broken> {
        let key = match &self.touch {
            Touch::Key { key, .. } => key,
            _ => "",
        };
        if self.widget.len().max(key.len()) > MAX_LENGTH {
            return wrong(&self.widget, format!("a name of more than {MAX_LENGTH} bytes"));
        }
        if self.widget.chars().chain(key.chars()).any(char::is_control) {
            return wrong(&self.widget, "a name with control characters");
        }
        let numbers = match &self.touch {
            Touch::Moved(to) => [[*to, 0.0, 0.0], [0.0; 3]],
            Touch::Clicked { at, .. } => [*at, [0.0; 3]],
            Touch::Dragged { from, to, .. } => [*from, *to],
            Touch::Pressed | Touch::Toggled(_) | Touch::Chose(_) | Touch::Key { .. } => [[0.0; 3]; 2],
        };
        if !numbers.as_flattened().iter().all(|number| number.is_finite()) {
            return wrong(&self.widget, "a position or number that is none");
        }
        Ok(())
    }
}

/// A mouse button.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Button {
    /// The left button.
    #[default]
    Primary,
    /// The right button.
    Secondary,
    /// The middle button.
    Middle,
}
