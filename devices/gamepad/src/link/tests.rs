//! A scripted gamepad: the test decides what each search finds and what each read returns.

use std::collections::VecDeque;
use std::sync::Mutex;

use jde_watchdog::Watchdog;

use super::*;

type Reads = VecDeque<io::Result<Controls>>;

/// A gamepad that repeats its last read, as the kernel does.
struct Scripted(Reads);

impl Source for Scripted {
    fn read(&mut self) -> io::Result<Controls> {
        match self.0.front() {
            Some(Ok(controls)) if self.0.len() == 1 => Ok(controls.clone()),
            Some(_) => self.0.pop_front().expect("it has a front"),
            None => Err(io::Error::other("it was read after it was gone")),
        }
    }
}

fn pressed(axis: f32) -> Controls {
    Controls {
        axes: vec![axis],
        buttons: vec![true],
    }
}

fn pad(name: &str, reads: impl IntoIterator<Item = io::Result<Controls>>) -> Result<Found, String> {
    Ok(Found {
        name: name.to_owned(),
        source: Box::new(Scripted(reads.into_iter().collect())),
    })
}

fn gone() -> io::Result<Controls> {
    Err(io::Error::from_raw_os_error(19))
}

fn link(results: impl IntoIterator<Item = Result<Found, String>>, max_silence: Option<Duration>) -> Link {
    let results = Mutex::new(results.into_iter().collect::<VecDeque<_>>());
    let search = move || {
        let next = results.lock().expect("one at a time").pop_front();
        next.unwrap_or_else(|| Err("no gamepad is connected".to_owned()))
    };
    Link::new(search, max_silence)
}

const fn ms(ms: u64) -> Duration {
    Duration::from_millis(ms)
}

/// Steps at one instant until the search that is under way has ended. Returns what was held meanwhile.
fn finish_search(link: &mut Link, now: Duration) -> Vec<Controls> {
    let _watchdog = Watchdog::for_test();
    let mut held = Vec::new();
    loop {
        held.extend(link.step(now));
        if !matches!(link.state, State::Absent { search: Some(_), .. }) {
            return held;
        }
        thread::yield_now();
    }
}

#[test]
fn it_reads_what_is_held_now_and_an_unchanged_stick_stays_true() {
    let mut link = link([pad("one", [Ok(pressed(0.5)), Ok(pressed(0.7))])], None);
    assert_eq!(link.state(), LinkState::Searching);
    assert_eq!(finish_search(&mut link, ms(0)), [], "a search waits for nobody");
    assert_eq!(link.state(), LinkState::Open("one"));
    assert_eq!(link.step(ms(20)), Some(pressed(0.5)));
    assert_eq!(link.step(ms(40)), Some(pressed(0.7)));
    assert_eq!(link.step(ms(3_600_000)), Some(pressed(0.7)));
}

#[test]
fn a_pad_that_is_unplugged_holds_nothing_from_then_on_and_is_looked_for() {
    let mut link = link(
        [
            pad("one", [Ok(pressed(1.0)), gone()]),
            pad("one", [Ok(pressed(1.0))]),
        ],
        None,
    );
    finish_search(&mut link, ms(0));
    assert!(link.step(ms(20)).is_some());
    assert_eq!(link.step(ms(40)), None, "not the last state");
    let LinkState::Absent(reason) = link.state() else {
        panic!("it is {:?}", link.state());
    };
    assert!(reason.starts_with("one is gone: No such device"), "{reason}");
    assert_eq!(link.step(ms(539)), None);
    assert!(
        matches!(link.state, State::Absent { search: None, .. }),
        "not before half a second"
    );
    assert_eq!(finish_search(&mut link, ms(540)), []);
    assert_eq!(link.step(ms(560)), Some(pressed(1.0)));
}

#[test]
fn a_pad_that_is_absent_keeps_its_reason_while_it_is_looked_for() {
    let mut link = link([Err("2 gamepads could be meant".to_owned())], None);
    finish_search(&mut link, ms(0));
    assert_eq!(link.state(), LinkState::Absent("2 gamepads could be meant"));
    assert_eq!(link.step(ms(500)), None);
    assert_eq!(link.state(), LinkState::Absent("2 gamepads could be meant"));
    finish_search(&mut link, ms(500));
    assert_eq!(
        (link.state(), link.attempts()),
        (LinkState::Absent("no gamepad is connected"), 2)
    );
}

#[test]
fn a_search_that_panics_is_said_and_repeated() {
    let mut link = Link::new(|| panic!("a search that fails, for this test"), None);
    finish_search(&mut link, ms(0));
    assert_eq!(link.state(), LinkState::Absent("the search for a gamepad failed"));
}

#[test]
fn a_pad_that_may_be_out_of_reach_counts_until_its_silence() {
    let reads = [
        Ok(pressed(0.5)),
        Ok(pressed(0.5)),
        Ok(pressed(0.5)),
        Ok(pressed(0.4)),
    ];
    let mut link = link([pad("one", reads)], Some(ms(1000)));
    finish_search(&mut link, ms(0));
    assert!(link.step(ms(20)).is_some());
    assert!(link.step(ms(1019)).is_some());
    assert_eq!(link.step(ms(1020)), None);
    let LinkState::Absent(reason) = link.state() else {
        panic!("it is {:?}", link.state());
    };
    assert!(reason.contains("nothing has changed on one for 1 s"), "{reason}");
    assert_eq!(link.step(ms(1040)), Some(pressed(0.4)));
    assert_eq!(link.state(), LinkState::Open("one"));
}
