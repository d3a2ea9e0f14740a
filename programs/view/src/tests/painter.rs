//! A schema with modulations and a panel, which runs in its own application.

use std::path::Path;

use jde_loader::{Plugins, SearchPath};
use jde_panel::Touch;
use jde_schema::prelude::*;

use super::common::Robot;

/// Counts, and shows the target that was clicked.
#[derive(Describe)]
#[schema(motor, period = "10ms")]
struct Painter {
    /// The speed.
    #[modulation(default = 0.5, unit = "m/s", min = 0.0, max = 2.0)]
    speed: Modulation<f64>,
    /// The angle.
    #[modulation(default = 0.0, unit = "rad")]
    turn: Modulation<f64>,
    /// The number of iterations.
    #[export]
    count: Export<u64>,
    /// The velocity from both modulations.
    #[export]
    velocity: Export<Twist>,
    counted: u64,
    target: Option<[f64; 3]>,
}

impl Schema for Painter {
    fn iterate(&mut self, cx: &Context) -> Result {
        self.counted += 1;
        self.count.write(cx, self.counted);
        self.velocity
            .write(cx, Twist::planar(self.speed.get(cx), self.turn.get(cx)));
        Ok(())
    }
}

impl Panel for Painter {
    fn draw(&self, _: &Context, pen: &mut Pen) {
        pen.text(match self.target {
            Some([x, y, _]) => format!("target {x:.0}, {y:.0}"),
            None => "no target".to_owned(),
        });
        pen.canvas("field").wants_clicks().show(|plane| {
            plane.disc([0.0, 0.0], 0.3);
        });
    }

    fn touched(&mut self, _: &Context, gesture: &Gesture) -> Result {
        if let Touch::Clicked { at, .. } = gesture.touch {
            self.target = Some(at);
        }
        Ok(())
    }
}

static PAINTERS: jde_abi::raw::Plugin = jde_schema::plugin!("painters", "Panels of a test.", [Painter]);

const TEXT: &str = "name = \"painters\"\nroots = [\"goon\"]\n[schemas.goon]\ntype = \"painters/painter\"\n";

/// Starts an application with one painter, `goon`.
pub(crate) fn robot() -> Robot {
    Robot::linked(TEXT, plugins())
}

/// Starts the same application from a new file in a folder.
pub(crate) fn robot_in(folder: &Path) -> Robot {
    let file = folder.join("painters.toml");
    std::fs::write(&file, TEXT).expect("the file is written");
    Robot::linked_at(&file, TEXT, plugins())
}

/// Starts the same application; windows see it as a recording that plays.
pub(crate) fn recorded() -> Robot {
    Robot::recorded(TEXT, plugins())
}

fn plugins() -> Plugins {
    let mut plugins = Plugins::new(SearchPath::default());
    plugins.link(&PAINTERS).expect("the plugin links");
    plugins
}
