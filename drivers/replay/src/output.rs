//! Assigns topics to sensors. It decodes messages and publishes none.

use jde_log::{Channel, DecodeError, LeftOut, RecordedVariable};
use jde_ros::definition;
use jde_schema::Error;
use jde_schema::types::{Text, Value};

use crate::reader::{RecordingReader, TimedMessage};

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
    /// What of messages was not read, in lines, the first of each topic.
    left_out: Vec<String>,
}

struct OutputChannel {
    variable: RecordedVariable,
    output: Output,
    /// Whether something of its messages was not read, and whether a whole one was not.
    is_cut: bool,
    is_spoilt: bool,
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
            Ok(_) if reader.variable(channel).is_none() => Some(
                "cannot be played: the topic also has messages of another type, which are read".to_owned(),
            ),
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
        let variable = found.and_then(|channel| reader.variable(channel));
        self.channels.extend(variable.map(|variable| OutputChannel {
            output,
            is_cut: false,
            is_spoilt: false,
            bytes: vec![0; value_type.bytes],
            variable: variable.with_type(value_type),
        }));
        Ok(())
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.channels.is_empty()
    }

    pub(crate) fn has(&self, topic: &str) -> bool {
        self.channels
            .iter()
            .any(|channel| channel.variable.topic == topic)
    }

    /// Returns what of messages was not read since the last call, in lines, once for each topic.
    pub(crate) fn take_left_out(&mut self) -> Vec<String> {
        std::mem::take(&mut self.left_out)
    }

    /// Lists the topics.
    pub(crate) fn names(&self) -> String {
        let names: Vec<_> = self
            .channels
            .iter()
            .map(|channel| &*channel.variable.topic)
            .collect();
        names.join(", ")
    }

    /// Decodes a message of one of the topics; `None` for other topics.
    ///
    /// # Errors
    /// It does not match its type.
    pub(crate) fn read(&mut self, message: &TimedMessage) -> Option<Result<(Output, &[u8]), DecodeError>> {
        let mut channels = self.channels.iter_mut();
        let channel = channels.find(|channel| channel.variable.topic == message.topic())?;
        let data = &message.message.data;
        let mut left_out = LeftOut::default();
        let decoded = channel
            .variable
            .decode_into(data, &mut channel.bytes, &mut left_out);
        if !left_out.is_empty() && !std::mem::replace(&mut channel.is_cut, true) {
            self.left_out.extend(left_out.lines());
        }
        if let Err(error) = &decoded
            && !std::mem::replace(&mut channel.is_spoilt, true)
        {
            self.left_out
                .push(format!("a message of {} is left out: {error}", message.topic()));
        }
        Some(decoded.map(|()| (channel.output, &*channel.bytes)))
    }
}
