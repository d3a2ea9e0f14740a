//! The modulations of the node and its connections, which every driver of this plugin has.

use jde_ros_node::{Settings, environment_domain, names};
use jde_schema::prelude::{Modulation, Problems, Text};

/// The modulations of these settings, and the names of topics.
pub(crate) struct Modulations<'m> {
    pub(crate) config: &'m Modulation<Text<1024>>,
    pub(crate) connect: &'m Modulation<Text<512>>,
    pub(crate) domain: &'m Modulation<i32>,
    pub(crate) namespace: &'m Modulation<Text<128>>,
    pub(crate) node: &'m Modulation<Text<128>>,
    pub(crate) topics: Vec<(&'m Modulation<Text<128>>, Text<128>)>,
}

/// Gives a driver `with_settings`, which reads the modulations of these settings.
macro_rules! with_settings {
    ($driver:ty) => {
        impl $driver {
            fn with_settings<R>(&self, cx: &Context, work: impl FnOnce(Settings<'_>) -> R) -> R {
                let (connect, listen) = (self.connect.sample(cx), self.listen.sample(cx));
                let (config, namespace, node) = (
                    self.config.get(cx),
                    self.namespace.get(cx),
                    self.node.get(cx),
                );
                work(Settings {
                    config: config.as_str(),
                    connect: connect.as_str(),
                    listen: listen.as_str(),
                    has_endpoint: !connect.is_default() || !listen.is_default(),
                    domain: self.domain.get(cx),
                    namespace: namespace.as_str(),
                    node: node.as_str(),
                    owner: cx.name(),
                })
            }
        }
    };
}

pub(crate) use with_settings;

impl Modulations<'_> {
    /// Reports each invalid setting at its modulation.
    pub(crate) fn inspect(&self, settings: &Settings<'_>, problems: &mut Problems<'_>) {
        let environment = environment_domain();
        problems.expect(
            self.domain,
            names::domain(settings.domain, environment.as_deref()),
        );
        let namespace = problems.expect(self.namespace, names::namespace(settings.namespace));
        problems.expect(self.node, names::node(settings.node, settings.owner));
        if let Err(error) = settings.connection_config() {
            match settings.config {
                "" => problems.wrong(self.connect, error),
                _ => problems.wrong(self.config, error),
            }
        }
        let namespace = namespace.unwrap_or_default();
        for (modulation, name) in &self.topics {
            problems.expect(modulation, names::topic(&namespace, name.as_str()));
        }
    }
}
