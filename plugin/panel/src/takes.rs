//! Whether a gesture fits the present content of a panel. It knows the list alone, and refuses to know
//! whether the schema uses the gesture.

use crate::limits::wrong;
use crate::{Broken, Gesture, Item, List, Touch, Wants};

impl List {
    /// Checks whether a gesture fits a widget of this list.
    ///
    /// # Errors
    /// There is no such widget, it is of another kind, it cannot be pressed now, it has no such number or
    /// option, or it does not accept the gesture.
    pub fn takes(&self, gesture: &Gesture) -> Result<(), Broken> {
        let id = &*gesture.widget;
        let Some(item) = self.walk().find(|item| item.id() == Some(id)) else {
            return wrong(id, "the panel shows no such widget now");
        };
        match (&gesture.touch, item) {
            (Touch::Pressed, Item::Button { enabled: true, .. })
            | (Touch::Toggled(_), Item::Toggle { .. }) => Ok(()),
            (Touch::Pressed, Item::Button { .. }) => wrong(id, "it cannot be pressed now"),
            (Touch::Moved(to), Item::Slider { least, greatest, .. }) => {
                if (least..=greatest).contains(&to) {
                    return Ok(());
                }
                wrong(id, format!("{to} is not from {least} to {greatest}"))
            }
            (Touch::Chose(index), Item::Choice { options, .. }) => {
                if (*index as usize) < options.len() {
                    return Ok(());
                }
                wrong(id, format!("it has {} options, counted from 0", options.len()))
            }
            (touch, Item::Canvas { wants, .. } | Item::Scene { wants, .. } | Item::Image { wants, .. }) => {
                check_touch(id, touch, *wants)
            }
            _ => wrong(id, "it is not a widget of which this can be done"),
        }
    }
}

/// Checks whether a canvas, scene or image accepts the gesture.
fn check_touch(id: &str, touch: &Touch, wants: Wants) -> Result<(), Broken> {
    let (accepted, kind) = match touch {
        Touch::Clicked { .. } => (wants.clicks, "clicks"),
        Touch::Dragged { .. } => (wants.drags, "drags"),
        Touch::Key { .. } => (wants.keys, "keys"),
        Touch::Pressed | Touch::Toggled(_) | Touch::Moved(_) | Touch::Chose(_) => {
            return wrong(id, "it is a picture: it can be clicked, dragged or given keys");
        }
    };
    if accepted {
        return Ok(());
    }
    wrong(id, format!("it takes no {kind}"))
}
