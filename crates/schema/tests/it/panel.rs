//! Panels through the same tables as the host uses: drawings, refusals and gestures.

#![allow(unsafe_code)]

use core::ffi::CStr;

use jde_abi::raw;
use jde_schema::bench::Bench;
use jde_schema::panel::{Button, Item, Touch, Words};
use jde_schema::prelude::*;

/// Draws what a modulation selects.
#[derive(Describe)]
#[schema(motor, period = "1s")]
struct Easel {
    #[modulation(default = 0)]
    step: Modulation<u32>,
    #[import(optional)]
    input: Import<f64>,
    #[actuator(optional)]
    base: Actuator<Twist>,
    #[child(group = "base", optional)]
    child: Child,
    done: Vec<String>,
}

impl Schema for Easel {
    fn iterate(&mut self, _: &Context) -> Result {
        Ok(())
    }
}

impl Panel for Easel {
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
            4 => panic!("the paint is out"),
            5 => pen.table("table", ["a", "b"], [["only one"]]),
            6 => pen.canvas("field").show(|field| {
                field.circle((0.0, 0.0), -1.0).ink(Ink::Bad);
            }),
            _ => {}
        }
    }

    fn touched(&mut self, cx: &Context, gesture: &Gesture) -> Result {
        self.done.push(gesture.words(gesture.by()));
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
struct Window {}

impl Schema for Window {
    fn iterate(&mut self, _: &Context) -> Result {
        Ok(())
    }
}

impl Panel for Window {
    fn draw(&self, _: &Context, _: &mut Pen) {}
}

/// Has no panel.
#[derive(Describe)]
#[schema(perceptive, period = "1s")]
struct Blind {}

impl Schema for Blind {
    fn iterate(&mut self, _: &Context) -> Result {
        Ok(())
    }
}

#[test]
fn a_panel_shows_what_was_drawn() {
    let mut bench = Bench::<Easel>::new();
    bench.import("input", &2.5);
    bench.set_now(Duration::from_secs(3));
    let panel = bench.draw().expect("it shows");
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
fn what_a_panel_cannot_show_or_do_is_said() {
    for (step, reason) in [
        (1_u32, "it tried to write while its panel was drawn"),
        (2, "it tried to wake a child while its panel was drawn"),
        (3, "`speed`: a number is NaN"),
        (5, "`table`: 3 texts do not fill 2 columns"),
        (6, "`field`: a size is -1"),
    ] {
        let mut bench = Bench::<Easel>::new();
        bench.set("step", step);
        let failure = bench.draw().expect_err("it is refused");
        assert_eq!(failure.reason, reason, "step {step}");
        assert_eq!(bench.commanded::<Twist>("base"), None);
        assert!(bench.awake_children().is_empty());
    }
    let mut bench = Bench::<Easel>::new();
    bench.set("step", 4_u32);
    let failure = bench.draw().expect_err("it panics");
    assert!(
        failure.panicked() && failure.reason.contains("the paint is out"),
        "{failure}"
    );
    bench.set("step", 0_u32);
    bench.draw().expect("and shows again");
}

#[test]
fn a_gesture_is_a_call_like_any_other() {
    let mut bench = Bench::<Easel>::new();
    let at = [1.0, 2.0, 0.0];
    let button = Button::Secondary;
    bench
        .touch("field", Touch::Clicked { at, button })
        .expect("no fault");
    bench.touch("drive", Touch::Pressed).expect("no fault");
    assert_eq!(
        bench.schema().done,
        [
            "clicked `field` of ana@laptop at (1.00, 2.00) with the right button",
            "pressed `drive` of ana@laptop",
        ]
    );
    assert_eq!(bench.commanded("base"), Some(Twist::planar(0.1, 0.0)));
    assert_eq!(bench.awake_children(), ["child"]);
    let mut window = Bench::<Window>::new();
    window.touch("anything", Touch::Pressed).expect("it is ignored");
}

#[test]
fn a_schema_has_the_ability_if_it_has_a_panel_and_no_other() {
    let ability = Easel::TABLE.ability.expect("it has a panel");
    let ask = |id: &CStr| {
        // SAFETY: a table made by the macro, and a text.
        unsafe { ability(id.as_ptr()) }.cast::<raw::Panel>()
    };
    let panel = ask(c"jde.panel");
    assert!(!panel.is_null());
    // SAFETY: for that id the function returns such a table.
    assert_eq!(unsafe { (*panel).size } as usize, size_of::<raw::Panel>());
    assert!(ask(c"jde.pane").is_null() && ask(c"jde.panel2").is_null() && ask(c"").is_null());
    // SAFETY: null is checked.
    assert!(unsafe { ability(core::ptr::null()) }.is_null());
    assert!(Blind::TABLE.ability.is_none());
}
