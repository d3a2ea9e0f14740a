//! Who is refused, what nonsense ends, and what a client misses that does not read.

use std::io::Write as _;

use jde_log::record;
use jde_records::{RecordKind, RunRecord};
use serde_json::Value;
use tungstenite::Message;

use super::{Arrival, connect, enter};
use crate::attached::Sandbox;
use crate::page::PageRun;
use crate::support::{app, pair};

#[test]
fn clients_need_a_token_a_protocol_and_no_foreign_origin() {
    let sandbox = Sandbox::new();
    let file = sandbox.folder().join("page.toml");
    std::fs::write(&file, "origins = [\"https://app.foxglove.dev\"]").expect("a file");
    let option = format!("--web={}", file.display());
    let run = PageRun::start(&sandbox, &pair(), &[&option]);
    let (token, protocol) = (format!("?token={}", run.token), Some("foxglove.sdk.v1"));
    for origin in [None, Some(run.origin.as_str()), Some("https://app.foxglove.dev")] {
        let mut client = connect(&run, &token, protocol, origin).expect("it may enter");
        client.next("serverInfo");
    }
    let refused = |query: &str, protocol, origin| {
        connect(&run, query, protocol, origin)
            .err()
            .expect("it is refused")
    };
    for origin in [
        "null",
        "file://",
        "http://evil.example",
        "https://app.foxglove.dev.evil.example",
    ] {
        let (status, words) = refused(&token, protocol, Some(origin));
        assert!(status == 403 && words.contains("origins"), "{origin}: {words}");
    }
    for protocol in [None, Some("foxglove.websocket.v2")] {
        let (status, words) = refused(&token, protocol, None);
        assert!(
            status == 400 && words.contains("foxglove.websocket.v1"),
            "{words}"
        );
    }
    for query in ["", "?token=", "?token=abcdefghijkmnpqrstuvwxyz"] {
        let (status, words) = refused(query, protocol, None);
        assert!(status == 401 && words.contains("token"), "{query}: {words}");
    }
    // The page's own socket is no wider than before, and the layout is for those with a token.
    let host = run.host();
    let rebound = run.ask(&format!(
        "GET /foxglove{token} HTTP/1.1\nHost: evil.example{}\n\n",
        &host[9..]
    ));
    assert!(rebound.starts_with("HTTP/1.1 403"), "{rebound}");
    let layout = |query: &str| {
        run.ask(&format!(
            "GET /foxglove-layout.json{query} HTTP/1.1\nHost: {host}\n\n"
        ))
    };
    assert!(layout("").starts_with("HTTP/1.1 401"));
    let answer = layout(&token);
    let (_, body) = answer.split_once("\r\n\r\n").expect("a body");
    let layout: Value = serde_json::from_str(body).expect("JSON");
    let path = &layout["configById"]["StateTransitions!states"]["paths"][0]["value"];
    assert_eq!(path, "/jde/states{schema==\"listener\"}.to_state");
}

#[test]
fn nonsense_ends_nothing_but_itself() {
    let sandbox = Sandbox::new();
    let run = PageRun::start(&sandbox, &pair(), &["--web"]);
    let (mut client, _) = enter(&run, &run.token);
    for text in [
        "null",
        "[]",
        "{}",
        "7",
        "",
        r#"{"op": "unload"}"#,
        r#"{"op": "advertise", "channels": [{"id": 1, "topic": "/cmd_vel", "encoding": "cdr", "schemaName": "x"}]}"#,
        r#"{"op": "fetchAsset", "uri": "file:///etc/passwd", "requestId": 1}"#,
        r#"{"op": "subscribeConnectionGraph"}"#,
        r#"{"op": "subscribe", "subscriptions": [{"id": 0, "channelId": 100000}]}"#,
        r#"{"op": "unsubscribe", "subscriptionIds": [5]}"#,
    ] {
        client.send(Message::text(text));
        assert!(!client.refused().is_empty(), "{text}");
    }
    for bytes in [
        &[][..],
        &[1, 0, 0, 0, 0, 0],
        &[2, 0, 0],
        &[2, 0, 0, 0, 0, 0, 0, 0, 0, 0xff, 0xff, 0xff, 0xff],
        &[77],
    ] {
        client.send(Message::binary(bytes.to_vec()));
        assert!(!client.refused().is_empty(), "{bytes:?}");
    }
    client.frame(0x81, &[0xc3, 0x28]);
    assert!(client.refused().contains("UTF-8"));
    client.frame(0x81, &vec![b'x'; 20 << 20]);
    assert!(client.refused().contains("longer than"));
    client.frame(0x83, b"a frame of no kind");
    assert!(client.refused().contains("no meaning"));
    // The same channel twice, and the same number twice.
    client.subscribe(0, "/talker/count");
    client.subscribe(1, "/talker/count");
    assert!(client.refused().contains("/talker/count"));
    client.subscribe(0, "/jde/states");
    assert!(client.refused().contains('0'));
    client.message(0);
    assert_eq!(client.parameters(&["listener.period"])[0]["value"], 0.1);
    // A client that vanishes within a frame takes nothing along.
    let (mut other, _) = enter(&run, &run.token);
    other
        .socket
        .get_mut()
        .write_all(&[0x81, 0xff, 0, 0])
        .expect("it is sent");
    drop(other);
    client.message(0);
}

#[test]
fn a_client_that_does_not_read_delays_nobody_and_gets_the_newest_later() {
    let sandbox = Sandbox::new();
    let run = PageRun::start(&sandbox, &app("flood.toml"), &["--web"]);
    let (mut unread, _) = enter(&run, &run.token);
    let (mut client, _) = enter(&run, &run.token);
    for socket in [&mut unread, &mut client] {
        socket.subscribe(0, "/a/count");
        socket.subscribe(1, "/camera/image");
        socket.subscribe(2, "/jde/decisions");
        for (id, topic) in [(3, "/b/count"), (4, "/c/count"), (5, "/d/count")] {
            socket.subscribe(id, topic);
        }
    }
    let number = |data: &[u8]| match record::decode(RecordKind::Decision, data) {
        Ok(RunRecord::Decision(decision)) => decision.number,
        other => panic!("{other:?}"),
    };
    let (mut counts, mut images, mut last, mut decided) = (0_u32, 0, 0, Vec::new());
    while counts < 2000 || images < 100 {
        if let Arrival::Message {
            subscription,
            time,
            data,
        } = client.read()
        {
            match subscription {
                0 => (counts, last) = (counts + 1, time),
                1 => {
                    images += 1;
                    // It sends, so it is not taken for gone.
                    unread.send(Message::Ping(Vec::new().into()));
                }
                2 => decided.push(number(&data)),
                _ => {}
            }
        }
    }
    // Of values it gets the newest; no decision is left out.
    let (mut stale, mut newest, mut left_out) = (0_u32, 0, false);
    while newest < last || !left_out || !decided.is_empty() {
        match unread.read() {
            Arrival::Message {
                subscription: 0,
                time,
                ..
            } => {
                stale += u32::from(time < last);
                newest = time;
            }
            Arrival::Message {
                subscription: 2,
                data,
                ..
            } => {
                let number = number(&data);
                decided.retain(|decided| *decided != number);
            }
            Arrival::Text(status) if status["id"] == "left-out" => {
                let words = status["message"].as_str().expect("words");
                left_out = words.contains("of /camera/image") || words.contains("of /a/count");
            }
            Arrival::Message { .. } | Arrival::Text(_) | Arrival::Time(_) | Arrival::Response(_) => {}
            Arrival::Close => panic!("the socket ends"),
        }
    }
    assert!(stale * 2 < counts, "{stale} old values of {counts}");
}
