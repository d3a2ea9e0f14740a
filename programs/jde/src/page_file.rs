//! The settings of a page for browsers, of `[web]` or of a file of the same keys, as the page's process takes them.

use std::path::Path;

use jde_app::{Web, link::Access};
use jde_web::{Identity, Right, Settings};

use crate::failure::Failure;

/// Reads the settings of a page; without a file those for this machine alone.
///
/// # Errors
/// All faults of the file, as one that would let others read along.
pub(crate) fn read(file: Option<&Path>) -> Result<Settings, Failure> {
    let web = file.map(Web::read_file).transpose().map_err(Failure::faults)?;
    Ok(settings(web.unwrap_or_default()))
}

/// Returns the settings that an application or a file states.
pub(crate) fn settings(web: Web) -> Settings {
    Settings {
        listen: web.listen,
        hosts: web.hosts,
        origins: web.origins,
        access: match web.access {
            Access::Operate => Right::Operate,
            Access::Read => Right::Read,
        },
        tls: web.tls.map(|tls| Identity {
            certificate: tls.certificate,
            key: tls.key,
        }),
    }
}
