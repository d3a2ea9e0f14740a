//! The father on the bench: which children are awake, and why one of them acts.

mod dock;
mod follow;

use jde_schema::bench::Bench;
use jde_schema::panel::Touch;
use jde_schema::types::{ColorBlob, Person, Point2D};

use super::*;

const FAR_POSE: Pose2D = Pose2D::new(2.5, 4.7, 0.0);
const NEAR_POSE: Pose2D = Pose2D::new(1.6, 4.7, 0.0);
const KITCHEN: Pose2D = Pose2D::new(9.0, 7.2, 0.0);

struct Test {
    bench: Bench<Guide>,
    odometry: Odometry,
    now: Duration,
}

impl Test {
    fn new() -> Self {
        let mut bench = Bench::new();
        let room = |name, place| Room {
            name: Text::new(name),
            place,
        };
        let rooms = [room("kitchen", KITCHEN), room("lab", Pose2D::new(2.6, 1.6, 0.0))];
        let rooms = Seq::from_slice(&rooms).expect("they fit");
        bench.set("rooms", Rooms { rooms });
        let poses = Seq::from_slice(&[FAR_POSE, NEAR_POSE]).expect("they fit");
        bench.set("station", Route { poses });
        Self {
            bench,
            odometry: Odometry::default(),
            now: Duration::ZERO,
        }
    }

    /// A robot whose map is closed.
    fn mapped() -> Self {
        let mut test = Self::new();
        test.step();
        test.mission("explored", Mission::DONE, "");
        test.step();
        test
    }

    fn step(&mut self) {
        self.now += Duration::from_millis(200);
        self.bench.set_now(self.now);
        self.bench.import("odometry", &self.odometry);
        self.bench.iterate().expect("it iterates");
    }

    fn steps(&mut self, count: u32) {
        (0..count).for_each(|_| self.step());
    }

    /// A mission for the target that the guide states now, if it is that of a father that navigates.
    fn mission(&mut self, name: &str, state: u8, note: &str) {
        let target = match name {
            "approached" => self.target("dock_target"),
            "led" => self.target("room_target"),
            _ => None,
        };
        self.mission_at(name, state, note, target.unwrap_or_default());
    }

    fn mission_at(&mut self, name: &str, state: u8, note: &str, target: Pose2D) {
        let mission = Mission {
            state,
            note: Text::truncated(note),
            target,
            ..Mission::default()
        };
        self.bench.set_now(self.now + Duration::from_millis(100));
        self.bench.import(name, &mission);
    }

    fn charge(&mut self, percentage: f32) {
        self.battery(percentage, 10.0);
    }

    fn battery(&mut self, percentage: f32, current: f32) {
        let battery = BatteryState {
            percentage,
            current,
            ..BatteryState::default()
        };
        self.bench.import("battery", &battery);
        self.step();
    }

    /// Asks for a room, as an operator.
    fn ask(&mut self, name: &str) {
        self.bench.set("room", Text::<28>::new(name));
        self.step();
    }

    /// Drives through the station, and is before the dock.
    fn at_dock(&mut self) {
        for _ in 0..2 {
            self.mission("approached", Mission::DONE, "");
            self.step();
        }
        assert_eq!(self.awake(), ["dock"]);
    }

    fn has_logged(&self, words: &str) -> bool {
        self.bench.log().iter().any(|(_, line)| line.contains(words))
    }

    fn persons(&mut self, places: &[(u32, f64, f64)]) {
        let persons = places.iter().map(|&(id, x, y)| Person {
            id,
            position: Point2D { x, y },
            ..Person::default()
        });
        let persons = persons.collect();
        self.bench.import(
            "persons",
            &Persons {
                persons,
                ..Persons::default()
            },
        );
    }

    /// The colour is seen in this direction, or nowhere, for so many seconds.
    fn wave(&mut self, bearing: Option<f64>, seconds: u32) {
        self.waves(bearing.as_slice(), seconds);
    }

    /// The colour is seen in these directions, the largest area first.
    fn waves(&mut self, bearings: &[f64], seconds: u32) {
        let blob = |&bearing: &f64| ColorBlob {
            bearing,
            ..ColorBlob::default()
        };
        let blobs = ColorBlobs {
            blobs: bearings.iter().map(blob).collect(),
            ..ColorBlobs::default()
        };
        for _ in 0..5 * seconds {
            self.bench.import("blobs", &blobs);
            self.step();
        }
    }

    /// What becomes of these children, which are READY.
    fn choice(&mut self, ready: &[&str]) -> (Option<String>, String) {
        for child in ["dock", "approach", "lead", "follow", "map", "patrol"] {
            self.bench.set_precondition(child, ready.contains(&child));
        }
        let decision = self.bench.arbitrate("base").expect("it decides");
        (decision.child, decision.reason)
    }

    fn target(&self, name: &str) -> Option<Pose2D> {
        self.bench.exported::<Target>(name).expect("it is exported").get()
    }

    fn awake(&self) -> Vec<&str> {
        self.bench.awake_children()
    }
}

#[test]
fn it_maps_first_and_patrols_all_rooms_then() {
    let mut test = Test::new();
    test.step();
    assert_eq!(test.awake(), ["map", "patrol"]);
    let (child, reason) = test.choice(&["map", "patrol"]);
    assert_eq!(
        (child.as_deref(), reason.as_str()),
        (Some("map"), "the map is not closed")
    );
    let route: Route = test.bench.modulated("patrol", "route").expect("it is set");
    assert_eq!((route.poses.len(), route.poses[0]), (2, KITCHEN));
    test.mission("explored", Mission::DONE, "");
    test.step();
    assert_eq!(test.awake(), ["patrol"]);
    test.mission("explored", Mission::RUNNING, "");
    test.step();
    assert_eq!(test.awake(), ["patrol"], "a map that opens again is no task");
}

#[test]
fn the_task_of_a_child_that_is_not_bound_is_left_out() {
    let without = |names: &[&str]| {
        let mut test = Test::new();
        names.iter().for_each(|name| test.bench.unbind(name));
        test.bench.awake().expect("it awakes");
        test.step();
        test.mission("explored", Mission::DONE, "");
        test.step();
        test
    };
    let mut test = without(&["dock"]);
    test.charge(0.1);
    assert_eq!(test.awake(), ["patrol"]);
    let mut test = without(&["approach"]);
    test.charge(0.1);
    assert_eq!((test.awake(), test.target("dock_target")), (vec!["dock"], None));
    let mut test = without(&["lead", "follow"]);
    test.persons(&[(3, 2.0, 0.0)]);
    test.wave(Some(0.0), 1);
    test.ask("kitchen");
    assert_eq!((test.awake(), test.target("room_target")), (vec!["patrol"], None));
    let state: Text<160> = test.bench.exported("state").expect("it is exported");
    assert_eq!(state.as_str(), "patrol: nothing else is to be done");
}

#[test]
fn a_child_without_its_mission_is_refused() {
    let mut test = Test::new();
    test.bench.unbind("explored");
    let refused = test.bench.awake().expect_err("the map would never be closed");
    assert!(refused.reason.contains("bind `explored`"), "{}", refused.reason);
    test.bench.unbind("map");
    test.bench.awake().expect("it awakes");
}

#[test]
fn charges_and_rooms_that_contradict_are_refused() {
    let mut test = Test::new();
    assert_eq!(test.bench.inspect().expect("it inspects"), []);
    test.bench.set("high", 0.25);
    let room = |name| Room {
        name: Text::new(name),
        place: KITCHEN,
    };
    for (names, words) in [(["lab", "lab"], "two rooms"), (["lab", ""], "room 2 has no name")] {
        let rooms = names.into_iter().map(room).collect();
        test.bench.set("rooms", Rooms { rooms });
        let problems = test.bench.inspect().expect("it inspects");
        assert_eq!(problems[0].modulation, "high");
        assert_eq!(problems[1].modulation, "rooms");
        assert!(problems[1].words.contains(words), "{problems:?}");
    }
}

#[test]
fn it_leads_to_the_room_that_is_asked_for_as_often_as_it_is() {
    let mut test = Test::mapped();
    for _ in 0..2 {
        test.ask("kitchen");
        assert_eq!(test.target("room_target"), Some(KITCHEN));
        let (child, reason) = test.choice(&["lead", "patrol"]);
        assert_eq!(
            (child.as_deref(), reason.as_str()),
            (Some("lead"), "an operator asks for `kitchen`")
        );
        test.mission("led", Mission::DONE, "");
        test.step();
        assert_eq!((test.awake(), test.target("room_target")), (vec!["patrol"], None));
    }
    test.ask("attic");
    assert_eq!(test.awake(), ["patrol"]);
    assert!(test.has_logged("`kitchen`, `lab`"), "{:?}", test.bench.log());
}

#[test]
fn a_room_that_is_not_known_ends_nothing_and_an_empty_name_ends_leading() {
    let mut test = Test::mapped();
    test.ask("kitchen");
    test.ask("kitchn");
    assert_eq!(test.target("room_target"), Some(KITCHEN));
    test.ask("");
    assert_eq!(test.target("room_target"), None);
    assert!(test.has_logged("no room is wanted"), "{:?}", test.bench.log());
}

#[test]
fn what_became_of_another_place_is_not_what_became_of_this_one() {
    let mut test = Test::mapped();
    test.ask("lab");
    let lab = test.target("room_target").expect("it leads there");
    test.ask("kitchen");
    test.mission_at("led", Mission::DONE, "", lab);
    test.step();
    assert_eq!(test.target("room_target"), Some(KITCHEN));
    test.charge(0.1);
    test.mission_at("approached", Mission::DONE, "", NEAR_POSE);
    test.step();
    assert_eq!(test.target("dock_target"), Some(FAR_POSE));
}

#[test]
fn a_room_that_an_earlier_instance_was_asked_for_is_not_led_to() {
    let mut test = Test::new();
    test.bench.set("room", Text::<28>::new("kitchen"));
    test.bench.awake().expect("it awakes");
    test.step();
    assert_eq!(test.awake(), ["map", "patrol"], "an earlier instance was asked");
    test.ask("kitchen");
    assert_eq!(test.target("room_target"), Some(KITCHEN));
}

#[test]
fn the_mission_is_done_when_each_task_is() {
    let mut test = Test::mapped();
    test.bench.set("rounds", 1_u32);
    let mission = |test: &mut Test| {
        test.step();
        let mission: Mission = test.bench.exported("mission").expect("it is exported");
        (mission.state, mission.reached, mission.total)
    };
    assert_eq!(mission(&mut test), (Mission::RUNNING, 1, 5));
    test.ask("lab");
    test.mission("led", Mission::DONE, "");
    test.persons(&[(3, 2.0, 0.0)]);
    test.wave(Some(0.0), 1);
    test.mission("followed", Mission::DONE, "");
    test.charge(0.1);
    for name in ["approached", "approached", "docked"] {
        test.mission(name, Mission::DONE, "");
        test.step();
    }
    test.charge(1.0);
    assert_eq!(mission(&mut test), (Mission::RUNNING, 4, 5));
    let patrolled = Mission {
        reached: 2,
        ..Mission::default()
    };
    test.bench.import("patrolled", &patrolled);
    assert_eq!(mission(&mut test), (Mission::DONE, 5, 5));
}

#[test]
fn its_panel_has_a_button_for_each_room_and_ends_tasks() {
    let mut test = Test::mapped();
    test.bench
        .touch("room kitchen", Touch::Pressed)
        .expect("it is handled");
    test.step();
    assert_eq!(test.target("room_target"), Some(KITCHEN));
    let drawn = format!("{:?}", test.bench.draw().expect("it draws"));
    assert!(drawn.contains("asks for `kitchen`"), "{drawn}");
    test.bench
        .touch("stop leading", Touch::Pressed)
        .expect("it is handled");
    test.step();
    assert_eq!(test.target("room_target"), None);
}

#[test]
fn a_reload_keeps_what_was_done() {
    let mut test = Test::mapped();
    let saved = test.bench.save().expect("it saves");
    let mut next = Test::new();
    next.bench.restore(&saved).expect("it restores");
    next.step();
    assert_eq!(next.awake(), ["patrol"], "the map is closed");
}

#[test]
fn a_reload_goes_on_with_what_is_due() {
    let mut test = Test::mapped();
    test.ask("kitchen");
    test.persons(&[(3, 2.0, 0.0)]);
    test.wave(Some(0.0), 1);
    test.charge(0.1);
    test.at_dock();
    test.charge(0.5);
    let saved = test.bench.save().expect("it saves");
    let mut next = Test::new();
    next.now = test.now;
    next.bench.set("room", Text::<28>::new("kitchen"));
    next.bench.restore(&saved).expect("it restores");
    next.persons(&[(3, 2.0, 0.0)]);
    next.wave(Some(0.0), 2);
    next.charge(0.5);
    assert_eq!(next.awake(), ["dock"], "it charges");
    assert_eq!(next.target("room_target"), Some(KITCHEN));
    next.mission("docked", Mission::DONE, "docked");
    next.charge(0.95);
    assert_eq!(next.awake(), ["lead", "follow", "patrol"], "no new wave");
}

#[test]
fn a_reload_before_the_first_iteration_loses_no_room() {
    let mut test = Test::new();
    test.bench.awake().expect("it awakes");
    let saved = test.bench.save().expect("it saves");
    let mut next = Test::new();
    next.bench.awake().expect("it awakes");
    next.bench.restore(&saved).expect("it restores");
    // It has asked for no room yet, not for the one that the application states either.
    assert_eq!(next.bench.schema().asked, None);
}

#[test]
fn a_patrol_without_rooms_keeps_its_route_and_is_not_counted() {
    let mut test = Test::new();
    test.bench.set("rooms", Rooms::default());
    test.bench.set("rounds", 1_u32);
    for child in ["dock", "lead", "follow", "map"] {
        test.bench.unbind(child);
    }
    test.step();
    assert_eq!(test.bench.modulated::<Route>("patrol", "route"), None);
    let mission: Mission = test.bench.exported("mission").expect("it is exported");
    assert_eq!((mission.state, mission.total), (Mission::RUNNING, 0));
}
