//! Nav2's action from both ends: Nav2 drives for an application, and an application drives for ROS 2.

use jde_ros_node::{ActionClient, ActionServer, GoalEvent, GoalStatus, Middleware, Node, ServerEvent};
use serde_json::{Value as Json, json};

use super::*;
use crate::goal;
use crate::{Goals, Navigate};

/// Nav2, and the schema that lets it drive.
struct Nav2 {
    session: Session,
    node: Node,
    server: ActionServer,
    fixture: Fixture<Navigate>,
    /// The time of the application beyond that of the machine.
    ahead: Duration,
}

impl Nav2 {
    fn new() -> Self {
        Self::behind("")
    }

    /// That of the middleware which this prefix states.
    fn behind(prefix: &str) -> Self {
        let address = unused_address();
        let session = open_router(&address);
        let address = format!("{prefix}{address}");
        let mut config = config(&address);
        let action = goal::action("", "navigate_to_pose", config.name.middleware).unwrap();
        let server = ActionServer::declare(action, &mut config);
        let node = Node::start(config).unwrap();
        let mut fixture = Fixture::<Navigate>::connecting_to(&address);
        fixture.bench.unbind("chosen");
        Self {
            session,
            node,
            server,
            fixture: fixture.awake(),
            ahead: Duration::ZERO,
        }
    }

    /// One turn of a schema that wins whenever it is READY. Returns whether it was.
    fn turn(&mut self) -> bool {
        self.fixture
            .bench
            .set_now(self.fixture.start.elapsed() + self.ahead);
        let ready = self.fixture.bench.check().unwrap().ready;
        if ready {
            self.fixture.bench.iterate().unwrap();
        }
        thread::yield_now();
        ready
    }

    /// Takes turns until Nav2 has a request.
    fn request(&mut self) -> ServerEvent {
        loop {
            self.turn();
            let events = self.server.poll(&self.node, Duration::from_secs(1), |_| true);
            if let Some(event) = events.into_iter().next() {
                return event;
            }
        }
    }

    /// Takes turns until the mission has a state, and returns its note.
    fn until_state(&mut self, state: u8) -> String {
        loop {
            self.turn();
            self.server.poll(&self.node, Duration::from_secs(1), |_| true);
            let mission = self.mission();
            if mission.state == state {
                return mission.note.to_string();
            }
        }
    }

    fn mission(&self) -> Mission {
        self.fixture
            .bench
            .exported::<Mission>("mission")
            .unwrap_or_default()
    }

    /// Takes turns until the schema knows that its goal is rejected.
    fn until_rejected(&mut self) {
        while self.mission().note.as_str() != "Nav2 rejects the target, and is asked again" {
            assert!(self.turn() || self.mission().note.as_str().contains("no node offers"));
            self.server.poll(&self.node, Duration::from_secs(1), |_| false);
        }
    }

    fn aim(&mut self, x: f64) {
        self.fixture
            .bench
            .set("target", Target::at(Pose2D::new(x, 1.0, 0.5)));
    }
}

#[test]
fn nav2_drives_while_the_schema_wins_and_a_lost_goal_is_canceled_and_sent_again() {
    let mut nav2 = Nav2::new();
    assert!(!nav2.turn(), "there is no target");
    nav2.aim(2.0);
    let ServerEvent::Accepted(id, goal) = nav2.request() else {
        panic!("a goal was sent");
    };
    let goal = goal::decode(Middleware::Rmw, "Goal", &goal).unwrap();
    assert_eq!(goal["pose"]["pose"]["position"]["x"], 2.0);
    assert_eq!(goal["pose"]["header"]["frame_id"], "map");
    let twist = Twist::planar(0.3, 0.1);
    while nav2.fixture.bench.commanded("base") != Some(twist) {
        put(&nav2.session, "/nav/cmd_vel", &twist);
        nav2.turn();
    }
    // It is READY, and another schema wins.
    let canceled = loop {
        nav2.fixture.bench.set_now(nav2.fixture.start.elapsed());
        nav2.fixture.bench.check().unwrap();
        thread::yield_now();
        let events = nav2.server.poll(&nav2.node, Duration::from_secs(1), |_| true);
        if let Some(event) = events.into_iter().next() {
            break event;
        }
    };
    assert_eq!(canceled, ServerEvent::Canceled(id));
    nav2.server.end(&nav2.node, id, GoalStatus::Canceled, None);
    let ServerEvent::Accepted(again, _) = nav2.request() else {
        panic!("the goal was sent again");
    };
    assert_ne!(again, id);
    nav2.server.end(&nav2.node, again, GoalStatus::Succeeded, None);
    assert_eq!(nav2.until_state(Mission::DONE), "reached");
    assert!(!nav2.turn(), "it is reached");
    assert_eq!(
        nav2.fixture.bench.exported::<Mission>("mission").unwrap().reached,
        1
    );
}

#[test]
fn a_target_that_nav2_gives_up_fails_with_its_words_until_another_one() {
    let mut nav2 = Nav2::new();
    nav2.aim(2.0);
    let ServerEvent::Accepted(id, _) = nav2.request() else {
        panic!("a goal was sent");
    };
    let result = json!({ "error_code": 204, "error_msg": "no valid path" });
    let result = goal::encode(
        Middleware::Rmw,
        "GetResult_Response",
        &json!({ "result": result }),
    );
    nav2.server.end(&nav2.node, id, GoalStatus::Aborted, Some(result));
    assert_eq!(
        nav2.until_state(Mission::FAILED),
        "Nav2 gave up: error 204 no valid path"
    );
    assert!(!nav2.turn());
    nav2.aim(3.0);
    assert!(matches!(nav2.request(), ServerEvent::Accepted(..)));
}

#[test]
fn nav2_of_humble_gives_up_without_words() {
    let mut nav2 = Nav2::behind("humble/");
    nav2.aim(2.0);
    let ServerEvent::Accepted(id, _) = nav2.request() else {
        panic!("a goal was sent");
    };
    nav2.server.end(&nav2.node, id, GoalStatus::Aborted, None);
    assert_eq!(nav2.until_state(Mission::FAILED), "Nav2 gave up");
}

#[test]
fn a_goal_that_nav2_rejects_because_it_is_not_active_is_sent_again() {
    let mut nav2 = Nav2::new();
    nav2.aim(2.0);
    nav2.until_rejected();
    nav2.ahead += Duration::from_secs(1);
    let ServerEvent::Accepted(id, _) = nav2.request() else {
        panic!("the goal was sent again");
    };
    nav2.server.end(&nav2.node, id, GoalStatus::Succeeded, None);
    assert_eq!(nav2.until_state(Mission::DONE), "reached");
    // The next one is rejected for longer.
    nav2.aim(3.0);
    nav2.until_rejected();
    nav2.ahead += Duration::from_secs(30);
    let rejects = |nav2: &mut Nav2| nav2.server.poll(&nav2.node, Duration::from_secs(1), |_| false);
    while nav2.mission().state != Mission::FAILED {
        nav2.turn();
        rejects(&mut nav2);
    }
    assert_eq!(nav2.mission().note.as_str(), "Nav2 rejects the target");
    assert!(!nav2.turn());
}

#[test]
fn without_nav2_the_schema_is_not_ready_and_says_so() {
    let address = unused_address();
    let _router = open_router(&address);
    let mut fixture = Fixture::<Navigate>::connecting_to(&address);
    fixture.bench.set("target", Target::at(Pose2D::ORIGIN));
    fixture.bench.unbind("chosen");
    let mut fixture = fixture.awake();
    loop {
        fixture.bench.set_now(fixture.start.elapsed());
        assert!(!fixture.bench.check().unwrap().ready);
        let mission = fixture.bench.exported::<Mission>("mission").unwrap();
        if fixture.connection().note.as_str().contains("/navigate_to_pose") {
            assert_eq!(mission.note.as_str(), "no node offers /navigate_to_pose");
            return;
        }
        thread::yield_now();
    }
}

/// A program of ROS 2 that sends goals, and the driver that takes them.
struct Program {
    session: Session,
    node: Node,
    client: ActionClient,
    middleware: Middleware,
    fixture: Fixture<Goals>,
}

impl Program {
    fn new() -> Self {
        Self::behind("")
    }

    /// One of the middleware which this prefix states.
    fn behind(prefix: &str) -> Self {
        let address = unused_address();
        let session = open_router(&address);
        let address = format!("{prefix}{address}");
        let mut config = config(&address);
        let action = goal::action("", "navigate_to_pose", config.name.middleware).unwrap();
        let client = ActionClient::declare(action, Duration::from_secs(5), &mut config);
        let middleware = config.name.middleware;
        let node = Node::start(config).unwrap();
        let mut fixture = Fixture::<Goals>::connecting_to(&address).awake();
        fixture.until(|_| client.has_server(&node));
        Self {
            session,
            node,
            client,
            middleware,
            fixture,
        }
    }

    fn send(&mut self, x: f64, frame: &str) {
        let pose = goal::stamped(Pose2D::new(x, 1.0, 0.0), frame, stamp());
        let goal = goal::encode(self.middleware, "Goal", &json!({ "pose": pose }));
        self.client.send(&self.node, &goal);
    }

    fn event(&mut self) -> GoalEvent {
        loop {
            self.fixture.step();
            let events = self.client.poll(&self.node);
            let mut news = events
                .into_iter()
                .filter(|event| !matches!(event, GoalEvent::Feedback(_)));
            if let Some(event) = news.next() {
                return event;
            }
        }
    }

    /// The next feedback.
    fn feedback(&mut self) -> Json {
        loop {
            self.fixture.step();
            for event in self.client.poll(&self.node) {
                if let GoalEvent::Feedback(feedback) = event {
                    return goal::decode(self.middleware, "Feedback", &feedback).unwrap();
                }
            }
        }
    }

    fn until_target(&mut self, x: Option<f64>) {
        let target = |bench: &Bench<Goals>| bench.exported::<Target>("target").unwrap_or_default().get();
        self.fixture.until(|bench| target(bench).map(|pose| pose.x) == x);
    }

    /// The mission of who drives to the present target.
    fn drive(&mut self, state: u8, note: &str) {
        let target = self.fixture.bench.exported::<Target>("target");
        self.state(target.unwrap().get().unwrap(), state, note);
    }

    fn state(&mut self, target: Pose2D, state: u8, note: &str) {
        let mission = Mission {
            state,
            note: Text::new(note),
            target,
            distance: 0.5,
            ..Mission::default()
        };
        self.fixture.bench.set_now(self.fixture.start.elapsed());
        self.fixture.bench.import("mission", &mission);
    }

    fn end(&mut self) -> (GoalStatus, Json) {
        match self.event() {
            GoalEvent::Ended(status, result) => {
                let mut result = goal::decode(self.middleware, "GetResult_Response", &result).unwrap();
                (status, result["result"].take())
            }
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn a_goal_of_ros_2_is_a_target_and_ends_as_the_mission_does() {
    let mut program = Program::new();
    program.until_target(None);
    program.send(2.0, "map");
    assert_eq!(program.event(), GoalEvent::Accepted);
    program.until_target(Some(2.0));
    // What is not known is not reported: the mission is of another target, then not planned yet.
    program.state(Pose2D::ORIGIN, Mission::RUNNING, "");
    program.fixture.step();
    let target = Pose2D::new(2.0, 1.0, 0.0);
    let planning = Mission {
        target,
        ..Mission::default()
    };
    program.fixture.bench.import("mission", &planning);
    program.fixture.step();
    program.drive(Mission::RUNNING, "");
    assert_eq!(program.feedback()["distance_remaining"], 0.5);
    program.drive(Mission::DONE, "");
    assert_eq!(program.end().0, GoalStatus::Succeeded);
    program.until_target(None);

    program.send(3.0, "map");
    assert_eq!(program.event(), GoalEvent::Accepted);
    program.until_target(Some(3.0));
    program.drive(Mission::FAILED, "no way");
    let (status, result) = program.end();
    assert_eq!(
        (status, &result["error_msg"]),
        (GoalStatus::Aborted, &json!("no way"))
    );
    program.until_target(None);

    // The same target again: it waits until the mission no longer states the end of the first.
    program.send(3.0, "map");
    assert_eq!(program.event(), GoalEvent::Accepted);
    program.state(Pose2D::new(3.0, 1.0, 0.0), Mission::FAILED, "no way");
    program.fixture.step();
    program.until_target(None);
    program.state(Pose2D::ORIGIN, Mission::RUNNING, "no target");
    program.until_target(Some(3.0));
    program.drive(Mission::DONE, "");
    assert_eq!(program.end().0, GoalStatus::Succeeded);
}

#[test]
fn a_goal_of_humble_ends_without_words() {
    let mut program = Program::behind("humble/");
    program.send(2.0, "map");
    assert_eq!(program.event(), GoalEvent::Accepted);
    program.until_target(Some(2.0));
    program.drive(Mission::FAILED, "no way");
    assert_eq!(program.end(), (GoalStatus::Aborted, json!({ "result": {} })));
}

#[test]
fn a_goal_is_canceled_and_another_target_takes_its_place() {
    let mut program = Program::new();
    program.send(2.0, "map");
    assert_eq!(program.event(), GoalEvent::Accepted);
    program.until_target(Some(2.0));
    program.client.cancel(&program.node);
    assert_eq!(program.end().0, GoalStatus::Canceled);
    program.until_target(None);

    program.send(3.0, "map");
    assert_eq!(program.event(), GoalEvent::Accepted);
    let pose = PoseStamped {
        header: Header::new(stamp(), "map"),
        pose: Pose2D::new(4.0, 0.0, 0.0).into(),
    };
    put(&program.session, "/goal_pose", &pose);
    program.until_target(Some(4.0));
    let (status, result) = program.end();
    assert_eq!(status, GoalStatus::Aborted);
    assert_eq!(result["error_msg"], "another target took its place");
}

#[test]
fn a_goal_in_another_frame_or_in_none_is_rejected_in_words() {
    let mut program = Program::new();
    // What a program sends that fills nothing in.
    program.client.send(
        &program.node,
        &goal::encode(program.middleware, "Goal", &json!({})),
    );
    assert_eq!(program.event(), GoalEvent::Rejected);
    program
        .fixture
        .until_logged("a goal is rejected: its frame_id is empty");
    program.send(2.0, "odom");
    assert_eq!(program.event(), GoalEvent::Rejected);
    assert_eq!(
        count_log(
            &program.fixture.bench,
            "a goal is rejected: it is in the frame \"odom\""
        ),
        1
    );
    let pose = PoseStamped {
        header: Header::new(stamp(), "odom"),
        pose: Pose2D::ORIGIN.into(),
    };
    program.fixture.until(|bench| {
        put(&program.session, "/goal_pose", &pose);
        count_log(
            bench,
            "/goal_pose: a pose is ignored: it is in the frame \"odom\"",
        ) == 1
    });
    program.until_target(None);
}
