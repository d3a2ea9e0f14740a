//! The frame around the windows: the start page, tiles, what stays from one start to the next.

use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;

use super::common::{Robot, until};
use crate::Opening;
use crate::app::App;
use crate::settings::Drawer;

#[test]
fn an_application_that_is_named_is_opened() {
    let robot = Robot::of("safe-navigation");
    let opening = Opening {
        reach: robot.reach(),
        application: Some("safe-navigation".to_owned()),
        recording: None,
        player: Vec::new(),
        recordings: Vec::new(),
    };
    let mut harness = Harness::builder().with_size([1200.0, 800.0]).build_ui_state(
        |ui, app: &mut Option<App>| {
            app.get_or_insert_with(|| App::new(ui.ctx(), opening.clone(), Drawer::at(None)))
                .frame(ui);
        },
        None,
    );
    until(&mut harness, |harness| {
        harness.query_by_label("Oscilloscope").is_some()
    });
}
