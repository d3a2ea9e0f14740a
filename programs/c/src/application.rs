//! Loading and starting applications.

use std::ffi::c_char;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use jde_abi::raw;
use jde_embed::{LoadedApplication, StartOptions};

use crate::boundary::{Failure, call, give, give_text, optional_text, text};
use crate::handles::{self, Object};
use crate::run::nanoseconds;
use crate::{executable, tables};

/// No structure of options will have more bytes: a larger `size` was not set.
const MOST_BYTES: usize = 4096;

/// Loads and checks the application of a file, and loads its plugins. `options` may be null. Blocks while files are read.
/// `JDE_FAILED`: jde_error() lists all faults, each with its file and line.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jde_application_load(
    file: *const c_char,
    options: *const tables::LoadOptions,
    application: *mut *mut tables::Application,
) -> i32 {
    call(|| {
        // SAFETY: the pointers are those of the header's rules.
        unsafe {
            let file = text("file", file)?;
            let (mut overrides, mut mocks, mut executable) = (Vec::new(), Vec::new(), None);
            if let Some(options) = read_options(options)? {
                if options.reserved != 0 {
                    return Err(unknown_option("`reserved`, which must be 0"));
                }
                for value in texts("values", options.values, options.value_count)? {
                    let refused = |error| Failure::new(raw::BAD_ARGUMENT, error);
                    overrides.push(value.parse().map_err(refused)?);
                }
                mocks = texts("mocks", options.mocks, options.mock_count)?;
                executable = optional_text("executable", options.executable)?.map(PathBuf::from);
            }
            let executable = executable.or_else(executable::find);
            let mocks = mocks.into_iter().map(str::to_owned).collect();
            let loaded = LoadedApplication::load(Path::new(file).to_owned(), overrides, mocks, executable)?;
            let handle = handles::open(Object::Application(Arc::new(loaded)));
            give("application", application, handle).inspect_err(|_| handles::close(handle))
        }
    })
}

/// Returns what is absent at present, such as a device that is not plugged in: one per line; an empty text if nothing is.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jde_application_warnings(
    application: *mut tables::Application,
    text: *mut *mut c_char,
) -> i32 {
    call(|| {
        let loaded = handles::application(application)?.application()?;
        let warnings = loaded.concerns.map(|concerns| concerns.to_string());
        // SAFETY: a place for a text.
        unsafe { give_text(text, warnings.unwrap_or_default()) }
    })
}

/// Starts an application at time 0; any number of times, also while earlier runs go on. `options` may be null. Blocks
/// while instances are made. The run needs the handle of the application no more.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jde_application_start(
    application: *mut tables::Application,
    options: *const tables::StartOptions,
    run: *mut *mut tables::Run,
) -> i32 {
    call(|| {
        let application = handles::application(application)?;
        let mut start = StartOptions::default();
        // SAFETY: the pointers are those of the header's rules.
        unsafe {
            if let Some(options) = read_options(options)? {
                let unknown =
                    options.flags & !(tables::LOCKSTEP | tables::WITH_SEED | tables::WITHOUT_RECORDS);
                if unknown != 0 {
                    return Err(unknown_option(&format!("the flags {unknown:#x}")));
                }
                start.lockstep = options.flags & tables::LOCKSTEP != 0;
                start.records = options.flags & tables::WITHOUT_RECORDS == 0;
                start.seed = (options.flags & tables::WITH_SEED != 0).then_some(options.seed);
                start.limit = (options.limit != 0.0)
                    .then(|| nanoseconds(options.limit))
                    .transpose()?;
                start.speed = speed(options.speed)?;
                if let Some(name) = optional_text("name", options.name)? {
                    name.clone_into(&mut start.operator);
                }
            }
            let handle = handles::open(Object::Run(Arc::new(application.start(&start)?)));
            give("run", run, handle).inspect_err(|_| handles::close(handle))
        }
    })
}

/// Closes an application. Its runs go on.
#[unsafe(no_mangle)]
pub extern "C" fn jde_application_close(application: *mut tables::Application) -> i32 {
    call(|| {
        handles::application(application)?;
        handles::close(application);
        Ok(())
    })
}

/// Reads options as far as the program knows them; the rest is zero. What the library does not know must be zero.
unsafe fn read_options<T: Copy>(options: *const T) -> Result<Option<T>, Failure> {
    if options.is_null() {
        return Ok(None);
    }
    let mut read = std::mem::MaybeUninit::<T>::zeroed();
    // SAFETY: options begin with their size, and have as many bytes as they state; zeros are options.
    unsafe {
        let stated = options.cast::<u32>().read() as usize;
        if !(size_of::<u32>() * 2..=MOST_BYTES).contains(&stated) {
            return Err(Failure::new(
                raw::BAD_ARGUMENT,
                format!("options of {stated} bytes are none: set `size` to the size of the structure"),
            ));
        }
        let known = stated.min(size_of::<T>());
        let bytes = options.cast::<u8>();
        if let Some(unknown) = (known..stated).find(|byte| bytes.add(*byte).read() != 0) {
            return Err(unknown_option(&format!("the option at byte {unknown}")));
        }
        std::ptr::copy_nonoverlapping(bytes, read.as_mut_ptr().cast(), known);
        Ok(Some(read.assume_init()))
    }
}

fn unknown_option(what: &str) -> Failure {
    let text = format!("this libjde does not know {what}: use a newer one, or the header of this one");
    Failure::new(raw::BAD_ARGUMENT, text)
}

/// Reads an array of texts.
unsafe fn texts<'t>(what: &str, array: *const *const c_char, count: u32) -> Result<Vec<&'t str>, Failure> {
    if array.is_null() && count > 0 {
        return Err(Failure::new(raw::BAD_ARGUMENT, format!("`{what}` is null")));
    }
    // SAFETY: an array of the program of this length.
    (0..count as usize)
        .map(|index| unsafe { text(what, *array.add(index)) })
        .collect()
}

fn speed(speed: f64) -> Result<f64, Failure> {
    match speed {
        0.0 => Ok(1.0),
        speed if speed.is_finite() && speed > 0.0 => Ok(speed),
        speed => Err(Failure::new(
            raw::BAD_ARGUMENT,
            format!("a speed is above 0, and {speed} is not"),
        )),
    }
}
