//! Reads the tokens by which ROS 2 and bridges of DDS announce topics and services.

use super::{SLASH, TOKENS};

/// Replaces each `/` in a name within a token of a bridge.
const BRIDGE_SLASH: &str = "§";

/// The parts of the token of a topic or a service.
pub(super) struct EntityToken<'t> {
    pub(super) session: &'t str,
    pub(super) kind: &'t str,
    pub(super) namespace: &'t str,
    pub(super) node: &'t str,
    pub(super) topic: &'t str,
    pub(super) dds: &'t str,
    pub(super) hash: &'t str,
}

/// Returns the kind, the topic and the type of a token by which `zenoh-bridge-ros2dds` announces that it passes a topic on:
/// `@/SESSION/@ros2_lv/KIND/TOPIC/TYPE/QUALITY`, with another letter for each slash within a part.
pub(super) fn bridge_token(token: &str) -> Option<(&str, String, String)> {
    let parts: Vec<&str> = token.split('/').collect();
    // Services have no quality.
    let ["@", _, TOKENS, kind, topic, type_name, _] = parts[..] else {
        return None;
    };
    Some((
        kind,
        topic.replace(BRIDGE_SLASH, "/"),
        type_name.replace(BRIDGE_SLASH, "/"),
    ))
}

impl<'t> EntityToken<'t> {
    /// Returns the parts of a token; `None` for that of a node, or of something else.
    pub(super) fn parse(token: &'t str) -> Option<Self> {
        let parts: Vec<&str> = token.splitn(14, '/').collect();
        let [
            TOKENS,
            _,
            session,
            _,
            _,
            kind,
            _,
            namespace,
            node,
            topic,
            dds,
            hash,
            _,
            ..,
        ] = parts[..]
        else {
            return None;
        };
        Some(Self {
            session,
            kind,
            namespace,
            node,
            topic,
            dds,
            hash,
        })
    }

    /// The full name of its node, such as `/robot/pioneer`.
    pub(super) fn full_name(&self) -> String {
        let namespace = self.namespace.replace(SLASH, "/");
        format!("{}/{}", namespace.trim_end_matches('/'), self.node)
    }
}
