//! Keys of rmw_zenoh: where a topic's messages go, and the tokens by which ROS 2 sees who is there. It opens nothing.
//!
//! Form: the design page of rmw_zenoh, <https://github.com/ros2/rmw_zenoh/blob/rolling/docs/design.md>.

use hiroz_schema::{dds_from_canonical, ros_from_dds_strict};

/// Where tokens are.
const TOKENS: &str = "@ros2_lv";
/// A name within a token has this for each `/`; an empty name is one.
const SLASH: &str = "%";

/// A node, as ROS 2 knows it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Name {
    /// Nodes of different domains do not meet.
    pub(crate) domain: u32,
    /// Empty, or as in `/robot`.
    pub(crate) namespace: String,
    pub(crate) node: String,
}

/// A topic that the node publishes or subscribes to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Topic {
    /// Its full name.
    pub(crate) name: String,
    /// Its type, as in `sensor_msgs/msg/LaserScan`.
    pub(crate) type_name: String,
    /// The type's hash.
    pub(crate) hash: String,
    pub(crate) quality: Quality,
}

/// What is promised of a topic's messages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Quality {
    /// The newest five, as they come: ROS 2's profile for sensors.
    Sensor,
    /// The newest ten, each of them: ROS 2's default.
    Reliable,
}

/// Which way a topic goes, seen from its node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Way {
    Out,
    In,
}

impl Name {
    /// The full name, as in `/robot/pioneer`.
    pub(crate) fn full(&self) -> String {
        format!("{}/{}", self.namespace, self.node)
    }

    /// The token by which others see the node; `session` is the id of its session of Zenoh.
    pub(crate) fn token(&self, session: &str) -> String {
        let (domain, namespace, node) = (self.domain, mangled(&self.namespace), &self.node);
        // The node is its session's number 0, and so is the thing that the token is for.
        format!("{TOKENS}/{domain}/{session}/0/0/NN/{SLASH}/{namespace}/{node}")
    }

    /// The tokens of everyone in the domain.
    pub(crate) fn everyone(&self) -> String {
        format!("{TOKENS}/{}/**", self.domain)
    }
}

impl Topic {
    /// Where its messages go.
    pub(crate) fn key(&self, name: &Name) -> String {
        let topic = self.name.trim_matches('/');
        format!("{}/{topic}/{}/{}", name.domain, self.dds(), self.hash)
    }

    /// The token by which others see that the node has it; no two of a node have one number.
    pub(crate) fn token(&self, name: &Name, session: &str, way: Way, number: usize) -> String {
        let kind = match way {
            Way::Out => "MP",
            Way::In => "MS",
        };
        let (domain, namespace, node) = (name.domain, mangled(&name.namespace), &name.node);
        let (topic, hash, quality) = (mangled(&self.name), &self.hash, self.quality.profile());
        let dds = self.dds();
        format!(
            "{TOKENS}/{domain}/{session}/0/{number}/{kind}/{SLASH}/{namespace}/{node}/{topic}/{dds}/{hash}/{quality}"
        )
    }

    /// What keeps it from meeting the one that another's token announces; nothing if they meet, or have nothing to do with each
    /// other.
    pub(crate) fn mismatch(&self, way: Way, token: &str) -> Option<String> {
        let parts: Vec<&str> = token.splitn(14, '/').collect();
        let [TOKENS, _, _, _, _, kind, _, namespace, node, topic, dds, hash, _] = parts[..] else {
            return None;
        };
        let opposite = match way {
            Way::Out => "MS",
            Way::In => "MP",
        };
        if kind != opposite || topic != mangled(&self.name) {
            return None;
        }
        let namespace = namespace.replace(SLASH, "/");
        let whose = format!("{} of node {}/{node}", self.name, namespace.trim_end_matches('/'));
        if dds != self.dds() {
            return Some(format!(
                "{whose} is a {}, and a {} here: nothing passes between them",
                ros_from_dds_strict(dds),
                self.type_name
            ));
        }
        (hash != self.hash).then(|| {
            format!(
                "{whose} is another version of {}, {}, and {} here: nothing passes between them",
                self.type_name,
                short(hash),
                short(&self.hash)
            )
        })
    }

    /// The name of its type as keys have it: `sensor_msgs::msg::dds_::LaserScan_`.
    fn dds(&self) -> String {
        dds_from_canonical(&self.type_name).unwrap_or_else(|| self.type_name.replace('/', SLASH))
    }
}

impl Quality {
    /// As tokens write it: whatever is left out is the default.
    fn profile(self) -> &'static str {
        match self {
            Self::Sensor => "2::,5:,:,:,,",
            Self::Reliable => "::,10:,:,:,,",
        }
    }
}

fn mangled(name: &str) -> String {
    if name.is_empty() {
        return SLASH.to_owned();
    }
    name.replace('/', SLASH)
}

/// Enough of a hash to tell it from another.
fn short(hash: &str) -> &str {
    hash.get(..20).unwrap_or(hash)
}

#[cfg(test)]
mod tests;
