//! Values of variables, by name.

use std::collections::BTreeMap;
use std::ffi::{c_char, c_void};
use std::sync::Arc;

use jde_abi::describe::Type;
use jde_abi::{raw, read, write};
use jde_board::Stamp;
use jde_board::value::{Value, decode};
use parking_lot::Mutex;

use crate::boundary::{Failure, call, give, give_text, text};
use crate::{handles, tables};

/// Copies the newest value of a variable, such as "pioneer.laser", into `value`, which has the type `type`: a
/// `jde_laser_scan` with `&jde_laser_scan_type`. Elements of sequences beyond their length stay as they are. `sample`
/// may be null, and gets the time and the number of the value. `JDE_NO_VALUE` without one; `JDE_BAD_ARGUMENT` for another
/// type or layout. It does not block, and a value is never torn.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jde_run_read(
    run: *mut tables::Run,
    name: *const c_char,
    value_type: *const raw::Type,
    value: *mut c_void,
    sample: *mut raw::Sample,
) -> i32 {
    call(|| {
        let run = handles::run(run)?;
        // SAFETY: the pointers are those of the header's rules, and `value` has the size of its type.
        unsafe {
            let name = text("name", name)?;
            let bytes = check(name, &run.value_type(name)?, value_type)?.bytes;
            if value.is_null() {
                return Err(Failure::new(raw::BAD_ARGUMENT, "`value` is null"));
            }
            let place = std::slice::from_raw_parts_mut(value.cast(), bytes);
            let stamp = run.read(name, place)?.ok_or_else(|| no_value(name))?;
            if !sample.is_null() {
                sample.write(self::sample(value, bytes, stamp));
            }
            Ok(())
        }
    })
}

/// Returns a number of a variable by its path: "pioneer.odometry.pose.x", "pioneer.laser.ranges[3]". True is 1.
/// `JDE_NO_VALUE` without a value. It does not block.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jde_run_read_number(
    run: *mut tables::Run,
    path: *const c_char,
    number: *mut f64,
) -> i32 {
    call(|| {
        let run = handles::run(run)?;
        // SAFETY: the pointers are those of the header's rules.
        unsafe {
            let path = text("path", path)?;
            let value = run.value(path)?.ok_or_else(|| no_value(path))?.into_only_field();
            let read = match value {
                Value::Bool(value) => Some(f64::from(value)),
                other => other.as_number(),
            };
            let read = read.ok_or_else(|| {
                Failure::new(
                    raw::BAD_ARGUMENT,
                    format!("`{path}` is not one number; name a field"),
                )
            })?;
            give("number", number, read)
        }
    })
}

/// Returns a variable or a part of it as a text; a text as it is, anything else as tools show it. `JDE_NO_VALUE` without a
/// value. It does not block.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jde_run_read_text(
    run: *mut tables::Run,
    path: *const c_char,
    text: *mut *mut c_char,
) -> i32 {
    call(|| {
        let run = handles::run(run)?;
        // SAFETY: the pointers are those of the header's rules.
        unsafe {
            let path = crate::boundary::text("path", path)?;
            match run.value(path)?.ok_or_else(|| no_value(path))?.into_only_field() {
                Value::Text(value) => give_text(text, value),
                other => give_text(text, other.to_string()),
            }
        }
    })
}

/// Returns the description of the type of a variable. It is valid until the process ends.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jde_run_type(
    run: *mut tables::Run,
    name: *const c_char,
    value_type: *mut *const raw::Type,
) -> i32 {
    call(|| {
        let run = handles::run(run)?;
        // SAFETY: the pointers are those of the header's rules.
        unsafe {
            let described = run.value_type(text("name", name)?)?;
            give("type", value_type, table(&described))
        }
    })
}

/// Writes a modulation as an operator (R14), or what a mock exports or commands. The value is copied.
/// `JDE_BAD_ARGUMENT` for another type or layout; `JDE_REFUSED` for a value outside the limits, and after the end. It does
/// not block.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jde_run_write(
    run: *mut tables::Run,
    name: *const c_char,
    value_type: *const raw::Type,
    value: *const c_void,
) -> i32 {
    call(|| {
        let run = handles::run(run)?;
        // SAFETY: the pointers are those of the header's rules, and `value` has the size of its type.
        unsafe {
            let name = text("name", name)?;
            let own = check(name, &run.written_type(name)?, value_type)?;
            if value.is_null() {
                return Err(Failure::new(raw::BAD_ARGUMENT, "`value` is null"));
            }
            let bytes = std::slice::from_raw_parts(value.cast(), own.bytes);
            Ok(run.write(name, decode(&own, bytes))?)
        }
    })
}

/// Writes a modulation, a period ("goon.period", s) or what a mock exports that is one number.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jde_run_write_number(
    run: *mut tables::Run,
    name: *const c_char,
    number: f64,
) -> i32 {
    call(|| {
        let run = handles::run(run)?;
        // SAFETY: a text of the program.
        let name = unsafe { text("name", name) }?;
        Ok(run.write(name, Value::Float(number))?)
    })
}

/// Writes the same from a text, as an application file states it: "30 cm/s", "{ linear = { x = 0.2 } }".
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jde_run_write_text(
    run: *mut tables::Run,
    name: *const c_char,
    value: *const c_char,
) -> i32 {
    call(|| {
        let run = handles::run(run)?;
        // SAFETY: texts of the program.
        let (name, value) = unsafe { (text("name", name)?, text("value", value)?) };
        Ok(run.write(name, Value::Text(value.to_owned()))?)
    })
}

/// Checks that the program and the application mean the same type, and returns it.
unsafe fn check(name: &str, own: &Arc<Type>, table: *const raw::Type) -> Result<Arc<Type>, Failure> {
    if table.is_null() {
        return Err(Failure::new(raw::BAD_ARGUMENT, "`type` is null"));
    }
    // SAFETY: a table of the program, which stays unchanged.
    let given = unsafe { known(table) }?;
    if own.same_as(&given) {
        return Ok(Arc::clone(own));
    }
    let text = match own.difference(&given) {
        Some(difference) if own.name == given.name => {
            format!("`{name}` is a {} of another layout: {difference}", own.name)
        }
        _ => format!("`{name}` is a {}, not a {}", own.name, given.name),
    };
    Err(Failure::new(raw::BAD_ARGUMENT, text))
}

/// Returns the type that a table describes. A table is read once.
unsafe fn known(table: *const raw::Type) -> Result<Arc<Type>, Failure> {
    static KNOWN: Mutex<BTreeMap<usize, Arc<Type>>> = Mutex::new(BTreeMap::new());
    let mut known = KNOWN.lock();
    if let Some(value_type) = known.get(&table.addr()) {
        return Ok(Arc::clone(value_type));
    }
    // SAFETY: the caller's.
    let read = unsafe { read::value_type(table) };
    let value_type = Arc::new(read.map_err(|refusal| Failure::new(raw::BAD_ARGUMENT, refusal.to_string()))?);
    known.insert(table.addr(), Arc::clone(&value_type));
    Ok(value_type)
}

/// Returns the table of a type. Each type has one.
fn table(described: &Type) -> *const raw::Type {
    static WRITTEN: Mutex<BTreeMap<(String, u64), usize>> = Mutex::new(BTreeMap::new());
    let mut written = WRITTEN.lock();
    let number = written
        .entry((described.name.clone(), described.hash()))
        .or_insert_with(|| std::ptr::from_ref(write::value_type(described)).expose_provenance());
    std::ptr::with_exposed_provenance(*number)
}

fn sample(value: *const c_void, bytes: usize, stamp: Stamp) -> raw::Sample {
    raw::Sample {
        data: value,
        bytes: bytes as u64,
        time_ns: stamp.time,
        sequence: stamp.sequence,
        writer: stamp.writer,
        flags: if stamp.writer == Stamp::NO_WRITER {
            raw::SAMPLE_DEFAULT
        } else {
            0
        },
    }
}

fn no_value(name: &str) -> Failure {
    Failure::new(raw::NO_VALUE, format!("`{name}` has no value"))
}
