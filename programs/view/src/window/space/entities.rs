//! Finds the variables of an application that the 3D view shows. It reads no values.

use jde_types::{
    Image, LaserScan, Mission, Movers, Odometry, PanTilt, Path, RangeRing, Route, Scenery, Target, Truth,
    Value,
};

use crate::session::WindowSession;

/// Variables by type, each with its full name and its owner. Rebuilt when the number of variables changes.
#[derive(Default)]
pub(super) struct Entities {
    /// The number of variables from which it was built.
    pub(super) made_of: usize,
    pub(super) robots: Vec<[String; 2]>,
    pub(super) lasers: Vec<[String; 2]>,
    pub(super) sonars: Vec<[String; 2]>,
    pub(super) heads: Vec<[String; 2]>,
    pub(super) images: Vec<[String; 2]>,
    pub(super) missions: Vec<[String; 2]>,
    pub(super) targets: Vec<[String; 2]>,
    pub(super) routes: Vec<[String; 2]>,
    pub(super) paths: Vec<[String; 2]>,
    pub(super) scenery: Option<[String; 2]>,
    pub(super) movers: Option<String>,
    pub(super) truth: Option<String>,
}

impl Entities {
    /// Finds the variables of an application.
    pub(super) fn of(session: &WindowSession) -> Self {
        fn exports<T: Value>(session: &WindowSession) -> Vec<[String; 2]> {
            let names = session.exports::<T>();
            names
                .map(|variable| [variable.name.clone(), variable.owner.clone()])
                .collect()
        }
        fn inputs<T: Value>(session: &WindowSession) -> Vec<[String; 2]> {
            let name = T::describe().name;
            let fits = session
                .variables()
                .iter()
                .filter(|variable| variable.type_name == name);
            fits.map(|variable| [variable.name.clone(), variable.owner.clone()])
                .collect()
        }
        let scenery = exports::<Scenery>(session).into_iter().next();
        let of_world = |all: Vec<[String; 2]>| {
            let [_, world] = scenery.as_ref()?;
            all.into_iter()
                .find(|[_, owner]| owner == world)
                .map(|[name, _]| name)
        };
        // The depths of a camera would cover its picture.
        let mut images = exports::<Image>(session);
        images.dedup_by(|later, first| later[1] == first[1]);
        Self {
            made_of: session.variables().len(),
            robots: exports::<Odometry>(session),
            lasers: exports::<LaserScan>(session),
            sonars: exports::<RangeRing>(session),
            heads: exports::<PanTilt>(session),
            images,
            missions: exports::<Mission>(session),
            targets: inputs::<Target>(session),
            routes: inputs::<Route>(session),
            paths: exports::<Path>(session),
            movers: of_world(exports::<Movers>(session)),
            truth: of_world(exports::<Truth>(session)),
            scenery,
        }
    }

    /// The index of the robot that an owner belongs to: the owner itself, or else the first robot.
    pub(super) fn robot(&self, owner: &str) -> usize {
        self.robots
            .iter()
            .position(|[_, robot]| robot == owner)
            .unwrap_or(0)
    }
}
