//! Variables of other applications.

use std::net::TcpListener;
use std::sync::Arc;
use std::time::Duration;

use jde_board::Variable;
use jde_link::{Error, Events, Link};

use crate::common::{Home, Stage, import, until, write};

const LONG: Duration = Duration::from_secs(3600);

/// The current number, if there is one.
fn shown(variable: &Arc<Variable>) -> Option<f64> {
    let mut reader = variable.reader("test");
    let latched = reader.latch()?;
    Some(f64::from_ne_bytes(latched.bytes.try_into().unwrap()))
}

#[test]
fn an_import_comes_with_its_age_goes_with_its_peer_and_comes_back() {
    let home = Home::new();
    let here = Stage::importing(vec![import("robot2", "pioneer.bearing", LONG)]);
    let _here = home.open("base", &here);
    let proxy = here.board.get("robot2:pioneer.bearing").unwrap();
    assert_eq!(shown(&proxy), None, "nobody is there");
    let there = Stage::new();
    let mut writer = there.writer("pioneer.bearing");
    // Two seconds old by the peer's clock, which is fixed at five.
    write(&mut writer, 1.0, 3_000_000_000);
    let link = home.open("robot2", &there);
    until("the value comes", || shown(&proxy) == Some(1.0));
    let stamp = proxy.reader("test").latch().unwrap().stamp;
    assert_eq!(stamp.writer, jde_app::RemoteVariable::WRITER);
    for value in [2.0, 3.0] {
        write(&mut writer, value, 5_000_000_000);
        until("each value comes", || shown(&proxy) == Some(value));
    }
    writer.retract();
    until("what is taken back there is taken back here", || {
        shown(&proxy).is_none()
    });
    write(&mut writer, 4.0, 5_000_000_000);
    until("and a new one comes", || shown(&proxy) == Some(4.0));
    drop(link);
    until("nothing counts when the peer is gone", || shown(&proxy).is_none());
    let _again = home.open("robot2", &there);
    until("it is back by itself", || shown(&proxy) == Some(4.0));
}

#[test]
fn an_import_that_is_too_old_no_longer_counts() {
    let home = Home::new();
    let stale = Duration::from_millis(300);
    let here = Stage::importing(vec![import("robot2", "pioneer.bearing", stale)]);
    let _here = home.open("base", &here);
    let proxy = here.board.get("robot2:pioneer.bearing").unwrap();
    let there = Stage::new();
    let mut writer = there.writer("pioneer.bearing");
    let _there = home.open("robot2", &there);
    until("a fresh value comes", || {
        write(&mut writer, 1.0, 5_000_000_000);
        shown(&proxy) == Some(1.0)
    });
    until("it is taken back", || shown(&proxy).is_none());
    assert!(proxy.is_retracted());
    until("and a fresh one comes", || {
        write(&mut writer, 2.0, 5_000_000_000);
        shown(&proxy) == Some(2.0)
    });
}

#[test]
fn what_the_peer_has_not_or_has_of_another_type_stays_without_a_value() {
    let home = Home::new();
    let imports = ["pioneer.path", "pioneer.nothing", "pioneer.bearing"];
    let here = Stage::importing(imports.map(|name| import("robot2", name, LONG)).to_vec());
    let _here = home.open("base", &here);
    let there = Stage::new();
    write(&mut there.writer("pioneer.bearing"), 1.0, 5_000_000_000);
    let mut path = there.writer("pioneer.path");
    path.loan().fill(0);
    path.publish(1, 1).unwrap();
    let _there = home.open("robot2", &there);
    let of = |name: &str| here.board.get(&format!("robot2:{name}")).unwrap();
    until("the one that fits comes", || {
        shown(&of("pioneer.bearing")) == Some(1.0)
    });
    assert_eq!(of("pioneer.path").newest(), 0);
    assert_eq!(of("pioneer.nothing").newest(), 0);
}

#[test]
fn imports_cross_the_network_whoever_of_the_two_listens() {
    for importer_listens in [true, false] {
        // Each machine has a folder of its own.
        let (base, robot) = (Home::new(), Home::new());
        let here = Stage::importing(vec![import("robot2", "pioneer.bearing", LONG)]);
        let there = Stage::new();
        write(&mut there.writer("pioneer.bearing"), 7.0, 5_000_000_000);
        let (_here, _there) = loop {
            let port = TcpListener::bind("127.0.0.1:0")
                .unwrap()
                .local_addr()
                .unwrap()
                .port();
            let endpoint = vec![format!("tcp/127.0.0.1:{port}")];
            let (mut ours, mut theirs) = (base.settings("base"), robot.settings("robot2"));
            if importer_listens {
                (ours.listen, theirs.connect) = (endpoint.clone(), endpoint);
            } else {
                (theirs.listen, ours.connect) = (endpoint.clone(), endpoint);
            }
            (ours.insecure, theirs.insecure) = (true, true);
            let opened = (
                Link::open(&ours, here.clone(), &Events::of_records()),
                Link::open(&theirs, there.clone(), &Events::of_records()),
            );
            match opened {
                (Ok(here), Ok(there)) => break (here, there),
                // Another test has taken the port.
                (Err(Error::Listen { .. }), _) | (_, Err(Error::Listen { .. })) => {}
                (Err(error), _) | (_, Err(error)) => panic!("{error}"),
            }
        };
        let proxy = here.board.get("robot2:pioneer.bearing").unwrap();
        until("the value comes", || shown(&proxy) == Some(7.0));
    }
}
