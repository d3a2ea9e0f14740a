//! A topic that the application file exports: its newest message, while it is fresh.

use std::sync::Arc;

use jde_ros_node::{Quality, Topic};
use jde_schema::ListedExport;
use jde_schema::describe::Type;
use jde_schema::prelude::*;
use jde_schema::types::{CompressedImage, JointState, NavSatFix, PointCloud2};

use super::publication::{is_of, topic_name};
use super::quality::quality;
use super::settings::Subscription;
use crate::compressed::{self, Arrival, Decompressor};
use crate::connection::{RosConnection, TopicSubscription};
use crate::described::DescribedCodec;
use crate::messages::{Codec, PoseWithCovarianceStamped};
use crate::scan::{Reading, Sweep};
use crate::velocity::{self, VelocitySubscription};

/// Age at which a value is retracted, unless the file or the type states another one.
const DEFAULT_STALE: Duration = Duration::from_secs(1);
/// That age of a velocity.
const STALE_VELOCITY: Duration = Duration::from_millis(500);

/// A topic and its export.
pub(super) struct TopicExport {
    name: String,
    form: MessageForm,
    /// `None` for a value that stays.
    stale: Option<Duration>,
    last_received: Option<Duration>,
}

/// How a message becomes a value.
enum MessageForm {
    /// As it is, from the subscription of that number.
    Described(usize, DescribedCodec, Option<Check>),
    /// A compressed picture, from the subscription of that number.
    Compressed(usize, DescribedCodec, Decompressor),
    /// A scan of any number of beams.
    Scan(TopicSubscription<Sweep>, Box<Sweep>, Reading),
    /// A pose, as a measured position.
    Position(TopicSubscription<PoseWithCovarianceStamped>),
    /// A velocity, plain or stamped.
    Velocity(VelocitySubscription),
}

impl MessageForm {
    /// The subscription of a measurement, whose values end with the time of ROS 2.
    fn measurement(&self) -> Option<usize> {
        match self {
            Self::Described(number, ..) | Self::Compressed(number, ..) => Some(*number),
            Self::Scan(subscription, ..) => Some(subscription.number()),
            Self::Position(subscription) => Some(subscription.number()),
            Self::Velocity(_) => None,
        }
    }
}

/// Whether one node alone sends messages of a type, because those of two contradict each other.
fn has_one_source(value_type: &Type) -> bool {
    is_of::<LaserScan>(value_type)
        || is_of::<Odometry>(value_type)
        || is_of::<PositionFix>(value_type)
        || is_of::<Image>(value_type)
        || is_of::<Imu>(value_type)
        || is_of::<NavSatFix>(value_type)
        || is_of::<PointCloud2>(value_type)
}

/// Returns what is wrong with a value whose message is well-formed.
type Check = fn(&[u8]) -> Result<(), &'static str>;

/// Returns the check of the values of a type, if it has one.
fn check_of(value_type: &Type) -> Option<Check> {
    fn of<T: Value>(value: &[u8], check: fn(&T) -> Result<(), &'static str>) -> Result<(), &'static str> {
        T::view(value).map_or(Err("its bytes are not aligned"), check)
    }
    if is_of::<JointState>(value_type) {
        Some(|value| of(value, JointState::check))
    } else if is_of::<NavSatFix>(value_type) {
        Some(|value| of(value, NavSatFix::check))
    } else if is_of::<PointCloud2>(value_type) {
        Some(|value| of(value, PointCloud2::check))
    } else {
        None
    }
}

/// Checks the settings of an entry.
pub(super) fn check(namespace: &str, export: &ListedExport<Subscription>) -> Result<(), String> {
    topic_name(namespace, export.label())?;
    let (settings, value_type) = (export.settings(), export.value_type());
    quality(settings.quality(), value_type)?;
    if settings.yaw != 0.0 && !is_of::<LaserScan>(value_type) {
        return Err("`yaw` belongs to laser scans, and this is none".to_owned());
    }
    if settings.inf_is_valid.get() && !is_of::<LaserScan>(value_type) {
        return Err("`inf_is_valid` belongs to laser scans, and this is none".to_owned());
    }
    if settings.compressed.get() && !is_of::<Image>(value_type) {
        return Err("`compressed` belongs to pictures, and this is none".to_owned());
    }
    if settings.stale > 3600.0 {
        return Err(format!(
            "`stale` is {} s; expected at most 3600 s",
            settings.stale
        ));
    }
    Ok(())
}

/// The age at which a value is retracted.
fn stale(stated: f64, value_type: &Type, quality: Quality) -> Option<Duration> {
    if stated >= 0.0 {
        return (stated > 0.0).then(|| Duration::from_secs_f64(stated));
    }
    match quality.latched {
        true => None,
        false if is_of::<Twist>(value_type) => Some(STALE_VELOCITY),
        false => Some(DEFAULT_STALE),
    }
}

impl TopicExport {
    /// Adds the topics of an entry to those of the node.
    pub(super) fn new(
        namespace: &str,
        export: &ListedExport<Subscription>,
        topics: &mut Vec<Topic>,
    ) -> Result<Self, String> {
        check(namespace, export).map_err(|error| format!("`{}` in `subscribe`: {error}", export.label()))?;
        let (number, value_type) = (topics.len(), export.value_type());
        let (name, settings) = (topic_name(namespace, export.label())?, export.settings());
        let quality = quality(settings.quality(), value_type)?;
        let form = if is_of::<LaserScan>(value_type) {
            let codec = Codec::new();
            topics.push(codec.topic(name.clone(), quality));
            let subscription = TopicSubscription::new(number, name.clone(), codec);
            let reading = Reading {
                yaw: settings.yaw as f32,
                inf_is_valid: settings.inf_is_valid.get(),
            };
            MessageForm::Scan(subscription, Sweep::boxed(), reading)
        } else if is_of::<PositionFix>(value_type) {
            let codec = Codec::new();
            topics.push(codec.topic(name.clone(), quality));
            MessageForm::Position(TopicSubscription::new(number, name.clone(), codec))
        } else if is_of::<Twist>(value_type) {
            topics.extend(velocity::topics(&name, quality));
            MessageForm::Velocity(VelocitySubscription::new(number, &name))
        } else if settings.compressed.get() {
            topics.push(compressed::topic(name.clone(), quality));
            let codec = DescribedCodec::new(&Arc::new(CompressedImage::describe()));
            let decompressor = Decompressor::start();
            let decompressor = decompressor
                .map_err(|error| format!("no thread for decompression could be created: {error}"))?;
            MessageForm::Compressed(number, codec, decompressor)
        } else {
            let codec = DescribedCodec::new(value_type);
            topics.push(codec.topic(name.clone(), quality));
            MessageForm::Described(number, codec, check_of(value_type))
        };
        if has_one_source(value_type) {
            topics[number..]
                .iter_mut()
                .for_each(|topic| topic.has_one_source = true);
        }
        Ok(Self {
            name,
            form,
            stale: stale(settings.stale, value_type, quality),
            last_received: None,
        })
    }

    /// Exports a new message, and retracts one that is stale.
    pub(super) fn receive(
        &mut self,
        cx: &Context,
        connection: &mut RosConnection,
        export: &mut ListedExport<Subscription>,
    ) {
        if let Some(arrived) = self.take(cx, connection, export) {
            self.last_received = Some(arrived);
        }
        let ended = |number: Option<usize>| number.is_some_and(|number| connection.has_ended(number));
        let has_ended = ended(self.form.measurement());
        let is_stale = |(received, stale): (Duration, Duration)| has_ended || cx.now() > received + stale;
        if self.last_received.zip(self.stale).is_some_and(is_stale) {
            self.last_received = None;
            export.retract(cx);
        }
    }

    /// Exports a new message. Returns when it arrived.
    fn take(
        &mut self,
        cx: &Context,
        connection: &mut RosConnection,
        export: &mut ListedExport<Subscription>,
    ) -> Option<Duration> {
        let name = &self.name;
        match &mut self.form {
            MessageForm::Described(number, codec, check) => {
                let (received, arrived) = connection.take(cx, *number)?;
                let pieces = received.pieces();
                let stamp = codec.stamp(&pieces);
                let time = stamp.map_or(arrived, |stamp| connection.measured(cx, name, stamp, arrived));
                if !connection.is_fresh(cx, name, (time, arrived), self.stale) {
                    return None;
                }
                let clock = &connection.clock;
                let written = export.write_with(cx, Some(time), |value| {
                    let decoded = codec.decode_into(&pieces, (time, clock), value);
                    decoded.map_err(|error| error.to_string())?;
                    check.map_or(Ok(()), |check| check(value)).map_err(str::to_owned)
                });
                if let Err(error) = written {
                    connection.warn_once(cx, format!("{name}: {error}"));
                    return None;
                }
                Some(arrived)
            }
            MessageForm::Compressed(number, codec, decompressor) => {
                let (picture, stale) = (decompressor.picture(), self.stale);
                decompressor.decompress(|| {
                    let (received, arrived) = connection.take(cx, *number)?;
                    let message = received.message.to_bytes().into_owned();
                    let stamp = codec.stamp(&[&message]);
                    let time = stamp.map_or(arrived, |stamp| connection.measured(cx, name, stamp, arrived));
                    let is_fresh = connection.is_fresh(cx, name, (time, arrived), stale);
                    is_fresh.then_some(Arrival {
                        message,
                        time,
                        arrived,
                    })
                });
                match picture? {
                    Ok((image, arrived)) => {
                        write(cx, export, image.header.stamp.into(), &*image);
                        Some(arrived)
                    }
                    Err(error) => {
                        connection.warn_once(cx, format!("{name}: {error}"));
                        None
                    }
                }
            }
            MessageForm::Scan(subscription, sweep, reading) => {
                let arrived = connection.receive(cx, subscription, &mut **sweep)?;
                let time = connection.stamp(cx, subscription, &mut sweep.header, arrived);
                if !connection.is_fresh(cx, name, (time, arrived), self.stale) {
                    return None;
                }
                let mut scan = LaserScan::boxed();
                if let Err(error) = sweep.fill(*reading, &mut scan) {
                    export.retract(cx);
                    connection.warn_once(cx, format!("{name}: {error}"));
                    return None;
                }
                write(cx, export, time, &*scan);
                Some(arrived)
            }
            MessageForm::Position(subscription) => {
                let mut pose = PoseWithCovarianceStamped::default();
                let arrived = connection.receive(cx, subscription, &mut pose)?;
                let time = connection.stamp(cx, subscription, &mut pose.header, arrived);
                if !connection.is_fresh(cx, name, (time, arrived), self.stale) {
                    return None;
                }
                write(cx, export, time, &PositionFix::from(&pose));
                Some(arrived)
            }
            MessageForm::Velocity(subscription) => {
                let (twist, arrived) = subscription.receive(cx, connection)?;
                write(cx, export, arrived, &twist);
                Some(arrived)
            }
        }
    }
}

fn write<T: Value>(cx: &Context, export: &mut ListedExport<Subscription>, time: Duration, value: &T) {
    let written = export.write_with(cx, Some(time), |bytes| {
        bytes.copy_from_slice(value.as_bytes());
        Ok::<(), core::convert::Infallible>(())
    });
    let Ok(()) = written;
}
