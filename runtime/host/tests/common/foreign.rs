//! The schemas of the tests in C, `tests/c/fixture.c`, and in C++, `tests/cpp/fixture.cpp`: each call of one runs the
//! scenario's behaviour, whose requests go through the ports in that language.

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
use jde_schema::{NoValue, Outcome, Precondition};

use super::c;
use super::io::{Answer, Call, Caller, Io, Request};
use super::scenario::Scenario;
use super::schemas::{count_live, record_commands};

/// A call of a schema in C or C++, as in `tests/c/fixture.h`.
#[repr(C)]
struct ForeignCall {
    scenario: u32,
    call: Call,
    name: *const c_char,
    group: *const c_char,
    gesture: *const c_char,
    memory: u64,
    /// The commands of a robot at its last iteration, and now.
    commands: [[f64; 2]; 2],
    caller: *mut c_void,
    /// Performs a request; 0 if it throws.
    request: unsafe extern "C" fn(*mut c_void, Request, *const c_char, f64, *mut ForeignAnswer) -> i32,
    ready: u32,
    urgency: f64,
    role: [c_char; 16],
    text: [c_char; 512],
}

#[repr(C)]
#[derive(Default)]
struct ForeignAnswer {
    code: i32,
    number: f64,
    count: u64,
}

/// What the fixture calls in the test.
#[repr(C)]
struct Functions {
    run: unsafe extern "C" fn(*mut ForeignCall) -> i32,
    alive: extern "C" fn(i32),
}

/// The plugin of the tests in C.
pub(super) fn in_c() -> &'static raw::Plugin {
    static PLUGIN: OnceLock<&'static raw::Plugin> = OnceLock::new();
    PLUGIN.get_or_init(|| build("fixture.c", "libfixture-c.so"))
}

/// The plugin of the tests in C++.
pub(super) fn in_cpp() -> &'static raw::Plugin {
    static PLUGIN: OnceLock<&'static raw::Plugin> = OnceLock::new();
    PLUGIN.get_or_init(|| build("../cpp/fixture.cpp", "libfixture-cpp.so"))
}

/// Builds a plugin, once for all tests of a program, and connects it with them.
fn build(source: &str, file: &str) -> &'static raw::Plugin {
    let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join(file);
    c::build(source, &[], &file);
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
}

extern "C" fn alive(change: i32) {
    count_live(i64::from(change));
}

/// Runs the behaviour of a call, and returns its code.
unsafe extern "C" fn run(call: *mut ForeignCall) -> i32 {
    // SAFETY: the fixture lends a call, of which no other reference exists until this function returns.
    let call = unsafe { &mut *call };
    // SAFETY: the fixture's texts, or null.
    let [name, group, gesture] = unsafe { [text_at(call.name), text_at(call.group), text_at(call.gesture)] };
    let made = MadeCall {
        scenario: call.scenario,
        kind: call.call,
        name,
        gesture,
        memory: call.memory,
        commands: call.commands,
    };
    let caller = InC(&raw const *call, group);
    match made.run(&caller) {
        Ok((precondition, role)) => {
            (call.ready, call.urgency) = (u32::from(precondition.ready), precondition.urgency);
            copy(&role, &mut call.role);
            raw::OK
        }
        Err((code, text)) => {
            copy(&text, &mut call.text);
            code
        }
    }
}

/// A call of a schema in another language.
pub(super) struct MadeCall {
    pub(super) scenario: u32,
    pub(super) kind: Call,
    pub(super) name: String,
    pub(super) gesture: String,
    /// Calls of the instance before this one.
    pub(super) memory: u64,
    /// The commands of a robot at its last iteration, and now.
    pub(super) commands: [[f64; 2]; 2],
}

impl MadeCall {
    /// Runs the behaviour. Returns the precondition and the role of the chosen child, or the code and the text of a
    /// failure.
    pub(super) fn run(self, caller: &dyn Caller) -> Result<(Precondition, String), (i32, String)> {
        match catch_unwind(AssertUnwindSafe(|| self.perform(caller))) {
            Ok(Ok(done)) => Ok(done),
            Ok(Err(error)) if error.is::<NoValue>() => Err((raw::NO_VALUE, error.to_string())),
            Ok(Err(error)) => Err((raw::FAILED, error.to_string())),
            Err(payload) => Err((raw::PANICKED, words(&*payload))),
        }
    }

    fn perform(self, caller: &dyn Caller) -> jde_schema::Result<(Precondition, String)> {
        let scenario = Scenario::of(self.scenario);
        if self.kind == Call::Iterate {
            let [before, seen] = self.commands;
            record_commands(&scenario, &self.name, before, seen);
        }
        let caller = (self.kind != Call::Drop).then_some(caller);
        let mut io = Io::new(&scenario, &self.name, self.memory, caller);
        io.gesture = self.gesture;
        io.perform(self.kind)?;
        Ok((io.precondition, io.chosen.unwrap_or_default()))
    }
}

/// A schema in C or C++ in a call, and the group to arbitrate.
struct InC(*const ForeignCall, String);

impl Caller for InC {
    fn request(&self, request: Request, text: &str, number: f64) -> Answer {
        let text = CString::new(text).expect("a text has no NUL");
        let mut answer = ForeignAnswer::default();
        // SAFETY: the fixture's function and its first argument, and texts that live until it returns.
        let done =
            unsafe { ((*self.0).request)((*self.0).caller, request, text.as_ptr(), number, &raw mut answer) };
        assert!(done != 0, "{request:?} threw an exception");
        (outcome(answer.code), answer.number, answer.count)
    }

    fn group(&self) -> String {
        self.1.clone()
    }
}

/// The outcome that a code states.
pub(super) fn outcome(code: i32) -> Outcome {
    match code {
        raw::OK => Outcome::Accepted,
        raw::REFUSED | raw::NO_VALUE => Outcome::Refused,
        raw::NOT_FINITE => Outcome::NotFinite,
        raw::OUT_OF_RANGE => Outcome::OutOfRange,
        raw::UNBOUND => Outcome::Unbound,
        other => panic!("{other} is the code of a mistake of the fixture"),
    }
}

/// # Safety
/// The pointer is null, or that of a text with a NUL.
unsafe fn text_at(text: *const c_char) -> String {
    if text.is_null() {
        return String::new();
    }
    // SAFETY: the caller's promise.
    unsafe { CStr::from_ptr(text) }.to_string_lossy().into_owned()
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
        *to = c_char::from_ne_bytes([byte]);
    }
}
