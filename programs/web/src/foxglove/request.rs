//! What a client may ask for. Whatever else it sends is answered in words, and ends nothing.

use serde::Deserialize;
use serde_json::Value;

/// A message of a client in JSON.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(tag = "op", rename_all = "camelCase", rename_all_fields = "camelCase")]
pub(super) enum Request {
    Subscribe {
        subscriptions: Vec<Subscription>,
    },
    Unsubscribe {
        subscription_ids: Vec<u32>,
    },
    /// Asks for these parameters, or for all.
    GetParameters {
        parameter_names: Vec<String>,
        id: Option<String>,
    },
    SetParameters {
        parameters: Vec<Parameter>,
        id: Option<String>,
    },
    /// Wants to know changes of these parameters, or of all.
    SubscribeParameterUpdates {
        parameter_names: Vec<String>,
    },
    UnsubscribeParameterUpdates {
        parameter_names: Vec<String>,
    },
}

/// A channel that a client wants, by a number of its own.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Subscription {
    pub(super) id: u32,
    pub(super) channel_id: u32,
}

/// A value for a parameter; without one, the parameter is to be removed.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub(super) struct Parameter {
    pub(super) name: String,
    #[serde(default)]
    pub(super) value: Value,
}

/// The call of a service.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Call {
    pub(super) service: u32,
    pub(super) number: u32,
    pub(super) encoding: String,
    pub(super) payload: Vec<u8>,
}

impl Request {
    /// Reads a message.
    ///
    /// # Errors
    /// It is none, in words.
    pub(super) fn read(text: &str) -> Result<Self, String> {
        let refuse = |why: String| format!("the message is not understood: {why}");
        serde_json::from_str(text).map_err(|error| refuse(error.to_string()))
    }

    /// Returns how many things it asks for.
    pub(super) fn cost(&self) -> usize {
        1 + match self {
            Self::Subscribe { subscriptions } => subscriptions.len(),
            Self::SetParameters { parameters, .. } => parameters.len(),
            Self::Unsubscribe { subscription_ids } => subscription_ids.len(),
            Self::GetParameters { parameter_names, .. }
            | Self::SubscribeParameterUpdates { parameter_names }
            | Self::UnsubscribeParameterUpdates { parameter_names } => parameter_names.len(),
        }
    }
}

impl Call {
    /// Reads a message in binary.
    ///
    /// # Errors
    /// It is no call, in words.
    pub(super) fn read(bytes: &[u8]) -> Result<Self, String> {
        let ends = || "the call of a service ends early".to_owned();
        match bytes.first() {
            Some(2) => {}
            Some(1) => return Err("messages are not taken: the robot is driven on its page".to_owned()),
            Some(other) => return Err(format!("messages of the kind {other} are not understood")),
            None => return Err("the message is empty".to_owned()),
        }
        let mut rest = &bytes[1..];
        let mut number = || {
            let (first, others) = rest.split_first_chunk()?;
            rest = others;
            Some(u32::from_le_bytes(*first))
        };
        let (service, call, length) = (number(), number(), number());
        let (service, call, length) = (
            service.ok_or_else(ends)?,
            call.ok_or_else(ends)?,
            length.ok_or_else(ends)?,
        );
        let (encoding, payload) = rest.split_at_checked(length as usize).ok_or_else(ends)?;
        Ok(Self {
            service,
            number: call,
            encoding: String::from_utf8_lossy(encoding).into_owned(),
            payload: payload.to_vec(),
        })
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn messages_are_read_whole_or_not_at_all() {
        let subscribe = r#"{"op": "subscribe", "subscriptions": [{"id": 0, "channelId": 3}], "later": 1}"#;
        let subscription = Subscription { id: 0, channel_id: 3 };
        assert_eq!(
            Request::read(subscribe),
            Ok(Request::Subscribe {
                subscriptions: vec![subscription]
            })
        );
        let set = Request::read(
            r#"{"op": "setParameters", "parameters": [{"name": "goon.fast", "value": 0.3}, {"name": "a"}]}"#,
        );
        assert!(matches!(set, Ok(Request::SetParameters { parameters, id: None })
            if parameters[0].value == json!(0.3) && parameters[1].value.is_null()));
        for wrong in [
            "",
            "null",
            "[]",
            "{}",
            "7",
            r#"{"op": 1}"#,
            r#"{"op": "unload"}"#,
            r#"{"op": "advertise", "channels": []}"#,
            r#"{"op": "fetchAsset", "uri": "file:///etc/passwd", "requestId": 1}"#,
            r#"{"op": "subscribe"}"#,
            r#"{"op": "subscribe", "subscriptions": [{"id": -1, "channelId": 3}]}"#,
            r#"{"op": "subscribe", "subscriptions": [{"id": 0, "channelId": 1e99}]}"#,
        ] {
            assert!(Request::read(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_call_that_is_cut_anywhere_is_none() {
        let mut bytes = vec![2];
        for number in [7_u32, 9, 4] {
            bytes.extend(number.to_le_bytes());
        }
        bytes.extend(b"json{}");
        let call = Call::read(&bytes).unwrap();
        assert_eq!(
            (call.service, call.number, call.encoding.as_str()),
            (7, 9, "json")
        );
        assert_eq!(call.payload, b"{}");
        for length in 0..bytes.len() - 2 {
            assert!(Call::read(&bytes[..length]).is_err(), "{length}");
        }
        let mut long = bytes;
        long[9..13].copy_from_slice(&u32::MAX.to_le_bytes());
        assert!(Call::read(&long).is_err());
        assert!(Call::read(&[1, 0, 0, 0, 0]).is_err() && Call::read(&[9]).is_err());
    }
}
