//! Errors of Zenoh, for users.

/// Returns the error's text without locations in Zenoh's source.
pub(crate) fn describe_error(error: &zenoh::Error) -> String {
    let text = error.to_string();
    let mut rest = text.as_str();
    let mut result = String::new();
    while let Some((before, after)) = rest.split_once(" at /") {
        result += before.trim_end();
        rest = after.split_once(".rs:").map_or("", |(_, line)| {
            line.trim_start_matches(|letter: char| letter.is_ascii_digit())
                .trim_start_matches('.')
        });
    }
    result += rest;
    // Zenoh gives no other reason if a client finds no router.
    if result.starts_with("Unable to connect to any of") {
        return "no router answers at this address; is it running?".to_owned();
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_described_without_source_locations() {
        let error = |text: &str| describe_error(&zenoh::Error::from(text.to_owned()));
        let port_in_use = "Can not listen: [127.0.0.1:1: Address already in use (os error 98) at /a b/tcp.rs:61.] at /c/unicast.rs:338.";
        assert_eq!(
            error(port_in_use),
            "Can not listen: [127.0.0.1:1: Address already in use (os error 98)]"
        );
        assert_eq!(error("plain"), "plain");
        let unreachable = "Unable to connect to any of [Single(tcp/a:1)]!  at /c/orchestrator.rs:447.";
        assert_eq!(
            error(unreachable),
            "no router answers at this address; is it running?"
        );
        assert_eq!(error("cut at /home/x"), "cut");
    }
}
