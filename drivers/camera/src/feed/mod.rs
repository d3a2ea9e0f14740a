//! A camera that can appear and disappear. It is opened on a thread of its own, because that can take
//! seconds, read without blocking, and reopened after every loss. All its transitions are here.

use core::time::Duration;
use std::sync::Arc;
use std::sync::mpsc::{self, Receiver, TryRecvError};
use std::thread;

use jde_device::port::Backoff;
use jde_picture::Picture;

use crate::format::Shape;

/// Time without a picture after which an open camera counts as lost. In the dark some need a second for a
/// picture.
const SILENCE: Duration = Duration::from_secs(5);

/// A device that can be opened as a camera.
pub(crate) trait Source: Send + Sync + 'static {
    /// Opens the camera. The error is a message for the operator, and names the camera.
    fn open(&self) -> Result<Box<dyn Stream>, String>;

    /// The device's name in messages.
    fn device(&self) -> &str;
}

/// An open camera.
pub(crate) trait Stream: Send {
    /// The camera's own name.
    fn name(&self) -> &str;

    fn shape(&self) -> Shape;

    /// Replaces `into` by the newest picture, not decoded, and returns whether a picture arrived. Never blocks.
    /// After an error the camera is lost.
    fn newest(&mut self, into: &mut Vec<u8>) -> Result<bool, String>;
}

/// The state of the connection.
pub(crate) enum State {
    /// The next step opens the camera.
    Idle,
    Opening(Receiver<Result<Box<dyn Stream>, String>>),
    Open {
        stream: Box<dyn Stream>,
        /// Time of the last picture, or of opening.
        last_frame: Duration,
    },
    Lost {
        reason: String,
        retry_at: Duration,
    },
}

/// The pictures of a camera.
pub(crate) struct Feed {
    source: Arc<dyn Source>,
    backoff: Backoff,
    state: State,
    attempts: u32,
    bytes: Vec<u8>,
    warned: bool,
}

/// The result of a step.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum FeedEvent {
    Picture(Picture),
    /// A picture cannot be decoded. Reported once until one can.
    Warn(String),
}

impl Feed {
    pub(crate) fn new(source: impl Source, backoff: Backoff) -> Self {
        Self {
            source: Arc::new(source),
            backoff,
            state: State::Idle,
            attempts: 0,
            bytes: Vec::new(),
            warned: false,
        }
    }

    pub(crate) fn state(&self) -> &State {
        &self.state
    }

    /// Attempts to open the camera since the last picture.
    pub(crate) fn attempts(&self) -> u32 {
        self.attempts
    }

    /// Opens the camera, reads it, and reopens it when the waiting time is over.
    pub(crate) fn step(&mut self, now: Duration) -> Option<FeedEvent> {
        match &mut self.state {
            State::Idle => self.start_open(now),
            State::Lost { retry_at, .. } if now >= *retry_at => self.start_open(now),
            State::Lost { .. } => {}
            State::Opening(result) => match result.try_recv() {
                Ok(Ok(stream)) => {
                    self.state = State::Open {
                        stream,
                        last_frame: now,
                    }
                }
                Ok(Err(reason)) => self.set_lost(reason, now),
                Err(TryRecvError::Empty) => {}
                Err(TryRecvError::Disconnected) => {
                    let reason = format!("{}: the attempt to open it failed", self.source.device());
                    self.set_lost(reason, now);
                }
            },
            State::Open { stream, last_frame } => match stream.newest(&mut self.bytes) {
                Ok(true) => {
                    *last_frame = now;
                    let shape = stream.shape();
                    return self.picture(shape);
                }
                Ok(false) if now.saturating_sub(*last_frame) >= SILENCE => {
                    let reason = format!(
                        "{}: no picture arrived for {} s",
                        self.source.device(),
                        SILENCE.as_secs()
                    );
                    self.set_lost(reason, now);
                }
                Ok(false) => {}
                Err(reason) => {
                    let reason = format!("{}: {reason}", self.source.device());
                    self.set_lost(reason, now);
                }
            },
        }
        None
    }

    fn picture(&mut self, shape: Shape) -> Option<FeedEvent> {
        match shape.picture(&self.bytes) {
            Ok(picture) => {
                self.attempts = 0;
                self.warned = false;
                Some(FeedEvent::Picture(picture))
            }
            Err(error) if !self.warned => {
                self.warned = true;
                Some(FeedEvent::Warn(format!("a picture is left out: {error}")))
            }
            Err(_) => None,
        }
    }

    fn start_open(&mut self, now: Duration) {
        self.attempts = self.attempts.saturating_add(1);
        let (sender, result) = mpsc::channel();
        let source = self.source.clone();
        let opening = thread::Builder::new().name("opening".to_owned()).spawn(move || {
            // If the receiver was dropped, sending fails and the camera is closed.
            let _ = sender.send(source.open());
        });
        match opening {
            Ok(_) => self.state = State::Opening(result),
            Err(error) => {
                let reason = format!("{}: no thread to open it with: {error}", self.source.device());
                self.set_lost(reason, now);
            }
        }
    }

    fn set_lost(&mut self, reason: String, now: Duration) {
        let retry_at = now.saturating_add(self.backoff.delay_after(self.attempts));
        self.state = State::Lost { reason, retry_at };
    }
}

#[cfg(test)]
mod tests;
