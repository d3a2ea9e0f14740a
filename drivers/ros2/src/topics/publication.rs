//! A topic that the application file publishes: new values of a variable, while somebody subscribes.

use jde_picture::Compression;
use jde_ros_node::Topic;
use jde_schema::ListedImport;
use jde_schema::describe::Type;
use jde_schema::prelude::*;
use jde_schema::types::CameraInfo;

use super::quality::quality;
use super::settings::Publication;
use crate::camera_info;
use crate::compressed::{self, Compressor};
use crate::connection::RosConnection;
use crate::described::DescribedCodec;
use crate::messages::{Codec, PoseWithCovarianceStamped, measured, typed};
use crate::tf::range_messages;
use crate::velocity::{self, VelocityPublisher};

/// The time between two messages of a ring. A subscription of ROS 2's profile for sensors keeps five, so its node may be busy
/// for four times as long.
const SONAR_GAP: Duration = Duration::from_millis(2);

/// A topic, and what of its variable was sent.
pub(super) struct TopicPublication {
    /// Its number among the publications of the node.
    number: usize,
    form: MessageForm,
    /// Whether a value is sent without a subscriber too, for those that begin later.
    is_latched: bool,
    /// Whether a value is encoded only once the message before was taken: one that would be replaced costs much.
    is_large: bool,
    period: Duration,
    sent: u64,
    sent_at: Option<Duration>,
}

/// How a value becomes messages.
enum MessageForm {
    /// As it is.
    Described(DescribedCodec),
    /// A picture, and the geometry of its camera with this field of view, as the next publication.
    Picture(DescribedCodec, Codec<CameraInfo>, f64),
    /// A picture, compressed.
    Compressed(Compressor),
    /// A ring of sonars, one message for each.
    Ranges(Codec<Range>),
    /// A measured position, as a pose.
    Position(Codec<PoseWithCovarianceStamped>),
    /// A velocity, plain and stamped.
    Velocity(VelocityPublisher),
}

/// Checks the settings of an entry.
pub(super) fn check(namespace: &str, import: &ListedImport<Publication>) -> Result<(), String> {
    topic_name(namespace, import.label())?;
    let (settings, value_type) = (import.settings(), import.value_type());
    quality(settings.quality(), value_type)?;
    let is_image = is_of::<Image>(value_type);
    if settings.mount != Pose2D::ORIGIN && !is_image && !is_of::<LaserScan>(value_type) {
        return Err("`mount` belongs to laser scans and pictures, and this is neither".to_owned());
    }
    let of_cameras = [settings.height, settings.tilt, settings.field_of_view];
    if of_cameras != [0.0; 3] && !is_image {
        return Err("`height`, `tilt` and `field_of_view` belong to pictures, and this is none".to_owned());
    }
    if of_cameras.iter().any(|number| !number.is_finite()) || !(0.0..3.1).contains(&settings.field_of_view) {
        return Err(
            "`field_of_view` is an angle from 0 to 3.1 rad, and `height` and `tilt` are finite".to_owned(),
        );
    }
    if compression(settings)?.is_some() {
        if !is_image {
            return Err("`compressed` belongs to pictures, and this is none".to_owned());
        }
        if settings.field_of_view != 0.0 {
            return Err(
                "state `field_of_view` where the same pictures are published without `compressed`".to_owned(),
            );
        }
    }
    if !settings.child.is_empty() && !is_of::<PoseStamped>(value_type) {
        return Err("`child` belongs to poses with a frame, and this is none".to_owned());
    }
    if !settings.period.is_finite() || !(0.0..=3600.0).contains(&settings.period) {
        return Err(format!("`period` is {}; expected 0 s to 3600 s", settings.period));
    }
    let is_ring = is_of::<RangeRing>(value_type);
    if !settings.frame.is_empty() && !is_ring && !DescribedCodec::new(value_type).has_header() {
        return Err("`frame` belongs to messages with a header, and this type has none".to_owned());
    }
    if !settings.transform.get() && !is_of::<Odometry>(value_type) {
        return Err("`transform` belongs to an odometry, and this is none".to_owned());
    }
    Ok(())
}

/// How the pictures of an entry are compressed, if they are.
fn compression(settings: &Publication) -> Result<Option<Compression>, String> {
    let name = settings.compressed.as_str();
    let found = Compression::named(name);
    if found.is_none() && !name.is_empty() {
        return Err(format!(
            "`compressed` is \"{name}\"; expected \"jpeg\" or \"png\""
        ));
    }
    Ok(found)
}

/// The full names of an entry's topics.
pub(super) fn topic_names(namespace: &str, import: &ListedImport<Publication>) -> Vec<String> {
    let name = topic_name(namespace, import.label()).ok();
    let is_camera = import.settings().field_of_view > 0.0;
    let info = name.as_deref().filter(|_| is_camera).map(camera_info::topic);
    name.into_iter().chain(info).collect()
}

/// The full name of an entry's topic.
pub(super) fn topic_name(namespace: &str, label: &str) -> Result<String, String> {
    jde_ros_node::names::topic(namespace, label)?.ok_or_else(|| "a topic has a name".to_owned())
}

/// Whether a type is that one, of the same layout.
pub(super) fn is_of<T: Value>(value_type: &Type) -> bool {
    value_type.same_as(&T::describe())
}

impl TopicPublication {
    /// Adds the topics of an entry to those of the node.
    pub(super) fn new(
        namespace: &str,
        import: &ListedImport<Publication>,
        topics: &mut Vec<Topic>,
    ) -> Result<Self, String> {
        check(namespace, import).map_err(|error| format!("`{}` in `publish`: {error}", import.label()))?;
        let (number, value_type) = (topics.len(), import.value_type());
        let (name, settings) = (topic_name(namespace, import.label())?, import.settings());
        let quality = quality(settings.quality(), value_type)?;
        let form = if is_of::<RangeRing>(value_type) {
            let codec = Codec::new();
            topics.push(Topic {
                gap: SONAR_GAP,
                ..codec.topic(name, quality)
            });
            MessageForm::Ranges(codec)
        } else if is_of::<PositionFix>(value_type) {
            let codec = Codec::new();
            topics.push(codec.topic(name, quality));
            MessageForm::Position(codec)
        } else if is_of::<Twist>(value_type) {
            topics.extend(velocity::topics(&name, quality));
            MessageForm::Velocity(VelocityPublisher::new(number))
        } else if let Some(compression) = compression(settings)? {
            topics.push(compressed::topic(name, quality));
            let compressor = Compressor::start(compression);
            MessageForm::Compressed(
                compressor.map_err(|error| format!("no thread for compression could be created: {error}"))?,
            )
        } else {
            let codec = DescribedCodec::new(value_type);
            topics.push(codec.topic(name.clone(), quality));
            if settings.field_of_view > 0.0 {
                let info = Codec::new();
                topics.push(info.topic(camera_info::topic(&name), quality));
                MessageForm::Picture(codec, info, settings.field_of_view)
            } else {
                MessageForm::Described(codec)
            }
        };
        Ok(Self {
            number,
            form,
            is_latched: quality.latched,
            is_large: topics[number].is_large,
            period: Duration::from_secs_f64(settings.period),
            sent: 0,
            sent_at: None,
        })
    }

    /// Submits the messages of a new value.
    pub(super) fn publish(
        &mut self,
        cx: &Context,
        connection: &mut RosConnection,
        import: &ListedImport<Publication>,
    ) {
        if let MessageForm::Compressed(compressor) = &mut self.form {
            match compressor.message() {
                Some(Ok(message)) => connection.node.publish(self.number, vec![message]),
                Some(Err(error)) => {
                    connection.warn_once(cx, format!("`{}` in `publish`: {error}", import.label()))
                }
                None if compressor.is_busy() => return,
                None => {}
            }
        }
        let connection = &*connection;
        let (node, clock) = (&connection.node, &connection.clock);
        // A ring is complete before the next one begins.
        if matches!(self.form, MessageForm::Ranges(_)) && !node.has_sent(self.number) {
            return;
        }
        let Some(value) = import.get(cx) else { return };
        if !self.is_due(cx.now(), value.sequence()) || !self.is_wanted(connection) {
            return;
        }
        if self.is_large && node.is_waiting(self.number) {
            return;
        }
        (self.sent, self.sent_at) = (value.sequence(), Some(cx.now()));
        let frame = import.settings().frame;
        match &mut self.form {
            MessageForm::Described(codec) => {
                let message = codec.encode(&value, frame.as_str(), value.time(), clock);
                node.publish(self.number, vec![message]);
            }
            MessageForm::Picture(codec, info, field_of_view) => {
                let message = codec.encode(&value, frame.as_str(), value.time(), clock);
                let mut geometry = camera_info::of(&value, *field_of_view);
                if !frame.is_empty() {
                    geometry.header.frame_id = Frame::truncated(frame.as_str());
                }
                let geometry = info.encode_stamped(&geometry, value.time(), clock);
                node.publish(self.number, vec![message]);
                node.publish(self.number + 1, vec![geometry]);
            }
            MessageForm::Compressed(compressor) => {
                let own = typed::<Header>(&value[..size_of::<Header>()]);
                let header = Header {
                    stamp: clock.stamp(measured(&own, value.time())),
                    frame_id: if frame.is_empty() {
                        own.frame_id
                    } else {
                        Frame::truncated(frame.as_str())
                    },
                };
                compressor.compress(import.value_type(), &value, header);
            }
            MessageForm::Ranges(codec) => {
                let ring = typed::<RangeRing>(&value);
                let message = |(range, _)| codec.encode_stamped(&range, value.time(), clock);
                node.publish(
                    self.number,
                    range_messages(&ring, frame.as_str()).map(message).collect(),
                );
            }
            MessageForm::Position(codec) => {
                let mut pose = PoseWithCovarianceStamped::from(&typed::<PositionFix>(&value));
                if !frame.is_empty() {
                    pose.header.frame_id = Frame::truncated(frame.as_str());
                }
                node.publish(
                    self.number,
                    vec![codec.encode_stamped(&pose, value.time(), clock)],
                );
            }
            MessageForm::Velocity(publisher) => publisher.publish(cx, connection, &typed(&value)),
        }
    }

    fn is_due(&self, now: Duration, sequence: u64) -> bool {
        let rested = self.sent_at.is_none_or(|sent_at| now >= sent_at + self.period);
        self.sent != sequence && rested
    }

    fn is_wanted(&self, connection: &RosConnection) -> bool {
        let numbers = match self.form {
            MessageForm::Velocity(_) | MessageForm::Picture(..) => self.number..=self.number + 1,
            _ => self.number..=self.number,
        };
        self.is_latched
            || numbers
                .into_iter()
                .any(|number| connection.node.has_subscribers(number))
    }
}
