//! The schema of these tests: it counts, moves a robot, passes scans on, and does whatever trouble it is told to make.

#![allow(unsafe_code, reason = "trouble is made on purpose")]

use std::hint::black_box;
use std::net::UdpSocket;

use jde_abi::raw;
use jde_schema::prelude::*;

pub(crate) static ODD: raw::Plugin = jde_schema::plugin!("odd", "Makes trouble.", [Odd]);

/// Touches memory that is not its own.
pub(crate) const SEGFAULT: u32 = 1;
/// Gives up.
pub(crate) const ABORT: u32 = 2;
/// Exits with status 3.
pub(crate) const EXIT: u32 = 3;
/// Never returns.
pub(crate) const HANG: u32 = 4;
/// Takes all the memory that it gets.
pub(crate) const EAT: u32 = 5;
/// Panics, which is caught.
pub(crate) const PANIC: u32 = 6;
/// Writes into what it may only read.
pub(crate) const SPOIL: u32 = 7;
/// Makes a socket; `tried` tells whether it could.
pub(crate) const SOCKET: u32 = 8;
/// Writes a file; `tried` tells whether it could.
pub(crate) const WRITE: u32 = 9;

/// Never returns, and is busy with that.
pub(crate) const SPIN: u32 = 10;

/// Counts, drives and makes trouble.
#[derive(Describe)]
#[schema(motor, period = "10ms")]
pub(crate) struct Odd {
    /// What to do wrong in the next iteration.
    #[modulation(default = 0)]
    trouble: Modulation<u32>,
    /// The speed to drive at.
    #[modulation(default = 0.3)]
    speed: Modulation<f64>,
    /// Something large to look at.
    #[import(optional)]
    scan: Import<LaserScan>,
    /// Speeds of the base.
    #[actuator(optional)]
    base: Actuator<Twist>,
    /// Iterations of this instance.
    #[export]
    count: Export<f64>,
    /// The application's time as it sees it, s.
    #[export]
    clock: Export<f64>,
    /// 1 if what was tried could be done, -1 if it could not.
    #[export]
    tried: Export<f64>,
    /// Something large: the scan that came, with the count for the first distance.
    #[export]
    seen: Export<LaserScan>,
    /// A child.
    #[child(group = "base", optional)]
    a: Child,
    /// Another.
    #[child(group = "base", optional)]
    b: Child,
    /// How fast the first is to drive.
    #[modulates(child = "a", name = "speed", optional)]
    speed_of_a: Modulates<f64>,
    iterations: u32,
}

impl Schema for Odd {
    fn check(&mut self, cx: &Context) -> Result<Precondition> {
        Ok((self.speed.get(cx) != 0.0).into())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
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
        seen.ranges.resize(2);
        seen.ranges[0] = count as f32;
        seen.publish();
        self.a.wake(cx);
        self.b.wake(cx);
        self.speed_of_a.set(cx, count);
        let mut twist = Twist::ZERO;
        twist.linear.x = self.speed.get(cx);
        self.base.command(cx, twist);
        if let Some(could) = make(self.trouble.get(cx), scan.as_deref()) {
            self.tried.write(cx, if could { 1.0 } else { -1.0 });
        }
        Ok(())
    }
}

impl Arbitrate for Odd {
    fn arbitrate(&mut self, _: &Context, level: &Level) -> Result<Verdict> {
        let child = if self.iterations.is_multiple_of(2) {
            &self.a
        } else {
            &self.b
        };
        assert!(level.candidate(child).is_some(), "both compete");
        Ok(Verdict::choose(child, format!("turn {}", self.iterations)))
    }
}

/// Makes trouble; answers whether it could, for what may be refused.
fn make(trouble: u32, scan: Option<&LaserScan>) -> Option<bool> {
    match trouble {
        SEGFAULT => {
            // SAFETY: there is none, which is the point: the page at address 8 is nobody's.
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
        EAT => {
            let mut kept = Vec::new();
            loop {
                kept.push(black_box(vec![1_u8; 1 << 20]));
            }
        }
        PANIC => panic!("as it was told"),
        SPOIL => {
            let scan = std::ptr::from_ref(scan.expect("there is a scan"));
            // SAFETY: there is none: what is imported is only for reading, and the system holds the child to it.
            unsafe { black_box(scan.cast_mut().cast::<u8>()).write_volatile(99) };
            None
        }
        SOCKET => Some(UdpSocket::bind("127.0.0.1:0").is_ok()),
        WRITE => Some(std::fs::write(std::env::temp_dir().join("jde-odd-was-here"), "here").is_ok()),
        _ => None,
    }
}
