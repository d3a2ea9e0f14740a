//! The checks that the targets run: those of the ordinary tests, and no others.

#[path = "../../crates/p2os/tests/it/checks.rs"]
mod checks;
#[path = "../../crates/panel/tests/common/checks.rs"]
mod panel;

/// Streams of bytes for the receiver of packets.
pub fn receiver(data: &[u8]) {
    checks::receiver(data);
}

/// Payloads for the reader of commands.
pub fn command(data: &[u8]) {
    checks::command(data);
}

/// Payloads for every reader of what robots say.
pub fn answer(data: &[u8]) {
    checks::answer(data);
}

/// Robots that say anything, for the client's session.
pub fn session(data: &[u8]) {
    checks::session(data);
}

/// Streams of bytes for the reader of the camera's frames.
pub fn head(data: &[u8]) {
    checks::head(data);
}

/// Bytes for the reader of panels.
pub fn list(data: &[u8]) {
    panel::list(data);
}

/// Bytes for the reader of what people do to panels.
pub fn gesture(data: &[u8]) {
    panel::gesture(data);
}
