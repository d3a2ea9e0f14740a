//! The message, and a pad that the kernel makes (`/dev/uinput`). The states of the connection are tested in `devices/gamepad`.

use std::thread;
use std::time::Instant;

use evdev::uinput::VirtualDevice;
use evdev::{AbsInfo, AbsoluteAxisCode, AttributeSet, EventType, InputEvent, KeyCode, UinputAbsSetup};
use jde_schema::bench::Bench;
use jde_watchdog::Watchdog;

use super::*;

#[test]
fn a_dead_zone_leaves_the_ends_and_has_no_step() {
    for position in [0.0, 0.05, -0.1, 0.1] {
        assert_eq!(without_dead_zone(position, 0.1).abs(), 0.0);
    }
    assert!(without_dead_zone(0.11, 0.1) < 0.02);
    assert!((without_dead_zone(0.55, 0.1) - 0.5).abs() < 1e-6);
    assert_eq!(
        (without_dead_zone(1.0, 0.1), without_dead_zone(-1.0, 0.3)),
        (1.0, -1.0)
    );
    assert_eq!(without_dead_zone(0.05, 0.0), 0.05);
}

#[test]
fn a_message_has_what_fits() {
    let controls = Controls {
        axes: vec![1.0; 40],
        buttons: vec![true; 80],
    };
    let joy = joy(&controls, 0.1, Duration::from_secs(7));
    assert_eq!((joy.axes.len(), joy.buttons.len()), (16, 32));
    assert_eq!((joy.axis(15), joy.is_pressed(31)), (Some(1.0), Some(true)));
    assert_eq!(
        (joy.axis(16), joy.axis(-1), joy.is_pressed(32)),
        (None, None, None)
    );
}

/// A pad of the kernel, with a name that no other device has.
struct VirtualPad(VirtualDevice);

impl VirtualPad {
    fn plug(name: &str) -> std::io::Result<Self> {
        let keys = [KeyCode::BTN_SOUTH, KeyCode::BTN_TL, KeyCode::BTN_TR];
        let mut device = VirtualDevice::builder()?
            .name(name)
            .with_keys(&keys.into_iter().collect::<AttributeSet<_>>())?;
        let range = AbsInfo::new(0, -32768, 32767, 0, 0, 0);
        for axis in [AbsoluteAxisCode::ABS_X, AbsoluteAxisCode::ABS_Y] {
            device = device.with_absolute_axis(&UinputAbsSetup::new(axis, range))?;
        }
        device.build().map(Self)
    }

    fn set(&mut self, button: bool, ahead: i32) {
        let events = [
            InputEvent::new(EventType::KEY.0, KeyCode::BTN_TL.0, button.into()),
            InputEvent::new(EventType::ABSOLUTE.0, AbsoluteAxisCode::ABS_Y.0, -ahead),
        ];
        self.0.emit(&events).expect("the kernel takes events");
    }
}

/// A driver that runs until conditions hold.
struct Running {
    bench: Bench<Gamepad>,
    start: Instant,
}

impl Running {
    fn new(name: &str) -> Self {
        let mut bench = Bench::new();
        bench.set("device_name", Text::<128>::new(name));
        bench.awake().expect("it awakes");
        Self {
            bench,
            start: Instant::now(),
        }
    }

    fn until(&mut self, mut condition: impl FnMut(&Bench<Gamepad>) -> bool) {
        while !condition(&self.bench) {
            self.bench.set_now(self.start.elapsed());
            self.bench.iterate().expect("an iteration does not fail");
            thread::yield_now();
        }
    }
}

fn connection(bench: &Bench<Gamepad>) -> Connection {
    bench.exported("connection").unwrap_or_default()
}

fn held(bench: &Bench<Gamepad>) -> Option<(bool, f64)> {
    let joy = bench.exported::<Joy>("joy")?;
    Some((joy.is_pressed(9)?, joy.axis(1)?))
}

#[test]
fn a_named_pad_that_is_not_there_is_said_and_has_no_value() {
    let _watchdog = Watchdog::for_test();
    let mut running = Running::new("no such pad");
    running.until(|bench| connection(bench).state == Connection::LOST);
    assert_eq!(held(&running.bench), None);
    running.bench.sleep().expect("it sleeps");
    assert!(running.bench.exported::<Connection>("connection").is_none());
}

#[test]
fn a_pad_of_the_kernel_is_read_unplugged_and_found_again() {
    let _watchdog = Watchdog::for_test();
    let name = format!("jde test pad {}", std::process::id());
    let mut pad = match VirtualPad::plug(&name) {
        Ok(pad) => pad,
        Err(error) => {
            eprintln!("not run: /dev/uinput makes no virtual pad here: {error}");
            return;
        }
    };
    let mut running = Running::new(&name);
    running.until(|bench| held(bench) == Some((false, 0.0)));
    assert!(connection(&running.bench).note.as_str().starts_with(&name));
    pad.set(true, 32768);
    running.until(|bench| held(bench) == Some((true, 1.0)));
    pad.set(true, 1000);
    running.until(|bench| held(bench) == Some((true, 0.0)));
    pad.set(true, 32768);
    running.until(|bench| held(bench) == Some((true, 1.0)));

    drop(pad);
    running.until(|bench| held(bench).is_none());
    running.until(|bench| connection(bench).state == Connection::LOST);
    let mut second = VirtualPad::plug(&name).expect("it was possible before");
    running.until(|bench| held(bench) == Some((false, 0.0)));
    second.set(true, -32767);
    running.until(|bench| held(bench) == Some((true, -1.0)));

    // Another one of the same name: the one that is taken stays, and a new search takes none of two.
    let _third = VirtualPad::plug(&name).expect("it was possible before");
    let mut other = Running::new(&name);
    other.until(|bench| connection(bench).state == Connection::LOST);
    assert!(
        connection(&other.bench)
            .note
            .as_str()
            .starts_with("2 gamepads could be meant")
    );
    assert_eq!(
        (held(&other.bench), held(&running.bench)),
        (None, Some((true, -1.0)))
    );
}
