//! An author's own value types are shared like the standard ones.

#![forbid(unsafe_code)]

use jde_schema::bench::Bench;
use jde_schema::prelude::*;

/// Where landmarks stand.
#[derive(Clone, Copy, Debug, PartialEq, Value)]
#[repr(C)]
#[value(name = "my_msgs/msg/Landmarks")]
struct Landmarks {
    /// Their places.
    places: Seq<Pose2D, 4>,
    /// Their names' first letters.
    letters: [u8; 4],
    /// Whether all are seen.
    all: Flag,
    /// Nothing.
    padding: Padding<3>,
}

/// Looks for landmarks.
#[derive(Describe)]
#[schema(perceptive, period = "100ms")]
struct Look {
    #[import]
    odometry: Import<Odometry>,
    #[modulation(default = Route::EMPTY, fixed)]
    route: Modulation<Route>,
    #[export]
    landmarks: Export<Landmarks>,
}

impl Schema for Look {
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
fn an_author_shares_values_of_an_own_type() {
    let mut bench = Bench::<Look>::new();
    bench.set_now(Duration::from_secs(2));
    bench.import(
        "odometry",
        &Odometry::planar(Duration::from_secs(2), Pose2D::new(1.0, 0.0, 0.0), Twist::ZERO),
    );
    bench.iterate().expect("no fault");
    let seen: Landmarks = bench.exported("landmarks").expect("published");
    assert!(seen.places.is_empty());

    let poses = Seq::from_slice(&[Pose2D::new(3.0, 1.0, 0.0); 6]).expect("they fit");
    bench.set("route", Route { poses });
    bench.iterate().expect("no fault");
    let seen: Landmarks = bench.exported("landmarks").expect("published");
    assert_eq!(
        seen.places.as_slice(),
        [Pose2D::new(2.0, 1.0, 0.0); 4],
        "as many as there is room for"
    );
    assert!(seen.all.get());
}

#[test]
fn its_description_is_its_name_and_comments() {
    let ty = <Landmarks as Value>::describe();
    assert_eq!(
        (&*ty.name, &*ty.doc),
        ("my_msgs/msg/Landmarks", "Where landmarks stand.")
    );
    let fields: Vec<&str> = ty.fields.iter().map(|field| &*field.name).collect();
    assert_eq!(fields, ["places", "letters", "all"]);
    assert_eq!(ty.fields[2].doc, "Whether all are seen.");
}
