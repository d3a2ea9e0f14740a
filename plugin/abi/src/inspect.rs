//! The host's side of the ability to inspect what modulations name: its table, and the list that collects the
//! problems. Calls no schema.

#![allow(unsafe_code)]

use core::ffi::c_char;
use core::{ptr, slice};

use crate::{raw, table};

/// The longest text of a problem, in bytes. The rest is dropped.
const LONGEST: usize = 1000;

/// A problem that an inspection found.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problem {
    /// Whether the schema would start nevertheless, and wait for what is missing.
    pub unavailable: bool,
    /// The port of the modulation, as the plugin states it.
    pub port: u32,
    /// What is wrong and what to do, as the plugin states it.
    pub words: String,
}

/// Returns the table of a schema type's inspection, if it has one.
///
/// # Errors
/// A message that states what is wrong with its table.
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

/// Lends a list of problems to one call. Returns the result of the call, and the problems that it added or
/// the reason why the host refused them.
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
    // SAFETY: the list of `lend`, which nothing else uses until the call to which it was lent has returned.
    let found = unsafe { &mut *found.cast::<Result<Vec<Problem>, String>>() };
    let Ok(problems) = found else {
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
    if problems.len() == raw::PROBLEMS_MOST as usize {
        return raw::BAD_ARGUMENT;
    }
    let length = usize::try_from(length).unwrap_or(LONGEST).min(LONGEST);
    // SAFETY: the plugin guarantees the length, and no more bytes are read.
    let bytes = unsafe { slice::from_raw_parts(text.cast::<u8>(), length) };
    problems.push(Problem {
        unavailable,
        port,
        words: String::from_utf8_lossy(bytes).into_owned(),
    });
    raw::OK
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Adds problems, each given as kind, port and text.
    fn add_all(problems: &[(u32, u32, Option<&str>)]) -> (Vec<i32>, Result<Vec<Problem>, String>) {
        lend(|list| {
            let add = |(kind, port, text): &(u32, u32, Option<&str>)| {
                let (pointer, length) = text.map_or((ptr::null(), 4), |text| (text.as_ptr(), text.len()));
                // SAFETY: the list that was lent, and a text of that length; null is checked.
                unsafe { ((*list).add)((*list).found, *kind, *port, pointer.cast(), length as u64) }
            };
            problems.iter().map(add).collect()
        })
    }

    #[test]
    fn problems_are_kept_in_their_order() {
        let (codes, found) = add_all(&[
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
    fn an_unknown_kind_or_a_null_text_is_refused() {
        let (codes, found) = add_all(&[(7, 0, Some("what")), (raw::PROBLEM_WRONG, 0, Some("late"))]);
        assert_eq!(codes, [raw::BAD_ARGUMENT; 2]);
        assert_eq!(
            found,
            Err(String::from("it reports a problem of the unknown kind 7"))
        );
        let (_, found) = add_all(&[(raw::PROBLEM_WRONG, 0, None)]);
        assert!(found.expect_err("a null text").contains("null"));
    }

    #[test]
    fn long_texts_are_cut_and_problems_beyond_the_limit_are_dropped() {
        let long = "x".repeat(LONGEST + 1);
        let most = raw::PROBLEMS_MOST as usize;
        let (codes, found) = add_all(&vec![(raw::PROBLEM_WRONG, 0, Some(&*long)); most + 1]);
        let found = found.expect("valid problems");
        assert_eq!((found.len(), found[0].words.len()), (most, LONGEST));
        assert_eq!((codes[most - 1], codes[most]), (raw::OK, raw::BAD_ARGUMENT));
    }
}
