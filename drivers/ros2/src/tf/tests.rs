//! The tree against products of matrices, and what it refuses.

use jde_schema::types::{Pose, Pose2D, Quaternion, Transform, Vector3};
use proptest::prelude::*;

use super::tree::{LookupError, Published, Tree};

const SECOND: i64 = 1_000_000_000;

type Matrix = [[f64; 4]; 4];

/// The matrix of a transform, by the rotation that its quaternion stands for.
fn matrix(transform: &Transform) -> Matrix {
    let Quaternion { x, y, z, w } = transform.rotation;
    let Vector3 {
        x: right,
        y: up,
        z: out,
    } = transform.translation;
    [
        [
            1.0 - 2.0 * (y * y + z * z),
            2.0 * (x * y - z * w),
            2.0 * (x * z + y * w),
            right,
        ],
        [
            2.0 * (x * y + z * w),
            1.0 - 2.0 * (x * x + z * z),
            2.0 * (y * z - x * w),
            up,
        ],
        [
            2.0 * (x * z - y * w),
            2.0 * (y * z + x * w),
            1.0 - 2.0 * (x * x + y * y),
            out,
        ],
        [0.0, 0.0, 0.0, 1.0],
    ]
}

fn product(a: &Matrix, b: &Matrix) -> Matrix {
    core::array::from_fn(|row| {
        core::array::from_fn(|column| (0..4).map(|inner| a[row][inner] * b[inner][column]).sum())
    })
}

fn is_near(a: &Matrix, b: &Matrix, error: f64) -> bool {
    a.iter()
        .flatten()
        .zip(b.iter().flatten())
        .all(|(a, b)| (a - b).abs() < error)
}

fn planar(x: f64, y: f64, theta: f64) -> Transform {
    Pose::from(Pose2D::new(x, y, theta)).into()
}

fn insert(
    tree: &mut Tree,
    child: &str,
    parent: &str,
    stamp: i64,
    transform: Transform,
) -> Result<(), String> {
    let is_static = false;
    tree.insert(&Published {
        parent,
        child,
        stamp,
        transform,
        is_static,
    })
}

fn fix(tree: &mut Tree, child: &str, parent: &str, transform: Transform) -> Result<(), String> {
    let (stamp, is_static) = (0, true);
    tree.insert(&Published {
        parent,
        child,
        stamp,
        transform,
        is_static,
    })
}

/// Frames `f0`, `f1` and so on: the parent of each is one before it.
fn frames() -> impl Strategy<Value = Vec<(usize, Transform, bool)>> {
    let number = || -100.0..100.0;
    let part = || -1.0..1.0;
    let rotation = (part(), part(), part(), part())
        .prop_filter("it has a direction", |(x, y, z, w)| {
            x * x + y * y + z * z + w * w > 0.01
        })
        .prop_map(|(x, y, z, w): (f64, f64, f64, f64)| {
            let length = (x * x + y * y + z * z + w * w).sqrt();
            let [x, y, z, w] = [x, y, z, w].map(|part| part / length);
            Quaternion { x, y, z, w }
        });
    let transform = (number(), number(), number(), rotation).prop_map(|(x, y, z, rotation)| Transform {
        translation: Vector3 { x, y, z },
        rotation,
    });
    proptest::collection::vec((any::<usize>(), transform, any::<bool>()), 1..12)
}

proptest! {
    #[test]
    fn a_lookup_is_the_product_of_the_matrices(frames in frames(), pair in any::<[prop::sample::Index; 2]>()) {
        let mut tree = Tree::default();
        let mut in_root = vec![matrix(&Transform::IDENTITY)];
        for (number, (parent, transform, is_static)) in frames.iter().enumerate() {
            let parent = parent % (number + 1);
            tree.insert(&Published {
                parent: &format!("f{parent}"),
                child: &format!("/f{}", number + 1),
                stamp: SECOND,
                transform: *transform,
                is_static: *is_static,
            })
            .unwrap();
            in_root.push(product(&in_root[parent], &matrix(transform)));
        }
        let [target, source] = pair.map(|index| index.index(in_root.len()));
        let found = tree.lookup(&format!("f{target}"), &format!("f{source}"), None).unwrap();
        let back = product(&in_root[target], &matrix(&found.transform));
        prop_assert!(is_near(&back, &in_root[source], 1e-9), "{back:?} is not {:?}", in_root[source]);
        let inverse = tree.lookup(&format!("f{source}"), &format!("f{target}"), found.stamp).unwrap();
        let nothing = product(&matrix(&found.transform), &matrix(&inverse.transform));
        prop_assert!(is_near(&nothing, &matrix(&Transform::IDENTITY), 1e-9));
    }

    #[test]
    fn between_two_times_it_moves_and_turns_evenly(
        turn in -3.1..3.1, ahead in -5.0..5.0, share in 0.0..1.0, negated in any::<bool>(),
    ) {
        let mut tree = Tree::default();
        let mut end = planar(ahead, 1.0, turn);
        if negated {
            // The same rotation.
            let Quaternion { x, y, z, w } = end.rotation;
            end.rotation = Quaternion { x: -x, y: -y, z: -z, w: -w };
        }
        // They come in any order.
        insert(&mut tree, "base", "odom", 3 * SECOND, end).unwrap();
        insert(&mut tree, "base", "odom", SECOND, Transform::IDENTITY).unwrap();
        let stamp = SECOND + (share * 2e9) as i64;
        let found = tree.lookup("odom", "base", Some(stamp)).unwrap();
        let expected = planar(share * ahead, share, share * turn);
        prop_assert!(is_near(&matrix(&found.transform), &matrix(&expected), 1e-6), "{found:?}");
    }
}

#[test]
fn without_a_time_it_is_the_newest_that_all_frames_have() {
    let mut tree = Tree::default();
    for second in 0..=4 {
        insert(
            &mut tree,
            "base",
            "odom",
            second * SECOND,
            planar(second as f64, 0.0, 0.0),
        )
        .unwrap();
    }
    insert(&mut tree, "odom", "map", 2 * SECOND, planar(10.0, 0.0, 0.0)).unwrap();
    insert(&mut tree, "odom", "map", 3 * SECOND, planar(20.0, 0.0, 0.0)).unwrap();
    fix(&mut tree, "laser", "base", planar(0.5, 0.0, 0.0)).unwrap();
    let found = tree.lookup("map", "laser", None).unwrap();
    assert_eq!(
        (found.stamp, found.transform.translation.x),
        (Some(3 * SECOND), 23.5)
    );
    let fixed = tree.lookup("base", "laser", None).unwrap();
    assert_eq!((fixed.stamp, fixed.transform), (None, planar(0.5, 0.0, 0.0)));
    let itself = tree.lookup("laser", "laser", None).unwrap();
    assert_eq!((itself.stamp, itself.transform), (None, Transform::IDENTITY));
}

#[test]
fn nothing_is_extrapolated() {
    let mut tree = Tree::default();
    insert(&mut tree, "base", "odom", 5 * SECOND, Transform::IDENTITY).unwrap();
    insert(&mut tree, "base", "odom", 6 * SECOND, Transform::IDENTITY).unwrap();
    let error = |stamp| tree.lookup("odom", "base", Some(stamp)).unwrap_err().to_string();
    assert_eq!(
        error(6 * SECOND + 1_500_000),
        "`base` in `odom` ends 0.002 s before the time that is asked for"
    );
    assert_eq!(
        error(SECOND),
        "`base` in `odom` begins 4.000 s after the time that is asked for"
    );
    assert!(tree.lookup("odom", "base", Some(6 * SECOND)).is_ok());
}

#[test]
fn ten_seconds_are_kept() {
    let mut tree = Tree::default();
    for second in 0..30 {
        insert(&mut tree, "base", "odom", second * SECOND, Transform::IDENTITY).unwrap();
    }
    assert!(tree.lookup("odom", "base", Some(19 * SECOND)).is_ok());
    assert!(matches!(
        tree.lookup("odom", "base", Some(18 * SECOND)),
        Err(LookupError::TooOld { .. })
    ));
    let late = insert(&mut tree, "base", "odom", 18 * SECOND, Transform::IDENTITY).unwrap_err();
    assert_eq!(late, "`base` in `odom` comes more than 10 s late");
    insert(&mut tree, "base", "odom", 25 * SECOND, planar(9.0, 0.0, 0.0)).unwrap();
    let first = tree.lookup("odom", "base", Some(25 * SECOND)).unwrap();
    assert_eq!(
        first.transform,
        Transform::IDENTITY,
        "the first of two of one time counts"
    );
}

#[test]
fn unknown_and_unconnected_frames_are_named() {
    let mut tree = Tree::default();
    let error = |tree: &Tree, source| tree.lookup("map", source, None).unwrap_err().to_string();
    assert_eq!(
        error(&tree, "base"),
        "nobody publishes the frame `map`; known are none"
    );
    insert(&mut tree, "odom", "map", SECOND, Transform::IDENTITY).unwrap();
    insert(&mut tree, "base", "wheels", SECOND, Transform::IDENTITY).unwrap();
    assert_eq!(
        error(&tree, "laser"),
        "nobody publishes the frame `laser`; known are base, map, odom, wheels"
    );
    assert_eq!(
        error(&tree, "base"),
        "nothing connects `map` and `base`: they are in the trees of `map` and `wheels`"
    );
}

#[test]
fn a_name_of_a_frame_that_is_too_long_is_refused_by_its_beginning() {
    let mut tree = Tree::default();
    insert(&mut tree, "b", &"a".repeat(255), SECOND, Transform::IDENTITY).unwrap();
    let error = insert(&mut tree, &"ä".repeat(128), "b", SECOND, Transform::IDENTITY).unwrap_err();
    let expected = format!(
        "the name of a frame has more than 255 bytes: `{}`...",
        "ä".repeat(20)
    );
    assert_eq!(error, expected);
}

#[test]
fn a_loop_of_frames_is_refused_and_the_rest_stays() {
    let mut tree = Tree::default();
    insert(&mut tree, "b", "a", SECOND, planar(1.0, 0.0, 0.0)).unwrap();
    insert(&mut tree, "c", "b", SECOND, planar(1.0, 0.0, 0.0)).unwrap();
    for (child, parent) in [("a", "c"), ("a", "b"), ("a", "a")] {
        let error = insert(&mut tree, child, parent, SECOND, Transform::IDENTITY).unwrap_err();
        assert_eq!(
            error,
            format!("`{child}` in `{parent}` would close a loop of frames")
        );
    }
    assert_eq!(tree.lookup("a", "c", None).unwrap().transform.translation.x, 2.0);
}

#[test]
fn a_frame_with_two_parents_has_no_transform_until_one_is_silent() {
    let mut tree = Tree::default();
    insert(&mut tree, "base", "odom", SECOND, Transform::IDENTITY).unwrap();
    fix(&mut tree, "laser", "base", Transform::IDENTITY).unwrap();
    let words = "`base` has two parents, `odom` and `map`: stop one of the nodes that publish it";
    let error = insert(&mut tree, "base", "map", 2 * SECOND, Transform::IDENTITY).unwrap_err();
    assert_eq!(error, words);
    assert_eq!(tree.lookup("odom", "laser", None).unwrap_err().to_string(), words);
    assert!(
        tree.lookup("base", "laser", None).is_ok(),
        "the frames below are certain"
    );

    let mut first_stays = tree.clone();
    insert(&mut first_stays, "base", "odom", 13 * SECOND, Transform::IDENTITY).unwrap();
    assert!(first_stays.lookup("odom", "laser", None).is_ok());
    insert(&mut tree, "base", "map", 12 * SECOND, planar(3.0, 0.0, 0.0)).unwrap();
    assert_eq!(
        tree.lookup("map", "laser", None).unwrap().transform.translation.x,
        3.0
    );
}

#[test]
fn a_frame_that_is_static_and_moves_has_no_transform_until_it_moves_no_more() {
    let mut tree = Tree::default();
    insert(&mut tree, "base", "odom", SECOND, Transform::IDENTITY).unwrap();
    fix(&mut tree, "odom", "map", Transform::IDENTITY).unwrap();
    let words = "`odom` in `map` is static and moves: stop one of the nodes that publish it";
    let error = insert(&mut tree, "odom", "map", SECOND, planar(1.0, 0.0, 0.0)).unwrap_err();
    assert_eq!(error, words);
    assert_eq!(tree.lookup("map", "base", None).unwrap_err().to_string(), words);
    insert(&mut tree, "base", "odom", 13 * SECOND, Transform::IDENTITY).unwrap();
    assert_eq!(
        tree.lookup("map", "base", None).unwrap().transform,
        Transform::IDENTITY
    );

    let mut moving = Tree::default();
    insert(&mut moving, "odom", "map", SECOND, Transform::IDENTITY).unwrap();
    fix(&mut moving, "odom", "map", Transform::IDENTITY).unwrap_err();
    insert(&mut moving, "odom", "map", 13 * SECOND, Transform::IDENTITY).unwrap();
    assert_eq!(moving.lookup("map", "odom", None).unwrap_err().to_string(), words);
}

#[test]
fn a_moving_second_parent_of_a_static_frame_counts_for_10_s() {
    let mut tree = Tree::default();
    insert(&mut tree, "base", "odom", SECOND, Transform::IDENTITY).unwrap();
    fix(&mut tree, "laser", "base", Transform::IDENTITY).unwrap();
    insert(&mut tree, "laser", "plate", SECOND, Transform::IDENTITY).unwrap_err();
    assert!(tree.lookup("odom", "laser", None).is_err());
    insert(&mut tree, "base", "odom", 13 * SECOND, Transform::IDENTITY).unwrap();
    assert!(tree.lookup("odom", "laser", None).is_ok());
}

#[test]
fn a_static_second_parent_counts_at_all_times() {
    let mut tree = Tree::default();
    fix(&mut tree, "laser", "base", Transform::IDENTITY).unwrap();
    fix(&mut tree, "laser", "plate", Transform::IDENTITY).unwrap_err();
    assert!(matches!(
        tree.lookup("base", "laser", None),
        Err(LookupError::TwoParents { .. })
    ));
    insert(&mut tree, "base", "odom", SECOND, Transform::IDENTITY).unwrap();
    fix(&mut tree, "base", "map", Transform::IDENTITY).unwrap_err();
    assert!(tree.lookup("odom", "base", None).is_err());
}

#[test]
fn invalid_numbers_and_names_are_refused() {
    let mut tree = Tree::default();
    let zero = Quaternion {
        w: 0.0,
        ..Quaternion::IDENTITY
    };
    let lying = Transform {
        rotation: zero,
        ..Transform::IDENTITY
    };
    for transform in [
        planar(f64::NAN, 0.0, 0.0),
        planar(0.0, f64::INFINITY, 0.0),
        planar(0.0, 0.0, f64::NAN),
        lying,
    ] {
        let error = insert(&mut tree, "base", "odom", SECOND, transform).unwrap_err();
        assert_eq!(error, "`base` in `odom` has invalid numbers");
    }
    insert(&mut tree, "", "odom", SECOND, Transform::IDENTITY).unwrap_err();
    assert!(tree.lookup("odom", "base", None).is_err());
}

#[test]
fn when_time_jumps_back_only_static_frames_stay() {
    let mut tree = Tree::default();
    insert(&mut tree, "base", "odom", 100 * SECOND, planar(9.0, 0.0, 0.0)).unwrap();
    fix(&mut tree, "laser", "base", planar(0.5, 0.0, 0.0)).unwrap();
    tree.forget_moving();
    assert!(tree.lookup("odom", "laser", None).is_err());
    insert(&mut tree, "base", "odom", SECOND, Transform::IDENTITY).unwrap();
    let found = tree.lookup("odom", "laser", None).unwrap();
    assert_eq!((found.stamp, found.transform.translation.x), (Some(SECOND), 0.5));
}

#[test]
fn without_a_time_the_frame_that_is_silent_is_named() {
    let mut tree = Tree::default();
    insert(&mut tree, "odom", "map", 2 * SECOND, Transform::IDENTITY).unwrap();
    for second in 0..30 {
        insert(&mut tree, "base", "odom", second * SECOND, Transform::IDENTITY).unwrap();
    }
    let error = tree.lookup("map", "base", None).unwrap_err();
    assert_eq!(error.to_string(), "`odom` in `map` has been silent for 27.0 s");
}
