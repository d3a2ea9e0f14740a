//! Checks of a port before it is opened.

use core::fmt::Display;

use jde_schema::{Modulation, Problems};

use crate::port::Address;

/// Reports an invalid address in `modulation`, and a device file that is missing or may not be opened. It
/// opens nothing. For `Inspect::inspect` of a driver.
pub fn inspect_port<T>(
    modulation: &Modulation<T>,
    address: Result<Address, impl Display>,
    problems: &mut Problems<'_>,
) {
    if let Some(address) = problems.expect(modulation, address)
        && let Err(missing) = address.check_access()
    {
        problems.unavailable(modulation, missing);
    }
}
