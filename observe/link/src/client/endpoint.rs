//! The short forms of endpoints that people type. It connects to none.

/// Completes an endpoint. Besides `tcp/host:port` it accepts `tcp:host:port`, a bare `host:port`, and a bare host, whose port
/// is 7447.
#[must_use]
pub fn complete_endpoint(text: &str) -> String {
    if text.contains('/') {
        return text.to_owned();
    }
    match text.split_once(':') {
        Some((protocol @ ("tcp" | "tls"), rest)) => format!("{protocol}/{rest}"),
        Some(_) => format!("tcp/{text}"),
        None => format!("tcp/{text}:7447"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_forms_of_endpoints_are_completed() {
        assert_eq!(complete_endpoint("tls/robot2:7447"), "tls/robot2:7447");
        assert_eq!(complete_endpoint("tcp:robot2:7447"), "tcp/robot2:7447");
        assert_eq!(complete_endpoint("robot2:7448"), "tcp/robot2:7448");
        assert_eq!(complete_endpoint("robot2"), "tcp/robot2:7447");
    }
}
