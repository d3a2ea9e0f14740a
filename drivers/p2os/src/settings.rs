//! Converts the modulations into a robot to look for. Every mistake in them is an error before a port is
//! opened.

use jde_device::inspect_port;
use jde_device::port::{Address, Backoff, Port};
use jde_p2os::{Beams, HeadKind, LaserMode, Model, Options, Pose};
use jde_schema::prelude::*;

use crate::Pioneer;
use crate::robot::RobotConnection;

impl Pioneer {
    /// The robot that the modulations describe. Opens no port.
    pub(crate) fn settings(&self, cx: &Context) -> Result<RobotConnection> {
        let address = self.address(cx)?;
        let beams = self.beams(cx);
        let start = self.start.get(cx);
        let options = Options {
            model: model(self.model.get(cx).as_str())?,
            laser: self.laser(cx)?,
            head: self.head(cx)?,
            start: Pose {
                x: start.x,
                y: start.y,
                heading: start.theta,
            },
        };
        Ok(RobotConnection::new(
            Port::new(address, Backoff::default()),
            options,
            beams,
        ))
    }

    fn address(&self, cx: &Context) -> Result<Address> {
        let port = self.port.get(cx);
        if port.is_empty() {
            return Err(
                "it has no port; give it one in the application: port = \"serial:/dev/ttyUSB0@9600\", or \
                 port = \"tcp:localhost:8101\" of a simulator"
                    .into(),
            );
        }
        Ok(Address::parse(port.as_str())?)
    }

    fn beams(&self, cx: &Context) -> Beams {
        Beams::spread(self.laser_beams.get(cx), self.laser_view.get(cx))
    }

    fn laser(&self, cx: &Context) -> Result<LaserMode> {
        match self.laser_mode.get(cx).as_str() {
            "auto" => Ok(LaserMode::Auto(self.beams(cx))),
            "on" => Ok(LaserMode::On(self.beams(cx))),
            "off" => Ok(LaserMode::Off),
            other => Err(format!("laser_mode = \"{other}\": it can be auto, on or off").into()),
        }
    }

    fn head(&self, cx: &Context) -> Result<HeadKind> {
        match self.head_kind.get(cx).as_str() {
            "none" => Ok(HeadKind::None),
            "vc-c4" => Ok(HeadKind::VcC4),
            "vc-c4-one-way" => Ok(HeadKind::VcC4OneWay),
            other => Err(format!("head_kind = \"{other}\": it can be none, vc-c4 or vc-c4-one-way").into()),
        }
    }
}

impl Inspect for Pioneer {
    fn inspect(&self, cx: &Context, problems: &mut Problems) {
        inspect_port(&self.port, self.address(cx), problems);
        problems.expect(&self.model, model(self.model.get(cx).as_str()));
        problems.expect(&self.laser_mode, self.laser(cx));
        problems.expect(&self.head_kind, self.head(cx));
    }
}

/// The largest file of a model, bytes.
const MAX_MODEL: u64 = 1 << 20;

/// Returns the model of a name or of a file; `None` for the model that the robot reports.
fn model(text: &str) -> Result<Option<Model>> {
    if text.is_empty() {
        return Ok(None);
    }
    if !text.ends_with(".toml") {
        return Ok(Some(Model::named(text)?));
    }
    let file = jde_files::read_text(text.as_ref(), MAX_MODEL)
        .map_err(|error| format!("model = \"{text}\": {error}"))?;
    Ok(Some(Model::parse(&file, text)?))
}
