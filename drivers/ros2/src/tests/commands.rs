//! Velocities that do not come from where they should.

use std::collections::BTreeSet;

use jde_ros_node::Direction;
use zenoh::liveliness::LivelinessToken;
use zenoh::sample::SampleKind;

use super::*;
use crate::velocity::TwistStamped;
use crate::{Base, Follow, Topics};

#[test]
fn a_velocity_of_the_own_application_is_not_followed() {
    let address = unused_address();
    let session = open_router(&address);
    let mut base = Fixture::<Base>::connecting_to(&address).awake();
    let mut follow = Fixture::<Follow>::connecting_to(&address);
    follow.bench.unbind("cmd_vel");
    follow.bench.set("topic", Text::<128>::new("cmd_vel"));
    let mut follow = follow.awake();
    let said = "this application publishes /cmd_vel itself, and ignores its own messages";
    base.bench.command("velocity", &Twist::planar(0.3, 0.0));
    while count_log(&follow.bench, said) == 0 {
        base.step();
        follow.bench.set_now(follow.start.elapsed());
        assert!(!follow.bench.check().unwrap().ready);
    }
    let ahead = Twist::planar(0.1, 0.0);
    loop {
        put(&session, "/cmd_vel", &ahead);
        base.step();
        follow.bench.set_now(follow.start.elapsed());
        if follow.bench.check().unwrap().ready {
            break;
        }
    }
    follow.bench.iterate().unwrap();
    assert_eq!(follow.bench.commanded("base"), Some(ahead));
    assert_eq!(count_log(&follow.bench, said), 1);
}

#[test]
fn another_node_that_commands_the_robot_is_reported_once() {
    let address = unused_address();
    let session = open_router(&address);
    let announce = |node: &str, topic: &str, direction, number| -> LivelinessToken {
        let other = NodeName {
            node: node.to_owned(),
            ..name()
        };
        let token = super::topic::<Twist>(topic).token(&other, &session.zid().to_string(), direction, number);
        session.liveliness().declare_token(token).wait().unwrap()
    };
    let _tokens = [
        announce("listener", "/cmd_vel", Direction::Subscribe, 1),
        announce("elsewhere", "/teleop/cmd_vel", Direction::Publish, 2),
        announce("joy", "/cmd_vel", Direction::Publish, 3),
        announce("joy", "/cmd_vel", Direction::Publish, 4),
    ];
    let mut fixture = Fixture::<Base>::connecting_to(&address).awake();
    fixture.until_logged(
        "node /joy publishes /cmd_vel too, and its commands do not pass through this application",
    );
    assert_eq!(
        count_log(&fixture.bench, "do not pass through this application"),
        1
    );
}

#[test]
fn a_stamped_velocity_is_received_and_announced_once_another_node_has_one() {
    let address = unused_address();
    let session = open_router(&address);
    let tokens = tokens(&session, "@ros2_lv/3/**");
    let mut fixture = Fixture::<Topics>::with_lists(
        &address,
        &[Entry::new::<Twist>("subscribe", "cmd_vel").named("cmd_vel")],
    )
    .awake();
    fixture.until_note(Connection::CONNECTED, &address);
    let stamped = TwistStamped {
        twist: Twist::planar(0.3, 0.1),
        ..TwistStamped::default()
    };
    fixture.until(|bench| {
        put(&session, "/cmd_vel", &stamped);
        bench.exported("cmd_vel") == Some(stamped.twist)
    });
    let mut announced = BTreeSet::new();
    let mut announced = move || {
        for sample in std::iter::from_fn(|| tokens.try_recv().unwrap()) {
            let token = sample.key_expr().to_string();
            let Some(token) = token
                .contains("/MS/")
                .then(|| token.split('/').nth(10).unwrap().to_owned())
            else {
                continue;
            };
            match sample.kind() {
                SampleKind::Put => announced.insert(token),
                SampleKind::Delete => announced.remove(&token),
            };
        }
        announced
            .iter()
            .map(|dds| dds.rsplit(':').next().unwrap().to_owned())
            .collect::<Vec<_>>()
    };
    assert_eq!(announced(), ["Twist_"], "nobody uses the other");
    let announce = |token: String| session.liveliness().declare_token(token).wait().unwrap();
    let _stamped = announce(topic::<TwistStamped>("/cmd_vel").token(&name(), "ab12", Direction::Publish, 1));
    fixture.until(|_| announced() == ["TwistStamped_"]);
    let _plain = announce(topic::<Twist>("/cmd_vel").token(&name(), "ab12", Direction::Publish, 2));
    fixture.until(|_| announced() == ["TwistStamped_", "Twist_"]);
    assert_eq!(count_log(&fixture.bench, "nothing passes"), 0);
}
