//! Tests of value types that an author defines.

#![forbid(unsafe_code)]

use jde_schema::bench::Bench;
use jde_schema::prelude::*;

/// Landmarks around the robot.
#[derive(Clone, Copy, Debug, PartialEq, Value)]
#[repr(C)]
#[value(name = "my_msgs/msg/Landmarks")]
struct Landmarks {
    /// Their poses in the frame of the robot.
    places: Seq<Pose2D, 4>,
    /// The first letters of their names.
    letters: [u8; 4],
    /// Whether all are visible.
    all: Flag,
    /// Unused.
    padding: Padding<3>,
}

/// Exports the landmarks of a route.
#[derive(Describe)]
#[schema(perceptive, period = "100ms")]
struct LandmarkFinder {
    #[import]
    odometry: Import<Odometry>,
    #[modulation(default = Route::EMPTY, fixed)]
    route: Modulation<Route>,
    #[export]
    landmarks: Export<Landmarks>,
}

impl Schema for LandmarkFinder {
    fn iterate(&mut self, cx: &Context) -> Result {
        let pose = self.odometry.require(cx)?.pose2d();
        let route = self.route.sample(cx);
        let landmarks = Landmarks {
            places: route.poses.iter().map(|place| pose.localize(place)).collect(),
            letters: *b"abcd",
            all: (!route.poses.is_empty()).into(),
            padding: Padding::ZERO,
        };
        self.landmarks.write_at(cx, landmarks, cx.now());
        Ok(())
    }
}

#[test]
fn values_of_a_type_of_the_author_are_exported() {
    let mut bench = Bench::<LandmarkFinder>::new();
    bench.set_now(Duration::from_secs(2));
    bench.import(
        "odometry",
        &Odometry::planar(Duration::from_secs(2), Pose2D::new(1.0, 0.0, 0.0), Twist::ZERO),
    );
    bench.iterate().expect("no fault");
    let landmarks: Landmarks = bench.exported("landmarks").expect("published");
    assert!(landmarks.places.is_empty());

    let poses = Seq::from_slice(&[Pose2D::new(3.0, 1.0, 0.0); 6]).expect("they fit");
    bench.set("route", Route { poses });
    bench.iterate().expect("no fault");
    let landmarks: Landmarks = bench.exported("landmarks").expect("published");
    assert_eq!(
        landmarks.places.as_slice(),
        [Pose2D::new(2.0, 1.0, 0.0); 4],
        "as many as the sequence can hold"
    );
    assert!(landmarks.all.get());
}

#[test]
fn the_description_of_a_value_type_has_its_name_fields_and_comments() {
    let ty = <Landmarks as Value>::describe();
    assert_eq!(
        (&*ty.name, &*ty.doc),
        ("my_msgs/msg/Landmarks", "Landmarks around the robot.")
    );
    let fields: Vec<&str> = ty.fields.iter().map(|field| &*field.name).collect();
    assert_eq!(fields, ["places", "letters", "all"]);
    assert_eq!(ty.fields[2].doc, "Whether all are visible.");
}
