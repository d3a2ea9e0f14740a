//! What people do to a panel.

use serde::{Deserialize, Serialize};

use crate::Broken;
use crate::limits::wrong;

/// Most bytes of the name of a widget or key in a gesture.
const LONGEST: usize = 256;

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

impl Gesture {
    /// Whether this button was pressed.
    #[must_use]
    pub fn pressed(&self, widget: &str) -> bool {
        self.widget == widget && self.touch == Touch::Pressed
    }

    /// To what this toggle was switched.
    #[must_use]
    pub fn toggled(&self, widget: &str) -> Option<bool> {
        match self.touch {
            Touch::Toggled(on) if self.widget == widget => Some(on),
            _ => None,
        }
    }

    /// To what this slider was moved.
    #[must_use]
    pub fn moved(&self, widget: &str) -> Option<f64> {
        match self.touch {
            Touch::Moved(to) if self.widget == widget => Some(to),
            _ => None,
        }
    }

    /// Which of this choice was taken.
    #[must_use]
    pub fn chose(&self, widget: &str) -> Option<usize> {
        match self.touch {
            Touch::Chose(place) if self.widget == widget => Some(place as usize),
            _ => None,
        }
    }

    /// Where this was clicked with the left button.
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

    /// Whether it is a drag that goes on: the next of its widget tells all that this one does.
    #[must_use]
    pub fn goes_on(&self) -> bool {
        matches!(self.touch, Touch::Dragged { ended: false, .. })
    }

    /// What was done to the panel of `owner`, in words after a name: "clicked `field` of example at (1.20, 3.40)".
    #[must_use]
    pub fn words(&self, owner: &str) -> String {
        let place = |[x, y, z]: [f64; 3]| {
            if z == 0.0 {
                format!("({x:.2}, {y:.2})")
            } else {
                format!("({x:.2}, {y:.2}, {z:.2})")
            }
        };
        let with = |button: Button| match button {
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
            Touch::Chose(which) => format!("chose number {which} of {widget}"),
            Touch::Clicked { at, button } => {
                format!("clicked {widget} at {}{}", place(*at), with(*button))
            }
            Touch::Dragged { from, to, button, .. } => format!(
                "dragged {widget} from {} to {}{}",
                place(*from),
                place(*to),
                with(*button)
            ),
            Touch::Key { key, down: true } => format!("pressed the key {key} on {widget}"),
            Touch::Key { key, down: false } => format!("let go of the key {key} on {widget}"),
        }
    }

    /// Looks whether it can be handed on as it is.
    ///
    /// # Errors
    /// What is wrong: a name that is too long or has control characters, which would command a terminal; a number that is none.
    pub fn check(&self) -> Result<(), Broken> {
        let key = match &self.touch {
            Touch::Key { key, .. } => key,
            _ => "",
        };
        if self.widget.len().max(key.len()) > LONGEST {
            return wrong(&self.widget, format!("a name of more than {LONGEST} bytes"));
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
