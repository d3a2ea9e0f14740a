//! No public authorities. Zenoh believes those that browsers believe, beside the one it is given, and has no setting against it: whoever
//! has a certificate of theirs, for whatever name, would prove himself by it to whom he is found by multicast. This takes the place of
//! their list, so that a connection proves what the application file or the key names, or nothing. It verifies nothing itself.

use pki_types::TrustAnchor;

/// The public authorities that are believed: none.
pub const TLS_SERVER_ROOTS: &[TrustAnchor<'static>] = &[];
