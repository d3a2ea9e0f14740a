//! Who may open a connection: a client that shows a token of the page in its address, and speaks a protocol that the robot
//! speaks. Nobody without both gets a socket.

use crate::settings::Right;
use crate::token::Tokens;

/// The path of the connection.
pub(crate) const PATH: &str = "/foxglove";
/// The path of the layout.
pub(crate) const LAYOUT: &str = "/foxglove-layout.json";
/// The names of the protocol. Their messages are the same, as far as the robot uses them.
const PROTOCOLS: [&str; 2] = ["foxglove.websocket.v1", "foxglove.sdk.v1"];
/// The name of a person who states none.
const NOBODY: &str = "foxglove";

/// Somebody who may enter.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Guest {
    pub(crate) right: Right,
    pub(super) name: String,
}

/// Returns who shows the token in a query.
pub(crate) fn admit(query: &str, tokens: &Tokens) -> Option<Guest> {
    let value = |key: &str| {
        query
            .split('&')
            .find_map(|pair| pair.strip_prefix(key)?.strip_prefix('='))
    };
    let right = tokens.right(value("token")?)?;
    let name = value("name").unwrap_or(NOBODY).to_owned();
    Some(Guest { right, name })
}

/// Returns the first protocol of a list that the robot speaks.
pub(crate) fn protocol(offered: &str) -> Option<&'static str> {
    let mut offered = offered.split(',').map(str::trim);
    offered.find_map(|name| PROTOCOLS.into_iter().find(|known| *known == name))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_token_in_the_query_gives_its_right_and_a_name_goes_with_it() {
        let tokens = Tokens::new(Right::Operate).unwrap();
        let (read, operate) = (
            tokens.of(Right::Read).unwrap(),
            tokens.of(Right::Operate).unwrap(),
        );
        let guest = |right, name: &str| {
            Some(Guest {
                right,
                name: name.to_owned(),
            })
        };
        assert_eq!(
            admit(&format!("token={read}"), &tokens),
            guest(Right::Read, NOBODY)
        );
        let named = format!("name=ana&token={operate}");
        assert_eq!(admit(&named, &tokens), guest(Right::Operate, "ana"));
        for wrong in [
            "",
            "token",
            "token=",
            "tokens=x",
            operate,
            &format!("Token={operate}"),
        ] {
            assert_eq!(admit(wrong, &tokens), None, "{wrong}");
        }
    }

    #[test]
    fn the_first_protocol_that_both_speak_is_chosen() {
        assert_eq!(
            protocol("foxglove.sdk.v1, foxglove.websocket.v1"),
            Some("foxglove.sdk.v1")
        );
        assert_eq!(
            protocol("rosbridge,foxglove.websocket.v1"),
            Some("foxglove.websocket.v1")
        );
        assert_eq!((protocol(""), protocol("foxglove.sdk.v2")), (None, None));
    }
}
