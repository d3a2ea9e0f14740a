//! A fake camera made of channels: the test opens it, sends its pictures, and removes it.

use std::sync::Mutex;
use std::sync::mpsc::Sender;

use jde_watchdog::Watchdog;

use super::*;
use crate::format::Format;

/// The results of the next attempts to open it.
struct Fake {
    attempts: Mutex<Receiver<Result<FakeStream, String>>>,
}

struct FakeStream {
    frames: Receiver<Result<Vec<u8>, String>>,
}

impl Source for Fake {
    fn open(&self) -> Result<Box<dyn Stream>, String> {
        let result = self
            .attempts
            .lock()
            .expect("one at a time")
            .recv()
            .expect("the test sends a result");
        result.map(|stream| Box::new(stream) as Box<dyn Stream>)
    }

    fn device(&self) -> &str {
        "/dev/fake"
    }
}

impl Stream for FakeStream {
    fn name(&self) -> &str {
        "fake"
    }

    fn shape(&self) -> Shape {
        Shape {
            format: Format::Grey,
            width: 2,
            height: 1,
            stride: 0,
        }
    }

    fn newest(&mut self, into: &mut Vec<u8>) -> Result<bool, String> {
        let mut arrived = false;
        while let Ok(frame) = self.frames.try_recv() {
            *into = frame?;
            arrived = true;
        }
        Ok(arrived)
    }
}

type OpenResults = Sender<Result<FakeStream, String>>;

fn feed() -> (Feed, OpenResults) {
    let (results, attempts) = mpsc::channel();
    (
        Feed::new(
            Fake {
                attempts: Mutex::new(attempts),
            },
            Backoff::default(),
        ),
        results,
    )
}

/// Makes the next attempt succeed, and returns the sender of its pictures.
fn open_camera(results: &OpenResults) -> Sender<Result<Vec<u8>, String>> {
    let (frames, stream) = mpsc::channel();
    results
        .send(Ok(FakeStream { frames: stream }))
        .expect("the feed opens the camera");
    frames
}

fn until(feed: &mut Feed, now: Duration, condition: fn(&State) -> bool) {
    let _watchdog = Watchdog::for_test();
    while !condition(feed.state()) {
        assert_eq!(feed.step(now), None);
        thread::yield_now();
    }
}

fn is_open(state: &State) -> bool {
    matches!(state, State::Open { .. })
}

fn is_lost(state: &State) -> bool {
    matches!(state, State::Lost { .. })
}

fn lost(feed: &Feed) -> (&str, Duration) {
    match feed.state() {
        State::Lost { reason, retry_at } => (reason, *retry_at),
        State::Idle | State::Opening(_) | State::Open { .. } => panic!("the camera is not lost"),
    }
}

fn grey(left: u8, right: u8) -> Option<FeedEvent> {
    let rgb = [[left; 3], [right; 3]].concat();
    Some(FeedEvent::Picture(Picture {
        width: 2,
        height: 1,
        rgb,
    }))
}

#[test]
fn each_step_returns_the_newest_picture_once() {
    let (mut feed, results) = feed();
    let frames = open_camera(&results);
    until(&mut feed, Duration::ZERO, is_open);
    assert_eq!(feed.step(Duration::ZERO), None);
    frames.send(Ok(vec![1, 2])).expect("it is open");
    frames.send(Ok(vec![3, 4])).expect("it is open");
    assert_eq!(feed.step(Duration::ZERO), grey(3, 4));
    assert_eq!(feed.step(Duration::ZERO), None);
}

#[test]
fn opening_a_camera_blocks_no_step() {
    let (mut feed, results) = feed();
    for second in 0..100 {
        assert_eq!(feed.step(Duration::from_secs(second)), None);
    }
    assert!(
        matches!(feed.state(), State::Opening(_)),
        "the camera is not open yet"
    );
    assert_eq!(feed.attempts(), 1, "there is only one attempt");
    let _frames = open_camera(&results);
    until(&mut feed, Duration::from_secs(100), is_open);
}

#[test]
fn attempts_to_open_a_missing_camera_have_increasing_intervals() {
    let (mut feed, results) = feed();
    let (mut now, mut waits) = (Duration::ZERO, Vec::new());
    for _ in 0..6 {
        results
            .send(Err("/dev/fake: it is not there".to_owned()))
            .expect("the feed opens the camera");
        until(&mut feed, now, is_lost);
        let (reason, retry_at) = lost(&feed);
        assert_eq!(reason, "/dev/fake: it is not there");
        waits.push((retry_at - now).as_millis());
        feed.step(retry_at - Duration::from_nanos(1));
        assert!(is_lost(feed.state()), "there is no attempt before its time");
        now = retry_at;
        feed.step(now);
    }
    assert_eq!(waits, [250, 500, 1000, 2000, 4000, 4000]);
}

#[test]
fn an_unplugged_or_silent_camera_is_lost_and_reopened() {
    let (mut feed, results) = feed();
    let frames = open_camera(&results);
    until(&mut feed, Duration::ZERO, is_open);
    frames.send(Ok(vec![1, 2])).expect("it is open");
    assert_eq!(feed.step(Duration::ZERO), grey(1, 2));
    frames.send(Err("it is gone".to_owned())).expect("it is open");
    assert_eq!(feed.step(Duration::ZERO), None);
    let (reason, retry_at) = lost(&feed);
    assert_eq!(reason, "/dev/fake: it is gone");

    let frames = open_camera(&results);
    feed.step(retry_at);
    until(&mut feed, retry_at, is_open);
    let shown = retry_at + SILENCE - Duration::from_nanos(1);
    frames.send(Ok(vec![3, 4])).expect("it is open");
    assert_eq!(feed.step(shown), grey(3, 4));
    feed.step(shown + SILENCE - Duration::from_nanos(1));
    assert!(is_open(feed.state()), "each picture restarts the timeout");
    feed.step(shown + SILENCE);
    assert_eq!(lost(&feed).0, "/dev/fake: no picture arrived for 5 s");
    drop(frames);
}

#[test]
fn pictures_that_cannot_be_decoded_are_skipped_with_one_warning() {
    let (mut feed, results) = feed();
    let frames = open_camera(&results);
    until(&mut feed, Duration::ZERO, is_open);
    let mut send = |bytes: Vec<u8>| {
        frames.send(Ok(bytes)).expect("it is open");
        feed.step(Duration::ZERO)
    };
    let warning = Some(FeedEvent::Warn(
        "a picture is left out: only 1 bytes of a picture arrived".to_owned(),
    ));
    assert_eq!(send(vec![1]), warning);
    assert_eq!(send(vec![1]), None);
    assert_eq!(send(vec![5, 6]), grey(5, 6));
    assert_eq!(send(vec![1]), warning);
}
