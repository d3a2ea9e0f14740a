//! Actions that commands and variables call and carry out, against another node.

use std::collections::VecDeque;

use jde_ros_node::{Action, ActionClient, ActionServer, GoalEvent, GoalId, GoalStatus, Node, ServerEvent};

use super::*;
use crate::Actions;
use crate::services::Timed;

/// Counts to a number.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "demo/action/Count_Goal")]
struct CountGoal {
    header: Header,
    last: i32,
}

/// How far it is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "demo/action/Count_Feedback")]
struct CountFeedback {
    number: i32,
}

/// What was counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "demo/action/Count_Result")]
struct CountResult {
    sum: f64,
}

/// How it has ended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "demo/action/Count_GetResult_Response")]
struct CountEnd {
    status: i8,
    padding: Padding<7>,
    result: CountResult,
}

impl CountEnd {
    fn new(status: i8, sum: f64) -> Self {
        Self {
            status,
            padding: Padding::ZERO,
            result: CountResult { sum },
        }
    }
}

fn action() -> Action {
    let (goal, end, feedback) = (
        CountGoal::describe(),
        CountEnd::describe(),
        CountFeedback::describe(),
    );
    Action::of_values("/count".to_owned(), &goal, &end, &feedback).unwrap()
}

fn to(last: i32) -> CountGoal {
    CountGoal {
        last,
        ..CountGoal::default()
    }
}

fn message<T: Value>(value: &T) -> Vec<u8> {
    Codec::new().encode(value)
}

fn decoded<T: Value>(message: &[u8]) -> T {
    let mut value = T::zeroed();
    Codec::new().decode_into(&[message], &mut value).unwrap();
    value
}

/// A driver that sends goals, and the node that carries them out.
struct Sender {
    _router: Session,
    fixture: Fixture<Actions>,
    node: Node,
    server: ActionServer,
    /// Whether the node accepts goals.
    accepts: bool,
}

impl Sender {
    fn new(timeout: f64) -> Self {
        let entries = [
            Entry::new::<CountGoal>("send_goal", "count")
                .named("goal")
                .settings(&Timed { timeout }),
            Entry::new::<CountFeedback>("take_feedback", "count").named("feedback"),
            Entry::new::<CountEnd>("take_result", "count").named("end"),
        ];
        let address = unused_address();
        let router = open_router(&address);
        let mut config = config(&address);
        let server = ActionServer::declare(action(), &mut config);
        let node = Node::start(config).unwrap();
        let mut fixture = Fixture::<Actions>::with_lists(&address, &entries).awake();
        fixture.until_note(Connection::CONNECTED, &address);
        Self {
            _router: router,
            fixture,
            node,
            server,
            accepts: true,
        }
    }

    /// One turn of a winner that commands this goal, or of nobody. Returns what the node is asked.
    fn turn(&mut self, goal: Option<CountGoal>) -> Vec<ServerEvent> {
        if let Some(goal) = goal {
            self.fixture.bench.set_now(self.fixture.start.elapsed());
            self.fixture.bench.command("goal", &goal);
        }
        self.fixture.step();
        let accepts = self.accepts;
        self.server.poll(&self.node, Duration::from_secs(9), |_| accepts)
    }

    /// Commands this goal until the node has it, and nothing else.
    fn accepted(&mut self, goal: CountGoal) -> (GoalId, CountGoal) {
        loop {
            match self.turn(Some(goal)).as_slice() {
                [] => {}
                [ServerEvent::Accepted(id, message)] => return (*id, decoded(message)),
                events => panic!("{events:?}"),
            }
        }
    }

    fn end(&self) -> Option<CountEnd> {
        self.fixture.bench.exported("end")
    }

    /// Takes turns until a goal has ended with this state.
    fn until_end(&mut self, goal: Option<CountGoal>, status: i8) -> CountEnd {
        loop {
            assert_eq!(self.turn(goal), [], "each goal once");
            if let Some(end) = self.end().filter(|end| end.status == status) {
                return end;
            }
        }
    }

    /// Takes turns for a while.
    fn pause(&mut self, goal: Option<CountGoal>) {
        let end = Instant::now() + Duration::from_millis(200);
        while Instant::now() < end {
            assert_eq!(self.turn(goal), []);
        }
    }
}

#[test]
fn a_command_is_a_goal_once_and_its_end_has_the_time_of_the_command() {
    let mut sender = Sender::new(60.0);
    let begun = sender.fixture.start.elapsed();
    let (id, goal) = sender.accepted(to(3));
    assert_eq!(goal.last, 3);
    assert!(goal.header.stamp.sec > 1_000_000_000, "in the time of ROS 2");
    while sender.fixture.bench.exported("feedback") != Some(CountFeedback { number: 2 }) {
        let feedback = message(&CountFeedback { number: 2 });
        sender.server.feedback(&sender.node, id, &feedback);
        // Its stamp does not make it another goal.
        let stamped = CountGoal {
            header: Header::new(sender.fixture.start.elapsed(), ""),
            ..to(3)
        };
        assert_eq!(sender.turn(Some(stamped)), []);
    }
    let result = message(&CountEnd::new(0, 6.0));
    sender
        .server
        .end(&sender.node, id, GoalStatus::Succeeded, Some(result));
    assert_eq!(sender.until_end(Some(to(3)), 4), CountEnd::new(4, 6.0));
    let time = sender.fixture.bench.exported_at("end").unwrap();
    assert!(time >= begun && time < sender.fixture.start.elapsed());
    sender.pause(Some(to(3)));
    // Another goal retracts the end of the one before.
    let (id, goal) = sender.accepted(to(4));
    assert_eq!((goal.last, sender.end()), (4, None));
    assert_eq!(sender.fixture.bench.exported::<CountFeedback>("feedback"), None);
    sender.server.end(&sender.node, id, GoalStatus::Aborted, None);
    assert_eq!(sender.until_end(Some(to(4)), 6), CountEnd::new(6, 0.0));
}

#[test]
fn a_goal_that_is_no_longer_commanded_is_canceled_and_then_another_one() {
    let mut sender = Sender::new(60.0);
    let (id, _) = sender.accepted(to(3));
    let canceled = loop {
        if let Some(event) = sender.turn(None).pop() {
            break event;
        }
    };
    assert_eq!(canceled, ServerEvent::Canceled(id));
    sender.server.end(&sender.node, id, GoalStatus::Canceled, None);
    sender.until_end(None, 5);
    let (again, _) = sender.accepted(to(3));
    assert_ne!(again, id);
    // Another goal takes its place, once it has ended.
    while !sender.turn(Some(to(5))).contains(&ServerEvent::Canceled(again)) {}
    sender.pause(Some(to(5)));
    sender.server.end(&sender.node, again, GoalStatus::Canceled, None);
    let (five, goal) = sender.accepted(to(5));
    assert_eq!(goal.last, 5);
    sender.server.end(&sender.node, five, GoalStatus::Succeeded, None);
    sender.until_end(Some(to(5)), 4);
    // The driver sleeps.
    let (last, _) = sender.accepted(to(7));
    sender.fixture.bench.sleep().unwrap();
    assert_eq!(sender.end(), None);
    let canceled = ServerEvent::Canceled(last);
    let now = Duration::from_secs(9);
    while !sender
        .server
        .poll(&sender.node, now, |_| true)
        .contains(&canceled)
    {
        thread::yield_now();
    }
}

#[test]
fn a_goal_that_nobody_carries_out_ends_without_a_state() {
    let mut sender = Sender::new(60.0);
    sender.accepts = false;
    sender.until_end(Some(to(3)), 0);
    let failed = "a goal of /count failed: it is rejected";
    assert_eq!(count_log(&sender.fixture.bench, failed), 1);
    sender.pause(Some(to(3)));

    let address = unused_address();
    let _router = open_router(&address);
    let entries = [
        Entry::new::<CountGoal>("send_goal", "count").settings(&Timed { timeout: 0.1 }),
        Entry::new::<CountFeedback>("take_feedback", "count").named("feedback"),
        Entry::new::<CountEnd>("take_result", "count").named("end"),
    ];
    let mut fixture = Fixture::<Actions>::with_lists(&address, &entries).awake();
    fixture.until_note(Connection::CONNECTED, &address);
    while fixture.bench.exported("end") != Some(CountEnd::default()) {
        fixture.bench.command("count", &to(3));
        fixture.step();
    }
    assert_eq!(
        count_log(&fixture.bench, "failed: no node offers it within 100ms"),
        1
    );
}

#[test]
fn a_goal_that_is_accepted_too_late_is_canceled() {
    let mut sender = Sender::new(0.1);
    while sender.end() != Some(CountEnd::default()) {
        sender.fixture.bench.command("goal", &to(3));
        sender.fixture.step();
    }
    let late = "a goal of /count failed: no node has accepted it within 100ms";
    assert_eq!(count_log(&sender.fixture.bench, late), 1);
    // The request for the goal and its cancellation may be taken together.
    let mut events = Vec::new();
    let canceled = |events: &[ServerEvent]| match events.first() {
        Some(ServerEvent::Accepted(id, _)) => events.contains(&ServerEvent::Canceled(*id)),
        _ => false,
    };
    while !canceled(&events) {
        events.extend(sender.turn(Some(to(3))));
    }
}

/// A driver that carries goals out, and the node that sends them.
struct Taker {
    address: String,
    _router: Session,
    fixture: Fixture<Actions>,
    node: Node,
    client: ActionClient,
    events: VecDeque<GoalEvent>,
}

impl Taker {
    fn new() -> Self {
        let entries = [
            Entry::new::<CountGoal>("take_goal", "count").named("goal"),
            Entry::new::<CountFeedback>("send_feedback", "count").named("feedback"),
            Entry::new::<CountEnd>("send_result", "count").named("end"),
        ];
        let address = unused_address();
        let router = open_router(&address);
        let mut config = config(&address);
        let client = ActionClient::declare(action(), Duration::from_secs(5), &mut config);
        let node = Node::start(config).unwrap();
        let mut fixture = Fixture::<Actions>::with_lists(&address, &entries).awake();
        fixture.until(|_| client.has_server(&node));
        Self {
            address,
            _router: router,
            fixture,
            node,
            client,
            events: VecDeque::new(),
        }
    }

    fn event(&mut self) -> GoalEvent {
        loop {
            if let Some(event) = self.events.pop_front() {
                return event;
            }
            self.fixture.step();
            self.events.extend(self.client.poll(&self.node));
        }
    }

    /// Sends a goal, which is exported.
    fn send(&mut self, last: i32) {
        self.client.send(&self.node, &message(&to(last)));
        assert_eq!(self.event(), GoalEvent::Accepted);
        self.until_goal(Some(last));
    }

    fn until_goal(&mut self, last: Option<i32>) {
        let exported = |bench: &Bench<Actions>| bench.exported::<CountGoal>("goal").map(|goal| goal.last);
        self.fixture.until(|bench| exported(bench) == last);
    }

    fn write<T: Value>(&mut self, name: &str, value: &T) {
        self.fixture.bench.set_now(self.fixture.start.elapsed());
        self.fixture.bench.import(name, value);
    }

    fn ended(&mut self) -> (GoalStatus, CountEnd) {
        match self.event() {
            GoalEvent::Ended(status, message) => (status, decoded(&message)),
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn a_goal_is_exported_until_the_next_value_ends_it() {
    let mut taker = Taker::new();
    // What was there before neither ends a goal nor is feedback to it.
    taker.write("end", &CountEnd::new(4, 1.0));
    taker.write("feedback", &CountFeedback { number: 1 });
    taker.send(3);
    while taker.events.is_empty() {
        taker.write("feedback", &CountFeedback { number: 2 });
        taker.fixture.step();
        taker.events.extend(taker.client.poll(&taker.node));
    }
    let feedback = message(&CountFeedback { number: 2 });
    assert_eq!(taker.event(), GoalEvent::Feedback(feedback));
    taker.write("end", &CountEnd::new(4, 6.0));
    let ended = loop {
        match taker.event() {
            GoalEvent::Feedback(_) => {}
            GoalEvent::Ended(status, message) => break (status, decoded::<CountEnd>(&message)),
            other => panic!("{other:?}"),
        }
    };
    assert_eq!(ended, (GoalStatus::Succeeded, CountEnd::new(4, 6.0)));
    taker.until_goal(None);
    // A result that states no end.
    taker.send(5);
    taker.write("end", &CountEnd::new(0, 7.0));
    assert_eq!(taker.ended(), (GoalStatus::Aborted, CountEnd::new(6, 7.0)));
    let said = "/count: a result states neither 4 (succeeded), 5 (canceled) nor 6 (aborted)";
    assert_eq!(count_log(&taker.fixture.bench, said), 1);
}

#[test]
fn a_goal_is_canceled_replaced_and_aborted_when_the_driver_sleeps() {
    let mut taker = Taker::new();
    taker.send(3);
    taker.client.cancel(&taker.node);
    assert_eq!(taker.ended(), (GoalStatus::Canceled, CountEnd::new(5, 0.0)));
    taker.until_goal(None);

    taker.send(4);
    let mut other = config(&taker.address);
    let mut second = ActionClient::declare(action(), Duration::from_secs(5), &mut other);
    let node = Node::start(other).unwrap();
    taker.fixture.until(|_| second.has_server(&node));
    second.send(&node, &message(&to(5)));
    assert_eq!(taker.ended().0, GoalStatus::Aborted);
    taker.until_goal(Some(5));

    while !second.poll(&node).contains(&GoalEvent::Accepted) {
        taker.fixture.step();
    }
    taker.fixture.bench.sleep().unwrap();
    assert_eq!(taker.fixture.bench.exported::<CountGoal>("goal"), None);
    // The request for the result may come too late.
    let ended = loop {
        if let Some(event) = second.poll(&node).pop() {
            break event;
        }
        thread::yield_now();
    };
    assert!(
        matches!(
            ended,
            GoalEvent::Ended(GoalStatus::Aborted, _) | GoalEvent::Lost(_)
        ),
        "{ended:?}"
    );
}

#[test]
fn a_goal_that_is_no_message_of_its_type_is_rejected() {
    let mut taker = Taker::new();
    taker.client.send(&taker.node, &[0, 1, 0, 0, 7]);
    assert_eq!(taker.event(), GoalEvent::Rejected);
    assert_eq!(
        count_log(&taker.fixture.bench, "a goal of /count is rejected: "),
        1
    );
}

#[test]
fn entries_that_are_no_action_are_refused() {
    let goal = Entry::new::<CountGoal>("send_goal", "count").named("goal");
    let feedback = Entry::new::<CountFeedback>("take_feedback", "count").named("feedback");
    let end = Entry::new::<CountEnd>("take_result", "count").named("end");
    let wrong = Entry::new::<CountResult>("take_result", "count").named("end");
    let twins = ["count", "/count"].map(|key| {
        [
            Entry::new::<CountGoal>("send_goal", key).named(&format!("goal{key}")),
            Entry::new::<CountFeedback>("take_feedback", key).named(&format!("feedback{key}")),
            Entry::new::<CountEnd>("take_result", key).named(&format!("end{key}")),
        ]
    });
    for (entries, expected) in [
        (twins.concat(), "`count` is the same action"),
        (
            vec![goal.clone(), feedback.clone()],
            "`take_result` has no entry of this name; an action has a goal, feedback and a result",
        ),
        (
            vec![feedback.clone(), end],
            "`send_goal` has no entry of this name; an action has a goal, feedback and a result",
        ),
        (
            vec![goal, feedback, wrong],
            "`demo/action/Count_Result` is not the name of a PACKAGE/action/NAME_GetResult_Response",
        ),
    ] {
        let mut bench = Bench::<Actions>::with_lists(&entries);
        bench.set("domain", 3_i32);
        let problems = bench.inspect().unwrap();
        assert!(
            problems.iter().any(|problem| problem.words.contains(expected)),
            "{problems:?}"
        );
    }
}
