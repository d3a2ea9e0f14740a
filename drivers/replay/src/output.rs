//! Assigns topics to sensors. It decodes messages and publishes none.

use jde_log::Channel;
use jde_ros::{cdr, definition};
use jde_schema::types::{Text, Value};
use jde_schema::{Error, Result};

use crate::reader::{RecordingReader, TimedMessage};

/// Decodes a message into the bytes of a value; returns false if it does not match the type.
type Decode = Box<dyn Fn(&[u8], &mut [u8]) -> bool + Send>;

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

/// The topics that are channel.
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
    ) -> Result {
        let topic = topic.as_str();
        let value_type = T::describe();
        let name = definition::name(&value_type);
        let is_suitable = |channel: &&Channel| channel.type_name == name && channel.encoding == "cdr";
        let found = if topic.is_empty() {
            let mut channels = reader.channels().filter(is_suitable);
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
            if !is_suitable(&named) {
                return Err(format!(
                    "`{topic}` of {} is a {} in {}, expected a {name} in cdr",
                    reader.path(),
                    named.type_name,
                    named.encoding
                )
                .into());
            }
            Some(named)
        };
        self.channels.extend(found.map(|channel| OutputChannel {
            topic: channel.topic.clone(),
            output,
            bytes: vec![0; value_type.bytes],
            decode: Box::new(move |message, bytes| cdr::decode_into(&value_type, message, bytes).is_ok()),
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

    /// Decodes a message; `None` if it does not match its type.
    pub(crate) fn read(&mut self, message: &TimedMessage) -> Option<(Output, &[u8])> {
        let channel = self
            .channels
            .iter_mut()
            .find(|channel| channel.topic == message.topic())?;
        let matches = (channel.decode)(&message.message.data, &mut channel.bytes);
        matches.then_some((channel.output, &*channel.bytes))
    }
}
