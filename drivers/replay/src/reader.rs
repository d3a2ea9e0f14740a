//! A recording in the player: its next message, and the values in force at a position. It knows no sensor
//! types.

use core::time::Duration;
use std::collections::BTreeMap;
use std::path::Path;

use jde_log::{Channel, Message, Messages, ReadError, Recording};

/// How far before a position the last values are searched.
const LOOK_BACK: Duration = Duration::from_secs(5);

/// A recording that is being played.
pub(crate) struct RecordingReader {
    path: String,
    recording: Recording,
    start: u64,
    length: Duration,
    messages: Messages,
    /// The message that was read but is not due yet.
    next: Option<TimedMessage>,
}

/// A message, with its position in the recording.
pub(crate) struct TimedMessage {
    pub(crate) at: Duration,
    /// Time from its measurement to its publication.
    pub(crate) age: Duration,
    pub(crate) message: Message,
}

/// The reason why a recording cannot be played.
#[derive(Debug, thiserror::Error)]
pub(crate) enum OpenError {
    #[error(transparent)]
    Read(#[from] ReadError),
    #[error("{0} has no messages")]
    Empty(String),
}

impl RecordingReader {
    pub(crate) fn open(path: &str) -> Result<Self, OpenError> {
        let recording = Recording::open(Path::new(path))?;
        let Some((start, end)) = recording.times() else {
            return Err(OpenError::Empty(path.to_owned()));
        };
        Ok(Self {
            path: path.to_owned(),
            messages: recording.messages()?,
            recording,
            start,
            length: Duration::from_nanos(end.saturating_sub(start)),
            next: None,
        })
    }

    pub(crate) fn path(&self) -> &str {
        &self.path
    }

    pub(crate) fn length(&self) -> Duration {
        self.length
    }

    /// Describes where the recording is damaged.
    pub(crate) fn damage(&self) -> Option<String> {
        let damage = self.recording.damage()?;
        Some(format!(
            "{} is damaged behind byte {}: {}",
            self.path, damage.offset, damage.reason
        ))
    }

    pub(crate) fn channels(&self) -> impl Iterator<Item = &Channel> {
        self.recording.channels()
    }

    /// Lists its topics.
    pub(crate) fn topics(&self) -> String {
        let topics: Vec<_> = self.channels().map(|channel| &*channel.topic).collect();
        if topics.is_empty() {
            "none at all".to_owned()
        } else {
            topics.join(", ")
        }
    }

    /// Returns the next message of the wanted topics, if it is due. With a count of messages `left` it is
    /// due while the count is positive; otherwise it is due if it was published up to `until`.
    pub(crate) fn next(
        &mut self,
        until: Duration,
        left: Option<u32>,
        wanted: impl Fn(&str) -> bool,
    ) -> Result<Option<TimedMessage>, OpenError> {
        if left == Some(0) {
            return Ok(None);
        }
        if self.next.is_none() {
            self.next = self.read(wanted)?;
        }
        Ok(self.next.take_if(|next| left.is_some() || next.at <= until))
    }

    /// Continues from a position. Returns the last message of each wanted topic before it.
    pub(crate) fn seek(
        &mut self,
        place: Duration,
        wanted: impl Fn(&str) -> bool,
    ) -> Result<Vec<TimedMessage>, OpenError> {
        let from = u64::try_from(place.saturating_sub(LOOK_BACK).as_nanos()).unwrap_or(0);
        let from = self.start.saturating_add(from);
        self.messages = self.recording.messages_from(from)?;
        let mut last = BTreeMap::new();
        self.next = loop {
            match self.read(&wanted)? {
                Some(due) if due.at < place => last.insert(due.topic().to_owned(), due),
                next => break next,
            };
        };
        Ok(last.into_values().collect())
    }

    fn read(&mut self, wanted: impl Fn(&str) -> bool) -> Result<Option<TimedMessage>, OpenError> {
        for message in self.messages.by_ref() {
            let message = match message {
                Ok(message) => message,
                // Reported when the recording was opened, or the file became shorter since. The recording
                // ends here.
                Err(ReadError::Damaged { .. }) => return Ok(None),
                Err(error) => return Err(error.into()),
            };
            if wanted(&message.channel.topic) {
                return Ok(Some(TimedMessage {
                    at: Duration::from_nanos(message.log_time.saturating_sub(self.start)),
                    age: Duration::from_nanos(message.log_time.saturating_sub(message.publish_time)),
                    message,
                }));
            }
        }
        Ok(None)
    }
}

impl TimedMessage {
    pub(crate) fn topic(&self) -> &str {
        &self.message.channel.topic
    }
}
