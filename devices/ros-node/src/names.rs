//! Names of ROS 2: validity of topics, namespaces and nodes, and full names of topics. It does not depend on
//! keys.

/// Returns the full name of a topic, such as `/robot/scan`. A name that begins with `/` is full already; any
/// other is relative to the namespace. Returns `None` for an empty name, which switches a topic off.
///
/// # Errors
/// If the name is not valid in ROS 2.
pub fn topic(namespace: &str, name: &str) -> Result<Option<String>, String> {
    if name.is_empty() {
        return Ok(None);
    }
    let full = if name.starts_with('/') {
        name.to_owned()
    } else {
        format!("{namespace}/{name}")
    };
    let tokens = full.strip_prefix('/').unwrap_or(&full);
    if tokens.split('/').all(is_token) {
        return Ok(Some(full));
    }
    Err(format!(
        "`{name}` is not a valid name of a topic; use letters, digits and `_`, with `/` between parts, as in \"scan\" or \"/robot/scan\""
    ))
}

/// Returns a namespace in the form of keys: empty, or such as `/robot`.
///
/// # Errors
/// If the name is not valid in ROS 2.
pub fn namespace(name: &str) -> Result<String, String> {
    let tokens = name.trim_matches('/');
    if tokens.is_empty() {
        return Ok(String::new());
    }
    if tokens.split('/').all(is_token) {
        return Ok(format!("/{tokens}"));
    }
    Err(format!(
        "namespace = \"{name}\": use letters, digits and `_`, with `/` between parts, as in \"robot\""
    ))
}

/// Returns the name of a node: the one given, or its owner's name adapted to the rules of ROS 2.
///
/// # Errors
/// If the name is not valid in ROS 2.
pub fn node(name: &str, owner: &str) -> Result<String, String> {
    if name.is_empty() {
        let adapt = |letter: char| {
            if letter.is_ascii_alphanumeric() {
                letter
            } else {
                '_'
            }
        };
        let adapted: String = owner.chars().map(adapt).collect();
        return Ok(if adapted.starts_with(|first: char| first.is_ascii_digit()) {
            format!("_{adapted}")
        } else {
            adapted
        });
    }
    if is_token(name) {
        return Ok(name.to_owned());
    }
    Err(format!(
        "node = \"{name}\": use letters, digits and `_`, as in \"pioneer\""
    ))
}

/// Returns the domain: the number given, or the environment's ROS_DOMAIN_ID, or 0.
///
/// # Errors
/// If the environment's value is not a number from 0 to 232.
pub fn domain(number: i32, environment: Option<&str>) -> Result<u32, String> {
    if let Ok(number) = u32::try_from(number) {
        return Ok(number);
    }
    let text = environment.map_or("", str::trim);
    if text.is_empty() {
        return Ok(0);
    }
    match text.parse() {
        Ok(domain) if domain <= 232 => Ok(domain),
        Ok(_) | Err(_) => Err(format!(
            "the environment has ROS_DOMAIN_ID={text}; expected a number from 0 to 232"
        )),
    }
}

fn is_token(token: &str) -> bool {
    let mut letters = token.chars();
    letters
        .next()
        .is_some_and(|first| first.is_ascii_alphabetic() || first == '_')
        && letters.all(|letter| letter.is_ascii_alphanumeric() || letter == '_')
        && !token.contains("__")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_topic_is_relative_to_the_namespace_unless_it_begins_with_a_slash() {
        let full = |namespace, name| topic(namespace, name).unwrap().unwrap();
        assert_eq!(full("", "scan"), "/scan");
        assert_eq!(full("/robot", "front/scan"), "/robot/front/scan");
        assert_eq!(full("/robot", "/scan"), "/scan");
        assert_eq!(topic("/robot", ""), Ok(None));
    }

    #[test]
    fn invalid_names_are_rejected() {
        for name in [
            "/", "a b", "a//b", "scan/", "2d", "a__b", "sc*n", "a$b", "#", "?", "@",
        ] {
            assert!(topic("", name).is_err(), "{name}");
        }
        assert!(namespace("a b").is_err());
        assert!(node("a/b", "x").is_err());
    }

    #[test]
    fn a_namespace_begins_with_one_slash() {
        for name in ["robot", "/robot", "/robot/"] {
            assert_eq!(namespace(name), Ok("/robot".to_owned()));
        }
        assert_eq!(namespace("/"), Ok(String::new()));
    }

    #[test]
    fn a_node_without_a_name_has_that_of_its_owner() {
        assert_eq!(node("", "ros-topics"), Ok("ros_topics".to_owned()));
        assert_eq!(node("", "2"), Ok("_2".to_owned()));
        assert_eq!(node("jde", "x"), Ok("jde".to_owned()));
    }

    #[test]
    fn the_domain_is_from_the_setting_then_the_environment_then_0() {
        assert_eq!(domain(7, Some("3")), Ok(7));
        assert_eq!(domain(-1, Some(" 3 ")), Ok(3));
        assert_eq!(domain(-1, Some("")), Ok(0));
        assert_eq!(domain(-1, None), Ok(0));
        assert!(
            domain(-1, Some("many"))
                .unwrap_err()
                .contains("ROS_DOMAIN_ID=many")
        );
        assert!(domain(-1, Some("233")).is_err());
    }
}
