//! What is drawn can be read: every text has contrast in both themes, and a small window keeps names and states.

use eframe::egui::{Rect, Theme, ThemePreference, Vec2, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::{By, Queryable};

use super::common::{Robot, until};
use super::drawn_text::{self, DrawnText};
use super::frame::{Window, click, has, open_sized, opening};
use crate::app::App;
use crate::settings::{SettingsStore, WindowSettings};
use crate::style::{Style, Units, contrast};
use crate::window::scope::Scope;
use crate::window::scope::fixture;

/// The least contrast of text, by WCAG 2.
const LEAST_CONTRAST: f32 = 4.5;

/// Opens the windows on a robot in a theme.
fn open_in(robot: &Robot, theme: ThemePreference, size: Vec2) -> (Window, tempfile::TempDir) {
    let folder = tempfile::tempdir().expect("the folder is created");
    let settings = WindowSettings {
        theme,
        ..WindowSettings::default()
    };
    SettingsStore::at(Some(folder.path().to_owned())).keep("settings", &settings);
    let opening = opening(robot.reach(), Some("safe-navigation"));
    let mut window = open_sized(opening, Some(folder.path()), size);
    until(&mut window, |window| has(window, "Oscilloscope"));
    (window, folder)
}

fn texts<State>(harness: &Harness<'_, State>) -> Vec<DrawnText> {
    let panel = harness.ctx.global_style().visuals.panel_fill;
    drawn_text::of(&harness.output().shapes, panel)
}

/// Fails with all texts that cannot be read. What cannot be operated now is excepted.
fn check<State>(harness: &Harness<'_, State>, place: &str) {
    let disabled = harness.query_all(By::new().predicate(|node| node.is_disabled()));
    let disabled: Vec<Rect> = disabled.map(|node| node.rect()).collect();
    let weak: Vec<_> = texts(harness)
        .into_iter()
        .filter(|text| contrast(text.color, text.ground) < LEAST_CONTRAST)
        .filter(|text| !disabled.iter().any(|rect| rect.contains(text.rect.center())))
        .map(|text| {
            let found = contrast(text.color, text.ground);
            format!(
                "{:?}: {found:.2}, {:?} on {:?}",
                text.text, text.color, text.ground
            )
        })
        .collect();
    assert!(weak.is_empty(), "{place}:\n{}", weak.join("\n"));
}

#[test]
fn a_text_without_contrast_is_found_on_its_own_ground() {
    use eframe::egui::Color32;
    let (weak, plain) = (Color32::from_gray(115), Color32::from_gray(225));
    let mut harness = Harness::builder().with_theme(Theme::Dark).build_ui(move |ui| {
        ui.colored_label(weak, "weak");
        ui.colored_label(plain, "plain");
        ui.add(eframe::egui::Button::new(eframe::egui::RichText::new("lit").color(plain)).fill(plain));
    });
    harness.run_steps(2);
    let found: Vec<_> = texts(&harness)
        .into_iter()
        .filter(|text| contrast(text.color, text.ground) < LEAST_CONTRAST)
        .map(|text| text.text)
        .collect();
    assert_eq!(found, ["weak", "lit"]);
}

#[test]
fn every_text_of_the_windows_has_contrast_in_both_themes() {
    let robot = Robot::of("safe-navigation");
    for theme in [ThemePreference::Dark, ThemePreference::Light] {
        let (mut window, _folder) = open_in(&robot, theme, vec2(1280.0, 800.0));
        until(&mut window, |window| {
            texts(window).iter().any(|text| text.text == "live")
        });
        check(&window, &format!("{theme:?}, at first"));
        click(&mut window, "Variables");
        until(&mut window, |window| {
            texts(window).iter().any(|text| text.text.ends_with(" Hz"))
        });
        check(&window, &format!("{theme:?}, variables"));
        click(&mut window, "Keys");
        check(&window, &format!("{theme:?}, keys"));
        click(&mut window, "Applications");
        check(&window, &format!("{theme:?}, start page"));
    }
}

#[test]
fn every_text_of_the_oscilloscope_has_contrast_in_all_states() {
    for theme in [Theme::Dark, Theme::Light] {
        let (mut scope, fixed) = (Scope::open(&serde_json::Value::Null), fixture::navigation());
        let mut harness = Harness::builder()
            .with_size(vec2(1100.0, 600.0))
            .with_theme(theme)
            .build_ui(move |ui| {
                crate::style::install(ui.ctx());
                let style = Style::of(ui.ctx(), Units::default());
                drop(scope.show_fixed(ui, &fixed, &[], &style));
            });
        harness.run_steps(3);
        check(&harness, &format!("{theme:?}"));
        harness.get_by_label_contains("vff, ").click();
        harness.run_steps(2);
        check(&harness, &format!("{theme:?}, with a selected row"));
    }
}

#[test]
fn a_small_window_keeps_names_and_states_whole() {
    let robot = Robot::of("safe-navigation");
    let (mut window, _folder) = open_in(&robot, ThemePreference::Dark, vec2(1024.0, 700.0));
    let shows =
        |window: &Harness<'_, Option<App>>, word: &str| texts(window).iter().any(|text| text.text == word);
    until(&mut window, |window| shows(window, "running"));
    for name in [
        "teleop", "example", "stop", "vff", "goon", "pioneer", "WINNER", "CHECKING",
    ] {
        assert!(shows(&window, name), "{name} is cut");
    }
    assert!(shows(&window, "Stop everything") && shows(&window, "Applications"));
}

#[test]
fn acts_on_a_robot_have_words_and_large_targets_and_no_click_on_a_row_acts() {
    let fixed = fixture::navigation();
    let scope = Scope::open(&serde_json::Value::Null);
    let mut harness = Harness::builder().with_size(vec2(900.0, 520.0)).build_ui_state(
        |ui, (scope, fixed, requests): &mut (Scope, fixture::Fixed, usize)| {
            let style = Style::of(ui.ctx(), Units::default());
            *requests += scope.show_fixed(ui, fixed, &[], &style).len();
        },
        (scope, fixed, 0),
    );
    harness.run_steps(3);
    assert!(harness.query_by_label("Stop vff").is_none());
    harness.get_by_label_contains("vff, ").click();
    harness.run_steps(2);
    assert_eq!(harness.state().2, 0, "a click on a row selects it");
    for verb in ["Play", "Stop", "Force", "Release"] {
        let rect = harness.get_by_label(&format!("{verb} vff")).rect();
        assert!(rect.width() >= 32.0 && rect.height() >= 32.0, "{verb}: {rect}");
        // The row has the focus now, so the keys act, and are shown.
        let text = texts(&harness)
            .into_iter()
            .find(|text| rect.contains(text.rect.center()));
        let text = text.map_or_else(String::new, |text| text.text);
        assert!(text.starts_with(verb), "{text}");
        assert_eq!(text.ends_with(')'), verb != "Release", "{text}: no one holds vff");
    }
    harness.get_by_label("Filter").focus();
    harness.run_steps(2);
    let rect = harness.get_by_label("Stop vff").rect();
    let text = texts(&harness)
        .into_iter()
        .find(|text| rect.contains(text.rect.center()));
    assert_eq!(
        text.map(|text| text.text).as_deref(),
        Some("Stop"),
        "the keys act no more"
    );
}

#[test]
fn a_question_mark_lists_the_keys_and_hides_them_again() {
    let robot = Robot::of("safe-navigation");
    let (mut window, _folder) = open_in(&robot, ThemePreference::Dark, vec2(1024.0, 700.0));
    let question = eframe::egui::Event::Text("?".to_owned());
    assert!(!has(&window, "Ctrl+Space"));
    window.event(question.clone());
    until(&mut window, |window| has(window, "Ctrl+Space"));
    window.event(question);
    until(&mut window, |window| !has(window, "Ctrl+Space"));
}
