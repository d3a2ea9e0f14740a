//! Assigns topics to sensors. It decodes messages and publishes none.

use jde_log::Channel;
use jde_ros::{cdr, definition};
use jde_schema::Error;
use jde_schema::types::{Text, Value};

use crate::reader::{RecordingReader, TimedMessage};

/// Decodes a message into the bytes of a value.
type Decode = Box<dyn Fn(&[u8], &mut [u8]) -> Result<(), cdr::Error> + Send>;

/// The sensors of a robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Output {
    Laser,
    Sonars,
    Odometry,
    Bumpers,
    PanTilt,
    Battery,
    Encoders,
    LineSensor,
    Imu,
    PositionFix,
    Body,
    Connection,
    Image,
    Depth,
}

/// The topics that are played.
#[derive(Default)]
pub(crate) struct Outputs {
    channels: Vec<OutputChannel>,
}

struct OutputChannel {
    topic: String,
    output: Output,
    decode: Decode,
    /// A reused buffer.
    bytes: Vec<u8>,
}

impl Outputs {
    /// Plays a sensor from the topic of that name, or from the first free one of its type if the name is empty.
    /// Without a topic of the type the sensor has no value.
    ///
    /// # Errors
    /// If there is no topic of that name, or it is of another type.
    pub(crate) fn add<T: Value>(
        &mut self,
        reader: &RecordingReader,
        output: Output,
        topic: &Text<120>,
    ) -> jde_schema::Result {
        let topic = topic.as_str();
        let value_type = T::describe();
        let name = definition::name(&value_type);
        let problem = |channel: &Channel| match jde_log::value_type(channel) {
            _ if channel.type_name != name => Some(format!("is a {}", channel.type_name)),
            Err(reason) => Some(format!("cannot be played: {reason}")),
            Ok(recorded) if !definition::has_fields(&definition::definition(&recorded), &value_type) => {
                Some(format!("is a {name} with other fields"))
            }
            Ok(_) => None,
        };
        let found = if topic.is_empty() {
            let mut channels = reader.channels().filter(|channel| problem(channel).is_none());
            channels.find(|channel| !self.has(&channel.topic))
        } else {
            let named = reader.channels().find(|channel| channel.topic == topic);
            let named = named.ok_or_else(|| {
                Error::from(format!(
                    "{} has no topic `{topic}`; it has {}",
                    reader.path(),
                    reader.topics()
                ))
            })?;
            if let Some(problem) = problem(named) {
                return Err(format!("`{topic}` of {} {problem}; expected a {name}", reader.path()).into());
            }
            Some(named)
        };
        self.channels.extend(found.map(|channel| OutputChannel {
            topic: channel.topic.clone(),
            output,
            bytes: vec![0; value_type.bytes],
            decode: Box::new(move |message, bytes| cdr::decode_into(&value_type, message, bytes)),
        }));
        Ok(())
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.channels.is_empty()
    }

    pub(crate) fn has(&self, topic: &str) -> bool {
        self.channels.iter().any(|channel| channel.topic == topic)
    }

    /// Lists the topics.
    pub(crate) fn names(&self) -> String {
        let names: Vec<_> = self.channels.iter().map(|channel| &*channel.topic).collect();
        names.join(", ")
    }

    /// Decodes a message of one of the topics; `None` for other topics.
    ///
    /// # Errors
    /// It does not match its type.
    pub(crate) fn read(&mut self, message: &TimedMessage) -> Option<Result<(Output, &[u8]), cdr::Error>> {
        let mut channels = self.channels.iter_mut();
        let channel = channels.find(|channel| channel.topic == message.topic())?;
        let decoded = (channel.decode)(&message.message.data, &mut channel.bytes);
        Some(decoded.map(|()| (channel.output, &*channel.bytes)))
    }
}
