//! A camera that comes and goes: opened on a thread of its own, because that can take seconds, read without blocking, met again
//! after every loss. All its transitions are here.

use core::time::Duration;
use std::sync::Arc;
use std::sync::mpsc::{self, Receiver, TryRecvError};
use std::thread;

use jde_port::Backoff;

use crate::format::Shape;
use crate::picture::Picture;

/// How long an open camera may send nothing: in the dark some take a second for a picture.
const SILENCE: Duration = Duration::from_secs(5);

/// What can be opened as a camera.
pub(crate) trait Source: Send + Sync + 'static {
    /// Opens it; the error is in words for whoever plugged it in, and names it.
    fn open(&self) -> Result<Box<dyn Stream>, String>;

    /// What it is called in messages.
    fn device(&self) -> &str;
}

/// A camera that sends pictures.
pub(crate) trait Stream: Send {
    /// What it calls itself.
    fn name(&self) -> &str;

    fn shape(&self) -> Shape;

    /// Replaces `into` by the newest picture as it came, if one came; never blocks. After an error it is gone.
    fn newest(&mut self, into: &mut Vec<u8>) -> Result<bool, String>;
}

/// How a camera is connected.
pub(crate) enum State {
    /// The next step opens it.
    Idle,
    Opening(Receiver<Result<Box<dyn Stream>, String>>),
    Open {
        stream: Box<dyn Stream>,
        /// When a picture last came.
        heard: Duration,
    },
    Lost {
        reason: String,
        again: Duration,
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

/// What came in a step.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum News {
    Picture(Picture),
    /// A picture that cannot be read, said once until one can.
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

    /// Attempts to open it since a picture last came.
    pub(crate) fn attempts(&self) -> u32 {
        self.attempts
    }

    /// Opens, reads, and opens again when it is time.
    pub(crate) fn step(&mut self, now: Duration) -> Option<News> {
        match &mut self.state {
            State::Idle => self.begin(now),
            State::Lost { again, .. } if now >= *again => self.begin(now),
            State::Lost { .. } => {}
            State::Opening(result) => match result.try_recv() {
                Ok(Ok(stream)) => self.state = State::Open { stream, heard: now },
                Ok(Err(reason)) => self.lose(reason, now),
                Err(TryRecvError::Empty) => {}
                Err(TryRecvError::Disconnected) => {
                    let reason = format!("{}: the attempt to open it failed", self.source.device());
                    self.lose(reason, now);
                }
            },
            State::Open { stream, heard } => match stream.newest(&mut self.bytes) {
                Ok(true) => {
                    *heard = now;
                    let shape = stream.shape();
                    return self.picture(shape);
                }
                Ok(false) if now.saturating_sub(*heard) >= SILENCE => {
                    let reason = format!(
                        "{}: no picture came for {} s",
                        self.source.device(),
                        SILENCE.as_secs()
                    );
                    self.lose(reason, now);
                }
                Ok(false) => {}
                Err(reason) => {
                    let reason = format!("{}: {reason}", self.source.device());
                    self.lose(reason, now);
                }
            },
        }
        None
    }

    fn picture(&mut self, shape: Shape) -> Option<News> {
        match shape.picture(&self.bytes) {
            Ok(picture) => {
                self.attempts = 0;
                self.warned = false;
                Some(News::Picture(picture))
            }
            Err(error) if !self.warned => {
                self.warned = true;
                Some(News::Warn(format!("a picture is left out: {error}")))
            }
            Err(_) => None,
        }
    }

    fn begin(&mut self, now: Duration) {
        self.attempts = self.attempts.saturating_add(1);
        let (sender, result) = mpsc::channel();
        let source = self.source.clone();
        let opening = thread::Builder::new().name("opening".to_owned()).spawn(move || {
            // Nobody may be waiting any more; the camera is closed then.
            let _ = sender.send(source.open());
        });
        match opening {
            Ok(_) => self.state = State::Opening(result),
            Err(error) => {
                let reason = format!("{}: no thread to open it with: {error}", self.source.device());
                self.lose(reason, now);
            }
        }
    }

    fn lose(&mut self, reason: String, now: Duration) {
        let again = now.saturating_add(self.backoff.after(self.attempts));
        self.state = State::Lost { reason, again };
    }
}

#[cfg(test)]
mod tests;
