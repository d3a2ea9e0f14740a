//! Services that variables call and answer, against another node.

use jde_ros_node::{Client, Node, NodeConfig, Request, Response, Service};
use jde_schema::types::{
    EmptyRequest, EmptyResponse, SetBoolRequest, SetBoolResponse, TriggerRequest, TriggerResponse,
};

use super::*;
use crate::Services;
use crate::services::Timed;

/// A driver and another node, which are connected.
struct Pair {
    address: String,
    _router: Session,
    fixture: Fixture<Services>,
    node: Node,
}

impl Pair {
    fn new(entries: &[Entry], other: impl FnOnce(&mut NodeConfig)) -> Self {
        let address = unused_address();
        let router = open_router(&address);
        let mut config = config(&address);
        other(&mut config);
        let node = Node::start(config).unwrap();
        let mut fixture = Fixture::<Services>::with_lists(&address, entries).awake();
        fixture.until_note(Connection::CONNECTED, &address);
        Self {
            address,
            _router: router,
            fixture,
            node,
        }
    }

    fn until<T>(&mut self, mut result: impl FnMut(&Node, &mut Bench<Services>) -> Option<T>) -> T {
        loop {
            self.fixture.step();
            if let Some(result) = result(&self.node, &mut self.fixture.bench) {
                return result;
            }
        }
    }

    /// Iterates until the other node has a request.
    fn request(&mut self) -> Request {
        self.until(|node, _| node.take_request(Duration::ZERO))
    }

    /// Writes a request, again if it fails, until the other node has it: it may not be known yet.
    fn request_again(&mut self, value: &SetBoolRequest) -> Request {
        loop {
            self.fixture.bench.import("light", value);
            let end = Instant::now() + Duration::from_millis(200);
            while Instant::now() < end {
                self.fixture.step();
                if let Some(request) = self.node.take_request(Duration::ZERO) {
                    return request;
                }
            }
        }
    }

    /// Iterates until a request of the other node has its outcome.
    fn response(&mut self) -> Response {
        self.until(|node, _| node.take_response(0))
    }

    /// Iterates until a request of this type is exported.
    fn exported<T: Value>(&mut self, name: &str) -> T {
        self.until(|_, bench| bench.exported::<T>(name))
    }

    /// Iterates for longer than any timeout of these tests.
    fn pause(&mut self) {
        let end = Instant::now() + Duration::from_millis(200);
        while Instant::now() < end {
            self.fixture.step();
        }
    }
}

fn service<Request: Value, Response: Value>(name: &str) -> Service {
    Service::of_values(name.to_owned(), &Request::describe(), &Response::describe()).unwrap()
}

fn switch(timeout: f64) -> [Entry; 2] {
    [
        Entry::new::<SetBoolRequest>("send_request", "light").settings(&Timed { timeout }),
        Entry::new::<SetBoolResponse>("take_response", "light").named("lit"),
    ]
}

fn trigger(timeout: f64) -> [Entry; 2] {
    [
        Entry::new::<TriggerRequest>("take_request", "home")
            .named("asked")
            .settings(&Timed { timeout }),
        Entry::new::<TriggerResponse>("send_response", "home"),
    ]
}

/// The other node offers `/light`.
fn with_light(config: &mut NodeConfig) {
    config
        .services
        .push(service::<SetBoolRequest, SetBoolResponse>("/light"));
}

/// The other node calls `/home`.
fn with_home(config: &mut NodeConfig) {
    config.clients.push(Client {
        service: service::<TriggerRequest, TriggerResponse>("/home"),
        timeout: Duration::from_secs(60),
    });
}

fn on(data: bool) -> SetBoolRequest {
    SetBoolRequest { data: data.into() }
}

fn message<T: Value>(value: &T) -> Vec<u8> {
    Codec::new().encode(value)
}

fn decoded<T: Value>(message: &[u8]) -> T {
    let mut value = T::zeroed();
    Codec::new().decode_into(&[message], &mut value).unwrap();
    value
}

#[test]
fn each_new_value_is_a_request_and_its_response_has_the_time_of_the_value() {
    let mut pair = Pair::new(&switch(60.0), with_light);
    let asked = pair.fixture.start.elapsed();
    pair.fixture.bench.set_now(asked);
    pair.fixture.bench.import("light", &on(true));
    let request = pair.request();
    assert_eq!(decoded::<SetBoolRequest>(&request.message()), on(true));
    // A value that comes meanwhile waits for the response.
    pair.pause();
    pair.fixture.bench.import("light", &on(false));
    pair.pause();
    assert!(pair.node.take_request(Duration::ZERO).is_none());
    let response = SetBoolResponse::new(true, "on");
    pair.node.reply(request, message(&response));
    pair.until(|_, bench| (bench.exported("lit") == Some(response)).then_some(()));
    assert_eq!(pair.fixture.bench.exported_at("lit"), Some(asked));
    let next = pair.request();
    assert_eq!(decoded::<SetBoolRequest>(&next.message()), on(false));
    assert_eq!(
        pair.fixture.bench.exported::<SetBoolResponse>("lit"),
        None,
        "the response to the newest request is not there yet"
    );
    let response = SetBoolResponse::new(false, "it is broken");
    pair.node.reply(next, message(&response));
    pair.until(|_, bench| (bench.exported("lit") == Some(response)).then_some(()));
    pair.pause();
    assert!(
        pair.node.take_request(Duration::ZERO).is_none(),
        "each value once"
    );
    // Neither a value that was a request is one again after a sleep.
    pair.fixture.bench.sleep().unwrap();
    assert_eq!(pair.fixture.bench.exported::<SetBoolResponse>("lit"), None);
    pair.fixture.bench.awake().unwrap();
    pair.pause();
    assert!(pair.node.take_request(Duration::ZERO).is_none());
}

#[test]
fn a_request_without_a_response_is_warned_of_and_the_next_one_is_sent() {
    let mut pair = Pair::new(&switch(0.1), with_light);
    let failed = "a request to /light (std_srvs/srv/SetBool) failed";
    for _ in 0..2 {
        let kept = pair.request_again(&on(true));
        pair.pause();
        assert_eq!(pair.fixture.bench.exported::<SetBoolResponse>("lit"), None);
        assert_eq!(count_log(&pair.fixture.bench, failed), 1);
        // Its response is late.
        pair.node
            .reply(kept, message(&SetBoolResponse::new(true, "late")));
    }
    pair.pause();
    assert_eq!(pair.fixture.bench.exported::<SetBoolResponse>("lit"), None);
    let request = pair.request_again(&on(false));
    pair.node.reply(request, vec![0, 1, 0, 0, 7]);
    pair.pause();
    assert_eq!(
        pair.fixture.bench.exported::<SetBoolResponse>("lit"),
        None,
        "it is not a response of this type"
    );
    while pair.node.take_request(Duration::ZERO).is_some() {}
    // A value that is old when the driver awakes is no request.
    pair.fixture.bench.sleep().unwrap();
    pair.fixture.bench.import("light", &on(true));
    pair.fixture
        .bench
        .set_now(pair.fixture.start.elapsed() + Duration::from_secs(1));
    pair.fixture.bench.awake().unwrap();
    pair.pause();
    assert!(pair.node.take_request(Duration::ZERO).is_none());
}

#[test]
fn a_request_waits_for_the_service_within_its_time() {
    let mut pair = Pair::new(&switch(0.1), |_| ());
    pair.fixture.bench.import("light", &on(true));
    pair.fixture.until_logged("no node offers it within 100ms");
}

#[test]
fn a_request_is_exported_until_the_next_value_responds() {
    let mut pair = Pair::new(&trigger(60.0), with_home);
    pair.until(|node, _| node.has_server(0).then_some(()));
    // What was there before is no response.
    pair.fixture
        .bench
        .import("home", &TriggerResponse::new(false, "old"));
    let calls = [(); 2].map(|()| pair.node.call(0, message(&TriggerRequest::default())));
    for (number, call) in calls.into_iter().enumerate() {
        pair.exported::<TriggerRequest>("asked");
        pair.pause();
        assert!(pair.node.take_response(0).is_none());
        let done = TriggerResponse::new(true, &format!("home {number}"));
        pair.fixture.bench.import("home", &done);
        let response = pair.response();
        assert_eq!(response.sequence, call);
        assert_eq!(decoded::<TriggerResponse>(&response.outcome.unwrap()), done);
    }
    assert_eq!(pair.fixture.bench.exported::<TriggerRequest>("asked"), None);
}

#[test]
fn a_request_that_no_schema_answers_fails_in_words() {
    let mut pair = Pair::new(&trigger(0.1), with_home);
    pair.until(|node, _| node.has_server(0).then_some(()));
    let unanswered = TriggerResponse::new(false, "no schema responded within 100ms");
    // A request does not wait longer than that for those before it.
    let behind = TriggerResponse::new(false, "the requests before it took 100ms");
    let mut seen = Vec::new();
    while !(seen.contains(&unanswered) && seen.contains(&behind)) {
        pair.node.call(0, message(&TriggerRequest::default()));
        pair.node.call(0, message(&TriggerRequest::default()));
        for _ in 0..2 {
            let response = decoded::<TriggerResponse>(&pair.response().outcome.unwrap());
            assert!(response == unanswered || response == behind, "{response:?}");
            seen.push(response);
        }
    }
    assert_eq!(pair.fixture.bench.exported::<TriggerRequest>("asked"), None);
}

#[test]
fn a_value_from_before_the_request_is_no_response_to_it() {
    let mut pair = Pair::new(&trigger(60.0), with_home);
    pair.until(|node, _| node.has_server(0).then_some(()));
    let before = pair.fixture.start.elapsed();
    pair.node.call(0, message(&TriggerRequest::default()));
    pair.exported::<TriggerRequest>("asked");
    // As the response to an earlier request, which comes too late.
    pair.fixture.bench.set_now(before);
    pair.fixture
        .bench
        .import("home", &TriggerResponse::new(true, "late"));
    pair.pause();
    assert!(pair.node.take_response(0).is_none());
    let done = TriggerResponse::new(true, "home");
    pair.fixture.bench.import("home", &done);
    assert_eq!(pair.response().outcome, Ok(message(&done)));
}

#[test]
fn requests_that_wait_are_answered_when_the_driver_sleeps_and_each_is_seen_alone() {
    let mut pair = Pair::new(&trigger(60.0), with_home);
    pair.until(|node, _| node.has_server(0).then_some(()));
    for _ in 0..3 {
        pair.node.call(0, message(&TriggerRequest::default()));
    }
    pair.exported::<TriggerRequest>("asked");
    pair.pause();
    pair.fixture
        .bench
        .import("home", &TriggerResponse::new(true, "home"));
    pair.until(|_, bench| bench.exported::<TriggerRequest>("asked").is_none().then_some(()));
    pair.exported::<TriggerRequest>("asked");
    pair.response();
    pair.fixture.bench.sleep().unwrap();
    for _ in 0..2 {
        let response = loop {
            if let Some(response) = pair.node.take_response(0) {
                break decoded::<TriggerResponse>(&response.outcome.unwrap());
            }
            thread::yield_now();
        };
        assert_eq!(
            response,
            TriggerResponse::new(false, "the schema that offers it sleeps")
        );
    }
}

#[test]
fn a_response_without_fields_for_a_failure_is_an_error_of_zenoh() {
    let entries = [
        Entry::new::<EmptyRequest>("take_request", "/reset")
            .named("asked")
            .settings(&Timed { timeout: 60.0 }),
        Entry::new::<EmptyResponse>("send_response", "/reset"),
    ];
    let mut pair = Pair::new(&entries, |config| {
        config.clients.push(Client {
            service: service::<EmptyRequest, EmptyResponse>("/reset"),
            timeout: Duration::from_secs(60),
        });
    });
    pair.until(|node, _| node.has_server(0).then_some(()));
    pair.node.call(0, message(&EmptyRequest::default()));
    pair.exported::<EmptyRequest>("asked");
    pair.fixture.bench.import("/reset", &EmptyResponse::default());
    assert_eq!(pair.response().outcome, Ok(message(&EmptyResponse::default())));
    pair.node.call(0, message(&EmptyRequest::default()));
    pair.exported::<EmptyRequest>("asked");
    pair.fixture.bench.sleep().unwrap();
    let response = loop {
        if let Some(response) = pair.node.take_response(0) {
            break response;
        }
        thread::yield_now();
    };
    assert!(response.outcome.unwrap_err().contains("sleeps"));
}

#[test]
fn a_request_that_is_none_is_refused_and_a_caller_may_vanish() {
    let mut pair = Pair::new(&trigger(60.0), with_home);
    pair.until(|node, _| node.has_server(0).then_some(()));
    for garbage in [vec![], vec![7], vec![0, 1, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8]] {
        pair.node.call(0, garbage.clone());
        let error = pair.response().outcome.unwrap_err();
        assert!(error.contains("the message"), "{garbage:?}: {error}");
    }
    pair.node.call(0, message(&TriggerRequest::default()));
    pair.exported::<TriggerRequest>("asked");
    // Its response has no receiver.
    let mut config = config(&pair.address);
    with_home(&mut config);
    pair.node = Node::start(config).unwrap();
    pair.fixture
        .bench
        .import("home", &TriggerResponse::new(true, "nobody hears it"));
    pair.until(|_, bench| bench.exported::<TriggerRequest>("asked").is_none().then_some(()));
    pair.until(|node, _| node.has_server(0).then_some(()));
    pair.node.call(0, message(&TriggerRequest::default()));
    pair.exported::<TriggerRequest>("asked");
    let done = TriggerResponse::new(true, "home");
    pair.fixture.bench.import("home", &done);
    assert_eq!(pair.response().outcome, Ok(message(&done)));
}

#[test]
fn requests_beyond_those_that_wait_are_refused_in_words() {
    let mut pair = Pair::new(&trigger(60.0), with_home);
    pair.until(|node, _| node.has_server(0).then_some(()));
    pair.node.call(0, message(&TriggerRequest::default()));
    pair.exported::<TriggerRequest>("asked");
    for _ in 0..10 {
        pair.node.call(0, message(&TriggerRequest::default()));
    }
    let refused = pair.node.call(0, message(&TriggerRequest::default()));
    let response = pair.response();
    assert_eq!(response.sequence, refused);
    assert!(response.outcome.unwrap_err().contains("10 requests wait already"));
}

#[test]
fn an_entry_without_its_partner_or_of_another_type_is_refused() {
    let response = Entry::new::<SetBoolResponse>("take_response", "light").named("lit");
    let request =
        |timeout| Entry::new::<SetBoolRequest>("send_request", "light").settings(&Timed { timeout });
    let [asked, answer] = trigger(1.0);
    let twins = vec![
        asked,
        answer,
        Entry::new::<TriggerRequest>("take_request", "/home").named("again"),
        Entry::new::<TriggerResponse>("send_response", "/home"),
    ];
    for (entries, expected) in [
        (twins, "`home` is the same service"),
        (vec![request(1.0)], "`take_response` has no entry of this name"),
        (vec![response.clone()], "`send_request` has no entry of this name"),
        (vec![request(0.0), response.clone()], "`timeout` is 0 s"),
        (
            vec![Entry::new::<Flag>("send_request", "light"), response.clone()],
            "`std_msgs/msg/Bool` is not the name of a PACKAGE/srv/NAME_Request",
        ),
        (
            vec![Entry::new::<EmptyRequest>("send_request", "light"), response],
            "its request is one of `std_srvs/srv/Empty`, and its response one of `std_srvs/srv/SetBool`",
        ),
    ] {
        let mut bench = Bench::<Services>::with_lists(&entries);
        let problems = bench.inspect().unwrap();
        assert_eq!(problems.len(), 1, "{problems:?}");
        assert!(problems[0].words.contains(expected), "{problems:?}");
    }
}
