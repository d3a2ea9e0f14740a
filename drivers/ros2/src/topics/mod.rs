//! Topics by the application file: variables are published, and messages are exported.

mod mounts;
mod publication;
mod quality;
mod settings;
mod subscription;
mod transforms;

use jde_ros_node::{NodeConfig, Settings};
use jde_schema::ListedImport;
use jde_schema::prelude::*;

use crate::clock_source::ClockSource;
use crate::connection::{RosConnection, arrival};
use crate::settings::node_schema;
use mounts::MountPublisher;
use publication::TopicPublication;
pub(crate) use settings::{Publication, Subscription};
use subscription::TopicExport;
use transforms::TransformPublisher;

node_schema! {
    /// Publishes variables in ROS 2, and exports topics. The keys of both lists are names of topics, relative to the
    /// namespace unless they begin with `/`.
    ///
    /// A variable is published when it is new and the topic has subscribers. Messages have the type of the variable, with
    /// these exceptions: a ring of sonars is one `sensor_msgs/msg/Range` for each, a measured position is a
    /// `geometry_msgs/msg/PoseWithCovarianceStamped`, and a velocity is a `Twist`, and a `TwistStamped` for those who
    /// subscribe to that. The same conversions apply to exports, and scans of more beams are merged.
    #[schema(driver, period = "20ms", budget = "20ms")]
    pub struct Topics {
        /// Topic of the transforms that change: the base by its odometry, and the poses with a `child`.
        #[modulation(default = "/tf", fixed)]
        tf_topic: Modulation<Text<128>>,
        /// Topic of the transforms that do not: the lasers, the sonars and the cameras on the base.
        #[modulation(default = "/tf_static", fixed)]
        tf_static_topic: Modulation<Text<128>>,
        /// The clock of the stamps: `wall`, `follow` for that of `/clock`, or `publish` for the time of the application,
        /// which is then published there.
        #[modulation(default = ClockSource::Wall)]
        clock: Modulation<ClockSource>,
        /// The variables to publish.
        #[imports(default = Publication::DEFAULT)]
        publish: Imports<Publication>,
        /// The topics to export.
        #[exports(default = Subscription::DEFAULT, lasting)]
        subscribe: Exports<Subscription>,
        /// Whether the router or other nodes are connected.
        #[export(lasting)]
        connection: Export<Connection>,
        active: Option<ActiveTopics>,
    }
}

/// The node with its topics, in the order of the lists.
struct ActiveTopics {
    connection: RosConnection,
    publications: Vec<TopicPublication>,
    exports: Vec<TopicExport>,
    transforms: Option<TransformPublisher>,
    mounts: Option<MountPublisher>,
}

impl Schema for Topics {
    fn awake(&mut self, cx: &Context) -> Result {
        // The time of an application that is that of ROS 2 too may pass as it likes.
        if self.clock.get(cx) != ClockSource::Publish {
            cx.require_real_time()?;
        }
        if self.active.is_none() {
            self.active = Some(self.with_settings(cx, |settings| self.start(cx, &settings))?);
        }
        Ok(())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        let Some(active) = &mut self.active else {
            return Err("it is not awake".into());
        };
        active.connection.begin(cx, self.clock.get(cx));
        if active.connection.clock.is_known() {
            for (publication, import) in active.publications.iter_mut().zip(self.publish.iter()) {
                publication.publish(cx, &mut active.connection, import);
            }
            if let Some(transforms) = &mut active.transforms {
                transforms.publish(cx, &active.connection, &self.publish);
            }
            if let Some(mounts) = &mut active.mounts {
                mounts.publish(cx, &mut active.connection, &self.publish);
            }
        }
        for (topic, export) in active.exports.iter_mut().zip(self.subscribe.iter_mut()) {
            topic.receive(cx, &mut active.connection, export);
        }
        active
            .connection
            .export_connection(cx, &mut self.connection, None);
        Ok(())
    }

    fn sleep(&mut self, cx: &Context) {
        if let Some(active) = self.active.take() {
            active.connection.close(cx, &mut self.connection);
            self.subscribe.iter_mut().for_each(|export| export.retract(cx));
        }
    }
}

impl Inspect for Topics {
    fn inspect(&self, cx: &Context, problems: &mut Problems) {
        let namespace = self.inspect_node(cx, &[&self.tf_topic, &self.tf_static_topic], problems);
        for import in self.publish.iter() {
            problems.expect(import, publication::check(&namespace, import));
        }
        for export in self.subscribe.iter() {
            problems.expect(export, subscription::check(&namespace, export));
        }
        for (import, twin) in self.twins(&namespace) {
            problems.wrong(import, format!("`{twin}` has the same topic"));
        }
    }
}

impl Topics {
    /// Returns each entry of `publish` one of whose topics is that of an earlier entry, with that entry's key.
    fn twins(&self, namespace: &str) -> Vec<(&ListedImport<Publication>, &'static str)> {
        let names = |import: &ListedImport<Publication>| publication::topic_names(namespace, import);
        let entries = self.publish.iter().enumerate();
        entries
            .filter_map(|(place, import)| {
                let own = names(import);
                let is_twin =
                    |other: &&ListedImport<Publication>| names(other).iter().any(|name| own.contains(name));
                let twin = self.publish[..place].iter().find(is_twin)?;
                Some((import, twin.label()))
            })
            .collect()
    }

    fn start(&self, cx: &Context, settings: &Settings<'_>) -> Result<ActiveTopics> {
        let node = settings.node_config()?;
        let namespace = node.name.namespace.as_str();
        if let Some((import, twin)) = self.twins(namespace).first() {
            let label = import.label();
            return Err(format!("`{twin}` and `{label}` in `publish` have the same topic").into());
        }
        let (mut published, mut subscribed) = (Vec::new(), Vec::new());
        let publications = self.publish.iter();
        let publications = publications
            .map(|import| TopicPublication::new(namespace, import, &mut published))
            .collect::<Result<Vec<_>, String>>()?;
        let exports = self.subscribe.iter();
        let exports = exports
            .map(|export| TopicExport::new(namespace, export, &mut subscribed))
            .collect::<Result<Vec<_>, String>>()?;
        let topic =
            |topic: &Modulation<Text<128>>| jde_ros_node::names::topic(namespace, topic.get(cx).as_str());
        let transforms = topic(&self.tf_topic)?
            .and_then(|topic| TransformPublisher::new(topic, &self.publish, &mut published));
        let mounts = topic(&self.tf_static_topic)?
            .and_then(|topic| MountPublisher::new(topic, &self.publish, &mut published));
        let config = NodeConfig {
            publications: published,
            subscriptions: subscribed,
            arrival: arrival(cx),
            ..node
        };
        let connection = RosConnection::start(config, self.clock.get(cx))?;
        Ok(ActiveTopics {
            connection,
            publications,
            exports,
            transforms,
            mounts,
        })
    }
}
