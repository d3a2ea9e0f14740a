//! Own advice in place of clap's for words that many people try: a recording where a verb needs an application, and
//! verbs of other programs. Refuses nothing itself.

use clap::builder::StyledStr;
use clap::error::{ContextKind, ContextValue};

/// The advice for a recording that is given to a verb for running applications.
const RECORDING: &str =
    "get, ps, vars, events and why ask a recording; for others, run jde replay FILE, then jde watch";
/// The advice for a verb `version`.
const VERSION: &str = "jde --version prints the version";

/// Replaces clap's advice in an error where this module has a better one.
pub(super) fn advise(error: &mut clap::Error) {
    let given = |kind: ContextKind| match error.get(kind) {
        Some(ContextValue::String(given)) => given.as_str(),
        Some(_) | None => "",
    };
    let advice = if given(ContextKind::InvalidArg) == "--in" {
        RECORDING
    } else if given(ContextKind::InvalidSubcommand) == "version" {
        VERSION
    } else {
        return;
    };
    error.remove(ContextKind::SuggestedArg);
    error.remove(ContextKind::SuggestedSubcommand);
    error.insert(
        ContextKind::Suggested,
        ContextValue::StyledStrs(vec![StyledStr::from(advice)]),
    );
}
