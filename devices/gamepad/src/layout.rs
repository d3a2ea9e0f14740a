//! Which of the kernel's codes is which axis and button. A gamepad by the kernel's convention (Linux Gamepad Specification) gets
//! the numbers of ROS's `game_controller_node`; of a joystick they follow the codes.

/// The axes of the first stick.
pub(crate) const LEFT_STICK: [u16; 2] = [0x00, 0x01];
/// The first button of a joystick (`BTN_JOYSTICK`), and of a gamepad (`BTN_GAMEPAD`).
pub(crate) const JOYSTICK_BUTTONS: u16 = 0x120;
pub(crate) const PAD_BUTTONS: u16 = 0x130;
/// The end of the codes of a gamepad's buttons (`BTN_DIGI`).
const PAD_BUTTONS_END: u16 = 0x140;
/// Right stick where the triggers have axes of their own (`ABS_RX`, `ABS_RY`), and the triggers (`ABS_Z`, `ABS_RZ`).
const RIGHT_STICK: [u16; 2] = [0x03, 0x04];
const TRIGGER_AXES: [u16; 2] = [0x02, 0x05];
/// Triggers of pads whose right stick has the codes of the triggers (`ABS_BRAKE`, `ABS_GAS`).
const PEDAL_AXES: [u16; 2] = [0x0a, 0x09];
/// Triggers that are buttons (`BTN_TL2`, `BTN_TR2`).
const TRIGGER_BUTTONS: [u16; 2] = [0x138, 0x139];
/// Buttons 0 to 10: A, B, X, Y, back, guide, start, the sticks, the shoulders.
const NUMBERED_BUTTONS: [u16; 11] = [
    0x130, 0x131, 0x133, 0x134, 0x13a, 0x13c, 0x13b, 0x13d, 0x13e, 0x136, 0x137,
];
/// Buttons 11 to 14, the cross: up, down, left, right. It has buttons, or an axis and the sign on it.
const CROSS_BUTTONS: [(u16, u16, i32); 4] = [
    (0x220, 0x11, -1),
    (0x221, 0x11, 1),
    (0x222, 0x10, -1),
    (0x223, 0x10, 1),
];

/// What a person holds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Controls {
    /// From -1 to 1; of a stick positive to the left and ahead, of a trigger 0 while it is released.
    pub axes: Vec<f32>,
    /// Whether each button is pressed.
    pub buttons: Vec<bool>,
}

/// The position of an axis, and its range, as the kernel states them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Range {
    /// The position.
    pub value: i32,
    /// The least position.
    pub minimum: i32,
    /// The greatest position.
    pub maximum: i32,
}

/// Where the axes and buttons of a device come from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Layout {
    axes: Vec<Axis>,
    buttons: Vec<Button>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Axis {
    Stick(u16),
    Trigger(u16),
    /// A trigger that is a button.
    Key(u16),
    Absent,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Button {
    Key(u16),
    /// One end of an axis, by its sign.
    End(u16, i32),
    Absent,
}

impl Layout {
    /// The layout of a device with these codes, in ascending order.
    pub(crate) fn new(keys: &[u16], axes: &[u16]) -> Self {
        if !keys.contains(&PAD_BUTTONS) {
            let buttons = keys
                .iter()
                .filter(|code| (JOYSTICK_BUTTONS..PAD_BUTTONS_END).contains(code));
            return Self {
                axes: axes.iter().map(|code| Axis::Stick(*code)).collect(),
                buttons: buttons.map(|code| Button::Key(*code)).collect(),
            };
        }
        let has_all = |codes: [u16; 2]| codes.iter().all(|code| axes.contains(code));
        let (right, triggers) = if has_all(RIGHT_STICK) {
            (RIGHT_STICK, TRIGGER_AXES)
        } else {
            (TRIGGER_AXES, PEDAL_AXES)
        };
        let stick = |code: &u16| {
            if axes.contains(code) {
                Axis::Stick(*code)
            } else {
                Axis::Absent
            }
        };
        let trigger = |(code, key): (&u16, &u16)| match () {
            () if axes.contains(code) => Axis::Trigger(*code),
            () if keys.contains(key) => Axis::Key(*key),
            () => Axis::Absent,
        };
        let key = |code: &u16| {
            if keys.contains(code) {
                Button::Key(*code)
            } else {
                Button::Absent
            }
        };
        let cross = |(code, axis, sign): &(u16, u16, i32)| match key(code) {
            Button::Absent if axes.contains(axis) => Button::End(*axis, *sign),
            button => button,
        };
        Self {
            axes: [LEFT_STICK, right]
                .iter()
                .flatten()
                .map(stick)
                .chain(triggers.iter().zip(&TRIGGER_BUTTONS).map(trigger))
                .collect(),
            buttons: NUMBERED_BUTTONS
                .iter()
                .map(key)
                .chain(CROSS_BUTTONS.iter().map(cross))
                .collect(),
        }
    }

    /// The present state, of which buttons are pressed and where the axes are.
    pub(crate) fn controls(
        &self,
        is_pressed: impl Fn(u16) -> bool,
        range: impl Fn(u16) -> Range,
    ) -> Controls {
        let axis = |axis: &Axis| match *axis {
            // The kernel's axes are positive to the right and back.
            Axis::Stick(code) => 1.0 - 2.0 * range(code).part(0.5),
            Axis::Trigger(code) => range(code).part(0.0),
            Axis::Key(code) => f32::from(u8::from(is_pressed(code))),
            Axis::Absent => 0.0,
        };
        let button = |button: &Button| match *button {
            Button::Key(code) => is_pressed(code),
            Button::End(code, sign) => {
                let range = range(code);
                let middle = i64::midpoint(range.minimum.into(), range.maximum.into());
                (i64::from(range.value) - middle).signum() == i64::from(sign)
            }
            Button::Absent => false,
        };
        Controls {
            axes: self.axes.iter().map(axis).collect(),
            buttons: self.buttons.iter().map(button).collect(),
        }
    }
}

impl Range {
    /// The position as a part of the range, from 0 to 1; `rest` of an axis without a range.
    fn part(self, rest: f32) -> f32 {
        let (value, minimum, maximum) = (
            i64::from(self.value),
            i64::from(self.minimum),
            i64::from(self.maximum),
        );
        if minimum >= maximum {
            return rest;
        }
        let value = value.clamp(minimum, maximum);
        ((value - minimum) as f64 / (maximum - minimum) as f64) as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const XBOX_KEYS: [u16; 11] = [
        0x130, 0x131, 0x133, 0x134, 0x136, 0x137, 0x13a, 0x13b, 0x13c, 0x13d, 0x13e,
    ];
    const XBOX_AXES: [u16; 8] = [0, 1, 2, 3, 4, 5, 0x10, 0x11];

    fn held(layout: &Layout, keys: &[u16], ranges: &[(u16, [i32; 3])]) -> Controls {
        let range = |code: u16| {
            let found = ranges.iter().find(|(other, _)| *other == code);
            let [value, minimum, maximum] = found.map_or([0, -1, 1], |(_, range)| *range);
            Range {
                value,
                minimum,
                maximum,
            }
        };
        layout.controls(|code| keys.contains(&code), range)
    }

    #[test]
    fn a_pad_has_the_numbers_of_game_controller_node() {
        let layout = Layout::new(&XBOX_KEYS, &XBOX_AXES);
        let stick = [-32768, -32768, 32767];
        let ranges = [
            (0, stick),
            (1, stick),
            (2, [255, 0, 255]),
            (5, [0, 0, 255]),
            (0x11, [-1, -1, 1]),
        ];
        let controls = held(&layout, &[0x136, 0x13a], &ranges);
        assert_eq!(
            controls.axes,
            [1.0, 1.0, 0.0, 0.0, 1.0, 0.0],
            "left and ahead are positive"
        );
        let pressed: Vec<_> = (0..15).filter(|number| controls.buttons[*number]).collect();
        assert_eq!(pressed, [4, 9, 11], "back, left shoulder, up");
        assert_eq!(controls.buttons.len(), 15);
    }

    #[test]
    fn the_right_stick_may_have_the_codes_of_triggers() {
        let layout = Layout::new(&XBOX_KEYS, &[0, 1, 2, 5, 9, 0x0a]);
        let controls = held(
            &layout,
            &[],
            &[
                (2, [0, 0, 255]),
                (5, [255, 0, 255]),
                (9, [1023, 0, 1023]),
                (0x0a, [0, 0, 1023]),
            ],
        );
        assert_eq!(controls.axes[2..], [1.0, -1.0, 0.0, 1.0]);
    }

    #[test]
    fn triggers_and_the_cross_may_be_buttons() {
        let keys = [0x130, 0x138, 0x139, 0x220, 0x221, 0x222, 0x223];
        let controls = held(&Layout::new(&keys, &[0, 1, 3, 4]), &[0x139, 0x223], &[]);
        assert_eq!(controls.axes[4..], [0.0, 1.0]);
        assert_eq!(controls.buttons[11..], [false, false, false, true]);
    }

    #[test]
    fn of_a_joystick_the_numbers_follow_the_codes() {
        let layout = Layout::new(&[0x100, 0x120, 0x121, 0x12f], &[0, 1, 6]);
        let controls = held(&layout, &[0x121, 0x100], &[(6, [0, 0, 255])]);
        assert_eq!(controls.buttons, [false, true, false]);
        assert_eq!(controls.axes, [0.0, 0.0, 1.0]);
    }

    #[test]
    fn an_axis_without_a_range_is_at_rest_and_none_leaves_its_own() {
        let layout = Layout::new(&XBOX_KEYS, &XBOX_AXES);
        let far = [i32::MAX, -100, 100];
        let controls = held(
            &layout,
            &[],
            &[
                (0, [7, 0, 0]),
                (1, far),
                (2, [9, 9, 9]),
                (3, [i32::MIN, i32::MIN, i32::MAX]),
                (5, [0, 0, 255]),
            ],
        );
        assert_eq!(
            controls.axes,
            [0.0, -1.0, 1.0, 0.0, 0.0, 0.0],
            "a trigger without a range is released"
        );
    }
}
