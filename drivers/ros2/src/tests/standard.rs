//! Standard types of ROS 2 with lists of texts, and with contents that a driver must check.

use jde_schema::types::{JointState, NavSatFix, NavSatStatus, PointCloud2, PointField};

use super::*;
use crate::Topics;

/// Two joints in ROS 2's own encoding: a list of texts, not of structures.
const JOINTS: &[u8] = b"\0\x01\0\0\
    \0\0\0\0\0\0\0\0\x01\0\0\0\0\0\0\0\
    \x02\0\0\0\x05\0\0\0left\0\0\0\0\x06\0\0\0right\0\0\0\
    \x02\0\0\0\0\0\0\0\0\0\xf0\x3f\0\0\0\0\0\0\0\xc0\
    \0\0\0\0\0\0\0\0";

fn joints() -> JointState {
    JointState {
        name: ["left", "right"].into_iter().map(Into::into).collect(),
        position: [1.0, -2.0].into_iter().collect(),
        ..JointState::default()
    }
}

fn fix(latitude: f64) -> NavSatFix {
    NavSatFix {
        status: NavSatStatus {
            status: 0,
            ..NavSatStatus::default()
        },
        latitude,
        longitude: -3.7,
        ..NavSatFix::default()
    }
}

/// One point of three numbers, the last of which ends at the end of the point.
fn cloud() -> Box<PointCloud2> {
    let mut cloud = PointCloud2::boxed();
    (cloud.height, cloud.width, cloud.point_step, cloud.row_step) = (1, 1, 12, 12);
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        let field = PointField {
            name: Text::new(name),
            offset: 4 * axis as u32,
            datatype: PointField::FLOAT32,
            count: 1,
            ..PointField::default()
        };
        cloud.fields.push(field).unwrap();
    }
    for number in [1.0_f32, 2.0, -0.5] {
        cloud.data.extend_from_slice(&number.to_le_bytes()).unwrap();
    }
    cloud
}

fn fixture(entries: &[Entry]) -> (Session, Fixture<Topics>) {
    let address = unused_address();
    let session = open_router(&address);
    let mut fixture = Fixture::<Topics>::with_lists(&address, entries).awake();
    fixture.until_note(Connection::CONNECTED, &address);
    (session, fixture)
}

#[test]
fn joints_have_a_list_of_texts_in_both_directions() {
    let (session, mut fixture) = fixture(&[
        Entry::new::<JointState>("publish", "joint_states"),
        Entry::new::<JointState>("subscribe", "other").named("joints"),
    ]);
    let key = topic::<JointState>("/other").key(&name());
    fixture.until(|bench| {
        session.put(&key, JOINTS).wait().unwrap();
        bench.exported::<JointState>("joints").is_some()
    });
    let exported: JointState = fixture.bench.exported("joints").unwrap();
    assert_eq!((exported.joint("right"), exported.joint("arm")), (Some(1), None));
    assert_eq!(
        (exported.name, exported.position),
        (joints().name, joints().position)
    );
    let published = listen::<JointState>(&session, "/joint_states");
    fixture.bench.import("joint_states", &joints());
    let mut sample = None;
    fixture.until(|_| {
        sample = published.try_recv().unwrap();
        sample.is_some()
    });
    let message = sample.unwrap().payload().to_bytes().into_owned();
    assert_eq!(message[12..], JOINTS[12..], "all but the stamp");
}

#[test]
fn contents_that_mean_nothing_are_refused_in_words_once_and_the_next_value_passes() {
    let (session, mut fixture) = fixture(&[
        Entry::new::<JointState>("subscribe", "joints"),
        Entry::new::<NavSatFix>("subscribe", "fix"),
        Entry::new::<PointCloud2>("subscribe", "points"),
    ]);
    let mut uneven = joints();
    uneven.velocity = [1.0].into_iter().collect();
    let mut cut = cloud();
    cut.data.resize(11);
    for _ in 0..2 {
        fixture.until(|bench| {
            put(&session, "/joints", &uneven);
            put(&session, "/fix", &fix(f64::NAN));
            put(&session, "/points", &*cut);
            [
                "/joints: a list has",
                "/fix: a fix with",
                "/points: a cloud with bytes",
            ]
            .iter()
            .all(|text| count_log(bench, text) == 1)
        });
    }
    assert!(fixture.bench.exported::<NavSatFix>("fix").is_none());
    fixture.until(|bench| {
        put(&session, "/joints", &joints());
        put(&session, "/fix", &fix(40.3));
        put(&session, "/points", &*cloud());
        bench.exported::<JointState>("joints").is_some()
            && bench.exported::<NavSatFix>("fix").is_some()
            && bench.exported_in_place::<PointCloud2>("points").is_some()
    });
    let points = fixture.bench.exported_in_place::<PointCloud2>("points").unwrap();
    assert_eq!(Vec::from_iter(points.points().unwrap()), [[1.0, 2.0, -0.5]]);
}
