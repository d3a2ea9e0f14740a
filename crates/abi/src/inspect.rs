//! The host's end of the ability to inspect what modulations name: its table, and a list of problems to lend to it. Calls no schema.

#![allow(unsafe_code)]

use core::ffi::c_char;
use core::{ptr, slice};

use crate::{raw, table};

/// Longest text of a problem that is kept, in bytes.
const LONGEST: usize = 1000;

/// What an inspection found.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problem {
    /// The schema would start all the same, and wait for what is missing.
    pub unavailable: bool,
    /// The port of the modulation, as the plugin says.
    pub port: u32,
    /// What is wrong and what to do, as the plugin says.
    pub words: String,
}

/// How a type of schema inspects what its modulations name.
///
/// # Errors
/// What is wrong with its table, in words.
///
/// # Safety
/// `schema` follows the rules of [`raw`].
pub unsafe fn of(schema: &raw::Schema) -> Result<Option<raw::Inspect>, String> {
    // SAFETY: the caller's.
    let inspect = unsafe { table::ability::<raw::Inspect>(schema, raw::ABILITY_INSPECT) };
    match inspect.map_err(|unreadable| unreadable.to_string())? {
        Some(raw::Inspect { inspect: None, .. }) => Err(String::from("its `inspect` is null")),
        inspect => Ok(inspect),
    }
}

/// Lends a list of problems for one call; answers with what the call did, and with what was added by it.
///
/// # Errors
/// The second is what the host could not take, in words.
pub fn lend<R>(inspect: impl FnOnce(*const raw::Problems) -> R) -> (R, Result<Vec<Problem>, String>) {
    let mut found: Result<Vec<Problem>, String> = Ok(Vec::new());
    let problems = raw::Problems {
        size: size_of::<raw::Problems>() as u32,
        reserved: 0,
        found: ptr::from_mut(&mut found).cast(),
        add,
    };
    let result = inspect(&raw const problems);
    (result, found)
}

unsafe extern "C" fn add(
    found: *mut raw::Found,
    kind: u32,
    port: u32,
    text: *const c_char,
    length: u64,
) -> i32 {
    // SAFETY: what `lend` put there, which nothing else uses until the call for which it was lent has returned.
    let found = unsafe { &mut *found.cast::<Result<Vec<Problem>, String>>() };
    let Ok(before) = found else {
        return raw::BAD_ARGUMENT;
    };
    let unavailable = match kind {
        raw::PROBLEM_WRONG => false,
        raw::PROBLEM_UNAVAILABLE => true,
        _ => {
            *found = Err(format!("it reports a problem of the unknown kind {kind}"));
            return raw::BAD_ARGUMENT;
        }
    };
    if text.is_null() {
        *found = Err(String::from("it reports a problem whose text is null"));
        return raw::BAD_ARGUMENT;
    }
    if before.len() == raw::PROBLEMS_MOST as usize {
        return raw::BAD_ARGUMENT;
    }
    let length = usize::try_from(length).unwrap_or(LONGEST).min(LONGEST);
    // SAFETY: the plugin vouches for the length, and no more of it is read.
    let bytes = unsafe { slice::from_raw_parts(text.cast::<u8>(), length) };
    before.push(Problem {
        unavailable,
        port,
        words: String::from_utf8_lossy(bytes).into_owned(),
    });
    raw::OK
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Adds each, as kind, port and text.
    fn added(each: &[(u32, u32, Option<&str>)]) -> (Vec<i32>, Result<Vec<Problem>, String>) {
        lend(|problems| {
            let add = |(kind, port, text): &(u32, u32, Option<&str>)| {
                let (at, length) = text.map_or((ptr::null(), 4), |text| (text.as_ptr(), text.len()));
                // SAFETY: the list that was lent, and a text of that length; null is looked at.
                unsafe { ((*problems).add)((*problems).found, *kind, *port, at.cast(), length as u64) }
            };
            each.iter().map(add).collect()
        })
    }

    #[test]
    fn problems_are_kept_in_their_order() {
        let (codes, found) = added(&[
            (raw::PROBLEM_WRONG, 3, Some("no file")),
            (raw::PROBLEM_UNAVAILABLE, 1, Some("no line")),
        ]);
        assert_eq!(codes, [raw::OK; 2]);
        let problem = |unavailable, port, words: &str| Problem {
            unavailable,
            port,
            words: words.to_owned(),
        };
        assert_eq!(
            found,
            Ok(vec![problem(false, 3, "no file"), problem(true, 1, "no line")])
        );
    }

    #[test]
    fn garbage_is_refused_in_words() {
        let (codes, found) = added(&[(7, 0, Some("what")), (raw::PROBLEM_WRONG, 0, Some("late"))]);
        assert_eq!(codes, [raw::BAD_ARGUMENT; 2]);
        assert_eq!(
            found,
            Err(String::from("it reports a problem of the unknown kind 7"))
        );
        let (_, found) = added(&[(raw::PROBLEM_WRONG, 0, None)]);
        assert!(found.expect_err("a null text").contains("null"));
    }

    #[test]
    fn what_is_too_long_is_cut_and_what_is_too_much_is_left_out() {
        let long = "x".repeat(LONGEST + 1);
        let most = raw::PROBLEMS_MOST as usize;
        let (codes, found) = added(&vec![(raw::PROBLEM_WRONG, 0, Some(&*long)); most + 1]);
        let found = found.expect("they are problems");
        assert_eq!((found.len(), found[0].words.len()), (most, LONGEST));
        assert_eq!((codes[most - 1], codes[most]), (raw::OK, raw::BAD_ARGUMENT));
    }
}
