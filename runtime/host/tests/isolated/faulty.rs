//! The schema of these tests. It counts, drives a robot, copies scans, and misbehaves on request.

#![allow(unsafe_code, reason = "the schema misbehaves on request")]

use std::hint::black_box;
use std::net::UdpSocket;

use jde_abi::raw;
use jde_schema::prelude::*;

pub(crate) static FAULTY: raw::Plugin = jde_schema::plugin!("faulty", "Misbehaves on request.", [Faulty]);

/// Writes to an unmapped address.
pub(crate) const SEGFAULT: u32 = 1;
/// Aborts.
pub(crate) const ABORT: u32 = 2;
/// Exits with status 3.
pub(crate) const EXIT: u32 = 3;
/// Blocks forever without using the processor.
pub(crate) const HANG: u32 = 4;
/// Allocates until no memory is left.
pub(crate) const ALLOCATE: u32 = 5;
/// Panics; the panic is caught.
pub(crate) const PANIC: u32 = 6;
/// Writes to an import, which is read-only memory.
pub(crate) const WRITE_IMPORT: u32 = 7;
/// Opens a socket; `tried` reports whether that succeeded.
pub(crate) const SOCKET: u32 = 8;
/// Writes a file; `tried` reports whether that succeeded.
pub(crate) const WRITE: u32 = 9;

/// Loops forever and uses the processor.
pub(crate) const SPIN: u32 = 10;
/// Commands until a command is refused; `tried` is 1 meanwhile and then -1.
pub(crate) const COMMAND: u32 = 11;

/// Says in an iteration that its import has no value, if it has none (R19).
pub(crate) const LACK: u32 = 12;
/// Says so in a check.
pub(crate) const LACK_IN_CHECK: u32 = 13;

/// Counts, drives and misbehaves on request.
#[derive(Describe)]
#[schema(motor, period = "10ms")]
pub(crate) struct Faulty {
    /// The misbehaviour of the next iteration; 0 for none.
    #[modulation(default = 0)]
    trouble: Modulation<u32>,
    /// The speed to drive at.
    #[modulation(default = 0.3)]
    speed: Modulation<f64>,
    /// A large value to read.
    #[import(optional)]
    scan: Import<LaserScan>,
    /// Speeds of the base.
    #[actuator(optional)]
    base: Actuator<Twist>,
    /// Iterations of this instance.
    #[export]
    count: Export<f64>,
    /// The application's time as this process reads it, s.
    #[export]
    clock: Export<f64>,
    /// 1 if the last attempt succeeded, -1 if it was refused.
    #[export]
    tried: Export<f64>,
    /// A large value: the imported scan, with `count` as its first distance.
    #[export]
    seen: Export<LaserScan>,
    /// A child.
    #[child(group = "base", optional)]
    a: Child,
    /// Another child.
    #[child(group = "base", optional)]
    b: Child,
    /// The speed of the first child.
    #[modulates(child = "a", name = "speed", optional)]
    speed_of_a: Modulates<f64>,
    iterations: u32,
}

impl Schema for Faulty {
    fn check(&mut self, cx: &Context) -> Result<Precondition> {
        if self.trouble.get(cx) == LACK_IN_CHECK {
            self.scan.require(cx)?;
        }
        Ok((self.speed.get(cx) != 0.0).into())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        if self.trouble.get(cx) == LACK {
            self.scan.require(cx)?;
        }
        self.iterations += 1;
        let count = f64::from(self.iterations);
        self.count.write(cx, count);
        self.clock.write(cx, cx.now().as_secs_f64());
        let scan = self.scan.get(cx);
        let mut seen = self.seen.loan(cx);
        match &scan {
            Some(scan) => *seen = **scan,
            None => *seen = LaserScan::default(),
        }
        (seen.angle_max, seen.angle_increment, seen.range_max) = (1.0, 1.0, f32::MAX);
        seen.ranges.resize(2);
        seen.ranges[0] = count as f32;
        seen.publish();
        self.a.wake(cx);
        self.b.wake(cx);
        self.speed_of_a.set(cx, count);
        let mut twist = Twist::ZERO;
        twist.linear.x = self.speed.get(cx);
        let mut outcome = self.base.command(cx, twist);
        if self.trouble.get(cx) == COMMAND {
            self.tried.write(cx, 1.0);
            while outcome.accepted() {
                outcome = self.base.command(cx, twist);
            }
            self.tried.write(cx, -1.0);
        }
        if let Some(succeeded) = misbehave(self.trouble.get(cx), scan.as_deref()) {
            self.tried.write(cx, if succeeded { 1.0 } else { -1.0 });
        }
        Ok(())
    }
}

impl Arbitrate for Faulty {
    fn arbitrate(&mut self, _: &Context, level: &Level) -> Result<Verdict> {
        let child = if self.iterations.is_multiple_of(2) {
            &self.a
        } else {
            &self.b
        };
        assert!(level.candidate(child).is_some(), "both children compete");
        Ok(Verdict::choose(child, format!("turn {}", self.iterations)))
    }
}

/// Misbehaves. Returns whether an attempt that may be refused succeeded; `None` for other misbehaviour.
fn misbehave(trouble: u32, scan: Option<&LaserScan>) -> Option<bool> {
    match trouble {
        SEGFAULT => {
            // SAFETY: deliberately unsound. The page at address 8 is not mapped.
            unsafe { black_box(std::ptr::without_provenance_mut::<u64>(8)).write_volatile(1) };
            None
        }
        ABORT => std::process::abort(),
        EXIT => std::process::exit(3),
        HANG => loop {
            std::thread::park();
        },
        SPIN => loop {
            black_box(0);
        },
        ALLOCATE => {
            let mut kept = Vec::new();
            loop {
                kept.push(black_box(vec![1_u8; 1 << 20]));
            }
        }
        PANIC => panic!("the requested panic"),
        WRITE_IMPORT => {
            let scan = std::ptr::from_ref(scan.expect("there is a scan"));
            // SAFETY: deliberately unsound. Imports are read-only, and the child's memory protection enforces
            // that.
            unsafe { black_box(scan.cast_mut().cast::<u8>()).write_volatile(99) };
            None
        }
        SOCKET => Some(UdpSocket::bind("127.0.0.1:0").is_ok()),
        WRITE => Some(std::fs::write(std::env::temp_dir().join("jde-faulty-was-here"), "written").is_ok()),
        _ => None,
    }
}
