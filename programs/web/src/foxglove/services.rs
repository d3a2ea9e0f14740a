//! The services: what operators do on the page, with the rights of the address that the client showed. Requests and responses
//! are JSON.

use jde_link::message::Action;
use serde::Deserialize;
use serde_json::{Value, json};

use super::request::Call;

/// The encoding of requests and responses.
pub(super) const ENCODING: &str = "json";

/// A service. Its number is its place.
struct Service {
    name: &'static str,
    doc: &'static str,
    action: fn(String) -> Action,
}

const SERVICES: [Service; 5] = [
    Service {
        name: "/jde/stop_all",
        doc: "Stops everything: every root sleeps, and every command is neutral.",
        action: |_| Action::StopAll,
    },
    Service {
        name: "/jde/release_all",
        doc: "Lets what was stopped with everything go on.",
        action: |_| Action::ReleaseAll,
    },
    Service {
        name: "/jde/play",
        doc: "Wakes a schema as its father would.",
        action: |schema| Action::Play { schema },
    },
    Service {
        name: "/jde/stop",
        doc: "Stops a schema until it is released.",
        action: |schema| Action::Stop { schema },
    },
    Service {
        name: "/jde/release",
        doc: "Undoes what operators did to a schema.",
        action: |schema| Action::Release { schema },
    },
];

/// The request of a service that is about a schema.
#[derive(Deserialize)]
struct Payload {
    schema: String,
}

/// Returns the services as clients get them.
pub(super) fn advertisement() -> Value {
    let services = SERVICES.iter().enumerate().map(|(number, service)| {
        let properties = if is_global(service) {
            json!({})
        } else {
            json!({ "schema": { "type": "string" } })
        };
        let form = |name: &str, properties: Value| {
            let schema = json!({ "type": "object", "title": name, "description": service.doc, "properties": properties });
            json!({
                "encoding": ENCODING,
                "schemaName": name,
                "schemaEncoding": "jsonschema",
                "schema": schema.to_string(),
            })
        };
        json!({
            "id": number,
            "name": service.name,
            "type": service.name,
            "request": form(&format!("{}_Request", service.name), properties),
            "response": form("jde/Response", json!({ "success": { "type": "boolean" }, "message": { "type": "string" } })),
        })
    });
    json!({ "op": "advertiseServices", "services": services.collect::<Vec<_>>() })
}

fn is_global(service: &Service) -> bool {
    (service.action)(String::new()).is_global()
}

/// Returns what a call asks the application for.
///
/// # Errors
/// The call is none of these services, in words.
pub(super) fn action(call: &Call) -> Result<Action, String> {
    let service = SERVICES
        .get(call.service as usize)
        .ok_or("there is no such service")?;
    if is_global(service) {
        // A stop is not refused for its form.
        return Ok((service.action)(String::new()));
    }
    if call.encoding != ENCODING {
        return Err(format!(
            "the request is in `{}`, and only {ENCODING} is understood",
            call.encoding
        ));
    }
    let payload: Payload = serde_json::from_slice(&call.payload)
        .map_err(|error| format!("{} needs {{\"schema\": \"goon\"}}: {error}", service.name))?;
    Ok((service.action)(payload.schema))
}

/// Returns the answer to a call, in binary.
pub(super) fn response(call: &Call, message: &str) -> Vec<u8> {
    let mut bytes = vec![3];
    for number in [call.service, call.number, ENCODING.len() as u32] {
        bytes.extend(number.to_le_bytes());
    }
    bytes.extend(ENCODING.as_bytes());
    bytes.extend(
        json!({ "success": true, "message": message })
            .to_string()
            .into_bytes(),
    );
    bytes
}

/// Returns the refusal of a call.
pub(super) fn failure(call: &Call, reason: &str) -> Value {
    json!({ "op": "serviceCallFailure", "serviceId": call.service, "callId": call.number, "message": reason })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ask(service: u32, payload: &str) -> Result<Action, String> {
        action(&Call {
            service,
            number: 1,
            encoding: ENCODING.to_owned(),
            payload: payload.as_bytes().to_vec(),
        })
    }

    #[test]
    fn calls_become_actions_of_operators() {
        for payload in ["", "{}", "x"] {
            assert_eq!(ask(0, payload), Ok(Action::StopAll), "{payload}");
        }
        let schema = "goon".to_owned();
        assert_eq!(ask(3, r#"{"schema": "goon"}"#), Ok(Action::Stop { schema }));
        for (service, payload) in [
            (3, ""),
            (3, "{}"),
            (3, "null"),
            (3, r#"{"schema": 7}"#),
            (5, "{}"),
        ] {
            assert!(ask(service, payload).is_err(), "{service} {payload}");
        }
    }
}
