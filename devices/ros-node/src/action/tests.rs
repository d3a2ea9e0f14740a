//! Both ends of an action, over a router of Zenoh in this process.

use std::time::Duration;

use serde_json::json;

use super::*;
use crate::interface::standard;
use crate::tests::{Router, until};
use crate::{Client, Node};

const SOON: Duration = Duration::from_secs(5);
const TYPE: &str = "nav2_msgs/action/NavigateToPose";

fn action() -> Action {
    Action::of_interface("/navigate_to_pose".to_owned(), TYPE, standard()).unwrap()
}

/// A message of a part of the action.
fn message(part: &str, value: &Value) -> Vec<u8> {
    standard().encode(&format!("{TYPE}_{part}"), value).unwrap()
}

fn value(part: &str, message: &[u8]) -> Value {
    standard().decode(&format!("{TYPE}_{part}"), message).unwrap()
}

/// The message of a result.
fn result(value: &Value) -> Vec<u8> {
    message("GetResult_Response", &json!({ "result": value }))
}

/// A node at each end, which know each other.
struct Ends {
    client: ActionClient,
    caller: Node,
    server: ActionServer,
    worker: Node,
    router: Router,
}

impl Ends {
    fn new() -> Self {
        let router = Router::open();
        let mut config = router.node("caller");
        let client = ActionClient::declare(action(), SOON, &mut config);
        let caller = Node::start(config).unwrap();
        let mut config = router.node("worker");
        let server = ActionServer::declare(action(), &mut config);
        let worker = Node::start(config).unwrap();
        until(|| client.has_server(&caller).then_some(()));
        Self {
            client,
            caller,
            server,
            worker,
            router,
        }
    }

    /// Waits for the next request at the server, which accepts goals without a behaviour tree.
    fn requested(&mut self) -> ServerEvent {
        let accepts = |goal: &[u8]| value("Goal", goal)["behavior_tree"] == "";
        until(|| {
            let events = self.server.poll(&self.worker, Duration::from_secs(9), accepts);
            assert!(events.len() < 2, "{events:?}");
            events.into_iter().next()
        })
    }

    /// Waits for the next event at the client. The server answers requests meanwhile.
    fn happened(&mut self) -> GoalEvent {
        until(|| {
            let requests = self.server.poll(&self.worker, Duration::from_secs(9), |_| false);
            assert_eq!(requests, []);
            self.client.poll(&self.caller).into_iter().next()
        })
    }

    /// Sends a goal, which the server accepts.
    fn goal(&mut self) -> GoalId {
        let goal = json!({ "pose": { "pose": { "position": { "x": 2.5 } } } });
        self.client.send(&self.caller, &message("Goal", &goal));
        let ServerEvent::Accepted(id, goal) = self.requested() else {
            panic!("a goal was sent");
        };
        assert_eq!(value("Goal", &goal)["pose"]["pose"]["position"]["x"], 2.5);
        assert_eq!(self.happened(), GoalEvent::Accepted);
        id
    }
}

#[test]
fn a_goal_is_accepted_has_feedback_and_ends_with_its_result() {
    let mut ends = Ends::new();
    let id = ends.goal();
    until(|| ends.worker.has_subscribers(0).then_some(()));
    let feedback = message("Feedback", &json!({ "distance_remaining": 1.5 }));
    ends.server.feedback(&ends.worker, id, &feedback);
    assert_eq!(ends.happened(), GoalEvent::Feedback(feedback));
    let why = json!({ "error_code": 3, "error_msg": "no way" });
    ends.server
        .end(&ends.worker, id, GoalStatus::Aborted, Some(result(&why)));
    let GoalEvent::Ended(GoalStatus::Aborted, ended) = ends.happened() else {
        panic!("it has ended");
    };
    let ended = value("GetResult_Response", &ended);
    assert_eq!((&ended["status"], &ended["result"]), (&json!(6), &why));
    assert!(!ends.client.is_active());
}

#[test]
fn a_goal_is_canceled_once_the_server_says_so() {
    let mut ends = Ends::new();
    let id = ends.goal();
    for _ in 0..2 {
        ends.client.cancel(&ends.caller);
    }
    assert_eq!(ends.requested(), ServerEvent::Canceled(id));
    assert!(ends.client.is_active());
    ends.server.end(&ends.worker, id, GoalStatus::Canceled, None);
    let GoalEvent::Ended(status, result) = ends.happened() else {
        panic!("it has ended");
    };
    let result = value("GetResult_Response", &result);
    assert_eq!((status, &result["status"]), (GoalStatus::Canceled, &json!(5)));
    assert_eq!(result["result"]["error_code"], 0);
}

#[test]
fn a_goal_that_is_canceled_before_it_is_accepted_is_canceled_afterwards() {
    let mut ends = Ends::new();
    ends.client.send(&ends.caller, &message("Goal", &json!({})));
    ends.client.cancel(&ends.caller);
    let mut seen = Vec::new();
    until(|| {
        seen.extend(ends.server.poll(&ends.worker, Duration::ZERO, |_| true));
        let _ = ends.client.poll(&ends.caller);
        matches!(seen.last(), Some(ServerEvent::Canceled(_))).then_some(())
    });
}

#[test]
fn a_rejected_goal_and_one_whose_server_is_gone_end_with_the_reason() {
    let mut ends = Ends::new();
    let goal = message("Goal", &json!({ "behavior_tree": "mine.xml" }));
    ends.client.send(&ends.caller, &goal);
    assert_eq!(ends.happened(), GoalEvent::Rejected);
    ends.goal();
    let Ends {
        client,
        caller,
        worker,
        ..
    } = &mut ends;
    let gone = Router::open();
    drop(std::mem::replace(
        worker,
        Node::start(gone.node("other")).unwrap(),
    ));
    let lost = until(|| client.poll(caller).into_iter().next());
    assert!(
        matches!(&lost, GoalEvent::Lost(why) if why.contains("navigate_to_pose")),
        "{lost:?}"
    );
}

#[test]
fn at_most_16_requests_for_the_result_of_a_goal_wait_and_further_ones_are_refused() {
    let mut ends = Ends::new();
    let id = ends.goal();
    let mut config = ends.router.node("curious");
    let [.., result] = action().services;
    config.clients.push(Client {
        service: result,
        timeout: Duration::from_secs(60),
    });
    let curious = Node::start(config).unwrap();
    until(|| curious.has_server(0).then_some(()));
    let ask = |id: GoalId| curious.call(0, message("GetResult_Request", &json!({ "goal_id": uuid(id) })));
    let mut refused = Vec::new();
    let mut asked = Vec::new();
    for _ in 0..17 {
        asked.push(ask(id));
        // The result of an unknown goal is answered at once, after the request before it was taken.
        let answered = ask(GoalId::default());
        until(|| {
            ends.server.poll(&ends.worker, Duration::ZERO, |_| false);
            let response = curious.take_response(0)?;
            let is_answer = response.sequence == answered;
            refused.extend(Some(response).filter(|_| !is_answer));
            is_answer.then_some(())
        });
    }
    let last = until(|| refused.pop().or_else(|| curious.take_response(0)));
    assert_eq!(last.sequence, asked[16]);
    assert!(
        last.outcome
            .unwrap_err()
            .contains("16 requests for this result wait already")
    );
    // One of those that wait may be that of the caller, and the newest ten responses of `curious` are kept.
    ends.server.end(&ends.worker, id, GoalStatus::Succeeded, None);
    let waited = until(|| {
        curious
            .take_response(0)
            .filter(|response| response.sequence == asked[14])
    });
    assert!(waited.outcome.is_ok(), "{waited:?}");
}

#[test]
fn the_envelopes_of_any_action_are_those_of_each() {
    let id = new_id();
    let goal = json!({ "behavior_tree": "mine.xml" });
    let request = message("SendGoal_Request", &json!({ "goal_id": uuid(id), "goal": goal }));
    assert_eq!(with_id(id, &message("Goal", &goal)), request);
    assert_eq!(split_id(&request), Some((id, message("Goal", &goal))));
    let feedback = json!({ "distance_remaining": 2.0, "number_of_recoveries": 3 });
    let sent = message(
        "FeedbackMessage",
        &json!({ "goal_id": uuid(id), "feedback": feedback }),
    );
    assert_eq!(with_id(id, &message("Feedback", &feedback)), sent);
    let accepted = json!({ "accepted": true, "stamp": stamp(Duration::from_secs(7)) });
    assert_eq!(
        encode("SendGoal_Response", &accepted),
        message("SendGoal_Response", &accepted)
    );
    let asked = json!({ "goal_id": uuid(id) });
    assert_eq!(
        encode("GetResult_Request", &asked),
        message("GetResult_Request", &asked)
    );
    for short in [&request[..3], &request[..19], &[]] {
        assert_eq!(split_id(short), None);
    }
}

#[test]
fn a_goal_that_was_replaced_is_canceled_also_if_it_is_accepted_later() {
    let mut ends = Ends::new();
    for _ in 0..2 {
        ends.client.send(&ends.caller, &message("Goal", &json!({})));
    }
    let (mut accepted, mut canceled) = (Vec::new(), Vec::new());
    until(|| {
        for event in ends.server.poll(&ends.worker, Duration::ZERO, |_| true) {
            match event {
                ServerEvent::Accepted(id, _) => accepted.push(id),
                ServerEvent::Canceled(id) => canceled.push(id),
            }
        }
        let _ = ends.client.poll(&ends.caller);
        (accepted.len() == 2 && !canceled.is_empty()).then_some(())
    });
    // Once more if the first request came before the acceptance was known.
    assert!(canceled.iter().all(|id| *id == accepted[0]), "{canceled:?}");
    assert!(ends.client.is_active() && ends.client.is_canceling());
    ends.server
        .end(&ends.worker, accepted[0], GoalStatus::Canceled, None);
    until(|| {
        let _ = ends.client.poll(&ends.caller);
        let _ = ends.server.poll(&ends.worker, Duration::ZERO, |_| true);
        (!ends.client.is_canceling()).then_some(())
    });
}

#[test]
fn a_goal_whose_server_was_away_is_canceled_when_it_is_there_again() {
    let mut ends = Ends::new();
    let id = ends.goal();
    let away = ends.router.node("away");
    ends.worker = Node::start(away).unwrap();
    let lost = until(|| ends.client.poll(&ends.caller).pop());
    assert!(matches!(lost, GoalEvent::Lost(_)), "{lost:?}");
    // The same server, which still has the goal.
    let mut config = ends.router.node("worker");
    let _ = ActionServer::declare(action(), &mut config);
    ends.worker = Node::start(config).unwrap();
    until(|| {
        assert_eq!(ends.client.poll(&ends.caller), []);
        let events = ends.server.poll(&ends.worker, Duration::ZERO, |_| true);
        events.contains(&ServerEvent::Canceled(id)).then_some(())
    });
}

#[test]
fn a_refused_cancellation_is_an_event_and_one_without_an_answer_is_requested_again() {
    let mut ends = Ends::new();
    ends.goal();
    let cancel = |ends: &mut Ends| {
        ends.client.cancel(&ends.caller);
        until(|| ends.worker.take_request_of(1))
    };
    let request = cancel(&mut ends);
    ends.worker.refuse(request, "it is busy".to_owned());
    // The owner asks in each of its turns.
    let request = until(|| {
        ends.client.cancel(&ends.caller);
        assert_eq!(ends.client.poll(&ends.caller), []);
        ends.worker.take_request_of(1)
    });
    let response = encode(&format!("{CANCEL}_Response"), &json!({ "return_code": 1 }));
    ends.worker.reply(request, response);
    assert_eq!(ends.happened(), GoalEvent::NotCanceled);
    assert!(ends.client.is_active());
}

#[test]
fn a_server_of_rclpy_refuses_a_cancellation_by_naming_no_goal() {
    let mut ends = Ends::new();
    ends.goal();
    ends.client.cancel(&ends.caller);
    let request = until(|| ends.worker.take_request_of(1));
    let response = encode(&format!("{CANCEL}_Response"), &json!({}));
    ends.worker.reply(request, response);
    assert_eq!(ends.happened(), GoalEvent::NotCanceled);
    // Nothing more can be done, and the next goal does not wait for it.
    ends.client.give_up(&ends.caller);
    assert!(!ends.client.is_canceling());
}
