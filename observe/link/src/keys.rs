//! The layout of keys, `jde/1/<name>/<id>/...`, for one robot or a fleet. Sends nothing.

use std::fmt;

use jde_records::RecordKind;

/// The version of this protocol, the second part of every key. Both ends must use the same version.
pub const PROTOCOL: u32 = 1;

/// The key at which every application, of any version, replies with its `About`.
pub(crate) const ALL_ABOUT: &str = "jde/*/*/*/about";

/// The queries and publications of an application, below its own key.
pub(crate) const ABOUT: &str = "about";
pub(crate) const ALIVE: &str = "alive";
pub(crate) const SCHEMAS: &str = "schemas";
pub(crate) const VARIABLES: &str = "variables";
pub(crate) const HIERARCHY: &str = "hierarchy";
pub(crate) const OPERATE: &str = "operate";

/// The key at which events of a kind are published and queried.
pub(crate) fn events(kind: RecordKind) -> &'static str {
    match kind {
        RecordKind::Decision => "events/decisions",
        RecordKind::State => "events/states",
        RecordKind::Event => "events/events",
    }
}

/// The key expression for all applications of a name.
pub(crate) fn of_name(name: &str) -> String {
    format!("jde/{PROTOCOL}/{}/*", chunk(name))
}

/// What a client's token is for.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum TokenTarget {
    /// Values of the variable at this path below `var/`: `owner/variable`, escaped as in keys.
    Variable(String),
    /// The panel of this schema, escaped as in keys.
    Panel(String),
}

/// The keys of one application.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Keys {
    root: String,
}

/// How often a client wants a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Rate {
    /// At most this many values per second. Each time the newest value is sent, if it is new.
    Hz(u16),
    /// Every value that the link sees: each at its publication, and none twice.
    Full,
}

/// The supported rates. They are few, so that clients with similar demands share one stream.
const STREAM_RATES: [u16; 7] = [1, 2, 5, 10, 20, 50, 100];

/// The text of [`Rate::Full`] in keys.
const FULL: &str = "full";

impl Keys {
    pub(crate) fn new(name: &str, id: &str) -> Self {
        Self {
            root: format!("jde/{PROTOCOL}/{}/{}", chunk(name), chunk(id)),
        }
    }

    /// A key below the application's own.
    pub(crate) fn of(&self, path: &str) -> String {
        format!("{}/{path}", self.root)
    }

    /// The expression for all keys of the application.
    pub(crate) fn all(&self) -> String {
        self.of("**")
    }

    /// The key at which values of a variable are published at this rate.
    pub(crate) fn values(&self, owner: &str, variable: &str, rate: Rate) -> String {
        format!("{}/{rate}", self.variable(owner, variable))
    }

    /// The key at which the newest value of a variable is queried.
    pub(crate) fn variable(&self, owner: &str, variable: &str) -> String {
        self.of(&format!("var/{}/{}", chunk(owner), chunk(variable)))
    }

    /// The liveliness token by which a client requests values.
    pub(crate) fn value_token(&self, owner: &str, variable: &str, rate: Rate, client: &str) -> String {
        self.of(&format!(
            "want/{}/{}/{rate}/{}",
            chunk(owner),
            chunk(variable),
            chunk(client)
        ))
    }

    /// The key at which the panel of a schema is published at this rate.
    pub(crate) fn panel(&self, schema: &str, rate: Rate) -> String {
        self.of(&format!("panel/{}/{rate}", chunk(schema)))
    }

    /// The liveliness token by which a client requests a panel.
    pub(crate) fn panel_token(&self, schema: &str, rate: Rate, client: &str) -> String {
        self.of(&format!("look/{}/{rate}/{}", chunk(schema), chunk(client)))
    }

    /// The expressions for all tokens of clients.
    pub(crate) fn tokens(&self) -> [String; 2] {
        [self.of("want/**"), self.of("look/**")]
    }

    /// The part of a key below the application's own; none for another application's key.
    pub(crate) fn strip_root<'a>(&self, key: &'a str) -> Option<&'a str> {
        key.strip_prefix(&self.root)?.strip_prefix('/')
    }
}

/// Reads a token: what it requests, and at which rate.
pub(crate) fn parse_token(path: &str) -> Option<(TokenTarget, Rate)> {
    let parts: Vec<&str> = path.splitn(6, '/').collect();
    let (target, rate) = match parts.as_slice() {
        ["want", owner, variable, rate, _client] => {
            (TokenTarget::Variable(format!("{owner}/{variable}")), rate)
        }
        ["look", schema, rate, _client] => (TokenTarget::Panel((*schema).to_owned()), rate),
        _ => return None,
    };
    Some((target, Rate::read(rate)?))
}

/// The path of a variable below `var/` and `want/`.
pub(crate) fn variable_path(owner: &str, variable: &str) -> String {
    format!("{}/{}", chunk(owner), chunk(variable))
}

/// Escapes a name as one part of a key: each byte of a character with a meaning in key expressions becomes
/// `%` and two hexadecimal digits.
pub(crate) fn chunk(name: &str) -> String {
    let mut chunk = String::with_capacity(name.len());
    for letter in name.chars() {
        if "/*$#?%@".contains(letter) || letter.is_control() || letter.is_whitespace() {
            letter
                .encode_utf8(&mut [0; 4])
                .bytes()
                .for_each(|byte| chunk.push_str(&format!("%{byte:02x}")));
        } else {
            chunk.push(letter);
        }
    }
    if chunk.is_empty() {
        chunk.push('%');
    }
    chunk
}

/// Whether a text is a valid name of an application: 1 to 64 letters, digits, `-` and `_`.
#[must_use]
pub fn is_name(name: &str) -> bool {
    let legal = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    (1..=64).contains(&name.len()) && name.chars().all(legal)
}

/// Makes a valid name from any text: the first 64 characters, each invalid one replaced by `-`.
#[must_use]
pub fn as_name(text: &str) -> String {
    let legal = |c: char| {
        if c.is_ascii_alphanumeric() || c == '_' {
            c
        } else {
            '-'
        }
    };
    let name: String = text.trim().chars().take(64).map(legal).collect();
    if name.is_empty() {
        "application".to_owned()
    } else {
        name
    }
}

impl Rate {
    /// The default rate of the tools.
    pub const DEFAULT: Self = Self::Hz(50);

    /// The lowest supported rate of at least this many values per second; [`Self::Full`] beyond 100 Hz.
    #[must_use]
    pub fn at_least(hz: f64) -> Self {
        STREAM_RATES
            .into_iter()
            .find(|rate| f64::from(*rate) >= hz)
            .map_or(Self::Full, Self::Hz)
    }

    /// The time between two values, ns; `None` for [`Self::Full`].
    pub(crate) fn period_ns(self) -> Option<u64> {
        match self {
            Self::Hz(hz) => Some(1_000_000_000 / u64::from(hz.max(1))),
            Self::Full => None,
        }
    }

    /// This rate, or the next higher supported one.
    pub(crate) fn to_supported(self) -> Self {
        match self {
            Self::Hz(hz) => Self::at_least(hz.into()),
            Self::Full => Self::Full,
        }
    }

    fn read(text: &str) -> Option<Self> {
        if text == FULL {
            return Some(Self::Full);
        }
        let hz = text.strip_suffix("hz")?.parse().ok()?;
        STREAM_RATES.contains(&hz).then_some(Self::Hz(hz))
    }
}

impl fmt::Display for Rate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Hz(hz) => write!(f, "{hz}hz"),
            Self::Full => f.write_str(FULL),
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn any_name_is_one_part_of_a_key(name in any::<String>(), other in any::<String>()) {
            let part = chunk(&name);
            let key = format!("jde/{part}/x");
            prop_assert!(zenoh::key_expr::KeyExpr::new(key.as_str()).is_ok(), "{key}");
            prop_assert!(!part.contains('/'));
            prop_assert_eq!(part == chunk(&other), name == other);
        }

        #[test]
        fn a_token_is_read_as_the_request_that_it_was_made_from(owner in "[a-z:]{1,9}", name in "[a-z]{1,9}", hz in 0.0..200.0) {
            let keys = Keys::new("robot2", "ab12");
            let rate = Rate::at_least(hz);
            let key = keys.value_token(&owner, &name, rate, "c1");
            let found = parse_token(keys.strip_root(&key).unwrap());
            prop_assert_eq!(found, Some((TokenTarget::Variable(variable_path(&owner, &name)), rate)));
            let key = keys.panel_token(&owner, rate, "c1");
            let found = parse_token(keys.strip_root(&key).unwrap());
            prop_assert_eq!(found, Some((TokenTarget::Panel(chunk(&owner)), rate)));
        }

        #[test]
        fn reading_a_token_survives_any_text(text in any::<String>()) {
            let _ = parse_token(&text);
        }
    }

    #[test]
    fn rates_are_rounded_to_supported_ones() {
        assert_eq!(Rate::at_least(0.1), Rate::Hz(1));
        assert_eq!(Rate::at_least(11.0), Rate::Hz(20));
        assert_eq!(Rate::at_least(101.0), Rate::Full);
        assert_eq!(Rate::Hz(30).to_supported(), Rate::Hz(50));
        assert_eq!(Rate::read("50hz"), Some(Rate::Hz(50)));
        assert_eq!(Rate::read("51hz"), None);
        assert_eq!(Rate::read("full"), Some(Rate::Full));
    }

    #[test]
    fn names_consist_of_letters_digits_underscores_and_hyphens() {
        assert!(is_name("robot_2-b"));
        assert!(!is_name("robot 2") && !is_name("") && !is_name(&"x".repeat(65)));
        assert_eq!(as_name("safe navigation"), "safe-navigation");
        assert_eq!(as_name("é/"), "--");
        assert_eq!(as_name(""), "application");
    }
}
