//! Panels of schemas: each widget is found by its label and operated, and the reported gesture is compared
//! exactly.

use std::sync::Arc;

use eframe::egui::{self, Key, PointerButton, Pos2, Theme, pos2, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use jde_panel::{Area, Button, Color, Gesture, Ink, Item, List, Shape, Stroke, Touch, Wants, Words, check};

use crate::style::{Style, Units};
use crate::window::panel::bench::Bench;

const AREA: Area = Area {
    least: [-2.0, -1.0],
    greatest: [2.0, 3.0],
};

pub(super) fn harness_of(items: Vec<Item>, size: [f32; 2], theme: Theme) -> Harness<'static, Bench> {
    let list = List { time: 1, items };
    assert_eq!(check(&list), Ok(()));
    let bench = Bench::of(list);
    let show = |ui: &mut egui::Ui, bench: &mut Bench| {
        let style = Style::of(ui.ctx(), Units::default());
        bench.show(ui, &style);
    };
    let mut harness = Harness::builder()
        .with_size(size)
        .with_theme(theme)
        .build_ui_state(show, bench);
    harness.run();
    harness
}

pub(super) fn harness_with(items: Vec<Item>) -> Harness<'static, Bench> {
    harness_of(items, [420.0, 420.0], Theme::Dark)
}

fn show_items(harness: &mut Harness<'_, Bench>, items: Vec<Item>) {
    harness.state_mut().list = Arc::new(List { time: 2, items });
    harness.step();
}

pub(super) fn gestures(harness: &mut Harness<'_, Bench>) -> Vec<(String, Touch)> {
    let reported = std::mem::take(&mut harness.state_mut().gestures);
    reported
        .into_iter()
        .map(|Gesture { widget, touch }| (widget, touch))
        .collect()
}

fn only_gesture(harness: &mut Harness<'_, Bench>, widget: &str) -> Touch {
    let mut reported = gestures(harness);
    assert_eq!(reported.len(), 1, "{reported:?}");
    let (of, touch) = reported.remove(0);
    assert_eq!(of, widget);
    touch
}

fn stroke(color: Ink) -> Stroke {
    Stroke {
        color: color.into(),
        width: 2.0,
    }
}

pub(super) fn field(wants: Wants, forward_up: bool) -> Item {
    Item::Canvas {
        id: "field".to_owned(),
        area: Some(AREA),
        forward_up,
        shapes: vec![
            Shape::Polygon {
                points: vec![[0.0, -0.3], [0.6, -0.3], [0.6, 0.3], [0.0, 0.3]],
                color: Color::Exact([245, 100, 90, 60]),
            },
            Shape::Points {
                points: (0..60)
                    .map(|n| f64::from(n) * 0.05)
                    .map(|a| [1.5 * a.cos(), 1.5 * a.sin()])
                    .collect(),
                stroke: stroke(Ink::Seen),
            },
            Shape::Circle {
                center: [1.0, 2.0],
                radius: 0.3,
                filled: false,
                stroke: stroke(Ink::Goal),
            },
            Shape::Arrow {
                from: [0.0, 0.0],
                to: [1.0, 1.0],
                stroke: stroke(Ink::Accent),
            },
            Shape::Line {
                points: vec![[-1.5, -0.5], [-1.5, 2.5], [-0.5, 2.5]],
                closed: false,
                stroke: stroke(Ink::Faint),
            },
            Shape::Label {
                at: [1.0, 2.0],
                text: "target".to_owned(),
                color: Ink::Goal.into(),
            },
            Shape::Robot {
                pose: [0.0, 0.0, 0.5],
            },
        ],
        wants,
    }
}

pub(super) fn clicks() -> Wants {
    Wants {
        clicks: true,
        ..Wants::default()
    }
}

/// The position on the screen of a position on the plane, without pan and zoom. Computed independently of the
/// tested code.
fn on_screen(rect: egui::Rect, [x, y]: [f64; 2], forward_up: bool) -> Pos2 {
    let scale = 0.92 * f64::from(rect.width()).min(f64::from(rect.height())) / 4.0;
    let (x, y) = (x * scale, (y - 1.0) * scale);
    let middle = rect.center();
    if forward_up {
        pos2(middle.x - y as f32, middle.y - x as f32)
    } else {
        pos2(middle.x + x as f32, middle.y - y as f32)
    }
}

fn press(harness: &mut Harness<'_, Bench>, at: Pos2, button: PointerButton, pressed: bool) {
    harness.event(egui::Event::PointerMoved(at));
    harness.event(egui::Event::PointerButton {
        pos: at,
        button,
        pressed,
        modifiers: egui::Modifiers::NONE,
    });
    harness.step();
}

fn move_pointer(harness: &mut Harness<'_, Bench>, at: Pos2) {
    harness.event(egui::Event::PointerMoved(at));
    harness.step();
}

#[track_caller]
fn assert_near(at: [f64; 3], place: [f64; 2], pixel: f64) {
    let off = (at[0] - place[0]).hypot(at[1] - place[1]);
    assert!(off <= pixel && at[2] == 0.0, "{at:?} is {off} m from {place:?}");
}

#[test]
fn an_enabled_button_reports_a_press_and_a_disabled_one_does_not() {
    let button = |enabled| Item::Button {
        id: "go".to_owned(),
        label: "Go there".to_owned(),
        enabled,
    };
    let mut harness = harness_with(vec![button(true)]);
    harness.get_by_label("Go there").click();
    harness.run();
    assert_eq!(only_gesture(&mut harness, "go"), Touch::Pressed);
    show_items(&mut harness, vec![button(false)]);
    harness.get_by_label("Go there").click();
    harness.run();
    assert_eq!(gestures(&mut harness), []);
}

#[test]
fn a_toggle_keeps_its_position_until_the_schema_sends_a_new_one() {
    let toggle = |on| Item::Toggle {
        id: "quiet".to_owned(),
        label: "Quiet".to_owned(),
        on,
    };
    let on = |harness: &Harness<'_, Bench>| {
        let toggled = harness.get_by_label("Quiet").accesskit_node().toggled();
        toggled == Some(egui::accesskit::Toggled::True)
    };
    let mut harness = harness_with(vec![toggle(false)]);
    harness.get_by_label("Quiet").click();
    harness.step();
    harness.step();
    assert_eq!(only_gesture(&mut harness, "quiet"), Touch::Toggled(true));
    assert!(on(&harness));
    // A list that was in transit at the touch does not reset the toggle.
    show_items(&mut harness, vec![toggle(false)]);
    assert!(on(&harness));
    show_items(&mut harness, vec![toggle(true)]);
    assert!(on(&harness));
    show_items(&mut harness, vec![toggle(false)]);
    assert!(!on(&harness));
}

#[test]
fn a_choice_reports_the_chosen_option() {
    let choice = Item::Choice {
        id: "way".to_owned(),
        label: "Way".to_owned(),
        options: ["straight", "around", "back"].map(str::to_owned).into(),
        chosen: 0,
    };
    let mut harness = harness_with(vec![choice]);
    harness
        .get_by_role_and_label(egui::accesskit::Role::ComboBox, "Way")
        .click();
    harness.run();
    harness.get_by_label("around").click();
    harness.run_steps(3);
    assert_eq!(only_gesture(&mut harness, "way"), Touch::Chose(1));
}

#[test]
fn a_click_on_a_plane_is_reported_in_metres_to_the_pixel() {
    for forward_up in [false, true] {
        let mut harness = harness_with(vec![field(clicks(), forward_up)]);
        let rect = harness.get_by_label("field").rect();
        let pixel = 4.0 / (0.92 * f64::from(rect.width().min(rect.height())));
        for (place, pointer_button, button) in [
            ([1.0, 2.0], PointerButton::Primary, Button::Primary),
            ([-1.2, 0.4], PointerButton::Secondary, Button::Secondary),
            ([0.3, 2.2], PointerButton::Middle, Button::Middle),
        ] {
            let at = on_screen(rect, place, forward_up);
            press(&mut harness, at, pointer_button, true);
            press(&mut harness, at, pointer_button, false);
            let Touch::Clicked { at, button: by } = only_gesture(&mut harness, "field") else {
                panic!("no click");
            };
            assert_eq!(by, button);
            assert_near(at, place, pixel);
        }
    }
}

#[test]
fn a_drag_is_reported_until_it_ends_and_does_not_pan() {
    let wants = Wants {
        drags: true,
        ..Wants::default()
    };
    let mut harness = harness_with(vec![field(wants, false)]);
    let rect = harness.get_by_label("field").rect();
    let pixel = 4.0 / (0.92 * f64::from(rect.width().min(rect.height())));
    let (start, end) = ([0.0, 0.0], [1.0, 1.5]);
    press(
        &mut harness,
        on_screen(rect, start, false),
        PointerButton::Primary,
        true,
    );
    move_pointer(&mut harness, on_screen(rect, [0.5, 0.5], false));
    move_pointer(&mut harness, on_screen(rect, end, false));
    press(
        &mut harness,
        on_screen(rect, end, false),
        PointerButton::Primary,
        false,
    );
    harness.step();
    let drags: Vec<_> = gestures(&mut harness)
        .into_iter()
        .map(|(_, touch)| match touch {
            Touch::Dragged {
                from,
                to,
                button: Button::Primary,
                ended,
            } => (from, to, ended),
            other => panic!("{other:?}"),
        })
        .collect();
    assert!(drags.len() >= 3, "{drags:?}");
    let (last, under_way) = drags.split_last().unwrap();
    assert!(
        under_way.iter().all(|(_, _, ended)| !ended) && last.2,
        "{drags:?}"
    );
    drags
        .iter()
        .for_each(|(from, _, _)| assert_near(*from, start, pixel));
    assert_near(last.1, end, pixel);
}

#[test]
fn a_plane_without_listeners_can_be_panned_zoomed_and_reset() {
    let mut harness = harness_with(vec![field(Wants::default(), false)]);
    let rect = harness.get_by_label("field").rect();
    let place = [1.0, 2.0];
    let seen = |harness: &mut Harness<'_, Bench>, at: Pos2| {
        show_items(harness, vec![field(clicks(), false)]);
        press(harness, at, PointerButton::Primary, true);
        press(harness, at, PointerButton::Primary, false);
        let touch = only_gesture(harness, "field");
        show_items(harness, vec![field(Wants::default(), false)]);
        match touch {
            Touch::Clicked { at, .. } => at,
            other => panic!("{other:?}"),
        }
    };
    let pixel = 4.0 / (0.92 * f64::from(rect.width().min(rect.height())));
    let at = on_screen(rect, place, false);
    press(&mut harness, at, PointerButton::Primary, true);
    move_pointer(&mut harness, at + vec2(20.0, 0.0));
    move_pointer(&mut harness, at + vec2(60.0, -40.0));
    press(
        &mut harness,
        at + vec2(60.0, -40.0),
        PointerButton::Primary,
        false,
    );
    assert_eq!(gestures(&mut harness), []);
    assert_near(seen(&mut harness, at + vec2(60.0, -40.0)), place, pixel);
    // The wheel zooms at the pointer: the point under it stays, and a point beside it moves nearer.
    let pointer = at + vec2(60.0, -40.0);
    let beside = seen(&mut harness, pointer - vec2(80.0, 0.0));
    move_pointer(&mut harness, pointer);
    harness.event(egui::Event::MouseWheel {
        unit: egui::MouseWheelUnit::Point,
        delta: vec2(0.0, 120.0),
        phase: egui::TouchPhase::Move,
        source: egui::MouseWheelSource::Wheel,
        modifiers: egui::Modifiers::NONE,
    });
    harness.run();
    assert_near(seen(&mut harness, pointer), place, pixel);
    let nearer = seen(&mut harness, pointer - vec2(80.0, 0.0));
    assert!(nearer[0] > beside[0] + 4.0 * pixel, "{nearer:?} was {beside:?}");
    harness.get_by_label("whole view of field").click();
    harness.run();
    assert_near(seen(&mut harness, at), place, pixel);
    // The keys pan too, once the plane has the focus.
    harness.get_by_label("field").focus();
    harness.run();
    harness.key_press(Key::ArrowRight);
    harness.run();
    assert_near(seen(&mut harness, at - vec2(40.0, 0.0)), place, pixel);
    harness.key_press(Key::Num0);
    harness.run();
    assert_near(seen(&mut harness, at), place, pixel);
}

#[test]
fn keys_go_to_the_focused_plane_and_are_released_when_the_focus_is_lost() {
    let wants = Wants {
        keys: true,
        ..Wants::default()
    };
    let mut harness = harness_with(vec![field(wants, false)]);
    harness.key_press(Key::A);
    harness.run();
    assert_eq!(gestures(&mut harness), []);
    harness.get_by_label("field").focus();
    harness.run();
    harness.key_press(Key::A);
    harness.run();
    harness.key_down(Key::ArrowUp);
    harness.run();
    let key = |key: &str, down| {
        let key = key.to_owned();
        ("field".to_owned(), Touch::Key { key, down })
    };
    assert_eq!(
        gestures(&mut harness),
        [key("a", true), key("a", false), key("ArrowUp", true)]
    );
    harness.input_mut().focused = false;
    harness.event(egui::Event::WindowFocused(false));
    harness.run();
    assert_eq!(gestures(&mut harness), [key("ArrowUp", false)]);
}

#[test]
fn a_click_on_a_picture_is_reported_in_its_pixels() {
    let picture = Item::Image {
        id: "seen".to_owned(),
        width: 8,
        height: 4,
        channels: 1,
        pixels: vec![128; 32],
        wants: clicks(),
    };
    let mut harness = harness_with(vec![picture]);
    let rect = harness.get_by_label("seen").rect();
    assert!((rect.width() / rect.height() - 2.0).abs() < 0.01, "{rect:?}");
    let at = rect.min + vec2(rect.width() * 2.5 / 8.0, rect.height() * 3.5 / 4.0);
    press(&mut harness, at, PointerButton::Primary, true);
    press(&mut harness, at, PointerButton::Primary, false);
    let Touch::Clicked { at, .. } = only_gesture(&mut harness, "seen") else {
        panic!("no click");
    };
    assert_near(at, [2.5, 3.5], 8.0 / f64::from(rect.width()));
}

#[test]
fn a_picture_that_exceeds_the_graphics_cards_limit_is_refused_with_a_message() {
    let picture = Item::Image {
        id: "seen".to_owned(),
        width: 2049,
        height: 1,
        channels: 1,
        pixels: vec![128; 2049],
        wants: clicks(),
    };
    let mut harness = harness_with(Vec::new());
    harness.input_mut().max_texture_side = Some(2048);
    harness.run();
    show_items(&mut harness, vec![picture]);
    harness
        .get_by_label("seen: 2049 × 1 pixels are too large for this graphics card, which takes 2048 × 2048");
}

#[test]
fn only_visible_table_rows_are_laid_out_and_a_heading_sorts_the_table() {
    let table = Item::Table {
        id: "rows".to_owned(),
        columns: vec!["name".to_owned(), "distance".to_owned()],
        rows: (0..2000)
            .map(|n| vec![format!("wall {n}"), format!("{} m", (n * 7919) % 2000)])
            .collect(),
    };
    let mut harness = harness_with(vec![table]);
    assert!(harness.query_by_label("wall 0").is_some());
    assert!(harness.query_by_label("wall 1500").is_none());
    harness.get_by_label("distance").click();
    harness.run();
    let zero = harness.get_by_label("0 m").rect().top();
    let two = harness.get_by_label("2 m").rect().top();
    assert!(zero < two && harness.query_by_label("1999 m").is_none());
}

#[test]
fn a_click_unfolds_a_group() {
    let group = Item::Group {
        id: "more".to_owned(),
        label: "More".to_owned(),
        open: false,
        items: vec![Item::Text {
            text: "hidden".to_owned(),
            words: Words::Plain,
        }],
    };
    let mut harness = harness_with(vec![group]);
    assert!(harness.query_by_label("hidden").is_none());
    harness.get_by_label("More").click();
    harness.run();
    assert!(harness.query_by_label("hidden").is_some());
}
