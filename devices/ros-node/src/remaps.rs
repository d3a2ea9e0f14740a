//! Rules that replace names of topics and services, as `--ros-args -r FROM:=TO` states them; in the form of
//! <https://design.ros2.org/articles/static_remapping.html>.

use std::str::FromStr;

use crate::keys::NodeName;
use crate::names;

/// Rules, of which the first that fits a name replaces it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Remaps(Vec<Rule>);

/// A rule: `FROM:=TO`, or `NODE:FROM:=TO` for one node.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Rule {
    node: Option<String>,
    from: From,
    to: String,
}

/// What a rule replaces.
#[derive(Clone, Debug, PartialEq, Eq)]
enum From {
    Node,
    Namespace,
    Name(String),
}

impl Remaps {
    /// Adds the rules of others after these.
    pub fn extend(&mut self, others: Self) {
        self.0.extend(others.0);
    }

    /// Returns the name that the rules give to a node; `None` if none does.
    #[must_use]
    pub fn node(&self, node: &str) -> Option<&str> {
        self.find(node, &From::Node).map(|rule| rule.to.as_str())
    }

    /// Returns the namespace that the rules give to a node, and whether the rule is for that node alone; `None` if none
    /// does.
    #[must_use]
    pub fn namespace(&self, node: &str) -> Option<(&str, bool)> {
        let rule = self.find(node, &From::Namespace)?;
        Some((&rule.to, rule.node.is_some()))
    }

    /// Returns the rules without those that name any node.
    #[must_use]
    pub fn without_names_of_all(&self) -> Self {
        let names_all = |rule: &&Rule| rule.from == From::Node && rule.node.is_none();
        Self(self.0.iter().filter(|rule| !names_all(rule)).cloned().collect())
    }

    /// Returns the full name that replaces the full name of a topic, a service, or a part of an action.
    #[must_use]
    pub fn apply(&self, node: &NodeName, full: &str) -> String {
        // The rules name an action, and not its services and topics.
        let (full, part) = full.split_at(full.find("/_action/").unwrap_or(full.len()));
        let fits = |rule: &&Rule| match &rule.from {
            From::Name(from) => rule.is_of(&node.node) && expand(from, node) == full,
            From::Node | From::Namespace => false,
        };
        match self.0.iter().find(fits) {
            Some(rule) => expand(&rule.to, node) + part,
            None => full.to_owned() + part,
        }
    }

    fn find(&self, node: &str, from: &From) -> Option<&Rule> {
        self.0.iter().find(|rule| rule.from == *from && rule.is_of(node))
    }
}

impl Rule {
    fn is_of(&self, node: &str) -> bool {
        self.node.as_ref().is_none_or(|own| own == node)
    }
}

/// Returns the full name of a full, private or relative one.
fn expand(name: &str, node: &NodeName) -> String {
    match name.strip_prefix('~') {
        Some(rest) => node.full() + rest,
        None if name.starts_with('/') => name.to_owned(),
        None => format!("{}/{name}", node.namespace),
    }
}

impl FromStr for Remaps {
    type Err = String;

    /// Parses rules with commas between them.
    fn from_str(text: &str) -> Result<Self, String> {
        let rules = text.split(',').map(str::trim).filter(|rule| !rule.is_empty());
        rules.map(str::parse).collect::<Result<_, _>>().map(Self)
    }
}

impl FromStr for Rule {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (left, to) = text
            .split_once(":=")
            .ok_or_else(|| format!("`{text}` is not a rule; expected FROM:=TO, or NODE:FROM:=TO"))?;
        let (node, from) = match left.split_once(':') {
            Some((node, from)) => (Some(names::node(node, "")?), from),
            None => (None, left),
        };
        let wrong = |error| format!("`{text}`: {error}");
        if to.is_empty() {
            return Err(wrong("the new name is missing".to_owned()));
        }
        let (from, to) = match from {
            "__node" | "__name" => (From::Node, names::node(to, "").map_err(wrong)?),
            "__ns" => (From::Namespace, names::namespace(to).map_err(wrong)?),
            from => {
                for name in [from, to] {
                    let tokens = name.strip_prefix("~/").unwrap_or(name);
                    match names::topic("", tokens) {
                        Ok(Some(_)) if tokens.len() == name.len() || !tokens.starts_with('/') => {}
                        Ok(_) => return Err(wrong(format!("`{name}` is not a name"))),
                        Err(error) => return Err(wrong(error)),
                    }
                }
                (From::Name(from.to_owned()), to.to_owned())
            }
        };
        Ok(Self { node, from, to })
    }
}

impl std::fmt::Display for Remaps {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        for (place, Rule { node, from, to }) in self.0.iter().enumerate() {
            if place > 0 {
                f.write_str(",")?;
            }
            if let Some(node) = node {
                write!(f, "{node}:")?;
            }
            let from = match from {
                From::Node => "__node",
                From::Namespace => "__ns",
                From::Name(name) => name,
            };
            let root = if to.is_empty() { "/" } else { "" };
            write!(f, "{from}:={to}{root}")?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::keys::Middleware;

    fn node() -> NodeName {
        NodeName {
            domain: 0,
            middleware: Middleware::Rmw,
            namespace: "/fleet".to_owned(),
            node: "scout".to_owned(),
        }
    }

    fn applied(rules: &str, full: &str) -> String {
        let remaps: Remaps = rules.parse().unwrap();
        assert_eq!(remaps.to_string().parse(), Ok(remaps.clone()), "{remaps}");
        remaps.apply(&node(), full)
    }

    #[test]
    fn full_relative_and_private_names_are_replaced() {
        for (rule, full, expected) in [
            ("scan:=front", "/fleet/scan", "/fleet/front"),
            ("scan:=/front", "/fleet/scan", "/front"),
            ("/scan:=scan", "/scan", "/fleet/scan"),
            ("scan:=front", "/scan", "/scan"),
            ("~/stop:=halt", "/fleet/scout/stop", "/fleet/halt"),
            ("scan:=~/scan", "/fleet/scan", "/fleet/scout/scan"),
            ("a/b:=c/d", "/fleet/a/b", "/fleet/c/d"),
            (
                "dock:=/own/dock",
                "/fleet/dock/_action/send_goal",
                "/own/dock/_action/send_goal",
            ),
        ] {
            assert_eq!(applied(rule, full), expected, "{rule}");
        }
    }

    #[test]
    fn the_first_rule_that_fits_counts_once_and_a_rule_may_be_of_one_node() {
        assert_eq!(applied("scan:=a, scan:=b, a:=c", "/fleet/scan"), "/fleet/a");
        assert_eq!(applied("other:scan:=a", "/fleet/scan"), "/fleet/scan");
        assert_eq!(applied("other:scan:=a,scout:scan:=b", "/fleet/scan"), "/fleet/b");
    }

    #[test]
    fn a_node_gets_its_names_by_rules() {
        let remaps: Remaps = "topics:__node:=bridge,__ns:=/,__node:=all,topics:__ns:=/own"
            .parse()
            .unwrap();
        assert_eq!(remaps.node("topics"), Some("bridge"));
        assert_eq!(remaps.node("other"), Some("all"));
        assert_eq!(remaps.without_names_of_all().node("other"), None);
        assert_eq!(remaps.namespace("other"), Some(("", false)));
        let reversed: Remaps = "topics:__ns:=own,__ns:=/all".parse().unwrap();
        assert_eq!(reversed.namespace("topics"), Some(("/own", true)));
        assert_eq!(Remaps::default().namespace("topics"), None);
    }

    #[test]
    fn what_is_no_rule_is_refused() {
        for rule in [
            "scan",
            "scan=front",
            "scan:=",
            ":=scan",
            "a:b:c:=d",
            "a b:=c",
            "~//a:=b",
            "~:=b",
            "rostopic://a:=b",
            "a:=b c",
            "__node:=a/b",
            "__ns:=a b",
            "a b:scan:=c",
        ] {
            let error = rule.parse::<Remaps>().unwrap_err();
            assert!(error.contains('`'), "{rule}: {error}");
        }
    }
}
