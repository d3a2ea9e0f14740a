//! The schemas of the tests in C++, `tests/cpp/fixture.cpp`: each call of one runs the scenario's behaviour, whose requests go
//! through the ports in C++.

#![allow(
    unsafe_code,
    reason = "the tables of a plugin and of its calls are in C layout"
)]

use std::any::Any;
use std::ffi::{CStr, CString, c_char, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::OnceLock;

use jde_abi::raw;
use jde_schema::prelude::*;

use super::c;
use super::io::{Answer, Call, Caller, Io, Request};
use super::scenario::Scenario;
use super::schemas::{count_live, record_commands};

/// A call of a schema in C++.
#[repr(C)]
struct ForeignCall {
    scenario: u32,
    call: Call,
    name: *const c_char,
    group: *const c_char,
    memory: u64,
    /// The commands of a robot at its last iteration, and now.
    commands: [[f64; 2]; 2],
    caller: *mut c_void,
    /// Performs a request; false if it throws.
    request: unsafe extern "C" fn(*mut c_void, Request, *const c_char, f64, *mut ForeignAnswer) -> bool,
    ready: u32,
    urgency: f64,
    role: [c_char; 16],
    text: [c_char; 512],
}

#[repr(C)]
#[derive(Default)]
struct ForeignAnswer {
    outcome: u32,
    number: f64,
    count: u64,
}

/// What the fixture calls in the test.
#[repr(C)]
struct Functions {
    run: unsafe extern "C" fn(*mut ForeignCall) -> i32,
    alive: extern "C" fn(i32),
}

/// The plugin of the tests in C++, built once for all tests of a program.
pub(super) fn plugin() -> &'static raw::Plugin {
    static PLUGIN: OnceLock<&'static raw::Plugin> = OnceLock::new();
    PLUGIN.get_or_init(|| {
        let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join("libfixture.so");
        c::build("../cpp/fixture.cpp", &[], &file);
        // SAFETY: a library of ours, without constructors. It stays loaded.
        let library = Box::leak(Box::new(
            unsafe { libloading::Library::new(file) }.expect("it loads"),
        ));
        // SAFETY: the symbols have these types.
        unsafe {
            let connect = library.get::<unsafe extern "C" fn(Functions)>(b"fixture_connect");
            connect.expect("the fixture exports it")(Functions { run, alive });
            let plugin = library.get::<*const raw::Plugin>(raw::ENTRY_SYMBOL);
            let address = plugin
                .expect("it is a plugin")
                .try_as_raw_ptr()
                .expect("an address");
            &*address.cast_const().cast()
        }
    })
}

extern "C" fn alive(change: i32) {
    count_live(i64::from(change));
}

/// Runs the behaviour of a call. Returns 0, 1 for an error and 2 for a panic.
unsafe extern "C" fn run(call: *mut ForeignCall) -> i32 {
    // SAFETY: the fixture lends a call, of which no other reference exists until this function returns.
    let call = unsafe { &mut *call };
    let behaviour = AssertUnwindSafe(|| perform(call));
    let (code, text) = match catch_unwind(behaviour) {
        Ok(Ok(())) => return 0,
        Ok(Err(error)) => (1, error.to_string()),
        Err(payload) => (2, words(&*payload)),
    };
    copy(&text, &mut call.text);
    code
}

fn perform(call: &mut ForeignCall) -> Result {
    // SAFETY: the fixture's texts.
    let name = unsafe { CStr::from_ptr(call.name) }
        .to_string_lossy()
        .into_owned();
    let scenario = Scenario::of(call.scenario);
    if call.call == Call::Iterate {
        let [before, seen] = call.commands;
        record_commands(&scenario, &name, before, seen);
    }
    let caller = InCpp(&raw const *call);
    let caller = (call.call != Call::Drop).then_some(&caller as &dyn Caller);
    if call.call == Call::Drop {
        scenario.record(|| format!("{name} drop"));
    }
    let mut io = Io::new(&scenario, &name, call.memory, caller);
    io.perform(call.call)?;
    let (precondition, chosen) = (io.precondition, io.chosen.unwrap_or_default());
    (call.ready, call.urgency) = (u32::from(precondition.ready), precondition.urgency);
    copy(&chosen, &mut call.role);
    Ok(())
}

/// A schema in C++ in a call.
struct InCpp(*const ForeignCall);

impl Caller for InCpp {
    fn request(&self, request: Request, role: &str, number: f64) -> Answer {
        let role = CString::new(role).expect("a role has no NUL");
        let mut answer = ForeignAnswer::default();
        // SAFETY: the fixture's function and its first argument, and texts that live until it returns.
        let done =
            unsafe { ((*self.0).request)((*self.0).caller, request, role.as_ptr(), number, &raw mut answer) };
        assert!(done, "{request:?} threw an exception");
        let outcomes = [
            Outcome::Accepted,
            Outcome::Refused,
            Outcome::NotFinite,
            Outcome::OutOfRange,
            Outcome::Unbound,
        ];
        (outcomes[answer.outcome as usize], answer.number, answer.count)
    }

    fn group(&self) -> String {
        // SAFETY: the fixture's text.
        unsafe { CStr::from_ptr((*self.0).group) }
            .to_string_lossy()
            .into_owned()
    }
}

fn words(payload: &dyn Any) -> String {
    let text = payload.downcast_ref::<&str>().map(|text| (*text).to_owned());
    let text = text.or_else(|| payload.downcast_ref::<String>().cloned());
    text.unwrap_or_default()
}

/// Copies a text, cut if it is long, and a NUL.
fn copy(text: &str, to: &mut [c_char]) {
    let cut = text.floor_char_boundary(to.len() - 1);
    for (to, byte) in to.iter_mut().zip(text[..cut].bytes().chain([0])) {
        *to = byte.cast_signed();
    }
}
