//! Keys in the format of other implementations, and tokens of others that match or do not.

use jde_schema::prelude::*;
use proptest::prelude::*;

use super::*;
use crate::messages::Codec;

fn name() -> NodeName {
    NodeName {
        domain: 2,
        namespace: "/fleet".to_owned(),
        node: "pioneer".to_owned(),
    }
}

fn scan() -> Topic {
    Codec::<LaserScan>::new().topic("/fleet/scan".to_owned(), Quality::Sensor)
}

#[test]
fn keys_are_laid_out_as_rmw_zenoh_does() {
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
    let alone = NodeName {
        namespace: String::new(),
        ..name()
    };
    assert_eq!(alone.token("ab12"), "@ros2_lv/2/ab12/0/0/NN/%/%/pioneer");
    assert_eq!(alone.full(), "/pioneer");
}

#[test]
fn keys_are_keys_of_zenoh() {
    for key in [
        scan().key(&name()),
        name().token("ab12"),
        name().everyone(),
        scan().token(&name(), "ab12", Direction::Subscribe, 1),
    ] {
        assert!(zenoh::key_expr::KeyExpr::new(key.clone()).is_ok(), "{key}");
    }
}

#[test]
fn who_means_the_same_by_a_topic_is_not_spoken_of() {
    let theirs = scan().token(&name(), "cd34", Direction::Publish, 1);
    assert_eq!(scan().mismatch(Direction::Subscribe, &theirs), None);
    // Two publications of the same topic never exchange messages.
    let other = Codec::<Odometry>::new().topic("/fleet/scan".to_owned(), Quality::Sensor);
    assert_eq!(other.mismatch(Direction::Publish, &theirs), None);
    let elsewhere = Codec::<Odometry>::new().topic("/scan".to_owned(), Quality::Sensor);
    assert_eq!(elsewhere.mismatch(Direction::Subscribe, &theirs), None);
    assert_eq!(scan().mismatch(Direction::Subscribe, &name().token("cd34")), None);
}

#[test]
fn another_type_and_another_version_are_named() {
    let theirs = Codec::<Odometry>::new().topic("/fleet/scan".to_owned(), Quality::Sensor);
    let token = theirs.token(&name(), "cd34", Direction::Publish, 1);
    assert_eq!(
        scan().mismatch(Direction::Subscribe, &token).unwrap(),
        "/fleet/scan of node /fleet/pioneer is a nav_msgs/msg/Odometry, and a sensor_msgs/msg/LaserScan here: nothing passes \
         between them"
    );
    let old = Topic {
        hash: "TypeHashNotSupported".to_owned(),
        ..scan()
    };
    let words = scan()
        .mismatch(
            Direction::Publish,
            &old.token(&name(), "cd34", Direction::Subscribe, 1),
        )
        .unwrap();
    assert!(
        words.contains("another version of sensor_msgs/msg/LaserScan, TypeHashNotSupported, and RIHS01_64c191398013a here"),
        "{words}"
    );
}

proptest! {
    #[test]
    fn tokens_nobody_meant_do_no_harm(token in ".{0,80}", parts in prop::collection::vec("[A-Z%@a-z_:,0-9é]{0,12}", 0..16)) {
        let _ = scan().mismatch(Direction::Subscribe, &token);
        let _ = scan().mismatch(Direction::Publish, &format!("@ros2_lv/{}", parts.join("/")));
        let hash = parts.concat();
        let theirs = Topic { hash: hash.replace('/', ""), ..scan() };
        let _ = scan().mismatch(Direction::Subscribe, &theirs.token(&name(), "cd34", Direction::Publish, 1));
    }
}
