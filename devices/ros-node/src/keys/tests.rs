//! Keys in the format of other implementations, and tokens of other nodes that match or do not.

use jde_types::{LaserScan, Odometry, Twist, Value};
use proptest::prelude::*;

use super::*;
use crate::interface::standard;

fn name() -> NodeName {
    NodeName {
        domain: 2,
        namespace: "/fleet".to_owned(),
        node: "pioneer".to_owned(),
        middleware: Middleware::Rmw,
    }
}

fn topic<T: Value>(name: &str) -> Topic {
    Topic::new(name.to_owned(), &T::describe(), Quality::SENSOR_DATA)
}

fn scan() -> Topic {
    topic::<LaserScan>("/fleet/scan")
}

#[test]
fn keys_have_the_layout_of_rmw_zenoh() {
    let hash = "RIHS01_64c191398013af96509d518dac71d5164f9382553fce5c1f8cca5be7924bd828";
    assert_eq!(
        scan().key(&name()),
        format!("2/fleet/scan/sensor_msgs::msg::dds_::LaserScan_/{hash}")
    );
    assert_eq!(name().token("ab12"), "@ros2_lv/2/ab12/0/0/NN/%/%fleet/pioneer");
    assert_eq!(
        scan().token(&name(), "ab12", Direction::Publish, 3),
        format!(
            "@ros2_lv/2/ab12/0/3/MP/%/%fleet/pioneer/%fleet%scan/sensor_msgs::msg::dds_::LaserScan_/{hash}/2::,5:,:,:,,"
        )
    );
    let without_namespace = NodeName {
        namespace: String::new(),
        ..name()
    };
    assert_eq!(
        without_namespace.token("ab12"),
        "@ros2_lv/2/ab12/0/0/NN/%/%/pioneer"
    );
    assert_eq!(without_namespace.full(), "/pioneer");
}

#[test]
fn a_service_has_keys_and_tokens_of_its_own() {
    let hash = "RIHS01_eeff2cd6fa5ad9d27cdf4dec64818317839b62f212a91e6b5304b634b2062c5f";
    let stop = Service::new(
        "/fleet/pioneer/stop".to_owned(),
        "std_srvs/srv/Trigger",
        standard(),
    )
    .unwrap();
    assert_eq!(
        stop.topic().key(&name()),
        format!("2/fleet/pioneer/stop/std_srvs::srv::dds_::Trigger_/{hash}")
    );
    let token = |direction| stop.topic().token(&name(), "ab12", direction, 3);
    assert_eq!(
        token(Direction::Serve),
        format!(
            "@ros2_lv/2/ab12/0/3/SS/%/%fleet/pioneer/%fleet%pioneer%stop/std_srvs::srv::dds_::Trigger_/{hash}/::,10:,:,:,,"
        )
    );
    assert!(stop.topic().meets(Direction::Call, &token(Direction::Serve)));
    assert!(!stop.topic().meets(Direction::Call, &token(Direction::Call)));
    assert_eq!(Service::new("/x".to_owned(), "a/srv/B", standard()), None);
}

#[test]
fn a_profile_is_encoded_without_default_values() {
    assert_eq!(Quality::SENSOR_DATA.profile(), "2::,5:,:,:,,");
    assert_eq!(Quality::LATCHED.profile(), ":1:,1:,:,:,,");
    assert_eq!(Quality::reliable(42).profile(), "::,:,:,:,,");
    assert_eq!(Quality::PARAMETERS.profile(), "::,1000:,:,:,,");
}

#[test]
fn keys_are_valid_in_zenoh() {
    for key in [
        scan().key(&name()),
        name().token("ab12"),
        name().all_tokens(),
        scan().token(&name(), "ab12", Direction::Subscribe, 1),
    ] {
        assert!(zenoh::key_expr::KeyExpr::new(key.clone()).is_ok(), "{key}");
    }
}

#[test]
fn equal_and_unrelated_topics_are_no_mismatch() {
    let token = scan().token(&name(), "cd34", Direction::Publish, 1);
    assert_eq!(scan().mismatch(Direction::Subscribe, &token), None);
    // Two publications of the same topic never exchange messages.
    let other_type = topic::<Odometry>("/fleet/scan");
    assert_eq!(other_type.mismatch(Direction::Publish, &token), None);
    let different_name = topic::<Odometry>("/scan");
    assert_eq!(different_name.mismatch(Direction::Subscribe, &token), None);
    assert_eq!(scan().mismatch(Direction::Subscribe, &name().token("cd34")), None);
}

#[test]
fn a_token_with_more_parts_is_of_its_topic() {
    // Rolling adds which memories its buffers may be in.
    let token = scan().token(&name(), "cd34", Direction::Subscribe, 1) + "/backends:cpu:";
    assert!(scan().meets(Direction::Publish, &token));
    let other_type = topic::<Odometry>("/fleet/scan");
    assert!(other_type.mismatch(Direction::Publish, &token).is_some());
}

#[test]
fn another_type_and_another_version_are_reported() {
    let odometry = topic::<Odometry>("/fleet/scan");
    let token = odometry.token(&name(), "cd34", Direction::Publish, 1);
    assert_eq!(
        scan().mismatch(Direction::Subscribe, &token).unwrap(),
        "/fleet/scan of node /fleet/pioneer is a nav_msgs/msg/Odometry, and a sensor_msgs/msg/LaserScan here: nothing passes \
         between them"
    );
    let with_hash = |hash: &str| Topic {
        hash: hash.to_owned(),
        ..scan()
    };
    let said = |own: &Topic, other: &Topic| {
        let token = other.token(&name(), "cd34", Direction::Subscribe, 1);
        own.mismatch(Direction::Publish, &token).unwrap()
    };
    let (other, humble) = (with_hash("RIHS01_0123456789abcdef"), with_hash(NO_HASH));
    for (message, expected) in [
        (
            said(&scan(), &other),
            "another version of sensor_msgs/msg/LaserScan, RIHS01_0123456789abc, and RIHS01_64c191398013a here",
        ),
        (
            said(&scan(), &humble),
            "is of Humble: nothing passes between them; connect = \"humble/tcp/HOST:PORT\"",
        ),
        (
            said(&humble, &scan()),
            "is not of Humble: nothing passes between them; leave out `humble/`",
        ),
    ] {
        assert!(message.contains(expected), "{message}");
    }
}

proptest! {
    #[test]
    fn arbitrary_tokens_cause_no_panic(token in ".{0,80}", parts in prop::collection::vec("[A-Z%@a-z_:,0-9é]{0,12}", 0..16)) {
        let _ = scan().mismatch(Direction::Subscribe, &token);
        let _ = scan().mismatch(Direction::Publish, &format!("@ros2_lv/{}", parts.join("/")));
        let hash = parts.concat();
        let changed = Topic { hash: hash.replace('/', ""), ..scan() };
        let _ = scan().mismatch(Direction::Subscribe, &changed.token(&name(), "cd34", Direction::Publish, 1));
    }
}

#[test]
fn a_topic_of_two_types_is_mismatched_only_by_a_third() {
    let plain = topic::<Twist>("/cmd_vel");
    let stamped = topic::<Odometry>("/cmd_vel");
    let topics = [plain.clone(), stamped.clone()];
    let token = |topic: &Topic| topic.token(&name(), "cd34", Direction::Publish, 1);
    for other in &topics {
        assert!(other.meets(Direction::Subscribe, &token(other)));
        assert!(!other.meets(Direction::Publish, &token(other)));
        assert_eq!(mismatch(&topics, Direction::Subscribe, &token(other)), None);
    }
    assert!(!plain.meets(Direction::Subscribe, &token(&stamped)));
    let said = |other: Topic| mismatch(&topics, Direction::Subscribe, &token(&other)).unwrap();
    assert!(
        said(topic::<LaserScan>("/cmd_vel"))
            .contains("is a sensor_msgs/msg/LaserScan, and a geometry_msgs/msg/Twist here")
    );
    let old = Topic {
        hash: "RIHS01_0".to_owned(),
        ..stamped
    };
    assert!(said(old).contains("is another version of nav_msgs/msg/Odometry"));
}
