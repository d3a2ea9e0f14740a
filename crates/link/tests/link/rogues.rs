//! Hostile peers on the network: one without credentials, one of a foreign authority, and one that is after a
//! password. None can operate.

use std::net::TcpListener;
use std::sync::mpsc::channel;

use jde_link::{Client, Error, Events, Link, Reach, Tls};
use jde_watchdog::Watchdog;
use zenoh::Wait;

use crate::common::{Home, SOON, Stage, until};
use crate::network::{Authority, authority, free, login, open, play, reach};

/// A Zenoh peer that listens, with or without a certificate, and answers every connection.
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

/// Whether the rogue can operate the application that connected to it. Waits for the answer, or until the
/// query ends without one.
fn operates(rogue: &zenoh::Session, id: &str) -> bool {
    let (tell, told) = channel();
    let order = serde_json::to_vec(&play()).unwrap();
    rogue
        .get(format!("jde/1/robot/{id}/operate"))
        .payload(order)
        .callback(move |reply| tell.send(reply.into_result().is_ok()).unwrap_or_default())
        .wait()
        .unwrap();
    told.recv_timeout(SOON).is_ok_and(|done| done)
}

#[test]
fn a_peer_without_credentials_is_not_connected_to() {
    let (home, files) = (Home::new(), tempfile::tempdir().unwrap());
    let ours = authority(files.path(), "ours");
    let there = format!("tcp/{}", free());
    let rogue = rogue(&there, None, false);
    let mut settings = home.settings("robot");
    settings.connect = vec![there.clone()];
    // An authority proves nothing about an address without TLS, nor does a password.
    settings.tls = Some(ours.tls(true, true));
    let error = Link::open(&settings, Stage::new(), &Events::of_records())
        .err()
        .unwrap();
    assert!(
        matches!(&error, Error::Unproven { endpoint } if *endpoint == there),
        "{error}"
    );
    settings.login = Some(login("lab", "secret"));
    let error = Link::open(&settings, Stage::new(), &Events::of_records())
        .err()
        .unwrap();
    assert!(matches!(error, Error::PlainPassword { .. }), "{error}");
    // With explicit consent it connects, which proves that this rogue would have succeeded.
    let stage = Stage::new();
    (settings.login, settings.insecure) = (None, true);
    let link = Link::open(&settings, stage.clone(), &Events::of_records()).unwrap();
    until("the rogue operates", || operates(&rogue, &link.about().id));
    assert!(!stage.acts().is_empty());
}

#[test]
fn a_peer_of_a_foreign_authority_gets_nothing() {
    let (home, files) = (Home::new(), tempfile::tempdir().unwrap());
    let (ours, theirs) = (authority(files.path(), "ours"), authority(files.path(), "theirs"));
    let [foreign, known] = [(); 2].map(|()| format!("tls/{}", free()));
    let (rogue, friend) = (
        rogue(&foreign, Some(&theirs), false),
        rogue(&known, Some(&ours), false),
    );
    let stage = Stage::new();
    let mut settings = home.settings("robot");
    settings.connect = vec![foreign, known];
    settings.tls = Some(ours.tls(true, true));
    let link = Link::open(&settings, stage.clone(), &Events::of_records()).unwrap();
    until("one of ours operates", || operates(&friend, &link.about().id));
    let done = stage.acts().len();
    assert!(!operates(&rogue, &link.about().id));
    assert_eq!(stage.acts().len(), done);
    let peers: Vec<_> = rogue.info().peers_zid().wait().collect();
    assert!(peers.is_empty(), "it is not even connected to: {peers:?}");
}

#[test]
fn where_nobody_has_to_prove_anything_no_public_authority_is_believed() {
    let _watchdog = Watchdog::for_test();
    let files = tempfile::tempdir().unwrap();
    let theirs = authority(files.path(), "theirs");
    let (encrypted, plain) = (format!("tls/{}", free()), format!("tcp/{}", free()));
    let (rogue, friend) = (
        rogue(&encrypted, Some(&theirs), false),
        rogue(&plain, None, false),
    );
    // Without an authority no certificate is trusted. The rogue's own authority proves that it would have
    // succeeded.
    for (tls, believed) in [
        (None, false),
        (Some(Tls::default()), false),
        (Some(theirs.tls(false, false)), true),
    ] {
        let home = Home::new();
        let mut settings = home.settings("robot");
        (settings.connect, settings.insecure) = (vec![encrypted.clone(), plain.clone()], true);
        settings.tls = tls;
        let link = Link::open(&settings, Stage::new(), &Events::of_records()).unwrap();
        until("who is not asked operates", || {
            operates(&friend, &link.about().id)
        });
        if believed {
            until("the rogue operates", || operates(&rogue, &link.about().id));
        } else {
            let peers: Vec<_> = rogue.info().peers_zid().wait().collect();
            assert!(peers.is_empty(), "{peers:?}");
        }
    }
}

#[test]
fn whoever_is_found_by_multicast_proves_as_much_as_others() {
    let (home, files) = (Home::new(), tempfile::tempdir().unwrap());
    let ours = authority(files.path(), "ours");
    let [plain, known] = ["tcp", "tls"].map(|protocol| format!("{protocol}/{}", free()));
    let rogue = rogue(&plain, None, true);
    let friend = self::rogue(&known, Some(&ours), true);
    let (link, _stage, _) = open(&home, "tls", |settings| {
        settings.tls = Some(ours.tls(true, true));
        settings.discover = true;
    });
    until("one of ours operates", || operates(&friend, &link.about().id));
    assert!(!operates(&rogue, &link.about().id));
}

#[test]
fn a_password_never_leaves_for_an_address_that_proves_nothing() {
    let files = tempfile::tempdir().unwrap();
    let (ours, theirs) = (authority(files.path(), "ours"), authority(files.path(), "theirs"));
    let lab = || Some(login("lab", "secret"));
    // An intermediary that would forward queries and answers.
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    listener.set_nonblocking(true).unwrap();
    let address = listener.local_addr().unwrap();
    for reach in [
        reach(&format!("tcp/{address}"), lab(), None),
        reach(&format!("tcp/{address}"), lab(), Some(ours.tls(false, false))),
        reach(&format!("tls/{address}"), lab(), None),
    ] {
        let error = Client::connect(&reach).err().unwrap();
        assert!(matches!(error, Error::PlainPassword { .. }), "{error}");
    }
    let knocked = listener.accept().map(drop).unwrap_err();
    assert_eq!(knocked.kind(), std::io::ErrorKind::WouldBlock, "nobody came");
    // Within TLS the password is sent only to an end with a certificate of the authority.
    let there = format!("tls/{}", free());
    let middle = rogue(&there, Some(&theirs), false);
    let tampered: Reach = reach(&there, lab(), Some(ours.tls(false, false)));
    let error = Client::connect(&tampered).err().unwrap();
    assert!(matches!(error, Error::Connect { .. }), "{error}");
    let peers: Vec<_> = middle.info().peers_zid().wait().collect();
    assert!(peers.is_empty(), "{peers:?}");
}

#[test]
fn no_public_authority_is_believed_in_place_of_one_that_is_not_named() {
    let (files, there) = (tempfile::tempdir().unwrap(), format!("tls/{}", free()));
    let _rogue = rogue(&there, Some(&authority(files.path(), "theirs")), false);
    let error = Client::connect(&reach(&there, None, None)).err().unwrap();
    assert!(error.to_string().contains("nobody is believed"), "{error}");
}
