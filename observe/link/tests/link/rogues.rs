//! Hostile peers on the network: one without credentials, one with a certificate of a foreign authority, and
//! one that intercepts passwords. None can operate.

use std::net::TcpListener;
use std::sync::mpsc::channel;

use jde_link::{Client, Error, Events, Link, Reach, Tls};
use jde_watchdog::Watchdog;
use zenoh::Wait;

use crate::common::{TIMEOUT, TestRuntime, TestSubject, until};
use crate::network::{Authority, authority, free_address, login, open, play, reach};

/// A Zenoh peer that listens, with or without a certificate, and accepts every connection.
fn rogue(endpoint: &str, certificate: Option<&Authority>, multicast: bool) -> zenoh::Session {
    let mut config = zenoh::Config::default();
    let tls = certificate.map(|authority| {
        let tls = authority.tls(true, false);
        let (certificate, key) = tls.identity.unwrap();
        serde_json::json!({ "listen_certificate": certificate, "listen_private_key": key })
    });
    for (key, value) in [
        ("mode", serde_json::json!("peer")),
        ("listen/endpoints", serde_json::json!([endpoint])),
        ("scouting/multicast/enabled", serde_json::json!(multicast)),
        ("transport/link/tls", tls.unwrap_or(serde_json::json!({}))),
    ] {
        config.insert_json5(key, &value.to_string()).unwrap();
    }
    zenoh::open(config).wait().unwrap()
}

/// Whether the rogue can operate the application that connected to it. Waits for the reply, or until the
/// query ends without one.
fn operates(rogue: &zenoh::Session, id: &str) -> bool {
    let (sender, received) = channel();
    let request = serde_json::to_vec(&play()).unwrap();
    rogue
        .get(format!("jde/1/robot/{id}/operate"))
        .payload(request)
        .callback(move |reply| sender.send(reply.into_result().is_ok()).unwrap_or_default())
        .wait()
        .unwrap();
    received.recv_timeout(TIMEOUT).is_ok_and(|done| done)
}

#[test]
fn an_application_does_not_connect_to_a_peer_without_credentials() {
    let (runtime, files) = (TestRuntime::new(), tempfile::tempdir().unwrap());
    let trusted = authority(files.path(), "trusted");
    let rogue_endpoint = format!("tcp/{}", free_address());
    let rogue = rogue(&rogue_endpoint, None, false);
    let mut settings = runtime.settings("robot");
    settings.connect = vec![rogue_endpoint.clone()];
    // Without TLS neither an authority nor a password authenticates the peer.
    settings.tls = Some(trusted.tls(true, true));
    let error = Link::open(&settings, TestSubject::new(), &Events::of_records())
        .err()
        .unwrap();
    assert!(
        matches!(&error, Error::Unproven { endpoint } if *endpoint == rogue_endpoint),
        "{error}"
    );
    settings.login = Some(login("lab", "secret"));
    let error = Link::open(&settings, TestSubject::new(), &Events::of_records())
        .err()
        .unwrap();
    assert!(matches!(error, Error::PlainPassword { .. }), "{error}");
    // With `insecure` it connects, which proves that this rogue would have succeeded.
    let subject = TestSubject::new();
    (settings.login, settings.insecure) = (None, true);
    let link = Link::open(&settings, subject.clone(), &Events::of_records()).unwrap();
    until("the rogue operates", || operates(&rogue, &link.about().id));
    assert!(!subject.actions().is_empty());
}

#[test]
fn a_peer_of_a_foreign_authority_cannot_operate() {
    let (runtime, files) = (TestRuntime::new(), tempfile::tempdir().unwrap());
    let (trusted, foreign_authority) = (
        authority(files.path(), "trusted"),
        authority(files.path(), "foreign_authority"),
    );
    let [foreign_endpoint, trusted_endpoint] = [(); 2].map(|()| format!("tls/{}", free_address()));
    let (rogue, trusted_peer) = (
        rogue(&foreign_endpoint, Some(&foreign_authority), false),
        rogue(&trusted_endpoint, Some(&trusted), false),
    );
    let subject = TestSubject::new();
    let mut settings = runtime.settings("robot");
    settings.connect = vec![foreign_endpoint, trusted_endpoint];
    settings.tls = Some(trusted.tls(true, true));
    let link = Link::open(&settings, subject.clone(), &Events::of_records()).unwrap();
    until("the trusted peer operates", || {
        operates(&trusted_peer, &link.about().id)
    });
    let count = subject.actions().len();
    assert!(!operates(&rogue, &link.about().id));
    assert_eq!(subject.actions().len(), count);
    let peers: Vec<_> = rogue.info().peers_zid().wait().collect();
    assert!(
        peers.is_empty(),
        "the application connected to the rogue: {peers:?}"
    );
}

#[test]
fn an_insecure_application_without_an_authority_trusts_no_certificate() {
    let _watchdog = Watchdog::for_test();
    let files = tempfile::tempdir().unwrap();
    let foreign_authority = authority(files.path(), "foreign_authority");
    let (encrypted, plain) = (
        format!("tls/{}", free_address()),
        format!("tcp/{}", free_address()),
    );
    let (rogue, trusted_peer) = (
        rogue(&encrypted, Some(&foreign_authority), false),
        rogue(&plain, None, false),
    );
    // Without an authority no certificate is trusted. The rogue's own authority proves that it would have
    // succeeded.
    for (tls, trusts_rogue) in [
        (None, false),
        (Some(Tls::default()), false),
        (Some(foreign_authority.tls(false, false)), true),
    ] {
        let runtime = TestRuntime::new();
        let mut settings = runtime.settings("robot");
        (settings.connect, settings.insecure) = (vec![encrypted.clone(), plain.clone()], true);
        settings.tls = tls;
        let link = Link::open(&settings, TestSubject::new(), &Events::of_records()).unwrap();
        until("the peer without TLS operates", || {
            operates(&trusted_peer, &link.about().id)
        });
        if trusts_rogue {
            until("the rogue operates", || operates(&rogue, &link.about().id));
        } else {
            let peers: Vec<_> = rogue.info().peers_zid().wait().collect();
            assert!(peers.is_empty(), "{peers:?}");
        }
    }
}

#[test]
fn peers_found_by_multicast_need_credentials_as_well() {
    let (runtime, files) = (TestRuntime::new(), tempfile::tempdir().unwrap());
    let trusted = authority(files.path(), "trusted");
    let [plain_endpoint, trusted_endpoint] =
        ["tcp", "tls"].map(|protocol| format!("{protocol}/{}", free_address()));
    let rogue = rogue(&plain_endpoint, None, true);
    let trusted_peer = self::rogue(&trusted_endpoint, Some(&trusted), true);
    let (link, _subject, _) = open(&runtime, "tls", |settings| {
        settings.tls = Some(trusted.tls(true, true));
        settings.discover = true;
    });
    until("the trusted peer operates", || {
        operates(&trusted_peer, &link.about().id)
    });
    assert!(!operates(&rogue, &link.about().id));
}

#[test]
fn a_password_is_never_sent_to_an_unauthenticated_peer() {
    let files = tempfile::tempdir().unwrap();
    let (trusted, foreign_authority) = (
        authority(files.path(), "trusted"),
        authority(files.path(), "foreign_authority"),
    );
    let credentials = || Some(login("lab", "secret"));
    // An intermediary that would forward queries and replies.
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    listener.set_nonblocking(true).unwrap();
    let address = listener.local_addr().unwrap();
    for reach in [
        reach(&format!("tcp/{address}"), credentials(), None),
        reach(
            &format!("tcp/{address}"),
            credentials(),
            Some(trusted.tls(false, false)),
        ),
        reach(&format!("tls/{address}"), credentials(), None),
    ] {
        let error = Client::connect(&reach).err().unwrap();
        assert!(matches!(error, Error::PlainPassword { .. }), "{error}");
    }
    let accept_error = listener.accept().map(drop).unwrap_err();
    assert_eq!(
        accept_error.kind(),
        std::io::ErrorKind::WouldBlock,
        "no connection was attempted"
    );
    // With TLS the password is sent only to a peer with a certificate of the authority.
    let rogue_endpoint = format!("tls/{}", free_address());
    let intermediary = rogue(&rogue_endpoint, Some(&foreign_authority), false);
    let intercepted: Reach = reach(&rogue_endpoint, credentials(), Some(trusted.tls(false, false)));
    let error = Client::connect(&intercepted).err().unwrap();
    assert!(matches!(error, Error::Connect { .. }), "{error}");
    let peers: Vec<_> = intermediary.info().peers_zid().wait().collect();
    assert!(peers.is_empty(), "{peers:?}");
}

#[test]
fn a_client_without_an_authority_trusts_no_certificate() {
    let (files, rogue_endpoint) = (tempfile::tempdir().unwrap(), format!("tls/{}", free_address()));
    let _rogue = rogue(
        &rogue_endpoint,
        Some(&authority(files.path(), "foreign_authority")),
        false,
    );
    let error = Client::connect(&reach(&rogue_endpoint, None, None))
        .err()
        .unwrap();
    assert!(error.to_string().contains("no certificate is trusted"), "{error}");
}
