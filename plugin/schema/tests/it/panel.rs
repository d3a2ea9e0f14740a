//! Tests of panels: drawings, refusals and gestures, through the tables that the host uses.

#![allow(unsafe_code)]

use core::ffi::CStr;

use jde_abi::raw;
use jde_schema::bench::Bench;
use jde_schema::panel::{Button, Item, Touch, Words};
use jde_schema::prelude::*;

/// Draws what the modulation `step` selects.
#[derive(Describe)]
#[schema(motor, period = "1s")]
struct Drawing {
    #[modulation(default = 0)]
    step: Modulation<u32>,
    #[import(optional)]
    input: Import<f64>,
    #[actuator(optional)]
    base: Actuator<Twist>,
    #[child(group = "base", optional)]
    child: Child,
    gestures: Vec<String>,
}

impl Schema for Drawing {
    fn iterate(&mut self, _: &Context) -> Result {
        Ok(())
    }
}

impl Panel for Drawing {
    fn draw(&self, cx: &Context, pen: &mut Pen) {
        match self.step.get(cx) {
            0 => {
                pen.words(Words::Good, "all is well");
                pen.value(
                    "input",
                    self.input.get(cx).map_or(-1.0, |input| *input.value()),
                    "m",
                );
                pen.text("up to\0the first NUL");
                pen.group("inner", "Inner", |pen| pen.toggle("on", "On", true));
            }
            1 => drop(self.base.command(cx, Twist::ZERO)),
            2 => drop(self.child.wake(cx)),
            3 => pen.value("speed", f64::NAN, "m/s"),
            4 => panic!("drawing failed"),
            5 => pen.table("table", ["a", "b"], [["only one"]]),
            6 => pen.canvas("field").show(|field| {
                field.circle((0.0, 0.0), -1.0).ink(Ink::Bad);
            }),
            _ => {}
        }
    }

    fn touched(&mut self, cx: &Context, gesture: &Gesture) -> Result {
        self.gestures.push(gesture.words(gesture.by()));
        if gesture.pressed("drive") {
            self.base.command(cx, Twist::planar(0.1, 0.0));
            self.child.wake(cx);
        }
        Ok(())
    }
}

/// Has a panel that ignores gestures.
#[derive(Describe)]
#[schema(perceptive, period = "1s")]
struct IgnoresGestures {}

impl Schema for IgnoresGestures {
    fn iterate(&mut self, _: &Context) -> Result {
        Ok(())
    }
}

impl Panel for IgnoresGestures {
    fn draw(&self, _: &Context, _: &mut Pen) {}
}

/// Has no panel.
#[derive(Describe)]
#[schema(perceptive, period = "1s")]
struct NoPanel {}

impl Schema for NoPanel {
    fn iterate(&mut self, _: &Context) -> Result {
        Ok(())
    }
}

#[test]
fn a_panel_contains_the_drawn_widgets() {
    let mut bench = Bench::<Drawing>::new();
    bench.import("input", &2.5);
    bench.set_now(Duration::from_secs(3));
    let panel = bench.draw().expect("no fault");
    assert_eq!(panel.list().time, 3_000_000_000);
    assert_eq!(panel.texts(), ["all is well", "up to"]);
    assert_eq!(panel.value("input"), 2.5);
    assert!(panel.is_on("on"));
    assert!(matches!(
        panel.list().items[0],
        Item::Text {
            words: Words::Good,
            ..
        }
    ));
}

#[test]
fn a_drawing_that_writes_panics_or_is_invalid_fails_with_a_reason() {
    for (step, reason) in [
        (1_u32, "it tried to write while its panel was drawn"),
        (2, "it tried to wake a child while its panel was drawn"),
        (3, "`speed`: a number is NaN"),
        (5, "`table`: 3 texts do not fill 2 columns"),
        (6, "`field`: a size is -1"),
    ] {
        let mut bench = Bench::<Drawing>::new();
        bench.set("step", step);
        let failure = bench.draw().expect_err("the drawing is refused");
        assert_eq!(failure.reason, reason, "step {step}");
        assert_eq!(bench.commanded::<Twist>("base"), None);
        assert!(bench.awake_children().is_empty());
    }
    let mut bench = Bench::<Drawing>::new();
    bench.set("step", 4_u32);
    let failure = bench.draw().expect_err("the drawing panics");
    assert!(
        failure.panicked() && failure.reason.contains("drawing failed"),
        "{failure}"
    );
    bench.set("step", 0_u32);
    bench.draw().expect("no fault");
}

#[test]
fn a_gesture_calls_the_schema_which_may_command_and_wake_children() {
    let mut bench = Bench::<Drawing>::new();
    let at = [1.0, 2.0, 0.0];
    let button = Button::Secondary;
    bench
        .touch("field", Touch::Clicked { at, button })
        .expect("no fault");
    bench.touch("drive", Touch::Pressed).expect("no fault");
    assert_eq!(
        bench.schema().gestures,
        [
            "clicked `field` of ana@laptop at (1.00, 2.00) with the right button",
            "pressed `drive` of ana@laptop",
        ]
    );
    assert_eq!(bench.commanded("base"), Some(Twist::planar(0.1, 0.0)));
    assert_eq!(bench.awake_children(), ["child"]);
    let mut window = Bench::<IgnoresGestures>::new();
    window
        .touch("anything", Touch::Pressed)
        .expect("the gesture is ignored");
}

#[test]
fn only_a_schema_with_a_panel_has_the_panel_ability() {
    let ability = Drawing::TABLE.ability.expect("it has a panel");
    let table = |id: &CStr| {
        // SAFETY: a table made by the macro, and a text.
        unsafe { ability(id.as_ptr()) }.cast::<raw::Panel>()
    };
    let panel = table(c"jde.panel");
    assert!(!panel.is_null());
    // SAFETY: for that id the function returns such a table.
    assert_eq!(unsafe { (*panel).size } as usize, size_of::<raw::Panel>());
    assert!(table(c"jde.pane").is_null() && table(c"jde.panel2").is_null() && table(c"").is_null());
    // SAFETY: null is checked.
    assert!(unsafe { ability(core::ptr::null()) }.is_null());
    assert!(NoPanel::TABLE.ability.is_none());
}
