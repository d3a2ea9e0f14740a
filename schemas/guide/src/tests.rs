//! The father on the bench: which children are awake, and why one of them acts.

use jde_schema::bench::Bench;
use jde_schema::panel::Touch;
use jde_schema::types::{ColorBlob, Person, Point2D};

use super::*;

const FAR: Pose2D = Pose2D::new(2.5, 4.7, 0.0);
const NEAR: Pose2D = Pose2D::new(1.6, 4.7, 0.0);
const KITCHEN: Pose2D = Pose2D::new(9.0, 7.2, 0.0);

struct Test {
    bench: Bench<Guide>,
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
        let poses = Seq::from_slice(&[FAR, NEAR]).expect("they fit");
        bench.set("station", Route { poses });
        bench.import("odometry", &Odometry::default());
        Self {
            bench,
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
        self.bench.iterate().expect("it iterates");
    }

    fn mission(&mut self, name: &str, state: u8, note: &str) {
        let note = Text::truncated(note);
        let mission = Mission {
            state,
            note,
            ..Mission::default()
        };
        self.bench.set_now(self.now + Duration::from_millis(100));
        self.bench.import(name, &mission);
    }

    fn charge(&mut self, percentage: f32) {
        let battery = BatteryState {
            percentage,
            ..BatteryState::default()
        };
        self.bench.import("battery", &battery);
        self.step();
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
        let blob = |bearing| ColorBlob {
            bearing,
            ..ColorBlob::default()
        };
        let blobs = bearing.into_iter().map(blob).collect();
        self.bench.import(
            "blobs",
            &ColorBlobs {
                blobs,
                ..ColorBlobs::default()
            },
        );
        (0..5 * seconds).for_each(|_| self.step());
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
fn it_docks_from_a_low_charge_until_a_high_one() {
    let mut test = Test::mapped();
    test.charge(0.26);
    assert_eq!(test.awake(), ["patrol"]);
    test.charge(0.24);
    assert_eq!(test.awake(), ["approach", "patrol"]);
    let (child, reason) = test.choice(&["approach", "patrol"]);
    assert_eq!(
        (child.as_deref(), reason.as_str()),
        (Some("approach"), "the battery is at 24 %")
    );
    assert_eq!(test.target("dock_target"), Some(FAR));
    test.mission("approached", Mission::DONE, "");
    test.step();
    assert_eq!(test.target("dock_target"), Some(NEAR));
    test.step();
    assert_eq!(test.target("dock_target"), Some(NEAR), "that was another place");
    test.mission("approached", Mission::FAILED, "it came no nearer");
    test.step();
    assert_eq!((test.awake(), test.target("dock_target")), (vec!["dock"], None));
    test.mission("docked", Mission::DONE, "docked");
    test.charge(0.6);
    assert_eq!(test.awake(), ["dock"], "it charges");
    test.charge(f32::NAN);
    assert_eq!(test.awake(), ["dock"]);
    test.charge(0.91);
    assert_eq!(test.awake(), ["patrol"]);
    test.charge(0.24);
    assert_eq!(test.target("dock_target"), Some(FAR), "from the beginning");
}

#[test]
fn without_the_tag_it_comes_to_the_dock_anew() {
    let mut test = Test::mapped();
    test.charge(0.2);
    for _ in 0..2 {
        test.mission("approached", Mission::DONE, "");
        test.step();
    }
    assert_eq!(test.awake(), ["dock"]);
    test.bench.set_child("dock", State::Winner);
    (0..100).for_each(|_| test.step());
    assert_eq!(test.awake(), ["dock"], "it drives there");
    test.bench.set_child("dock", State::Checking);
    (0..45).for_each(|_| test.step());
    assert_eq!(test.awake(), ["dock"], "it waits for a sight");
    (0..10).for_each(|_| test.step());
    assert_eq!(test.target("dock_target"), Some(FAR));
}

#[test]
fn it_leads_to_the_room_that_is_asked_for_as_often_as_it_is() {
    let mut test = Test::mapped();
    for _ in 0..2 {
        test.bench.set("room", Text::<28>::new("kitchen"));
        test.step();
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
    test.bench.set("room", Text::<28>::new("attic"));
    test.step();
    assert_eq!(test.awake(), ["patrol"]);
    let warned = test
        .bench
        .log()
        .iter()
        .any(|(_, line)| line.contains("`kitchen`, `lab`"));
    assert!(warned, "{:?}", test.bench.log());
}

#[test]
fn it_follows_who_waves_until_the_next_wave() {
    let mut test = Test::mapped();
    test.persons(&[(3, 2.0, 2.0), (4, 2.0, -0.1)]);
    test.wave(Some(0.9), 1);
    test.wave(None, 2);
    assert_eq!(test.bench.modulated("follow", "id"), Some(3_u32));
    test.bench.set_child("follow", State::Winner);
    let (child, reason) = test.choice(&["follow", "patrol"]);
    assert_eq!(
        (child.as_deref(), reason.as_str()),
        (Some("follow"), "person 3 waves")
    );
    test.wave(Some(0.9), 1);
    test.wave(None, 10);
    assert_eq!(
        test.awake(),
        ["follow", "patrol"],
        "the robot has turned meanwhile"
    );
    test.wave(Some(0.9), 1);
    assert_eq!(test.awake(), ["patrol"]);
    test.wave(None, 10);
    test.wave(Some(-2.0), 1);
    assert_eq!(test.awake(), ["patrol"], "nobody is there");
    test.persons(&[(4, -1.0, -2.0)]);
    test.wave(Some(-2.0), 1);
    assert_eq!(
        test.bench.modulated("follow", "id"),
        Some(4_u32),
        "now somebody is"
    );
    test.mission("followed", Mission::FAILED, "gave up");
    test.step();
    assert_eq!(test.awake(), ["patrol"]);
}

#[test]
fn a_person_who_is_gone_is_not_followed() {
    let mut test = Test::mapped();
    test.persons(&[(3, 2.0, 0.0)]);
    test.wave(Some(0.0), 1);
    test.bench.set_child("follow", State::Checking);
    test.wave(None, 8);
    assert_eq!(test.awake(), ["follow", "patrol"]);
    test.wave(None, 3);
    assert_eq!(test.awake(), ["patrol"]);
}

#[test]
fn a_colour_that_is_no_number_is_no_wave() {
    let mut test = Test::mapped();
    test.persons(&[(3, f64::NAN, 0.0), (4, 2.0, 0.0)]);
    test.wave(Some(f64::NAN), 1);
    assert_eq!(test.awake(), ["patrol"]);
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
    test.bench.set("room", Text::<28>::new("lab"));
    test.step();
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
