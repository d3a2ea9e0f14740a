//! Behind a bridge of DDS.

use zenoh::liveliness::LivelinessToken;

use super::*;
use crate::velocity::TwistStamped;
use crate::{Base, Goals, Topics};

#[test]
fn a_bridge_of_dds_has_topics_by_their_names_and_velocities_of_one_type() {
    let address = unused_address();
    let session = open_router(&address);
    let tokens = tokens(&session, "@ros2_lv/**");
    let scans = session.declare_subscriber("fleet/scan").wait().unwrap();
    let entries = [
        Entry::new::<LaserScan>("publish", "scan"),
        Entry::new::<Twist>("subscribe", "/cmd_vel").named("velocity"),
    ];
    let mut fixture = Fixture::<Topics>::with_lists(&format!("ros2dds/{address}"), &entries);
    fixture.bench.set("namespace", Text::<128>::new("fleet"));
    fixture.bench.import("scan", &one_beam());
    let mut fixture = fixture.awake();
    fixture.until_note(Connection::CONNECTED, &address);
    fixture.until(|_| receive::<LaserScan>(&scans).is_some());
    let twist = Twist::planar(0.3, 0.1);
    fixture.until(|bench| {
        session
            .put("cmd_vel", Codec::new().encode(&twist))
            .wait()
            .unwrap();
        bench.exported("velocity") == Some(twist)
    });
    let stamped = TwistStamped {
        twist: Twist::planar(9.0, 0.0),
        ..TwistStamped::default()
    };
    fixture.until(|bench| {
        session
            .put("cmd_vel", Codec::new().encode(&stamped))
            .wait()
            .unwrap();
        count_log(bench, "/cmd_vel: the message has") > 0
    });
    assert_ne!(fixture.bench.exported("velocity"), Some(stamped.twist));
    let _theirs = bridged(&session, "MP", "geometry_msgs§msg§TwistStamped");
    fixture.until(|bench| {
        session
            .put("cmd_vel", Codec::new().encode(&stamped))
            .wait()
            .unwrap();
        bench.exported("velocity") == Some(stamped.twist)
    });
    assert_eq!(
        tokens
            .try_recv()
            .unwrap()
            .map(|token| token.key_expr().to_string()),
        None
    );
}

/// Announces `/cmd_vel` as `zenoh-bridge-ros2dds` does.
fn bridged(session: &Session, kind: &str, type_name: &str) -> LivelinessToken {
    let token = format!("@/{}/@ros2_lv/{kind}/cmd_vel/{type_name}/:::1,10", session.zid());
    session.liveliness().declare_token(token).wait().unwrap()
}

#[test]
fn a_robot_behind_a_bridge_of_dds_receives_the_velocities_of_its_type() {
    let address = unused_address();
    let session = open_router(&address);
    let velocities = session.declare_subscriber("cmd_vel").wait().unwrap();
    let mut base = Fixture::<Base>::connecting_to(&format!("ros2dds/{address}")).awake();
    let ahead = Twist::planar(0.3, 0.0);
    base.bench.command("velocity", &ahead);
    let newest = || std::iter::from_fn(|| velocities.try_recv().unwrap()).last();
    base.until(|_| newest().is_some_and(|sample| sample.payload().len() == 52));
    let theirs = bridged(&session, "MS", "geometry_msgs§msg§TwistStamped");
    let stamped = Codec::<TwistStamped>::new();
    base.until(|_| {
        let mut value = TwistStamped::default();
        newest().is_some_and(|sample| {
            stamped
                .decode_into(&[&sample.payload().to_bytes()], &mut value)
                .is_ok()
        }) && value.twist == ahead
    });
    let _plain = bridged(&session, "MS", "geometry_msgs§msg§Twist");
    let mut sizes = Vec::new();
    base.until(|_| {
        sizes.extend(
            std::iter::from_fn(|| velocities.try_recv().unwrap()).map(|sample| sample.payload().len()),
        );
        sizes.len() >= 10
    });
    assert!(
        sizes.iter().all(|size| *size > 52),
        "messages of one type pass: {sizes:?}"
    );
    drop(theirs);
    base.until(|_| newest().is_some_and(|sample| sample.payload().len() == 52));
}

#[test]
fn actions_are_refused_at_a_bridge_of_dds() {
    let mut bench = Bench::<Goals>::new();
    bench.set("connect", Text::<512>::new("ros2dds/tcp/localhost:7447"));
    let problems = bench.inspect().unwrap();
    assert!(
        problems[0].words.contains("actions do not pass a bridge"),
        "{problems:?}"
    );
    assert!(bench.awake().is_err());
}
