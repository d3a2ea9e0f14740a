//! Foxglove's protocol with real processes and sockets: who gets in, what a client sees, sets and calls, what nonsense ends, and
//! what a client misses that does not read.

mod hostile;
mod seen;

use std::io::Write as _;
use std::net::TcpStream;

use serde_json::{Value, json};
use tungstenite::client::ClientRequestBuilder;
use tungstenite::{Message, WebSocket};

use crate::page::PageRun;

/// A client.
struct Client {
    socket: WebSocket<TcpStream>,
    channels: Vec<Value>,
    services: Vec<Value>,
}

/// What arrives.
enum Arrival {
    Text(Value),
    Time(u64),
    Message {
        subscription: u32,
        time: u64,
        data: Vec<u8>,
    },
    /// The answer to a call.
    Response(Value),
    Close,
}

/// Opens a connection. Returns the status of a refusal and its words.
fn connect(
    run: &PageRun,
    query: &str,
    protocol: Option<&str>,
    origin: Option<&str>,
) -> Result<Client, (u16, String)> {
    let stream = TcpStream::connect(run.host()).expect("the page listens");
    let address = format!("ws://{}/foxglove{query}", run.host());
    let mut request = ClientRequestBuilder::new(address.parse().expect("an address"));
    if let Some(protocol) = protocol {
        request = request.with_sub_protocol(protocol);
    }
    if let Some(origin) = origin {
        request = request.with_header("Origin", origin);
    }
    match tungstenite::client(request, stream) {
        Ok((socket, answer)) => {
            let chosen = answer.headers().get("Sec-WebSocket-Protocol");
            assert_eq!(chosen.map(|name| name.to_str().expect("text")), protocol);
            Ok(Client {
                socket,
                channels: Vec::new(),
                services: Vec::new(),
            })
        }
        Err(tungstenite::HandshakeError::Failure(tungstenite::Error::Http(answer))) => {
            let words = answer.body().clone().unwrap_or_default();
            Err((answer.status().as_u16(), String::from_utf8(words).expect("text")))
        }
        Err(error) => panic!("{error}"),
    }
}

/// Enters with a token. Returns what the server says of itself, too.
fn enter(run: &PageRun, token: &str) -> (Client, Value) {
    let query = format!("?token={token}&name=ana");
    let mut client =
        connect(run, &query, Some("foxglove.websocket.v1"), None).expect("a token and a protocol");
    let info = client.next("serverInfo");
    client.channels = client.next("advertise")["channels"]
        .as_array()
        .expect("a list")
        .clone();
    if info["capabilities"]
        .as_array()
        .is_some_and(|all| all.contains(&json!("services")))
    {
        client.services = client.next("advertiseServices")["services"]
            .as_array()
            .expect("a list")
            .clone();
    }
    (client, info)
}

impl Client {
    fn say(&mut self, message: &Value) {
        self.send(Message::text(message.to_string()));
    }

    fn send(&mut self, message: Message) {
        self.socket.send(message).expect("it is sent");
    }

    /// Sends the bytes of a frame, whatever they are.
    fn frame(&mut self, first: u8, payload: &[u8]) {
        let mut frame = vec![first, 0x80 | 127];
        frame.extend((payload.len() as u64).to_be_bytes());
        // The mask that changes nothing.
        frame.extend([0; 4]);
        frame.extend(payload);
        self.socket.get_mut().write_all(&frame).expect("it is sent");
    }

    fn read(&mut self) -> Arrival {
        loop {
            match self.socket.read().expect("the socket is open") {
                Message::Text(text) => return Arrival::Text(serde_json::from_str(&text).expect("JSON")),
                Message::Binary(bytes) => return binary(&bytes),
                Message::Close(_) => return Arrival::Close,
                Message::Ping(_) | Message::Pong(_) | Message::Frame(_) => {}
            }
        }
    }

    /// Reads up to the next message of a kind.
    fn next(&mut self, op: &str) -> Value {
        loop {
            if let Arrival::Text(message) = self.read()
                && message["op"] == op
            {
                return message;
            }
        }
    }

    /// Reads up to a status message of the level error. Returns its words.
    fn refused(&mut self) -> String {
        let status = self.next("status");
        assert_eq!(status["level"], 2, "{status}");
        status["message"].as_str().expect("words").to_owned()
    }

    fn channel(&self, topic: &str) -> u64 {
        let found = self.channels.iter().find(|channel| channel["topic"] == topic);
        found.unwrap_or_else(|| panic!("{topic} is no channel"))["id"]
            .as_u64()
            .expect("a number")
    }

    fn subscribe(&mut self, id: u32, topic: &str) {
        let channel = self.channel(topic);
        self.say(&json!({ "op": "subscribe", "subscriptions": [{ "id": id, "channelId": channel }] }));
    }

    /// Reads up to the next message of a subscription.
    fn message(&mut self, wanted: u32) -> (u64, Vec<u8>) {
        loop {
            if let Arrival::Message {
                subscription,
                time,
                data,
            } = self.read()
                && subscription == wanted
            {
                return (time, data);
            }
        }
    }

    /// Asks for parameters.
    fn parameters(&mut self, names: &[&str]) -> Value {
        self.say(&json!({ "op": "getParameters", "parameterNames": names, "id": "get" }));
        self.values("get")
    }

    fn values(&mut self, id: &str) -> Value {
        loop {
            let mut values = self.next("parameterValues");
            if values["id"] == id {
                return values["parameters"].take();
            }
        }
    }

    fn set(&mut self, name: &str, value: &Value) {
        self.say(
            &json!({ "op": "setParameters", "parameters": [{ "name": name, "value": value }], "id": "set" }),
        );
    }

    /// Calls a service. Returns the answer, or the reason of a failure.
    fn call(&mut self, service: u32, payload: &str) -> Result<Value, String> {
        let mut bytes = vec![2];
        for number in [service, 7, 4] {
            bytes.extend(number.to_le_bytes());
        }
        bytes.extend(b"json");
        bytes.extend(payload.as_bytes());
        self.send(Message::binary(bytes));
        loop {
            match self.read() {
                Arrival::Response(answer) => return Ok(answer),
                Arrival::Text(text) if text["op"] == "serviceCallFailure" => {
                    assert_eq!(
                        (&text["serviceId"], &text["callId"]),
                        (&json!(service), &json!(7))
                    );
                    return Err(text["message"].to_string());
                }
                Arrival::Text(_) | Arrival::Time(_) | Arrival::Message { .. } => {}
                Arrival::Close => panic!("the socket ends"),
            }
        }
    }

    fn call_named(&mut self, service: &str, payload: &str) -> Result<Value, String> {
        let number = self.services.iter().position(|known| known["name"] == service);
        self.call(number.expect("it is advertised") as u32, payload)
    }
}

fn binary(bytes: &[u8]) -> Arrival {
    let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().expect("4 bytes"));
    let time = |at: usize| u64::from_le_bytes(bytes[at..at + 8].try_into().expect("8 bytes"));
    match bytes[0] {
        1 => Arrival::Message {
            subscription: word(1),
            time: time(5),
            data: bytes[13..].to_vec(),
        },
        2 => Arrival::Time(time(1)),
        3 => {
            assert_eq!((word(5), word(9), &bytes[13..17]), (7, 4, &b"json"[..]));
            Arrival::Response(serde_json::from_slice(&bytes[17..]).expect("JSON"))
        }
        other => panic!("{other} is no kind of message"),
    }
}
