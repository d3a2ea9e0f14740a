//! The limit of open files. Most systems permit a thousand to a program that does not ask for more.

use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};

/// The most that is asked for: some programs look at each descriptor that they might have, and children inherit the limit.
const MAX_DESCRIPTORS: u64 = 1 << 16;

/// Raises the soft limit towards the hard one. The system may refuse it; then the limit stays.
pub(crate) fn raise_limit() {
    let limit = getrlimit(Resource::Nofile);
    let most = limit
        .maximum
        .map_or(MAX_DESCRIPTORS, |hard| hard.min(MAX_DESCRIPTORS));
    if limit.current.is_some_and(|soft| soft < most) {
        let current = Some(most);
        let _ = setrlimit(Resource::Nofile, Rlimit { current, ..limit });
    }
}
