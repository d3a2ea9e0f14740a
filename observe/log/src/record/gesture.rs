//! A gesture as a message: the fields of all kinds of gestures one after the other.

use jde_panel::{Button, Gesture, Touch};
use jde_records::wire::GestureMessage;
use jde_ros::cdr::Error;

use super::fields::{Cdr, Fields};

/// The names of the mouse buttons.
const BUTTONS: [(&str, Button); 3] = [
    ("primary", Button::Primary),
    ("secondary", Button::Secondary),
    ("middle", Button::Middle),
];

/// The message `jde_msgs/msg/Gesture`.
#[derive(Default)]
struct GestureFields {
    number: u64,
    widget: String,
    touch: String,
    active: bool,
    value: f64,
    option: u32,
    position: [f64; 3],
    origin: [f64; 3],
    button: String,
    key: String,
}

/// None is a gesture with the number 0. A gesture of an unknown kind is read as none.
impl Fields for Option<GestureMessage> {
    fn fields(&mut self, cdr: &mut Cdr<'_, '_>) -> Result<(), Error> {
        let mut message = self.take().map(GestureFields::from).unwrap_or_default();
        message.number.fields(cdr)?;
        message.widget.fields(cdr)?;
        message.touch.fields(cdr)?;
        message.active.fields(cdr)?;
        message.value.fields(cdr)?;
        message.option.fields(cdr)?;
        message.position.fields(cdr)?;
        message.origin.fields(cdr)?;
        message.button.fields(cdr)?;
        message.key.fields(cdr)?;
        if message.number > 0 {
            *self = message.into_record();
        }
        Ok(())
    }
}

impl From<GestureMessage> for GestureFields {
    fn from(GestureMessage { number, gesture }: GestureMessage) -> Self {
        let name = |touch: &str| Self {
            number,
            widget: gesture.widget,
            touch: touch.to_owned(),
            ..Self::default()
        };
        let button_name = |button: Button| {
            let named = BUTTONS.into_iter().find(|(_, other)| *other == button);
            named.map(|(name, _)| name.to_owned()).unwrap_or_default()
        };
        match gesture.touch {
            Touch::Pressed => name("pressed"),
            Touch::Toggled(active) => Self {
                active,
                ..name("toggled")
            },
            Touch::Moved(value) => Self {
                value,
                ..name("moved")
            },
            Touch::Chose(option) => Self {
                option,
                ..name("chose")
            },
            Touch::Clicked { at, button } => Self {
                position: at,
                button: button_name(button),
                ..name("clicked")
            },
            Touch::Dragged {
                from,
                to,
                button,
                ended,
            } => Self {
                active: ended,
                position: to,
                origin: from,
                button: button_name(button),
                ..name("dragged")
            },
            Touch::Key { key, down } => Self {
                active: down,
                key,
                ..name("key")
            },
        }
    }
}

impl GestureFields {
    fn into_record(self) -> Option<GestureMessage> {
        let button = || {
            let named = BUTTONS.into_iter().find(|(name, _)| *name == self.button);
            named.map(|(_, button)| button)
        };
        let touch = match self.touch.as_str() {
            "pressed" => Touch::Pressed,
            "toggled" => Touch::Toggled(self.active),
            "moved" => Touch::Moved(self.value),
            "chose" => Touch::Chose(self.option),
            "clicked" => Touch::Clicked {
                at: self.position,
                button: button()?,
            },
            "dragged" => Touch::Dragged {
                from: self.origin,
                to: self.position,
                button: button()?,
                ended: self.active,
            },
            "key" => Touch::Key {
                key: self.key,
                down: self.active,
            },
            _ => return None,
        };
        Some(GestureMessage {
            number: self.number,
            gesture: Gesture {
                widget: self.widget,
                touch,
            },
        })
    }
}
