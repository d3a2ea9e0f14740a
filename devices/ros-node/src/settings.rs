//! The settings of a node and its connections, validated without connecting.

use std::time::Duration;

use zenoh::Config;
use zenoh::config::EndPoint;

use crate::error::describe_error;
use crate::keys::{Middleware, NodeName};
use crate::names;
use crate::node::NodeConfig;
use crate::remaps::Remaps;

/// Protocols that this crate is built with.
const ENDPOINT_KEYS: [&str; 3] = ["tcp", "tls", "unixsock-stream"];
/// The address of ROS 2's own router.
const DEFAULT_ROUTER: &str = "tcp/localhost:7447";
/// Where a node of ROS 2 listens by default: a free port, for the nodes of this machine.
const DEFAULT_LISTEN: &str = "tcp/localhost:0";
/// Largest message that is accepted, bytes. A picture that fits has a sixteenth of it.
const MAX_BYTES: usize = 16 << 20;
/// Batches of large messages that wait. With the two of other messages, the thread of the node wakes up for each fragment of
/// a picture.
const LARGE_BATCHES: usize = 8;
/// How long Zenoh waits for a batch before it drops a message, and then all others until there is one. For each fragment of
/// a large message it waits twice as long as for the one before.
const LONGEST_WAIT: Duration = Duration::from_micros(200);

/// What the addresses begin with if another middleware than that of Iron and later is there.
const MIDDLEWARES: [(&str, Middleware); 2] = [
    ("ros2dds/", Middleware::Bridge),
    ("humble/", Middleware::RmwHumble),
];

/// Where a node connects, and its names.
pub struct Settings<'a> {
    /// Path of a Zenoh configuration file, or empty.
    pub config: &'a str,
    /// Addresses to connect to, separated by commas. They begin with `ros2dds/` if a bridge of DDS is there, and with
    /// `humble/` for nodes of Humble.
    pub connect: &'a str,
    /// Addresses to listen on, separated by commas. If it is empty and `connect` is the router of this machine, the node
    /// listens at a free port of this machine, as one of ROS 2.
    pub listen: &'a str,
    /// Less than 0 for the environment's.
    pub domain: i32,
    /// The namespace of the node and its topics, or empty.
    pub namespace: &'a str,
    /// The name of the node, or empty.
    pub node: &'a str,
    /// What has the node, such as a schema: its name is that of the node if `node` is empty.
    pub owner: &'a str,
    /// Rules that replace names, `FROM:=TO` with commas between them.
    pub remap: &'a str,
}

impl Settings<'_> {
    /// Returns a node without topics and services.
    ///
    /// # Errors
    /// If a name, an address, a rule or the environment's domain is not valid, or a file cannot be read.
    pub fn node_config(&self) -> Result<NodeConfig, String> {
        Ok(NodeConfig {
            remaps: self.remap.parse()?,
            ..NodeConfig::new(self.name()?, self.connection_config()?)
        })
    }

    /// Returns the node's name. A rule for all nodes gives a namespace only to a node that states none.
    ///
    /// # Errors
    /// If a name, a rule or the environment's domain is not valid in ROS 2.
    pub fn name(&self) -> Result<NodeName, String> {
        let remaps: Remaps = self.remap.parse()?;
        let own = names::node(self.node, self.owner)?;
        let node = remaps.node(&own).map_or_else(|| own.clone(), str::to_owned);
        let stated = names::namespace(self.namespace)?;
        let namespace = match remaps.namespace(&node) {
            Some((namespace, is_own)) if is_own || stated.is_empty() => namespace.to_owned(),
            _ => stated,
        };
        Ok(NodeName {
            domain: names::domain(self.domain, environment_domain().as_deref())?,
            namespace,
            node,
            middleware: self.middleware(),
        })
    }

    /// Returns what it connects to.
    #[must_use]
    pub fn middleware(&self) -> Middleware {
        self.addresses().0
    }

    /// Returns what it connects to, and the addresses.
    fn addresses(&self) -> (Middleware, &str) {
        let mut others = MIDDLEWARES.iter();
        let other = others.find_map(|(prefix, other)| Some((*other, self.connect.strip_prefix(prefix)?)));
        other.unwrap_or((Middleware::Rmw, self.connect))
    }

    /// Returns Zenoh's configuration, and its address for messages.
    ///
    /// # Errors
    /// If an address is not valid, or the file cannot be read.
    pub fn connection_config(&self) -> Result<(Config, String), String> {
        let (middleware, connect) = self.addresses();
        let has_default_addresses = connect == DEFAULT_ROUTER && self.listen.is_empty();
        if !self.config.is_empty() {
            if !has_default_addresses {
                return Err(
                    "give either config, or connect and listen: the file contains the addresses".to_owned(),
                );
            }
            let config = Config::from_file(self.config)
                .map_err(|error| format!("config = \"{}\": {}", self.config, describe_error(&error)))?;
            return Ok((config, self.config.to_owned()));
        }
        // A bridge of DDS does not tell the nodes of each other.
        let listens_by_default = has_default_addresses && middleware != Middleware::Bridge;
        let listen = match listens_by_default {
            true => DEFAULT_LISTEN,
            false => self.listen,
        };
        let (connect, listen) = (endpoints("connect", connect)?, endpoints("listen", listen)?);
        let (mode, endpoint) = match (connect.is_empty(), listen.is_empty()) {
            (true, true) => {
                return Err(
                    "no address is set; set connect = \"tcp/localhost:7447\" to connect to a router, or \
                     listen = \"tcp/localhost:7448\" to accept connections"
                        .to_owned(),
                );
            }
            (false, true) => ("client", self.connect),
            (_, false) if listens_by_default => ("peer", self.connect),
            (_, false) => ("peer", self.listen),
        };
        let mut config = Config::default();
        let lists = |endpoints: &[EndPoint]| {
            let quoted: Vec<String> = endpoints
                .iter()
                .map(|endpoint| format!("{:?}", endpoint.to_string()))
                .collect();
            format!("[{}]", quoted.join(","))
        };
        // A client fails if it cannot connect, and its session's thread tries again. A peer fails only if it
        // cannot listen, and connects to other nodes meanwhile.
        let is_peer = mode == "peer";
        let entries = [
            ("mode", format!("{mode:?}")),
            ("connect/endpoints", lists(&connect)),
            ("connect/timeout_ms", if is_peer { "-1" } else { "0" }.to_owned()),
            ("connect/exit_on_failure", (!is_peer).to_string()),
            (
                "connect/retry",
                "{ period_init_ms: 200, period_max_ms: 1000, period_increase_factor: 2 }".to_owned(),
            ),
            ("listen/endpoints", lists(&listen)),
            ("listen/timeout_ms", "0".to_owned()),
            ("listen/exit_on_failure", "true".to_owned()),
            // As in ROS 2: no multicast scouting; connected nodes report others by gossip.
            ("scouting/multicast/enabled", "false".to_owned()),
            ("scouting/gossip/enabled", "true".to_owned()),
            ("transport/link/rx/max_message_size", MAX_BYTES.to_string()),
            ("transport/link/tx/queue/size/data_low", LARGE_BATCHES.to_string()),
            (
                "transport/link/tx/queue/congestion_control/drop/wait_before_drop",
                LONGEST_WAIT.as_micros().to_string(),
            ),
        ];
        // With a router, as in ROS 2: it alone reports the others, and of two nodes one connects.
        let with_router = [
            ("scouting/gossip/target", "{ peer: [\"router\"] }".to_owned()),
            (
                "scouting/gossip/autoconnect_strategy",
                "{ peer: { to_router: \"always\", to_peer: \"greater-zid\" } }".to_owned(),
            ),
        ];
        let with_router = with_router.into_iter().filter(|_| listens_by_default);
        for (key, value) in entries.into_iter().chain(with_router) {
            config.insert_json5(key, &value).map_err(|error| {
                format!(
                    "Zenoh does not accept {value} for `{key}`: {}",
                    describe_error(&error)
                )
            })?;
        }
        Ok((config, endpoint.to_owned()))
    }
}

/// The environment's ROS_DOMAIN_ID.
#[must_use]
pub fn environment_domain() -> Option<String> {
    std::env::var("ROS_DOMAIN_ID").ok()
}

/// Returns the middleware of the environment's ROS_DISTRO.
#[must_use]
pub fn environment_middleware() -> Middleware {
    match std::env::var("ROS_DISTRO").as_deref() {
        Ok("humble") => Middleware::RmwHumble,
        _ => Middleware::Rmw,
    }
}

/// Returns the configuration that the environment states as for `rmw_zenoh_cpp`, and its address for messages:
/// the file `ZENOH_SESSION_CONFIG_URI`, or the router at `tcp/localhost:7447` and a free port of this machine; and then each
/// `KEY=VALUE` of `ZENOH_CONFIG_OVERRIDE`, with semicolons between them.
///
/// # Errors
/// If the file cannot be read, or Zenoh does not accept an entry.
pub fn environment_connection() -> Result<(Config, String), String> {
    let variable = |name| std::env::var(name).unwrap_or_default();
    stated_connection(
        &variable("ZENOH_SESSION_CONFIG_URI"),
        &variable("ZENOH_CONFIG_OVERRIDE"),
    )
}

fn stated_connection(file: &str, overrides: &str) -> Result<(Config, String), String> {
    let settings = Settings {
        config: file,
        connect: DEFAULT_ROUTER,
        listen: "",
        domain: -1,
        namespace: "",
        node: "",
        owner: "",
        remap: "",
    };
    let (mut config, mut endpoint) = settings.connection_config()?;
    for entry in overrides
        .split(';')
        .map(str::trim)
        .filter(|entry| !entry.is_empty())
    {
        let error = |error: &str| format!("ZENOH_CONFIG_OVERRIDE has `{entry}`: {error}");
        let (key, value) = entry
            .split_once('=')
            .ok_or_else(|| error("expected KEY=VALUE, as in connect/endpoints=[\"tcp/localhost:7447\"]"))?;
        config
            .insert_json5(key, value)
            .map_err(|refusal| error(&describe_error(&refusal)))?;
        if key == "connect/endpoints" {
            value.clone_into(&mut endpoint);
        }
    }
    Ok((config, endpoint))
}

/// Parses addresses separated by commas.
fn endpoints(key: &str, text: &str) -> Result<Vec<EndPoint>, String> {
    let addresses = text
        .split(',')
        .map(str::trim)
        .filter(|address| !address.is_empty());
    addresses
        .map(|text| {
            let error = || {
                format!(
                    "{key} = \"{text}\" is not an address; expected tcp/HOST:PORT, tls/HOST:PORT or unixsock-stream/PATH, as in \
                     \"tcp/localhost:7447\""
                )
            };
            let endpoint: EndPoint = text.parse().map_err(|_| error())?;
            let protocol = endpoint.protocol();
            let address = endpoint.address();
            let has_port = protocol.as_str() == "unixsock-stream"
                || address
                    .as_str()
                    .rsplit_once(':')
                    .is_some_and(|(host, port)| !host.is_empty() && port.parse::<u16>().is_ok());
            if ENDPOINT_KEYS.contains(&protocol.as_str()) && has_port {
                Ok(endpoint)
            } else {
                Err(error())
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settings<'a>(connect: &'a str, listen: &'a str) -> Settings<'a> {
        Settings {
            config: "",
            connect,
            listen,
            domain: 3,
            namespace: "fleet",
            node: "",
            owner: "one",
            remap: "",
        }
    }

    #[test]
    fn a_node_that_listens_is_a_peer_and_one_that_connects_only_is_a_client() {
        let mode = |connect, listen| {
            let (config, endpoint) = settings(connect, listen).connection_config().unwrap();
            (config.get_json("mode").unwrap(), endpoint)
        };
        assert_eq!(
            mode("tcp/localhost:7448", ""),
            ("\"client\"".to_owned(), "tcp/localhost:7448".to_owned())
        );
        assert_eq!(
            mode("", "tcp/localhost:0"),
            ("\"peer\"".to_owned(), "tcp/localhost:0".to_owned())
        );
        let (config, _) = settings("tcp/a:1, tls/b:2", "tcp/[::1]:3")
            .connection_config()
            .unwrap();
        assert_eq!(
            config.get_json("connect/endpoints").unwrap(),
            "[\"tcp/a:1\",\"tls/b:2\"]"
        );
    }

    #[test]
    fn a_node_at_the_default_router_is_a_peer_on_this_machine_as_one_of_ros_2() {
        for (connect, mode, listen) in [
            (DEFAULT_ROUTER, "\"peer\"", "[\"tcp/localhost:0\"]"),
            ("humble/tcp/localhost:7447", "\"peer\"", "[\"tcp/localhost:0\"]"),
            ("ros2dds/tcp/localhost:7447", "\"client\"", "[]"),
        ] {
            let (config, endpoint) = settings(connect, "").connection_config().unwrap();
            let entry = |key| config.get_json(key).unwrap();
            assert_eq!(
                (entry("mode").as_str(), entry("listen/endpoints").as_str()),
                (mode, listen)
            );
            assert_eq!(entry("connect/endpoints"), "[\"tcp/localhost:7447\"]");
            assert_eq!(endpoint, connect);
        }
    }

    #[test]
    fn an_invalid_address_is_rejected_with_the_expected_format() {
        for address in [
            "localhost:7447",
            "tcp/localhost",
            "tcp/:7447",
            "tcp/a:70000",
            "udp/a:1",
            "tcp",
            "/",
        ] {
            let error = settings(address, "").connection_config().unwrap_err();
            assert!(
                error.contains(address) && error.contains("tcp/HOST:PORT"),
                "{error}"
            );
        }
        assert!(
            settings("", "")
                .connection_config()
                .unwrap_err()
                .contains("no address is set")
        );
    }

    #[test]
    fn a_configuration_file_excludes_other_addresses() {
        let both = Settings {
            config: "zenoh.json5",
            ..settings("tcp/a:1", "")
        };
        assert!(both.connection_config().unwrap_err().contains("either"));
        let missing = Settings {
            config: "no-such-file.json5",
            ..settings(DEFAULT_ROUTER, "")
        };
        assert_eq!(
            missing.connection_config().unwrap_err(),
            "config = \"no-such-file.json5\": No such file or directory (os error 2)"
        );
    }

    #[test]
    fn the_environment_states_the_connection_as_for_rmw_zenoh() {
        let router = stated_connection("", "").unwrap();
        assert_eq!(router.1, "tcp/localhost:7447");
        let (config, endpoint) = stated_connection(
            "",
            r#" connect/endpoints=["tcp/a:1"]; timestamping/enabled=true ;"#,
        )
        .unwrap();
        assert_eq!(endpoint, r#"["tcp/a:1"]"#);
        assert_eq!(config.get_json("connect/endpoints").unwrap(), r#"["tcp/a:1"]"#);
        for wrong in ["mode", "mode=3", "no/such/key=1"] {
            let error = stated_connection("", wrong).unwrap_err();
            assert!(
                error.contains(wrong) && error.contains("ZENOH_CONFIG_OVERRIDE"),
                "{error}"
            );
        }
        assert!(stated_connection("no-such-file.json5", "").is_err());
    }

    #[test]
    fn what_an_address_begins_with_states_the_middleware() {
        for (prefix, middleware) in [
            ("", Middleware::Rmw),
            ("humble/", Middleware::RmwHumble),
            ("ros2dds/", Middleware::Bridge),
        ] {
            let connect = format!("{prefix}tcp/a:1");
            let settings = settings(&connect, "");
            let (config, _) = settings.connection_config().unwrap();
            assert_eq!(config.get_json("connect/endpoints").unwrap(), "[\"tcp/a:1\"]");
            assert_eq!(settings.name().unwrap().middleware, middleware);
        }
        let error = settings("iron/tcp/a:1", "").connection_config().unwrap_err();
        assert!(error.contains("iron/tcp/a:1"), "{error}");
        // One that only listens.
        assert!(settings("humble/", "tcp/localhost:0").connection_config().is_ok());
    }

    #[test]
    fn the_node_has_the_name_of_its_owner_in_its_namespace() {
        let name = settings("", "").name().unwrap();
        assert_eq!((name.domain, name.full().as_str()), (3, "/fleet/one"));
    }

    #[test]
    fn rules_name_a_node_and_its_namespace() {
        let named = |namespace, remap| {
            let settings = Settings {
                namespace,
                remap,
                ..settings("tcp/a:1", "")
            };
            let config = settings.node_config().unwrap();
            let topic = config
                .remaps
                .apply(&config.name, &format!("{}/scan", config.name.namespace));
            (config.name.full(), topic)
        };
        let name = |full: &str, topic: &str| (full.to_owned(), topic.to_owned());
        assert_eq!(named("", "__ns:=/all"), name("/all/one", "/all/scan"));
        assert_eq!(named("own", "__ns:=/all"), name("/own/one", "/own/scan"));
        assert_eq!(named("own", "one:__ns:=/"), name("/one", "/scan"));
        assert_eq!(
            named("own", "one:__node:=two,scan:=~/scan"),
            name("/own/two", "/own/two/scan")
        );
        let wrong = Settings {
            remap: "scan",
            ..settings("tcp/a:1", "")
        };
        assert!(wrong.node_config().unwrap_err().contains("`scan` is not a rule"));
    }
}
