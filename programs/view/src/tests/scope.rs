//! The oscilloscope on artificial hierarchies with a constant past.

use eframe::egui::{Event, Key, Modifiers, MouseWheelUnit, Pos2, Theme, TouchPhase, Vec2, pos2, vec2};
use egui_kittest::kittest::{NodeT, Queryable};
use egui_kittest::{Harness, SnapshotOptions};
use jde_core::Case;
use jde_link::message::Action;

use crate::style::{Style, Units};
use crate::window::scope::fixture::{self, Fixed};
use crate::window::scope::{Request, Scope};

/// The oscilloscope on an artificial hierarchy.
struct Shown {
    scope: Scope,
    fixed: Fixed,
    requests: Vec<Request>,
}

fn shown(fixed: Fixed, theme: Theme) -> Harness<'static, Shown> {
    let shown = Shown {
        scope: Scope::open(&serde_json::Value::Null),
        fixed,
        requests: Vec::new(),
    };
    let mut harness = Harness::builder()
        .with_size(vec2(900.0, 520.0))
        .with_theme(theme)
        .wgpu()
        .build_ui_state(
            |ui, shown: &mut Shown| {
                crate::style::install(ui.ctx());
                let style = Style::of(ui.ctx(), Units::default());
                shown
                    .requests
                    .extend(shown.scope.show_fixed(ui, &shown.fixed, &[], &style));
            },
            shown,
        );
    harness.run_steps(3);
    harness
}

/// The position of a time in a schema's row, for a window of 20 s that ends at 10 s.
fn position_of(harness: &Harness<'_, Shown>, schema: &str, time: f64) -> Pos2 {
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

fn select(harness: &mut Harness<'_, Shown>, schema: &str) {
    harness.get_by_label_contains(&format!("{schema}, ")).click();
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
fn the_oscilloscope_matches_its_snapshot_in_the_dark_theme() {
    assert_snapshot(Theme::Dark, "scope_dark");
}

#[test]
fn the_oscilloscope_matches_its_snapshot_in_the_light_theme() {
    assert_snapshot(Theme::Light, "scope_light");
}

/// Software renderers may differ only at the edges of letters.
fn assert_snapshot(theme: Theme, name: &str) {
    let mut harness = shown(fixture::navigation(), theme);
    let options = SnapshotOptions::new().threshold(1.5).max_failed_pixels(400);
    harness.snapshot_options(name, &options);
}

#[test]
fn r15_a_click_on_a_takeover_opens_its_record_with_the_candidates() {
    let mut harness = shown(fixture::navigation(), Theme::Dark);
    assert!(
        has(&harness, "Cause: the readiness of stop changed"),
        "the newest takeover is shown first"
    );
    let at = position_of(&harness, "vff", 4.0);
    click(&mut harness, at);
    assert!(has(&harness, "Cause: the readiness of vff changed"));
    assert!(has(&harness, "conflict: two or more were ready"));
    assert!(has(&harness, "Took over in 1.24 ms of 85.0 ms allowed"));
    let names: Vec<_> = ["goon", "vff"]
        .map(|name| harness.query_all_by_label(name).count())
        .into();
    assert_eq!(
        names,
        [1, 2],
        "the record names both candidates, and vff is selected"
    );
}

#[test]
fn arrow_keys_move_between_takeovers_and_rows_and_letter_keys_operate() {
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
    press(&mut harness, Key::S);
    press(&mut harness, Key::R);
    let schema = || "goon".to_owned();
    let expected = [
        Request::Act(Action::Force { schema: schema() }),
        Request::Act(Action::Play { schema: schema() }),
        Request::Act(Action::Stop { schema: schema() }),
        Request::Act(Action::Release { schema: schema() }),
    ];
    assert_eq!(harness.state().requests, expected);
}

#[test]
fn letter_keys_do_not_act_on_a_schema_whose_row_is_folded() {
    let mut harness = shown(fixture::navigation(), Theme::Dark);
    select(&mut harness, "vff");
    harness.get_by_label("Fold example").click();
    harness.run_steps(2);
    harness.get_by_label("Traces").focus();
    harness.run_steps(2);
    press(&mut harness, Key::S);
    assert!(harness.state().requests.is_empty());
    harness.get_by_label("Unfold example").click();
    harness.run_steps(2);
    harness.get_by_label("Traces").focus();
    harness.run_steps(2);
    press(&mut harness, Key::S);
    let stop = Action::Stop {
        schema: "vff".to_owned(),
    };
    assert_eq!(harness.state().requests, [Request::Act(stop)]);
}

#[test]
fn a_narrow_window_shows_every_action_on_the_selected_schema() {
    let mut harness = shown(fixture::navigation(), Theme::Dark);
    select(&mut harness, "vff");
    harness.set_size(vec2(340.0, 520.0));
    harness.run_steps(4);
    let [play, panel] = ["Play vff", "Panel vff"].map(|action| harness.get_by_label(action).rect());
    assert!(panel.right() <= 340.0, "{panel:?} is whole");
    assert!(play.bottom() <= panel.top(), "{panel:?} is below {play:?}");
}

#[test]
fn the_space_key_pauses_the_picture_and_run_resumes_it() {
    let mut harness = shown(fixture::navigation(), Theme::Dark);
    press(&mut harness, Key::Space);
    let before = position_of(&harness, "vff", 4.0);
    let state = harness.state_mut();
    state.fixed.snapshot.time += 2_000_000_000;
    let later = state.fixed.snapshot.clone();
    state.fixed.timeline.add_snapshot(&later);
    harness.run_steps(2);
    click(&mut harness, before);
    assert!(
        has(&harness, "Cause: the readiness of vff changed"),
        "the paused picture did not move"
    );
    harness.get_by_label("Run").click();
    harness.run_steps(2);
    assert!(harness.query_by_label("Pause").is_some());
}

#[test]
fn the_wheel_zooms_at_the_pointer_and_a_drag_pans() {
    let mut harness = shown(fixture::navigation(), Theme::Dark);
    press(&mut harness, Key::Space);
    assert!(has(&harness, "2 s/div"));
    let at = position_of(&harness, "vff", 4.0);
    harness.hover_at(at);
    harness.event(Event::MouseWheel {
        unit: MouseWheelUnit::Point,
        source: eframe::egui::MouseWheelSource::Wheel,
        delta: vec2(0.0, 460.0),
        phase: TouchPhase::Move,
        modifiers: Modifiers::NONE,
    });
    harness.run_steps(40);
    assert!(!has(&harness, "2 s/div"), "a division spans less time");
    click(&mut harness, at);
    assert!(
        has(&harness, "Cause: the readiness of vff changed"),
        "the time is still under the pointer"
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
        "the time moved with the pointer"
    );
}

#[test]
fn the_filter_keeps_matching_schemas_and_their_fathers() {
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
fn the_children_of_a_schema_can_be_folded() {
    let mut harness = shown(fixture::navigation(), Theme::Dark);
    harness.get_by_label("Fold example").click();
    harness.run_steps(2);
    assert!(!has(&harness, "goon, ") && has(&harness, "pioneer, running"));
    harness.get_by_label("Unfold example").click();
    harness.run_steps(2);
    assert!(has(&harness, "goon, "));
}

#[test]
fn an_invalid_period_is_refused_with_the_reason_and_a_valid_one_is_requested() {
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
    assert!(harness.state().requests.is_empty());
    retype(&mut harness, "ms");
    let expected = Request::Act(Action::Period {
        schema: "goon".to_owned(),
        period_s: 0.05,
    });
    assert_eq!(harness.state().requests, [expected]);
    assert!(harness.query_by_label("New period of goon").is_none());
}

#[test]
fn r14_buttons_send_operator_requests_and_are_disabled_where_an_action_is_impossible() {
    let mut harness = shown(fixture::navigation(), Theme::Dark);
    for (verb, name) in [
        ("Play", "goon"),
        ("Stop", "vff"),
        ("Force", "goon"),
        ("Release", "stop"),
        ("Panel", "example"),
    ] {
        select(&mut harness, name);
        harness.get_by_label(&format!("{verb} {name}")).click();
        harness.run_steps(2);
    }
    let schema = |name: &str| name.to_owned();
    let expected = [
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
    assert_eq!(harness.state().requests, expected);
    for (verb, name) in [("Force", "pioneer"), ("Release", "goon")] {
        select(&mut harness, name);
        let label = format!("{verb} {name}");
        let button = harness.get_by_label(&label);
        assert!(button.accesskit_node().is_disabled(), "{verb} {name}");
    }
}

#[test]
fn two_cursors_show_the_time_between_them() {
    let mut harness = shown(fixture::navigation(), Theme::Dark);
    harness.get_by_label("Cursors").click();
    harness.run_steps(2);
    assert!(has(&harness, "B − A 6.67 s"), "at the thirds of 20 s");
    press(&mut harness, Key::Space);
    let from = position_of(&harness, "vff", 10.0 - 20.0 / 3.0);
    harness.hover_at(from);
    harness.step();
    harness.drag_at(from);
    harness.step();
    for step in 1..=4 {
        harness.hover_at(from + step as f32 * 0.25 * (position_of(&harness, "vff", 8.0) - from));
        harness.step();
    }
    harness.drop_at(position_of(&harness, "vff", 8.0));
    harness.run_steps(2);
    assert!(has(&harness, "B − A 11.3 s"), "from -3.33 s to 8 s");
}

/// A thousand schemas, most in groups of ten, each with `bands` changes of state.
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
        ..jde_records::snapshot::Snapshot::default()
    };
    let mut fixed = Fixed::of(snapshot);
    let states = State::ALL;
    for nth in 0..1000 {
        let name = fixed.snapshot.schemas[nth].name.clone();
        for band in 0..bands {
            let time = (band as f64 + nth as f64 / 1000.0) * 999.0 / bands as f64;
            let state_at = |step: usize| states[(step + nth) % 4];
            fixed.change(time, &name, state_at(band), state_at(band + 1));
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
            Case::Alone,
        );
        fixed.timeline.add(&jde_records::RunRecord::Decision(selection));
    }
    let snapshot = fixed.snapshot.clone();
    fixed.timeline.add_snapshot(&snapshot);
    fixed
}

#[test]
fn of_a_thousand_schemas_only_visible_rows_are_drawn() {
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
fn the_number_of_shapes_does_not_grow_with_the_history() {
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
    let (few, many) = (shapes(4_000), shapes(16_000));
    assert!(
        many <= few + few / 10,
        "{few} shapes for 4000 states, {many} for 16000"
    );
}
