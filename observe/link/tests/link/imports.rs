//! Variables of other applications.

use std::net::TcpListener;
use std::sync::Arc;
use std::time::Duration;

use jde_board::Variable;
use jde_link::{Error, Events, Link};

use crate::common::{TestRuntime, TestSubject, import, until, write};

const LONG: Duration = Duration::from_secs(3600);

/// The current number, if there is one.
fn value_of(variable: &Arc<Variable>) -> Option<f64> {
    let mut reader = variable.reader("test");
    let latched = reader.latch(0)?;
    Some(f64::from_ne_bytes(latched.bytes.try_into().unwrap()))
}

#[test]
fn an_import_arrives_with_its_age_ends_with_its_peer_and_resumes() {
    let runtime = TestRuntime::new();
    let base_subject = TestSubject::with_imports(vec![import("robot2", "pioneer.bearing", LONG)]);
    let _base = runtime.open("base", &base_subject);
    let proxy = base_subject.board.get("robot2:pioneer.bearing").unwrap();
    assert_eq!(value_of(&proxy), None, "the peer does not run yet");
    let robot_subject = TestSubject::new();
    let mut writer = robot_subject.writer("pioneer.bearing");
    // The peer's clock is fixed at 5 s, so the value is 2 s old.
    write(&mut writer, 1.0, 3_000_000_000);
    let link = runtime.open("robot2", &robot_subject);
    until("the value arrives", || value_of(&proxy) == Some(1.0));
    let stamp = proxy.reader("test").latch(0).unwrap().stamp;
    assert_eq!(stamp.writer, jde_app::RemoteVariable::WRITER);
    for value in [2.0, 3.0] {
        write(&mut writer, value, 5_000_000_000);
        until("each value arrives", || value_of(&proxy) == Some(value));
    }
    writer.retract();
    until("a retraction by the peer arrives", || value_of(&proxy).is_none());
    write(&mut writer, 4.0, 5_000_000_000);
    until("a new value arrives", || value_of(&proxy) == Some(4.0));
    drop(link);
    until("the value is retracted when the peer is gone", || {
        value_of(&proxy).is_none()
    });
    let _again = runtime.open("robot2", &robot_subject);
    until("the value arrives again without a request", || {
        value_of(&proxy) == Some(4.0)
    });
}

#[test]
fn an_import_that_is_too_old_is_retracted() {
    let runtime = TestRuntime::new();
    let stale = Duration::from_millis(300);
    let base_subject = TestSubject::with_imports(vec![import("robot2", "pioneer.bearing", stale)]);
    let _base = runtime.open("base", &base_subject);
    let proxy = base_subject.board.get("robot2:pioneer.bearing").unwrap();
    let robot_subject = TestSubject::new();
    let mut writer = robot_subject.writer("pioneer.bearing");
    let _robot = runtime.open("robot2", &robot_subject);
    until("a fresh value arrives", || {
        write(&mut writer, 1.0, 5_000_000_000);
        value_of(&proxy) == Some(1.0)
    });
    until("it is retracted", || value_of(&proxy).is_none());
    assert!(!proxy.has_value(0));
    until("a fresh value arrives again", || {
        write(&mut writer, 2.0, 5_000_000_000);
        value_of(&proxy) == Some(2.0)
    });
}

#[test]
fn an_import_that_the_peer_lacks_or_has_with_another_type_stays_without_a_value() {
    let runtime = TestRuntime::new();
    let imports = ["pioneer.path", "pioneer.nothing", "pioneer.bearing"];
    let base_subject = TestSubject::with_imports(imports.map(|name| import("robot2", name, LONG)).to_vec());
    let _base = runtime.open("base", &base_subject);
    let robot_subject = TestSubject::new();
    write(&mut robot_subject.writer("pioneer.bearing"), 1.0, 5_000_000_000);
    let mut path = robot_subject.writer("pioneer.path");
    path.loan().fill(0);
    path.publish(1, 1).unwrap();
    let _robot = runtime.open("robot2", &robot_subject);
    let proxy = |name: &str| base_subject.board.get(&format!("robot2:{name}")).unwrap();
    until("the import of the right type arrives", || {
        value_of(&proxy("pioneer.bearing")) == Some(1.0)
    });
    assert_eq!(proxy("pioneer.path").newest(), 0);
    assert_eq!(proxy("pioneer.nothing").newest(), 0);
}

#[test]
fn imports_cross_the_network_whichever_end_listens() {
    for importer_listens in [true, false] {
        // Each machine has a folder of its own.
        let (base, robot) = (TestRuntime::new(), TestRuntime::new());
        let base_subject = TestSubject::with_imports(vec![import("robot2", "pioneer.bearing", LONG)]);
        let robot_subject = TestSubject::new();
        write(&mut robot_subject.writer("pioneer.bearing"), 7.0, 5_000_000_000);
        let (_base, _robot) = loop {
            let port = TcpListener::bind("127.0.0.1:0")
                .unwrap()
                .local_addr()
                .unwrap()
                .port();
            let endpoint = vec![format!("tcp/127.0.0.1:{port}")];
            let (mut base_settings, mut robot_settings) = (base.settings("base"), robot.settings("robot2"));
            if importer_listens {
                (base_settings.listen, robot_settings.connect) = (endpoint.clone(), endpoint);
            } else {
                (robot_settings.listen, base_settings.connect) = (endpoint.clone(), endpoint);
            }
            (base_settings.insecure, robot_settings.insecure) = (true, true);
            let opened = (
                Link::open(&base_settings, base_subject.clone(), &Events::of_records()),
                Link::open(&robot_settings, robot_subject.clone(), &Events::of_records()),
            );
            match opened {
                (Ok(base), Ok(robot)) => break (base, robot),
                // Another test has taken the port.
                (Err(Error::Listen { .. }), _) | (_, Err(Error::Listen { .. })) => {}
                (Err(error), _) | (_, Err(error)) => panic!("{error}"),
            }
        };
        let proxy = base_subject.board.get("robot2:pioneer.bearing").unwrap();
        until("the value arrives", || value_of(&proxy) == Some(7.0));
    }
}
