//! The checks that the fuzz targets run. They are the checks of the ordinary tests, and no others.

#[path = "../../drivers/carmen/src/tests/checks.rs"]
mod carmen;
#[path = "../../crates/p2os/tests/it/checks.rs"]
mod checks;
#[path = "../../drivers/carmen/src/log/mod.rs"]
mod log;
#[path = "../../crates/link/tests/link/checks.rs"]
mod link;
#[path = "../../crates/log/tests/it/checks.rs"]
mod recordings;
#[path = "../../crates/panel/tests/it/checks.rs"]
mod panel;
#[path = "../../crates/player/tests/it/checks.rs"]
mod player;
#[path = "../../crates/sim/tests/it/checks.rs"]
mod sim;
#[path = "../../crates/vision/tests/it/checks.rs"]
mod vision;

/// Checks the reader of calibrations of cameras with a file.
pub fn calibration(data: &[u8]) {
    vision::calibration(data);
}

/// Checks the readers of the link's messages with arbitrary bytes.
pub fn link(data: &[u8]) {
    link::messages(data);
}

/// Checks the reader of recordings with the bytes of a file.
pub fn recording(data: &[u8]) {
    recordings::recording(data);
}

/// Checks the receiver of packets with a stream of bytes.
pub fn receiver(data: &[u8]) {
    checks::receiver(data);
}

/// Checks the reader of commands with a payload.
pub fn command(data: &[u8]) {
    checks::command(data);
}

/// Checks every reader of a robot's packets with a payload.
pub fn answer(data: &[u8]) {
    checks::answer(data);
}

/// Checks the client's session with a robot that sends arbitrary bytes.
pub fn session(data: &[u8]) {
    checks::session(data);
}

/// Checks the reader of the camera's frames with a stream of bytes.
pub fn head(data: &[u8]) {
    checks::head(data);
}

/// Checks the reader of panels with arbitrary bytes.
pub fn list(data: &[u8]) {
    panel::list(data);
}

/// Checks the reader of operators' gestures on panels with arbitrary bytes.
pub fn gesture(data: &[u8]) {
    panel::gesture(data);
}

/// Checks the receiver of Player's messages with a stream of bytes.
pub fn player_stream(data: &[u8]) {
    player::stream(data);
}

/// Checks the client's session with a Player server that sends arbitrary bytes.
pub fn player_session(data: &[u8]) {
    player::session(data);
}

/// Checks the reader of ROS maps with a YAML file and, after a byte 0, its image `m`.
pub fn map_file(data: &[u8]) {
    sim::map(data);
}

/// Checks the readers of worlds of other programs with a file and, after a byte 0, the image `m` beside it.
pub fn import(data: &[u8]) {
    sim::import(data);
}

/// Checks the reader of CARMEN's logs with arbitrary bytes.
pub fn carmen_log(data: &[u8]) {
    carmen::log(data);
}
