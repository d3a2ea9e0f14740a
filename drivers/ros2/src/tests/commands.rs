//! Velocities that do not come from where they should.

use jde_ros_node::Direction;
use zenoh::liveliness::LivelinessToken;

use super::*;
use crate::{Base, Follow};

#[test]
fn a_velocity_of_the_own_application_is_not_followed() {
    let address = unused_address();
    let session = open_router(&address);
    let mut base = Fixture::<Base>::connecting_to(&address).awake();
    let mut follow = Fixture::<Follow>::connecting_to(&address);
    follow.bench.unbind("cmd_vel");
    follow.bench.set("topic", Text::<128>::new("cmd_vel"));
    let mut follow = follow.awake();
    let said = "this application itself publishes /cmd_vel, and ignores that";
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
    fixture.until_logged("node /joy publishes /cmd_vel too, and its commands pass this application by");
    assert_eq!(count_log(&fixture.bench, "pass this application by"), 1);
}
