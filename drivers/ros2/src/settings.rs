//! The modulations of the node and its connections, which every driver of this plugin has.

use jde_ros_node::{Remaps, Settings, environment_domain, names};
use jde_schema::prelude::{Context, Modulation, Problems, Text};

/// Declares a type of schema whose instances are nodes. The modulations of the node come before the ports that it
/// states itself.
macro_rules! node_schema {
    ($(#[$about:meta])* pub struct $schema:ident { $($fields:tt)* }) => {
        #[derive(Describe)]
        $(#[$about])*
        pub struct $schema {
            /// The router of ROS 2, or other nodes, to connect to; separated by commas. `humble/` before them is for nodes
            /// of Humble, and `ros2dds/` connects to a bridge of DDS.
            #[modulation(default = "tcp/localhost:7447", fixed)]
            connect: Modulation<Text<512>>,
            /// Addresses at which other nodes can connect, such as "tcp/localhost:0" for a free port; if empty, all messages
            /// pass through the router, unless it is the default one: then those of this machine can connect, as in ROS 2.
            #[modulation(default = "", fixed)]
            listen: Modulation<Text<512>>,
            /// A Zenoh configuration file instead of these two, for TLS, passwords and other settings.
            #[modulation(default = "", unit = "path", fixed)]
            config: Modulation<Text<1024>>,
            /// Domain; -1 for the environment's ROS_DOMAIN_ID, or 0 without one.
            #[modulation(default = -1, min = -1.0, max = 232.0, fixed)]
            domain: Modulation<i32>,
            /// Namespace of the node and its names.
            #[modulation(default = "", fixed)]
            namespace: Modulation<Text<128>>,
            /// Name of the node; empty for that of this schema.
            #[modulation(default = "", fixed)]
            node: Modulation<Text<128>>,
            /// Rules that replace names of topics and services, `FROM:=TO` with commas between them, as ROS 2 takes them
            /// with `-r`.
            #[modulation(default = "", fixed)]
            remap: Modulation<Text<1020>>,
            $($fields)*
        }

        impl $schema {
            fn with_settings<R>(
                &self,
                cx: &Context,
                work: impl FnOnce(jde_ros_node::Settings<'_>) -> R,
            ) -> R {
                let (connect, listen) = (self.connect.get(cx), self.listen.get(cx));
                let (config, namespace, node, remap) = (
                    self.config.get(cx),
                    self.namespace.get(cx),
                    self.node.get(cx),
                    self.remap.get(cx),
                );
                work(jde_ros_node::Settings {
                    config: config.as_str(),
                    connect: connect.as_str(),
                    listen: listen.as_str(),
                    domain: self.domain.get(cx),
                    namespace: namespace.as_str(),
                    node: node.as_str(),
                    owner: cx.name(),
                    remap: remap.as_str(),
                })
            }

            /// Reports each invalid setting of the node, and each of these names of topics. Returns the namespace, empty for an
            /// invalid one.
            fn inspect_node(
                &self,
                cx: &Context,
                topics: &[&Modulation<Text<128>>],
                problems: &mut Problems<'_>,
            ) -> String {
                let modulations = $crate::settings::Modulations {
                    config: &self.config,
                    connect: &self.connect,
                    domain: &self.domain,
                    namespace: &self.namespace,
                    node: &self.node,
                    remap: &self.remap,
                };
                self.with_settings(cx, |settings| {
                    modulations.inspect(cx, &settings, topics, problems)
                })
            }
        }
    };
}

pub(crate) use node_schema;

/// The modulations of a node.
pub(crate) struct Modulations<'m> {
    pub(crate) config: &'m Modulation<Text<1024>>,
    pub(crate) connect: &'m Modulation<Text<512>>,
    pub(crate) domain: &'m Modulation<i32>,
    pub(crate) namespace: &'m Modulation<Text<128>>,
    pub(crate) node: &'m Modulation<Text<128>>,
    pub(crate) remap: &'m Modulation<Text<1020>>,
}

impl Modulations<'_> {
    /// Reports each invalid setting, and each invalid name of a topic, at its modulation. Returns the namespace.
    pub(crate) fn inspect(
        &self,
        cx: &Context,
        settings: &Settings<'_>,
        topics: &[&Modulation<Text<128>>],
        problems: &mut Problems<'_>,
    ) -> String {
        let environment = environment_domain();
        problems.expect(
            self.domain,
            names::domain(settings.domain, environment.as_deref()),
        );
        let namespace = problems.expect(self.namespace, names::namespace(settings.namespace));
        problems.expect(self.node, names::node(settings.node, settings.owner));
        problems.expect(self.remap, settings.remap.parse::<Remaps>());
        if let Err(error) = settings.connection_config() {
            match settings.config {
                "" => problems.wrong(self.connect, error),
                _ => problems.wrong(self.config, error),
            }
        }
        let namespace = namespace.unwrap_or_default();
        for topic in topics {
            problems.expect(topic, names::topic(&namespace, topic.get(cx).as_str()));
        }
        namespace
    }
}
