//! Joints, positions on the Earth and clouds of points, as other programs send them.

use jde_types::*;

#[test]
fn joints_are_found_by_name_and_each_list_is_whole_or_empty() {
    let mut joints = JointState {
        name: ["wheel", "arm"].into_iter().map(Name::from).collect(),
        velocity: [0.5, 1.0].into_iter().collect(),
        ..JointState::default()
    };
    assert_eq!((joints.joint("arm"), joints.joint("hand")), (Some(1), None));
    assert_eq!(joints.check(), Ok(()));
    joints.effort.push(1.0).expect("there is room");
    assert!(joints.check().is_err());
}

#[test]
fn a_fix_is_on_the_earth() {
    let fix = |status, latitude, longitude| NavSatFix {
        status: NavSatStatus {
            status,
            ..NavSatStatus::default()
        },
        latitude,
        longitude,
        ..NavSatFix::default()
    };
    assert!(fix(0, -90.0, 180.0).check().is_ok());
    for wrong in [fix(0, 90.1, 0.0), fix(2, f64::NAN, 0.0), fix(1, 0.0, -181.0)] {
        assert!(wrong.has_fix() && wrong.check().is_err(), "{wrong:?}");
    }
    let none = fix(-1, f64::NAN, f64::NAN);
    assert!(!none.has_fix() && none.check().is_ok(), "it claims nothing");
}

/// Two rows of two points of x, a byte, y as a double and z, with a byte of surplus behind each row.
fn cloud(is_bigendian: bool) -> Box<PointCloud2> {
    let mut cloud = PointCloud2::boxed();
    cloud.is_bigendian = is_bigendian.into();
    (cloud.height, cloud.width, cloud.point_step, cloud.row_step) = (2, 2, 17, 35);
    for (name, offset, datatype) in [
        ("x", 0, PointField::FLOAT32),
        ("ring", 4, 2),
        ("y", 5, PointField::FLOAT64),
        ("z", 13, PointField::FLOAT32),
    ] {
        let field = PointField {
            name: Text::new(name),
            offset,
            datatype,
            count: 1,
            ..PointField::default()
        };
        cloud.fields.push(field).expect("there is room");
    }
    let in_order = |mut bytes: Vec<u8>| {
        if is_bigendian {
            bytes.reverse();
        }
        bytes
    };
    for number in 0..4 {
        let x = if number == 2 { f32::NAN } else { number as f32 };
        let mut point = in_order(x.to_le_bytes().to_vec());
        point.push(7);
        point.extend(in_order((f64::from(number) + 0.1).to_le_bytes().to_vec()));
        point.extend(in_order((-1.5_f32).to_le_bytes().to_vec()));
        if number % 2 == 1 {
            point.push(0);
        }
        cloud.data.extend_from_slice(&point).expect("there is room");
    }
    cloud
}

#[test]
fn points_are_read_by_the_fields_of_their_cloud() {
    for is_bigendian in [false, true] {
        let cloud = cloud(is_bigendian);
        let points: Vec<_> = cloud.points().expect("it is a cloud").collect();
        assert_eq!(
            points,
            [[0.0, 0.1, -1.5], [1.0, 1.1, -1.5], [3.0, 3.1, -1.5]],
            "one is not finite"
        );
    }
    assert_eq!(PointCloud2::boxed().check(), Ok(()), "an empty one");
}

#[test]
fn a_cloud_that_contradicts_itself_is_refused() {
    let refused = |change: fn(&mut PointCloud2), words: &str| {
        let mut cloud = cloud(false);
        change(&mut cloud);
        let reason = cloud.points().err().expect("it is refused");
        assert!(reason.contains(words), "{reason}");
    };
    refused(|cloud| cloud.fields[3].offset = 14, "behind its point");
    refused(|cloud| cloud.fields[3].offset = u32::MAX, "behind its point");
    refused(|cloud| cloud.fields[3].count = u32::MAX, "behind its point");
    refused(|cloud| cloud.fields[1].datatype = 9, "datatype");
    refused(|cloud| cloud.fields[0].datatype = 5, "floating-point");
    refused(|cloud| cloud.fields[0].name = Text::new("u"), "floating-point");
    refused(|cloud| cloud.width = u32::MAX, "shorter than its points");
    refused(|cloud| cloud.row_step = 33, "shorter than its points");
    refused(|cloud| cloud.height = 3, "bytes missing");
    refused(|cloud| cloud.point_step = 0, "behind its point");
}
