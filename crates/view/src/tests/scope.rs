//! The oscilloscope on artificial hierarchies, whose past is always the same.

use eframe::egui::{Event, Key, Modifiers, MouseWheelUnit, Pos2, Theme, TouchPhase, Vec2, pos2, vec2};
use egui_kittest::kittest::{NodeT, Queryable};
use egui_kittest::{Harness, SnapshotOptions};
use jde_link::message::Action;

use crate::style::{Style, Units};
use crate::window::scope::fixture::{self, Fixed};
use crate::window::scope::{Request, Scope};

/// The oscilloscope on an artificial hierarchy.
struct Shown {
    scope: Scope,
    fixed: Fixed,
    asks: Vec<Request>,
}

fn shown(fixed: Fixed, theme: Theme) -> Harness<'static, Shown> {
    let shown = Shown {
        scope: Scope::open(&serde_json::Value::Null),
        fixed,
        asks: Vec::new(),
    };
    let mut harness = Harness::builder()
        .with_size(vec2(900.0, 520.0))
        .with_theme(theme)
        .wgpu()
        .build_ui_state(
            |ui, shown: &mut Shown| {
                let style = Style::of(ui.ctx(), Units::default());
                shown
                    .asks
                    .extend(shown.scope.show_fixed(ui, &shown.fixed, &[], &style));
            },
            shown,
        );
    harness.run_steps(3);
    harness
}

/// The position of a time in a schema's row, for a window of 20 s that ends at 10 s.
fn moment(harness: &Harness<'_, Shown>, schema: &str, time: f64) -> Pos2 {
    let traces = harness.get_by_label("Traces").rect();
    let row = harness.get_by_label_contains(&format!("{schema}, ")).rect();
    let share = (time + 10.0) / 20.0;
    pos2(traces.left() + traces.width() * share as f32, row.center().y)
}

fn click(harness: &mut Harness<'_, Shown>, at: Pos2) {
    harness.hover_at(at);
    harness.step();
    harness.drag_at(at);
    harness.step();
    harness.drop_at(at);
    harness.run_steps(2);
}

fn press(harness: &mut Harness<'_, Shown>, key: Key) {
    harness.key_press(key);
    harness.run_steps(2);
}

fn has(harness: &Harness<'_, Shown>, text: &str) -> bool {
    harness.query_all_by_label_contains(text).next().is_some()
}

#[test]
fn it_looks_as_it_did_in_the_dark() {
    looks_as_it_did(Theme::Dark, "scope_dark");
}

#[test]
fn it_looks_as_it_did_in_the_light() {
    looks_as_it_did(Theme::Light, "scope_light");
}

/// Software renderers may differ only at the edges of letters.
fn looks_as_it_did(theme: Theme, name: &str) {
    let mut harness = shown(fixture::navigation(), theme);
    let options = SnapshotOptions::new().threshold(1.5).max_failed_pixels(400);
    harness.snapshot_options(name, &options);
}

#[test]
fn r15_a_click_on_a_switch_opens_its_record_with_the_candidates() {
    let mut harness = shown(fixture::navigation(), Theme::Dark);
    assert!(
        has(&harness, "Cause: the readiness of stop changed"),
        "the newest comes first"
    );
    let at = moment(&harness, "vff", 4.0);
    click(&mut harness, at);
    assert!(has(&harness, "Cause: the readiness of vff changed"));
    assert!(has(&harness, "collision: several were ready"));
    assert!(has(&harness, "Took over in 1.24 ms of 85.0 ms allowed"));
    let names: Vec<_> = ["goon", "vff"]
        .map(|name| harness.query_all_by_label(name).count())
        .into();
    assert_eq!(names, [1, 1], "both candidates are named");
}

#[test]
fn arrows_go_from_switch_to_switch_and_from_row_to_row_and_letters_operate() {
    let mut harness = shown(fixture::navigation(), Theme::Dark);
    harness.get_by_label("Traces").focus();
    harness.run_steps(2);
    press(&mut harness, Key::ArrowLeft);
    assert!(has(&harness, "Cause: the readiness of vff changed"));
    press(&mut harness, Key::ArrowLeft);
    assert!(has(&harness, "Cause: the readiness of goon changed"));
    press(&mut harness, Key::ArrowRight);
    assert!(has(&harness, "Cause: the readiness of vff changed"));
    for _ in 0..3 {
        press(&mut harness, Key::ArrowDown);
    }
    press(&mut harness, Key::F);
    press(&mut harness, Key::P);
    press(&mut harness, Key::R);
    let schema = || "goon".to_owned();
    let asked = [
        Request::Act(Action::Force { schema: schema() }),
        Request::Act(Action::Stop { schema: schema() }),
        Request::Act(Action::Release { schema: schema() }),
    ];
    assert_eq!(harness.state().asks, asked);
}

#[test]
fn space_holds_the_picture_still_and_lets_it_go_on() {
    let mut harness = shown(fixture::navigation(), Theme::Dark);
    press(&mut harness, Key::Space);
    let before = moment(&harness, "vff", 4.0);
    let state = harness.state_mut();
    state.fixed.snapshot.time += 2_000_000_000;
    let later = state.fixed.snapshot.clone();
    state.fixed.past.add_snapshot(&later);
    harness.run_steps(2);
    click(&mut harness, before);
    assert!(
        has(&harness, "Cause: the readiness of vff changed"),
        "it is where it was"
    );
    harness.get_by_label("Run").click();
    harness.run_steps(2);
    assert!(harness.query_by_label("Pause").is_some());
}

#[test]
fn the_wheel_zooms_at_the_pointer_and_a_drag_moves() {
    let mut harness = shown(fixture::navigation(), Theme::Dark);
    press(&mut harness, Key::Space);
    assert!(has(&harness, "2 s/div"));
    let at = moment(&harness, "vff", 4.0);
    harness.hover_at(at);
    harness.event(Event::MouseWheel {
        unit: MouseWheelUnit::Point,
        source: eframe::egui::MouseWheelSource::Wheel,
        delta: vec2(0.0, 460.0),
        phase: TouchPhase::Move,
        modifiers: Modifiers::NONE,
    });
    harness.run_steps(40);
    assert!(!has(&harness, "2 s/div"), "less time");
    click(&mut harness, at);
    assert!(
        has(&harness, "Cause: the readiness of vff changed"),
        "the moment is still under the pointer"
    );

    harness.get_by_label("Newest").click();
    harness.run_steps(2);
    harness.drag_at(at);
    harness.step();
    let moved = at + vec2(-60.0, 0.0);
    for step in 1..=6 {
        harness.hover_at(at + vec2(-10.0, 0.0) * step as f32);
        harness.step();
    }
    harness.drop_at(moved);
    harness.run_steps(2);
    click(&mut harness, moved);
    assert!(
        has(&harness, "Cause: the readiness of vff changed"),
        "the moment went with the pointer"
    );
}

#[test]
fn the_filter_leaves_the_fitting_and_their_fathers() {
    let mut harness = shown(fixture::navigation(), Theme::Dark);
    assert!(has(&harness, "goon, CHECKING"));
    harness.get_by_label("Filter").focus();
    harness.step();
    harness.get_by_label("Filter").type_text("vff");
    harness.run_steps(2);
    assert!(has(&harness, "vff, READY") && has(&harness, "example, WINNER"));
    assert!(!has(&harness, "goon, CHECKING") && has(&harness, "5 left out"));
    harness.get_by_label("all").click();
    harness.run_steps(2);
    harness.get_by_label("troubled").click();
    harness.run_steps(2);
    assert!(has(&harness, "goon, CHECKING, overrun") && has(&harness, "forced by ana@laptop"));
    assert!(!has(&harness, "vff, READY"));
}

#[test]
fn what_is_below_a_schema_folds_away() {
    let mut harness = shown(fixture::navigation(), Theme::Dark);
    harness.get_by_label("Fold example").click();
    harness.run_steps(2);
    assert!(!has(&harness, "goon, ") && has(&harness, "pioneer, WINNER"));
    harness.get_by_label("Unfold example").click();
    harness.run_steps(2);
    assert!(has(&harness, "goon, "));
}

#[test]
fn a_period_that_cannot_be_read_says_why_and_one_that_can_is_asked_for() {
    let mut harness = shown(fixture::navigation(), Theme::Dark);
    let retype = |harness: &mut Harness<'_, Shown>, text: &str| {
        harness.get_by_label("New period of goon").type_text(text);
        harness.run_steps(2);
        press(harness, Key::Enter);
    };
    harness.get_by_label("Period of goon: 75 ms").click();
    harness.run_steps(3);
    retype(&mut harness, "50");
    assert!(has(&harness, "needs a unit"));
    assert!(harness.state().asks.is_empty());
    retype(&mut harness, "ms");
    let asked = Request::Act(Action::Period {
        schema: "goon".to_owned(),
        period_s: 0.05,
    });
    assert_eq!(harness.state().asks, [asked]);
    assert!(harness.query_by_label("New period of goon").is_none());
}

#[test]
fn r14_buttons_ask_as_an_operator_and_only_for_what_can_be_done() {
    let mut harness = shown(fixture::navigation(), Theme::Dark);
    for label in [
        "Play goon",
        "Stop vff",
        "Force goon",
        "Release stop",
        "Panel of example",
    ] {
        harness.get_by_label(label).click();
        harness.run_steps(2);
    }
    let schema = |name: &str| name.to_owned();
    let asked = [
        Request::Act(Action::Play {
            schema: schema("goon"),
        }),
        Request::Act(Action::Stop {
            schema: schema("vff"),
        }),
        Request::Act(Action::Force {
            schema: schema("goon"),
        }),
        Request::Act(Action::Release {
            schema: schema("stop"),
        }),
        Request::Panel(schema("example")),
    ];
    assert_eq!(harness.state().asks, asked);
    for label in ["Force pioneer", "Release goon"] {
        assert!(
            harness.get_by_label(label).accesskit_node().is_disabled(),
            "{label}"
        );
    }
}

#[test]
fn two_cursors_tell_the_time_between_them() {
    let mut harness = shown(fixture::navigation(), Theme::Dark);
    harness.get_by_label("Cursors").click();
    harness.run_steps(2);
    assert!(has(&harness, "B − A 6.67 s"), "at the thirds of 20 s");
    press(&mut harness, Key::Space);
    let from = moment(&harness, "vff", 10.0 - 20.0 / 3.0);
    harness.hover_at(from);
    harness.step();
    harness.drag_at(from);
    harness.step();
    for step in 1..=4 {
        harness.hover_at(from + step as f32 * 0.25 * (moment(&harness, "vff", 8.0) - from));
        harness.step();
    }
    harness.drop_at(moment(&harness, "vff", 8.0));
    harness.run_steps(2);
    assert!(has(&harness, "B − A 11.3 s"), "from -3.33 s to 8 s");
}

/// A thousand schemas, most in groups of ten, each with this many changes of state.
fn thousand(bands: usize) -> Fixed {
    use jde_abi::describe::Kind;
    use jde_core::State;
    let mut schemas = vec![fixture::schema("father", Kind::Motor, None, Some(0))];
    let mut groups = vec![fixture::group("roots", None, &[0])];
    for nth in 1..1000 {
        let group = 1 + (nth - 1) / 10;
        if groups.len() == group {
            groups.push(fixture::group(&format!("father/group{group}"), Some(0), &[]));
        }
        groups[group].members.push(nth);
        let mut schema = fixture::schema(&format!("schema{nth}"), Kind::Motor, Some(0), Some(group));
        schema.state = if nth % 10 == 0 {
            State::Winner
        } else {
            State::Checking
        };
        schemas.push(schema);
    }
    let snapshot = jde_records::snapshot::Snapshot {
        time: 1_000_000_000_000,
        schemas,
        groups,
    };
    let mut fixed = Fixed::of(snapshot);
    let words = ["slept", "checking", "ready", "winner"];
    for nth in 0..1000 {
        let name = fixed.snapshot.schemas[nth].name.clone();
        for band in 0..bands {
            let time = (band as f64 + nth as f64 / 1000.0) * 999.0 / bands as f64;
            let word = |step: usize| words[(step + nth) % 4];
            fixed.change(time, &name, word(band), word(band + 1));
        }
    }
    for nth in 0..20_000 {
        let group = 1 + nth as usize % 100;
        let choice = format!("schema{}", (group - 1) * 10 + 1 + nth as usize % 9);
        let time = f64::from(nth as u32) * 0.049;
        let selection = fixture::selection(
            nth + 1,
            time,
            &format!("father/group{group}"),
            None,
            &choice,
            "alone",
        );
        fixed
            .past
            .add_line(jde_records::RunRecord::Decision(selection), 0);
    }
    let snapshot = fixed.snapshot.clone();
    fixed.past.add_snapshot(&snapshot);
    fixed
}

#[test]
fn of_a_thousand_schemas_those_in_sight_are_drawn() {
    let mut harness = shown(thousand(50), Theme::Dark);
    assert!(has(&harness, "schema1, "));
    assert!(!has(&harness, "schema900, "));
    let rows = harness.query_all_by_label_contains(", ok").count();
    assert!(rows < 60, "{rows}");
    harness.get_by_label("Filter").focus();
    harness.step();
    harness.get_by_label("Filter").type_text("schema900");
    harness.run_steps(2);
    assert!(has(&harness, "schema900, "));
}

#[test]
fn what_is_drawn_does_not_grow_with_the_history() {
    let shapes = |bands| {
        let fixed = thousand(bands);
        let mut scope = Scope::open(&serde_json::json!({ "span": 1000.0, "share": 0.5 }));
        let ctx = eframe::egui::Context::default();
        let style = Style::of(&ctx, Units::default());
        let mut shapes = 0;
        for _ in 0..3 {
            let input = eframe::egui::RawInput {
                screen_rect: Some(eframe::egui::Rect::from_min_size(
                    Pos2::ZERO,
                    Vec2::new(1440.0, 900.0),
                )),
                ..eframe::egui::RawInput::default()
            };
            let mut output = ctx.run_ui(input, |ui| drop(scope.show_fixed(ui, &fixed, &[], &style)));
            // No renderer takes the textures.
            output.textures_delta.clear();
            shapes = output.shapes.len();
        }
        shapes
    };
    let (few, many) = (shapes(2_000), shapes(20_000));
    assert!(
        many <= few + few / 10,
        "{few} shapes for 2000 states, {many} for 20000"
    );
}
