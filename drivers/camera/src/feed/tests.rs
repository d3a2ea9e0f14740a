//! A fake camera made of channels: the test opens it, gives it pictures, and removes it.

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
        let found = self
            .attempts
            .lock()
            .expect("one at a time")
            .recv()
            .expect("the test says what is found");
        found.map(|stream| Box::new(stream) as Box<dyn Stream>)
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
        let mut came = false;
        while let Ok(frame) = self.frames.try_recv() {
            *into = frame?;
            came = true;
        }
        Ok(came)
    }
}

type Finds = Sender<Result<FakeStream, String>>;

fn feed() -> (Feed, Finds) {
    let (finds, attempts) = mpsc::channel();
    (
        Feed::new(
            Fake {
                attempts: Mutex::new(attempts),
            },
            Backoff::default(),
        ),
        finds,
    )
}

/// Makes the next attempt succeed, and returns the sender of its pictures.
fn found(finds: &Finds) -> Sender<Result<Vec<u8>, String>> {
    let (frames, stream) = mpsc::channel();
    finds
        .send(Ok(FakeStream { frames: stream }))
        .expect("somebody opens");
    frames
}

fn until(feed: &mut Feed, now: Duration, good: fn(&State) -> bool) {
    let _watchdog = Watchdog::for_test();
    while !good(feed.state()) {
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
        State::Lost {
            reason,
            retry_at: again,
        } => (reason, *again),
        State::Idle | State::Opening(_) | State::Open { .. } => panic!("it is not lost"),
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
fn the_newest_picture_is_shown_and_each_once() {
    let (mut feed, finds) = feed();
    let frames = found(&finds);
    until(&mut feed, Duration::ZERO, is_open);
    assert_eq!(feed.step(Duration::ZERO), None);
    frames.send(Ok(vec![1, 2])).expect("it is open");
    frames.send(Ok(vec![3, 4])).expect("it is open");
    assert_eq!(feed.step(Duration::ZERO), grey(3, 4));
    assert_eq!(feed.step(Duration::ZERO), None);
}

#[test]
fn opening_keeps_nobody_waiting() {
    let (mut feed, finds) = feed();
    for second in 0..100 {
        assert_eq!(feed.step(Duration::from_secs(second)), None);
    }
    assert!(
        matches!(feed.state(), State::Opening(_)),
        "the camera has not answered yet"
    );
    assert_eq!(feed.attempts(), 1, "and nobody else was sent");
    let _frames = found(&finds);
    until(&mut feed, Duration::from_secs(100), is_open);
}

#[test]
fn a_camera_that_is_not_there_is_looked_for_ever_more_rarely() {
    let (mut feed, finds) = feed();
    let (mut now, mut waits) = (Duration::ZERO, Vec::new());
    for _ in 0..6 {
        finds
            .send(Err("/dev/fake: it is not there".to_owned()))
            .expect("somebody opens");
        until(&mut feed, now, is_lost);
        let (reason, again) = lost(&feed);
        assert_eq!(reason, "/dev/fake: it is not there");
        waits.push((again - now).as_millis());
        feed.step(again - Duration::from_nanos(1));
        assert!(is_lost(feed.state()), "not before its time");
        now = again;
        feed.step(now);
    }
    assert_eq!(waits, [250, 500, 1000, 2000, 4000, 4000]);
}

#[test]
fn a_camera_that_is_unplugged_or_silent_is_lost_and_met_again() {
    let (mut feed, finds) = feed();
    let frames = found(&finds);
    until(&mut feed, Duration::ZERO, is_open);
    frames.send(Ok(vec![1, 2])).expect("it is open");
    assert_eq!(feed.step(Duration::ZERO), grey(1, 2));
    frames.send(Err("it is gone".to_owned())).expect("it is open");
    assert_eq!(feed.step(Duration::ZERO), None);
    let (reason, again) = lost(&feed);
    assert_eq!(reason, "/dev/fake: it is gone");

    let frames = found(&finds);
    feed.step(again);
    until(&mut feed, again, is_open);
    let shown = again + SILENCE - Duration::from_nanos(1);
    frames.send(Ok(vec![3, 4])).expect("it is open");
    assert_eq!(feed.step(shown), grey(3, 4));
    feed.step(shown + SILENCE - Duration::from_nanos(1));
    assert!(is_open(feed.state()), "each picture begins the wait anew");
    feed.step(shown + SILENCE);
    assert_eq!(lost(&feed).0, "/dev/fake: no picture came for 5 s");
    drop(frames);
}

#[test]
fn pictures_that_cannot_be_read_are_left_out_and_told_once() {
    let (mut feed, finds) = feed();
    let frames = found(&finds);
    until(&mut feed, Duration::ZERO, is_open);
    let mut send = |bytes: Vec<u8>| {
        frames.send(Ok(bytes)).expect("it is open");
        feed.step(Duration::ZERO)
    };
    let warning = Some(FeedEvent::Warn(
        "a picture is left out: only 1 bytes of a picture came".to_owned(),
    ));
    assert_eq!(send(vec![1]), warning);
    assert_eq!(send(vec![1]), None);
    assert_eq!(send(vec![5, 6]), grey(5, 6));
    assert_eq!(send(vec![1]), warning);
}
