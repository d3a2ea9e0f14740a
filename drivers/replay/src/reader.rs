//! A recording in the player: its next message, and the values in force at a position. It knows no sensor
//! types.

use core::time::Duration;
use std::collections::BTreeMap;
use std::path::Path;

use jde_log::{
    Channel, LeftOut, Messages, ReadError, RecordedMessage, RecordedVariable, RecordedVariables, Recording,
};
use jde_schema::types::Time;

/// The time before a position in which the last values are searched.
const SEARCH_TIME: Duration = Duration::from_secs(5);

/// A header with an older time is not by the wall clock.
const MAX_AGE: Duration = Duration::from_secs(10);

/// A recording that is being played.
pub(crate) struct RecordingReader {
    path: String,
    recording: Recording,
    variables: RecordedVariables,
    start: u64,
    length: Duration,
    messages: Messages,
    /// The message that was read but is not due yet.
    next: Option<TimedMessage>,
}

/// A message, with its position in the recording.
pub(crate) struct TimedMessage {
    pub(crate) at: Duration,
    pub(crate) message: RecordedMessage,
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
            variables: RecordedVariables::of(&recording),
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

    /// Says where the recording ends too soon, and of which times within it nothing can be read.
    pub(crate) fn damage(&self) -> impl Iterator<Item = String> {
        let end = self.recording.damage().map(|damage| {
            format!(
                "{}: {}; only the part before is played",
                self.path,
                damage.sentence()
            )
        });
        let gaps = self.recording.gaps().iter().filter(|gap| gap.damaged);
        end.into_iter()
            .chain(gaps.map(move |gap| format!("{}: {gap}", self.path)))
    }

    /// Returns the variable of a channel, if its values can be read.
    pub(crate) fn variable(&self, channel: &Channel) -> Option<&RecordedVariable> {
        self.variables.get(channel)
    }

    /// Returns the files and topics that cannot be read.
    pub(crate) fn left_out(&self) -> &LeftOut {
        self.variables.left_out()
    }

    pub(crate) fn channels(&self) -> impl Iterator<Item = &Channel> {
        self.recording.channels()
    }

    /// Lists its topics, the first ones if there are many.
    pub(crate) fn topics(&self) -> String {
        const MAX_LISTED: usize = 20;
        let topics: Vec<_> = self.channels().map(|channel| &*channel.topic).collect();
        match topics.len() {
            0 => "none at all".to_owned(),
            1..=MAX_LISTED => topics.join(", "),
            count => format!(
                "{} and {} others",
                topics[..MAX_LISTED].join(", "),
                count - MAX_LISTED
            ),
        }
    }

    /// Returns the next message of the selected topics, if it is due. With a count `remaining` it is due while
    /// the count is positive; otherwise it is due if it was published up to `until`.
    pub(crate) fn next(
        &mut self,
        until: Duration,
        remaining: Option<u32>,
        selected: impl Fn(&str) -> bool,
    ) -> Result<Option<TimedMessage>, OpenError> {
        if remaining == Some(0) {
            return Ok(None);
        }
        if self.next.is_none() {
            self.next = self.read(selected)?;
        }
        Ok(self.next.take_if(|next| remaining.is_some() || next.at <= until))
    }

    /// Continues from a position. Returns the last message of each selected topic before it.
    pub(crate) fn seek(
        &mut self,
        position: Duration,
        selected: impl Fn(&str) -> bool,
    ) -> Result<Vec<TimedMessage>, OpenError> {
        let from = u64::try_from(position.saturating_sub(SEARCH_TIME).as_nanos()).unwrap_or(0);
        let from = self.start.saturating_add(from);
        self.messages = self.recording.messages_from(from)?;
        let mut last = BTreeMap::new();
        self.next = loop {
            match self.read(&selected)? {
                Some(due) if due.at < position => last.insert(due.topic().to_owned(), due),
                next => break next,
            };
        };
        Ok(last.into_values().collect())
    }

    fn read(&mut self, selected: impl Fn(&str) -> bool) -> Result<Option<TimedMessage>, OpenError> {
        for message in self.messages.by_ref() {
            let message = match message {
                Ok(message) => message,
                // The damage was reported at the opening, or the file has become shorter since. The recording
                // ends at this message.
                Err(ReadError::Damaged { .. }) => return Ok(None),
                Err(error) => return Err(error.into()),
            };
            if self.variables.get(&message.channel).is_some() && selected(&message.channel.topic) {
                return Ok(Some(TimedMessage {
                    at: Duration::from_nanos(message.log_time.saturating_sub(self.start)),
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

    /// Returns the time from its measurement to its publication. Bags of ROS 2 state the measurement in the header
    /// of the value, by the wall clock; others state it in the message.
    pub(crate) fn age(&self, stamp: Time) -> Duration {
        let published = Duration::from_nanos(self.message.log_time);
        published
            .checked_sub(stamp.into())
            .filter(|age| *age <= MAX_AGE)
            .unwrap_or_else(|| published.saturating_sub(Duration::from_nanos(self.message.publish_time)))
    }
}
