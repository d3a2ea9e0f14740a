//! Keys of rmw_zenoh: the key of a topic's messages, and the liveliness tokens by which ROS 2 discovers
//! nodes. It opens no connection.
//!
//! The format follows the design page of rmw_zenoh,
//! <https://github.com/ros2/rmw_zenoh/blob/rolling/docs/design.md>.

mod tokens;

use std::time::Duration;

use hiroz_schema::{dds_from_canonical, ros_from_dds_strict};
use jde_ros::{Type, definition};
use tokens::{EntityToken, bridge_token};

use crate::hash;
use crate::interface::Interfaces;
use crate::own::is_own_session;

/// Prefix of tokens.
const TOKENS: &str = "@ros2_lv";
/// The depth that tokens leave out.
const DEFAULT_DEPTH: usize = 42;
/// Stands for the hash of a type in Humble.
pub(crate) const NO_HASH: &str = "TypeHashNotSupported";
/// Replaces each `/` in a name within a token, and stands for an empty name.
const SLASH: &str = "%";
/// A node, as ROS 2 identifies it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NodeName {
    /// Nodes of different domains do not communicate.
    pub domain: u32,
    /// What it speaks to.
    pub middleware: Middleware,
    /// Empty, or such as `/robot`.
    pub namespace: String,
    /// Its own name, such as `pioneer`.
    pub node: String,
}

/// What a node speaks to. It decides the form of the keys.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Middleware {
    /// `rmw_zenoh_cpp` of Iron and later.
    #[default]
    Rmw,
    /// `rmw_zenoh_cpp` of Humble, which has no hashes of types.
    RmwHumble,
    /// `zenoh-bridge-ros2dds`, a bridge of DDS, whose keys are the names of topics alone. A node has no tokens then, and
    /// no services.
    Bridge,
}

/// The bytes of a batch of Zenoh. A longer message is sent in fragments.
pub(crate) const BATCH_BYTES: usize = u16::MAX as usize;

/// A topic that the node publishes or subscribes to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Topic {
    /// Its full name.
    pub name: String,
    /// Its type, such as `sensor_msgs/msg/LaserScan`.
    pub type_name: String,
    /// The type's hash.
    pub hash: String,
    /// Its quality of service.
    pub quality: Quality,
    /// When other nodes discover it.
    pub announced: Announced,
    /// The least time between two messages that are sent.
    pub gap: Duration,
    /// Whether a message may have more bytes than a batch of Zenoh. Those of all other topics go before them.
    pub is_large: bool,
    /// Whether its messages command a robot. Those of this process are not received, since they would repeat themselves, and
    /// another node that publishes them is remarked.
    pub is_command: bool,
    /// Whether the node publishes it only while no other does: it does not receive its own messages, and others do not discover
    /// the publication, since it is no rival of theirs.
    pub is_standby: bool,
    /// Whether one node alone sends its messages, as those of a sensor. While two do, none is received, and a remark names both.
    pub has_one_source: bool,
}

/// When other nodes discover a topic.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Announced {
    /// From the beginning.
    Always,
    /// As long as no other node has, in the opposite direction, only the topic of the same name that is announced
    /// [`OnceMet`](Self::OnceMet), so that a name has one type as long as nobody uses the other.
    Preferably,
    /// Once another node has the topic in the opposite direction.
    OnceMet,
    /// While the owner [wants](crate::Node::want) its messages; a subscription only.
    WhileWanted,
}

/// A service that the node offers or calls.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Service {
    /// Its full name.
    pub name: String,
    /// Its type, such as `std_srvs/srv/Trigger`.
    pub type_name: String,
    /// The type's hash.
    pub hash: String,
}

/// Quality of service of a topic.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Quality {
    /// Whether it is reliable; otherwise best effort.
    pub reliable: bool,
    /// Whether a subscription that begins later receives the newest messages: transient local.
    pub latched: bool,
    /// The number of messages that are kept.
    pub depth: usize,
}

/// Direction of a topic or a service, as seen from its node.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Direction {
    /// The node sends its messages.
    Publish,
    /// The node receives its messages.
    Subscribe,
    /// The node answers its requests.
    Serve,
    /// The node requests.
    Call,
}

impl NodeName {
    /// Whether it speaks to a bridge of DDS.
    pub(crate) fn is_bridged(&self) -> bool {
        self.middleware == Middleware::Bridge
    }

    /// The full name, such as `/robot/pioneer`.
    pub fn full(&self) -> String {
        format!("{}/{}", self.namespace, self.node)
    }

    /// The token by which others discover the node; `session` is the identifier of its Zenoh session.
    pub fn token(&self, session: &str) -> String {
        let (domain, namespace, node) = (self.domain, encode_name(&self.namespace), &self.node);
        // The node has number 0 in its session, and the entity of the token has it too.
        format!("{TOKENS}/{domain}/{session}/0/0/NN/{SLASH}/{namespace}/{node}")
    }

    /// The key expression of all tokens in the domain, or of those of a bridge.
    pub fn all_tokens(&self) -> String {
        match self.is_bridged() {
            true => format!("@/*/{TOKENS}/**"),
            false => format!("{TOKENS}/{}/**", self.domain),
        }
    }
}

/// Returns the bytes that messages of a topic do not have at their end where the node connects: the variance of a range in
/// Humble.
pub(crate) fn missing(name: &NodeName, topic: &Topic) -> &'static [u8] {
    match (name.middleware, topic.type_name.as_str()) {
        (Middleware::RmwHumble, "sensor_msgs/msg/Range") => &[0; size_of::<f32>()],
        _ => &[],
    }
}

impl Topic {
    /// A topic of that name whose messages are values of a type.
    #[must_use]
    pub fn new(name: String, value_type: &Type, quality: Quality) -> Self {
        Self {
            name,
            type_name: definition::name(value_type),
            hash: hash::rihs01(value_type),
            quality,
            announced: Announced::Always,
            gap: Duration::ZERO,
            is_large: value_type.bytes > BATCH_BYTES,
            is_command: false,
            is_standby: false,
            has_one_source: false,
        }
    }

    /// A topic of that name whose messages are of an interface; `None` for an unknown one.
    #[must_use]
    pub fn of_interface(
        name: String,
        type_name: &str,
        interfaces: &Interfaces,
        quality: Quality,
    ) -> Option<Self> {
        Some(Self {
            name,
            type_name: type_name.to_owned(),
            hash: interfaces.hash(type_name)?,
            quality,
            announced: Announced::Always,
            gap: Duration::ZERO,
            is_large: false,
            is_command: false,
            is_standby: false,
            has_one_source: false,
        })
    }

    /// The key of its messages.
    pub fn key(&self, name: &NodeName) -> String {
        let topic = self.name.trim_matches('/');
        if name.is_bridged() {
            return topic.to_owned();
        }
        format!("{}/{topic}/{}/{}", name.domain, self.dds(), self.hash)
    }

    /// The token by which others discover the topic; `number` is unique within the node.
    pub fn token(&self, name: &NodeName, session: &str, direction: Direction, number: usize) -> String {
        let kind = direction.kind();
        let (domain, namespace, node) = (name.domain, encode_name(&name.namespace), &name.node);
        let (topic, hash, quality) = (encode_name(&self.name), &self.hash, self.quality.profile());
        let dds = self.dds();
        format!(
            "{TOKENS}/{domain}/{session}/0/{number}/{kind}/{SLASH}/{namespace}/{node}/{topic}/{dds}/{hash}/{quality}"
        )
    }

    /// Whether a token of another node, or of a bridge, announces this topic in the opposite direction.
    #[must_use]
    pub fn meets(&self, direction: Direction, token: &str) -> bool {
        if let Some((kind, topic, type_name)) = bridge_token(token) {
            return kind == direction.opposite().kind()
                && topic == self.name.trim_matches('/')
                && type_name == self.type_name;
        }
        EntityToken::parse(token).is_some_and(|token| self.is_announced_by(direction.opposite(), &token))
    }

    /// Whether a token announces this topic in a direction.
    fn is_announced_by(&self, direction: Direction, token: &EntityToken<'_>) -> bool {
        token.kind == direction.kind()
            && token.topic == encode_name(&self.name)
            && token.dds == self.dds()
            && token.hash == self.hash
    }

    /// Returns a remark if this topic commands a robot and a token announces that another node publishes it too.
    fn rival(&self, token: &str) -> Option<String> {
        if !self.is_command {
            return None;
        }
        let who = if let Some((kind, topic, _)) = bridge_token(token) {
            let is_rival = kind == Direction::Publish.kind() && topic == self.name.trim_matches('/');
            is_rival.then(|| "a program behind the bridge".to_owned())
        } else {
            EntityToken::parse(token)
                .filter(|token| !is_own_session(token.session))
                .filter(|token| self.is_announced_by(Direction::Publish, token))
                .map(|token| format!("node {}", token.full_name()))
        };
        who.map(|who| {
            format!(
                "{who} publishes {} too, and its commands do not pass through this application",
                self.name
            )
        })
    }

    /// Returns the reason why this topic exchanges no messages with the one that a token of another node
    /// announces; `None` if they communicate, or if the token is unrelated.
    fn mismatch(&self, direction: Direction, token: &str) -> Option<String> {
        let token = EntityToken::parse(token)?;
        if token.kind != direction.opposite().kind() || token.topic != encode_name(&self.name) {
            return None;
        }
        let (dds, hash) = (token.dds, token.hash);
        let description = format!("{} of node {}", self.name, token.full_name());
        if dds != self.dds() {
            return Some(format!(
                "{description} is a {}, and a {} here: nothing passes between them",
                ros_from_dds_strict(dds),
                self.type_name
            ));
        }
        match (hash == NO_HASH, self.hash == NO_HASH) {
            (true, false) => Some(format!(
                "{description} is of Humble: nothing passes between them; connect = \"humble/tcp/HOST:PORT\" is for nodes \
                 of Humble"
            )),
            (false, true) => Some(format!(
                "{description} is not of Humble: nothing passes between them; leave out `humble/` in connect for nodes of \
                 other distributions"
            )),
            _ => (hash != self.hash).then(|| {
                format!(
                    "{description} is another version of {}, {}, and {} here: nothing passes between them",
                    self.type_name,
                    short(hash),
                    short(&self.hash)
                )
            }),
        }
    }

    /// The name of its type in keys, such as `sensor_msgs::msg::dds_::LaserScan_`.
    fn dds(&self) -> String {
        dds_from_canonical(&self.type_name).unwrap_or_else(|| self.type_name.replace('/', SLASH))
    }
}

impl Service {
    /// A service of that name; `None` if its type is none of the interfaces.
    #[must_use]
    pub fn new(name: String, type_name: &str, interfaces: &Interfaces) -> Option<Self> {
        Some(Self {
            name,
            type_name: type_name.to_owned(),
            hash: interfaces.hash(type_name)?,
        })
    }

    /// A service of that name, whose request and response are values of these types.
    ///
    /// # Errors
    /// If they are not the request and the response of one service.
    pub fn of_values(name: String, request: &Type, response: &Type) -> Result<Self, String> {
        let is_service = |stem: &&str| stem.contains("/srv/");
        let part = |value_type: &Type, part: &str| {
            let stem = value_type.name.strip_suffix(part).filter(is_service);
            stem.map(str::to_owned).ok_or_else(|| {
                format!(
                    "`{}` is not the name of a PACKAGE/srv/NAME{part}",
                    value_type.name
                )
            })
        };
        let (type_name, other) = (part(request, "_Request")?, part(response, "_Response")?);
        let hash = Interfaces::service_hash(&type_name, request, response).ok_or_else(|| {
            format!("its request is one of `{type_name}`, and its response one of `{other}`")
        })?;
        Ok(Self {
            name,
            type_name,
            hash,
        })
    }

    /// The topic that has the keys and tokens of this service.
    pub(crate) fn topic(&self) -> Topic {
        Topic {
            name: self.name.clone(),
            type_name: self.type_name.clone(),
            hash: self.hash.clone(),
            quality: Quality::SERVICES,
            announced: Announced::Always,
            gap: Duration::ZERO,
            is_large: false,
            is_command: false,
            is_standby: false,
            has_one_source: false,
        }
    }
}

/// Returns the reason why none of a node's topics of a direction exchanges messages with the one of that name that a
/// token of another node announces; `None` if one does, or if the token is unrelated.
pub(crate) fn mismatch(topics: &[Topic], direction: Direction, token: &str) -> Option<String> {
    if topics.iter().any(|topic| topic.meets(direction, token)) {
        return None;
    }
    let is_of_type = |topic: &&Topic| token.split('/').any(|part| part == topic.dds());
    let same_type = topics.iter().filter(is_of_type);
    same_type
        .chain(topics)
        .find_map(|topic| topic.mismatch(direction, token))
}

/// Returns a remark if a node publishes a topic that commands a robot, and a token announces that another node does too.
pub(crate) fn rival(topics: &[Topic], token: &str) -> Option<String> {
    topics.iter().find_map(|topic| topic.rival(token))
}

/// Returns the topics that have one source and that a token announces as published, by their numbers, with the name of the
/// node.
pub(crate) fn source<'t>(
    topics: &'t [Topic],
    token: &str,
) -> impl Iterator<Item = (usize, String)> + use<'t> {
    let token = EntityToken::parse(token).filter(|token| token.kind == Direction::Publish.kind());
    let source = token.map(|token| (token.topic.to_owned(), token.full_name()));
    topics.iter().enumerate().filter_map(move |(number, topic)| {
        let (name, node) = source.as_ref()?;
        let is_source = topic.has_one_source && encode_name(&topic.name) == *name;
        is_source.then(|| (number, node.clone()))
    })
}

impl Direction {
    fn opposite(self) -> Self {
        match self {
            Self::Publish => Self::Subscribe,
            Self::Subscribe => Self::Publish,
            Self::Serve => Self::Call,
            Self::Call => Self::Serve,
        }
    }

    /// The kind of its tokens.
    fn kind(self) -> &'static str {
        match self {
            Self::Publish => "MP",
            Self::Subscribe => "MS",
            Self::Serve => "SS",
            Self::Call => "SC",
        }
    }
}

impl Quality {
    /// ROS 2's profile of this name.
    pub const DEFAULT: Self = Self::reliable(10);
    /// ROS 2's profile of this name: best effort.
    pub const SENSOR_DATA: Self = Self {
        reliable: false,
        latched: false,
        depth: 5,
    };
    /// The newest message, also for subscriptions that begin later, as of a map.
    pub const LATCHED: Self = Self {
        latched: true,
        ..Self::reliable(1)
    };
    /// ROS 2's profile for requests and responses.
    pub const SERVICES: Self = Self::DEFAULT;
    /// ROS 2's profile for parameters and their events.
    pub const PARAMETERS: Self = Self::reliable(1000);
    /// ROS 2's profile for `/rosout`.
    pub const LOG: Self = Self {
        latched: true,
        ..Self::reliable(1000)
    };

    const fn reliable(depth: usize) -> Self {
        Self {
            reliable: true,
            latched: false,
            depth,
        }
    }

    /// The encoding in tokens, which omits default values.
    fn profile(self) -> String {
        let reliability = if self.reliable { "" } else { "2" };
        let durability = if self.latched { "1" } else { "" };
        let depth = match self.depth {
            DEFAULT_DEPTH => String::new(),
            depth => depth.to_string(),
        };
        format!("{reliability}:{durability}:,{depth}:,:,:,,")
    }
}

fn encode_name(name: &str) -> String {
    if name.is_empty() {
        return SLASH.to_owned();
    }
    name.replace('/', SLASH)
}

/// Shortens a hash to a distinctive prefix.
fn short(hash: &str) -> &str {
    hash.get(..20).unwrap_or(hash)
}

#[cfg(test)]
mod tests;
