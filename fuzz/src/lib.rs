//! The checks that the targets run: those of the ordinary tests, and no others.

#[path = "../../crates/p2os/tests/common/checks.rs"]
mod checks;

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
