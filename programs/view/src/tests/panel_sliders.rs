//! Sliders of panels: typed into, and tapped.

use eframe::egui::{self, Key};
use egui_kittest::kittest::Queryable;
use jde_panel::{Item, Touch};

use super::panel::{gestures, harness_with};

#[test]
fn a_number_is_typed_in_the_users_unit_and_reported_in_the_si_unit() {
    let slider = Item::Slider {
        id: "turn".to_owned(),
        label: "Turn rate".to_owned(),
        value: 0.0,
        least: -1.0,
        greatest: 2.0,
        unit: "rad/s".to_owned(),
    };
    let mut harness = harness_with(vec![slider]);
    let typed = harness.get_by_role(egui::accesskit::Role::SpinButton);
    assert_eq!(typed.value().as_deref(), Some("0.0 deg/s"));
    typed.click();
    harness.run();
    harness
        .get_by_role(egui::accesskit::Role::SpinButton)
        .type_text("90");
    harness.run();
    harness.key_press(Key::Enter);
    harness.run();
    let last = gestures(&mut harness).pop();
    let Some((widget, Touch::Moved(to))) = last else {
        panic!("{last:?}");
    };
    assert_eq!(widget, "turn");
    assert!((to - std::f64::consts::FRAC_PI_2).abs() < 1e-9, "{to}");
    // The slider itself is also found by its name.
    harness.get_by_role_and_label(egui::accesskit::Role::Slider, "Turn rate");
}

#[test]
fn a_tap_within_one_frame_moves_a_slider() {
    let slider = Item::Slider {
        id: "turn".to_owned(),
        label: "Turn rate".to_owned(),
        value: -1.0,
        least: -1.0,
        greatest: 3.0,
        unit: String::new(),
    };
    let mut harness = harness_with(vec![slider]);
    let rail = harness.get_by_role_and_label(egui::accesskit::Role::Slider, "Turn rate");
    let at = rail.rect().center();
    harness.hover_at(at);
    harness.step();
    for pressed in [true, false] {
        harness.input_mut().events.push(egui::Event::PointerButton {
            pos: at,
            button: egui::PointerButton::Primary,
            pressed,
            modifiers: egui::Modifiers::NONE,
        });
    }
    harness.run();
    let last = gestures(&mut harness).pop();
    let Some((_, Touch::Moved(to))) = last else {
        panic!("{last:?}");
    };
    assert!((0.8..1.2).contains(&to), "{to}");
}

#[test]
fn a_value_out_of_range_in_the_list_causes_no_gesture() {
    let slider = Item::Slider {
        id: "turn".to_owned(),
        label: "Turn rate".to_owned(),
        value: 9.0,
        least: -1.0,
        greatest: 3.0,
        unit: String::new(),
    };
    let mut harness = harness_with(vec![slider]);
    harness.run();
    assert!(gestures(&mut harness).is_empty());
}
